"""Scenes in which the objects of an item stand, kept for other items that have the same ones."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from functools import cache

from ...dsp.runtime.fresh import Mark
from ...presets import Presets
from ...server.osc.wire import Message
from ...server.render import Options
from ..performer import Performer
from .truth import AMPLIFIED

_MOST = 32  # scenes, of 1 MB each
_MOST_ASKED = 1_024  # keys that are remembered, of scenes that may be asked for again
_MOST_MISSED = 512  # scenes that would have been kept, if others were not


class Scene:
    """A scene that plays one item, in which messages at 0 s were carried out: as a rule those that make its objects."""

    def __init__(self, rate: int, channels: int, made: Sequence[Message], presets: Presets) -> None:
        """Take the scene that is kept, or make one. presets: their files do not change. CommandError says what was
        refused."""
        self._key = rate, channels, presets, tuple(made)
        self._mark: Mark | None
        if kept := _kept.pop(self._key, None):  # nobody else has it meanwhile
            self.performer, self._mark = kept
            return
        self.performer = _made(rate, channels, made, presets)
        self._mark = self.performer.mark() if made and _is_worth_it(self._key) else None

    def give(self) -> None:
        """Keep the scene, if it is worth it. Its gestures made no objects, and changed none."""
        if self._mark:
            try:
                self.performer.rewind(self._mark)
            except OSError:
                return
            _kept[self._key] = self.performer, self._mark


_kept: dict[Hashable, tuple[Performer, Mark]] = {}
_asked: dict[Hashable, None] = {}
_missed: list[Hashable] = []


def _is_worth_it(key: Hashable) -> bool:
    """True if a scene is asked for again, and there is room for it. Where many are not kept for others, all go."""
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
