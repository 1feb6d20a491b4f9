"""carom strike: one line to a sound."""

import numpy as np
import pytest
import soundfile

from carom.clients import strike
from carom.presets import Presets
from carom.server.osc.score import parse
from tests.support import Jack, render_lines

pytestmark = pytest.mark.slow


def test_a_strike_is_the_score_that_says_the_same(carom_here, tmp_path):
    carom_here(
        "strike", "glass-plate", "a.wav", "--velocity", "5e-1", "--position", "0.2", "--striker", "wood", check=True
    )
    score = b"0 /object/new p glass-plate\n0 /object/p/impact 0.5 0.2 striker wood\n"
    samples, rate = soundfile.read(tmp_path / "a.wav", dtype="float32")
    assert rate == 48_000 and np.array_equal(samples, render_lines(parse(score, "s")))


def test_its_velocity_is_the_presets(carom_here, tmp_path):
    velocity = Presets().object("wood-block").velocity
    carom_here("strike", "wood-block", "a.flac", "--rate", "44100", "--seconds", "0.1", check=True)
    carom_here(
        "strike", "wood-block", "b.flac", "--rate", "44100", "--seconds", "0.1", "--velocity", velocity, check=True
    )
    assert (tmp_path / "a.flac").read_bytes() == (tmp_path / "b.flac").read_bytes()
    assert soundfile.info(tmp_path / "a.flac").frames == 4_410


def test_the_default_device_plays_it(carom, jack: Jack):
    jack.start(256, 44_100)
    run = carom("strike", "wood-block", "--seconds", "0.3")
    assert (run.returncode, run.stderr) == (0, "")


class Device:
    """A sound device that plays at once."""

    PortAudioError = RuntimeError

    def __init__(self):
        self.played = []

    def play(self, sound, rate, blocking):
        self.played.append(sound)


def test_a_strike_on_a_device_tells_of_the_limiter_as_one_in_a_file_does(carom_here, monkeypatch):
    device = Device()
    monkeypatch.setattr(strike, "portaudio", lambda: device)
    words = "strike", "wood-block", "--velocity", "20", "--rate", "48000", "--seconds", "0.2"
    heard = carom_here(*words)
    written = carom_here(*words[:2], "loud.wav", *words[2:])
    assert "too loud: wood-block" in written.stderr and heard.stderr == written.stderr
    assert np.array_equal(device.played[0], soundfile.read("loud.wav", dtype="float32")[0])


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (("wood-blok",), "no object 'wood-blok': did you mean wood-block?"),
        (("wood-block", "a.wav", "--striker", "stel"), "no striker 'stel': did you mean steel?"),
        (("wood-block", "a.wav", "--velocity", "-1"), "velocity = -1: expected a number from 0 to 1000 m/s"),
        (("wood-block", "a.mp3"), "a.mp3: expected a name that ends in .wav or .flac"),
    ],
)
def test_error_of_a_strike_is_one_line_and_nothing_is_written(carom_here, tmp_path, words, error):
    run = carom_here("strike", *words)
    assert run.returncode == 1 and error in run.stderr and run.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("why", ["no device can play", "PortAudio library not found: install PortAudio"])
def test_a_file_is_proposed_where_nothing_plays(carom_here, tmp_path, monkeypatch, why):
    """Whatever this machine has: no device, or not even the library that looks for one."""

    def devices():
        if "PortAudio" in why:
            raise strike.AudioError(why)
        return []

    monkeypatch.setattr(strike, "devices", devices)
    run = carom_here("strike", "wood-block")
    said = f"carom strike: {why}; name a file instead: carom strike wood-block wood-block.wav\n"
    assert (run.returncode, run.stderr) == (1, said) and not list(tmp_path.iterdir())
