"""The tracker for hosts without Python: it finds what a World finds, of bodies that are made at run time too."""

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest

from carom.dsp.engine.memory.commands import Kind
from carom.presets import Presets
from carom.server.bridge import touching
from carom.server.bridge.hearing import Hearing, Microphone
from carom.server.bridge.simulation import Simulation
from carom.server.bridge.step import Pose, Touch
from carom.server.bridge.touching import BODY_ROW, TOUCHING, body_row

RATE, FRAME, GRAVITY, RADIUS = 48_000.0, 1 / 60, 9.81, 0.03
EARS = tuple(Microphone((0.0, 0.0, 1.5), (side, 0.0, 0.0)) for side in (-1.0, 1.0))
NAN = math.nan


def simulation() -> Simulation:
    """Return a simulation of a floor, a ball and a box, as touching.py hears it."""
    made = Simulation(Presets(), 20_000.0, Hearing(EARS, gestures=16, rests=0))
    made.add("floor", "plate", (4.0, 4.0, 0.02), "wood", held=1)
    made.add("ball", "sphere", RADIUS, "steel")
    made.add("box", "box", (0.2, 0.15, 0.1), "glass")
    return made


class Tracker:
    """The memory of a tracker, with the bodies of a simulation, whose objects are in slots 10 and on."""

    def __init__(self, of: Simulation) -> None:
        self.memory = np.zeros(1, TOUCHING)
        self.at = self.memory.ctypes.data
        touching.begin(self.at, RATE, 16)
        record, count = of.state[0], len(of.materials)
        for a in range(count):
            for b in range(count):
                law = np.array([*record["law"][a, b], record["surface"][a, b]])
                assert touching.set_law(self.at, a, b, law.ctypes.data) == 1
        for surface in range(len(of.surfaces)):
            command = self.memory["link"]["blank"].copy()
            assert touching.set_slide(self.at, surface, 1e-6, command.ctypes.data) == 1
        for number in range(len(of.bodies)):
            assert self.make(body_row(record, number), slot=10 + number) == number

    @property
    def state(self) -> np.void:
        found: np.void = self.memory["tracker"][0]
        return found

    def make(self, row: np.ndarray, size: float = 1.0, slot: int = 0) -> int:
        change = np.array([math.log2(size), 0.0, 0.0, -1.0])
        return int(touching.make_body(self.at, row.ctypes.data, change.ctypes.data, slot, 1 + slot))

    def move(self, body: int, pose: Pose) -> int:
        row = np.array([body, *pose.position, *pose.turn, *pose.velocity, *pose.spin], np.float64)
        return int(touching.move(self.at, row.ctypes.data))

    def touch(self, a: int, b: int, touch: Touch) -> int:
        row = np.array([a, b, *touch.point, *touch.normal, *touch[4:]], np.float64)
        return int(touching.touch(self.at, row.ctypes.data))

    def frame(self, seconds: float = FRAME, position: int = 0, load: float = 0.0) -> list[np.void]:
        """End a frame, and return its commands."""
        count = touching.end_frame(self.at, seconds, position, 0, load)
        ring = self.memory["ring"][0]
        first = int(self.memory["read"][0])
        assert [touching.command_at(self.at, n) for n in range(count)] == [
            TOUCHING.fields["ring"][1] + (first + n) % len(ring) * ring.itemsize for n in range(count)
        ]
        return [ring[(first + n) % len(ring)].copy() for n in range(count)]


def frames(seconds: float) -> Iterator[tuple[list[Touch], dict[str, Pose]]]:
    """Yield the frames of a ball that falls, bounces and rolls on, beside a box that slides until it stands."""
    height, falls, x, speed, spin, slides, far = 0.5, 0.0, 0.0, 1.0, 0.0, 1.5, 0.0
    for _ in range(round(seconds / FRAME)):
        falls -= GRAVITY * FRAME
        height += falls * FRAME
        x += speed * FRAME
        far += slides * FRAME
        touches = []
        if height <= RADIUS:
            touches.append(Touch("floor", "ball", (x, 0.0, 0.0), (0.0, 0.0, 1.0), approach=-falls))
            height, falls, spin = RADIUS, (-0.6 * falls if falls < -0.4 else 0.0), speed / RADIUS
        for corner in (-0.1, 0.1):
            at = (far + corner, 0.5, 0.0)
            touches.append(Touch("floor", "box", at, (0.0, 0.0, 1.0), slip=slides, impulse=0.5 * 7.5 * GRAVITY * FRAME))
        yield (
            touches,
            {
                "ball": Pose((x, 0.0, height), (1.0, 0.0, 0.0, 0.0), (speed, 0.0, falls), (0.0, spin, 0.0)),
                "box": Pose((far, 0.5, 0.05), (1.0, 0.0, 0.0, 0.0), (slides, 0.0, 0.0)),
            },
        )
        slides = max(slides - 0.3 * GRAVITY * FRAME, 0.0)


def test_it_finds_what_a_world_finds() -> None:
    """Blows, slides and rolls of frames are those of a World, to the bit; each is a command to its object."""
    wanted = simulation()
    tracker, numbers = Tracker(wanted), {"floor": 0, "ball": 1, "box": 2}
    time, kinds = 0.0, []
    for touches, poses in frames(2.0):
        time += FRAME
        wanted.step(time, touches, poses)
        for name, pose in poses.items():
            assert tracker.move(numbers[name], pose) == 1
        for touch in touches:
            assert tracker.touch(numbers[touch.a], numbers[touch.b], touch) == 1
        commands = tracker.frame()
        kinds += [(int(each["kind"]), int(each["what"])) for each in commands]
        struck = int(wanted.state["struck"][0])
        assert tracker.state["struck"] == struck
        assert tracker.state["blows"][:struck].tobytes() == wanted.state["blows"][0, :struck].tobytes()
        for name in ("hits", "faint", "begun", "heard", "touching", "changed"):
            assert tracker.state[name] == wanted.state[name][0], name
        for each in commands:
            if each["kind"] in (Kind.GESTURE, Kind.PLACE):
                assert 10 <= each["slot"] < 13 and each["serial"] == each["slot"] + 1
    assert tracker.state["hits"] >= 3 and tracker.state["begun"] == 2
    assert kinds.count((int(Kind.STOP), 0)) == 1  # of the box, which stands at last; the ball rolls on
    assert kinds.count((int(Kind.GESTURE), 0)) >= 3 and kinds.count((int(Kind.PLACE), 0)) >= 4


def test_a_body_in_another_size_is_similar() -> None:
    """A body made in twice the size, of a row, has the numbers of one that a World makes so large."""
    wanted = simulation()
    wanted.add("large", "sphere", 2 * RADIUS, "steel")
    tracker = Tracker(wanted)
    made = tracker.make(body_row(wanted.state[0], 1), 2.0)
    large = 3
    for name in ("lightness", "yielding", "edges", "reach", "round", "rings", "strip", "flat", "material"):
        np.testing.assert_allclose(tracker.state[name][made], wanted.state[name][0, large], rtol=1e-12, err_msg=name)
    loud, itself = (np.log10(each) for each in (tracker.state["loudness"][made], wanted.state["loudness"][0, large]))
    smaller = np.log10(wanted.state["loudness"][0, 1])
    audible = slice(2, 14)  # contacts of 4 us to 8 ms
    assert np.abs(loud - itself)[audible].max() < 0.1 < np.abs(smaller - itself)[audible].max()  # 2 dB
    assert math.isclose(tracker.state["ringing"][made], wanted.state["ringing"][0, large], rel_tol=0.2)


def test_numbers_of_bodies_are_given_again() -> None:
    """A freed body's number is another's once its pairs have ended; touches of it are refused meanwhile."""
    wanted = simulation()
    tracker, touch = Tracker(wanted), Touch("floor", "ball", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), approach=1.0)
    row = body_row(wanted.state[0], 1)
    assert tracker.touch(0, 1, touch) == 1 and len(tracker.frame()) > 0
    touching.free_body(tracker.at, 1)
    assert (tracker.touch(0, 1, touch), tracker.move(1, Pose((0.0, 0.0, 1.0)))) == (0, 0)
    assert tracker.make(row) == 3  # the pair of number 1 has not ended
    for _ in range(20):
        assert not [each for each in tracker.frame() if each["kind"] == Kind.GESTURE]
    assert tracker.make(row) == 1
    assert tracker.touch(0, 1, touch) == 1 and any(each["kind"] == Kind.GESTURE for each in tracker.frame())


def test_a_body_that_touches_in_this_frame_keeps_its_number() -> None:
    tracker = Tracker(simulation())
    row, touch = body_row(simulation().state[0], 1), Touch("floor", "ball", (0.0,) * 3, (0.0, 0.0, 1.0), approach=1.0)
    assert tracker.touch(0, 1, touch) == 1
    touching.free_body(tracker.at, 1)
    assert tracker.make(row) == 3


@pytest.mark.parametrize("seconds", [0.0, -1.0, NAN, 1e-300, 9e-7, 1.1e6, 1e12, math.inf])
def test_a_frame_that_cannot_be_is_refused_with_its_touches(seconds: float) -> None:
    tracker = Tracker(simulation())
    assert tracker.touch(0, 1, Touch("floor", "ball", (0.0,) * 3, (0.0, 0.0, 1.0), approach=1.0)) == 1
    assert touching.end_frame(tracker.at, seconds, 0, 0, 0.0) == -1
    assert not [each for each in tracker.frame() if each["kind"] == Kind.GESTURE]


@pytest.mark.parametrize("place", range(BODY_ROW))
@pytest.mark.parametrize("value", [NAN, math.inf, -1.0])
def test_a_row_that_cannot_be_makes_no_body(place: int, value: float) -> None:
    tracker = TRACKER
    row = body_row(SIMULATION.state[0], 1)
    row[place] = value
    assert tracker.make(row) == -2


SIMULATION = simulation()
TRACKER = Tracker(SIMULATION)


def test_what_cannot_touch_or_move_is_refused() -> None:
    tracker, up = TRACKER, (0.0, 0.0, 1.0)
    good = Touch("floor", "ball", (0.0, 0.0, 0.0), up)
    for a, b in ((-1, 1), (0, 3), (0, 10**9), (NAN, 1)):
        assert tracker.touch(a, b, good) == 0  # type: ignore[arg-type]
    for wrong in ({"point": (NAN, 0, 0)}, {"normal": (0, 0, 2)}, {"approach": 1.0, "impulse": 1.0}, {"slip": -1.0}):
        assert tracker.touch(0, 1, good._replace(**wrong)) == 0, wrong
    assert tracker.move(1, Pose((0, 0, 0), (1, 1, 0, 0))) == 0


def test_a_listener_that_moves_hears_more_of_what_is_near() -> None:
    """Each body's gains follow the listener's place, and his right ear."""
    tracker = Tracker(SIMULATION)
    touch = Touch("floor", "ball", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), approach=1.0)
    gains = []
    for place, right in (((-1.0, 0.0, 0.0), (0.0, -1.0, 0.0)), ((0.0, -2.0, 0.0), (3.0, 0.0, 0.0)),
                         ((-1.0, 0.0, 0.0), (1.0, 0.0, 0.0))):  # fmt: skip
        told = np.array([*place, *right])
        assert touching.listen(tracker.at, told.ctypes.data) == 1
        tracker.move(1, Pose((0.0, 0.0, 0.0), velocity=(0.0, 0.0, -1.0)))
        tracker.touch(0, 1, touch)
        found = [each for each in tracker.frame() if each["kind"] == Kind.PLACE and each["slot"] == 10]
        gains.append({int(each["channel"]): float(each["value"]) for each in found})
        for _ in range(30):
            tracker.frame()
    assert gains == [
        pytest.approx({0: 0.5, 1: 0.5}),
        pytest.approx({0: 0.25, 1: 0.25}),
        pytest.approx({0: 0.0, 1: 1.0}),
    ]


def test_events_come_at_once_and_in_time_though_the_engine_goes_in_blocks() -> None:
    """What happens in a frame is never before the engine's sample, and not long after it, for any of its blocks."""
    tracker, block, played = Tracker(SIMULATION), 1_024, 0
    touch = Touch("floor", "ball", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), approach=1.0)
    late = []
    for frame in range(1, 600):
        at = frame * FRAME * RATE * 1.001  # the game's clock and the sound's differ
        played = int(at // block) * block
        if frame % 30 == 0:
            tracker.touch(0, 1, touch)
        late += [
            each["time"] - played for each in tracker.frame(position=played) if each["kind"] == Kind.GESTURE
        ]  # fmt: skip
    assert len(late) == 19 and min(late) >= 0.0 and max(late) <= block + 0.02 * RATE


def test_a_load_above_the_share_ends_the_faintest_slides_and_a_small_one_lets_them_begin_again() -> None:
    """Two boxes slide; as the sound takes too much, the slower one is left out first, then the other; nothing is left
    out without a share."""
    own = simulation()
    own.add("other", "box", (0.2, 0.15, 0.1), "glass")
    tracker, heard = Tracker(own), []
    for frame in range(700):
        for body, speed in ((2, 1.0), (3, 0.5)):
            at = (speed * frame * FRAME, float(body), 0.05)
            tracker.move(body, Pose(at, velocity=(speed, 0.0, 0.0)))
            tracker.touch(0, body, Touch("floor", "box", (at[0], at[1], 0.0), (0.0, 0.0, 1.0), slip=speed))
        if frame == 100:
            assert touching.govern(tracker.at, 0.2) == 1 and touching.govern(tracker.at, 1.5) == 0
        tracker.frame(load=0.5 if frame < 200 else 0.01)
        pairs = tracker.state["pairs"][: tracker.state["touching"]]
        heard.append(sorted(int(each["b"]) for each in pairs if each["moves"] == 2))
    assert heard[99] == [2, 3] == heard[-1]
    assert [each for n, each in enumerate(heard[100:200]) if each != heard[99 + n]] == [[2], []]
    assert tracker.state["unheard"] >= 2


def test_bodies_that_lie_cost_no_command() -> None:
    """Boxes land on a floor and on each other, and lie there: from then on no frame sends anything."""
    tracker = Tracker(simulation())
    row, numbers = body_row(simulation().state[0], 2), [0]
    numbers += [tracker.make(row, slot=20 + n) for n in range(6)]
    sent = []
    for frame in range(120):
        for n, (below, box) in enumerate(pairwise(numbers)):
            approach = 1.0 if frame == 0 else GRAVITY * FRAME  # as engines report it that pull first
            for corner in (-0.1, 0.1):
                point = (corner, 0.0, 0.1 * n)
                assert tracker.touch(below, box, Touch(below, box, point, (0.0, 0.0, 1.0), approach=approach)) == 1
            assert tracker.move(box, Pose((0.0, 0.0, 0.1 * n + 0.05))) == 1
        sent.append([int(each["kind"]) for each in tracker.frame()])
    assert sent[0].count(int(Kind.GESTURE)) == 6
    assert not any(int(Kind.GESTURE) in each for each in sent[1:]) and not any(sent[30:]), sent
