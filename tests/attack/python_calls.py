"""Calls of Python's own face with arguments of any kind: numbers that can't be, other types, arrays of all shapes."""

import inspect
import math
import random
from collections.abc import Callable, Iterator
from decimal import Decimal
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np

import carom
from tests.attack import Tried, kind
from tests.attack.children import Child, Died
from tests.attack.extremes import any_value

_SECONDS = 20
_LONG = 10.0  # s of sound, beyond which a call may take as long as it says
_LEFT = {"save", "plot", "close", "score", "reporter"}  # methods that write, show or end, or are for bridges
_LENGTHS = {"seconds", "frames", "time", "at"}
_PLAUSIBLE: dict[str, tuple[Any, ...]] = {
    "name": ("a", "b", "world/x"), "preset": ("wood-block", "wine-glass"), "at": (None, 0.0, 0.1),
    "seconds": (0.05, 0.3), "rate": (48_000, 8_000, 44_100), "frames": (64, 1_000), "channels": (1, 2, 8),
    "velocity": (1.0,), "position": (0.3,), "over": (0.1,), "time": (0.0, 0.01, 0.02),
    "a": ("x",), "b": ("y",), "shape": ("sphere", "box"), "size": ((0.1, 0.2, 0.3), (0.05,)),
    "material": ("steel", "wood"),
}  # fmt: skip


@kind("python", 60)
def python(chance: random.Random) -> Iterator[Tried]:
    """A few calls of a scene, a world, a render, a fit or a mesh, one of whose arguments at least is odd."""
    with Child() as child:
        while True:
            seed = chance.getrandbits(48)
            try:
                refused, fine = child.run(attempt, seed, cpu=_SECONDS)
                yield Tried(refused, fine)
            except Died as died:
                yield Tried(faults=(f"{died}: attempt({seed})",))


def attempt(seed: int) -> tuple[int, int]:
    """Make the calls of a seed; return how many were refused, and how many were not. An error that
    does not say what was expected is raised."""
    chance, refused, fine = random.Random(seed), 0, 0
    for call in chance.choice((_of_a_scene, _of_a_scene, _of_a_world, _of_functions))(chance):
        try:
            call()
            fine += 1
        except (carom.CaromError, TypeError, ValueError) as error:
            if not isinstance(error, carom.CaromError) and "expected" not in str(error):
                raise
            assert str(error), "a refusal that says nothing"
            refused += 1
    return refused, fine


def _of_a_scene(chance: random.Random) -> Iterator[Callable[[], object]]:
    if chance.random() < 0.3:
        yield partial(carom.Scene, **_keys(chance, carom.Scene.__init__))
    scene = carom.Scene(48_000)
    thing = scene.new("a", "wood-block")
    for _ in range(8):
        yield _call(chance, chance.choice((scene, scene, thing)))
    yield partial(scene.render, 0.02)


def _of_a_world(chance: random.Random) -> Iterator[Callable[[], object]]:
    if chance.random() < 0.5:
        yield partial(carom.World, **_keys(chance, carom.World.__init__))
    world = carom.World(48_000)
    world.body("x", "sphere", (0.02,), "steel")
    for n in range(6):
        yield _call(chance, world)
        point = {name: _value(chance, name) for name in chance.sample(["position", "normal", "force", "slip"], 2)}
        yield partial(world.step, 0.01 * (n + 1), [{"a": "x", "b": "", **point}])
    yield world.sound


def _of_functions(chance: random.Random) -> Iterator[Callable[[], object]]:
    sound = np.sin(np.arange(4_000) / 9.0) * np.exp(-np.arange(4_000) / 400.0)
    score = "0 /object/new a wood-block\n0 /object/a/impact 1"
    points = np.array([(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)])
    faces = np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
    made = carom.render(score, seconds=0.02)
    for function, usual in (
        (carom.render, [score]), (carom.fit, [sound, 48_000]), (carom.mesh, [(points, faces)]),
        (carom.compare, [made, made]), (made.resample, [24_000]), (made.__getitem__, [slice(0, 9)]),
        (made.__add__, [made]), (carom.Presets, []),
    ):  # fmt: skip
        args = [_odd(chance) if chance.random() < 0.4 else each for each in usual]
        yield partial(function, *args, **_keys(chance, function, len(usual)))


def _call(chance: random.Random, thing: object) -> Callable[[], object]:
    """Return a call of a public method."""
    names = [name for name in dir(type(thing)) if not name.startswith("_") and name not in _LEFT]
    method = getattr(thing, chance.choice(names), None)
    if not callable(method):
        return lambda: method
    return partial(method, **_keys(chance, method))


def _keys(chance: random.Random, function: Callable[..., object], skipped: int = 0) -> dict[str, Any]:
    """Return values for a function's parameters: all that it needs, beyond those that are given, and some others."""
    found = {}
    parameters = list(inspect.signature(function).parameters.values())[skipped:]
    for each in parameters:
        if each.name == "self" or each.kind in (each.VAR_KEYWORD, each.VAR_POSITIONAL, each.POSITIONAL_ONLY):
            continue
        if each.default is each.empty or chance.random() < 0.3:
            found[each.name] = _value(chance, each.name)
    if any(each.kind == each.VAR_KEYWORD for each in parameters) and chance.random() < 0.5:
        found[chance.choice(("velocity", "striker", "gain", "mass", "id", "nonsense"))] = _odd(chance)
    return found


def _value(chance: random.Random, name: str) -> Any:
    if name in _PLAUSIBLE and chance.random() < 0.7:
        return chance.choice(_PLAUSIBLE[name])
    value = _odd(chance)
    if name in _LENGTHS and isinstance(value, int | float | Decimal | Fraction) and _LONG < abs(value) < math.inf:
        return -value
    return value


def _odd(chance: random.Random) -> Any:
    """Return a value of any type."""
    number = any_value(chance)
    real = float(number) if isinstance(number, int | float) and abs(number) < 1e308 else math.nan
    return chance.choice(
        [
            number, number, number, real, None, object(), 1j, Decimal("0.5"), Fraction(1, 3), {}, {"a": real}, {1},
            [real] * 3, [[real]], "a" * 300, np.float32(real if abs(real) < 1e38 else 1.0), np.int64(-1), np.array([]),
            np.full((2, 3), real), np.full(3, real), np.zeros((1, 1, 1)), np.array(["a"]), np.array([None]), iter(()),
            range(3), bytearray(3), len, type,
        ]
    )  # fmt: skip
