"""A score as its engine's memory: what is laid out in it, and the commands that it gets, each at its sample.

The score is rendered. Before each block in which a line is due, what Python has written into the engine's memory is
kept: words that differ, and commands. Another engine of the same layout that gets both at the same samples makes the
same bits, without knowing what they mean.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...dsp.bodies.striker import StrikerSound
from ...dsp.engine.bodies.reshaping import HEAD, ROWS
from ...dsp.engine.memory.capacity import MODES, MOST_CHANNELS, OBJECTS
from ...dsp.engine.memory.commands import Kind
from ...dsp.engine.memory.state import RING, STATE, new_state
from ...dsp.runtime.arena import EngineFull
from ...dsp.runtime.engine import Engine
from ...presets import Presets
from ...presets.reshaping import Axes, Wanted, axes_of
from ...server.osc.score import Line, ScoreError
from ...server.osc.wire import Message
from ...server.render import Options, blocks, sensors_of
from ...server.scene.objects import PlayedObject
from ...server.scene.session import Session

Words = NDArray[np.uint64]
_WORD = np.dtype(np.uint64).itemsize
PULSES: int = STATE.fields["pulses"][1]  # type: ignore[index]
"""The place of the tables of pulses in the engine's memory, in bytes."""
PULSE_TABLES: int = STATE["pulses"].fields["left"][1]  # type: ignore[index]
"""Bytes of these tables without their values, and what an engine counts of them."""
SHAPES: int = STATE.fields["bank"][1] + STATE["bank"].fields["shape"][1]  # type: ignore[index]
"""The place of the mode shapes."""
PULSE_VALUES: int = PULSES + STATE["pulses"].fields["values"][1]  # type: ignore[index]
"""The place of their values."""


@dataclass(frozen=True)
class Patch:
    """Words of the engine's memory: the first, and their values."""

    first: int
    words: Words


@dataclass(frozen=True)
class Batch:
    """Changes of the engine's memory and commands that it gets before the block that begins at a sample."""

    at: int
    patches: list[Patch]
    commands: NDArray[np.void]


class MacroTable(NamedTuple):
    """The table of an object's macros: its first value among the mode shapes, and the changes by setting and place."""

    first: int
    axes: Axes


@dataclass
class Baked:
    """A baked score: what its memory has besides a fresh one's as it begins, its batches, its objects by name with the
    number of the command that makes each, and its sound, float32 (frames, channels)."""

    engine: Engine
    session: Session
    start: list[Patch]
    batches: list[Batch]
    sound: NDArray[np.float32]
    objects: dict[str, PlayedObject] = field(default_factory=dict)
    tables: dict[str, MacroTable] = field(default_factory=dict)
    """By object, where its body's macros can be turned live."""


class _Kept(Engine):
    """An engine that keeps what is written into its memory between its blocks."""

    def __init__(self, *sizes: Any, **more: Any) -> None:
        super().__init__(*sizes, **more)
        self.batches: list[Batch] = []
        self._before: Words | None = None
        self._sent = 0
        ring = STATE.fields["ring"]  # type: ignore[index]
        self._ring = slice(ring[1] // _WORD, (ring[1] + ring[0].itemsize) // _WORD)

    @property
    def words(self) -> Words:
        """The memory as words, without the tables of pulses, which come last."""
        return np.frombuffer(self.state, np.uint64, PULSES // _WORD)

    @property
    def pulse_words(self) -> Words:
        """The tables of pulses as words, without their values, which engines make of them."""
        return np.frombuffer(self.state, np.uint64, PULSE_TABLES // _WORD, PULSES)

    def lay_out_pulses(self, exponent: float, kept: Collection[float] = ()) -> dict[str, float]:
        """Make a table of pulses as every engine does; none makes room for another, as all of them are baked."""
        return super().lay_out_pulses(exponent, {*kept, *self.pulses.numbers})

    def look(self) -> None:
        """Look at the memory before something is written into it."""
        if self._before is None:
            self._before = self.words.copy()
            self._sent = self.sent

    def process(self, frames: int) -> NDArray[np.float32]:
        """Keep what was written since the last block, and compute the next one."""
        if self._before is not None:
            changed = self.words != self._before
            changed[self._ring] = False
            numbers = np.arange(self._sent, self.sent) % RING
            self.batches.append(Batch(self.position, _patches(self.words, changed), self.ring.entries[numbers].copy()))
            self._before = None
        return super().process(frames)


class _Session(Session):
    """A session that lets its engine look before it writes, and remembers the objects that it has made."""

    made: dict[str, PlayedObject]

    def perform(self, messages: Iterable[Message], time: float, source: Any = None) -> list[Message]:
        """Carry out messages, as every session does."""
        engine = self.engine
        assert isinstance(engine, _Kept)
        engine.look()
        replies = super().perform(messages, time, source)
        for name, obj in self.objects.items():
            self.made[name] = obj
        return replies


def bake(
    score: Sequence[Line],
    presets: Presets,
    options: Options,
    strikers: Iterable[StrikerSound] = (),
    warn: Callable[[str], object] = lambda text: None,
) -> Baked:
    """Render a score and return all commands to its engine; strikers: sounds that are laid out before.

    ScoreError names a line that is refused, or for which an engine of these sizes has no room.
    """
    options.lines_of(score)  # that there are some is asked before an engine is compiled
    channels = options.channels_of(score)
    sensors = sensors_of(score)
    if sensors > MOST_CHANNELS - channels:
        told = f"there are {channels} of sound and {sensors} of sensors"
        raise ScoreError(f"an export has {MOST_CHANNELS} channels: {told}")
    engine = _Kept(options.rate, channels, MODES, OBJECTS, limited=not options.calibrated, sensors=sensors)
    session = _Session(engine, presets, steers_ended=True, scale=options.scale_of(score))
    session.made = {}
    for striker in strikers:
        engine.lay_out_striker(striker)
    words = engine.words
    fresh = new_state(options.rate, channels)
    fresh[0]["output"]["sensors"], fresh[0]["output"]["delay"] = sensors, engine.delay
    start = _patches(words, words != fresh.view(np.uint64)[: len(words)])
    sound = np.concatenate(list(blocks(score, engine, presets, options, session, warn)))
    tables = _patches(engine.pulse_words, engine.pulse_words != 0)
    start += [Patch(PULSES // _WORD + each.first, each.words) for each in tables]
    return Baked(engine, session, start, engine.batches, sound, session.made)


def _patches(words: Words, changed: NDArray[np.bool_]) -> list[Patch]:
    """Return the runs of words that changed."""
    places = np.flatnonzero(changed)
    if not len(places):
        return []
    cuts = np.flatnonzero(np.diff(places) > 1) + 1
    runs = [(int(run[0]), int(run[-1]) + 1) for run in np.split(places, cuts)]
    return [Patch(first, words[first:end].copy()) for first, end in runs]


def lay_out_macros(baked: Baked, *, all_objects: bool) -> None:
    """Lay out the tables of the macros of all objects, else of those that the score shapes, or of the only one.

    A table is there from when its object is made. An object gets none where there is no room, or where another one's
    shapes have lain.
    """
    engine, scale = baked.engine, baked.session.scale
    written = [patch for batch in baked.batches for patch in batch.patches] + baked.start
    for name, obj in baked.objects.items():
        wanted = all_objects or len(baked.objects) == 1 or obj.shaped is not None
        if name in baked.tables or not wanted or not obj.modes.frequency.size:
            continue
        axes = axes_of(Wanted(obj.preset, obj.modes, engine.top_frequency, of_material=True))
        try:
            first = engine.lay_out_macros(obj.handle, obj.modes, scale.object(obj.preset), axes)
        except EngineFull:
            continue
        number, place = maker_of(baked, obj)
        size = int(baked.batches[number].commands[place]["layout"]["size"])
        begin, end = (SHAPES + 4 * value for value in (first, first + HEAD + ROWS * size))
        begin, end = begin // _WORD, -(-end // _WORD)
        if any(each.first < end and begin < each.first + len(each.words) for each in written):
            continue
        words = np.frombuffer(engine.state, np.uint64, end - begin, begin * _WORD).copy()
        baked.batches[number].patches.append(Patch(begin, words))
        baked.tables[name] = MacroTable(first, axes)


MAKES = int(Kind.NEW)
"""The kind of a command that makes an object."""


def maker_of(baked: Baked, obj: PlayedObject) -> tuple[int, int]:
    """Return the batch, and the place in it, of the command that made an object."""
    for number, batch in enumerate(baked.batches):
        made = (batch.commands["kind"] == MAKES) & (batch.commands["serial"] == obj.handle.serial)
        if made.any():
            return number, int(np.flatnonzero(made)[0])
    raise LookupError(f"no command makes the object {obj.preset.name}")
