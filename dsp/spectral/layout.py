"""The memory of a spectral bank: phases, whose blocks begin one after the other, and in each of them bins of chunks.

A phase keeps its chunks in a region of its own, bin after bin as far as may be: what lies in memory in the order in
which it is read is read several times faster. A bin has room for some more modes; one that runs full moves to the
region's end. When too much has moved, the phase moves bin by bin to the spare region (places.py).

A bin keeps what brings its modes further as float64 or, where that is chosen, as float32.
"""

import numpy as np

from .basis import BINS, FRAMES, SIZE
from .simd import CHUNK, MOTION, SUMS, WEIGHTS
from .synthesis import POINT

PHASES = 8
"""Blocks begin in turn, one in each 64 frames."""
PHASE_MODES = 163_840
"""The most modes in a phase: 1.25 of an eighth of a million."""
REGION = 4 * (PHASE_MODES // CHUNK + BINS)
"""Chunks of a region: what moves in it needs room."""
CHUNKS = (PHASES + 1) * REGION

PHASE = np.dtype(
    [
        ("start", np.int64, BINS),  # first chunk of each bin
        ("count", np.int64, BINS),  # its chunks
        ("room", np.int64, BINS),  # chunks that it has room for
        ("used", np.int64, BINS),  # its modes
        ("free", np.int64, BINS),  # its first free place, 1 + number; 0: none
        ("single", np.int64, BINS),  # 1: its modes are in `singles`
        ("region", np.int64),  # first chunk of its region
        ("top", np.int64),  # the first chunk after all that are taken
        ("modes", np.int64),  # in all its bins
        ("moved", np.int64),  # chunks that moved since it was last put in order
        ("begin", np.int64),  # samples: when its block began
        ("sounds", np.int64),  # 1: its block is not silence
        ("out", np.float64, (2, FRAMES)),  # the block
    ],
    align=True,
)

SPECTRAL = np.dtype(
    [
        ("chunks", np.float64, CHUNKS * MOTION * CHUNK),  # modes, as simd.py says
        ("singles", np.float32, CHUNKS * MOTION * CHUNK),  # the same places, of bins whose modes are kept in float32
        ("weights", np.float32, CHUNKS * WEIGHTS * CHUNK),  # of both
        ("owner", np.int32, CHUNKS * CHUNK),  # whose place it is: 1 + number of the mode; else minus the next free one
        ("sums", np.float64, BINS * SUMS),
        ("points", np.float64, (2, SIZE * POINT)),
        ("phases", PHASE, PHASES),
        ("spare", np.int64),  # first chunk of the spare region
        ("moving", np.int64),  # 1 + the phase that is being put in order; 0: none
        ("next_bin", np.int64),  # the first of its bins that has not moved
        ("modes", np.int64),  # in all phases
        ("single", np.int64),  # 1: all bins are to be kept in float32
        ("unlike", np.int64),  # bins that are not yet looked at for that, from the last one on
        ("fading", np.int64),  # 1: a panic lets all that is in it fade
        ("faded", np.int64),  # frames since that panic
    ],
    align=True,
)
"""A place is a chunk's number times CHUNK and the mode's number in the chunk."""
