"""carom fit and carom compare as they are typed, and what they refuse."""

import json
import re

import numpy as np
import pytest
import soundfile

import carom
from carom.clients import recordings
from carom.clients.cli import main
from carom.clients.commands import progress
from carom.dsp.numerics.constants import FULL_SCALE_PRESSURE

RATE = 32_000
T = np.arange(RATE) / RATE
RING = 0.2 * sum(np.exp(-6 * k * T) * np.sin(2 * np.pi * f * T) for k, f in ((1, 440), (2, 1230), (3, 2810)))


def drum() -> np.ndarray:
    """Return a hit on a drum whose modes do not begin together; its peaks at full scale."""
    sound = sum(np.exp(-25 * T) * np.sin(2 * np.pi * f * T + f) for f in (180, 310, 480, 700))
    return np.concatenate([np.zeros(400), 0.99 * sound / np.abs(sound).max()])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recordings")
    noise = 1e-5 * np.random.default_rng(1).standard_normal(RATE)
    files = {
        "ring": RING + noise,
        "stereo": np.stack([0.3 * RING, RING], 1),
        "silence": 0 * T,
        "clipped": np.clip(20 * RING, -1, 1),
        "nan": np.where(np.arange(RATE) == 9, np.nan, RING),
        "tiny": RING[:50],
        "noise": 1e4 * noise,
        "steady": 0.1 * np.sin(2 * np.pi * 440 * T),
        "reversed": RING[::-1],
        "click": np.where(np.arange(RATE) == 9_000, 0.9, 0.2),
        "hum": RING + noise + 0.01 * np.sin(2 * np.pi * 50 * T),
        "short": 0.3 * np.exp(-0.5 * T)[:8_000] * np.sin(2 * np.pi * 440 * T)[:8_000],
        "noisy": RING + 1_000 * noise,
        "drum": drum(),
    }
    for name, samples in files.items():
        soundfile.write(folder / f"{name}.wav", samples, RATE, subtype="FLOAT")
    soundfile.write(folder / "long.wav", np.zeros(130 * 8000, np.int16), 8000)
    soundfile.write(folder / "empty.wav", np.zeros(0), RATE)
    (folder / "text.wav").write_text("no sound")
    (folder / "none.mp3").touch()
    (folder / "none.wav").touch()
    (folder / "pointer.wav").write_text("version https://git-lfs.github.com/spec/v1\noid sha256:aa\nsize 12\n")
    (folder / "notes").mkdir()
    (folder / "notes" / "a.txt").write_text("no sound")
    return folder


REFUSED = [
    ("silence.wav out --name a", "silence.wav: silent", "expected the sound of a strike"),
    ("clipped.wav out --name a", "clipped.wav: clipped in", "expected a recording below full scale"),
    ("nan.wav out --name a", "nan.wav: sample 9 is nan", "expected numbers"),
    ("tiny.wav out --name a", "tiny.wav: 0.00156 s long", "expected at least 0.03 s"),
    ("empty.wav out --name a", "empty.wav: empty", "expected the sound of a strike"),
    ("steady.wav out --name a", "steady.wav: ", "expected"),
    ("reversed.wav out --name a", "reversed.wav: ", "expected"),
    ("click.wav out --name a", "click.wav: a click", "expected the sound of a strike"),
    ("long.wav out --name a", "long.wav: 130 s long", "expected at most 120 s"),
    ("text.wav out --name a", "text.wav: ", "expected a sound file; `ffmpeg -i text.wav text-plain.wav`"),
    ("none.mp3 out --name a", "none.mp3: it holds no sound", "expected a sound file; `ffmpeg -i none.mp3 none.wav`"),
    ("none.wav out --name a", "none.wav: it holds no sound", "expected a sound file; `ffmpeg -i none.wav"),
    ("pointer.wav out --name a", "pointer.wav: a pointer of Git LFS", "`git lfs pull` fetches it"),
    ("notes out --name a", "notes: a folder of 1 files", "expected .wav"),
    ("rng.wav out --name a", "rng.wav: No such file", "did you mean ring.wav?"),
    ("ring.wav out --name a/b", "name = 'a/b'", "expected a name of up to 64"),
    ("ring.wav out --name a --modes 0", "modes = 0", "expected 1 to 200"),
    ("ring.wav out --name a --positions 0.1,0.2", "positions: 2 for 1 hits", "expected one, or one for each"),
    ("ring.wav out --name a --positions 1.5", "positions: 1.5", "expected 0 to 1"),
    ("ring.wav out --name a --positions left", "'left'", "expected a number"),
    ("ring.wav out --name a --mass -1", "mass = -1", "expected 0.001 to"),
    ("ring.wav out --name a --full-scale 0", "full-scale = 0", "expected 0.001 to"),
    ("ring.wav out --name a --distance -1", "distance = -1", "expected 0.001 to"),
    ("ring.wav out --name a --force silence.wav", "silence.wav: silent", "expected the force of a hammer"),
    ("ring.wav out --name a --force noise.wav", "noise.wav: no pulse", "expected the force of a hammer"),
    ("ring.wav ring.wav --name a", "ring.wav", "expected a folder"),
    ("ring.wav out", "--name", "usage: carom fit"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("words", "culprit", "right"), REFUSED, ids=[words for words, _, _ in REFUSED])
def test_error_of_a_fit_is_one_line_and_nothing_is_written(folder, capsys, monkeypatch, words, culprit, right):
    monkeypatch.chdir(folder)
    try:
        code = main(["fit", *words.split()])
    except SystemExit as end:
        code = end.code
    error = capsys.readouterr().err
    assert code in (1, 2) and error.count("\n") == 1 and culprit in error and right in error
    assert not (folder / "out").exists()


@pytest.mark.slow
def test_a_stereo_recording_becomes_an_object_and_a_page(folder, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(folder)
    monkeypatch.setattr(progress, "PERIOD", 1e3)  # a busy machine takes long enough to tell its progress
    assert main(["fit", "stereo.wav", str(tmp_path), "--name", "bar", "--modes", "6", "--licence", "CC0"]) == 0
    out, error = capsys.readouterr()
    assert error == "carom fit: stereo.wav: 2 channels: channel 2 is taken, where most rises and decays\n"
    assert [line.removeprefix(str(tmp_path)) for line in out.split()] == [
        "/objects/bar.toml",
        "/strikers/bar-striker.toml",
        "/bar.html",
    ]
    page = (tmp_path / "bar.html").read_text()
    assert page.count("<audio") == 4 and page.count("<img") == 2
    assert main(["presets", "--check", str(tmp_path / "objects" / "bar.toml"), "--presets", str(tmp_path)]) == 0
    assert main(["strike", "bar", str(tmp_path / "x.wav"), "--presets", str(tmp_path), "--seconds", "1"]) == 0
    capsys.readouterr()
    assert main(["compare", str(folder / "ring.wav"), str(tmp_path / "x.wav"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["log_spectral_distance_db"] < 4


@pytest.mark.slow
@pytest.mark.parametrize("loud", [0.01, 0.3, 3.0])
@pytest.mark.parametrize("noise", ["hum", "hiss", "offset", "beats", "drift", "brown", "swells", "gaps"])
def test_a_channel_without_a_hit_is_not_taken_however_loud_it_is(tmp_path, noise, loud):
    t = np.arange(RATE) / RATE
    hit = 0.2 * np.sin(2 * np.pi * 440 * t) * np.exp(-8 * t) * (t > 0.1)
    hiss = np.random.default_rng(1).normal(size=RATE) / 3
    dead = {
        "hum": np.sin(2 * np.pi * 60 * t),
        "hiss": hiss,
        "offset": np.ones(RATE),
        "beats": (np.sin(2 * np.pi * 50 * t) + np.sin(2 * np.pi * 52 * t)) / 2,
        "drift": np.sin(2 * np.pi * 0.7 * t),
        "brown": np.cumsum(hiss) / 300,
        "swells": np.sin(2 * np.pi * 50 * t) * np.sin(2 * np.pi * 2 * t) ** 2,
        "gaps": np.sin(2 * np.pi * 100 * t) * (t % 0.3 < 0.2),
    }[noise]
    soundfile.write(tmp_path / "two.wav", np.stack([loud * dead, hit], axis=1), RATE, subtype="FLOAT")
    taken = recordings.read(tmp_path / "two.wav")
    assert taken.samples == pytest.approx(hit, abs=1e-6)


def struck(folder, recording, out, *options) -> float:
    """Return by how much (dB) the default strike is quieter than the recording it was fitted to, in what Carom
    writes."""
    source = folder / recording
    assert main(["fit", str(source), str(out), "--name", "bar", "--licence", "CC0", "--no-report", *options]) == 0
    words = ["strike", "bar", str(out / "x.wav"), "--presets", str(out), "--seconds", "1", "--rate", str(RATE)]
    assert main(words) == 0
    recorded, played = (soundfile.read(file)[0] for file in (source, out / "x.wav"))
    return 10 * np.log10(np.mean(recorded**2) / np.mean(played[: len(recorded)] ** 2))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "quieter"),
    [
        ((), 0.0),
        (("--full-scale", f"{FULL_SCALE_PRESSURE / 10:g}Pa", "--distance", "0.5"), 26.0),
    ],
    ids=["as it is", "calibrated"],
)
def test_the_default_strike_is_as_loud_as_the_recording_says(folder, tmp_path, options, quieter):
    assert struck(folder, "ring.wav", tmp_path, *options) == pytest.approx(quieter, abs=1)


@pytest.mark.slow
def test_the_default_strike_s_peaks_stay_under_full_scale(folder, tmp_path, capsys):
    """A preset's modes begin together, so that its peaks are higher against its loudness."""
    quieter = struck(folder, "drum.wav", tmp_path)
    told = capsys.readouterr().err
    assert "limiter" not in told
    said = re.search(r"the default strike is ([0-9.]+) dB quieter than the recording", told)
    assert said and quieter == pytest.approx(float(said[1]), abs=1)


@pytest.mark.slow
def test_a_short_recording_is_as_loud_as_its_preset_for_as_long(folder, tmp_path):
    assert struck(folder, "short.wav", tmp_path) == pytest.approx(0, abs=1)


@pytest.mark.slow
def test_a_bar_of_carom_s_own_is_as_loud_as_its_fit(tmp_path):
    """Two clicks that cancel each other in the recording would not do so from two channels."""
    with carom.Scene(RATE, limiter=False) as scene:
        scene.new("a", "marimba-bar", stereo_width=0).impact(1.0)
        soundfile.write(tmp_path / "bar.wav", scene.render(1.0).samples[:, 0], RATE, subtype="FLOAT")
    assert struck(tmp_path, "bar.wav", tmp_path / "out") == pytest.approx(0, abs=1.5)


@pytest.mark.slow
def test_a_strike_that_cannot_be_so_loud_is_told(folder, tmp_path, capsys):
    struck(folder, "ring.wav", tmp_path, "--full-scale", "1000")
    assert "dB, which calibrated sound lacks" in capsys.readouterr().err


@pytest.mark.slow
def test_pascals_are_those_that_the_recording_s_full_scale_stands_for(folder, tmp_path):
    """The strike has the energy for it."""
    struck(folder, "ring.wav", tmp_path, "--full-scale", "0.1", "--velocity", "3")
    assert "level = 0.0" in (tmp_path / "objects" / "bar.toml").read_text()
    with carom.Scene(RATE, presets=tmp_path, calibrated=True) as scene:
        scene.new("a", "bar").impact(3.0)
        pascals = scene.render(1.0).samples
    assert 10 * np.log10(np.mean(pascals**2) / np.mean((0.1 * RING) ** 2)) == pytest.approx(0, abs=1)


@pytest.mark.slow
@pytest.mark.parametrize("force", [np.hanning(400), np.hanning(12)], ids=["of another blow", "short"])
def test_a_force_makes_no_fit_worse(folder, tmp_path, capsys, force):
    soundfile.write(tmp_path / "hammer.wav", np.concatenate([np.zeros(900), 0.5 * force, np.zeros(900)]), RATE)
    apart = []
    for options in ((), ("--force", str(tmp_path / "hammer.wav"))):
        assert abs(struck(folder, "ring.wav", tmp_path, *options)) < 1
        capsys.readouterr()
        assert main(["compare", str(folder / "ring.wav"), str(tmp_path / "x.wav"), "--json"]) == 0
        apart.append(json.loads(capsys.readouterr().out)["log_spectral_distance_db"])
    assert apart[1] < apart[0] + 0.2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "says"),
    [
        # One of the noise about 20 Hz may be named before it, as rounding has it.
        ("hum", r"left out, as they do not decay with the strike: (\d+, )?50 Hz"),
        ("short", "its T60 is taken to be"),
        ("noisy", "noise at -3"),
    ],
)
def test_shortcomings_of_a_recording_are_told(folder, tmp_path, capsys, name, says):
    assert main(["fit", str(folder / f"{name}.wav"), str(tmp_path), "--name", "bar", "--no-report"]) == 0
    assert re.search(says, capsys.readouterr().err)


@pytest.mark.slow
def test_a_sound_is_no_distance_from_itself(folder, tmp_path, capsys):
    ring, page, picture = str(folder / "ring.wav"), tmp_path / "a.html", tmp_path / "a.png"
    assert main(["compare", ring, ring, "--page", str(page), "--plot", str(picture)]) == 0
    assert "log-spectral distance     0.00 dB" in capsys.readouterr().out
    assert page.read_text().count("<audio") == 2 and picture.stat().st_size > 10_000


@pytest.mark.slow
def test_a_comparison_ends_in_a_sentence_that_a_player_understands(tmp_path, capsys):
    """A ring of two modes beside itself, beside one that is 6 dB brighter, and one that rings twice as long."""
    time = np.arange(48_000) / 48_000
    for name, level, seconds in (("a", 1.0, 0.1), ("bright", 2.0, 0.1), ("long", 1.0, 0.2)):
        ring = np.sin(2 * np.pi * 500 * time) + 0.3 * level * np.sin(2 * np.pi * 4_000 * time)
        soundfile.write(tmp_path / f"{name}.wav", 0.3 * ring * np.exp(-time / seconds), 48_000)
    for name, said in (
        ("a", "B is as bright as A and rings as long."),
        ("bright", r"B is [67] dB brighter."),
        ("long", r"B rings (1\.9|2\.0|2\.1) times as long."),
    ):
        assert main(["compare", str(tmp_path / "a.wav"), str(tmp_path / f"{name}.wav")]) == 0
        assert re.fullmatch(said, capsys.readouterr().out.splitlines()[-1]), name


@pytest.mark.slow
def test_a_sound_is_compared_with_recordings_of_its_kind(folder, tmp_path, capsys):
    ring, kind = folder / "ring.wav", tmp_path / "kind"
    kind.mkdir()
    samples, rate = soundfile.read(ring)
    for n in (1, 2):
        soundfile.write(kind / f"{n}.wav", np.r_[np.zeros(100 * n), samples / n], rate, "FLOAT")
    soundfile.write(tmp_path / "b.wav", samples * np.exp(-20.0 * np.arange(len(samples)) / rate), rate, "FLOAT")
    (kind / "copy.wav").write_bytes(ring.read_bytes())
    words = ["compare", str(ring), str(tmp_path / "b.wav"), "--kind", str(kind)]
    page = tmp_path / "page.html"
    assert main([*words, "--json", "--page", str(page)]) == 0
    told = json.loads(capsys.readouterr().out)["kind"]
    assert told["recordings"] == 3 and told["third_octaves_real_db"] < 0.1 < told["third_octaves_db"]
    assert told["decays_real_octaves"] < 0.05 < told["decays_octaves"]
    assert main(words) == 0
    assert "beside 3 recordings" in capsys.readouterr().out
    assert "beside 3 recordings" in page.read_text()
    (kind / "2.wav").unlink()
    (kind / "copy.wav").unlink()
    assert main(["compare", str(kind / "1.wav"), str(ring), "--kind", str(kind)]) == 1
    assert "expected a folder with other recordings of the kind of 1.wav" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("ring.wav silence.wav", "silence.wav: silent"),
        ("ring.wav notes", "notes: "),
        ("ring.wav ring.wav --plot x.bmp", "x.bmp: expected a name that ends in .png"),
        ("ring.wav ring.wav --page no/x.html", "no/x.html: there is no folder no"),
    ],
)
def test_error_of_a_comparison_is_one_line(folder, capsys, monkeypatch, words, says):
    monkeypatch.chdir(folder)
    assert main(["compare", *words.split()]) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and says in error
