"""Scenes in which the objects of an item stand, kept for other items that have the same ones."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from functools import cache, lru_cache

from ...dsp.runtime.fresh import Mark
from ...presets import Presets
from ...server.osc.wire import Message
from ...server.render import Options
from ...server.scene.repeated import Blow, Repeated
from ..performer import Performer
from .truth import AMPLIFIED, Told, told_of

_MOST = 32  # scenes, of 1 MB each
_MOST_ASKED = 1_024  # keys that are remembered, of scenes that may be requested again
_MOST_MISSED = 512  # scenes that would have been kept, if others were not


class Scene:
    """A scene that plays one item, in which messages at 0 s were carried out: as a rule those that make its objects."""

    def __init__(
        self, key: Hashable, performer: Performer, mark: Mark | None, blows: dict[Hashable, Blow] | None
    ) -> None:
        """Take what plays it, where it is brought back to, None: nowhere, and the blows of such scenes, None: they are
        not remembered."""
        self.performer = performer
        self._key, self._mark = key, mark
        self._objects: dict[str, Told] = {}
        self._blows = Repeated(performer.scene, blows) if blows is not None else None

    def objects(self) -> Mapping[str, Told]:
        """Return, by name, the truth of the objects that are there: once they were heard, and found once for all
        items if it is kept."""
        if not self._objects or not self._mark:
            rate = int(self.performer.engine.rate)
            told = ((name, told_of(self.performer, rate, name)) for name in self.performer.scene.objects)
            self._objects = {name: each for name, each in told if each}
        return self._objects

    def perform(self, messages: Sequence[Message], at: float) -> None:
        """Carry out messages together at a time (s). CommandError says what was refused, and why."""
        if not self._blows or len(messages) > 1:
            self.performer.perform(messages, at)
        elif not self.performer.repeat(self._blows, messages[0], at):
            self.performer.perform(messages, at)
            self._blows.remember(messages[0])

    def give(self) -> None:
        """Keep the scene, if it is worth it. Its gestures made no objects, and changed none."""
        if self._mark:
            try:
                self.performer.rewind(self._mark)
            except OSError:
                return
            _kept[self._key] = self


def scene_for(rate: int, channels: int, made: Sequence[Message], presets: Presets) -> Scene:
    """Take the scene that is kept, or make one. presets: their files do not change. CommandError says what was
    refused."""
    key = rate, channels, presets, tuple(made)
    if kept := _kept.pop(key, None):  # nobody else has it meanwhile
        return kept
    performer = _made(rate, channels, made, presets)
    mark = performer.mark() if made and _is_worth_it(key) else None
    blows = _blows(rate, channels, presets, *map(_sizeless, made)) if made and performer.is_untouched else None
    return Scene(key, performer, mark, blows)


@lru_cache(maxsize=_MOST)
def _blows(*told: Hashable) -> dict[Hashable, Blow]:
    """Return what is remembered of blows in scenes that keep them."""
    return {}


def _sizeless(made: Message) -> Hashable:
    """Return what a message says of the object that it makes, but for its size."""
    pairs = zip(made.args[2::2], made.args[3::2], strict=True)
    return (*made.args[:2], *(pair for pair in pairs if pair[0] != "size"))


_kept: dict[Hashable, Scene] = {}
_asked: dict[Hashable, None] = {}
_missed: list[Hashable] = []


def _is_worth_it(key: Hashable) -> bool:
    """True if a scene is requested again, and there is room for it. Where many are not kept for others, all go."""
    if len(_asked) >= _MOST_ASKED:
        _asked.clear()
    if key not in _asked:
        _asked[key] = None
        return False
    if len(_kept) < _MOST:
        return True
    _missed.append(key)
    if len(_missed) >= _MOST_MISSED:
        _missed.clear()
        _kept.clear()
    return False


def _made(rate: int, channels: int, made: Sequence[Message], presets: Presets) -> Performer:
    """Return a new scene in which messages were carried out."""
    options = options_of(rate, channels)
    performer = Performer(options, (), presets, stems=False, contacts=True, steers_ended=True, amplified=AMPLIFIED)
    head = options.head
    for message in made:
        performer.perform([*head, message], 0.0)
        head = []
    return performer


@cache
def options_of(rate: int, channels: int) -> Options:
    """Return how items are rendered."""
    return Options(rate, calibrated=True, channels=channels)
