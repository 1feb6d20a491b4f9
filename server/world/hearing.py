"""Where the sound is heard, and what of it is: microphones, and contacts that are too faint to be computed."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...dsp.tracking.microphones import MICROPHONE_STATE
from ...dsp.tracking.track import place
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
    """Decides whether a contact is heard."""

    def __init__(self, hearing: Hearing) -> None:
        self.hearing = hearing
        self._faintest = 20e-6 * 10.0 ** (hearing.faintest / 20.0)
        self._masked = 10.0 ** (-hearing.masked / 20.0)
        self._loudest = 0.0
        self._loudest_at = -math.inf

    def is_heard(self, pressure: float, time: float) -> bool:
        """Whether a contact of a pressure (Pa rms at a microphone) is heard at a time (s), after those asked of."""
        hidden = self._loudest * self._masked if time - self._loudest_at < _RECENT else 0.0
        if pressure < max(self._faintest, hidden):
            return False
        if pressure >= self._loudest or time - self._loudest_at >= _RECENT:
            self._loudest, self._loudest_at = pressure, time
        return True


class Placing:
    """The gains of bodies in each channel, 1/r times what the microphone hears from there: as they are, and as they
    were told of those that sound. state: the tracker's memory."""

    def __init__(self, hearing: Hearing, state: NDArray[np.void]) -> None:
        self.microphones = np.zeros(1, MICROPHONE_STATE)
        """(1,) of MICROPHONE_STATE."""
        record = self.microphones[0]
        record["count"] = count = len(hearing.microphones)
        record["nearest"], record["step"] = NEAREST, _CHANGED
        for n, microphone in enumerate(hearing.microphones):
            record["position"][n] = microphone.position
            length = math.hypot(*microphone.direction) if microphone.direction else 0.0
            if microphone.direction and length:
                record["direction"][n] = np.array(microphone.direction) / length
                record["pattern"][n] = microphone.pattern
        record["told"] = np.nan
        self.loudest: NDArray[np.float64] = record["loudest"]
        """The gain of each body at the microphone that hears it best."""
        self._until, self._next, self._changed = record["until"], self.microphones["next"], record["changed"]
        self._now = record["now"][:, :count]
        self._addresses = self.microphones.ctypes.data, state.ctypes.data
        self._kept, self._place = state, place.bare
        self.silence()

    def silence(self) -> None:
        """Nothing sounds."""
        self._until[:] = -math.inf
        self._next[0] = math.inf

    def look_at(self, time: float) -> None:
        """Have bodies looked at in the step after a time (s)."""
        self._next[0] = time

    def sounds(self, body: int, until: float) -> None:
        """A body sounds, until a time (s)."""
        self._until[body] = until

    def look(self) -> list[tuple[int, list[float]]]:
        """The bodies that sound and whose gains are others than those told, with these."""
        count = self._place(*self._addresses)
        return [(n, self._now[n].tolist()) for n in self._changed[:count].tolist()]
