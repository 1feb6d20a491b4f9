"""Sounds whose partials glide in pitch together, as a struck head's do, wound to one pitch.

A blow stretches a head, and its tension falls with what rings: f^2 = f0^2 (1 + a exp(-s t)) for all partials. f0, a and
s are fitted to the frequency of the lowest partial. The sound is read at the places where that partial is as far on as
it would be at f0: then a partial stays within the band in which its decay is looked at. Late times keep their pace,
the first tenth of a second is stretched by as much as the pitch is higher there.
"""

import numpy as np
from scipy.optimize import least_squares

WIDTH = 0.22  # octaves of the Gaussian band about the lowest partial
HOP, FIRST, LAST = 0.005, 0.005, 1.0  # s: between frequencies, and where they are taken
FAINTEST = -30.0  # dB under the loudest
NEARLY = 0.02  # of the frequency: what is farther off counts less


def glide(samples: np.ndarray, rate: float, lowest: float) -> tuple[float, float, float]:
    """Return f0 (Hz), a and s (1/s) of the partial near `lowest` (Hz)."""
    size = 2 * len(samples)
    octaves = np.log2(np.fft.rfftfreq(size, 1 / rate).clip(1.0) / lowest)
    part = np.fft.rfft(samples, size) * np.exp(-0.5 * (octaves / WIDTH) ** 2)
    analytic = np.zeros(size, complex)
    analytic[: len(part)] = 2 * part
    analytic = np.fft.ifft(analytic)[: len(samples)]
    turned, hop = analytic[1:] * analytic[:-1].conj(), round(HOP * rate)
    turned = turned[: turned.size // hop * hop].reshape(-1, hop).sum(axis=1)
    time, weight = (np.arange(turned.size) + 0.5) * hop / rate, np.sqrt(np.abs(turned) / np.abs(turned).max())
    keep = (weight > 10 ** (FAINTEST / 20)) & (time > FIRST) & (time < LAST)
    time, weight, found = time[keep], weight[keep], np.angle(turned[keep]) * rate / (2 * np.pi)

    def off(unknowns: np.ndarray) -> np.ndarray:
        f0, log_a, log_s = unknowns
        return np.asarray((f0 * np.sqrt(1 + np.exp(log_a - np.exp(log_s) * time)) - found) / lowest * weight)

    begin, bounds = [0.95 * lowest, -1.0, 2.0], ([0.6 * lowest, -7.0, 0.0], [1.3 * lowest, 0.7, 4.0])
    fit = least_squares(off, begin, loss="soft_l1", f_scale=NEARLY, bounds=bounds)
    return float(fit.x[0]), float(np.exp(fit.x[1])), float(np.exp(fit.x[2]))


def unwound(samples: np.ndarray, rate: float, lowest: float) -> np.ndarray:
    """Return a sound without the glide that its partial near `lowest` (Hz) has."""
    _, a, s = glide(samples, rate, lowest)
    passed = np.cumsum(np.sqrt(1 + a * np.exp(-s * np.arange(len(samples)) / rate))) / rate
    passed -= passed[0]
    return np.interp(np.arange(0.0, passed[-1], 1 / rate), passed, samples)
