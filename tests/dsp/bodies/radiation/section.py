"""The radiation of an endless bar of rectangular section, by boundary elements of its section: the tables' reference.

    python -m tests.dsp.bodies.radiation.section

prints the tables of `carom.dsp.bodies.radiation.thick`. The sound field outside of the section of half sides 1 and a is
p = int p dG/dn - G dp/dn, G = i/4 H_0(k r), collocated at the middles of panels of one quarter. Points inside, where
the same is 0, rule out resonances of the inside (H. A. Schenck, J. Acoust. Soc. Am. 44, 1968).
"""

import numpy as np
from scipy.special import hankel1

from carom.dsp.bodies.radiation import line, thick, twist

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_FINE, _FINE_WEIGHTS = np.polynomial.legendre.leggauss(24)
_INSIDE = 12


def resistance(x: float, aspect: float, turns: bool = False, count: int = 24) -> float:
    """Return the resistance per length, over rho c times half the width, at x = k half the width.

    aspect: thickness over width. The section moves along its thickness, or turns, its edges at unit velocity.
    """
    begin, across, length, normal = _quarter(aspect, count)
    middle = begin + across / 2
    inside = np.random.default_rng(0).uniform(0.05, 0.95, (_INSIDE, 2)) * [1, aspect]
    at = np.concatenate([middle, inside])
    weights = length[:, None] / 2 * _WEIGHTS
    places = middle[:, None] + _NODES[None, :, None] / 2 * across[:, None]
    single = np.zeros((len(at), len(middle)), complex)
    double = np.zeros_like(single)
    for mirror in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        sign = mirror[1] * (mirror[0] if turns else 1)
        away = at[:, None, None] - places * mirror
        far = np.linalg.norm(away, axis=3)
        along = np.einsum("ijqc,jc->ijq", away, normal * mirror) / far
        single += sign * (_green(x * far) * weights).sum(axis=2)
        double += sign * (0.25j * x * hankel1(1, x * far) * along * weights).sum(axis=2)
    for n, half in enumerate(length / 2):  # of a panel on itself, with its logarithm exact
        near = half * (_FINE + 1) / 2
        smooth = ((_green(x * near) + np.log(near) / (2 * np.pi)) * _FINE_WEIGHTS).sum() * half / 2
        rough = (_green(x * np.abs(_NODES) * half) * weights[n]).sum()
        single[n, n] += 2 * (smooth - (half * np.log(half) - half) / (2 * np.pi)) - rough
    moving = normal[:, 1] * middle[:, 0] - normal[:, 0] * middle[:, 1] if turns else normal[:, 1]
    matrix = np.concatenate([np.eye(len(middle)) / 2, np.zeros((_INSIDE, len(middle)))]) - double
    pressure = np.linalg.lstsq(matrix, -single @ (1j * x * moving), rcond=None)[0]
    return 4 * float(np.real((pressure * moving * length).sum()))


def _green(x: np.ndarray) -> np.ndarray:
    return 0.25j * hankel1(0, x)


def _quarter(aspect: float, count: int) -> tuple[np.ndarray, ...]:
    """Return panels of a quarter of the section, smaller towards the corner: begins, vectors, lengths and normals."""
    upright = max(4, int(count * aspect)) if aspect > 0.25 else max(4, count // 3)
    side, top = (np.sin(np.pi / 2 * np.arange(n + 1) / n) for n in (upright, count))
    corners = [
        np.stack([np.ones(upright + 1), aspect * side], axis=1),
        np.stack([top[::-1], np.full(count + 1, aspect)], 1),
    ]
    begin, end = (np.concatenate([each[part] for each in corners]) for part in (slice(None, -1), slice(1, None)))
    across = end - begin
    length = np.linalg.norm(across, axis=1)
    return begin, across, length, np.stack([across[:, 1], -across[:, 0]], axis=1) / length[:, None]


def dipole_of(aspect: float) -> float:
    """Return the dipole of a section of a thickness over its width, over that of a flat strip of its width."""
    return line.added_of(aspect) + 4 * aspect / np.pi


def excess(x: float, aspect: float, turns: bool = False) -> float:
    """Return by how much (dB) the resistance is above that estimated of the dipole or the quadrupole of its section."""
    at = np.array([x])
    if turns:
        strength, flat = np.interp(aspect, twist.THICKNESS, twist.FLATNESS), twist.strip(at)
    else:
        strength, flat = dipole_of(aspect), line._strip_resistance(at)
    known = flat[0] * (1 + (strength**2 - 1) / (1 + x * x) ** 2)
    return float(10 * np.log10(resistance(x, aspect, turns, 24 if aspect < 2 else 12) / known))


def main() -> None:
    """Print the tables."""
    for name, aspects, turns in (("SWAYS", thick.ASPECTS, False), ("TURNS", thick.TURNED, True)):
        print(f"{name} = (")
        for aspect in aspects:
            values = [f"{excess(x, aspect, turns):.2f}" for x in np.geomspace(*thick.REACH, thick.STEPS)]
            print(f"    ({', '.join(values)}),")
        print(")")


if __name__ == "__main__":
    main()
