"""Memory that is given back once nobody needs it: what was kept, and what the C library holds for later."""

import ctypes
from contextlib import suppress

from ..dsp.kept import SECONDS, forget

PERIOD = SECONDS + 5.0
"""s after which something that was made is no longer kept, if nobody requested it."""


def tidy() -> None:
    """Give memory back; any thread may."""
    forget()
    with suppress(AttributeError, OSError, TypeError):  # other libraries than GNU's have no such function
        ctypes.CDLL(None).malloc_trim(0)
