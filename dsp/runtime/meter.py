"""The level meter as Python reads it."""

import math

import numpy as np
from numpy.typing import NDArray

from ..engine.memory.meter_record import METERED, WINDOW, k_weighting
from ..engine.memory.state import QUANTUM

SILENCE = -200.0
"""dB: what counts as silence."""
OFFSET = -0.691
"""LUFS of a weighted mean square of 1, as ITU-R BS.1770 has it."""


class Meter:
    """A meter of an engine's output: `start` it, and it shows the last 0.4 s."""

    def __init__(self, record: np.void) -> None:
        """Prepare to meter the engine of `record`, of STATE."""
        self._record, self._meter = record, record["meter"]
        self._rate, self._channels = float(record["rate"]), int(record["output"]["channels"])
        self._window = round(WINDOW * self._rate / QUANTUM)

    def start(self) -> None:
        """Measure from here on."""
        self._meter["shelf"], self._meter["high_pass"] = k_weighting(self._rate)
        self._meter["on"] = 1

    def peaks(self, since: int = 0) -> list[float]:
        """Return the highest amplitude of each channel, dB of full scale; `since`: a sample that may cut the 0.4 s
        short."""
        places = self._places(since)
        peaks = self._meter["peak"][places, : self._channels].max(axis=0, initial=0.0)
        return [decibels(float(peak) ** 2) for peak in peaks]

    @property
    def loudness(self) -> float:
        """Momentary loudness, LUFS."""
        return OFFSET + decibels(float(self._meter["power"][self._places()].sum()) / self._window)

    def _places(self, since: int = 0) -> NDArray[np.int64]:
        """Return the quanta of the last 0.4 s, those before a sample left out."""
        end = int(self._record["position"]) // QUANTUM
        return np.arange(max(0, end - self._window, since // QUANTUM), end) % METERED


def decibels(square: float) -> float:
    """Return the level of a squared amplitude, dB."""
    return 10.0 * math.log10(square) if square > 10.0 ** (SILENCE / 10.0) else SILENCE
