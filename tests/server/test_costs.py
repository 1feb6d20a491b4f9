"""A sound that takes far longer than it lasts is told of, with what it is mostly spent on."""

import pytest

import carom
from carom.server import costs

SCORE = """0 /object/new gong gong
0 /object/new bell church-bell
0 /object/bell/impact 1 0.3
0.02 /object/gong/press 2 striker fingertip
"""


class Clock:
    """A processor's time, of which each look at it takes so much (s)."""

    def __init__(self, step):
        self.step, self.now = step, 0.0

    def __call__(self):
        self.now += self.step
        return self.now


@pytest.fixture
def takes(monkeypatch):
    """Have each piece of a sound take so many seconds of a processor."""
    return lambda seconds: monkeypatch.setattr(costs, "thread_time", Clock(seconds))


def test_a_render_that_takes_long_says_so_and_names_what_is_touched_with_most_modes(takes):
    takes(1.0)
    said = carom.render(SCORE, seconds=0.1).report.warnings
    assert len(said) == 1 and " s of a processor, mostly for contacts of gong: /budget" in said[0]
    assert said[0].startswith("0.1 s of sound took")


def test_a_render_with_a_budget_is_not_advised_to_have_one(takes):
    takes(1.0)
    (said,) = carom.render(f"0 /budget 16 8192\n{SCORE}", seconds=0.1).report.warnings
    assert said.endswith("mostly for contacts of gong: /quality 2 or 3 costs less")


def test_a_scene_that_takes_long_says_so_each_time(takes):
    scene = carom.Scene()
    bell = scene.new("bell", "church-bell")
    bell.impact(1.0)
    takes(1e-6)
    assert scene.render(0.1).report.warnings == ()
    takes(1.0)
    found = [scene.render(0.1).report.warnings for _ in range(2)]
    assert [len(said) for said in found] == [1, 1]
    assert found[0][0].startswith("0.1 s of sound took")


def test_a_sound_that_takes_little_longer_than_it_lasts_is_not_told_of(takes):
    takes(0.02)
    assert carom.render(SCORE, seconds=0.1).report.warnings == ()
