"""Gestures with many keys at the edges of their ranges at once: finite sound, within a second of a processor a
second."""

import random
from collections.abc import Iterator

from carom.presets import Presets
from carom.server.osc.addresses import KEYS, STRIKE, VERBS
from carom.server.osc.arguments import Either, Numbers, Vector, Word
from carom.server.osc.arguments import Number as NumberKey
from carom.server.osc.wire import Argument, Message
from tests.attack import Tried, kind
from tests.attack.children import Child
from tests.attack.extremes import edge
from tests.attack.playing import tried
from tests.bench.declared import KINDS

PRESETS = Presets()
_SUPPORTS = ("felt", "foam", "finger", "palm", "table", "b")
_SECONDS = 0.3


@kind("combinations", 12)
def combinations(chance: random.Random) -> Iterator[Tried]:
    """Two objects, and one to three gestures on them, at edges that are allowed."""
    names = PRESETS.names("objects")
    with Child() as child:
        while True:
            made = [Message("/object/new", (each, chance.choice(names))) for each in "ab"]
            gestures = [gesture(chance, name) for name in chance.choices("ab", k=chance.choice((1, 1, 1, 2, 3)))]
            yield tried(child, [*made, *gestures], _SECONDS)


def gesture(chance: random.Random, name: str) -> Message:
    """Return a message that begins a gesture on an object of a name, its numbers at the edges of what they may be."""
    kind = chance.choice(sorted(KEYS))
    verb = VERBS[f"/object/NAME/{kind}"]
    own = [key for key in verb.keys if key not in STRIKE or chance.random() < 0.3]
    args: list[Argument] = [chance.choice(_SUPPORTS) if kind == "rest" else at_edge(chance, verb.optional[0])]
    for key in chance.sample(own, min(len(own), chance.choice((0, 1, 2, 3, 5, 8)))):
        if isinstance(key, NumberKey):
            args += [key.name, at_edge(chance, key)]
        elif isinstance(key, Word) and key.name in KINDS:
            args += [key.name, chance.choice(PRESETS.names(KINDS[key.name]))]
        elif isinstance(key, Word) and key.name in ("by", "onto"):
            args += [key.name, "b" if name == "a" else "a"]
        else:
            assert isinstance(key, Word | Vector | Either | Numbers)
    return Message(f"/object/{name}/{kind}", tuple(args))


def at_edge(chance: random.Random, key: NumberKey) -> float:
    """Return a value of a number: mostly at an edge, else as a fader has it."""
    if key.useful and chance.random() < 0.3:
        return key.useful[chance.randrange(2)]
    return edge(chance, key, key.whole, inside=True)
