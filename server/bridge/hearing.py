"""Hearing of a simulation: microphones, and contacts that are too faint to be computed."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...dsp.arguments import explain_all_arguments
from ...dsp.contact.accuracy import DEFAULT, LEVELS, NUMBERS
from ...dsp.engine.memory.state import Quality
from ...dsp.numerics.quantities import Range
from ...dsp.wording import expected
from .checks import WorldError, require_number
from .rows import FARTHEST
from .shapes import Vector
from .tracking.microphones import MICROPHONE_STATE

NEAREST = 0.1
"""m: a body that is nearer to a microphone is as loud as at this distance."""
_LEVEL, _COUNT, _PATTERN = Range(-1000.0, 1000.0, "dB"), Range(0, 10**9), Range(0.0, 1.0)
_MOST_QUALITY = int(max(Quality))
GAIN_STEP = 0.03
"""Share by which a gain changes before it is sent: 0.26 dB."""


@explain_all_arguments
class Microphone(NamedTuple):
    """A microphone in the world of a simulation.

    Attributes
    ----------
    position : (x, y, z)
        In m.
    direction : (x, y, z), optional
        Direction in which it points. Default: it hears alike all around.
    pattern : float, default 0.5
        0 all around, 0.5 a cardioid, 1 a figure of eight.
    on : str, optional
        Body on which it rides, in whose axes position and direction are.
    """

    position: Vector
    direction: Vector | None = None
    pattern: float = 0.5
    on: str = ""


@explain_all_arguments
class Listener(NamedTuple):
    """A listener in the world of a simulation, with delay, doppler, air and direction.

    Attributes
    ----------
    position : (x, y, z), default (0, 0, 1.5)
        In m.
    yaw, pitch, roll : float, default 0
        Turns to the left, down and to the right, degrees, from looking along x with z up.
    layout : {"binaural", "pan", "ambisonics"}
        Way in which directions become channels: two, two, or (order + 1)^2.
    order : int, default 1
        Order of ambisonics, 1 to 3.
    on : str, optional
        Body on which it rides, in whose axes all this is.
    floor : float, optional
        Height of a floor that reflects, m.
    room : dict, optional
        Arguments of `/room`.
    """

    position: Vector = (0.0, 0.0, 1.5)
    yaw: float = 0.0
    pitch: float = 0.0
    roll: float = 0.0
    layout: str = "binaural"
    order: int = 1
    on: str = ""
    floor: float | None = None
    room: Mapping[str, float] | None = None

    @property
    def channels(self) -> int:
        """Number of channels that carry the directions."""
        return (self.order + 1) ** 2 if self.layout == "ambisonics" else 2


@explain_all_arguments
@dataclass(frozen=True)
class Hearing:
    """Settings of a World: how much of a simulation is computed, and where it is heard.

    Attributes
    ----------
    microphones : list of Microphone or (x, y, z)
        A channel for each.
    faintest : float, default 0
        Level below which a contact is left out, dB over 20 uPa.
    masked : float, default 70
        Distance below the sound of the last 0.1 s at which a contact is left out, dB.
    blows : int, default 200
        Largest number of blows in 50 ms; the loudest are taken.
    gestures : int, default 24
        Largest number of slides and rolls at once.
    rests : int, default 4
        Largest number of rests at once; 0: bodies that lie ring as if they hung.
    seed : int, default 0
        Seed of the surfaces on which bodies slide and roll.
    accuracy : {"-60", "-50", "-80", "exact"}
        Accuracy of blows, as `/accuracy` sets it; a server keeps its own.
    quality : int, default 0
        0 (everything) to 8, as `/quality` sets it; a server keeps its own. At 3 rolls and slides have fewer
        micro-impacts.
    """

    microphones: Sequence[Microphone] = (Microphone((0.0, 0.0, 1.5)),)
    faintest: float = 0.0
    masked: float = 70.0
    blows: int = 200
    gestures: int = 24
    rests: int = 4
    seed: int = 0
    accuracy: str | int = LEVELS[DEFAULT]
    quality: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "microphones", microphones_of(self.microphones))
        if not 1 <= len(self.microphones) <= 64:
            raise WorldError(f"microphones: {len(self.microphones)} of them: expected 1 to 64")
        for name in ("faintest", "masked"):
            require_number(name, getattr(self, name), _LEVEL)
        for name in ("blows", "gestures", "rests"):
            require_number(name, getattr(self, name), _COUNT)
        if str(self.accuracy) not in NUMBERS:
            raise WorldError(f"accuracy = {self.accuracy}: {expected(self.accuracy, LEVELS)}")
        if self.quality not in range(_MOST_QUALITY + 1):
            raise WorldError(f"quality = {self.quality!r}: expected a whole number from 0 to {_MOST_QUALITY}")
        for number, microphone in enumerate(self.microphones):
            _check(f"microphone {number}", microphone)


def _check(which: str, microphone: Microphone) -> None:
    """Raise WorldError for a microphone that can't be."""
    for name, vector in (("position", microphone.position), ("direction", microphone.direction)):
        if vector is not None and not _is_vector(vector):
            raise WorldError(f"{which}: {name} = {vector!r}: expected three numbers")
    if microphone.direction is not None and not any(microphone.direction):
        raise WorldError(f"{which}: direction = {microphone.direction}: expected a vector that is not 0, or None")
    require_number(f"{which}: pattern", microphone.pattern, _PATTERN)


def _is_vector(value: object) -> bool:
    """True for three numbers up to FARTHEST."""
    if not isinstance(value, Sequence | np.ndarray) or len(value) != 3:
        return False
    return all(isinstance(each, Real) and abs(float(each)) <= FARTHEST for each in value)


def microphones_of(given: Sequence[Microphone | Sequence[float]]) -> tuple[Microphone, ...]:
    """Return microphones, of which some may be places (m)."""
    if not isinstance(given, Iterable):
        raise WorldError(f"microphones = {given!r}: expected Microphones or places (m)")
    return tuple(map(_microphone, given))


def _microphone(given: Microphone | Sequence[float]) -> Microphone:
    if isinstance(given, Microphone):
        return given
    try:
        x, y, z = given
        return Microphone((float(x), float(y), float(z)))
    except (TypeError, ValueError):
        raise WorldError(f"microphones: {given!r}: expected a Microphone or a place, three numbers (m)") from None


def begin_hearing(hearing: Hearing, state: NDArray[np.void]) -> NDArray[np.void]:
    """Write into the tracker's memory what is heard; (1,) of MICROPHONE_STATE, the microphones."""
    state["faintest"], state["masked"] = 20e-6 * 10.0 ** (hearing.faintest / 20.0), 10.0 ** (-hearing.masked / 20.0)
    state["most"], state["most_blows"], state["most_rests"] = hearing.gestures, hearing.blows, hearing.rests
    made = np.zeros(1, MICROPHONE_STATE)
    record = made[0]
    record["count"] = len(hearing.microphones)
    record["nearest"], record["step"] = NEAREST, GAIN_STEP
    for n, microphone in enumerate(hearing.microphones):
        record["position"][n] = microphone.position
        if microphone.direction is not None:
            record["direction"][n] = np.array(microphone.direction) / math.hypot(*microphone.direction)
            record["pattern"][n] = microphone.pattern
    record["told"], record["next"] = np.nan, np.inf
    return made
