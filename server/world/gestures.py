"""Standing contacts that slip or sweep, as slides: a roll is one without slip."""

from collections.abc import Mapping

from .bodies import Body
from .requests import Ending, Request, Slide, Steering
from .step import Event

_LEAST = 1e-6  # m/s, N: a slide of 0 would end
_CHANGED, _SLOW, _AWAY = 0.05, 0.004, 0.01  # shares, m/s or N, and of a strike path: what is told anew
_FLAT = 0.002  # m: width of the contact of two faces, of which a corner carries at a time
_STATIC, _DYNAMIC = 0.4, 0.3
_STRIDE, _SEEDS = 1_000_003, 2**31

Key = tuple[int, int]


class Gestures:
    """The slides that go on, by the numbers of their bodies."""

    def __init__(self, seed: int = 0) -> None:
        self.running: dict[Key, str] = {}
        self._said: dict[Key, dict[str, float]] = {}  # as it was told last
        self._made = 0
        self._seed = seed

    def begin(
        self,
        key: Key,
        event: Event,
        side: int,
        bodies: tuple[Body, Body],
        places: tuple[float, float],
        keys: Mapping[str, float | str],
    ) -> list[Request]:
        """Begin a slide on the first of two bodies, `side` of the pair, at places of both."""
        self._made += 1
        self.running[key] = f"contact.{self._made}"
        to, by = bodies
        slip, sweep, force = _motion(event, side)
        self._said[key] = {"speed": slip, "sweep": sweep, "force": force, "position": places[0]}
        round_ = to.shape.round or by.shape.round
        given: dict[str, float | str] = {
            "static": _STATIC, "dynamic": _DYNAMIC, "patch": 0.0 if round_ else _FLAT, **keys
        }  # fmt: skip
        if "static" in keys or "dynamic" in keys:
            given["dynamic"] = min(float(given["dynamic"]), float(given["static"]))
        seed = (self._seed * _STRIDE + self._made) % _SEEDS
        other, by_place = (by.name, places[1]) if by.rings else ("", 0.0)
        return [
            Slide(event.time, to.name, other, self.running[key], places[0], by_place, slip, sweep, force, seed,
                  tuple(given.items()))
        ]  # fmt: skip

    def steer(self, key: Key, event: Event, side: int, place: float) -> list[Request]:
        """Steer a slide."""
        slip, sweep, force = _motion(event, side)
        said = self._said[key]
        found: list[Request] = []
        for name, value in {"speed": slip, "sweep": sweep, "force": force, "position": place}.items():
            least = _AWAY if name == "position" else _CHANGED * max(said[name], _SLOW)
            if abs(value - said[name]) > least:
                said[name] = value
                found.append(Steering(event.time, self.running[key], name, value))
        return found

    def rest(self, key: Key, event: Event) -> list[Request]:
        """End a slide, if it goes on."""
        id = self.running.pop(key, None)
        self._said.pop(key, None)
        return [Ending(event.time, id)] if id else []


def _motion(event: Event, side: int) -> tuple[float, float, float]:
    """Slip and sweep over a side of the pair (m/s), and force (N), as a slide takes them."""
    slip = min(max(event.slip, _LEAST), 100.0)
    return slip, min(event.sweep[side], 100.0), min(max(event.force, _LEAST), 1e5)
