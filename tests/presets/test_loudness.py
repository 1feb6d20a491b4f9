"""Each preset is as loud as others at its defaults, and so are the gestures that suit it."""

import json
import math
from functools import cache
from itertools import islice

import numpy as np
import pyloudnorm
import pytest

import carom
from carom.dsp.engine.output.limiter import _AIM
from carom.dsp.runtime.loudness import LEAST, LOUDNESS, PEAK, decibels, heard, true_peak
from tests.bench.loudness import GESTURES, gesture, played
from tests.bench.loudness import MEASURED as _MEASURED

pytestmark = pytest.mark.slow
RATE = 48_000
PRESETS = carom.Presets()
SUITED = [(name, kind) for name in PRESETS.names("objects") for kind in PRESETS.object(name).gestures]
DEAR = ("china-cymbal", "crash-cymbal", "opera-gong", "splash-cymbal", "tam-tam", "thunder-sheet")
"""Coupled plates whose slides take seconds of a processor; three others' are played."""


MEASURED = json.loads(_MEASURED.read_text(encoding="utf-8"))
"""What `make levels` measured of each object at its defaults."""


@cache
def strike(name):
    """Return the sound of a strike at its defaults, without a limiter."""
    return played(name, "impact")


@pytest.mark.parametrize("name", PRESETS.names("objects"))
def test_a_strike_is_as_loud_as_others_or_at_its_highest_peak(name):
    struck = heard(strike(name), RATE)
    assert struck.loudness <= LOUDNESS + 2.0 and struck.peak <= PEAK + 0.2
    assert struck.loudness >= LOUDNESS - 2.0 or struck.peak >= PEAK - 0.5
    assert struck.loudness >= LEAST - 1.0


def apart(kind):
    """Return how far (LU) a gesture may be from the strike; bodies that hop are louder or softer by their last bits."""
    return GESTURES + (1.0 if kind in ("roll", "slide") else 0.0)


@pytest.mark.parametrize(
    ("name", "kind"), [(name, kind) for name, kind in SUITED if kind != "slide" or name not in DEAR]
)
def test_a_gesture_is_nearly_as_loud_as_the_strike(name, kind):
    """Slides are measured for ten seconds: most are as loud after three, and some bowls go on to swell."""
    struck, lengths = heard(strike(name), RATE).loudness, (3.0, math.inf)
    assert any(abs(gesture(name, kind, at_most=each).loudness - struck) <= apart(kind) for each in lengths)


def test_gestures_were_measured_nearly_as_loud_as_the_strike():
    """All of them, and what takes seconds of a processor, too."""
    measured = {(name, kind): loud for name, row in MEASURED.items() for kind, loud in row["gestures"].items()}
    assert sorted(measured) == sorted(SUITED)
    assert [each for each, loud in measured.items() if abs(loud) > apart(each[1])] == []


def together(name, times):
    """Return by how much (dB) a limiter has to turn down strikes at their defaults, each of a copy, at some times
    (s)."""
    sound = strike(name)[: round(0.4 * RATE)]
    added = np.zeros((len(sound) + round(0.06 * RATE), 2))
    for at in times:
        added[round(at * RATE) :][: len(sound)] += sound
    return decibels(true_peak(added[: len(sound)]) / _AIM)


@pytest.mark.parametrize("name", PRESETS.names("objects"))
def test_one_strike_is_not_limited_and_eight_within_50_ms_are_by_6_db_at_most(name):
    """The median of three times eight at random: how their waves add up is a matter of chance. Two within it do."""
    assert together(name, [0.01]) <= 0.0
    draws = 0.05 * np.random.default_rng(0).uniform(size=(3, 8))
    assert len([*islice((times for times in draws if together(name, times) <= 6.0), 2)]) == 2


def test_the_limiter_turns_copies_down_by_what_their_sum_is_over():
    times = 0.05 * np.random.default_rng(0).uniform(size=8)
    with carom.Scene(RATE) as scene:
        for n, at in enumerate(np.sort(times)):
            scene.new(f"o{n}", "church-bell").impact(PRESETS.object("church-bell").velocity, at=float(at))
        limited = scene.render(0.4).report.limited_db
    assert limited == pytest.approx(together("church-bell", times), abs=0.2) and limited > 5.0


def test_every_gesture_suits_some_objects_and_none_suits_all():
    for kind in ("bounce", "roll", "slide", "spin"):
        assert 5 < sum(kind in PRESETS.object(name).gestures for name in PRESETS.names("objects")) < 32


def test_loudness_is_that_of_the_recommendation():
    """A sine of 997 Hz at full scale on one side: -3.01 LUFS; shorter than a block by its share of it."""
    sine = np.sin(2 * np.pi * 997 / RATE * np.arange(2 * RATE))[:, None] * [1.0, 0.0]
    assert heard(sine, RATE).loudness == pytest.approx(-3.01, abs=0.1)
    assert heard(0.1 * sine, RATE).loudness == pytest.approx(-23.01, abs=0.1)
    assert heard(sine[: RATE // 10], RATE).loudness == pytest.approx(-3.01 - 10 * math.log10(4), abs=0.1)
    assert heard(np.zeros((100, 2)), RATE).loudness == -math.inf


@pytest.mark.parametrize("rate", [44_100, RATE, 96_000])
def test_loudness_is_that_of_another_meter(rate):
    """pyloudnorm's filters differ by some hundredths of a dB from the standard's."""
    noise = np.random.default_rng(1).standard_normal((rate, 2)) * np.exp(-np.arange(rate) / 9e3)[:, None]
    meter = pyloudnorm.Meter(rate, block_size=0.4)
    meter.integrated_loudness(np.concatenate([noise, np.zeros((round(0.4 * rate), 2))]))
    assert heard(noise, rate).loudness == pytest.approx(max(meter.blockwise_loudness), abs=0.06)


def test_a_true_peak_is_found_between_samples():
    """A sine at a quarter of the rate whose samples all lie at 0.707 of its height."""
    sine = np.sin(np.pi / 2 * np.arange(4000) + np.pi / 4)[:, None]
    assert np.abs(sine).max() == pytest.approx(math.sqrt(0.5))
    assert true_peak(sine[1000:3000] * np.hanning(2000)[:, None]) == pytest.approx(1.0, abs=0.01)
