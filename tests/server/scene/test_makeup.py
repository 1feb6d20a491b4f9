"""Make-up: what is played is heard whatever strikes what, and what is not played stays as physics has it."""

import itertools
import json

import numpy as np
import pytest

import carom
from carom.dsp.runtime.loudness import Heard, heard
from carom.dsp.schema import GESTURES
from carom.dsp.schema_values import OWN
from carom.presets import BUILT_IN
from carom.server.scene.makeup import STORED, Measure, aimed_at, gain_of, measured_at, on_grid
from carom.server.scene.notes import speed_of

RATE = 48_000
NAMES = ("aluminium-pipe", "church-bell", "glass-ball", "marimba-bar", "tuning-fork", "wrench")
STRIKERS = ("rice", "fingertip", "hand", "hammer")


def played(name: str, kind: str = "impact", *args: float, seconds: float = 1.0, **keys: float | str) -> Heard:
    """Play a gesture with make-up, without a limiter."""
    with carom.Scene(RATE, limiter=False) as scene:
        getattr(scene.new("a", name), kind)(*args, **({"play": 1} | keys))
        return heard(scene.render(seconds).samples, RATE)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_midi_velocities_have_their_loudness(name: str) -> None:
    strikes = [played(name, "impact", speed_of(velocity)) for velocity in (32, 64, 100, 127)]
    for struck, aim in zip(strikes, (-30.0, -24.0, -18.0, -15.0), strict=True):
        assert abs(struck.loudness - aim) < 6.0 or struck.peak > -0.8  # a click reaches full scale before
        assert struck.peak < 3.5
    assert all(a.loudness < b.loudness for a, b in itertools.pairwise(strikes))


@pytest.mark.parametrize("striker", STRIKERS)
def test_a_bell_is_heard_whatever_strikes_it(striker: str) -> None:
    physical = played("church-bell", "impact", 1.0, striker=striker, play=0)
    made_up = played("church-bell", "impact", 1.0, striker=striker)
    aim = aimed_at("impact", 1.0)
    assert abs(made_up.loudness - aim) < abs(physical.loudness - aim)
    assert -35.0 < made_up.loudness < -12.0


def test_a_gesture_without_play_keeps_its_bits() -> None:
    sounds = []
    for keys in ({}, {"play": 0}):
        with carom.Scene(RATE) as scene:
            scene.new("a", "marimba-bar").impact(1.0, **keys)
            sounds.append(scene.render(0.2).samples)
    assert np.array_equal(*sounds)


def test_calibrated_sound_has_no_make_up() -> None:
    sounds = []
    for play in (False, True):
        with carom.Scene(RATE, calibrated=True) as scene:
            scene.play(play)
            scene.new("a", "marimba-bar").impact(1.0)
            sounds.append(scene.render(0.2))
    assert np.array_equal(sounds[0].samples, sounds[1].samples)
    assert any("/play" in warning for warning in sounds[1].report.warnings)


def test_play_on_holds_until_it_is_off() -> None:
    with carom.Scene(RATE, limiter=False) as scene:
        pipe = scene.new("a", "aluminium-pipe")
        scene.play(True)
        pipe.impact(0.1)
        on = scene.render(4.0)
        scene.play(False)
        pipe.impact(0.1)
        off = scene.render(1.0)
    assert np.abs(on.samples).max() > 2.0 * np.abs(off.samples).max()


@pytest.mark.slow
def test_the_level_does_not_depend_on_what_was_played_before() -> None:
    with carom.Scene(RATE) as scene:
        scene.play(True)
        scene.new("b", "goblet").impact(1.0, mass=0.0101, stiffness=1.0e6)
        scene.new("a", "goblet")
        scene.render(20.0)
        scene.impact("a", 1.0, mass=0.01, stiffness=1.0e6, at=21.0)
        after = scene.render(2.0).samples[-RATE // 2 :]
    with carom.Scene(RATE) as scene:
        scene.play(True)
        scene.new("b", "goblet")
        scene.new("a", "goblet")
        scene.render(20.0)
        scene.impact("a", 1.0, mass=0.01, stiffness=1.0e6, at=21.0)
        alone = scene.render(2.0).samples[-RATE // 2 :]
    assert np.abs(alone).max() > 0.0
    assert np.allclose(after, alone, atol=1e-4)


def test_a_steered_roll_keeps_near_its_aim() -> None:
    """A roll that begins slowly and is made fast is about as loud as one that was fast from the beginning."""
    sounds = {}
    for first in (0.05, 1.0):
        with carom.Scene(RATE, limiter=False) as scene:
            scene.play(True)
            scene.new("a", "wooden-floor").roll(first, id="r", seed=3)
            scene.steer("r", at=0.5, speed=1.0)
            sounds[first] = heard(scene.render(2.5).samples[RATE:], RATE).loudness
    assert sounds[0.05] == pytest.approx(sounds[1.0], abs=2.0)


def test_steering_the_gain_of_a_played_roll_is_relative_to_its_make_up() -> None:
    """A gain of 0 dB changes no bit; one of -12 dB is heard as such, but for the chance of a body that hops, which
    feels the object."""
    sounds = []
    for gain in (None, 0.0, -12.0):
        with carom.Scene(RATE, limiter=False) as scene:
            scene.play(True)
            scene.new("a", "wooden-floor").roll(0.5, id="r", seed=3)
            if gain is not None:
                scene.steer("r", at=0.2, gain=gain)
            sounds.append(scene.render(2.0).samples[RATE // 2 :])
    assert np.array_equal(sounds[0], sounds[1])
    assert heard(sounds[0], RATE).loudness - heard(sounds[2], RATE).loudness == pytest.approx(12.0, abs=2.0)


@pytest.mark.slow
@pytest.mark.parametrize("name, kind", [("goblet", "shatter"), ("tin-lid", "rain"), ("plastic-cup", "shake")])
def test_textures_and_breaking_stay_below_full_scale(name: str, kind: str) -> None:
    found = played(name, kind, seed=5, seconds=2.0)
    assert -35.0 < found.loudness < -12.0
    assert found.peak < 2.0


def test_stored_measurements_are_those_of_the_presets() -> None:
    """The stored measurement of a strike is that of its preset as it is now."""
    rows = json.loads(STORED.read_text(encoding="utf-8"))
    assert set(rows) == {path.stem for path in (BUILT_IN / "objects").glob("*.toml")}
    for name in NAMES:
        with carom.Scene(RATE) as scene:
            makeup = scene._open.scene.makeup
            makeup.stored = {}
            scene.new("a", name).impact(play=1)
            ((digest, measure),) = makeup.measures.items()
        assert rows[name]["impact"] == [digest, list(measure.loudness), list(measure.peak)]


def test_a_gain_follows_a_line_between_measurements() -> None:
    measure = Measure((-60.0, -40.0, -30.0), (-60.0, -40.0, -30.0))
    for argument, loudness in zip(measured_at("impact"), measure.loudness, strict=True):
        wanted = max(aimed_at("impact", argument) + 0.25 * (-22.0 + 10.0), -31.0)
        assert gain_of("impact", argument, measure, 0.0) == pytest.approx(wanted - loudness, abs=0.1)
    assert gain_of("impact", 1.0, measure, 20.0) < gain_of("impact", 1.0, measure, 0.0)


@pytest.mark.slow
def test_a_plate_that_breaks_is_as_physics_has_it() -> None:
    """A gain would have it swell as it never does."""
    keys = {"seed": 290, "striker": "mute", "seconds": 1.0}
    assert played("small-gong", "shatter", 0.0325, **keys) == played("small-gong", "shatter", 0.0325, play=0, **keys)


@pytest.mark.parametrize("kind", sorted(GESTURES))
def test_values_at_their_bounds_are_measured_within(kind: str) -> None:
    """Beyond them kernels may divide by zero, as a steepness of 1 has the pieces of what breaks do."""
    law = {"mass": 1.0, "stiffness": 1e6, "dissipation": 0.0, "exponent": 1.5}
    bounds = {name: (each.in_engine(each.low), each.in_engine(each.high)) for name, each in OWN[kind].items()}
    for end in (0, 1):
        found = on_grid(kind, law | {name: ends[end] for name, ends in bounds.items()})
        for name in found.keys() & bounds.keys():
            assert min(bounds[name]) <= found[name] <= max(bounds[name]), name
