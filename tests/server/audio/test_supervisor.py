"""The player: what runs the engine stays up, whatever becomes of devices and of Python."""

import ctypes
import os
import re
import signal
import threading
import time
from collections.abc import Callable

import numpy as np
import pytest
import soundfile

from carom.dsp.native.atomics import publish
from carom.dsp.runtime.engine import Engine
from carom.dsp.runtime.handover import Handover
from carom.dsp.runtime.pacer import keep_pace
from carom.dsp.runtime.signature import SIGNATURE
from carom.server.audio import supervisor as player_module
from carom.server.audio.supervisor import Player, priority
from tests import needs
from tests.support import serving

pytestmark = pytest.mark.slow


def within(seconds: float, done: Callable[[], object]) -> None:
    deadline = time.monotonic() + seconds
    while not done():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def status(client) -> dict:
    args = client.status().args
    return dict(zip(args[9::2], args[10::2], strict=True))


def hold_the_gil(stop: threading.Event) -> None:
    while not stop.is_set():
        sum(range(10**6))  # in C, so that it is not let go of inside


class Device:
    """A device of a thread's, that can stall, come round, and go."""

    name, latency, patience = "fake", 0.01, 60.0

    def __init__(self, engine: Engine) -> None:
        self._handover = Handover(engine.address, engine.pointer, 2)
        self.gone, self.closed = False, 0
        self.come_round()
        self.start, self.rest = self._handover.allow, self._handover.revoke

    def come_round(self) -> None:
        self._running = np.ones(1, np.int64)
        memory = np.zeros((480, 2), np.float32), np.zeros(3)
        args = self._running, self._handover.address, self._handover.pointer, 48_000.0, *memory
        self._thread = threading.Thread(target=keep_pace, args=args, daemon=True)
        self._thread.start()

    def stall(self) -> None:
        publish(self._running, 0)
        self._thread.join()

    def prepare(self) -> None:
        pass

    def active(self) -> bool:
        return not self.gone

    def calls(self) -> int:
        return self._handover.calls

    def close(self) -> bool:
        self.closed += 1
        self.stall()
        raise RuntimeError("it won't")


@pytest.fixture
def devices(monkeypatch) -> list[Device]:
    """The devices that players open, all of them fakes, and who are less patient."""
    opened: list[Device] = []
    monkeypatch.setattr(player_module, "open_output", lambda engine, *_: opened.append(Device(engine)) or opened[-1])
    monkeypatch.setattr(player_module, "look_for_devices", lambda: None)
    monkeypatch.setattr(player_module, "_STALLED", 0.5)
    monkeypatch.setattr(player_module, "_AGAIN", 0.1)
    return opened


def told(player: Player, word: str) -> bool:
    return any(word in text for text in player.look())


def goes_on(engine: Engine) -> bool:
    position = engine.position
    time.sleep(0.1)
    return engine.position > position


def test_a_device_that_stalls_is_stood_in_for_until_it_comes_round(devices):
    engine = Engine(48_000)
    player = Player(engine, None, 0, None)
    (device,) = devices
    for times in range(1, 3):
        within(5, lambda: goes_on(engine))
        device.stall()
        within(5, lambda: told(player, "device fake stalled: playing by the system's clock until it returns"))
        within(5, lambda: player.name == "none" and goes_on(engine))
        device.come_round()
        within(5, lambda: told(player, "device fake is back"))
        assert player.name == "fake" and player.reconnects == times and len(devices) == 1
        assert goes_on(engine)
    device.stall()
    player.rest()
    device.come_round()
    assert not goes_on(engine)


def test_device_that_cannot_be_closed_is_told_and_time_goes_on(devices):
    engine = Engine(48_000)
    player = Player(engine, None, 0, None)
    devices[0].gone = True
    within(5, lambda: told(player, "it won't"))
    within(5, lambda: told(player, "device fake is back"))
    assert len(devices) == 2 and devices[0].closed == 1 and player.reconnects == 1
    assert goes_on(engine)
    player.rest()
    assert not goes_on(engine)
    devices[1].stall()


def test_the_clock_plays_on_while_python_is_held_up():
    """Blocks of 64 frames while the GIL is taken for milliseconds at a time: none is late by a tenth of a second."""
    engine = Engine(48_000)
    player = Player(engine, "none", 64, None)
    stop = threading.Event()
    hogs = [threading.Thread(target=hold_the_gil, args=(stop,)) for _ in range(3)]
    for hog in hogs:
        hog.start()
    start, before = time.monotonic(), engine.position
    time.sleep(1.5)
    played, lasted = engine.position - before, time.monotonic() - start
    stop.set()
    for hog in hogs:
        hog.join()
    player.close()
    assert played / 48_000 == pytest.approx(lasted, abs=0.1)
    position = engine.position
    time.sleep(0.05)
    assert engine.position == position


def test_a_device_is_served_while_python_is_held_up(tmp_path, request):
    """64 frames a block on JACK: hogs in Carom's own process cost it no more than 2 %, a Python callback over 20 %."""
    needs.module("sounddevice")
    request.getfixturevalue("jack")
    from tests.bench import gil

    for take in range(3):
        lost = gil.shares(1.0, tmp_path)
        if lost["hogged"] <= lost["alone"] + 0.02 or take == 2:
            break
    assert lost["hogged"] <= lost["alone"] + 0.02 and lost["python"] > 0.2, lost


def test_latency_is_asked_for_and_told(tmp_path):
    """The limiter's delay is counted."""
    engine = Engine(48_000, limited=True)
    player = Player(engine, "none", 480, 0.05)
    assert player.requested == player.latency == 0.05 and engine.state["clock"]["latency"][0] == 2_400 + engine.delay
    player.close()
    with serving(tmp_path, "--device", "none", "--latency", "0.03") as server:
        with server.client() as client:
            within(30, lambda: 0 < status(client)["latency_measured"] < 0.03)  # a busy machine is late at first
            told = status(client)
        server.quit()
    assert told["latency_requested"] == pytest.approx(0.03)
    assert told["latency"] == pytest.approx(0.03 + engine.delay / 48_000)
    assert told["latency_measured"] >= 0 and told["device"] == "none" and told["time"] > 0


def test_a_late_block_is_heard_at_once():
    """The clock's callback takes twice its block's time, and no block is said to be heard in the past."""
    running, memory = np.ones(1, np.int64), (np.zeros((48, 2), np.float32), np.zeros(3))
    leads = []

    @ctypes.CFUNCTYPE(*SIGNATURE)
    def late(_input, _output, _frames, times, _flags, _state):
        _, now, heard = ctypes.cast(times, ctypes.POINTER(ctypes.c_double))[:3]
        leads.append(heard - now)
        time.sleep(0.002)
        if len(leads) == 20:
            publish(running, 0)
        return 0

    keep_pace(running, ctypes.cast(late, ctypes.c_void_p).value, 0, 48_000.0, *memory)
    assert len(leads) == 20 and min(leads) == 0


@needs.linux("SCHED_FIFO")
def test_the_thread_runs_in_real_time_where_that_is_permitted():
    engine = Engine(48_000)
    player = Player(engine, "none", 0, None)
    try:
        within(5, lambda: player.look() is not None and player.scheduling != "unknown")
        thread = engine.thread
        assert thread in map(int, os.listdir("/proc/self/task")) and thread != threading.get_native_id()
        permitted = player.scheduling == "fifo"
        assert permitted == (os.sched_getscheduler(thread) == os.SCHED_FIFO)
        assert permitted or player.scheduling == "other"
        assert os.sched_getscheduler(0) == os.SCHED_OTHER  # Python's own thread stays as it was
    finally:
        player.close()


@needs.linux("SCHED_FIFO")
def test_a_thread_that_ends_while_it_is_looked_at_is_no_fault(monkeypatch):
    engine = Engine(48_000)
    player = Player(engine, "none", 0, None)
    within(5, lambda: engine.thread)
    answers = iter([os.SCHED_FIFO])

    def scheduler(_thread: int) -> int:
        for answer in answers:
            return answer
        raise ProcessLookupError

    monkeypatch.setattr(os, "sched_getscheduler", scheduler)
    assert player.look() == [] and player.scheduling == "unknown"
    player.close()


@pytest.mark.skipif(not hasattr(os, "sched_setscheduler"), reason="another system's scheduler")
@pytest.mark.parametrize(("policy", "said"), [(0, "other"), (1, "fifo"), (2, "rr"), (0x4000_0001, "fifo")])
def test_a_user_without_rights_is_told_how_the_thread_runs(monkeypatch, policy, said):
    """A thread that rtkit has raised says besides that what it forks is not."""
    engine = Engine(48_000)
    player = Player(engine, "none", 0, None)
    within(5, lambda: engine.thread)
    asked = []

    def refuse(_thread: int, _policy: int, parameter: os.sched_param) -> None:
        asked.append(parameter.sched_priority)
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "sched_getscheduler", lambda _: policy)
    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    assert player.look() == [] and player.scheduling == said
    assert asked == ([] if policy else [player_module._PRIORITY])
    player.close()


@pytest.mark.parametrize(
    ("user", "limit", "expected"), [(0, 0, 70), (1000, 0, 70), (1000, 20, 20), (1000, 95, 70), (1000, -1, 70)]
)
def test_no_priority_is_asked_for_beyond_what_is_given(monkeypatch, user, limit, expected):
    resource = needs.module("resource")
    monkeypatch.setattr(os, "geteuid", lambda: user)
    monkeypatch.setattr(resource, "getrlimit", lambda _: (limit, limit))
    assert priority() == expected


def test_a_lost_device_is_told_and_had_back(tmp_path, jack):
    """jackd is killed under a server and started again: the clock paces the sound meanwhile."""
    needs.module("sounddevice")
    jack.start(1024)
    with (
        serving(tmp_path, "--device", "system", "--record", "out.wav") as server,
        server.client() as client,
    ):
        assert status(client)["device"] == "system"
        with server.client() as listener:
            listener.ask("/notify", 1)
            jack.kill()
            within(10, lambda: status(client)["device"] == "none")
            before = status(client)["time"]
            time.sleep(0.5)
            assert status(client)["time"] - before > 0.3
            client.new("a", "wood-block")
            client.impact("a", 1.0)
            jack.start(512)
            within(20, lambda: status(client)["device"] == "system")
            told = " ".join(str(reply.args[0]) for reply in listener.replies(0.3) if reply.address == "/warning")
        assert "device system disappeared" in told and "device system is back" in told
        client.impact("a", 1.0)
        client.ask("/sync", 1)  # which the device's callback answers
        assert status(client)["reconnects"] == 1
        seconds = status(client)["time"]
        assert server.quit() == (0, "")
    sound, rate = soundfile.read(tmp_path / "out.wav")
    assert len(sound) / rate > seconds - 0.01 and sound.any()


def test_a_server_ends_well_after_its_device(tmp_path, jack):
    needs.module("sounddevice")
    jack.start(1024)
    with serving(tmp_path, "--device", "system") as server:
        jack.stop()
        server.process.terminate()
        assert server.process.wait(timeout=10) == 0


def test_a_device_that_came_back_at_another_rate_is_had_back_at_its_own(tmp_path, jack):
    needs.module("sounddevice")
    jack.start(1024)
    with serving(tmp_path, "--device", "system") as server, server.client() as client, server.client() as listener:
        listener.ask("/notify", 1)
        warnings: list[str] = []

        def warned(text: str) -> bool:
            warnings.extend(str(reply.args[0]) for reply in listener.replies(0.1) if reply.address == "/warning")
            return any(text in warning for warning in warnings)

        jack.kill()
        within(10, lambda: status(client)["device"] == "none")
        jack.start(1024, rate=44_100)
        within(10, lambda: warned("Invalid sample rate"))
        assert warned("expected its own rate, 44100 Hz, not 48000;")
        jack.kill()
        jack.start(1024)
        within(10, lambda: status(client)["device"] == "system")
        client.ask("/sync", 1)
        assert status(client)["reconnects"] == 1
        assert server.quit() == (0, "")


@pytest.mark.parametrize("pause", [0.3, 3.0])
def test_a_server_ends_well_while_its_device_is_frozen(tmp_path, jack, pause):
    """Told to end before it has seen that the device stands still, and after."""
    needs.module("sounddevice")
    jack.start(256)
    with serving(tmp_path, "--device", "system", "--record", "out.wav", "--log", "log.txt") as server:
        with server.client() as client:
            client.new("a", "wood-block")
            client.impact("a", 1.0)
            client.ask("/sync", 1)
            jack.process.send_signal(signal.SIGSTOP)
            time.sleep(pause)
            assert status(client)["device"] == ("system" if pause < 2 else "none")
        server.process.terminate()
        _, errors = server.process.communicate(timeout=8)
        assert server.process.returncode == 0
        assert re.sub(r"the sound was stopped for [\d.]+ s, as .*\n", "", errors) == ""
    jack.kill()
    sound, _ = soundfile.read(tmp_path / "out.wav")
    assert sound.any() and (tmp_path / "log.txt").read_text().count("/object/a/impact") == 1


def test_a_server_ends_well_in_the_moment_that_its_device_goes(tmp_path, jack):
    needs.module("sounddevice")
    jack.start(64)
    with serving(tmp_path, "--device", "system", "--record", "out.wav") as server, server.client() as client:
        client.new("a", "wood-block")
        client.impact("a", 1.0)
        client.ask("/sync", 1)
        jack.kill()
        assert server.quit() == (0, "")
    assert soundfile.read(tmp_path / "out.wav")[0].any()
