"""Real time against real back ends: what leaves PortAudio is what a render gives, bit for bit."""

import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from carom.server.audio.outputs import AudioError, open_output
from carom.server.osc.score import Line, read
from tests import needs
from tests.support import render_lines

pytestmark = pytest.mark.slow

SCORE = """0 /object/new bell church-bell pan -0.2
0 /object/new glass wine-glass pan 0.5
0 /object/new lid tin-lid pan 0.3 gain -10
0.1 /object/bell/impact 0.7
0.3 /object/glass/bounce 0.05 striker glass-marble irregularity 0.3 seed 1 id ball
0.5 /object/lid/impact 1.2 0.2 striker coin
0.8 /object/lid/roll 0.3 striker glass-marble surface glass seed 2 id marble
1.2 /object/bell/tune -5
1.2 /object/bell/impact 1.0
1.5 /object/*/damp 0.6
2.5 /panic
"""
LEAD = 1.0  # s before the first event, for the recorder to connect

PLAYER = """
import sys, time
from carom.server.audio.outputs import open_output
from carom.presets.library import Presets
from carom.server.render import Options
from carom.server.scene.session import Session
from carom.server.osc.score import read, sample_at
score = read(sys.argv[1])
engine = Options().engine(score)
scene = Session(engine, Presets())
for line in sorted(score, key=lambda line: line.time):
    assert all(r.address == "/done" for r in scene.perform([line.message], sample_at(line.time + 1.0, 48_000)))
output = open_output(engine, sys.argv[2], 0)
output.start()
while engine.position < float(sys.argv[3]) * 48_000 + engine.delay:
    time.sleep(0.01)
output.close()
print(engine.stats.underflows)
"""


def shifted(lines: list[Line]) -> list[Line]:
    return [Line(line.time + LEAD, line.message, line.where) for line in lines]


@pytest.mark.parametrize("channels", [2, 5])
def test_jack_hears_what_a_render_gives(jack, tmp_path, channels):
    """A score through PortAudio on jackd's dummy driver, recorded by a JACK client: the offline render's samples.

    A virtual machine that is stopped for a while loses a block; three takes, of which one must be whole.
    """
    jack.start(2048, channels=channels)  # blocks long enough for a machine that is busy
    score = tmp_path / "score.txt"
    score.write_text(f"0 /channels {channels}\n{SCORE}")
    expected = render_lines(shifted(read(score)))
    for take in range(3):
        heard = one_take(score, len(expected) / 48_000 + 1.0, channels)
        try:
            return assert_heard(heard, expected)
        except AssertionError:
            if take == 2:
                raise


def one_take(score: Path, seconds: float, channels: int) -> np.ndarray:
    """Record a score as JACK hears it."""
    with recording(seconds + 5.0, channels) as recorder:
        player = subprocess.Popen(
            [sys.executable, "-c", PLAYER, str(score), "system", str(seconds)], stdout=subprocess.PIPE, text=True
        )
        recorder.connect()
        out, _ = player.communicate(timeout=seconds + 60)
        assert player.returncode == 0, out
    return recorder.sound()


def assert_heard(heard: np.ndarray, expected: np.ndarray) -> None:
    """Assert that every expected sample was heard from the first that is not zero on: back ends begin with silence of
    their own."""
    start, lead = first_sound(heard), first_sound(expected)
    np.testing.assert_array_equal(heard[start : start + len(expected) - lead], expected[lead:])


def first_sound(sound: np.ndarray) -> int:
    assert sound.any()
    return int(np.argmax(np.abs(sound).max(axis=1) > 0))


class recording:  # noqa: N801 - used as a context, like the standard library's
    """Records every client's output from a JACK server, for up to some seconds."""

    def __init__(self, seconds: float, channels: int) -> None:
        import jack

        deadline = time.monotonic() + 10
        while True:
            try:
                self._client = jack.Client("carom-recorder", no_start_server=True)
                break
            except jack.JackOpenError:
                if time.monotonic() > deadline:
                    raise
                time.sleep(0.1)
        self._inputs = [self._client.inports.register(f"in_{n}") for n in range(channels)]
        self._sound = np.zeros((round(seconds * 48_000), channels), np.float32)
        self._frames = 0
        self._client.set_process_callback(self._process)

    def __enter__(self) -> "recording":
        self._client.activate()
        return self

    def __exit__(self, *_: object) -> None:
        self._client.deactivate()
        self._client.close()

    def _process(self, frames: int) -> None:
        end = min(self._frames + frames, len(self._sound))
        for channel, port in enumerate(self._inputs):
            self._sound[self._frames : end, channel] = port.get_array()[: end - self._frames]
        self._frames = end

    def connect(self) -> None:
        """Wait for a client that plays, and listen to it."""
        deadline = time.monotonic() + 30
        while time.monotonic() < deadline:
            ports = self._client.get_ports(is_audio=True, is_output=True)
            playing = [p for p in ports if not p.name.startswith(("system:", "carom-recorder:"))]
            if len(playing) == len(self._inputs):
                for source, target in zip(playing, self._inputs, strict=True):
                    self._client.connect(source, target)
                return
            time.sleep(0.02)
        raise TimeoutError("no client plays")

    def sound(self) -> np.ndarray:
        return self._sound[: self._frames]


def test_alsa_writes_what_a_render_gives(tmp_path):
    """ALSA's file device through PortAudio, unpaced: the same samples again, by another back end."""
    needs.module("sounddevice")
    if not Path("/usr/share/alsa/alsa.conf").exists():
        needs.skip("ALSA is not installed", "apt install libasound2-data")
    score = tmp_path / "score.txt"
    score.write_text("0 /object/new a glass-plate\n0.1 /object/a/impact 1\n0.5 /object/a/impact 2 striker wood\n")
    raw = tmp_path / "out.raw"
    (tmp_path / "asound.conf").write_text(
        # By its name alone: ALSA aborts at a letter that is not ASCII.
        f'</usr/share/alsa/alsa.conf>\npcm.carom {{ type file slave.pcm null file "{raw.name}" format raw }}\n'
    )
    env = os.environ | {"ALSA_CONFIG_PATH": "asound.conf"}
    expected = render_lines(shifted(read(score)))
    words = [sys.executable, "-c", PLAYER, str(score), "carom", str(len(expected) / 48_000 + 1.0)]
    run = subprocess.run(words, env=env, cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert run.returncode == 0, run.stderr
    assert_heard(np.fromfile(raw, np.float32).reshape(-1, 2), expected)


def test_a_machine_without_devices_is_told_what_to_do(monkeypatch):
    needs.module("sounddevice")
    from carom.dsp.runtime.engine import Engine

    monkeypatch.setattr("carom.server.audio.outputs.devices", lambda: [])
    with pytest.raises(AudioError, match=r"^no device can play: start JACK, .* `carom serve --device none`$"):
        open_output(Engine(48_000), None, 0)


def test_no_such_device():
    needs.module("sounddevice")
    from carom.dsp.runtime.engine import Engine

    with pytest.raises(AudioError, match=r"device no-such-device: .*`carom devices` lists"):
        open_output(Engine(48_000), "no-such-device", 0)


def test_a_name_that_fits_several_is_told_in_one_line(monkeypatch):
    sd = needs.module("sounddevice")
    from carom.dsp.runtime.engine import Engine

    found = [{"name": f"Card {n}", "hostapi": 0, "max_output_channels": 2} for n in range(2)]
    monkeypatch.setattr(sd, "query_hostapis", lambda index=None: {"name": "ALSA"})
    lookup = sd.query_devices
    monkeypatch.setattr(
        sd, "query_devices", lambda device=None, kind=None: found if device is None else lookup(device, kind)
    )
    with pytest.raises(
        AudioError, match=r"^device Card: Multiple output devices found for 'Card': .*Card 0.*Card 1"
    ) as told:
        open_output(Engine(48_000), "Card", 0)
    assert "\n" not in str(told.value)


def test_the_clock_keeps_time():
    from carom.dsp.runtime.engine import Engine

    engine = Engine(48_000)
    output = open_output(engine, "none", 64)
    output.start()
    time.sleep(1.0)
    output.close()
    assert 0.5 < engine.position / 48_000 < 1.5
