"""Standing contacts that slip or sweep, as slides: a roll is one without slip."""

from collections.abc import Mapping

from .bodies import Body
from .requests import Ending, Slide
from .step import Event

_STATIC, _DYNAMIC = 0.4, 0.3
_STRIDE, _SEEDS = 1_000_003, 2**31

Key = tuple[int, int]


class Gestures:
    """The slides that go on which Python has begun, by the numbers of their bodies."""

    def __init__(self) -> None:
        self.running: dict[Key, str] = {}

    def begin(self, event: Event, to: Body, by: Body, surface: str, keys: Mapping[str, float]) -> Slide:
        """Begin a slide of one body on another, as an event and the keys of its pair say."""
        id = self.running[event.a, event.b] = id_of(event.slide)
        law = {"mass": event.mass, "stiffness": event.stiffness, "exponent": event.exponent}
        given = _keys(event.patch, event.radius, surface, {**law, **keys})
        slip, sweep, force, place = event.motion
        other, by_place = (by.name, event.by_place) if by.rings else ("", 0.0)
        return Slide(event.time, to.name, other, id, place, by_place, slip, sweep, force, event.seed, given)

    def rest(self, event: Event) -> list[Ending]:
        """End a slide, if it goes on."""
        id = self.running.pop((event.a, event.b), None)
        return [Ending(event.time, id)] if id else []


def template(body: Body, surface: str, radius: float) -> Slide:
    """Return a slide on a body and a surface, in which the numbers of a contact are yet to be written."""
    law = {"mass": 1.0, "stiffness": 1e6, "exponent": 1.5}
    return Slide(0.0, body.name, "", id_of(0), 0.0, 0.0, 1.0, 1.0, 1.0, 0, _keys(0.0, radius, surface, law))


def _keys(patch: float, radius: float, surface: str, more: Mapping[str, float]) -> tuple[tuple[str, float | str], ...]:
    """Return the keys of a slide, what its pair says last."""
    given = {"static": _STATIC, "dynamic": _DYNAMIC, "patch": patch, "radius": radius, **more}
    if "static" in more or "dynamic" in more:
        given["dynamic"] = min(given["dynamic"], given["static"])
    return (*given.items(), ("surface", surface))


def seed_of(seed: int) -> int:
    """Return the first seed of a simulation's slides."""
    return seed * _STRIDE % _SEEDS


def id_of(number: int) -> str:
    """Return the id of a slide."""
    return f"contact.{number}"
