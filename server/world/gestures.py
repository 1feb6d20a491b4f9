"""Standing contacts that slip or sweep, as slides: a roll is one without slip."""

from collections.abc import Mapping

from .bodies import Body
from .requests import Ending, Slide
from .shapes import Vector
from .step import Event

_FLAT = 0.002  # m: width of the contact of two faces, of which a corner carries at a time
_STATIC, _DYNAMIC = 0.4, 0.3
_STRIDE, _SEEDS = 1_000_003, 2**31

Key = tuple[int, int]


class Gestures:
    """The slides that go on, by the numbers of their bodies."""

    def __init__(self, seed: int = 0) -> None:
        self.running: dict[Key, str] = {}
        self.made = 0
        """How many there were: the number of the last."""
        self._seed = seed

    def begin(
        self,
        key: Key,
        event: Event,
        bodies: tuple[Body, Body],
        by_at: Vector,
        keys: Mapping[str, float | str],
    ) -> Slide:
        """Begin a slide on the first of two bodies, which the second touches at a point (m) in its axes."""
        self.made += 1
        self.running[key] = id_of(self.made)
        to, by = bodies
        slip, sweep, force, place = event.motion
        round_ = to.shape.round or by.shape.round
        given: dict[str, float | str] = {
            "static": _STATIC, "dynamic": _DYNAMIC, "patch": 0.0 if round_ else _FLAT, **keys
        }  # fmt: skip
        if "static" in keys or "dynamic" in keys:
            given["dynamic"] = min(float(given["dynamic"]), float(given["static"]))
        seed = (self._seed * _STRIDE + self.made) % _SEEDS
        other, by_place = (by.name, by.place(by_at)) if by.rings else ("", 0.0)
        return Slide(event.time, to.name, other, self.running[key], place, by_place, slip, sweep, force, seed,
                     tuple(given.items()))  # fmt: skip

    def rest(self, key: Key, event: Event) -> list[Ending]:
        """End a slide, if it goes on."""
        id = self.running.pop(key, None)
        return [Ending(event.time, id)] if id else []


def id_of(number: int) -> str:
    """The id of a slide."""
    return f"contact.{number}"
