"""The whole of a render: channels, levels, pascals, a peak, and a file for each object."""

import math
from pathlib import Path

import numpy as np
import pytest
import soundfile

from carom.dsp.numerics.constants import FULL_SCALE_PRESSURE
from carom.presets import Presets
from carom.server.limiting import Limiting
from carom.server.osc.score import ScoreError, parse
from carom.server.render import Options, RenderError, blocks, render
from tests.support import render_lines

pytestmark = pytest.mark.slow

SCORE = """
0 /object/new bell church-bell pan -0.2
0 /object/new tom tom pan 0.7
0 /object/new never triangle
0.01 /object/bell/impact 0.7
0.05 /object/tom/impact 2
0.1 /object/tom/roll 0.4 striker glass-marble id ball seed 1
0.15 /object/bell/gain -6
0.2 /object/bell/pan 0.9
0.3 /object/tom/free 1
0.4 /object/new tom tom pan -0.7
0.41 /object/tom/impact 1
0.45 /gain 3
"""


def heard(text: str, **options) -> np.ndarray:
    return render_lines(parse(text.encode(), "score"), **{"seconds": 0.5, **options}).astype(float)


def rendered(tmp_path: Path, text: str, name: str = "x.wav", stems: str | None = None, **options):
    """Render to a file; return what became of it, its sound, and its warnings."""
    warnings: list[str] = []
    lines = parse(text.encode(), "score")
    chosen = Options(**{"seconds": 0.5, **options})
    folder = tmp_path / stems if stems else None
    done = render(lines, tmp_path / name, Presets(), chosen, warn=warnings.append, stems=folder)
    return done, soundfile.read(tmp_path / name, always_2d=True)[0], warnings


# Full scale and pascals


@pytest.mark.parametrize("striker", ["drumstick", "coin"])
def test_a_sample_is_a_share_of_full_scale_by_the_preset_s_level_or_a_pascal(striker):
    """The object and its striker. Loud, as modes are put to rest by how loud they are."""
    level = Presets().object("tom").level
    text = f"0 /object/new a tom gain 20\n0.01 /object/a/impact 2 striker {striker}\n"
    pascals = heard(text, calibrated=True)
    share = heard(text, limiter=False)
    assert np.abs(pascals).max() > 1e-3
    expected = pascals * 10 ** (level / 20) / FULL_SCALE_PRESSURE
    np.testing.assert_allclose(share, expected, atol=1e-4 * np.abs(expected).max())
    changed = heard(text.replace("tom gain 20", "tom gain 20 level 60"), calibrated=True)
    np.testing.assert_array_equal(changed, pascals)
    louder = heard(text.replace("gain 20", "gain 40"), calibrated=True)
    np.testing.assert_allclose(louder, 10 * pascals, atol=1e-4 * np.abs(louder).max())


def test_pascals_are_not_limited():
    loud = "/object/a/impact 20 gain 40"
    text = f"0 /object/new a tom gain 40\n0.01 {loud}\n0.1 /limiter on\n0.1 {loud}"
    warnings: list[str] = []
    options = Options(seconds=0.3, calibrated=True)
    lines = parse(text.encode(), "score")
    sound = np.concatenate(list(blocks(lines, options.engine(lines), Presets(), options, warn=warnings.append)))
    assert np.abs(sound).max() > 100.0
    assert warnings == ["score:3: /limiter: no effect: samples are pascals, which nothing limits"]


@pytest.mark.parametrize(
    ("options", "culprit"),
    [
        ({"calibrated": True, "limiter": True}, "limiter = on: expected none, as calibrated samples are pascals"),
        ({"calibrated": True, "normalize": -1.0}, "normalize = -1: expected none, as calibrated"),
        ({"calibrated": True, "format": "24"}, "format = 24: expected float, as calibrated"),
        ({"channels": 0}, "channels = 0: expected a number from 1 to 64"),
        ({"channels": 65}, "channels = 65: expected a number from 1 to 64"),
        ({"channels": 2.5}, r"channels = 2.5: expected a whole number"),
        ({"gain": 41.0}, "gain = 41: expected a number from -120 to 40 dB"),
        ({"gain": math.nan}, "gain = nan: expected a number"),
        ({"normalize": 1.0}, "normalize = 1: expected a number from -100 to 0 dBFS"),
    ],
)
def test_bad_options_are_named(options, culprit):
    with pytest.raises(RenderError, match=culprit):
        Options(**options)


def test_pascals_are_written_as_floats(tmp_path):
    done, *_ = rendered(tmp_path, "0 /object/new a tom\n0 /object/a/impact 2\n", calibrated=True)
    assert soundfile.info(tmp_path / "x.wav").subtype == "FLOAT" and done.limiting.said() == ""
    with pytest.raises(RenderError, match="format = float: FLAC holds 16 or 24"):
        rendered(tmp_path, SCORE, "x.flac", calibrated=True)
    with pytest.raises(RenderError, match=r"x\.flac: 9 channels: FLAC holds at most 8"):
        rendered(tmp_path, SCORE, "x.flac", channels=9)


# The head of a score


def test_a_score_says_its_channels_gain_and_limiter():
    head = "0 /gain 12\n0 /limiter off\n0 /channels 1\n"
    sound = heard(head + SCORE)
    assert sound.shape[1] == 1
    np.testing.assert_array_equal(sound, heard(SCORE, channels=1, gain=12.0, limiter=False))


def test_options_take_the_place_of_a_score_s_head_alone():
    head = "0 /gain 12\n0 /limiter off\n0 /channels 1\n"
    sound = heard(head + SCORE, channels=4, gain=-3.0, limiter=True)
    np.testing.assert_array_equal(sound, heard(SCORE, channels=4, gain=-3.0))
    later = "0.3 /gain -20\n"
    np.testing.assert_array_equal(heard(later + SCORE, gain=5.0), heard(f"0 /gain 5\n{later}{SCORE}"))
    assert np.abs(heard(later + SCORE, gain=5.0)[19_200:21_000]).max() < np.abs(heard(SCORE)[19_200:21_000]).max()


def test_a_line_that_says_other_channels_is_refused():
    with pytest.raises(ScoreError, match="score:2: /channels: channels = 3: expected 8, as many as were opened"):
        heard("0 /channels 8\n0.1 /channels 3\n" + SCORE)
    with pytest.raises(ScoreError, match="score:1: /channels: channels = 0: expected a number from 1 to 64"):
        heard("0 /channels 0\n" + SCORE)


# A file for each object


@pytest.mark.parametrize("channels", [1, 2, 8])
def test_stems_add_up_to_the_sound(tmp_path, channels):
    """The score frees an object and makes a namesake, moves one, and has one that never sounds."""
    done, sound, _ = rendered(tmp_path, SCORE, stems="parts", channels=channels, limiter=False)
    files = {path.name: soundfile.read(path, always_2d=True)[0] for path in (tmp_path / "parts").iterdir()}
    assert set(files) == {"bell.wav", "tom.wav", "never.wav"} and done.engine.channels == channels
    assert all(stem.shape == sound.shape for stem in files.values()) and not files["never.wav"].any()
    assert np.abs(sum(files.values()) - sound).max() < 1e-6 < np.abs(sound).max()
    np.testing.assert_array_equal(sound, heard(SCORE, channels=channels, limiter=False))


def test_stems_have_the_kind_and_the_scale_of_the_whole(tmp_path):
    _, sound, _ = rendered(tmp_path, SCORE, "x.flac", stems="parts", normalize=-6.0, format="16")
    files = [soundfile.read(path)[0] for path in sorted((tmp_path / "parts").iterdir())]
    assert {soundfile.info(path).subtype for path in (tmp_path / "parts").iterdir()} == {"PCM_16"}
    assert np.abs(sum(files) - sound).max() < 4 * 2**-15 and np.abs(sound).max() == pytest.approx(0.5, rel=0.01)
    assert not [path for path in tmp_path.rglob("*") if path.name.startswith(".")]


def test_a_folder_that_can_not_be_made_is_named(tmp_path):
    (tmp_path / "parts").write_text("a file")
    with pytest.raises(RenderError, match="parts: expected a folder, and a file is there"):
        rendered(tmp_path, SCORE, stems="parts")
    assert not (tmp_path / "x.wav").exists()


# A peak that is asked for


@pytest.mark.parametrize("level", [-1.0, -20.0, 0.0])
def test_the_whole_is_brought_to_a_peak(tmp_path, level):
    """The sound as it is without a limiter, times one gain, which is told."""
    done, sound, warnings = rendered(tmp_path, SCORE, normalize=level, gain=20.0)
    plain = heard(SCORE, gain=20.0, limiter=False)
    assert np.abs(sound).max() == pytest.approx(10 ** (level / 20), rel=1e-6) and warnings == []
    np.testing.assert_allclose(sound, plain * 10 ** (done.normalized / 20), rtol=1e-5, atol=1e-12)


def test_a_limiter_that_is_asked_for_comes_first(tmp_path):
    done, *_ = rendered(tmp_path, SCORE, normalize=-1.0, gain=40.0, limiter=True)
    assert done.limiting.db > 1.0 and "too loud: tom (" in done.limiting.said()
    assert done.normalized == pytest.approx(0.0, abs=0.2)  # its ceiling is the peak that is asked for


def test_the_limiter_names_no_object_of_less_than_a_hundredth():
    limiting = Limiting(((0.0, 1.0),), 2.0, {"bell": 0.995, "(freed)": 0.005})
    assert "too loud: bell (100%); the limiter" in limiting.said()


def test_silence_stays_and_is_told(tmp_path):
    done, sound, warnings = rendered(tmp_path, "0 /object/new a tom\n", normalize=-1.0)
    assert not sound.any() and done.normalized == 0.0 and warnings == ["the sound is silence: it is not normalized"]


def test_stems_lie_in_their_folder_whatever_their_objects_are_called(tmp_path):
    """Names that lead elsewhere on some system, that are devices there, and that differ but in case."""
    names = ("\\..\\y", "NUL", "a:b", "x", "X", "..")
    text = "".join(f"0 /object/new '{name}' wood-block\n0 '/object/{name}/impact' 1\n" for name in names)
    rendered(tmp_path, text, stems="parts", seconds=0.05)
    assert sorted(path.stem for path in (tmp_path / "parts").iterdir()) == sorted(
        ["%5C..%5Cy", "%4EUL", "a%3Ab", "x", "X%2", "%2E%2E"]
    )
