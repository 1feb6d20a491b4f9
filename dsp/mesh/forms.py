"""Surfaces of simple things: turned, pulled, bent from a tube. Put together they make the meshes of household things.

Parts may overlap: a model joins them. Lengths in m.
"""

import numpy as np
import numpy.typing as npt

from ..bodies.material import Array
from .surface import Surface


def lathe(profile: npt.ArrayLike, count: int = 96, closed: bool = True) -> Surface:
    """Return what a profile (n, 2) of radii and heights makes as it turns about z, in so many steps.

    closed: the profile is a polygon, counter-clockwise as seen with the axis at the left; else a line, and the surface
    is a sheet. Points on the axis are one.
    """
    at = np.asarray(profile, float)
    angle = np.arange(count) * 2 * np.pi / count
    points: list[tuple[float, float, float]] = []
    rings = []
    for radius, height in at:
        rings.append(np.full(count, len(points)) if radius == 0 else len(points) + np.arange(count))
        turned = [(0.0, 0.0, height)] if radius == 0 else zip(
            radius * np.cos(angle), radius * np.sin(angle), np.full(count, height), strict=True
        )  # fmt: skip
        points += list(turned)
    faces = []
    for number in range(len(at) if closed else len(at) - 1):
        low, high = rings[number], rings[(number + 1) % len(at)]
        after_low, after_high = np.roll(low, -1), np.roll(high, -1)
        if number % 2:
            quads = [(low, after_low, high), (after_low, after_high, high)]
        else:
            quads = [(low, after_low, after_high), (low, after_high, high)]
        faces += [np.stack(each, axis=1) for each in quads]
    every = np.concatenate(faces)
    whole = (every[:, 0] != every[:, 1]) & (every[:, 1] != every[:, 2]) & (every[:, 2] != every[:, 0])
    return Surface(np.array(points, float), every[whole].astype(np.int64))


def pulled(outline: npt.ArrayLike, height: float) -> Surface:
    """Return a prism on an outline (n, 2), counter-clockwise in the plane z = 0, up to a height.

    The outline must be seen whole from its middle: no corner hides another.
    """
    at = np.asarray(outline, float)
    count = len(at)
    middle = at.mean(axis=0)
    low, high = np.c_[at, np.zeros(count)], np.c_[at, np.full(count, height)]
    ends = np.array([[*middle, 0.0], [*middle, height]])
    number = np.arange(count)
    after = (number + 1) % count
    faces = np.concatenate([
        np.stack([number, after, after + count], axis=1),
        np.stack([number, after + count, number + count], axis=1),
        np.stack([after, number, np.full(count, 2 * count)], axis=1),
        np.stack([number + count, after + count, np.full(count, 2 * count + 1)], axis=1),
    ])  # fmt: skip
    return Surface(np.vstack([low, high, ends]), faces.astype(np.int64))


def box(length: float, width: float, height: float) -> Surface:
    """Return a box about the origin."""
    half = np.array([length, width]) / 2
    made = pulled(np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half, height)
    return moved(made, (0, 0, -height / 2))


def tube(path: npt.ArrayLike, section: npt.ArrayLike, across: npt.ArrayLike = (0, 1, 0)) -> Surface:
    """Return a section (m, 2), counter-clockwise, pulled along a path (n, 3), with flat ends.

    across: the direction of the section's first coordinate, which the path never takes; the second one is across both.
    """
    line, outline, side = np.asarray(path, float), np.asarray(section, float), np.asarray(across, float)
    along = np.gradient(line, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    first = side - (along @ side)[:, None] * along
    first /= np.linalg.norm(first, axis=1)[:, None]
    second = np.cross(along, first)
    rings = line[:, None] + outline[None, :, :1] * first[:, None] + outline[None, :, 1:] * second[:, None]
    count, steps = len(outline), len(line)
    number = np.arange(count)
    after = (number + 1) % count
    faces = []
    for step in range(steps - 1):
        low, high = step * count, (step + 1) * count
        faces += [
            np.stack([low + number, low + after, high + after], axis=1),
            np.stack([low + number, high + after, high + number], axis=1),
        ]
    last = steps * count
    faces += [
        np.stack([after, number, np.full(count, last)], axis=1),
        np.stack([last - count + number, last - count + after, np.full(count, last + 1)], axis=1),
    ]
    points = np.vstack([rings.reshape(-1, 3), line[:1], line[-1:]])
    return Surface(points, np.concatenate(faces).astype(np.int64))


def ball(radius: float, rounds: int = 3) -> Surface:
    """Return a sphere: an icosahedron whose triangles were split so many times."""
    golden = (1 + 5**0.5) / 2
    points = np.array([(0, a, b * golden) for a in (-1, 1) for b in (-1, 1)], float)
    points = np.vstack([points, np.roll(points, 1, axis=1), np.roll(points, 2, axis=1)])
    from scipy.spatial import ConvexHull

    faces = ConvexHull(points).simplices.astype(np.int64)
    a, b, c = points[faces].transpose(1, 0, 2)
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a) < 0
    faces[inward] = faces[inward][:, ::-1]
    made = Surface(points, faces)
    for _ in range(rounds):
        made = split(made)
    scale = radius / np.linalg.norm(made.points, axis=1)
    return Surface(made.points * scale[:, None], made.faces)


def split(surface: Surface) -> Surface:
    """Return a surface of which each triangle became four."""
    sides = np.stack([surface.faces, np.roll(surface.faces, -1, axis=1)], axis=2)
    edges, number = np.unique(np.sort(sides.reshape(-1, 2), axis=1), axis=0, return_inverse=True)
    middle = number.reshape(-1, 3) + len(surface.points)
    points = np.vstack([surface.points, surface.points[edges].mean(axis=1)])
    a, b, c = surface.faces.T
    ab, bc, ca = middle.T
    faces = np.concatenate([np.stack(each, axis=1) for each in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return Surface(points, faces.astype(np.int64))


def circle(radius: float, count: int = 24) -> Array:
    """Return the outline (count, 2) of a circle."""
    angle = np.arange(count) * 2 * np.pi / count
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def moved(surface: Surface, by: npt.ArrayLike, turn: npt.ArrayLike | None = None) -> Surface:
    """Return a surface turned by a rotation matrix (3, 3), then moved (3,)."""
    points = surface.points if turn is None else surface.points @ np.asarray(turn, float).T
    return Surface(points + np.asarray(by, float), surface.faces)


def together(*parts: Surface) -> Surface:
    """Return parts as one surface."""
    begin = np.cumsum([0, *(len(part.points) for part in parts)])
    faces = [part.faces + first for part, first in zip(parts, begin, strict=False)]
    return Surface(np.vstack([part.points for part in parts]), np.concatenate(faces))
