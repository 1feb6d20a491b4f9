"""Standing contacts: those that slip or sweep, as slides, of which a roll is one without slip; those that lie, as
rests."""

import math
from collections.abc import Mapping

from ...dsp.bodies.material import contact_between
from ...dsp.numerics.constants import HARDEST_REST
from ...dsp.schema import MASS
from ...presets.supports import SUPPORTS
from .bodies import Body
from .pairs import law_of
from .requests import Ending, Lying, Slide
from .step import Event

_STATIC, _DYNAMIC = 0.4, 0.3
_STRIDE, _SEEDS = 1_000_003, 2**31
_GROUND = "table"  # with a law of its own and without resistance it is any rigid ground

Key = tuple[int, int]


class Gestures:
    """The slides and rests that go on which Python has begun, by the numbers of their bodies."""

    def __init__(self) -> None:
        self.running: dict[Key, str] = {}

    def begin(self, event: Event, to: Body, by: Body, surface: str, keys: Mapping[str, float]) -> Slide:
        """Begin a slide of one body on another, as an event and the keys of its pair say."""
        id = self.running[event.a, event.b] = id_of(event.slide)
        law = {"mass": event.mass, "stiffness": event.stiffness, "exponent": event.exponent}
        given = _keys(event.patch, event.radius, surface, {**law, **keys})
        slip, sweep, force, place = event.motion[:4]
        other, by_place = (by.name, event.by_place) if by.rings else ("", 0.0)
        points = to.point(event.local[event.side]), by.point(event.local[1 - event.side])
        return Slide(event.time, to.name, other, id, place, by_place, slip, sweep, force, event.seed, given, *points)

    def lie(self, event: Event, to: Body, by: Body, support: str) -> Lying:
        """Begin a rest of one body, `by`, on another, or of the one that rings on the other, which is rigid ground
        then. support: whose law it has, and, of a hand, whose flesh moves; empty: the law of both materials."""
        id = self.running[event.a, event.b] = id_of(event.slide)
        place = event.motion[3]
        lies, ground, place, its_place = (by, to, event.by_place, place) if by.rings else (to, by, place, 0.0)
        on, under = event.local[1 - event.side], event.local[event.side]
        point, its_point = (lies.point(on), ground.point(under)) if by.rings else (lies.point(under), ())
        law, mass, behind = _law(lies, ground, support, event.radius), event.mass, 0.0
        if support:
            mass, behind = min(mass, SUPPORTS[support].mass or mass), SUPPORTS[support].resistance
        keys = {**law, "mass": min(max(mass, MASS.low), MASS.high)}
        most = min(HARDEST_REST * keys["mass"], SUPPORTS[support].most if support else math.inf)
        if not ground.rings:
            keys["resistance"] = behind
        elif not its_point:
            keys["by_position"] = its_place
        what = ground.name if ground.rings else support or _GROUND
        load = min(event.motion[2], most)
        return Lying(event.time, lies.name, what, id, place, load, tuple(keys.items()), point, its_point)

    def rest(self, event: Event) -> list[Ending]:
        """End a slide or a rest, if it goes on."""
        id = self.running.pop((event.a, event.b), None)
        return [Ending(event.time, id)] if id else []


def _law(lies: Body, ground: Body, support: str, radius: float) -> dict[str, float]:
    """Return the keys of the law of a rest."""
    law = law_of(support) if support else contact_between(lies.material, ground.material, radius)
    return dict(zip(("stiffness", "dissipation", "exponent"), law, strict=True))


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
    """Return the id of a slide or of a rest."""
    return f"contact.{number}"
