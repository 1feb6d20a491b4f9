"""The address space: what can be said to Carom, declared once for checking, for the README and for whoever asks.

`python -m carom.server.space` prints it as the README's table.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache

from .patterns import is_pattern, match
from .wire import Argument, Message


class Refused(ValueError):
    """A message that can't be carried out; the text names the culprit, its value and what was expected."""


@dataclass(frozen=True)
class Number:
    """A numeric argument and its range, bounds included."""

    name: str
    low: float
    high: float
    unit: str = ""
    help: str = ""

    def check(self, value: Argument) -> float:
        if isinstance(value, (int, float)) and self.low <= value <= self.high:
            return float(value)
        unit = f" {self.unit}" if self.unit else ""
        raise Refused(f"{self.name} = {shown(value)}: expected a number from {self.low:g} to {self.high:g}{unit}")


@dataclass(frozen=True)
class Word:
    """An argument that is a name."""

    name: str
    help: str = ""

    def check(self, value: Argument) -> str:
        if isinstance(value, str) and value:
            return value
        raise Refused(f"{self.name} = {shown(value)}: expected a name")


@dataclass(frozen=True)
class Either:
    """An argument that is one of a few words; a number stands for the word that is written like it."""

    name: str
    words: tuple[str, ...]

    def check(self, value: Argument) -> str:
        word = f"{value:g}" if isinstance(value, int | float) else value
        if isinstance(word, str) and word in self.words:
            return word
        raise Refused(f"{self.name} = {shown(value)}: expected {', '.join(self.words)}")


@dataclass
class Values:
    """The checked arguments of a message, by name."""

    numbers: dict[str, float] = field(default_factory=dict)
    words: dict[str, str] = field(default_factory=dict)
    others: dict[str, Argument] = field(default_factory=dict)

    def check(self, argument: "Number | Word | Either", value: Argument) -> None:
        if argument.name in self.numbers or argument.name in self.words:
            raise Refused(f"{argument.name} = {shown(value)}: given twice")
        if isinstance(argument, Number):
            self.numbers[argument.name] = argument.check(value)
        else:
            self.words[argument.name] = argument.check(value)


@dataclass(frozen=True)
class Verb:
    """An address and its arguments: required ones, optional positional numbers, then key value pairs."""

    address: str
    help: str
    required: tuple[Number | Word | Either, ...] = ()
    optional: tuple[Number, ...] = ()
    keys: tuple[Number | Word, ...] = ()
    open_keys: bool = False  # further keys are another's to check
    scored: bool = field(default=True)  # has a meaning in a score

    def parse(self, args: tuple[Argument, ...]) -> Values:
        """Checked values by name; Refused says what is wrong."""
        if len(args) < len(self.required):
            missing = self.required[len(args)]
            raise Refused(f"{missing.name} is missing: expected {self.usage()}")
        values = Values()
        for argument, value in zip(self.required, args, strict=False):
            values.check(argument, value)
        rest = list(args[len(self.required) :])
        for number in self.optional:
            if rest and not isinstance(rest[0], str):
                values.check(number, rest.pop(0))
        keys = {key.name: key for key in (*self.keys, *self.optional)}
        for key, value in _pairs(rest, self):
            if key in keys:
                values.check(keys[key], value)
            elif key in values.others:
                raise Refused(f"{key} = {shown(value)}: given twice")
            elif self.open_keys:
                values.others[key] = value
            else:
                raise Refused(f"{key}: no such key; expected {', '.join(keys) or 'none'}")
        return values

    def usage(self) -> str:
        words = [a.name for a in self.required] + [f"[{a.name}]" for a in self.optional]
        return " ".join([self.address, *words, *(["[key value ...]"] if self.keys or self.open_keys else [])])


def _pairs(rest: list[Argument], verb: Verb) -> Iterator[tuple[str, Argument]]:
    for i in range(0, len(rest), 2):
        key = rest[i]
        if not isinstance(key, str):
            raise Refused(f"{shown(key)}: expected a key; {verb.usage()}")
        if i + 1 == len(rest):
            raise Refused(f"{key}: its value is missing")
        yield key, rest[i + 1]


def shown(value: Argument) -> str:
    """A value as an error names it."""
    if isinstance(value, float) and math.isfinite(value):
        return f"{value:g}"
    text = str(value) if isinstance(value, str) else repr(value)
    return text if len(text) <= 40 else text[:37] + "..."


VELOCITY = Number("velocity", 0, 1000, "m/s", "of the striker as it meets the object; 0 does nothing")
POSITION = Number("position", 0, 1, "", "where it is struck, from one end of the object's strike path to the other")
GAIN = Number("gain", -120, 40, "dB")
PAN = Number("pan", -1, 1, "", "-1 left, 1 right")
TUNE = Number("tune", -60, 60, "semitones")
DECAY = Number("decay", 0.001, 100, "times", "every decay time, longer or shorter")
HEIGHT = Number("height", 0, 1000, "m", "it falls from")
GRAVITY = Number("gravity", 0.01, 1000, "m/s^2")
IRREGULARITY = Number("irregularity", 0, 1, "", "how far from round: energy comes and goes between flight and rotation")
SPEED = Number("speed", 0, 100, "m/s", "along the surface; 0 stops it")
RADIUS = Number("radius", 1e-4, 10, "m", "of the body; the striker's if it is a ball")
ROUGHNESS = Number("roughness", 0, 100, "times", "the surface's own")
ASYMMETRY = Number("asymmetry", 0, 1, "", "how far the centre of mass is from the middle, as a share of the radius")
FRICTION = Number("friction", 0, 10, "", "share of its weight that slows it down")
FORCE = Number("force", 0, 1e5, "N", "that presses it on")
MASS = Number("mass", 1e-9, 1e6, "kg")
SEED = Number("seed", 0, 2**31 - 1, "", "of what is left to chance")
DAMP = Number("damp", 0, 1, "", "a hand on it: 0 off, 1 firm")

STRIKER = (
    Word("striker", "a preset"),
    MASS,
    Number("stiffness", 1e-3, 1e16, "N/m^a"),
    Number("dissipation", 0, 1e6, "s/m"),
    Number("exponent", 1, 4),
)

STRIKE = (
    *STRIKER,
    Word("by", "an object that strikes, and rings too"),
    Number("by_position", 0, 1, "", "where on that object"),
    Number("gain", -120, 40, "dB", "of this gesture"),
    Word("id", "a name by which the gesture can be steered, and its end is told"),
)

VERBS = {
    verb.address: verb
    for verb in (
        Verb(
            "/object/new", "makes an object from a preset; further keys change the preset (length, material, ...)",
            (Word("name"), Word("preset")), keys=(GAIN, PAN, TUNE, DECAY, DAMP, POSITION, STRIKER[0]), open_keys=True,
        ),
        Verb(
            "/object/NAME/impact", "strikes it once; `by` another object, that one rings too",
            (VELOCITY,), (POSITION,), STRIKE,
        ),
        Verb(
            "/object/NAME/bounce", "drops or throws the striker on it, which bounces until it rests",
            (HEIGHT,), (POSITION,),
            (
                *STRIKE, Number("velocity", -100, 100, "m/s", "thrown downwards, or upwards"), GRAVITY, IRREGULARITY,
                SEED, Number("weight", 0, 1, "", "1: gravity acts in every contact too, not only near rest"),
            ),
        ),
        Verb(
            "/object/NAME/roll", "rolls the striker over it until 0, or steers the roll of that id (NAME if none)",
            (SPEED,), (POSITION,),
            (
                *STRIKE, RADIUS, Word("surface", "a preset"), ROUGHNESS, ASYMMETRY, FRICTION, GRAVITY, SEED,
                Number("corners", 0, 100, "", "of the body; 0: it is round"),
                Number("travel", 0, 1e3, "m", "length of the strike path, which it rolls to and fro; 0: it stays"),
            ),
        ),
        Verb(
            "/object/NAME/press", "lays the striker on it and presses, until it is stopped: a hand, a mute",
            (FORCE,), (POSITION,), STRIKE,
        ),
        Verb("/object/NAME/damp", "puts a hand on it, until changed", (DAMP,)),
        Verb("/object/NAME/gain", "level", (GAIN,)),
        Verb("/object/NAME/pan", "place between left and right", (PAN,)),
        Verb("/object/NAME/tune", "all its frequencies up or down", (TUNE,)),
        Verb("/object/NAME/decay", "all its decay times longer or shorter", (DECAY,)),
        Verb(
            "/object/NAME/free", "removes it once silent, or with 1 at once (a 70 ms fade); its name is free",
            optional=(Number("at_once", 0, 1),),
        ),
        Verb("/gesture/ID/stop", "a striker that bounces does not come back, a rolling body halts, a hand lets go"),
        Verb("/gesture/ID/gain", "level of a running gesture", (GAIN,)),
        Verb("/gesture/ID/position", "where it touches the object", (POSITION,)),
        Verb("/gesture/ID/gravity", "of a bounce, from the next flight on, or a roll", (GRAVITY,)),
        Verb("/gesture/ID/irregularity", "of a bounce, from the next contact on", (IRREGULARITY,)),
        Verb("/gesture/ID/force", "of what presses", (FORCE,)),
        Verb("/gesture/ID/speed", "of a roll", (SPEED,)),
        Verb("/gesture/ID/mass", "of a roll", (MASS,)),
        Verb("/gesture/ID/roughness", "of a roll", (ROUGHNESS,)),
        Verb("/gesture/ID/radius", "of a roll", (RADIUS,)),
        Verb("/gesture/ID/asymmetry", "of a roll", (ASYMMETRY,)),
        Verb("/gesture/ID/friction", "of a roll", (FRICTION,)),
        Verb(
            "/accuracy", "how exact contacts with what moves are from now on: -40, -60 (dB, the default), -80, exact",
            (Either("accuracy", ("-40", "-60", "-80", "exact")),),
        ),
        Verb(
            "/quality", "what is left out: 0 nothing, 1 contacts' fine steps, 2 modes under -80 dB, 3 rolls' density, "
            "4 what was not touched lately, 5 to 8 bounces, rolls and presses but the newest 32, 16, 8, 4, which wait; "
            "with too little time the server goes further by itself",
            (Number("quality", 0, 8),),
        ),
        Verb(
            "/contact", "how contacts are solved from now on: closed (exact, the default), am1, verlet, heun, rk4",
            (Word("method"),), (Number("oversampling", 1, 64),),
            (Word("correction", "none, hybrid, release, both, paper-release, paper-both"),),
        ),
        Verb("/panic", "silences everything at once; objects stay"),
        Verb("/status", "answers /status.reply", scored=False),
        Verb("/version", "answers /version.reply name major minor patch", scored=False),
        Verb(
            "/sync", "answers /synced id once all sent before it is done", (Number("id", -(2**31), 2**31 - 1),),
            scored=False,
        ),
        Verb("/notify", "1: /warning text comes to you from now on, 0: no more", (Number("on", 0, 1),), scored=False),
        Verb("/dump", "1: prints every message that arrives, 0: no more", (Number("on", 0, 1),), scored=False),
        Verb("/quit", "ends the server", scored=False),
    )
}  # fmt: skip


def spelled(message: Message) -> list[Message]:
    """The message once for each verb that its address, a pattern perhaps, matches; only a NAME in it stays a pattern.

    What matches none comes back as it is, to be refused. /quit is meant by its full name alone: nobody who sends to
    every address wants to end the server.
    """
    if not is_pattern(message.address):
        return [message]
    return [Message(address, message.args) for address in _matched(message.address)] or [message]


@lru_cache(maxsize=64)
def _matched(pattern: str) -> list[str]:
    parts = pattern.split("/")
    candidates = (verb.split("/") for verb in VERBS if verb != "/quit")
    return [
        "/".join(given if known.isupper() else known for given, known in zip(parts, verb, strict=True))
        for verb in candidates
        if len(verb) == len(parts)
        and all(known.isupper() or match(given, known) for given, known in zip(parts, verb, strict=True))
    ]


def table() -> str:
    """The address space as a Markdown table."""

    def described(argument: Number | Word | Either) -> str:
        if isinstance(argument, Word | Either):
            return f"`{argument.name}`"
        unit = f" {argument.unit}" if argument.unit else ""
        return f"`{argument.name}` {argument.low:g} to {argument.high:g}{unit}"

    def listed(keys: tuple[Number | Word, ...]) -> str:
        strikes = keys[: len(STRIKE)] == STRIKE
        own = ", ".join(described(key) for key in (keys[len(STRIKE) :] if strikes else keys))
        return "; keys: " + ", ".join(filter(None, ["a strike's" if strikes else "", own])) if keys else ""

    lines = ["| address | arguments | does |", "|---|---|---|"]
    for verb in VERBS.values():
        parts = [described(a) for a in verb.required] + [f"[{described(a)}]" for a in verb.optional]
        lines.append(f"| `{verb.address}` | {', '.join(parts)}{listed(verb.keys)} | {verb.help} |")
    lines += ["", "| a strike's keys | meaning |", "|---|---|"]
    lines += [f"| {described(key)} | {key.help or 'in place of the one that the striker has'} |" for key in STRIKE]
    return "\n".join(lines)


if __name__ == "__main__":
    print(table())
