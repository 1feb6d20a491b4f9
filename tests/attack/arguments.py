"""Arguments at all addresses: extremes of numbers, other kinds, too many and too few of them."""

import random
from collections.abc import Iterator

from carom.server.osc.addresses import VERBS
from carom.server.osc.arguments import Number
from carom.server.osc.wire import Argument, Message
from tests.attack import Tried, kind
from tests.attack.children import Child
from tests.attack.extremes import any_value, edge
from tests.attack.playing import tried
from tests.bench.declared import argument, argument_list, name

OBJECTS = (("a", "wood-block"), ("b", "wine-glass"), ("c", "marimba-bar"), ("d", "crash-cymbal"))
_MESSAGES = 20
_SECONDS = 0.05


@kind("arguments", 12)
def arguments(chance: random.Random) -> Iterator[Tried]:
    """Twenty messages to any address, on objects that gestures act on."""
    with Child() as child:
        while True:
            made = [Message("/object/new", each) for each in chance.sample(OBJECTS, 2)]
            begun = [Message(f"/object/{made[0].args[0]}/roll", (0.3, "id", made[0].args[0], "seed", 3))]
            yield tried(child, [*made, *begun, *(message(chance) for _ in range(_MESSAGES))], _SECONDS)


def message(chance: random.Random) -> Message:
    """Return a message to any address, some of its arguments as they may be, others not."""
    verb = VERBS[chance.choice(sorted(VERBS))]

    def value(key: object) -> Argument:
        if isinstance(key, Number) and chance.random() < 0.5:
            return edge(chance, key, key.whole)
        return any_value(chance) if chance.random() < 0.3 else argument(chance, key)  # type: ignore[arg-type]

    args = [value(each) for each in (*verb.required, *verb.optional[: chance.randrange(3)])]
    if verb.many:
        args += argument_list(chance, verb.many, chance.choice((0, 1, 3, verb.many.most, verb.many.most + 1)))
    for key in chance.sample(verb.keys, min(len(verb.keys), chance.choice((0, 1, 1, 2, 4)))):
        args += [key.name, value(key)]
    if args and chance.random() < 0.1:
        args = args[: chance.randrange(len(args))]
    if chance.random() < 0.05:
        args += [any_value(chance)]
    return Message(verb.address.replace("NAME", name(chance)).replace("ID", name(chance)), tuple(args))
