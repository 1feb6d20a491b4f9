"""A log renders to what was heard, bit for bit."""

import errno
import os
import random
import re
import subprocess
import time
from collections.abc import Callable

import numpy as np
import pytest
import soundfile

from carom.dsp.native.system import clock_ns
from carom.dsp.runtime.engine import NOW, Engine, Stamp
from carom.presets.library import Presets
from carom.server.files.log import Log
from carom.server.options import Options as Serving
from carom.server.osc.score import Line, read, sample_at
from carom.server.osc.wire import Message
from carom.server.render import Options, blocks
from carom.server.scene.session import Session
from tests.bench.logs import any_message, random_message
from tests.support import CAROM, render_lines, serving

PRESETS = Presets()


def replay(
    tmp_path, rng, messages: Callable[[], list[Message]], rounds: int, options=None, by_clock: bool = True
) -> list[Line]:
    """Carry out messages for now, for later, too late, by samples and by the clock; what is logged renders to what was
    heard. options: a server's, with which engine and log begin. by_clock: whether the clock counts; it goes its own way
    here, as sound is computed faster or slower than it is heard. Return the log."""
    engine = options.engine() if options else Engine(48_000, limited=True)
    scene = Session(engine, PRESETS)
    log = Log(engine, tmp_path / "log.txt", options.head if options else ())
    scene.on_sent = log.expect
    log.start()
    sound = []
    for _ in range(rounds):
        when = rng.choice(
            (
                NOW,
                max(0.0, engine.position + rng.randrange(-500, 20_000) + rng.randrange(256) / 256),
                engine.stamp(clock_ns() + rng.randrange(-(10**7), 3 * 10**7)) if by_clock else NOW,
            )
        )
        scene.perform(messages(), when)
        if rng.random() < 0.7:
            sound.append(engine.process(rng.choice((1, 64, 100, 1_000))))
        log.write()
    sound.append(engine.process(30_000))
    log.close()
    heard = np.concatenate(sound)[engine.delay :]
    assert heard.any() and log.error is None
    lines = read(tmp_path / "log.txt")
    assert [line.time for line in lines] == sorted(line.time for line in lines)
    options = Options(seconds=len(heard) / 48_000)
    np.testing.assert_array_equal(np.concatenate(list(blocks(lines, options.engine(lines), PRESETS, options))), heard)
    return lines


@pytest.mark.slow
def test_a_simulations_contacts_fall_where_the_logs_seconds_can_name_them(monkeypatch):
    """A step comes at any sample, and its contacts lie anywhere between two steps."""
    engine = Engine(44_100)
    scene = Session(engine, PRESETS)
    times: list[float] = []
    send = engine.send
    monkeypatch.setattr(engine, "send", lambda commands: times.extend(each.time for each in commands) or send(commands))
    touch = ("floor", "ball", 0, 0, 0, 0, 0, 1, "approach", 1.0, "depth")
    begin = [
        Message("/world/body", ("floor", "plate", "wood", 0.3, 0.2, 0.01, "held", 1)),
        Message("/world/body", ("ball", "sphere", "rubber", 0.05)),
        Message("/world/step", (0.0,)),
    ]
    scene.perform(begin, NOW)
    for n in range(1, 60):
        engine.process(101)
        told = [Message("/world/pose", ("ball", 0, 0, 0.05, 1, 0, 0, 0, 0, 0, -1))]
        if n % 3 == 0:
            told.append(Message("/world/touch", (*touch, 0.0007 * (n % 7 + 0.123))))
        scene.perform([*told, Message("/world/step", (0.01 * n + 0.0001 * (n % 5),))], NOW)
    later = [time for time in times if time > 0]
    assert len(later) > 15 and [time for time in later if sample_at(time / 44_100, 44_100) != time] == []


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_a_session_of_anything_at_any_time(tmp_path, seed):
    """Messages of all kinds, refused and panicked away."""
    rng = random.Random(seed)
    lines = replay(tmp_path, rng, lambda: [random_message(rng) for _ in range(rng.randrange(1, 4))], 300)
    assert len(lines) > 100 and {"/panic", "/quality", "/object/new"} < {line.message.address for line in lines}


_TURNS = re.compile(r"/macro/|/(dice|undo|morph|tune|decay|damp)$|^/play$")
"""Messages on which the values of gestures depend that come after them, and were perhaps sent before."""


@pytest.mark.slow
@pytest.mark.parametrize("by_clock", [False, True])
@pytest.mark.parametrize("seed", [1, 3])
def test_a_session_of_all_that_is_declared(tmp_path, seed, by_clock):
    """Messages to all addresses of scores: what rests, breaks and scatters among them, macros, on objects that come
    and go. By the clock there are no macros: gestures that were sent ahead have those of the sample at which they are
    likely to come."""
    rng = random.Random(seed)

    def messages() -> list[Message]:
        said = [any_message(rng) for _ in range(rng.randrange(1, 4))]
        return [each for each in said if not (by_clock and _TURNS.search(each.address))]

    lines = replay(tmp_path, rng, messages, 120, by_clock=by_clock)
    assert len(lines) > 50


@pytest.mark.slow
def test_a_rest_or_a_press_of_several_contacts_is_one_line(tmp_path):
    rng = random.Random(1)
    begin = [Message("/object/new", each) for each in (("a", "wine-glass"), ("b", "wood-board"))]
    rests = [Message("/object/a/rest", args) for args in (("b", 0.5, "load", 2.0), ("table",), ("felt", "id", "mat"))]
    rests += [Message(f"/object/{name}/press", (5.0, "striker", each)) for name, each in (("a", "hand"), ("b", "mute"))]
    todo = [[each] for each in reversed(begin)]

    def messages() -> list[Message]:
        if todo:
            return todo.pop()
        if rests and rng.random() < 0.2:
            return [rests.pop()]
        return [Message(f"/object/{rng.choice('ab')}/impact", (rng.random(),))]

    lines = replay(tmp_path, rng, messages, 80)
    addresses = [line.message.address for line in lines]
    assert addresses.count("/object/a/rest") == 3 and len([each for each in addresses if each.endswith("/press")]) == 2


@pytest.mark.slow
def test_swarms_and_what_breaks(tmp_path):
    """A body that breaks is one message, though its cracks, its pieces and its silence are commands of two objects."""
    rng = random.Random(2)
    presets = {"a": "wine-glass", "b": "wine-glass", "c": "wood-board", "d": "tin-lid"}
    first = [[Message("/object/new", each)] for each in presets.items()]
    once = [
        ("b", "shatter", 4.0, "pieces", 20, "onto", "c"),
        ("a", "shatter", 2.0, "pieces", 10),
        *((name, "step", 500.0) for name in "cd"),
        ("c", "pour", 300.0, "id", "rice", "striker", "rice"),
        ("d", "rain", 500.0, "id", "rain"),
        ("d", "shake", 50.0, "id", "dice"),
        ("d", "crumple", 0.1, "id", "fist"),
    ]

    def messages() -> list[Message]:
        if first:
            return first.pop()
        if once and rng.random() < 0.2:
            name, action, *args = once.pop()
            return [Message(f"/object/{name}/{action}", tuple(args))]
        return [Message(f"/object/{rng.choice('cd')}/impact", (rng.random(),))]

    lines = replay(tmp_path, rng, messages, 100)
    assert not once and sum(line.message.address.endswith("/shatter") for line in lines) == 2


@pytest.mark.slow
def test_log_renders_changes_of_the_spectral_banks_precision(tmp_path):
    """The bank begins with float32, and changes while two cymbals ring."""
    rng = random.Random(1)
    first = [[Message("/object/new", (name, "cymbal", "gain", -30))] for name in "ab"]

    def messages() -> list[Message]:
        if first:
            return first.pop()
        form = Message("/bank", (rng.choice(("float64", "float32")),))
        return rng.choice(([form], [], [], [Message("/object/*/impact", (0.1,))]))

    lines = replay(tmp_path, rng, messages, 60, Serving(bank="float32"))
    forms = [line.message.args[0] for line in lines if line.message.address == "/bank"]
    assert forms[0] == "float32" and forms.count("float64") > 3


@pytest.mark.slow
def test_a_server_s_log_renders_to_its_recording(tmp_path):
    (tmp_path / "log.txt").write_text("an older one")
    options = ("--device", "none", "--record", "out.wav", "--log", "log.txt", "--block", "100")
    with serving(tmp_path, *options) as server:
        with server.client() as client:
            client.new("a", "glockenspiel-bar")
            client.new("b", "wood-block", pan=0.5)
            for _ in range(3):
                client.impact("*", 0.7, striker="wood")
                client.impact("nobody", 1.0)
                with client.bundle(at=time.time() + 0.1):
                    client.send("/object/a/tune", 1.5)
                    client.impact("a", 1.0)
                with client.bundle(at=time.time() - 0.1):
                    client.impact("b", 0.5)
                time.sleep(0.15)
            with client.bundle(at=time.time() + 0.3):
                client.impact("a", 2.0)
            client.ask("/sync", 1)
            client.send("/panic")
            client.send("/object/a/free")
            client.new("a", "triangle")
            client.impact("a", 1.0)
            with client.bundle(at=time.time() + 3.0):
                client.impact("a", 2.0)
            time.sleep(0.5)
        server.quit()
    lines = read(tmp_path / "log.txt")
    said = [line.message.address for line in lines]
    assert said.count("/object/a/impact") == 3 + 3 + 1 and said.count("/object/b/impact") == 3 + 3
    assert (
        said[:7] == ["/channels", "/full_scale", "/limiter", "/headroom", "/gain", "/budget", "/bank"]
        and "/panic" in said
        and "/object/nobody/impact" not in said
    )
    recorded, rate = soundfile.read(tmp_path / "out.wav", dtype="float32")
    np.testing.assert_array_equal(render_lines(lines, seconds=len(recorded) / rate), recorded)


@pytest.mark.slow
def test_a_log_with_sensors_places_and_a_gong_renders_to_its_recording(tmp_path):
    options = ("--device", "none", "--record", "out.wav", "--log", "log.txt", "--sensors", "2")
    with serving(tmp_path, *options) as server:
        with server.client() as client:
            client.new("a", "wood-block")
            client.new("gong", "small-gong")
            client.listener(0, 0, 0)
            client.place("a", 2, 1, 0)
            client.room(5, 4, 3)
            client.sensor("tip", "a", full=1000)
            client.impact("a", 1.0)
            client.impact("gong", 3.0)
            client.place("a", -2, 1, 0, over=0.4)
            client.ask("/sync", 1)
            time.sleep(0.3)
            client.impact("a", 1.0)
            client.unmount("tip")
            client.sensor("disc", "gong", preset="piezo-27", full=1000)
            client.sensor("tip", "gong", full=1000)
            client.unmount("disc")
            client.sensor("other", "a", full=1000)
            client.impact("a", 1.0)
            client.ask("/sync", 2)
            time.sleep(0.3)
        server.quit()
    lines = read(tmp_path / "log.txt")
    assert Message("/sensor/new", ("tip", "a", "full", 1000)) in [line.message for line in lines]
    recorded, rate = soundfile.read(tmp_path / "out.wav", dtype="float32")
    rendered = render_lines(lines, seconds=len(recorded) / rate)
    assert recorded.shape[1] == 4 and recorded[:, 2].any() and recorded[:, 3].any()
    np.testing.assert_array_equal(rendered, recorded)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_sensors_that_come_and_go_at_any_time(tmp_path, seed):
    """One may be taken away, and another one of its name come, before the time at which it comes."""
    rng = random.Random(seed)
    made = [Message("/object/new", (name, "triangle")) for name in "ab"]

    def messages():
        sensor, name = rng.choice("xyz"), rng.choice("ab")
        kinds = (
            Message(f"/sensor/{rng.choice((sensor, '*', '[xy]'))}/free"),
            Message("/sensor/new", (sensor, name, rng.random())),
            Message("/sensor/new", (sensor, name, rng.random())),
            Message(f"/object/{name}/impact", (1.0, rng.random())),
        )
        return [made.pop() if made else rng.choice(kinds)]

    replay(tmp_path, rng, messages, 100, Serving(sensors=3))


def test_a_listener_without_a_layout_has_that_of_the_message_before(tmp_path):
    """The log says so, as the one whose layout it lacks may come earlier, though it was sent later."""
    rng = random.Random(3)
    wanted = [
        Message("/object/new", ("a", "triangle")),
        Message("/object/a/place", (3.0, 1.0, 0.0)),
        Message("/listener", (0.0, 0.0, 0.0)),
        Message("/object/a/impact", (1.0,)),
    ]

    def messages():
        if wanted:
            return [wanted.pop(0)]
        layout = rng.choice(((), (), ("layout", "binaural"), ("layout", "pan")))
        return [Message("/listener", (rng.uniform(-2.0, 2.0), 0.0, 0.0, *layout)), Message("/object/a/impact", (1.0,))]

    replay(tmp_path, rng, messages, 40)


def test_a_sensor_whose_object_goes_before_it_comes_is_not_in_the_log(logged, tmp_path):
    engine, scene, log = logged
    engine.sensors = 1
    for when, address, *args in (
        (1000.0, "/sensor/new", "tip", "a"), (500.0, "/object/a/free", 1), (1500.0, "/sensor/tip/free"),
        (NOW, "/object/new", "b", "triangle"), (2000.0, "/sensor/new", "tip", "b"),
    ):  # fmt: skip
        replies = scene.perform([Message(address, tuple(args))], when)
        assert not [reply for reply in replies if reply.address == "/fail"]
    for _ in range(4):
        engine.process(1024)
        log.write()
    sensors = [line.message.args for line in read(tmp_path / "log.txt") if "/sensor" in line.message.address]
    assert sensors == [("tip", "b")]


@pytest.mark.slow
def test_a_log_s_head_says_channels_full_scale_limiter_and_gain(tmp_path):
    """The log renders to the recording of a server that was started with other values, and changed while it played."""
    options = ("--device", "none", "--record", "out.wav", "--log", "log.txt", "--full-scale", "0.7Pa")
    with serving(tmp_path, *options, "--channels", "3", "--gain", "9.5", "--limiter", "off") as server:
        with server.client() as client:
            client.new("a", "glockenspiel-bar", gains=[0.2, -1.0], distance=2.0)
            client.new("b", "wood-block", pan=0.5)
            for _ in range(3):
                client.impact("*", 0.7, striker="wood")
                time.sleep(0.1)
            client.main_gain(30.0)
            client.gains("a")
            client.gains("b", [0.0, 0.0, 4.0])
            client.limiter(True)
            for _ in range(3):
                client.impact("*", 2.0, striker="steel")
                time.sleep(0.1)
            client.distance("*", 0.3)
            client.limiter(False)
            client.panic()
            client.impact("a", 1.0)
            time.sleep(0.1)
            assert dict(zip((args := client.status().args)[9::2], args[10::2], strict=True))["limited"] > 0
        server.quit()
    lines = read(tmp_path / "log.txt")
    said = [(line.time, line.message) for line in lines[:5]]
    assert said == [
        (0.0, Message("/channels", (3,))), (0.0, Message("/full_scale", (0.7,))),
        (0.0, Message("/limiter", ("off",))), (0.0, Message("/headroom", ("on",))), (0.0, Message("/gain", (9.5,))),
    ]  # fmt: skip
    assert sum(line.message.address == "/object/b/gains" for line in lines) == 1
    recorded, rate = soundfile.read(tmp_path / "out.wav", dtype="float32")
    assert recorded.shape[1] == 3 and np.abs(recorded).max() > 1e-3
    np.testing.assert_array_equal(render_lines(lines, seconds=len(recorded) / rate), recorded)


@pytest.mark.slow
def test_a_crash_loses_little(tmp_path):
    with serving(tmp_path, "--device", "none", "--record", "out.wav", "--log", "log.txt") as server:
        with server.client() as client:
            client.new("a", "wood-block")
            for _ in range(15):
                client.impact("a", 1.0)
                time.sleep(0.1)
            status = client.status().args
        server.process.kill()
        server.process.wait()
    impacts = dict(zip(status[9::2], status[10::2], strict=True))["impacts"]
    recorded, rate = soundfile.read(tmp_path / "out.wav", dtype="float32")
    lines = read(tmp_path / "log.txt")
    assert sum(line.message.address.endswith("impact") for line in lines) >= impacts - 10
    assert len(recorded) / rate > 1.5 - 1.0 and len(recorded) / rate > lines[-1].time - 1.0
    assert soundfile.info(tmp_path / "out.wav").frames == len(recorded)
    rendered = render_lines(lines, seconds=min(len(recorded) / rate, lines[-1].time))
    np.testing.assert_array_equal(rendered, recorded[: len(rendered)])


def test_a_log_that_fails_is_told(tmp_path):
    engine = Engine(48_000)
    with pytest.raises(OSError, match="Is a directory"):
        Log(engine, tmp_path)
    log = Log(engine, tmp_path / "log.txt")
    log.close()
    assert not (tmp_path / "log.txt").exists()  # it was never begun


@pytest.mark.slow
def test_a_log_that_missed_something_ends(logged, tmp_path):
    """The log renders to what was heard, up to where it says that it ended."""
    engine, scene, log = logged
    engine.process(64)
    log.write()
    while not engine.stats.notes_lost:
        assert scene.perform([Message("/object/a/damp", (0.1,))] * 8_000, NOW) == []
        engine.process(64)
    log.write()
    assert log.error is not None and "events came too fast to write" in log.error
    assert len(read(tmp_path / "log.txt")) == 1


def test_a_server_that_runs_for_longer_than_a_score_lasts(logged, monkeypatch, tmp_path):
    engine, scene, log = logged
    engine.process(64)
    monkeypatch.setattr("carom.server.osc.score.LONGEST_SCORE", 0.01)
    scene.perform([Message("/object/a/impact", (0.1,))], 4_800.0)
    engine.process(9_600)
    log.write()
    assert log.error is not None and "time 0.1: expected seconds from 0 to 0.01" in log.error
    monkeypatch.undo()
    assert [line.message.address for line in read(tmp_path / "log.txt")] == []


def test_messages_that_wait_to_be_logged_are_forgotten_once_they_are(logged):
    engine, scene, log = logged
    for n in range(10):
        scene.perform([Message("/object/a/impact", (0.1,)), Message("/object/a/damp", (0.1,))], 1e6 * (n % 2))
    scene.perform([Message("/panic")], NOW)
    engine.process(640)
    log.write()
    assert not log._waiting and log.error is None


def test_a_name_that_is_free_is_given_again(logged, tmp_path):
    engine, scene, log = logged
    for message in (Message("/object/a/free", (1,)), Message("/object/new", ("a", "tom"))):
        engine.process(6_400)
        scene.perform([message], NOW)
    engine.process(64)
    log.write()
    assert [line.message.args[0] for line in read(tmp_path / "log.txt")] == ["a", 1, "a"]


def test_a_file_is_as_readable_as_any(logged, tmp_path):
    (tmp_path / "plain").touch()
    assert (tmp_path / "log.txt").stat().st_mode == (tmp_path / "plain").stat().st_mode


@pytest.mark.parametrize("name", ["a", "n" * 64])
def test_a_name_that_came_back_too_early(tmp_path, name):
    """The clock was set: what was to be gone by then is still there when its name is given again."""
    engine = Engine(48_000)
    scene = Session(engine, PRESETS)
    log = Log(engine, tmp_path / "log.txt")
    scene.on_sent = log.expect
    log.start()
    scene.perform([Message("/object/new", (name, "wood-block"))], NOW)
    heard = [engine.process(64)]
    scene.perform([Message(f"/object/{name}/free", (1,))], Stamp(100.0, clock_ns() + 50_000_000))
    heard.append(engine.process(256))
    new = [Message("/object/new", (name, "triangle")), Message(f"/object/{name}/impact", (1.0,))]
    assert [reply.address for reply in scene.perform(new, NOW)] == ["/done"]
    heard.append(engine.process(256))
    time.sleep(0.06)
    heard.append(engine.process(2_048))
    log.close()
    lines = read(tmp_path / "log.txt")
    names = ["/object/new", "/object/new", f"/object/{name[:50]}~2/impact", f"/object/{name}/free", "/panic"]
    assert [line.message.address for line in lines] == names
    sound = np.concatenate(heard)
    np.testing.assert_array_equal(render_lines(lines, seconds=len(sound) / 48_000), sound)


def test_a_log_without_room_keeps_whole_lines(logged, tmp_path, monkeypatch):
    """All lines that fit, however many are written at once."""
    engine, scene, log = logged
    engine.process(64)
    log.write()
    room = 400

    def write(descriptor: int, data: bytes) -> int:
        if os.fstat(descriptor).st_size + len(data) > room:
            raise OSError(errno.EFBIG, "File too large")
        return real(descriptor, data)

    real = os.write
    monkeypatch.setattr(os, "write", write)
    for n in range(20):
        scene.perform([Message("/object/a/damp", (0.01 * n,))], NOW)
    engine.process(64)
    log.write()
    monkeypatch.undo()
    assert log.error == f"the log {tmp_path / 'log.txt'} ended: File too large"
    lines = read(tmp_path / "log.txt")
    assert len(lines) > 5 and room - 40 < (tmp_path / "log.txt").stat().st_size <= room
    assert [line.message.args for line in lines[1:]] == [(0.01 * n,) for n in range(len(lines) - 1)]


@pytest.mark.slow
def test_a_log_names_what_computed_it_and_a_render_by_something_else_is_warned_of(tmp_path):
    with serving(tmp_path, "--device", "none", "--log", "log.txt") as server:
        with server.client() as client:
            client.new("a", "wood-block")
            client.impact("a", 1.0)
            client.ask("/sync", 1)
        server.quit()
    text = (tmp_path / "log.txt").read_text()
    said = r"# carom \S+, .*; code [0-9a-f]{16} for \S+, numpy \S+; render it at --rate 48000\n"
    assert re.match(said, text)
    (tmp_path / "other.txt").write_text(text.replace("numpy ", "numpy 0.", 1))
    for name, warned in (("log.txt", False), ("other.txt", True)):
        words = [*CAROM, "render", name, "out.wav"]
        run = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=True)
        assert ("other.txt was logged by code" in run.stderr and "may differ" in run.stderr) == warned, run.stderr
