"""The radiation of a box whose faces move, by boundary elements of one octant: an independent solution for bars.

The sound field outside is p = int p dG/dn - G dp/dn, G = exp(ikr)/(4 pi r), collocated at the middles of flat panels
that are smaller towards the edges; the static parts of a panel are in closed form. What it radiates follows from its
far field. Below resonances of the inside alone, which thin bodies have far above what is heard.
"""

import math
from collections.abc import Callable
from itertools import product
from typing import NamedTuple

import numpy as np

from carom.dsp.bodies.air import DENSITY, IMPEDANCE, SPEED

_SIDES = np.array(list(product((-1.0, 1.0), repeat=2)))
_NEAR = 12.0  # halves of a panel's longer side


class Panels(NamedTuple):
    """Panels of the octant where x, y, z are positive: middles (n, 3), axes (n,) of their normals, and halves of their
    sides (n, 3), 0 along the normal."""

    middles: np.ndarray
    axes: np.ndarray
    halves: np.ndarray


def panels(halves: tuple[float, float, float], sides: tuple[float, float, float]) -> Panels:
    """Return panels of a box of half sides, about so long (m) along x, y and z."""
    cuts = [half * _graded(max(3, round(half / side))) for half, side in zip(halves, sides, strict=True)]
    found: tuple[list[np.ndarray], ...] = ([], [], [])
    for axis in range(3):
        grids = [(each[1:] + each[:-1]) / 2 for each in cuts]
        widths = [np.diff(each) / 2 for each in cuts]
        grids[axis], widths[axis] = np.array([halves[axis]]), np.zeros(1)
        for part, each in zip(found[::2], (grids, widths), strict=True):
            part.append(np.stack([at.ravel() for at in np.meshgrid(*each, indexing="ij")], axis=1))
        found[1].append(np.full(len(found[0][-1]), axis))
    return Panels(*map(np.concatenate, found))


def _graded(count: int) -> np.ndarray:
    """Return cuts from 0 to 1, even but for the last part, which falls off towards 1."""
    even = max(count - 6, 0)
    last = min(6, count)
    slow = np.sin(np.pi / 2 * np.arange(last + 1) / last) * last * 0.8
    cuts = np.concatenate([np.arange(even), even + slow])
    return cuts / cuts[-1]


def resistance(
    box: Panels, k: float, velocity: Callable[[np.ndarray, np.ndarray], np.ndarray], signs: tuple[int, int, int]
) -> float:
    """Return R of a power of R v^2/2. velocity: along the normals, of middles and axes; signs: of what it is beyond the
    planes across x, y and z."""
    moving = velocity(box.middles, box.axes)
    single, double = _matrices(box, k, signs)
    source = 1j * k * SPEED * DENSITY * moving
    pressure = np.linalg.solve(np.eye(len(moving)) / 2 - double, -single @ source)
    node, weight = np.polynomial.legendre.leggauss(24)
    x, turn = np.meshgrid((node + 1) / 2, (node + 1) * np.pi / 4, indexing="ij")
    across = np.sqrt(1 - x**2)
    ways = np.stack([x, across * np.cos(turn), across * np.sin(turn)], axis=2).reshape(-1, 3)
    areas = np.prod(np.where(box.halves > 0, 2 * box.halves, 1.0), axis=1)
    far = np.zeros(len(ways), complex)
    for mirror in product((1, -1), repeat=3):
        seen = ways * mirror
        spread = np.sinc(k * seen[:, None] * box.halves / np.pi).prod(axis=2) * areas
        wave = np.exp(-1j * k * seen @ box.middles.T) * spread
        far += _sign(mirror, signs) * ((-1j * k * seen[:, box.axes] * wave) @ pressure - wave @ source)
    power = np.outer(weight, weight).ravel() * np.pi / 8 @ np.abs(far / (4 * np.pi)) ** 2
    return float(8 * power / IMPEDANCE)


def _sign(mirror: tuple[int, ...], signs: tuple[int, int, int]) -> float:
    return math.prod(sign for side, sign in zip(mirror, signs, strict=True) if side < 0)


def _matrices(box: Panels, k: float, signs: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return the single and the double layer (n, n) of panels and their images."""
    every = np.arange(len(box.axes))
    order = (box.axes[:, None] + np.arange(3)) % 3  # normal, and the panel's two sides
    halves = box.halves[every[:, None], order]
    single, double = np.zeros((2, len(every), len(every)), complex)
    for mirror in product((1, -1), repeat=3):
        sign = _sign(mirror, signs)
        away = (box.middles * mirror)[:, None] - box.middles
        h, u, v = (away[:, every, order[:, n]] for n in range(3))
        near = h**2 + u**2 + v**2 < (_NEAR * halves.max(axis=1)) ** 2
        area = halves[:, 1] * halves[:, 2]  # of a quarter
        one, two = np.zeros((2, len(every), len(every)), complex)
        for p, q in _SIDES:
            r = np.sqrt((p * halves[:, 1] / 3**0.5 - u) ** 2 + (q * halves[:, 2] / 3**0.5 - v) ** 2 + h**2)
            wave = np.exp(1j * k * r)
            one += area * (wave - near) / r
            two += area * h * (wave * (1 - 1j * k * r) - near) / r**3
            corner = _corner(p * halves[:, 1] - u, q * halves[:, 2] - v, h)
            one += np.where(near, p * q * corner[0], 0.0)
            two += np.where(near, p * q * corner[1] * np.sign(np.where(np.abs(h) > 1e-12, h, 0.0)), 0.0)
        single += sign * one / (4 * np.pi)
        double += sign * two / (4 * np.pi)
    return single, double


def _corner(u: np.ndarray, v: np.ndarray, h: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return int int 1/r and the solid angle up to a corner."""
    r = np.sqrt(u**2 + v**2 + h**2)
    angle = np.arctan2(u * v, np.abs(h) * r)

    def log(a: np.ndarray, rest: np.ndarray) -> np.ndarray:
        """Return ln(a + r), which cancels where a < 0."""
        return np.where(a > 0, np.log(np.abs(a) + r), np.log(np.maximum(rest, 1e-300)) - np.log(np.abs(a) + r))

    return u * log(v, u**2 + h**2) + v * log(u, v**2 + h**2) - np.abs(h) * angle, angle
