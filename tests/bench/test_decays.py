"""The measure of decays, on partials whose T60 is known."""

import numpy as np
import pytest

from .decays import Measured, among, as_near, beside, decay, decays, share, summary
from .soundfont import Recording

RATE = 32_000


def ringing(seconds: float, *partials: tuple[float, float, float]) -> np.ndarray:
    """Return partials of some Hz, T60 (s) and amplitude."""
    time = np.arange(round(seconds * RATE)) / RATE
    return sum(a * np.sin(2 * np.pi * f * time) * 10 ** (-3 * time / t60) for f, t60, a in partials)


def test_each_partial_has_its_own_decay():
    known = [(220.0, 1.5, 1.0), (700.0, 0.4, 0.5), (3000.0, 0.15, 0.3)]
    found = decays(Recording("", ringing(0.8, *known), RATE))
    assert [at for at, _ in found] == pytest.approx([220, 700, 3000], rel=0.01)
    assert [t60 for _, t60 in found] == pytest.approx([1.5, 0.4, 0.15], rel=0.1)


def test_noise_is_a_floor_and_no_decay():
    noise = np.random.default_rng(1).standard_normal(2 * RATE)
    assert decay(ringing(2.0, (1000.0, 0.6, 1.0)) + 0.02 * noise, RATE, 1000.0) == pytest.approx(0.6, rel=0.1)


def test_beats_leave_the_decay():
    pair = ringing(2.0, (1000.0, 1.2, 1.0), (1004.0, 1.2, 0.5))
    assert decay(pair, RATE, 1002.0) == pytest.approx(1.2, rel=0.15)


def test_what_hardly_falls_is_left_out():
    assert decay(ringing(0.3, (1000.0, 10.0, 1.0)), RATE, 1000.0) is None


def test_partials_meet_the_nearest_and_count_within_a_quarter():
    rows = beside([(100.0, 1.0), (400.0, 1.0), (2000.0, 1.0)], [(110.0, 1.2), (405.0, 1.3)])
    assert rows == [(100.0, 1.0, 1.2), (400.0, 1.0, 1.3)]
    assert share(rows) == 50


def test_recordings_of_one_kind_are_compared_at_one_pitch():
    low = Measured("", "", 0.0, [(100.0, 1.0), (400.0, 1.0)], [])
    high = Measured("", "", 12.0, [(200.0, 1.1), (3000.0, 1.0)], [])
    assert among([low, high]) == [(100.0, 1.0, 1.1), (200.0, 1.1, 1.0)]
    assert among([low]) == []


def agreeing(count: int, of: int) -> list[tuple[float, float, float]]:
    """Return partials of which some agree."""
    return [(100.0, 1.0, 1.0)] * count + [(100.0, 1.0, 2.0)] * (of - count)


def test_a_family_is_as_near_as_its_recordings_are_but_for_chance():
    assert as_near(agreeing(12, 30), agreeing(20, 60))
    assert as_near(agreeing(12, 30), agreeing(28, 60))  # 40 % beside 47 %: by chance
    assert not as_near(agreeing(6, 30), agreeing(28, 60))
    assert not as_near(agreeing(400, 1000), agreeing(940, 2000))


def test_families_weigh_by_their_partials():
    said = summary([(30, 40.0, 30.0, True), (10, 20.0, 50.0, False)])
    assert said.endswith("1 of 2 families; ours 35 %, theirs 35 % (30 to 50 % by family)")
