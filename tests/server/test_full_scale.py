"""The pressure of full scale: chosen, told, and the same in a render and on a server."""

import subprocess

import numpy as np
import pytest
import soundfile

import carom
from carom.dsp.numerics.constants import FULL_SCALE_PRESSURE
from carom.server.render import Options, RenderError
from tests.server.test_warnings import status
from tests.support import CAROM, serving

# Loud, as modes are put to rest by how loud they are.
SCORE = "0 /object/new a tom level 0 gain 20\n0.01 /object/a/impact 1\n"


def heard(**options) -> np.ndarray:
    return carom.render(options.pop("head", "") + SCORE, seconds=0.3, limiter=False, **options).samples


def test_a_sample_is_the_pressure_over_full_scale():
    """The object has level 0; an option stands above the score."""
    pascals = heard(calibrated=True)
    for options, full_scale in (
        ({}, FULL_SCALE_PRESSURE), ({"full_scale": 0.5}, 0.5), ({"head": "0 /full_scale 3\n"}, 3.0),
        ({"head": "0 /full_scale 3\n", "full_scale": 7.0}, 7.0),
    ):  # fmt: skip
        found = heard(**options)
        np.testing.assert_allclose(full_scale * found, pascals, atol=1e-4 * np.abs(pascals).max())
    np.testing.assert_array_equal(heard(calibrated=True, head="0 /full_scale 3\n"), pascals)


def test_a_scene_has_it():
    with carom.Scene(full_scale=0.5, limiter=False) as scene:
        scene.new("a", "tom", level=0.0, gain=20.0).impact(1.0, at=0.01)
        sound = scene.render(0.3)
        assert sound.scale.full_scale == 0.5 and not sound.calibrated
        np.testing.assert_array_equal(sound.samples, heard(full_scale=0.5))
        with pytest.raises(carom.CommandError, match=r"/full_scale: full_scale = 2: expected 0\.5 Pa, as was chosen"):
            scene.send("/full_scale", 2.0)


@pytest.mark.parametrize(
    ("options", "culprit"),
    [
        ({"full_scale": 0.0}, "full_scale = 0: expected a number from 1e-06 to 1e\\+06 Pa"),
        ({"full_scale": 2.0, "calibrated": True}, "full_scale = 2: expected none, as calibrated samples are pascals"),
    ],
)
def test_bad_ones_are_named(options, culprit):
    with pytest.raises(RenderError, match=culprit):
        Options(**options)


@pytest.mark.parametrize("ending", ["wav", "flac"])
def test_a_file_s_metadata_say_it(tmp_path, ending):
    path = tmp_path / f"a.{ending}"
    for options, comment in (
        ({"full_scale": 2.0}, "1.0 is 2 Pa of an object of level 0 dB"), ({"calibrated": True}, "1.0 is 1 Pa"),
    ):  # fmt: skip
        if ending == "wav" or "calibrated" not in options:
            carom.render(SCORE, seconds=0.1, **options).save(path)
            with soundfile.SoundFile(path) as file:
                assert file.comment == comment


@pytest.mark.slow
def test_the_command_line_and_the_server_have_it(tmp_path):
    """A unit may follow; the status, the log and the recording's metadata tell it, and a message with another is
    refused."""
    (tmp_path / "s.txt").write_text(SCORE)
    words = [*CAROM, "render", "s.txt", "s.wav", "--seconds", "0.3", "--full-scale", "2 Pa", "--limiter", "off"]
    subprocess.run(words, cwd=tmp_path, check=True, capture_output=True)
    np.testing.assert_array_equal(soundfile.read(tmp_path / "s.wav", dtype="float32")[0], heard(full_scale=2.0))
    options = ("--device", "none", "--full-scale", "2Pa", "--record", "r.wav", "--log", "l.txt")
    with serving(tmp_path, *options) as server:
        with server.client() as client:
            assert status(client)["full_scale"] == 2.0
            client.send("/full_scale", 2.0)
            client.send("/full_scale", 3.0)
            client.ask("/sync", 1)
            assert [str(error) for error in client.errors()] == [
                "/full_scale: full_scale = 3: expected 2 Pa, as was chosen at the start"
            ]
        server.quit()
    with soundfile.SoundFile(tmp_path / "r.wav") as file:
        assert file.comment == "1.0 is 2 Pa of an object of level 0 dB"
    assert "/full_scale 2" in (tmp_path / "l.txt").read_text()
