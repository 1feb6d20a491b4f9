"""Contacts as they are played, for whoever watches: a report of each blow, and of what touches on, as it goes on."""

from collections import OrderedDict
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..dsp.engine.memory.state import PUSHED

_BLOW = 0.1  # s: what touches for longer is reported as it goes on
_MOST_FORCES = 2_048  # samples of a contact whose force is kept
_MOST_OPEN = 2_048  # contacts


@dataclass
class Touching:
    """A contact: its gesture's number and its object's place, where and when (samples) it began, and what it gave."""

    gesture: int
    slot: int
    position: float
    speed: float
    """m/s, at which striker and object met, or along the surface."""
    velocity: float
    """m/s, of the striker then, towards the object."""
    begin: float
    end: float = 0.0
    impulse: float = 0.0
    """N s."""
    force: list[float] = field(default_factory=list)
    """N, its mean over each sample."""
    goes_on: bool = False
    """True if the contact lasts: then place and speed are the latest."""
    strength: float = 0.0
    """N, the force's rms since the last report of one that lasts."""


class ContactWatch:
    """Puts together the samples of contacts that an engine traces."""

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._open: OrderedDict[int, Touching] = OrderedDict()
        self.lost = 0
        """Contacts that were left out, as too many went on."""

    def look(self, trace: NDArray[np.void]) -> tuple[list[Touching], list[Touching]]:
        """Return the blows that are over, and what touches on, by what was traced since the last call."""
        pushed = np.flatnonzero(trace["kind"] == PUSHED)
        order = pushed[np.argsort(trace["contact"][pushed], kind="stable")]
        numbers = trace["contact"][order]
        starts = np.flatnonzero(np.diff(numbers, prepend=-1))
        runs = dict(zip(numbers[starts].tolist(), np.split(order, starts[1:]), strict=False))
        over = [number for number in self._open if number not in runs]
        blows = [each for each in map(self._open.pop, over) if not each.goes_on]
        on = []
        for number, run in runs.items():
            touching = self._open.get(number)
            if touching is None:
                if len(self._open) >= _MOST_OPEN:
                    self.lost += 1
                    continue
                first = trace[run[0]]
                touching = self._open[number] = Touching(
                    int(first["gesture"]), int(first["slot"]), float(first["position"]), float(first["speed"]),
                    float(first["velocity"]), float(first["begin"]),
                )  # fmt: skip
            self._add(touching, trace, run)
            if touching.goes_on:
                on.append(touching)
        return blows, on

    def _add(self, touching: Touching, trace: NDArray[np.void], run: NDArray[np.int64]) -> None:
        """Add the entries of a contact, in their order."""
        impulse, last = trace["impulse"][run], trace[run[-1]]
        touching.goes_on = touching.goes_on or float(last["end"]) - touching.begin > _BLOW * self._rate
        if touching.goes_on:
            touching.strength = float(np.sqrt(np.mean(np.square(impulse))) * self._rate)
            touching.position, touching.speed = float(last["position"]), float(last["speed"])
        elif len(touching.force) < _MOST_FORCES:
            touching.force += (impulse * self._rate).tolist()
        touching.impulse += float(impulse.sum())
        touching.end = float(last["end"])


def thinned(values: list[float], most: int) -> list[float]:
    """Thin values out to at most so many: the highest of each of as many equal pieces."""
    if len(values) <= most:
        return values
    return [float(piece.max()) for piece in np.array_split(np.asarray(values), most)]
