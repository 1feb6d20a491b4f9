"""The longest duration of a contact, estimated by a formula that Python can run as it is."""

import math

from ..native.jit import kernel
from .law import ELASTIC_TIME

LONGEST_CONTACT = 1.0
"""s: a striker so soft or heavy that it would stay longer is refused."""


@kernel
def longest_estimate(v_in: float, m: float, k: float, a: float, w: float) -> float:
    """Return an upper estimate (s) of `contact_time_bound`, with one of the depth; w: mu v_in, at least."""
    length: float = (m * v_in * v_in / k) ** (1.0 / (a + 1.0))
    deepest: float = ((a + 1.0) * min(0.5, 1.0 / w if w > 0.0 else math.inf)) ** (1.0 / (a + 1.0))
    return length / v_in * (ELASTIC_TIME + w * deepest)
