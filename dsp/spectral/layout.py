"""The memory of a spectral bank: phases, whose blocks begin one after the other, and in each of them bins of chunks.

A phase keeps its chunks in a region of its own, bin after bin as far as may be: what lies in memory in the order in
which it is read is read several times faster. A bin has room for some more modes; one that runs full moves to the
region's end. When too much has moved, the phase moves bin by bin to the spare region (places.py).

A bin keeps what brings its modes further as float64 or, where that is chosen, as f32.
"""

from typing import Annotated

from ..native.typed import Record, View, View2D, f32, i32
from ..sizes import CAPACITY
from .basis import BINS, FRAMES, POINT, SIZE
from .simd import CHUNK, MOTION, SUMS, WEIGHTS

PHASES = 8
"""Blocks begin in turn, one in each 64 frames."""
PHASE_MODES = CAPACITY.phase_modes
REGION = 4 * (PHASE_MODES // CHUNK + BINS)
"""Chunks of a region: what moves in it needs room."""
CHUNKS = (PHASES + 1) * REGION


class Phase(Record):
    """The modes whose blocks begin in one quantum."""

    start: Annotated[View[int], BINS]  # first chunk of each bin
    count: Annotated[View[int], BINS]  # its chunks
    room: Annotated[View[int], BINS]  # chunks that it has room for
    used: Annotated[View[int], BINS]  # its modes
    free: Annotated[View[int], BINS]  # its first free place, 1 + number; 0: none
    single: Annotated[View[int], BINS]  # 1: its modes are in `singles`
    region: int  # first chunk of its region
    top: int  # the first chunk after all that are taken
    modes: int  # in all its bins
    moved: int  # chunks that moved since it was last put in order
    begin: int  # samples: when its block began
    sounds: int  # 1: its block is not silence
    out: Annotated[View2D[float], 2, FRAMES]  # the block


class Spectral(Record):
    """A place is a chunk's number times CHUNK and the mode's number in the chunk."""

    chunks: Annotated[View[float], CHUNKS * MOTION * CHUNK]  # modes, as simd.py says
    singles: Annotated[View[f32], CHUNKS * MOTION * CHUNK]  # the same places, of bins whose modes are kept in f32
    weights: Annotated[View[f32], CHUNKS * WEIGHTS * CHUNK]  # of both
    owner: Annotated[
        View[i32], CHUNKS * CHUNK
    ]  # whose place it is: 1 + number of the mode; else minus the next free one
    sums: Annotated[View[float], BINS * SUMS]
    points: Annotated[View2D[float], 2, SIZE * POINT]
    phases: Annotated[View[Phase], PHASES]
    spare: int  # first chunk of the spare region
    moving: int  # 1 + the phase that is being put in order; 0: none
    next_bin: int  # the first of its bins that has not moved
    modes: int  # in all phases
    single: int  # 1: all bins are to be kept in f32
    unlike: int  # bins that are not yet looked at for that, from the last one on
    fading: int  # 1: a panic lets all that is in it fade
    faded: int  # frames since that panic
