"""The engine's callback, as Python reaches it: by its machine code, without what that was compiled from.

All that the callback is made of is imported where it has to be compiled, and only there.
"""

import ctypes
from collections.abc import Callable
from functools import cached_property
from typing import Any

from ..native.code import Code, load
from .signature import SIGNATURE

MODULE = f"{__package__}.callback"


class _Callback:
    """The callback, which computes a block."""

    @property
    def code(self) -> Code:
        """The machine code that it is a part of."""
        return load(MODULE)

    @property
    def address(self) -> int:
        return self.code.addresses["callback"]

    @cached_property
    def compute(self) -> Callable[..., Any]:
        """The callback as ctypes has it, without the GIL."""
        return ctypes.CFUNCTYPE(*SIGNATURE)(self.address)


callback = _Callback()
