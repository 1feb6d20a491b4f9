"""Sizes of what forces and modes take, apart from kernels: records are laid out without loading these."""

from ..numerics.legendre import KEPT
from .simd import FACTORS, LANES
from .simd_rows import MOST_POINTS, WIDE

CLICK_MODES = 4
"""Modes of the bank that a click takes, one after the other: together they make one sound (`click.py`)."""

HALF = FACTORS // KEPT // 2
"""Samples ahead and behind that a band-limited sample of a force is made of: so many that the window's FACTORS weights
stay in registers (`fed.py`)."""

REACH = 2
"""Samples ahead and behind whose forces are heard in a sample: taps 0 to REACH on either side (`fed.py`)."""

LEAST_FED = 4 * LANES
"""Modes of an object's own from which on it gets the rolls on it by one number a frame: that costs more to lay for each
force than to ring fewer modes by moments."""

SENSED = 4
"""Velocities (m/s) that `sense` finds: after a third of the sample, at its end; its mean, and int v t dt
(`velocity.py`)."""

ROWS = 1 + 2 * SENSED + 4 + 2
"""Values for each mode that slides at a point: its shape there, and what `set_rows` finds (`velocity.py`)."""

KEPT_GROUPS = 10
"""Groups of LANES modes whose factors in rows are kept (`rows.py`), at most."""

ROOM_FOR_FACTORS = (KEPT_GROUPS + 1) * 8 * LANES
"""Values that are kept of them: how far each group turns, then its factors at up to four points of a sample."""

ROOM_FOR_ROWS = MOST_POINTS * ((WIDE + 4) * LANES + WIDE) + 2 * LANES
"""Values that `lay_rows` needs room for (`rows.py`)."""
