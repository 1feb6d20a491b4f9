"""Values at which programs break: of the kinds that a message or a file may hold, and about the ends of a range."""

import math
import random
import sys
from typing import Any

from carom.dsp.numerics.quantities import Ranged

NUMBERS = (
    0, -0.0, 1, -1, 0.5, 5e-324, -5e-324, 2.2e-308, 1e-308, 1e-300, 1e-30, -1e-30, 1e-12, 1e12, 1e30, 1e300,
    sys.float_info.max, -sys.float_info.max, math.inf, -math.inf, math.nan, 2**31 - 1, -(2**31), 2**63 - 1, -(2**63),
    2**64, 10**30, 10**400,
)  # fmt: skip
OTHERS: tuple[Any, ...] = (
    "", "a", "none", "0", "nan", "1e999", "x" * 10_000, "\0", "é\ud800", "../../etc", "[1 2", "a b", True, False, None,
    b"", b"\xff" * 100, (), (1.0,), (math.nan,) * 3, (0.0,) * 3, ("a", 1), ((((((1,),),),),),), (1e-320,) * 100,
)  # fmt: skip


def any_value(chance: random.Random) -> Any:
    """Return a number or something else."""
    return chance.choice(NUMBERS if chance.random() < 0.7 else OTHERS)


def edge(chance: random.Random, within: Ranged, whole: bool = False, inside: bool = False) -> float:
    """Return a number at or near an end of a range, or just outside of it unless that is said."""
    low, high = within.low, within.high
    near = [low, high, *([0.0] if low <= 0.0 <= high or within.or_zero else [])]
    if whole:
        return int(chance.choice(near if inside else (*near, low - 1, high + 1)))
    near += [math.nextafter(low, high), math.nextafter(high, low)]
    if low > 0.0:
        near += [low * 10, high / 10, math.sqrt(low * high)]
    else:
        near += [each for each in (5e-324, 1e-300, within.least, within.least / 2) if each <= high]
    if not inside:
        near += [math.nextafter(low, -math.inf), math.nextafter(high, math.inf), 5e-324, -5e-324, 1e-308]
    return float(chance.choice(near))
