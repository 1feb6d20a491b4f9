"""Time tags: their sounds begin where the clock says, to less than a sample, whoever sends them, whatever plays."""

import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import soundfile
from pythonosc.osc_bundle_builder import OscBundleBuilder
from pythonosc.osc_message_builder import OscMessageBuilder
from pythonosc.udp_client import UDPClient

from carom.server.osc.score import read
from tests import needs
from tests.support import Running, serving

pytestmark = pytest.mark.slow

RATE = 48_000
SETTLED = 20  # events after which sclang's beat, and
SECONDS = {"none": 1.0, "system": 7.0}  # after which the clock of a device, are steady
TAKES = 3  # of which one must be free of dropouts: the machine may be busy

SCLANG = """
~net = NetAddr("127.0.0.1", thisProcess.argv[0].asInteger);
{
    60.do { |i|
        ~net.sendBundle(0.3, ["/object/a/impact", 1.0 + (i * 0.001)]);
        0.0411.wait;
    };
    0.6.wait;
    0.exit;
}.fork(SystemClock);
"""


def python_osc(server: Running, _: Path) -> None:
    client = UDPClient("127.0.0.1", server.port)
    start = time.time() + 0.3
    for i in range(60):
        bundle = OscBundleBuilder(start + 0.0411 * i)
        message = OscMessageBuilder("/object/a/impact")
        message.add_arg(1.0 + 0.001 * i)
        bundle.add_content(message.build())
        while time.time() < start + 0.0411 * i - 0.3:
            time.sleep(0.005)
        client.send(bundle.build())
    client._sock.close()
    time.sleep(0.6)


def sclang(server: Running, folder: Path) -> None:
    script = folder / "strikes.scd"
    script.write_text(SCLANG)
    env = os.environ | {"QT_QPA_PLATFORM": "offscreen", "QTWEBENGINE_DISABLE_SANDBOX": "1", "HOME": str(folder)}
    subprocess.run(["sclang", str(script), str(server.port)], env=env, check=True, timeout=60, capture_output=True)


def jitter(folder: Path, device: str, send) -> float:
    """Return the root mean square of the onsets' distance from an even beat, in samples; inf where sound was lost."""
    with serving(folder, "--device", device, "--log", "log.txt", "--record", "out.wav") as server:
        with server.client() as client:
            client.new("a", "wood-block", gain=-20)
            time.sleep(SECONDS[device])
            send(server, folder)
            args = client.status().args
        assert server.quit()[0] == 0
    told = dict(zip(args[9::2], args[10::2], strict=True))
    onsets = [line.time * RATE for line in read(folder / "log.txt") if line.message.address.endswith("impact")]
    assert len(onsets) == 60 and told["late"] == 0
    assert_heard_at(folder / "out.wav", onsets[0])
    onsets = onsets[SETTLED:]
    beat, start = np.polyfit(np.arange(len(onsets)), onsets, 1)
    lost = told["underflows"] > 0 or abs(beat / (0.0411 * RATE) - 1) > 1e-4  # JACK's dummy device loses time silently
    return np.inf if lost else float(np.std(np.array(onsets) - start - beat * np.arange(len(onsets))))


def assert_heard_at(recording: Path, onset: float) -> None:
    sound, _ = soundfile.read(recording)
    assert np.argmax(np.abs(sound).max(axis=1) > 0) == pytest.approx(onset, abs=2)


@pytest.mark.parametrize(
    ("send", "device"),
    [(python_osc, "none"), (sclang, "none"), (python_osc, "system")],
    ids=["python-osc", "sclang", "jack"],
)
def test_onsets_are_even_to_less_than_a_sample(tmp_path, request, send, device):
    if send is sclang:
        needs.program("sclang")
    if device == "system":
        needs.module("sounddevice")
        request.getfixturevalue("jack").start(1024)
    heard = []
    while len(heard) < TAKES and min(heard, default=np.inf) >= 1.0:
        heard.append(jitter(tmp_path, device, send))
    assert min(heard) < 1.0


def test_the_wall_clock_may_be_set_while_events_wait(monkeypatch):
    """A tag is turned into the engine's time as it arrives; what the wall clock does then is nothing to it."""
    from carom.server import time_tags
    from carom.server.osc import wire

    wall = time.time_ns()
    monkeypatch.setattr(time, "time_ns", lambda: wall + 10**9)
    at, clock = time_tags._clocks()
    assert at == wall + 10**9 and abs(clock - time_tags.clock_ns()) < 10**8
    assert wire.unix_ns(wire.time_tag(1.5), wall) == 1_500_000_000


@pytest.mark.parametrize("away", [-10.0, -0.25, 0.0, 0.25, 1_000.0, 3e9])
def test_time_tags_are_right_where_their_seconds_begin_anew(monkeypatch, away):
    """On 7 February 2036 and after it: a tag a second before or after now, whichever side of the border each is on."""
    from carom.dsp.native.system import clock_ns
    from carom.dsp.runtime.engine import Engine
    from carom.server import time_tags
    from carom.server.osc import wire
    from carom.server.osc.arguments import Refused

    engine, wall = Engine(RATE), round(1e9 * (2**32 - 2208988800 + away))
    engine.process(64)
    monkeypatch.setattr(time_tags, "_clocks", lambda: (wall, clock_ns()))
    for ahead in (-1.0, -0.1, 0.1, 1.0):
        before = engine.stamp(clock_ns())
        at = time_tags.time_of(wire.time_tag(1e-9 * wall + ahead), engine)
        assert (at - before) / RATE == pytest.approx(ahead, abs=0.05)
    with pytest.raises(Refused, match="7200 s ahead; expected at most 3600 s"):
        time_tags.time_of(wire.time_tag(1e-9 * wall + 7_200.0), engine)


def an_hour_late() -> None:
    """Assert that an event of an hour ago is that late, and is carried out, however young the machine is."""
    from carom.dsp.engine.memory.commands import Command, Kind
    from carom.dsp.native.system import clock_ns
    from carom.dsp.runtime.engine import Engine

    engine = Engine(RATE)
    engine.process(64)
    engine.send([Command(engine.stamp(clock_ns() - 3_600 * 10**9), Kind.SYNC, value=1.0)])
    engine.process(64)
    assert (engine.stats.late, engine.stats.synced) == (1, 1)
    assert engine.stats.late_worst == pytest.approx(3_600, rel=1e-3)


def test_an_hour_late_is_told_on_a_machine_that_is_a_minute_old():
    """The server runs in a time namespace, where the system can make one."""
    offsets = Path("/proc/self/timens_offsets")
    here = int(offsets.read_text().split()[1]) if offsets.exists() else 0  # s: offsets count from the system's clock
    namespace = [needs.program("unshare"), "--fork", "--time", "--monotonic", str(here + 60 - int(time.monotonic()))]
    if subprocess.run([*namespace, "true"], capture_output=True).returncode:
        needs.skip("no time namespace can be made", "root may, on Linux 5.6 and newer")
    code = f"import time; from {__name__} import an_hour_late; assert time.monotonic() < 120; an_hour_late()"
    root = Path(__file__).parents[2]
    subprocess.run([*namespace, sys.executable, "-c", code], cwd=root, check=True, timeout=120)


def test_an_hour_late_is_told_here():
    an_hour_late()
