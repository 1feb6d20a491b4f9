"""Sizes of lasting contacts that are solved in blocks (block.py): parts of a sample, forces and moments."""

from ..numerics.sums import DELAYED

MOST_PARTS = 3
"""Parts of a sample, at most."""

NODES_PER_PART = 2

FORCES = MOST_PARTS * NODES_PER_PART
"""Unknown forces in a sample, at most."""

MOTIONS = 2 * FORCES
"""Compression and rate at all nodes."""

MOMENTS_AHEAD = MOST_PARTS + 1
"""Legendre moments of the force over a sample that later ones feel, at most: one more than it has parts."""

LAID = DELAYED
"""Samples over which the path of a body that rolls evenly is laid at once, at most: lanes take as many as later ones
feel together (block_lanes.py)."""

LINEAR = 0
"""Number in the place of parts for a rest that is a line about its load (linear.py)."""
