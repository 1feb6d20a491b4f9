"""The position on a strike path that is nearest to a point of a body, of shapes that have no surface of their own.

The body's frame: its origin is in the body's middle; x runs along the length of bars, strings and plates, y along the
width, z along the thickness, or the axis of what is round.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

_ASIDE = 0.1  # of a plate's path: a point that is farther from it is no point of it

Geometry = Mapping[str, Any]
Place = Sequence[float]


def position_of(shape: str, geometry: Geometry, point: Place) -> float | None:
    """Return the position (0 to 1) on a shape's strike path that is nearest to a point (m); None of shapes whose paths
    are not places of their frame. ValueError names a point that is far from the path."""
    place = _PLACES.get(shape)
    return None if place is None else place(geometry, point)


def _along(geometry: Geometry, point: Place) -> float:
    """Return the share of a length; where along a section a bar is struck is not asked."""
    share: float = point[0] / geometry["length"] + 0.5
    return min(max(share, 0.0), 1.0)


def _over_plate(geometry: Geometry, point: Place) -> float:
    sides = float(geometry["length"]), float(geometry["width"])
    ends = geometry.get("path_from", (0.0, 0.0)), geometry.get("path_to", (1.0, 1.0))
    start, end = ([(share - 0.5) * side for share, side in zip(each, sides, strict=True)] for each in ends)
    way = end[0] - start[0], end[1] - start[1]
    length = math.hypot(*way)
    if not length:
        return 0.0
    found = ((point[0] - start[0]) * way[0] + (point[1] - start[1]) * way[1]) / length**2
    share: float = min(max(found, 0.0), 1.0)
    aside = math.hypot(point[0] - start[0] - share * way[0], point[1] - start[1] - share * way[1])
    if aside > _ASIDE * length:
        path = " to ".join(f"{x:.4g} {y:.4g}" for x, y in (start, end))
        raise ValueError(
            f"it is {aside:.3g} m from the strike path ({path} m), where alone a plate is struck: expected within "
            f"{_ASIDE * length:.3g} m, other keys path_from and path_to, or a [mesh] box"
        )
    return share


def _over_disc(geometry: Geometry, point: Place) -> float:
    """Return the position on a diameter: what is round is alike all around, so that the distance counts alone."""
    share = min(math.hypot(point[0], point[1]) / float(geometry["radius"]), 1.0)
    return 0.5 + 0.5 * math.copysign(share, point[0])


_PLACES: Mapping[str, Callable[[Geometry, Place], float]] = {
    "bar": _along,
    "string": _along,
    "plate": _over_plate,
    "disc": _over_disc,
    "membrane": _over_disc,
}
