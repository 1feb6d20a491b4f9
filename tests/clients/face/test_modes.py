"""Object.modes: an object's modes as labels, against what it sounds like."""

import numpy as np
import pytest

import carom
from carom.dsp.numerics.legendre import MOMENTS
from carom.dsp.resonator.bank import RESPONSES, Modes, Point, inject, ring
from carom.dsp.resonator.click import set_click
from carom.dsp.resonator.simd import LANES
from carom.presets.library import Presets

RATE = 48_000
# Light and stiff: over within a ten-thousandth of a sample, without loss, so that it gives 2 m v; and silent itself.
CLICK = dict(striker="felt", mass=1e-7, stiffness=1e16, dissipation=0.0, exponent=1.5)


def synthesised(table, impulse, frames):
    """Return the sound of an impulse at t = 0, sample by sample, (frames, 2)."""
    t = np.arange(frames)[:, None] / RATE
    waves = np.exp(-table.decays * t) * np.sin(2 * np.pi * table.frequencies * t)
    sound = waves @ table.gains
    frequencies, decays, gains = table.relief
    sound += np.exp(-decays * t) * np.sin(2 * np.pi * frequencies * t) @ gains
    for click in table.clicks:
        sound += clicked(click.frequency, click.decay, frames)[:, None] * click.gains
    return impulse * sound


def clicked(frequency, decay, frames):
    """Return the bank's output for a click of a strength of 1 and an impulse that comes with the first sample."""
    y1, y2, a1, a2 = np.zeros((4, LANES))
    modes = Modes(y1, y2, a1, a2, np.ones(LANES), np.zeros(RESPONSES))
    set_click(modes, 0, frequency, decay, float(RATE), 1.0)
    inject(modes, Point(np.ones(LANES), 0, 0, np.array([1.0, 0, 0, 0])), (-1.0) ** np.arange(MOMENTS))
    out = np.zeros((2, frames))
    ring(modes, out, 1, frames)
    return out[0]


def added_up(preset, keys, position):
    """Return the table of an object struck at a position, which adds up to its sound."""
    with carom.Scene(RATE, limiter=False) as scene:
        obj = scene.new("a", preset, level=120, **keys)  # so that no mode is too quiet to be kept
        table = obj.modes(position)
        obj.impact(1.0, position, **CLICK)
        sound = scene.render(0.2).samples
        again = obj.modes(position)
    expected = synthesised(table, 2 * CLICK["mass"], len(sound))
    np.testing.assert_allclose(sound, expected, atol=2e-4 * np.abs(expected).max())
    for before, after in zip(table[:3], again[:3], strict=True):
        np.testing.assert_allclose(after, before, rtol=1e-12)
    return table


@pytest.mark.slow
@pytest.mark.parametrize("position", [0.0, 0.07, 0.5, 0.83, 1.0])
@pytest.mark.parametrize(
    ("preset", "keys"),
    [
        ("steel-plate", {"pan": 0.4, "gain": -3}),
        ("church-bell", {"tune": 5.0}),
        ("marimba-bar", {"damp": 0.3, "decay": 2}),
    ],
)
def test_modes_add_up_to_the_sound(preset, keys, position):
    assert (added_up(preset, keys, position).clicks == ()) == (preset == "church-bell")


@pytest.mark.slow
def test_a_discs_clicks_go_with_the_place_that_is_struck():
    """At 0.07 of a gong's diameter its edge lets the sound of the lowest one round."""
    edge, aside, middle = (abs(added_up("gong", {}, each).clicks[0].gains[0]) for each in (0.07, 0.3, 0.5))
    assert edge < 0.1 * aside < 0.1 * middle


@pytest.mark.parametrize(
    ("options", "keys"),
    [
        ({}, {"pitch": 440.0}),
        ({}, {"note": 69, "damp": 0.3}),
        ({"gain": -6.0}, {}),
        ({}, {"gains": [1.0, 0.25]}),
    ],
)
def test_modes_before_the_first_render_are_those_after_it(options, keys):
    with carom.Scene(RATE, **options) as scene:
        bar = scene.new("bar", "marimba-bar", **keys)
        before = bar.modes()
        scene.render(frames=64)
        after = bar.modes()
    assert bool(keys.keys() & {"pitch", "note"}) == (abs(before.frequencies[0] - 440.0) < 1e-6)
    for one, other in zip(before[:3], after[:3], strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12)


def test_modes_are_those_of_the_preset_below_the_top():
    modes = Presets().object("church-bell").modes(20_000.0)
    with carom.Scene(RATE) as scene:
        bell = scene.new("bell", "church-bell")
        table = bell.modes()
        assert bell.mass == modes.mass
        np.testing.assert_array_equal(table.frequencies, modes.frequency)
        np.testing.assert_array_equal(table.decays, modes.decay)
        assert table.gains.shape == (len(modes.frequency), 2) and np.all(np.diff(table.frequencies) > 0)


def test_modes_follow_the_object_s_settings():
    with carom.Scene(RATE) as scene:
        plate = scene.new("p", "steel-plate")
        table = plate.modes()
        plate.tune(24)
        plate.damp(1.0)
        plate.pan(-1)
        scene.render(frames=64)
        tuned = plate.modes()
        assert np.all(np.abs(tuned.gains[:, 1]) < 1e-15 * np.abs(tuned.gains[:, 0]).max())
        assert len(tuned.frequencies) < len(table.frequencies) and tuned.frequencies.max() <= 0.475 * RATE
        np.testing.assert_allclose(tuned.frequencies, table.frequencies[: len(tuned.frequencies)] * 4, rtol=1e-12)
        np.testing.assert_allclose(tuned.decays, table.decays[: len(tuned.decays)] + 200.0)


def test_the_preset_s_position_is_the_default():
    with carom.Scene(RATE) as scene:
        plate = scene.new("p", "steel-plate", position=0.2)
        np.testing.assert_array_equal(plate.modes().gains, plate.modes(np.float64(0.2)).gains)
        with pytest.raises(ValueError, match=r"position = 1\.5: expected 0 to 1"):
            plate.modes(1.5)


def test_modes_can_be_read_after_the_scene_is_closed():
    with carom.Scene() as scene:
        plate = scene.new("plate", "steel-plate")
        inside = plate.modes(0.3)
    for before, after in zip(inside[:3], plate.modes(0.3)[:3], strict=True):
        np.testing.assert_array_equal(before, after)
    for one, other in zip(inside.clicks, plate.modes(0.3).clicks, strict=True):
        np.testing.assert_array_equal(one.gains, other.gains)


def test_a_table_of_an_object_tuned_too_high_has_the_reliefs_of_one_that_is_not() -> None:
    """Modes that are tuned too high are muted: they are neither in the table nor in its relief."""
    with carom.Scene(48_000, calibrated=True) as scene:
        plain, tuned = (scene.new(f"o{tune}", "steel-ring", tune=tune).modes() for tune in (0, 24))
    assert len(tuned.frequencies) < len(plain.frequencies)
    assert len(tuned.relief.frequencies) == len(plain.relief.frequencies)
