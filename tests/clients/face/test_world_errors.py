"""Refusals of a World: one error names the body and the step, and nothing has changed."""

import math

import numpy as np
import pytest

from carom import Hearing, Microphone, Pose, Touch, World, WorldError
from tests.clients.face.test_world import furnished

ONE = {"pair": [[0, 1]], "point": [[0, 0, 0]], "normal": [[0, 0, 1]]}


def told(world: World, **columns) -> None:
    world.step(0.02, {**ONE, **columns})


def touch(world: World, *names: str, point=(0, 0, 0), normal=(0, 0, 1)) -> None:
    world.step(0.02, [Touch(*names, point, normal, approach=1.0)])


def pose(world: World, *pose) -> None:
    world.step(0.02, (), {"ball": Pose(*pose)})


WRONG = {
    "step 2: body bal: no such body; did you mean ball?": lambda w: touch(w, "floor", "bal"),
    "step 2: body ball: position = (nan, 0, 0): expected 3 numbers": lambda w: pose(w, (math.nan, 0, 0)),
    "step 2: body ball: turn = (0, 0, 0, 0): expected a quaternion": lambda w: pose(w, (0, 0, 0), (0, 0, 0, 0)),
    "step 2: time = 0.005: expected above 0.01": lambda w: w.step(0.005),
    "step 2: time = nan": lambda w: w.step(math.nan),
    "step 2: bodies floor, ball: point = [0.0, nan, 0.0]": lambda w: touch(w, "floor", "ball", point=(0, math.nan, 0)),
    "step 2: bodies floor, ball: normal = [0.0, 0.0, 2.0]": lambda w: touch(w, "floor", "ball", normal=(0, 0, 2)),
    "step 2: bodies number 0.9, ball: expected numbers below 2": lambda w: told(w, pair=[[0.9, 1]]),
    "step 2: bodies floor, ball: approach = inf: expected a number from": lambda w: told(w, approach=[math.inf]),
    "step 2: bodies floor, ball: mass = -1.0: expected a number from": lambda w: told(w, mass=[-1]),
    "step 2: bodies floor, ball: restitution = 5.0: expected a number from 0 to 1": lambda w: told(w, restitution=[5]),
    "step 2: contacts: approach = ['a']: expected numbers": lambda w: told(w, approach=["a"]),
    "step 2: contacts = None: expected a list of Touch": lambda w: w.step(0.02, None),
    "step 2: contacts = Touch(": lambda w: w.step(0.02, Touch("floor", "ball", (0, 0, 0), (0, 0, 1))),
    "step 2: contacts: ('floor', 'ball'): expected a Touch": lambda w: w.step(0.02, [("floor", "ball")]),
    "step 2: poses = ['ball']: expected a mapping": lambda w: w.step(0.02, (), ["ball"]),
    "step 2: body ball: (0, 0, 0): expected a Pose": lambda w: w.step(0.02, (), {"ball": (0, 0, 0)}),
    "step 2: body ball: position = ('a', 0, 0): expected 3 numbers": lambda w: pose(w, ("a", 0, 0)),
    "step 2: time = '1': expected a number": lambda w: w.step("1"),
    "step 2: time = 10000000.0: expected at most 3600 s after 0.01": lambda w: w.step(1e7),
    "seconds = '1': expected a number from 0 to 3600 s": lambda w: w.ring("1"),
    "time = '1': expected a number from -1e+09 to 1e+09 s": lambda w: w.restart("1"),
    "body 3: name = 3: expected 1 to 64 printable": lambda w: w.body(3, "sphere", 0.1, "steel"),
    "body a: size = 'big': expected a radius": lambda w: w.body("a", "sphere", "big", "steel"),
    "body a: inertia = nan: expected a number": lambda w: w.body("a", "sphere", 0.1, "steel", inertia=[math.nan] * 3),
    "body a: inertia = 'x': expected three moments": lambda w: w.body("a", "sphere", 0.1, "steel", inertia="x"),
    "body a: held = no: expected True or False": lambda w: w.body("a", "sphere", 0.1, "steel", held="no"),
    "body a: size: vertex 0 = [nan, nan, nan]": lambda w: w.body("a", "mesh", np.full((5, 3), math.nan), "steel"),
    "body a: size, of shapes (3, 3) and (1, 3), of f": lambda w: w.body("a", "mesh", (np.eye(3), [[0, 1, 2.5]]), "tin"),
    "seconds = -1: expected a number from 0 to 3600 s": lambda w: w.ring(-1),
    "time = nan: expected a number from -1e+09 to 1e+09 s": lambda w: w.restart(math.nan),
    "body a: /object/new: damp": lambda w: w.body("a", "sphere", 0.1, "steel", damp=2),
    "step 2: bodies ball, number 7: expected numbers below 2": lambda w: told(w, pair=[[1, 7]]),
    "step 2: contacts: points: did you mean point?": lambda w: told(w, points=[[0, 0, 0]]),
    "body ball: there is one of that name": lambda w: w.body("ball", "sphere", 0.1, "steel"),
    "body a: shape = spere: did you mean sphere?": lambda w: w.body("a", "spere", 0.1, "steel"),
    "body a: size = [-0.1]: expected a radius": lambda w: w.body("a", "sphere", -0.1, "steel"),
    "body a: no material 'stel': did you mean steel?": lambda w: w.body("a", "sphere", 0.1, "stel"),
    "body a: size = [1e+300]: expected a radius, in m, from 1e-06": lambda w: w.body("a", "sphere", 1e300, "wood"),
    "body a: size = [1e-300]: expected a radius": lambda w: w.body("a", "sphere", 1e-300, "steel"),
    "body a: size: vertices with edges [1e+300": lambda w: w.body("a", "mesh", 1e300 * np.eye(4)[:, :3], "steel"),
    "body a: density = 1e-35: expected a": lambda w: w.body("a", "sphere", 0.1, "steel", density=1e-35),
    "body a: mass = -1: expected a number from 1e-15": lambda w: w.body("a", "sphere", 0.1, "steel", mass=-1),
    "body a: most_mods = 3: did you mean most_modes?": lambda w: w.body("a", "sphere", 0.1, "steel", most_mods=3),
    "pair floor, ball: no surface 'wod': did you mean wood?": lambda w: w.pair("floor", "ball", surface="wod"),
    "pair ball, ball: expected two bodies": lambda w: w.pair("ball", "ball"),
    "pair floor, ball: frction = 1": lambda w: w.pair("floor", "ball", frction=1),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("text", WRONG)
def test_one_error_names_the_body_and_the_step(text):
    with furnished() as world:
        world.step(0.01)
        with pytest.raises(WorldError) as found:
            WRONG[text](world)
        assert str(found.value).startswith(text)
        # Nothing has changed.
        assert world.bodies == ("floor", "ball") and world.time == 0.01
        if "step 2" in text:
            touch(world, "floor", "ball")
            assert len(world.hits) == 1


def test_a_step_that_is_refused_moves_no_body():
    with furnished() as world:
        world.step(0.01)
        where = world.memory["position"][0, :2].tolist()
        there, nowhere = Pose((9, 9, 9)), Pose((math.nan, 0, 0))
        for time, contacts, poses in (
            (0.02, (), {"ball": there, "floor": nowhere}),
            (0.005, (), {"ball": there}),
            (0.02, [Touch("floor", "ball", (0, 0, 0), (0, 0, 2))], {"ball": there}),
        ):
            with pytest.raises(WorldError):
                world.step(time, contacts, poses)
        assert world.memory["position"][0, :2].tolist() == where


@pytest.mark.parametrize(
    "text, options",
    [
        ("rate = 0: expected", {"rate": 0}),
        ("microphones: (0, 0): expected a Microphone or a place", {"microphones": [(0, 0)]}),
        ("microphones: 0: expected a Microphone or a place", {"microphones": (0, -1, 0.5)}),
        ("gravity = (0, 0, -9.81): expected a number", {"gravity": (0, 0, -9.81)}),
        ("start = '1': expected a number from -1e+09 to 1e+09 s", {"start": "1"}),
    ],
)
def test_a_world_that_cannot_be_is_refused(text, options):
    with pytest.raises(WorldError) as found:
        World(**options)
    assert str(found.value).startswith(text)


def test_microphones_of_a_hearing_may_be_places():
    assert Hearing([(0, 0, 1)]).microphones == (Microphone((0.0, 0.0, 1.0)),)
    with pytest.raises(WorldError, match="expected a Microphone or a place"):
        Hearing([(0, 0)])
