"""Sizes of finite cells: their side, and how often those at inner edges are halved, for about so many in a body."""

from typing import NamedTuple

import numpy as np

from ..bodies.material import Array
from .grading import graded, places_on
from .grids import TILT, Grid, grid_about
from .surface import Surface, faces_of, volume_of

_SIZES = 14  # halvings
_SAMPLES = 30_000
_SHARES, _FINE_SHARES = (0.8, 0.6), (1.0, 0.8, 0.6, 0.45)  # of cells that are all alike: before they are halved
_MORE = 2.4  # times as many cells as if all were alike, those of a second grid among them
_HALVINGS = 3
_RESOLVED = 0.2  # of the smallest cells' sides: the body is thicker
_RAYS = (24, 40)  # of a cell: the fewest, the most
_THROUGH = 4  # rays through a wall


class Sizes(NamedTuple):
    """The side of cells (m), rays through each, and the body's thickness (m): twice its volume over its area. How often
    cells at inner edges are halved, and whether the last halving gives the error that is left; whether walls yield
    across at inner edges alone."""

    side: float
    rays: int
    thickness: float
    halvings: int = 0
    told: bool = False
    edges: bool = False


def sizes(surface: Surface, cells: int, wall: float | None = None) -> Sizes:
    """Return sizes for about so many cells, all alike."""
    turned = Surface(surface.points @ TILT.T, surface.faces)
    total = float(faces_of(turned).areas.sum())
    volume = volume_of(turned) if wall is None else wall * total
    places, _ = places_on(turned, _SAMPLES)
    low, high = 1e-3 * float(np.ptp(turned.points)), float(np.ptp(turned.points))
    for _ in range(_SIZES):
        side = np.sqrt(low * high)
        if _count(grid_about(turned, side, 1), places, volume if wall is None else 0.0) > cells:
            low = side
        else:
            high = side
    thickness = 2 * volume / total
    return Sizes(high, int(np.clip(np.ceil(high * _THROUGH / thickness), *_RAYS)), thickness)


def graded_sizes(surface: Surface, cells: int, fine: bool) -> Sizes:
    """Return sizes for a solid: where it has inner edges, of large cells that are halved there, as far as that takes no
    more time than some twice as many cells that are all alike."""
    turned = Surface(surface.points @ TILT.T, surface.faces)
    places, _ = places_on(turned, _SAMPLES)
    best = None
    for share in _FINE_SHARES if fine else _SHARES:
        size = sizes(surface, int(share * cells))
        grids = graded(grid_about(turned, size.side, size.rays), turned, _HALVINGS)
        counts = [_count(each, places, volume_of(turned)) for each in grids]
        for halvings in range(1, len(grids)):
            told = halvings > 1
            takes = counts[halvings] + told * counts[halvings - 1]
            resolved = size.thickness > _RESOLVED * size.side / 2**halvings
            if resolved and takes < _MORE * cells and (not best or halvings > best.halvings):
                best = size._replace(halvings=halvings, told=told)
    return (best or sizes(surface, cells))._replace(edges=fine)


def _count(grid: Grid, places: Array, volume: float) -> float:
    """Return about how many cells hold a body of a volume (m^3) with such places on its surface."""
    crossed = np.unique(grid.number(places))
    inside = volume / grid.side**3 - float((grid.sides[crossed] ** 3).sum()) / grid.side**3 / 2
    return len(crossed) + max(0.0, inside)
