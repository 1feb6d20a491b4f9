"""Candidates for the modes of a recording: ESPRIT in subbands.

Each band is cut out of the signal's spectrum, shifted to 0 Hz and decimated, so that few samples span many periods of
what beats in it. There the signal's lagged copies span a space of as many dimensions as there are modes, which a shift
by one sample rotates: the eigenvalues of that rotation are the poles (R. Roy, T. Kailath, "ESPRIT", IEEE Trans.
Acoustics, Speech, and Signal Processing 37, 1989; in subbands: R. Badeau, B. David, G. Richard, 2006). Several
recordings of one body share its poles, so their covariances add up.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ..numerics.checks import Array
from .sums import Complex

EDGES = (
    20, 150, 300, 450, 650, 900, 1200, 1500, 1900, 2400, 3000, 3600, 4300, 5000, 5800, 6700, 7700, 8800, 10000, 11500,
    13000, 15000, 17500, 20000,
)  # fmt: skip
"""Hz: of the 23 bands."""

LAGS = 128
MOST_IN_BAND = 24  # modes
LOWEST = 15.0  # Hz
_FLAT, _END = 0.55, 0.98  # of a band filter's half width: where its flank begins and ends
_HIGHEST = 0.98  # of half the sampling rate
_ABOVE_NOISE = 8.0  # times the median of the lower eigenvalues: what is a mode's
_DYNAMIC = 1e-9  # of the highest eigenvalue
_ABOVE_FLOOR = 4.0  # times a band's own noise floor, in power, ends what is looked at
_LEAST, _MOST_DECAY = 0.02, 3000.0  # 1/s
_SHORTEST = 24  # decimated samples


def candidates(takes: Sequence[Array], rate: float) -> Complex:
    """Log poles per sample of what may be modes of the body that all takes ring of, (k,)."""
    length = 1 << int(np.ceil(np.log2(max(map(len, takes)) + 4096)))
    spectra = [np.fft.rfft(take, length) for take in takes]
    sizes = [len(take) for take in takes]
    found = [
        _in_band(spectra, sizes, length, rate, low, high)
        for low, high in pairwise(EDGES)
        if high <= _HIGHEST * rate / 2
    ]
    return np.concatenate([*found, np.zeros(0, np.complex128)])


def _in_band(spectra: list[Complex], sizes: list[int], length: int, rate: float, low: float, high: float) -> Complex:
    center, reach = round((low + high) / 2 * length / rate), int(np.ceil((high - low) * length / rate))
    slow = 2 * reach * rate / length  # Hz, the decimated rate
    skip = int(np.ceil(1.0 / (0.45 * (high - low)) * slow))  # the filter's own length
    pieces = []
    for spectrum, size in zip(spectra, sizes, strict=True):
        piece = _heard(_cut(spectrum, center, reach, length)[skip : int(size / rate * slow)])
        if len(piece) >= _SHORTEST:
            pieces.append(piece)
    if not pieces:
        return np.zeros(0, np.complex128)
    lags = min(LAGS, min(map(len, pieces)) // 2)
    poles = np.log(_rotation(pieces, lags), dtype=np.complex128) * slow
    frequency, decay = center * rate / length + poles.imag / (2 * np.pi), -poles.real
    fits = (frequency >= max(low, LOWEST)) & (frequency < high)
    fits &= (decay > _LEAST) & (decay < min(_MOST_DECAY, 2 * (high - low)))
    return (-decay[fits] + 2j * np.pi * frequency[fits]).astype(np.complex128) / rate


def _cut(spectrum: Complex, center: int, reach: int, length: int) -> Complex:
    """Return the analytic signal of a band, shifted to 0 Hz and decimated to 2 `reach` samples of the whole length."""
    offset = np.arange(-reach, reach)
    share = np.abs(offset) / reach
    flank = 0.5 + 0.5 * np.cos(np.pi * (share - _FLAT) / (_END - _FLAT))
    weight = np.where(share < _FLAT, 1, np.where(share < _END, flank, 0))
    place = center + offset
    # Below 0 Hz the spectrum of a real signal goes on as the conjugate of what is above.
    values = np.where(place >= 0, spectrum[np.clip(place, 0, length // 2)], spectrum[np.clip(-place, 0, None)].conj())
    return np.fft.ifft(np.fft.ifftshift(values * weight)) * (2 * reach / length)


def _heard(piece: Complex) -> Complex:
    """Return a band's signal down to its own noise floor."""
    if len(piece) < _SHORTEST:
        return piece
    width = max(4, len(piece) // 60)
    power = np.convolve(np.abs(piece) ** 2, np.ones(width) / width, "same")
    floor = np.median(power[-max(4, len(power) // 10) :])
    above = np.flatnonzero(power > _ABOVE_FLOOR * floor)
    return piece[: max(int(above[-1]) + width, _SHORTEST)] if above.size else piece


def _covariance(piece: Complex, lags: int) -> Complex:
    """Return sum_t x[i + t] x*[j + t] over a signal's copies, by i, j < lags.

    A step up its diagonals is one product more at the beginning and one less at the end. What decays is summed from its
    end on, so that little is rounded.
    """
    count = len(piece) - lags + 1
    column = np.correlate(piece, piece[lags - 1 :], "valid")
    found = np.empty((lags, lags), np.complex128)
    found[:, -1], found[-1] = column, column.conj()
    first, last = piece[: lags - 1], piece[count:]
    steps = np.outer(first, first.conj()) - np.outer(last, last.conj())
    for n in reversed(range(lags - 1)):
        found[n, :-1] = found[n + 1, 1:] + steps[n]
    return found


def _rotation(pieces: list[Complex], lags: int) -> Complex:
    """Return the poles per decimated sample that span the signals' space, as many as rise above its noise."""
    covariance = sum(_covariance(piece, lags) for piece in pieces)
    powers, vectors = np.linalg.eigh(covariance)
    powers, vectors = powers[::-1], vectors[:, ::-1]
    noise = np.median(powers[lags // 2 :])
    count = int(np.clip(np.sum(powers > max(noise * _ABOVE_NOISE, powers[0] * _DYNAMIC)), 1, MOST_IN_BAND))
    space = vectors[:, :count]
    rotation = np.linalg.lstsq(space[:-1], space[1:], rcond=None)[0]
    poles = np.linalg.eigvals(rotation).astype(np.complex128)
    return poles[np.abs(poles) > 0]
