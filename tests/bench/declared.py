"""Messages to every address that is declared, a new one too, and objects and bodies of extreme geometry."""

import math
import random
from collections.abc import Iterator
from itertools import chain

from carom.presets import Presets
from carom.presets.schema import SHAPES as OBJECT_SHAPES
from carom.presets.values import Choice, Quantity, Whole
from carom.server.bridge.shapes import SHAPES as BODY_SHAPES
from carom.server.osc.addresses import VERBS
from carom.server.osc.arguments import Either, Key, Note, Number, Numbers, Vector, Word
from carom.server.osc.wire import Argument, Message

PRESETS = Presets()
KINDS = {
    "preset": "objects",
    "object": "objects",
    "striker": "strikers",
    "material": "materials",
    "surface": "surfaces",
}
"""The presets that a word may name, by the name of the argument."""
_NAMES = "abcdefgh"
_NEVER = "/quit"


def declared(chance: random.Random) -> Message:
    """Return a message to any address but the one that ends the server, its arguments within their ranges or at their
    ends."""
    verb = VERBS[chance.choice([address for address in VERBS if address != _NEVER])]
    args: list[Argument] = [argument(chance, each) for each in verb.required]
    if verb.many:
        args += argument_list(chance, verb.many, chance.choice((0, 1, 2, 3, 7, 13, verb.many.most)))
    elif verb.optional and chance.random() < 0.5:
        args += [argument(chance, verb.optional[0])]
    keys = chance.sample(verb.keys, min(len(verb.keys), chance.choice((0, 0, 1, 2, 4))))
    args += chain.from_iterable((key.name, argument(chance, key)) for key in keys)
    return Message(verb.address.replace("NAME", name(chance)).replace("ID", name(chance)), tuple(args))


def name(chance: random.Random) -> str:
    """Return a name of an object, a gesture or a body, or a pattern of such."""
    return chance.choice([*_NAMES, "*", "[a-c]"] if chance.random() < 0.3 else _NAMES)


def argument(chance: random.Random, key: Key) -> Argument:
    """Return a value that an argument may have."""
    if isinstance(key, Either):
        return chance.choice(key.words)
    if isinstance(key, Note):
        return chance.uniform(key.low, key.high)
    if isinstance(key, Numbers):
        return tuple(argument_list(chance, key, chance.choice((1, 2, key.most))))
    if isinstance(key, Number):
        low, high = key.useful if key.useful and chance.random() < 0.7 else (key.low, key.high)
        return float(round(between(chance, low, high))) if key.whole else between(chance, low, high)
    if isinstance(key, Vector):
        return tuple(argument(chance, axis) for axis in key.axes)
    assert isinstance(key, Word)
    if key.name in KINDS:
        return chance.choice(sorted(PRESETS.names(KINDS[key.name])))
    return chance.choice(_NAMES)


def argument_list(chance: random.Random, numbers: Numbers, count: int) -> list[Argument]:
    """Return so many numbers of one kind."""
    return [argument(chance, numbers.number) for _ in range(count)]


def between(chance: random.Random, low: float, high: float) -> float:
    """Return a number of a range: an end of it, or by equal ratios where both are positive."""
    kind = chance.random()
    if kind < 0.1:
        return low
    if kind < 0.2:
        return high
    return math.exp(chance.uniform(math.log(low), math.log(high))) if low > 0.0 else chance.uniform(low, high)


def extreme(chance: random.Random) -> Message:
    """Return a message that makes an object or a body, of any size that there may be."""
    if chance.random() < 0.4:
        shape = chance.choice(BODY_SHAPES)
        size = [between(chance, 1e-5, 1e3) for _ in range({"sphere": 1, "cylinder": 2, "capsule": 2}.get(shape, 3))]
        material = chance.choice(sorted(PRESETS.names("materials")))
        return Message("/world/body", (chance.choice(_NAMES), shape, material, *size, "held", chance.randrange(2)))
    preset = PRESETS.object(chance.choice(sorted(PRESETS.names("objects"))))
    return Message(
        "/object/new", (chance.choice(_NAMES), preset.name, *chain.from_iterable(_geometry(chance, preset.shape)))
    )


def _geometry(chance: random.Random, shape: str) -> Iterator[tuple[str, Argument]]:
    """Yield keys of a shape, and values that its schema allows."""
    for key, field in OBJECT_SHAPES[shape].fields.items():
        if chance.random() < 0.5:
            if isinstance(field, Whole):
                yield key, chance.randint(int(field.low), int(field.high))
            elif isinstance(field, Quantity):
                yield key, between(chance, field.low, field.high)
            elif isinstance(field, Choice):
                yield key, chance.choice(field.options)
