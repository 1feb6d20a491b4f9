"""carom.render: scores in, sounds out."""

import multiprocessing
from pathlib import Path

import numpy as np
import pytest
import soundfile

import carom
from carom.presets.library import BUILT_IN
from carom.server.osc.score import read

SCORE = """
0    /object/new a xylophone-bar   # a comment
0.01 /object/a/impact 1
0.1  /object/a/bounce 0.02 0.3 striker ping-pong
"""
LINES = [
    (0, "/object/new", "a", "xylophone-bar"),
    (np.float64(0.1), "/object/a/bounce", np.float64(0.02), np.float64(0.3), "striker", "ping-pong"),
    (0.01, "/object/a/impact", np.int64(1)),
]


@pytest.mark.slow
def test_a_score_renders_to_the_bits_of_the_command(carom, tmp_path):
    path = tmp_path / "s.txt"
    path.write_text(SCORE)
    carom("render", "s.txt", "s.wav", "--rate", "44100", check=True)
    expected = soundfile.read(tmp_path / "s.wav", dtype="float32")[0]
    from carom import render

    for score in (path, SCORE, read(path)):
        sound = render(score, np.int64(44_100))
        assert sound.rate == 44_100 and sound.samples.dtype == np.float32
        np.testing.assert_array_equal(sound.samples, expected)


def test_lines_may_stand_in_any_order_and_hold_numpys_numbers():
    sound = carom.render(iter(LINES))
    np.testing.assert_array_equal(sound.samples, carom.render(SCORE).samples)
    assert sound.report.contacts > 3 and str(sound.report) == "nothing to report"
    np.testing.assert_array_equal(carom.render(LINES[:1] + LINES[2:], seconds=0.05).samples, sound.samples[:2400])


def test_folders_of_presets_come_first(tmp_path):
    (tmp_path / "objects").mkdir()
    text = (BUILT_IN / "objects" / "xylophone-bar.toml").read_text()
    (tmp_path / "objects" / "mine.toml").write_text(text)
    score = SCORE.replace("xylophone-bar", "mine")
    for presets in (tmp_path, str(tmp_path), [tmp_path], carom.Presets([tmp_path])):
        np.testing.assert_array_equal(
            carom.render(score, seconds=0.02, presets=presets).samples, carom.render(SCORE, seconds=0.02).samples
        )
    with pytest.raises(carom.ScoreError, match="no object 'mine'"):
        carom.render(score)


@pytest.mark.parametrize(
    ("score", "options", "error", "text"),
    [
        ("strike.txt", {}, carom.ScoreError, "a file's name is given as pathlib.Path"),
        (Path("none.txt"), {}, FileNotFoundError, "none.txt"),
        ("", {}, carom.RenderError, "the score is empty"),
        ("x /panic", {}, carom.ScoreError, "score:1: time 'x': expected seconds from 0"),
        ("0 /panic\n0 /object/a/impact 1", {}, carom.ScoreError, "score:2: /object/a/impact: a: no such object"),
        ([(0, "/panic"), (1.0,)], {}, carom.ScoreError, r"line 2: \(1.0,\): expected a time from 0"),
        ([(float("nan"), "/panic")], {}, carom.ScoreError, "line 1: .*expected a time from 0"),
        ([(0, "/object/new", "a")], {}, carom.ScoreError, "line 1: /object/new: preset is missing"),
        (SCORE, {"rate": 1}, carom.RenderError, "rate = 1: expected 8000 to 192000 Hz"),
        (SCORE, {"seconds": 0}, carom.RenderError, "seconds = 0: expected at least a frame"),
        (SCORE, {"presets": "none"}, carom.PresetError, "none: expected a folder"),
    ],
)
def test_errors_of_a_render_name_the_culprit(score, options, error, text):
    with pytest.raises(error, match=text):
        carom.render(score, **options)


@pytest.mark.slow
def test_processes_render_at_once_to_equal_bits():
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        sounds = pool.map(carom.render, [SCORE, SCORE])
    for sound in sounds:
        np.testing.assert_array_equal(sound.samples, carom.render(SCORE).samples)


def test_the_report_tells_when_the_limiter_worked_and_by_how_much():
    score = "0 /object/new a xylophone-bar\n0.1 /object/a/impact 1\n0.5 /object/a/impact 1 gain 40\n"
    quiet, report = carom.render(score, seconds=0.4).report, carom.render(score, seconds=3.0).report
    assert quiet.limited == () and quiet.limited_db == 0.0
    ((start, end),) = report.limited
    assert start == pytest.approx(0.5, abs=0.022) and start < end < 3.0 and report.limited_db > 3.0
    assert "too loud: " in str(report)


def test_the_report_tells_of_a_sound_that_ends_before_it_is_over(monkeypatch):
    monkeypatch.setattr("carom.server.render.LONGEST_TAIL", 1.0)
    score = "0 /object/new a xylophone-bar\n0 /object/a/press 1 striker hand id palm\n"
    sound = carom.render(score, 8_000)
    assert sound.duration == 1.0 and "palm" in str(sound.report)
    assert str(carom.render(score + "0.1 /gesture/palm/stop", 8_000).report) == "nothing to report"


def test_without_the_limiter_it_is_the_sum_itself():
    score = "0 /object/new a xylophone-bar gain {}\n0.01 /object/a/impact 1\n"
    loud = carom.render(score.format(40), seconds=0.2, limiter=False)
    plain = carom.render(score.format(0), seconds=0.2)
    assert np.abs(loud.samples).max() > 1.0 and loud.report.limited == plain.report.limited == ()
    # Modes come to rest below -120 dB, so what is louder has more of their ends.
    np.testing.assert_allclose(loud.samples, plain.samples * 100, rtol=1e-5, atol=1e-3)


def test_the_report_names_the_objects_that_were_limited():
    score = "0 /object/new a xylophone-bar gain 10\n0 /object/new b marimba-bar gain -20\n"
    report = carom.render(score + "0.1 /object/*/impact 1 gain 30\n", seconds=0.5).report
    assert report.limited_objects["a"] > 0.8 > 0.2 > report.limited_objects["b"] > 0.0
    assert sum(report.limited_objects.values()) == pytest.approx(1.0)
    assert "too loud: a (" in str(report)


def test_steering_a_gesture_that_has_ended_is_a_warning():
    score = "0 /object/new a xylophone-bar\n0 /object/a/bounce 0.01 striker steel id ball\n2 /gesture/ball/stop"
    (warning,) = carom.render(score).report.warnings
    assert "no such gesture is running" in warning
