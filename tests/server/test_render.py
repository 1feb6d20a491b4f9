"""Scores become sound files: the same at any block size, whole or not at all."""

import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyloudnorm
import pytest
import soundfile

from carom.dsp.engine.memory.state import EVENTS
from carom.dsp.runtime.engine import Engine
from carom.dsp.schema import GESTURES
from carom.presets.library import BUILT_IN, Presets
from carom.server.osc.score import ScoreError, read
from carom.server.render import Options, RenderError, blocks, render
from tests.scores import ACCURACIES, any_score, play
from tests.support import render_lines

DEMO = BUILT_IN / "scores" / "demo.txt"
STRIKE = "0 /object/new a wood-block\n0.01 /object/a/impact 1\n"


@pytest.fixture(scope="module")
def demo() -> np.ndarray:
    return render_lines(read(DEMO))


@pytest.mark.slow
def test_the_demo_is_loud_enough_clean_and_ends(demo):
    assert 0.2 < np.abs(demo).max() < 1.0
    assert 15 < len(demo) / 48_000 < 25 and np.abs(demo[-4800:]).max() < 1e-4


@pytest.mark.slow
def test_something_is_heard_in_the_demo_as_long_as_it_goes_on(demo):
    """Momentary loudness (ITU-R BS.1770, 400 ms), until a hand is laid on the bell at the end."""
    meter, step = pyloudnorm.Meter(48_000, block_size=0.4), 4800
    lines = read(DEMO)
    end = max(line.time for line in lines)
    found = [
        meter.integrated_loudness(demo[start : start + 4 * step].astype(float))
        for start in range(0, round((end - 0.4) * 48_000), step)
    ]
    assert min(found) > -41
    assert {"bounce", "roll"} <= {line.message.address.split("/")[-1] for line in lines}


@pytest.mark.parametrize("rate", [22_050, 44_100, 96_000, 192_000])
def test_a_strike_is_the_same_at_any_rate(render_text, rate):
    """The spectrum below 8 kHz of what rings does not depend on the sampling rate.

    The striker is silent: at 22.05 kHz the filter of its click is another (dsp/resonator/click.py).
    """

    def spectrum(rate):
        # It is loud, as modes are put to rest by how loud they are.
        wood = "mass 0.015 stiffness 4e8 dissipation 0.45 exponent 1.5"
        out = render_text(
            f"0 /object/new a church-bell gain 40\n0.01 /object/a/impact 1 {wood}\n", rate=rate, seconds=1.0
        )
        return np.abs(np.fft.rfft(out[:, 0].astype(float)))[:8000] / rate

    reference = spectrum(48_000)
    assert np.linalg.norm(spectrum(rate) - reference) < 1e-3 * np.linalg.norm(reference)


@pytest.mark.parametrize(
    ("name", "format", "subtype"),
    [
        ("x.wav", None, "FLOAT"),
        ("x.wav", "16", "PCM_16"),
        ("x.wav", "24", "PCM_24"),
        ("x.flac", None, "PCM_24"),
        ("x.FLAC", "16", "PCM_16"),
    ],
)
def test_formats(tmp_path, name, format, subtype):
    score = tmp_path / "s.txt"
    score.write_text(STRIKE)
    out = tmp_path / name
    render(read(score), out, Presets(), Options(format=format, seconds=0.5))
    info = soundfile.info(out)
    assert (info.subtype, info.frames, info.channels, info.samplerate) == (subtype, 24_000, 2, 48_000)
    assert out.stat().st_mode == score.stat().st_mode
    expected = render_lines(read(score), seconds=0.5)
    step = {"FLOAT": 0, "PCM_24": 2**-23, "PCM_16": 2**-15}[subtype]
    assert np.abs(soundfile.read(out)[0] - expected).max() <= step


@pytest.mark.parametrize(
    ("options", "culprit"),
    [
        ({"rate": 100}, "rate = 100"),
        ({"rate": 400_000}, "rate = 400000"),
        ({"block": 0}, "block = 0"),
        ({"block": 2_000_000}, "block = 2000000"),
        ({"seconds": 0.0}, "seconds = 0"),
        ({"seconds": 1e-5}, "seconds = 1e-05"),
        ({"seconds": 2_678_401.0}, r"seconds = 2678401.0: expected at least a frame and at most 2678400"),
        ({"seconds": float("nan")}, "seconds = nan"),
        ({"format": "32"}, "format = 32"),
    ],
)
def test_bad_options_are_named(options, culprit):
    with pytest.raises(RenderError, match=culprit):
        Options(**options)


def rendering(tmp_path: Path, text: str, out: str = "x.wav", **options) -> None:
    score = tmp_path / "score.txt"
    score.write_text(text)
    render(read(score), tmp_path / out, Presets(), Options(**options))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("0 /object/new a wood-bloc\n", r"score.txt:1: /object/new: no object 'wood-bloc'"),
        (STRIKE + "3 /object/b/impact 1\n", r"score.txt:3: /object/b/impact: b: no such object"),
        (STRIKE + "x /object/a/impact 1\n", r"score.txt:3: time 'x'"),
        (STRIKE + "1 /contact closed\n", r"score.txt:3: /contact: the sampled methods are in `carom chart`"),
        (STRIKE + "1 /status\n", r"score.txt:3: /status: .*server-only message"),
    ],
)
def test_a_broken_score_names_its_line_and_leaves_no_file(tmp_path, text, reason):
    (tmp_path / "x.wav").write_bytes(b"an earlier render")
    with pytest.raises(ScoreError, match=reason):
        rendering(tmp_path, text)
    assert (tmp_path / "x.wav").read_bytes() == b"an earlier render"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["score.txt", "x.wav"]


def test_other_failures_are_told(tmp_path):
    with pytest.raises(RenderError, match="the score is empty"):
        rendering(tmp_path, "# nothing\n")
    with pytest.raises(RenderError, match=r"x.mp3: expected a name that ends in .wav or .flac"):
        rendering(tmp_path, STRIKE, out="x.mp3")
    with pytest.raises(RenderError, match="format = float: FLAC holds 16 or 24"):
        rendering(tmp_path, STRIKE, out="x.flac", format="float")
    with pytest.raises(RenderError, match=r"x.wav: there is no folder .*no/such/folder"):
        rendering(tmp_path, STRIKE, out="no/such/folder/x.wav")


def test_lines_may_stand_in_any_order_of_time(render_text):
    lines = ["0 /object/new a wood-block", "0.1 /object/a/impact 1", "0.1 /object/a/gain -6", "0.2 /object/a/impact 2"]
    expected = render_text("\n".join(lines))
    for order in ((3, 0, 1, 2), (1, 2, 3, 0)):
        np.testing.assert_array_equal(render_text("\n".join(lines[n] for n in order)), expected)


ENDLESS = {
    "roll": "0 /object/new a wood-block\n0.1 /object/a/roll 0.3 striker steel\n",
    "press": "0 /object/new a wood-block\n0.1 /object/a/press 3 id hand\n",
}
SETTLING = {
    "bounce": "0 /object/new a xylophone-bar gain -40\n0.1 /object/a/bounce 0.1 striker steel\n",
    "spin": "0 /object/new a wood-block gain -40\n0.1 /object/a/spin 1.6 striker coin\n",
    "roll with friction": "0 /object/new a wood-block\n0.1 /object/a/roll 0.3 striker steel friction 0.01\n",
    "ringing": "0 /object/new a church-bell decay 0.3\n0.1 /object/a/impact 1\n",
}


def rendered(tmp_path: Path, text: str, **options) -> tuple[int, list[str]]:
    """Return the length of a render in frames, and its warnings."""
    (tmp_path / "s.txt").write_text(text)
    chosen = Options(**options)
    warnings: list[str] = []
    parts = blocks(read(tmp_path / "s.txt"), Engine(chosen.rate), Presets(), chosen, warn=warnings.append)
    return sum(map(len, parts)), warnings


@pytest.mark.slow
@pytest.mark.parametrize("kind", ENDLESS)
def test_a_render_of_what_never_ends_stops_some_time_after_the_last_event_and_says_so(tmp_path, kind, monkeypatch):
    monkeypatch.setattr("carom.server.render.LONGEST_TAIL", 0.5)
    name = "a" if kind == "roll" else "hand"
    going = f"the sound ends 0.5 s after the last event, though these gestures go on: {name}; stop them in the score"
    for block in (64, 1_000, 4_096):
        frames, warnings = rendered(tmp_path, ENDLESS[kind], block=block)
        assert (frames, warnings) == (0.6 * 48_000, [f"{going}, or give a length in seconds"])
    assert rendered(tmp_path, ENDLESS[kind], seconds=0.7) == (0.7 * 48_000, [])


@pytest.mark.slow
@pytest.mark.parametrize("kind", SETTLING)
def test_a_render_goes_on_while_something_comes_to_rest(tmp_path, kind, monkeypatch):
    whole, warnings = rendered(tmp_path, SETTLING[kind])
    assert whole > 1.5 * 48_000 and warnings == []
    monkeypatch.setattr("carom.server.render.LONGEST_TAIL", 0.5)
    assert rendered(tmp_path, SETTLING[kind], block=777) == (whole, [])
    monkeypatch.setattr("carom.server.render.LONGEST_REST", 1.0)
    frames, (warning,) = rendered(tmp_path, SETTLING[kind])
    assert frames == 52_800 and "the sound ends 1 s after the last event, though " in warning


@pytest.mark.slow
def test_a_render_ends_once_only_the_endless_is_left(tmp_path, monkeypatch):
    """The bounce goes on beyond the limit, and is waited for; the press is not."""
    monkeypatch.setattr("carom.server.render.LONGEST_TAIL", 0.5)
    both = SETTLING["bounce"] + "0 /object/new b wood-block\n0.1 /object/b/press 3\n"
    ends = [rendered(tmp_path, both, block=block) for block in (37, 1_000, 65_536)]
    assert ends[0] == ends[1] == ends[2] and len(ends[0][1]) == 1 and "b-2" in ends[0][1][0]
    bounced, _ = rendered(tmp_path, SETTLING["bounce"])
    assert 48_000 < ends[0][0] <= bounced


def test_a_render_without_a_sound_ends_with_its_last_event(render_text):
    assert len(render_text("0 /object/new a wood-block\n0.1 /object/a/gain -6\n")) == 4_800 + 64


@pytest.mark.slow
@pytest.mark.parametrize(("ends", "length"), [((1.25,), 1.25), ((0.5, 0.75), 0.75), ((0.0,), None)])
def test_a_score_that_says_its_end_is_as_long(render_text, ends, length):
    text = "0 /object/new b church-bell\n0 /object/b/impact 1\n" + "".join(f"{end} /end\n" for end in ends)
    seconds = len(render_text(text)) / 48_000
    assert seconds == pytest.approx(length) if length else seconds > 5.0


@pytest.mark.slow
def test_more_events_than_the_queue_holds_are_played_in_turn(render_text):
    """A striker waits behind twice as many changes of a gain as the queue holds."""
    lines = ["0 /object/new a wood-block"]
    lines += [f"{0.0001 * i:.4f} /object/a/gain {-i / EVENTS:.4f}" for i in range(2 * EVENTS)]
    end = round(0.0002 * EVENTS + 0.1, 2)
    sound = render_text("\n".join([*lines, f"{end} /object/a/impact 1"]))
    heard = np.flatnonzero(np.abs(sound).max(axis=1))
    assert heard[0] == pytest.approx(48_000 * end, abs=2)
    assert np.abs(sound).max() == pytest.approx(
        np.abs(render_text(f"{lines[0]} gain -2\n0 /object/a/impact 1")).max(), rel=1e-3
    )


@pytest.mark.slow
def test_more_events_at_once_than_can_be_queued_are_refused(tmp_path):
    lines = ["0 /object/new a wood-block"] + ["0.1 /object/a/impact 0.1"] * 20_000
    with pytest.raises(ScoreError, match="too many events at once"):
        rendering(tmp_path, "\n".join(lines))


SEEDS = (6, 8, 12, 15, 17, 19)
"""Of random scores that have all gestures and accuracies between them."""


def test_random_scores_have_all_gestures_and_accuracies():
    lines = [line.message for seed in SEEDS for line in any_score(seed, seconds=1.0).lines]
    assert set(GESTURES) <= {message.address.rpartition("/")[2] for message in lines}
    assert {message.args[0] for message in lines if message.address == "/accuracy"} == set(ACCURACIES)


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_block_size_changes_no_bit_of_random_scores(seed):
    """Gestures and what steers them, strikers, surfaces, other objects, panics, qualities, forms of the bank, channels,
    the limiter: all of it at once."""
    score = any_score(seed, seconds=1.0)
    score = replace(score, rate=min(score.rate, 48_000))
    reference = play(replace(score, block=4_096))
    assert np.isfinite(reference).all() and reference.any()
    np.testing.assert_array_equal(play(score), reference)


@pytest.mark.slow
def test_equal_sounds_are_equal_files(tmp_path):
    """The files are equal to the byte, at any block size and at any time of day."""
    score = tmp_path / "s.txt"
    score.write_text(STRIKE)

    def made(block: int) -> list[bytes]:
        files = [tmp_path / name for name in ("a.wav", "a.flac")]
        for file in files:
            render(read(score), file, Presets(), Options(block=block))
        return [file.read_bytes() for file in files]

    first = made(64)
    time.sleep(1.1)  # a second is the finest time that a header could hold
    assert made(1000) == first


def test_two_renders_of_one_name_do_not_meet(tmp_path):
    score = tmp_path / "s.txt"
    score.write_text(STRIKE)
    lines = read(score)
    with ThreadPoolExecutor(2) as pool:
        list(pool.map(lambda _: render(lines, tmp_path / "a.wav", Presets(), Options(seconds=5.0)), range(4)))
    assert soundfile.info(tmp_path / "a.wav").frames == 240_000
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.wav", "s.txt"]


def test_a_wav_too_long_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("carom.server.files.whole.WAV_BYTES", 1_000_000)
    with pytest.raises(RenderError, match=r"x\.wav: longer than the 4 GiB"):
        rendering(tmp_path, STRIKE, seconds=10.0)
    assert not list(tmp_path.glob("x.wav*"))


def test_the_limiters_span_is_told_to_1024_frames_whatever_the_block(tmp_path):
    (tmp_path / "s.txt").write_text("0 /object/new a xylophone-bar\n0.5 /object/a/impact 1 gain 40\n")
    score, told = read(tmp_path / "s.txt"), []
    for block in (64, 16_384):
        done = render(score, tmp_path / "s.wav", Presets(), Options(block=block, seconds=3.0))
        told.append(done.limiting.spans)
    (((first, last),), ((start, end),)) = told
    assert first == pytest.approx(0.5, abs=0.002)
    assert 0.0 <= first - start < 1_024 / 48_000 and 0.0 <= end - last < 1_024 / 48_000


def test_a_limiter_that_works_to_the_end_is_told_to_it(tmp_path):
    (tmp_path / "s.txt").write_text("0 /object/new a church-bell gain 30\n0 /object/a/impact 3\n")
    done = render(read(tmp_path / "s.txt"), tmp_path / "s.wav", Presets(), Options(seconds=0.1))
    assert done.limiting.spans[-1][1] == 0.1
