"""Contacts of a game in C: the library finds what a World finds; objects are made like others, and freed."""

import ctypes
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests import needs
from tests.clients.export.test_c import Report
from tests.server.bridge.test_touching import FRAME, RATE, frames, simulation

pytestmark = [pytest.mark.slow, needs.without("cc")]

NAN = math.nan


class Contacts(ctypes.Structure):
    _fields_ = [
        *((name, ctypes.c_long) for name in ("blows", "faint", "slides", "left_out")), ("loudest", ctypes.c_double),
        ("crowded", ctypes.c_long), ("bodies", ctypes.c_long),
    ]  # fmt: skip


class Game:
    """A scene with bodies, as a program in C has it."""

    def __init__(self, folder: Path) -> None:
        self.c = ctypes.CDLL(str(folder / "libcarom.so"))
        self.c.carom_open.restype, self.c.carom_answer.restype = ctypes.c_void_p, ctypes.c_char_p
        baked = (folder / "scene.carom").read_bytes()
        self.scene = ctypes.c_void_p(self.c.carom_open(baked, ctypes.c_size_t(len(baked)), 1))

    def send(self, message: str) -> str:
        """Send a message; "" or why it is refused."""
        taken = self.c.carom_send(self.scene, message.encode(), ctypes.c_double(-1.0))
        return "" if taken else self.why

    @property
    def why(self) -> str:
        return str(self.c.carom_answer(self.scene).decode())

    def body(self, name: str) -> int:
        return int(self.c.carom_body(self.scene, name.encode()))

    def move(self, body: int, position: Any, velocity: Any = (0, 0, 0), spin: Any = (0, 0, 0), turn: Any = None) -> int:
        turned = None if turn is None else _floats(*turn)
        return int(self.c.carom_move(self.scene, body, _floats(*position), turned, _floats(*velocity), _floats(*spin)))

    def touch(self, a: int, b: int, point: Any, normal: Any, impulse: float, speed: float, slip: float) -> int:
        numbers = (ctypes.c_float(each) for each in (impulse, speed, slip))
        return int(self.c.carom_touch(self.scene, a, b, _floats(*point), _floats(*normal), *numbers))

    def listen(self, position: Any, right: Any) -> int:
        return int(self.c.carom_listen(self.scene, _floats(*position), _floats(*right)))

    def frame(self, seconds: float = FRAME) -> int:
        taken = int(self.c.carom_frame(self.scene, ctypes.c_double(seconds)))
        self.process(round(seconds * RATE))
        return taken

    def process(self, frames: int) -> list[float]:
        sound = (ctypes.c_float * (2 * frames))()
        self.c.carom_process(self.scene, sound, ctypes.c_size_t(frames))
        return list(sound)

    @property
    def contacts(self) -> Contacts:
        told = Contacts()
        self.c.carom_report_contacts(self.scene, ctypes.byref(told))
        return told


def _floats(*numbers: float) -> Any:
    return (ctypes.c_float * len(numbers))(*numbers)


@pytest.fixture
def played(game: Path) -> Iterator[Game]:
    made = Game(game)
    yield made
    made.c.carom_close(made.scene)


def test_frames_are_heard_as_a_world_hears_them(played: Game) -> None:
    """As many blows, slides and rolls of a ball and a box as a World finds, which the engine takes."""
    wanted, time = simulation(), 0.0
    numbers = {name: played.body(name) for name in ("floor", "ball", "box", "ground")}
    assert numbers == {"floor": 0, "ball": 1, "box": 2, "ground": 3}
    assert played.listen((0, 0, 1.5), (1, 0, 0)) == 1
    for touches, poses in frames(2.0):
        time += FRAME
        wanted.step(time, touches, poses)
        for name, pose in poses.items():
            assert played.move(numbers[name], pose.position, pose.velocity, pose.spin)
        for each in touches:
            its = numbers[each.a], numbers[each.b]
            assert played.touch(*its, each.point, each.normal, each.impulse, each.approach, each.slip)
        assert played.frame(), played.why
    counts, found = wanted.counts, played.contacts
    assert (found.blows, found.slides, found.faint) == (counts.hits, counts.gestures, counts.faint)
    assert found.blows >= 3 and found.slides == 2 and (found.left_out, found.crowded, found.bodies) == (0, 0, 4)


def test_what_is_refused_is_said(played: Game) -> None:
    assert played.body("bell") == played.body("nobody") == -1
    assert played.move(7, (0, 0, 0)) == 0 and "carom_move: expected" in played.why
    assert played.touch(0, 1, (0, 0, 0), (0, 0, 2), NAN, 1.0, NAN) == 0 and "carom_touch: expected" in played.why
    assert played.touch(0, 1, (0, 0, 0), (0, 0, 1), 1.0, 1.0, NAN) == 0 and "impulse or speed" in played.why
    assert played.c.carom_body(played.scene, None) == -1
    assert played.frame(0.0) == 0 and "1e-6 to 1e6 seconds" in played.why
    for message, words in (
        ("/object/new a nobody", "nobody: no such object"), ("/object/new ball ball", "there is an object"),
        ("/object/new ground ball", "there is a silent body"),
        ("/object/new a/b ball", "expected no blank"), ("/object/new a ball size 100", "size = 100"),
        ("/object/new a ball material cheese", "cheese: no such material"), ("/object/new a", "like is missing"),
        ("/object/new a bell material steel", ""), ("/object/new b ball material glass size 0.5 pan -1", ""),
    ):  # fmt: skip
        told = played.send(message)
        assert words in told if words else not told, (message, told)


def test_frames_are_refused_whole_while_the_sound_stalls(played: Game) -> None:
    """While half of the ring waits: else the end of a slide would be lost."""
    floor, box, along = played.body("floor"), played.body("box"), (1.5, 0.0, 0.0)
    for _ in range(20):
        assert played.move(box, (0, 0, 0.05), along) and played.touch(floor, box, (0, 0, 0), (0, 0, 1), NAN, NAN, 1.5)
        assert played.frame(), played.why
    while not played.send("/object/bell/gain 0"):
        pass
    assert played.c.carom_frame(played.scene, ctypes.c_double(FRAME)) == 0 and "compute sound" in played.why
    played.process(4_096)
    assert played.move(box, (0, 0, 0.05)) and played.frame(), played.why
    assert played.contacts.slides == 1 and played.contacts.crowded == 0


def test_a_slide_begins_long_after_its_contact_wandered(played: Game) -> None:
    """Once its place on the box has wandered, and then stood for two seconds, the engine still takes the slide."""
    ground, box, x = played.body("ground"), played.body("box"), 0.0
    for frame in range(150):
        moves = 1.0 if frame < 6 or frame > 126 else 0.0
        at = 0.01 * min(frame, 6)
        x += moves * FRAME
        assert played.move(box, (x, 0, 0.05), (moves, 0, 0))
        assert played.touch(ground, box, (x + at, 0, 0), (0, 0, 1), NAN, NAN, moves)
        assert played.frame(), played.why
    report = Report()
    played.c.carom_report(played.scene, ctypes.byref(report))
    assert played.contacts.slides == 2 and report.refused == 0


def test_objects_are_made_and_freed_for_ever(played: Game) -> None:
    """Many more objects than there is room for, some at a time: each has a body while it is there."""
    bodies = set()
    for n in range(3_000):
        name = f"ball.{n % 40}"
        if n >= 40:
            assert not played.send(f"/object/{name}/free 1")
            assert played.body(name) == -1
            played.process(256)
        assert not played.send(f"/object/new {name} ball size {0.5 + n % 7 / 7}"), n
        bodies.add(played.body(name))
    assert min(bodies) == 4 and max(bodies) < 50 and played.contacts.bodies == 44
    report = Report()
    played.c.carom_report(played.scene, ctypes.byref(report))
    assert report.refused == 0
    for n in range(1_000):  # more at a time than there is room for
        if why := played.send(f"/object/new more.{n} ball"):
            break
    assert "no capacity for another object" in why
