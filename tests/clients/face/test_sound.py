"""carom.Sound: saved, drawn, played in a notebook, taken as an array."""

import base64
import io
import pickle
import re

import numpy as np
import pytest
import soundfile

import carom


@pytest.fixture(scope="module")
def sound():
    return carom.render("0 /object/new a wood-block pan 1\n0.01 /object/a/impact 1\n", 44_100, seconds=0.25)


def test_sound_is_an_array_of_frames(sound):
    array = np.asarray(sound)
    assert array.shape == (11_025, 2) and array.dtype == np.float32 and np.shares_memory(array, sound.samples)
    assert len(sound) == 11_025 and sound.duration == 0.25 and sound.start == 0.0
    assert np.asarray(sound, dtype=np.float64).dtype == np.float64
    assert np.abs(array[:, 1]).max() > 0.01 and np.abs(array[:, 0]).max() < 1e-6
    copy = pickle.loads(pickle.dumps(sound))
    assert copy.report == sound.report and np.array_equal(copy, sound)


@pytest.mark.parametrize(
    ("name", "format", "subtype", "error"),
    [
        ("s.wav", None, "FLOAT", 0.0),
        ("s.flac", None, "PCM_24", 2**-23),
        ("s.flac", "16", "PCM_16", 2**-15),
        ("S.WAV", "24", "PCM_24", 2**-23),
    ],
)
def test_sound_is_saved_by_the_names_ending(sound, tmp_path, name, format, subtype, error):
    sound.save(str(tmp_path / name), format)
    info = soundfile.info(tmp_path / name)
    assert (info.samplerate, info.subtype, info.frames) == (44_100, subtype, 11_025)
    saved = soundfile.read(tmp_path / name, dtype="float32")[0]
    assert np.abs(saved - sound.samples).max() <= error


@pytest.mark.parametrize(
    ("name", "format", "text"),
    [
        ("s.mp3", None, "s.mp3: expected a name that ends in .wav or .flac"),
        ("s.flac", "float", "format = float: FLAC holds 16 or 24"),
        ("s.wav", "32", "format = 32: expected 16, 24, float"),
        ("none/s.wav", None, "there is no folder"),
    ],
)
def test_error_of_saving_names_the_culprit(sound, tmp_path, name, format, text):
    with pytest.raises(carom.RenderError, match=text):
        sound.save(tmp_path / name, format)
    assert not list(tmp_path.iterdir())


def test_a_notebook_plays_it(sound):
    data = re.fullmatch(r'<audio controls src="data:audio/flac;base64,([A-Za-z0-9+/=]+)"></audio>', sound._repr_html_())
    assert data
    played, rate = soundfile.read(io.BytesIO(base64.b64decode(data[1])))
    assert rate == 44_100 and np.abs(played - sound.samples).max() <= 2**-15
    loud = carom.Sound(sound.samples * np.float32(8.0 / np.abs(sound.samples).max()), 44_100)
    data = re.search(r"base64,([^\"]+)", loud._repr_html_())
    assert data
    played = soundfile.read(io.BytesIO(base64.b64decode(data[1])))[0]
    np.testing.assert_allclose(played, loud.samples / 8.0, atol=2**-15)


@pytest.mark.slow
def test_sound_is_drawn_into_a_file_or_for_a_notebook(sound, tmp_path):
    assert sound.plot(tmp_path / "s.svg") is None
    assert b"<svg" in (tmp_path / "s.svg").read_bytes() and len(list(tmp_path.iterdir())) == 1
    picture = sound.plot()
    assert picture is not None and picture._repr_png_().startswith(b"\x89PNG")
    with pytest.raises(RuntimeError, match=r"s\.bmp: expected a name that ends in"):
        sound.plot(tmp_path / "s.bmp")
