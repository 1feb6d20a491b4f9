"""Answers to programs that look up what there is: presets, objects, gestures, an object's settings and modes."""

import math
from collections.abc import Iterable, Iterator
from itertools import islice

from ..dsp.wording import suggestion
from ..presets import Presets
from .osc.arguments import Refused
from .osc.wire import Argument, Message
from .scene.object_call import listed
from .scene.objects import PlayedObject
from .scene.session import Session
from .scene.transaction import MOST_COMPARED

_LARGEST = 1_200  # bytes of the arguments of an answer: a datagram of it fits any network
_T60 = math.log(1e3)  # times the time constant


def presets(library: Presets, kind: str) -> Iterator[Message]:
    """Yield /presets.reply KIND FIRST TOTAL NAME ...: as many as are needed."""
    yield from in_parts("/presets.reply", (kind,), [(name,) for name in library.names(kind)])


def objects(session: Session) -> Iterator[Message]:
    """Yield /objects.reply FIRST TOTAL and pairs of name and preset."""
    there = [(name, session.objects[name].preset.name) for name in session.objects.there(0.0)]
    yield from in_parts("/objects.reply", (), there)


def gestures(session: Session) -> Iterator[Message]:
    """Yield /gestures.reply FIRST TOTAL and pairs of id and the address that started it."""
    running = [(id.name, address) for id in session.gestures.running() for address, _ in tuple(id.running)]
    yield from in_parts("/gestures.reply", (), running)


def described(session: Session, target: str, modes: int) -> Iterator[Message]:
    """Yield /object/NAME/get.reply and pairs, for each object that matches; with a number of modes, get.modes, too."""
    found = session.objects.at(target, 0.0)
    if not found:
        there = list(islice(session.objects.there(0.0), MOST_COMPARED))
        raise Refused(f"{target}: no such object; {suggestion(target, there) or f'there are {listed(there)}'}")
    for name, obj in found.items():
        spectrum = obj.preset.modes(session.engine.top_frequency)
        pairs: dict[str, Argument] = {
            "preset": obj.preset.name,
            "shape": obj.preset.shape,
            "material": obj.preset.material.name if obj.preset.material else "",
            "mass": obj.mass,
            "modes": len(spectrum.frequency),
            "striker": obj.preset.striker,
            **obj.settings,
        }
        yield Message(f"/object/{name}/get.reply", tuple(each for pair in pairs.items() for each in pair))
        ratio = tuning_of(obj)
        count = min(modes, len(spectrum.frequency))
        values = [
            (ratio * float(spectrum.frequency[i]), _T60 / float(spectrum.decay[i]) if spectrum.decay[i] else 0.0)
            for i in range(count)
        ]
        if count:
            yield from in_parts(f"/object/{name}/get.modes", (), values)


def tuning_of(obj: PlayedObject) -> float:
    """Return the factor on an object's frequencies as it is tuned now."""
    return float(2.0 ** (obj.settings.get("tune", 0.0) / 12.0))


def in_parts(address: str, head: tuple[Argument, ...], items: Iterable[tuple[Argument, ...]]) -> Iterator[Message]:
    """Yield messages with all items, each with the place of its first one and their number after the head."""
    items = list(items)
    part: list[Argument] = []
    first = size = 0
    for place, item in enumerate(items):
        grows = sum(len(each) + 5 if isinstance(each, str) else 5 for each in item)
        if size + grows > _LARGEST:
            yield Message(address, (*head, first, len(items), *part))
            part, first, size = [], place, 0
        part += item
        size += grows
    yield Message(address, (*head, first, len(items), *part))
