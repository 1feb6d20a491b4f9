"""Scores of a recipe: what an item does line by line, with words that are drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from operator import attrgetter
from pathlib import Path
from typing import NamedTuple

from ...dsp.wording import expected
from ...presets import PresetError, Presets
from ...presets.values import shown
from ...server.osc.addresses import calls, unknown
from ...server.osc.arguments import Refused
from ...server.osc.score import Line, ScoreError
from ...server.osc.score import read as read_score
from ...server.osc.sensor_verbs import SENSOR
from ...server.osc.wire import Argument, Message
from ...server.scene.sensing import sensor_asked
from ..errors import plain
from .spread import Spread, Value

FILE, SEED = "file", "seed"
"""The key of a score's name, and the word for a seed that each item has of its own."""

NAMED: Mapping[str, Callable[[Presets, str], object]] = {
    "striker": Presets.striker, "surface": Presets.surface, "preset": Presets.object, "material": Presets.material,
}  # fmt: skip
"""Words of messages that name presets."""

_MARK = "$"


class Score(NamedTuple):
    """A score: its lines by time, and the words in them that are drawn, $seed apart."""

    lines: tuple[Line, ...]
    words: frozenset[str]

    def fixed(self) -> list[Line]:
        """Return the lines in which nothing is drawn."""
        return [line for line in self.lines if not any(_words(line.message.args))]

    def drawn(self) -> list[Line]:
        """Return the lines in which something is drawn."""
        return [line for line in self.lines if any(_words(line.message.args))]


def read_scores(where: str, folder: Path, table: Mapping[str, Value | Spread]) -> dict[str, Score]:
    """Read the scores that a section names, of a recipe's folder. PresetError names the file and its line."""
    if FILE not in table:
        raise PresetError(f"{where}{FILE} is missing: expected the name of a score, whose place is beside the recipe")
    named = table[FILE]
    scores = {}
    for name in named.ends if isinstance(named, Spread) else (named,):
        culprit = f"{where}{FILE} = {shown(name)}"
        if not isinstance(name, str):
            raise PresetError(f"{culprit}: expected the name of a score")
        try:
            lines = read_score(folder / name)
        except OSError as error:
            raise PresetError(f"{culprit}: {plain(error)}") from None
        except ScoreError as error:
            raise PresetError(f"{culprit}: {error}") from None
        if not lines:
            raise PresetError(f"{culprit}: it is empty; expected lines of time, address and arguments")
        words = {word for line in lines for word in _words(line.message.args)} - {SEED}
        scores[name] = Score(tuple(sorted(lines, key=attrgetter("time"))), frozenset(words))
    return scores


def filled(lines: Sequence[Line], values: Mapping[str, Value], seed: int) -> list[Line]:
    """Fill a score's lines with an item's values in the places of words such as $velocity."""
    given = {SEED: seed, **values}
    return [
        line._replace(message=Message(line.message.address, tuple(_filled(arg, given) for arg in line.message.args)))
        for line in lines
    ]


def _filled(arg: Argument, given: Mapping[str, Value]) -> Argument:
    if isinstance(arg, tuple):
        return tuple(_filled(each, given) for each in arg)
    return given[arg[1:]] if isinstance(arg, str) and arg.startswith(_MARK) else arg


def require_filled(
    where: str, scores: Mapping[str, Score], table: Mapping[str, Value | Spread], seconds: float
) -> None:
    """Raise PresetError where scores and keys do not fit each other, or a score is longer than an item."""
    keys = [key for key in table if key != FILE]
    for name, score in scores.items():
        culprit = f"{where}{FILE} = {shown(name)}"
        if unknown_words := sorted(score.words - set(keys)):
            word = unknown_words[0]
            raise PresetError(f"{culprit}: {_MARK}{word}: {expected(word, [*keys, SEED])}")
        if (last := score.lines[-1].time) > seconds:
            raise PresetError(f"{culprit}: its last line is at {last:g} s; expected at most seconds = {seconds:g}")
    for key in keys:
        if not any(key in score.words for score in scores.values()):
            raise PresetError(f"{where}{key}: no score has {_MARK}{key}; expected a line of {', '.join(scores)} to")


def _words(args: tuple[Argument, ...]) -> Iterator[str]:
    """Yield the words that are drawn."""
    for arg in args:
        if isinstance(arg, tuple):
            yield from _words(arg)
        elif isinstance(arg, str) and arg.startswith(_MARK):
            yield arg[1:]


def require_performable(lines: Sequence[Line], presets: Presets) -> None:
    """Raise PresetError that names a line which no score could carry out, or which names a preset that does not
    exist."""
    for line in lines:
        for call in calls(line.message):
            try:
                if call.verb is None:
                    raise unknown(call.message.address)
                if not call.verb.scored:
                    raise Refused("expected an address that a score may hold")
                values = call.verb.parse(call.message.args)
                if call.verb.address == SENSOR:
                    sensor_asked(values)
                    continue
                for key, find in NAMED.items():
                    if values.words.get(key):
                        find(presets, values.words[key])
            except (Refused, PresetError) as error:
                raise PresetError(f"{line.where}: {call.message.address}: {error}") from None
