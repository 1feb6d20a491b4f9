"""Grids of cubes about a body, some of which are halved, and halved again, where the body asks for smaller ones."""

from typing import NamedTuple

import numpy as np

from ..bodies.material import Array
from .surface import Indices, Surface, rotation

TILT = rotation((0.11, 0.13, 0.17))
"""The turn of the body against the grid: of angles that no body has."""

_LEAST_RAYS = 16  # through a small cube


class Grid(NamedTuple):
    """Cubes from a `corner` (3,), in m, as many as `counts` (3,) say, and their halves.

    Of each: its place (3,) in units of its own side, how often its cube was halved, its side (m), the cube that it is
    part of (-1: none), and the first of its eight parts (-1: it is not halved). Parts follow all cubes that are as
    large as their whole. rays cross the side of a large cube.
    """

    corner: Array
    counts: Indices
    rays: int
    at: Indices
    levels: Indices
    sides: Array
    whole: Indices
    parts: Indices

    @property
    def size(self) -> int:
        """The number of cubes."""
        return len(self.at)

    @property
    def side(self) -> float:
        """The side (m) of a large cube."""
        return float(self.sides[0])

    @property
    def leaves(self) -> Indices:
        """The numbers of the cubes that are not halved: the cells."""
        return np.flatnonzero(self.parts < 0)

    @property
    def corners(self) -> Array:
        """The lowest corners (n, 3) of the cubes, in m."""
        return self.corner + self.sides[:, None] * self.at

    def rays_of(self, level: int) -> int:
        """Return how many rays cross the side of a cube that was halved so often."""
        return max(min(self.rays, _LEAST_RAYS), -(-self.rays >> level))

    def number(self, places: Array) -> Indices:
        """Return the number of the cell that holds each of the places (n, 3)."""
        within = (places - self.corner) / self.side
        at = np.clip(np.floor(within).astype(np.int64), 0, self.counts - 1)
        numbers: Indices = (at[:, 0] * self.counts[1] + at[:, 1]) * self.counts[2] + at[:, 2]
        inside = np.flatnonzero(self.parts[numbers] >= 0)
        while len(inside):
            of = numbers[inside]
            part = within[inside] * 2.0 ** (self.levels[of, None] + 1) - 2 * self.at[of]
            x, y, z = np.clip(np.floor(part).astype(np.int64), 0, 1).T
            numbers[inside] = self.parts[of] + (x * 2 + y) * 2 + z
            inside = inside[self.parts[numbers[inside]] >= 0]
        return numbers

    def halved(self, which: Indices) -> "Grid":
        """Return a grid in which some of the smallest cells (their numbers, ascending) are halved."""
        octant = np.stack(np.unravel_index(np.arange(8), (2, 2, 2)), axis=1)
        parts = self.parts.copy()
        parts[which] = self.size + 8 * np.arange(len(which))
        return self._replace(
            at=np.vstack([self.at, (2 * self.at[which, None] + octant).reshape(-1, 3)]),
            levels=np.r_[self.levels, np.repeat(self.levels[which] + 1, 8)],
            sides=np.r_[self.sides, np.repeat(self.sides[which] / 2, 8)],
            whole=np.r_[self.whole, np.repeat(which, 8)],
            parts=np.r_[parts, np.full(8 * len(which), -1)],
        )

    def again(self, which: Indices) -> "Grid":
        """Return a grid in which some cells (their numbers) are there once more, after all others."""
        at, levels, sides, whole, parts = (
            np.concatenate([each, each[which]]) for each in (self.at, self.levels, self.sides, self.whole, self.parts)
        )
        return self._replace(at=at, levels=levels, sides=sides, whole=whole, parts=parts)


def grid_about(surface: Surface, side: float, rays: int, margin: float = 0.0) -> Grid:
    """Return a grid of cells about a surface, and `margin` (m) around it; no face of a box lies on a plane of it."""
    corner = surface.points.min(axis=0) - margin - side * np.array([0.31, 0.37, 0.43])
    counts = np.ceil((surface.points.max(axis=0) + margin - corner) / side).astype(np.int64) + 1
    at = np.stack(np.unravel_index(np.arange(counts.prod()), tuple(counts)), axis=1).astype(np.int64)
    none = np.full(len(at), -1)
    return Grid(corner, counts, rays, at, np.zeros(len(at), np.int64), np.full(len(at), side), none, none)
