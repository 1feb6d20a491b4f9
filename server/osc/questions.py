"""Questions about the scene: each is an address, and the function that answers it, declared together."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import islice
from typing import Protocol

from ...dsp.bodies.modes import Modes
from ...dsp.schema import Parameter as Number
from ...dsp.wording import MOST_COMPARED, suggestion, there_are
from ...presets import ObjectPreset, Presets
from .arguments import Either, Parameter, Refused, Values, Verb, shown
from .wire import Argument, Message

_LARGEST = 1_200  # bytes of the arguments of an answer: a datagram of it fits any network
_T60 = math.log(1e3)  # times the time constant


class Object(Protocol):
    """The part of an object that questions read."""

    preset: ObjectPreset
    modes: Modes
    settings: dict[str, float]

    @property
    def mass(self) -> float:
        """kg."""


class Asked(Protocol):
    """The part of a session that questions read."""

    presets: Presets

    def objects_at(self, pattern: str) -> Mapping[str, Object]:
        """Return the objects whose names match a pattern."""

    def objects_there(self) -> Mapping[str, Object]:
        """Return the objects that are there."""

    def running(self) -> Iterable[tuple[str, str]]:
        """Return the ids of gestures that run, with the addresses that began them."""


Answer = Callable[[Asked, Values], Iterable[Message]]

QUESTIONS: dict[str, tuple[Verb, Answer]] = {}
"""Each question about the scene with the function that answers it, by address."""


def _question(
    address: str, help: str, required: tuple[Parameter, ...] = (), optional: tuple[Number, ...] = ()
) -> Callable[[Answer], Answer]:
    """Return a decorator that declares the question which a function answers."""

    def declare(answer: Answer) -> Answer:
        QUESTIONS[address] = Verb(address, help, required, optional, scored=False), answer
        return answer

    return declare


@_question(
    "/object/NAME/get",
    "answers with `/object/NAME/get.reply` and pairs of key and value: preset, shape, mass (kg), modes, settings. "
    "The argument `modes` adds `/object/NAME/get.modes FIRST TOTAL`, then each mode's frequency (Hz) and T60 (s)",
    optional=(Number("modes", 0, 4096, "", "number of modes to list", default=0, whole=True),),
)
def _object(scene: Asked, values: Values) -> Iterator[Message]:
    target = values.words["NAME"]
    found = scene.objects_at(target)
    if not found:
        there = list(islice(scene.objects_there(), MOST_COMPARED))
        raise Refused(f"{shown(target)}: no such object; {suggestion(target, there) or there_are(there)}")
    for name, obj in found.items():
        spectrum = obj.modes
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
        count = min(int(values.number("modes")), len(spectrum.frequency))
        modes = [
            (ratio * float(spectrum.frequency[i]), _T60 / float(spectrum.decay[i]) if spectrum.decay[i] else 0.0)
            for i in range(count)
        ]
        if count:
            yield from in_parts(f"/object/{name}/get.modes", (), modes)


@_question("/objects", "answers with `/objects.reply FIRST TOTAL`, then pairs of name and preset")
def _objects(scene: Asked, values: Values) -> Iterator[Message]:
    there = [(name, obj.preset.name) for name, obj in scene.objects_there().items()]
    yield from in_parts("/objects.reply", (), there)


@_question("/gestures", "answers with `/gestures.reply FIRST TOTAL`, then pairs of id and address")
def _gestures(scene: Asked, values: Values) -> Iterator[Message]:
    yield from in_parts("/gestures.reply", (), scene.running())


@_question(
    "/presets",
    "answers with `/presets.reply KIND FIRST TOTAL`, then names",
    (Either("kind", ("objects", "strikers", "surfaces", "materials"), "kind of presets"),),
)
def _presets(scene: Asked, values: Values) -> Iterator[Message]:
    kind = values.words["kind"]
    yield from in_parts("/presets.reply", (kind,), [(name,) for name in scene.presets.names(kind)])


def tuning_of(obj: Object) -> float:
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
