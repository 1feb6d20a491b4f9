"""News for subscribers of /notify as it happens: objects that come and go, contacts, levels."""

import time
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from ..dsp.runtime.engine import Engine
from ..dsp.runtime.meter import decibels
from ..dsp.spectral.places import levels_of
from .contact_watch import ContactWatch, Touching, thinned
from .net.network import Source
from .osc.wire import Message
from .scene.session import Session
from .subscribers import Subscribers

CHANGES, LEVELS = 2, 3
"""Levels of /notify from which on contacts, and levels, are reported."""
_MOST_BLOWS = 64  # reported at a look
_MOST_SAMPLES = 1 << 16  # of contacts that are looked at: 70 may go on all the time; more would take too long
_MOST_FORCES = 128  # values of a force
_MOST_MODES = 12  # of an object that are reported
_MOST_LEVELS = 48  # objects
_SOFTEST = 1e-10  # squared amplitude of a mode that is reported
_PERIOD = 0.04  # s between levels


class Teller:
    """Looks at an engine and notifies subscribers. `look` often."""

    def __init__(
        self,
        engine: Engine,
        session: Session,
        subscribers: Subscribers,
        reply: Callable[[Message, Source], object],
        lowest_gain: Callable[[], float],
    ) -> None:
        """Begin with nothing to report. lowest_gain: returns the limiter's lowest gain since the last call."""
        self._engine = engine
        self._lowest_gain = lowest_gain
        self._metered = 0  # samples up to which peaks were reported
        self._session = session
        self._subscribers = subscribers
        self._reply = reply
        self._watch: ContactWatch | None = None
        self._there: dict[str, str] = {}
        self._due = 0.0
        self._dropped = 0

    @property
    def dropped(self) -> int:
        """Contacts that were not reported, as there were too many."""
        return self._dropped + (self._watch.lost if self._watch else 0)

    def look(self) -> dict[str, str]:
        """Report what is new; return the objects that are there, with the names of their presets."""
        there = {name: self._session.objects[name].preset.name for name in self._session.objects.there(0.0)}
        self._tell_objects(there)
        self._tell_contacts(self._subscribers.of(CHANGES))
        now = time.monotonic()
        if now >= self._due and (listeners := self._subscribers.of(LEVELS)):
            self._due = now + _PERIOD
            for message in self._levels(there):
                self._tell(message, listeners)
        return there

    def _tell(self, message: Message, listeners: list[Source]) -> None:
        for listener in listeners:
            self._reply(message, listener)

    def _tell_objects(self, there: dict[str, str]) -> None:
        if there == self._there:
            return
        listeners = self._subscribers.of(CHANGES)
        for name in (name for name in self._there if name not in there):
            self._tell(Message("/object.removed", (name,)), listeners)
        for name in (name for name in there if name not in self._there):
            self._tell(Message("/object.added", (name, there[name])), listeners)
        self._there = there

    def _tell_contacts(self, listeners: list[Source]) -> None:
        if not listeners:
            if self._watch:
                self._engine.trace(False)
                self._watch = None
            return
        if self._watch is None:
            self._watch = ContactWatch(self._engine.rate)
            self._engine.traced()  # what is left of an earlier time
            self._engine.trace(True)
        trace = self._engine.traced(_MOST_SAMPLES)
        blows, on = self._watch.look(trace)
        self._dropped += max(0, len(blows) - _MOST_BLOWS) + (len(trace) == _MOST_SAMPLES)
        for blow in blows[-_MOST_BLOWS:]:
            seconds = (blow.end - blow.begin) / self._engine.rate
            told = (*self._head(blow, blow.begin), blow.impulse, seconds, blow.velocity)
            self._tell(Message("/hit", told), listeners)
        for touching in on[-_MOST_BLOWS:]:
            self._tell(Message("/touch", (*self._head(touching, touching.end), touching.strength)), listeners)
        if blows and (watchers := self._subscribers.of(LEVELS)):
            force = thinned(blows[-1].force, _MOST_FORCES)
            span = len(blows[-1].force) / self._engine.rate
            self._tell(Message("/force", (self._name(blows[-1]), span, *force)), watchers)

    def _head(self, touching: Touching, sample: float) -> tuple[str, str, int, float, float]:
        id = self._session.gestures.name_of(touching.gesture)
        return self._name(touching), id, round(sample), touching.position, touching.speed

    def _name(self, touching: Touching) -> str:
        return self._session.objects.slots.get(touching.slot, "")

    def _levels(self, there: Mapping[str, str]) -> list[Message]:
        """Return the levels of the output, of each object that sounds and of its loudest modes."""
        engine = self._engine
        stats = engine.stats
        counts = engine.position, stats.load, int(engine.quality), stats.limited, stats.contacts_active
        loudness, lowest, peaks = engine.meter.loudness, self._lowest_gain(), engine.meter.peaks(self._metered)
        self._metered = counts[0]
        messages = [Message("/meter", (*counts, loudness, decibels(lowest * lowest), *peaks))]
        for name in there:
            squares = mode_levels(engine, self._session.objects[name].handle.slot)
            loud = np.flatnonzero(squares > _SOFTEST)
            if len(loud):
                loudest = loud[np.argsort(-squares[loud])][:_MOST_MODES]
                pairs = [each for i in loudest.tolist() for each in (i, decibels(float(squares[i])))]
                messages.append(Message("/modes", (name, decibels(0.5 * float(squares.sum())), *pairs)))
            if len(messages) > _MOST_LEVELS:
                break
        return messages


def mode_levels(engine: Engine, slot: int) -> NDArray[np.float64]:
    """Return the squared amplitude at the output of each mode that an object in a place has and that rings, as it is
    now.

    The audio thread goes on meanwhile: a value may be off by what a mode does between two samples.
    """
    obj, bank = engine.objects[slot], engine.state["bank"][0]
    first = int(obj["first"])
    part = slice(first, first + min(int(obj["live"]), int(obj["felt"])))
    if obj["spectral"]:
        phase = int(obj["spectral"]) - 1
        squares = levels_of(engine.state["spectral"][0], phase, bank["bin"][part], bank["place"][part])
        return squares / float(obj["spectral_gain"]) ** 2
    y1, y2, a1, a2 = (bank[name][part] for name in ("y1", "y2", "a1", "a2"))
    scale = 4.0 * a2 + a1 * a1
    square = (y1 * y1 - a1 * y1 * y2 - a2 * y2 * y2) * 4.0 * a2
    level = np.divide(square, scale, out=np.zeros_like(square), where=scale != 0.0)
    return np.where(np.isfinite(level), np.maximum(level, 0.0), 0.0)
