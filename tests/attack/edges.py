"""Every key of every preset at its least and its most, a step beyond, at 0 and at the least numbers that there are."""

import random
from collections.abc import Iterator
from typing import Any

from carom.presets import Presets
from carom.presets.schema import OBJECT, SHAPES, STRIKE
from carom.presets.values import Choice, Domain, Many, Quantity, Row, Rows, Whole
from carom.server.osc.wire import Message
from tests.attack import Tried, kind
from tests.attack.children import Child
from tests.attack.extremes import any_value, edge
from tests.attack.playing import tried

PRESETS = Presets()
_SECONDS = 0.05


@kind("edges", 20)
def edges(chance: random.Random) -> Iterator[Tried]:
    """An object with one or a few keys at their edges, which is struck."""
    names = PRESETS.names("objects")
    with Child() as child:
        while True:
            name = chance.choice(names)
            keys = keys_of(name)
            chosen = chance.sample(sorted(keys), min(len(keys), chance.choice((1, 1, 1, 2, 3))))
            given = [each for key in chosen for each in (key, at_edge(chance, keys[key]))]
            strike = Message("/object/a/impact", (1.0,))
            yield tried(child, [Message("/object/new", ("a", name, *given)), strike], _SECONDS)


def keys_of(name: str) -> dict[str, Domain]:
    """Return the keys that a message may change of an object's preset."""
    preset = PRESETS.object(name)
    fields = {**OBJECT, **STRIKE, **SHAPES[preset.shape].damping, **SHAPES[preset.shape].fields}
    return {key: fields.get(key, Quantity(1e-3, 1e3, "times")) for key in preset.keys if key != "rest"}


def at_edge(chance: random.Random, domain: Domain | Choice) -> Any:
    """Return a value near the edges of what may be."""
    if chance.random() < 0.05:
        return any_value(chance)
    if isinstance(domain, Quantity):
        return edge(chance, domain, isinstance(domain, Whole))
    if isinstance(domain, Choice):
        return chance.choice(domain.options)
    if isinstance(domain, Row):
        return tuple(at_edge(chance, each) for each in domain.items)
    if isinstance(domain, Many | Rows):
        return tuple(at_edge(chance, domain.item) for _ in range(chance.choice((1, 2, 30))))
    return any_value(chance)
