"""The air's load on rectangular plates.

A mode's impedance is a smooth function of the frequency, and what is dear in it depends on the frequency alone: it is
solved at a few frequencies, each for all modes nearby, and interpolated between them.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..air import IMPEDANCE, SPEED, Load, plate_mass, wavenumber
from ..material import Array
from ..modes import Indices
from .rectangle import free_rectangle, jump_terms, legendre_terms, side, walled_rectangle

_MARGIN = {"free": 3, "wall": 8, "closed": 8}  # terms beyond those that a mode's waves need
_CLOSED = 5.0  # (k - k_b) b from which the endless plate's formula holds within 0.4 dB, b half the shorter side
_MOST_TERMS = {"free": 450, "wall": 1400, "closed": 1400}  # its waves are the shortest that are solved
_SLOW = ((0.06, -20.0), (0.11, -15.0), (0.22, -8.0), (0.28, -5.0), (0.36, -2.0), (0.45, 1.0), (0.57, 4.5), (0.71, 9.3))
_OVER, _BLUR = 1.1, 1.6
_NODES_PER_OCTAVE = {"free": 8, "wall": 16, "closed": 16}
_NODES = 3  # between which a mode is interpolated
_LEAST, _NOTHING = 1e-300, 1e-12
_PARITIES = ((0, 0), (0, 1), (1, 0), (1, 1))


class Group(NamedTuple):
    """Modes of a block of the Ritz series: their numbers (n,), beam functions x and y (j,), and vectors (j, n)."""

    mode: Indices
    x: Indices
    y: Indices
    vector: Array


class Rectangle(NamedTuple):
    """A plate's modes: half its sides (m), mass per area (kg/m^2), sqrt(D/(rho h)), and their Ritz series.

    along and across give the beams' functions, of unit norm, at fractions of the side; baffle: one of `heard.BAFFLES`.
    """

    halves: tuple[float, float]
    areal: float
    speed: float
    along: Callable[[Array], Array]
    across: Callable[[Array], Array]
    groups: list[Group]
    baffle: str


class Loads:
    """The load as a function of the modes' frequencies in air."""

    def __init__(self, plate: Rectangle, frequency: Array) -> None:
        """Prepare the modes of a plate by their frequencies (n,) in Hz, without air, ascending."""
        self._plate = plate
        self._waves = np.sqrt(2 * math.pi * frequency / plate.speed)
        fast = _is_fast(plate, self._waves, frequency)
        terms = np.prod([self._waves * half + _MARGIN[plate.baffle] for half in plate.halves], axis=0)
        self._solved = np.flatnonzero(~fast & (terms <= _MOST_TERMS[plate.baffle]))
        if self._solved.size:
            self._tabulate(frequency[self._solved])

    def __call__(self, frequency: Array) -> Load:
        resistance = _typical(self._plate, self._waves, frequency)
        mass = plate_mass(self._plate.areal, self._waves, frequency)
        if self._solved.size:
            resistance[self._solved], solved_mass = self._interpolated(frequency[self._solved])
            if self._plate.baffle == "free":
                mass[self._solved] = solved_mass
        sides = 1.0 if self._plate.baffle == "closed" else 2.0
        return Load(resistance * sides / 2, mass * sides / 2)

    def _tabulate(self, frequency: Array) -> None:
        """Solve at nodes (m,) of ln f the impedances of the modes around each."""
        low, high = math.log(frequency[0] / 1.1), math.log(frequency[-1])
        count = max(_NODES, math.ceil((high - low) / math.log(2) * _NODES_PER_OCTAVE[self._plate.baffle]) + 1)
        self._nodes = np.linspace(low, high, count)
        nearest = np.round((np.log(frequency) - low) / (self._nodes[1] - low)).astype(int)
        self._first = np.clip(nearest - 1, 0, count - _NODES)
        self._values = np.zeros((_NODES, frequency.size, 2))
        solver = _Solver(self._plate, self._solved, self._waves)
        for node, at in enumerate(np.exp(self._nodes)):
            using = np.flatnonzero((node >= self._first) & (node < self._first + _NODES))
            if using.size:
                self._values[node - self._first[using], using] = solver.solve(at, using)

    def _interpolated(self, frequency: Array) -> tuple[Array, Array]:
        """Interpolate ln R and the mass by parabolas over ln f."""
        x = np.log(frequency)
        a, b, c = self._nodes[self._first + np.arange(_NODES)[:, None]]
        weights = np.stack(
            [
                (x - b) * (x - c) / ((a - b) * (a - c)),
                (x - a) * (x - c) / ((b - a) * (b - c)),
                (x - a) * (x - b) / ((c - a) * (c - b)),
            ]
        )
        resistance = np.exp((weights * np.log(np.maximum(self._values[..., 0], _LEAST))).sum(axis=0))
        return resistance, (weights * self._values[..., 1]).sum(axis=0)


def _is_fast(plate: Rectangle, waves: Array, frequency: Array) -> npt.NDArray[np.bool_]:
    """True for the modes that radiate as an endless plate does."""
    return np.asarray((wavenumber(frequency) - waves) * min(plate.halves) > _CLOSED)


def _typical(plate: Rectangle, waves: Array, frequency: Array) -> Array:
    """Return the resistance of modes of many waves: that of an endless plate, and where they are slower than sound a
    mean.

    Below 0.7 of the critical frequency f_c that is _SLOW over the share of the edges, c P/(4 pi^2 S f_c): a fit to
    the solutions of four plates of 300 to 900 modes, within 2 dB; single modes scatter by 2 dB around it (rms), far
    below f_c by 5 dB. The plate's ends blur the peak at f_c.
    """
    ratio = (wavenumber(frequency) / waves) ** 2
    a, b = plate.halves
    critical = SPEED**2 / (2 * math.pi * plate.speed)
    edges = SPEED * (a + b) / (4 * math.pi**2 * a * b * critical)
    blur = np.where(_is_fast(plate, waves, frequency), 0.0, _BLUR / (waves * min(a, b)))
    fast = 10 * np.log10(1 / np.sqrt(np.maximum(1 - 1 / ratio, 0) + blur))
    where, level = np.array(_SLOW).T
    slow = np.interp(np.log(ratio), np.log(where), level + 10 * math.log10(edges))
    steepness = np.clip(np.log(ratio / where[-1]) / math.log(_OVER / where[-1]), 0, 1)
    whole: Array = 2 * IMPEDANCE / plate.areal * 10 ** ((slow + steepness * (fast - slow)) / 10)
    return whole


class _Solver:
    """The modes that are solved, by their projections on the sides' terms (p, q, n)."""

    def __init__(self, plate: Rectangle, solved: Indices, waves: Array) -> None:
        self._plate, self._waves = plate, waves[solved]
        longest = self._waves[-1]
        terms = [math.ceil(longest * half) + _MARGIN[plate.baffle] for half in plate.halves]
        project = jump_terms if plate.baffle == "free" else legendre_terms
        functions = zip(terms, (plate.along, plate.across), plate.halves, strict=True)
        along, across = (project(*each) for each in functions)
        place = np.full(waves.size, -1)
        place[solved] = np.arange(solved.size)
        self._projected = np.zeros((*terms, solved.size))
        for group in plate.groups:
            at = place[group.mode]
            vector = group.vector[:, at >= 0]
            product = (along[:, None, group.x] * across[None, :, group.y]).reshape(terms[0] * terms[1], -1)
            self._projected[:, :, at[at >= 0]] = (product @ vector).reshape(*terms, -1)
        self._sides = [side(*each) for each in zip(plate.halves, terms, strict=True)] if plate.baffle == "free" else []

    def solve(self, frequency: float, modes: Indices) -> Array:
        """Return the resistance and mass (modes, 2) at a frequency (Hz); in a wall the mass is left to `plate_mass`."""
        omega, plate = 2 * math.pi * frequency, self._plate
        k = omega / SPEED
        terms = [math.ceil(self._waves[modes[-1]] * half) + _MARGIN[plate.baffle] for half in plate.halves]
        b = self._projected[: terms[0], : terms[1], modes]
        least = _NOTHING * (b**2).sum()
        parts = {odd: b[odd[0] :: 2, odd[1] :: 2] for odd in _PARITIES}
        parts = {odd: part for odd, part in parts.items() if (part**2).sum() > least}
        if plate.baffle != "free":
            resistance = 2 * IMPEDANCE / plate.areal * walled_rectangle(k, plate.halves, parts)
            return np.stack([resistance, np.zeros_like(resistance)], axis=1)
        impedance = 2 * IMPEDANCE * k / plate.areal * free_rectangle(k, self._sides[0], self._sides[1], parts)
        return np.stack([impedance.real, -impedance.imag / omega], axis=1)
