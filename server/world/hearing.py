"""Where the sound is heard, and what of it is: microphones, and contacts that are too faint to be computed."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .bodies import WorldError
from .shapes import Vector

NEAREST = 0.1
"""m: a body that is nearer to a microphone is as loud as at this distance."""
_CHANGED = 0.03  # share by which a gain changes before it is told: 0.26 dB
_RECENT = 0.1  # s: what was louder so lately hides what is fainter


class Microphone(NamedTuple):
    """A microphone: its position (m); the direction in which it points, None for one that hears alike all around; and
    its pattern, 0 all around, 0.5 a cardioid, 1 a figure of eight."""

    position: Vector
    direction: Vector | None = None
    pattern: float = 0.5


@dataclass(frozen=True)
class Hearing:
    """What is computed of a simulation, and where it is heard.

    microphones: one for each channel. faintest: dB over 20 µPa, below which a contact is left out. masked: dB by which
    it may lie below what was heard within 0.1 s. blows: the most in 50 ms; gestures: the most that slip or sweep at
    once; the loudest are taken. seed: of the surfaces on which bodies slide and roll.
    """

    microphones: Sequence[Microphone] = (Microphone((0.0, 0.0, 1.5)),)
    faintest: float = 0.0
    masked: float = 70.0
    blows: int = 200
    gestures: int = 24
    seed: int = 0

    def __post_init__(self) -> None:
        if not 1 <= len(self.microphones) <= 64:
            raise WorldError(f"microphones: {len(self.microphones)} of them: expected 1 to 64")
        for number, microphone in enumerate(self.microphones):
            for name, vector in (("position", microphone.position), ("direction", microphone.direction)):
                if vector is not None and not (len(vector) == 3 and all(map(math.isfinite, vector))):
                    raise WorldError(f"microphone {number}: {name} = {vector}: expected three numbers")
            if not 0.0 <= microphone.pattern <= 1.0:
                raise WorldError(f"microphone {number}: pattern = {microphone.pattern}: expected 0 to 1")


class Listener:
    """The gains of bodies in each channel, and whether a contact is heard."""

    def __init__(self, hearing: Hearing) -> None:
        self.hearing = hearing
        self._positions = np.array([each.position for each in hearing.microphones], np.float64)
        directions = [each.direction or (0.0, 0.0, 0.0) for each in hearing.microphones]
        lengths = np.linalg.norm(directions, axis=1, keepdims=True)
        self._directions = np.array(directions) / np.where(lengths > 0, lengths, 1.0)
        patterns = [each.pattern if each.direction is not None else 0.0 for each in hearing.microphones]
        self._pattern = np.array(patterns, np.float64)
        self._faintest = 20e-6 * 10.0 ** (hearing.faintest / 20.0)
        self._masked = 10.0 ** (-hearing.masked / 20.0)
        self._loudest = 0.0
        self._loudest_at = -math.inf

    def gains(self, positions: NDArray[np.float64]) -> NDArray[np.float64]:
        """The gains (n, channels) of bodies at positions (n, 3): 1/r, times what each microphone hears from there."""
        way = positions[:, None] - self._positions
        distance = np.maximum(np.sqrt((way**2).sum(axis=2)), NEAREST)
        cosine = (way * self._directions).sum(axis=2) / distance
        heard: NDArray[np.float64] = (1.0 - self._pattern + self._pattern * cosine) / distance
        return heard

    def is_heard(self, pressure: float, time: float) -> bool:
        """Whether a contact of a pressure (Pa rms at a microphone) is heard at a time (s), after those asked of."""
        hidden = self._loudest * self._masked if time - self._loudest_at < _RECENT else 0.0
        if pressure < max(self._faintest, hidden):
            return False
        if pressure >= self._loudest or time - self._loudest_at >= _RECENT:
            self._loudest, self._loudest_at = pressure, time
        return True


@dataclass
class Placing:
    """The gains that were told of each body, (bodies, channels); NaN where none were."""

    told: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 0)))

    def changed(self, gains: NDArray[np.float64]) -> NDArray[np.intp]:
        """The bodies whose gains (n, channels) are others than those told; they are told now."""
        if self.told.shape != gains.shape:
            before = self.told
            self.told = np.full(gains.shape, np.nan)
            if before.shape[1:] == gains.shape[1:]:
                self.told[: len(before)] = before
        size = np.abs(self.told).max(axis=1, keepdims=True)
        near = np.abs(gains - self.told) <= _CHANGED * size
        found = np.flatnonzero(~near.all(axis=1))
        self.told[found] = gains[found]
        return found
