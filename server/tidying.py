"""Memory that is given back once nobody needs it: modes that were kept, and what the C library holds for later."""

import ctypes
from contextlib import suppress

from ..dsp.kept import SECONDS
from ..dsp.runtime.plan import forget_plans
from ..presets.making import forget

PERIOD = SECONDS + 5.0
"""s after which something that was made is no longer kept, if nobody asked for it."""


def tidy() -> None:
    """Give memory back; any thread may."""
    forget()
    forget_plans()
    with suppress(AttributeError, OSError, TypeError):  # other libraries than GNU's have no such function
        ctypes.CDLL(None).malloc_trim(0)
