"""Real gains of modes from complex amplitudes.

A body's modes all answer a blow with the same phase, or the opposite one. In a recording the way to the microphone
turns each mode's phase. Alone, a mode keeps its amplitude's size. Modes that overlap, as pairs that beat do, keep what
they are together: the real gains nearest to the amplitudes, in the energy of their sum, up to a phase in common.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from ..numerics.checks import Array
from .sums import Complex, products

Indices = npt.NDArray[np.intp]

_ALIKE = 0.6  # of two modes' coherence over the recording: they can't be told apart without each other's phase
_PHASES = np.linspace(0, np.pi, 24, endpoint=False)


def real_gains(amplitude: Sequence[Complex], s: Complex, lengths: Sequence[int]) -> Array:
    """Return the gains (takes, k) of modes of log poles s per sample from their amplitudes (k,) in each take."""
    if len(amplitude) > 1:
        return _alike(np.array(amplitude))
    energy = products(s, lengths[0])[1]
    gains = np.zeros((1, len(s)))
    for group in overlapping(energy):
        gains[0, group] = _nearest(amplitude[0][group], energy[np.ix_(group, group)])
    return gains


def _alike(amplitude: Complex) -> Array:
    """Return the gains of several takes: the sizes, with signs by a phase that each mode has in common in all."""
    phase = 0.5 * np.angle(np.sum(amplitude**2, axis=0))
    turned = amplitude * np.exp(-1j * phase)
    turned = turned * np.where(turned[0].real < 0, -1, 1)
    gains: Array = np.where(turned.real < 0, -1.0, 1.0) * np.abs(amplitude)
    return gains


def overlapping(energy: Complex) -> list[Indices]:
    """Return the groups of modes that overlap, by their indices; energy (k, k): sums over time of conj(a_i) a_j."""
    scale = np.sqrt(np.diag(energy).real)
    alike = np.abs(energy) / np.outer(scale, scale) > _ALIKE
    count, label = connected_components(csr_array(alike), directed=False)
    return [np.flatnonzero(label == number) for number in range(count)]


def _nearest(amplitude: Complex, energy: Complex) -> Array:
    """Return the real gains g that leave the least energy in the sum of (c - g exp(i phase)) exp(s t), over phases."""
    if len(amplitude) == 1:
        return np.where(amplitude.real < 0, -1.0, 1.0) * np.abs(amplitude)
    best, least = np.abs(amplitude), np.inf
    scale = np.sqrt(np.diag(energy).real)
    system = energy.real / np.outer(scale, scale) + 1e-6 * np.eye(len(amplitude))
    for phase in _PHASES:
        turned = amplitude * np.exp(-1j * phase)
        gains = np.linalg.solve(system, (energy @ turned).real / scale) / scale
        left = turned - gains
        error = float((left.conj() @ energy @ left).real)
        if error < least:
            best, least = gains * np.where(np.cos(phase) < 0, -1.0, 1.0), error
    return best
