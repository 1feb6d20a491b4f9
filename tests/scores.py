"""Random scores of all gestures, each a function of its seed alone, and how they are played."""

import math
import random
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.runtime.engine import Engine
from carom.dsp.schema import DIRECTION, GESTURES, POINT, SETTINGS, STRIKE, VELOCITY, Gesture, Parameter
from carom.presets import Presets
from carom.server.osc.score import Line, format_line, sample_at
from carom.server.osc.wire import Message
from carom.server.scene.session import Session

RATES = (22_050, 32_000, 44_100, 48_000, 96_000, 192_000)
ACCURACIES = ("-50", "-60", "-80", "exact")
SUPPORTS = ("felt", "foam", "finger", "palm", "table")
LIVELY = 0.3
"""The part of a wide range, as its logarithm goes, that swarms keep to: some hundred blows a second."""
_SWARMS_AT_ONCE = 2  # of them: more cost a hundred times real time
_PRESETS = Presets()


@dataclass(frozen=True)
class Score:
    """A score's lines, and how it is played: rate in Hz, block in frames, length in s, channels, with a limiter or
    without."""

    lines: tuple[Line, ...]
    rate: int
    block: int
    seconds: float
    channels: int = 2
    limited: bool = False

    @property
    def text(self) -> str:
        """The score as a file has it."""
        return "".join(f"{format_line(line.time, line.message)}\n" for line in self.lines)

    def after(self, seconds: float, before: "Score | None" = None) -> "Score":
        """Return the score some seconds later, with another one's lines before it."""
        later = tuple(line._replace(time=line.time + seconds) for line in self.lines)
        return replace(self, lines=(*(before.lines if before else ()), *later), seconds=self.seconds + seconds)


def number(chance: random.Random, of: Parameter, edges: float = 0.0, part: float = 1.0) -> float:
    """Return a number that a parameter allows: mostly of its useful range, with a chance of `edges` of all of it, half
    of these at an end. part: of a wide range, as its logarithm goes."""
    low, high = of.useful or (of.low, of.high)
    if edges and chance.random() < edges:
        low, high = of.low, of.high
        if chance.random() < 0.5:
            return chance.choice((low, high))
    if of.whole:
        return chance.randint(int(low), int(min(high, 1_000)))
    if low > 0.0 and high / low > 30.0:
        return low * (high / low) ** (part * chance.random())
    return low + part * chance.random() * (high - low)


def gesture(
    chance: random.Random, name: str, target: str, others: list[str], edges: float = 0.0, id: str = ""
) -> Message:
    """Return a gesture on an object, with some of its keys. It always has its seed, which is else another each time."""
    declared = GESTURES[name]
    part = LIVELY if declared.swarms else 1.0
    args: list[str | float] = ["felt" if declared.what else number(chance, declared.argument, 0.0, part)]
    if declared.what:
        args[0] = chance.choice([*SUPPORTS, *(each for each in others if each != target)])
    args.append(chance.random())
    if declared.instead and chance.random() < 0.2:
        instead = next(key for key in declared.keys if key.name == declared.instead)
        args = [instead.name, number(chance, instead)]
    left = ("seed", "position", "gain", "dissipation", declared.instead)
    keys = [key for key in _keys_of(declared) if key.name not in left]
    for key in keys:
        if chance.random() < 0.15:
            args += [key.name, number(chance, key, edges, part)]
    args += _law_of(chance, declared)
    if not declared.rests and chance.random() < 0.5:
        args += ["striker", chance.choice(_PRESETS.names("strikers"))]
    if declared.along and chance.random() < 0.7:
        args += ["surface", chance.choice(_PRESETS.names("surfaces"))]
    if not (declared.swarms or declared.rests) and chance.random() < 0.25:
        args += ["by", chance.choice(others)]
    if declared.breaks and chance.random() < 0.5:
        args += ["onto", chance.choice(others)]
    if any(key.name == "seed" for key in declared.keys):
        args += ["seed", chance.randrange(1_000)]
    if not declared.rests and not declared.held:
        args += ["gain", chance.uniform(-24.0, 6.0)]
    return Message(f"/object/{target}/{name}", (*args, *(("id", id) if id else ())))


def _keys_of(declared: Gesture) -> tuple[Parameter, ...]:
    return (*(() if declared.rests else STRIKE[:4]), *declared.keys)


def _law_of(chance: random.Random, declared: Gesture) -> list[str | float]:
    """Return how a blow loses energy, if it says so, or where on a surface it acts."""
    args: list[str | float] = []
    if not declared.along and not declared.rests and chance.random() < 0.2:
        args += ["restitution", chance.uniform(0.05, 1.0)]
    if chance.random() < 0.1 and not declared.breaks:
        for key in POINT:
            args += [key.name, number(chance, key)]
        if declared.argument is VELOCITY and not declared.breaks:
            for key in DIRECTION:
                args += [key.name, number(chance, key)]
    return args


def any_score(seed: int, prefix: str = "o", edges: float = 0.05, seconds: float = 1.5) -> Score:
    """Return a score of all gestures, some of them at once, on objects that come and go: with what steers them,
    settings, methods, accuracies, panics and frees. It says at first how is computed; at its end all is freed,
    the floor under what was shattered, too.

    prefix: of its objects' names and gestures' ids; edges: chance that a key is anywhere in its declared range.
    """
    chance = random.Random(f"{seed} {prefix}")
    names = [f"{prefix}{n}" for n in range(chance.randint(2, 5))]
    bank = "float32" if chance.random() < 0.2 else "float64"
    first = {"/accuracy": chance.choice(ACCURACIES), "/bank": bank, "/quality": 0}
    lines = [Line(0.0, Message(address, (word,)), "") for address, word in first.items()]
    lines += [Line(0.05 * (n // 3), _made(chance, name), "") for n, name in enumerate(names)]
    played = [chance.choice(list(GESTURES)) for _ in range(chance.randint(3, 9))]
    swarms = 0
    for n, name in enumerate(played):
        swarms += GESTURES[name].swarms > 0
        if GESTURES[name].swarms and swarms > _SWARMS_AT_ONCE:
            continue
        begin, target, id = chance.uniform(0.1, 0.7 * seconds), chance.choice(names), f"{prefix}g{n}"
        lines.append(Line(begin, gesture(chance, name, target, names, edges, id), ""))
        lines += _steering(chance, GESTURES[name], id, begin, seconds)
    for _ in range(chance.randint(0, 5)):
        lines.append(Line(chance.uniform(0.1, seconds), _change(chance, chance.choice(names)), ""))
    if chance.random() < 0.5:
        gone, at = chance.choice(names), chance.uniform(0.3, 0.6) * seconds
        lines.append(Line(at, Message(f"/object/{gone}/free", (chance.choice((0, 1)),)), ""))
        lines.append(Line(at + 0.1, _made(chance, gone), ""))
    if chance.random() < 0.1:
        lines.append(Line(chance.uniform(0.3, 0.9) * seconds, Message("/panic", ()), ""))
    lines += [Line(seconds - 0.1, Message(f"/object/{name}/free", (1,)), "") for name in (*names, "floor")]
    lines.append(Line(seconds - 0.02, Message("/panic", ()), ""))
    lines.sort(key=lambda line: line.time)
    block = round(math.exp(chance.uniform(0.0, math.log(4_096.0))))
    rate, channels = chance.choice(RATES), chance.choice((1, 2, 2, 8))
    return Score(tuple(lines), rate, block, seconds, channels, chance.random() < 0.5)


def _made(chance: random.Random, name: str) -> Message:
    args = (name, chance.choice(_PRESETS.names("objects")), "gain", chance.uniform(-30.0, 0.0))
    return Message("/object/new", (*args, "pan", chance.uniform(-1.0, 1.0)))


def _steering(chance: random.Random, declared: Gesture, id: str, begin: float, seconds: float) -> Iterator[Line]:
    """Yield what steers a gesture, and its end."""
    known = {each.name: each for each in (*STRIKE, *declared.keys, declared.argument)}
    names = [name for name in declared.steerable if name in known]
    for _ in range(chance.choice((0, 0, 1, 2)) if declared.lasts and names else 0):
        name = chance.choice(names)
        value = number(chance, known[name], 0.0, LIVELY if declared.swarms else 1.0)
        more = ("over", chance.uniform(0.0, 0.3)) if chance.random() < 0.5 else ()
        yield Line(begin + chance.uniform(0.02, 0.5), Message(f"/gesture/{id}/{name}", (value, *more)), "")
    if chance.random() < 0.4:
        yield Line(chance.uniform(begin, seconds), Message(f"/gesture/{id}/stop", ()), "")


def _change(chance: random.Random, name: str) -> Message:
    """Return a change of a setting, or of how is computed."""
    kind = chance.randrange(9)
    if kind == 1:
        return Message("/accuracy", (chance.choice(ACCURACIES),))
    if kind == 2:
        return Message("/quality", (chance.choice((0, 0, 1, 2, 3)),))
    if kind == 3:
        return Message("/bank", (chance.choice(("float32", "float64")),))
    setting = chance.choice(list(SETTINGS.values()))
    more = ("over", chance.uniform(0.0, 0.3)) if chance.random() < 0.5 else ()
    return Message(f"/object/{name}/{setting.name}", (number(chance, setting), *more))


def play(score: Score, filler: int | None = None, begin: float = 0.0) -> np.ndarray:
    """Play a score, without the lines that are refused; return its sound from some seconds on, float32 (frames,
    channels). filler: the byte that fills what nobody should read; None: as the build has it."""
    engine = Engine(score.rate, score.channels, limited=score.limited)
    if filler is not None:
        engine.state[0]["filler"] = filler
    session, lines, sound = Session(engine, _PRESETS), list(score.lines), []
    frames, made = round(score.seconds * score.rate), 0
    while made < frames:
        # The engine computes whole quanta: what begins within one has to be there before.
        while lines and lines[0].time * score.rate < engine.position + score.block + QUANTUM:
            line = lines.pop(0)
            session.perform([line.message], sample_at(line.time, score.rate))
        sound.append(engine.process(score.block))
        made += score.block
    return np.concatenate(sound)[round(begin * score.rate) : frames]
