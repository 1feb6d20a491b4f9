"""Hearing of a simulation: microphones, and contacts that are too faint to be computed."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...dsp.arguments import explain_all_arguments
from ...dsp.contact.accuracy import DEFAULT, LEVELS
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
_CHANGED = 0.03  # share by which a gain changes before it is told: 0.26 dB


@explain_all_arguments
class Microphone(NamedTuple):
    """A microphone in the world of a simulation.

    position: m. direction: in which it points, None for one that hears alike all around. pattern: 0 all around, 0.5 a
    cardioid, 1 a figure of eight. on: the body on which it rides, in whose axes position and direction then are.
    """

    position: Vector
    direction: Vector | None = None
    pattern: float = 0.5
    on: str = ""


@explain_all_arguments
class Listener(NamedTuple):
    """A listener in the world of a simulation, to whom sound takes its time: by distance, doppler, air and direction.

    position: m. yaw, pitch, roll: to the left, down, to the right (degrees), from looking along x with z up. layout:
    "pan" or "binaural", of two channels, or "ambisonics", of (order + 1)^2. on: the body on which it rides, in whose
    axes all this then is. floor: the height (m) of a floor that reflects. room: the keys of `/room`.
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
        """Number of channels that tell the directions."""
        return (self.order + 1) ** 2 if self.layout == "ambisonics" else 2


@explain_all_arguments
@dataclass(frozen=True)
class Hearing:
    """Settings: how much of a simulation is computed, and where it is heard.

    microphones: one for each channel, or its place (m). faintest: dB over 20 µPa, below which a contact is left out.
    masked: dB by which it may lie below what was heard within 0.1 s. blows: the most in 50 ms; gestures: the most that
    slip or sweep at once; the loudest are taken. rests: the most that lie on each other at once, so that they mute each
    other; those whose bodies sound come first; 0: bodies that lie ring as if they hung. seed: of the surfaces on which
    bodies slide and roll. accuracy: of blows, as `/accuracy` has it: "-40" (dB), "-50", "-60", "-80" or "exact"; a
    server keeps its own. quality: as `/quality` has it, 0 (everything) to 8; a server keeps its own. Rolls and slides
    cost most, nearly the same at any accuracy. At a quality of 3 they have fewer micro-impacts and take some 70 % of
    the time: bodies that stay on each other are within 1 dB, small ones that skip are up to 10 dB softer.
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
        if str(self.accuracy) not in LEVELS:
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
    """Tell the tracker's memory what is heard; (1,) of MICROPHONE_STATE, the microphones."""
    state["faintest"], state["masked"] = 20e-6 * 10.0 ** (hearing.faintest / 20.0), 10.0 ** (-hearing.masked / 20.0)
    state["most"], state["most_blows"], state["most_rests"] = hearing.gestures, hearing.blows, hearing.rests
    made = np.zeros(1, MICROPHONE_STATE)
    record = made[0]
    record["count"] = len(hearing.microphones)
    record["nearest"], record["step"] = NEAREST, _CHANGED
    for n, microphone in enumerate(hearing.microphones):
        record["position"][n] = microphone.position
        if microphone.direction is not None:
            record["direction"][n] = np.array(microphone.direction) / math.hypot(*microphone.direction)
            record["pattern"][n] = microphone.pattern
    record["told"], record["next"] = np.nan, np.inf
    return made
