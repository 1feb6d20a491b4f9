"""The truth of a clip, against its sound and against mechanics."""

import json

import numpy as np
import pytest

from carom.clients.dataset.clip import ItemError, render
from carom.clients.dataset.design import items
from carom.clients.dataset.plan import make, planned
from carom.clients.dataset.recipe import find, read
from carom.presets import Presets
from tests.clients.dataset.support import SMALL, recipe_of, unpacked


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A recipe and the items of its first shard."""
    recipe = recipe_of(tmp_path_factory.mktemp("recipe"), SMALL)
    return recipe, unpacked(make(planned(recipe, ()), 0, "here").tar)


def _pascals(item):
    return item["truth"]["full_scale"] * item["samples"]


@pytest.mark.slow
def test_a_shard_holds_sounds_truths_and_forces(small):
    recipe, found = small
    assert [item["key"] for item in found] == ["000000000", "000000001"]
    for number, item in enumerate(found):
        assert item["samples"].shape == (12_000, 1) and item["rate"] == 48_000 and item["ending"] == "flac"
        truth = item["truth"]
        assert truth["item"] == number and truth["full_scale"] / 2 <= truth["peak"] < truth["full_scale"]
        assert truth["factors"] == dict(items(recipe, range(2))[number].factors)
        assert truth["peak"] == pytest.approx(np.abs(_pascals(item)).max(), abs=truth["full_scale"] / 2**23)
        assert truth["exposure"] == pytest.approx([np.square(_pascals(item)).sum() / 48_000], rel=1e-4)


def test_the_modes_are_heard(small):
    """The sound after the contact is the sum of the modes that are listed: their amplitudes come out of a fit."""
    _, found = small
    for item in found:
        (contact,) = item["truth"]["contacts"]
        (obj,) = item["truth"]["objects"]
        frequency, decay = (np.array(obj["modes"][key]) for key in ("frequency", "decay"))
        begin = round((contact["start"] + contact["duration"]) * 48_000) + 300
        pressure = _pascals(item)[begin:, 0]
        time = (np.arange(begin, 12_000) - 64) / 48_000 - contact["start"]  # the sound comes a quantum later
        basis = np.exp(np.outer(time, -decay + 2j * np.pi * frequency))
        columns = np.hstack([basis.real, basis.imag])
        left = pressure - columns @ np.linalg.lstsq(columns, pressure, rcond=None)[0]
        assert np.linalg.norm(left) < 1e-3 * np.linalg.norm(pressure)


def test_the_lowest_mode_is_as_loud_as_its_gain_says(small):
    """The amplitude of a mode is its gain times the force's component at its frequency: by the forces in the shard."""
    _, found = small
    for item in found:
        (contact,) = item["truth"]["contacts"]
        modes = item["truth"]["objects"][0]["modes"]
        frequency, decay, gain = modes["frequency"][0], modes["decay"][0], modes["gain"][0][0]
        pole = -decay + 2j * np.pi * frequency
        force = item["force"][contact["force_begin"] :, 0][: contact["force_count"]]
        when = (contact["first"] - 1 + np.arange(len(force)) + 0.5) / 48_000
        amplitude = gain * (force * np.exp(-pole * when)).sum() / 48_000  # at the time 0
        begin = 1_500
        time = np.arange(begin, 12_000) / 48_000
        pressure = _pascals(item)[begin:, 0]
        poles = -np.array(modes["decay"]) + 2j * np.pi * np.array(modes["frequency"])
        basis = np.exp(np.outer(time, poles))
        fitted = np.linalg.lstsq(np.hstack([basis.real, basis.imag]), pressure, rcond=None)[0]
        heard = np.hypot(fitted[0], fitted[len(modes["decay"])])
        assert heard == pytest.approx(abs(amplitude), rel=0.02)


def test_a_blow_conserves_momentum_and_loses_energy(small):
    _, found = small
    for item in found:
        (contact,) = item["truth"]["contacts"]
        assert contact["speed"] == pytest.approx(item["truth"]["factors"]["impact.velocity"])
        assert contact["velocity"] == pytest.approx(contact["speed"], rel=1e-12)
        assert contact["energy"] == pytest.approx(0.5 * contact["mass"] * contact["speed"] ** 2)
        after = contact["speed"] - contact["impulse"] / contact["mass"]
        assert contact["loss"] == pytest.approx(contact["energy"] - 0.5 * contact["mass"] * after**2)
        assert 0.0 < contact["loss"] <= contact["energy"]
        assert contact["impulse"] == pytest.approx(item["force"][:, 0].sum() / 48_000, rel=1e-5)
        assert contact["position"] == pytest.approx(item["truth"]["factors"]["impact.position"])


def test_pascals_are_those_of_a_calibrated_scene(small):
    import carom

    recipe, found = small
    item = items(recipe, range(1))[0]
    with carom.Scene(calibrated=True, channels=1) as scene:
        bar = scene.new("object", "xylophone-bar", material=item.factors["object.material"], at=0)
        bar.impact(item.factors["impact.velocity"], item.factors["impact.position"], at=0)
        pressure = scene.render(0.25).pressure
    np.testing.assert_allclose(_pascals(found[0]), pressure, atol=found[0]["truth"]["full_scale"] / 2**23)


def test_a_recipe_may_draw_impulses(tmp_path):
    """In place of velocities; a bar that hardly yields gets what was drawn."""
    blow = "impulse = { log_uniform = [1e-4, 1e-3] }\nstriker = 'felt-hammer'"
    recipe = recipe_of(tmp_path, SMALL.replace("velocity = { log_uniform = [0.1, 1.0] }", blow))
    for item in items(recipe, range(3)):
        (contact,) = render(recipe, item, Presets()).truth["contacts"]
        assert contact["impulse"] == pytest.approx(item.factors["impact.impulse"], rel=0.3)


def test_a_clip_beyond_full_scale_is_an_error_that_names_it(tmp_path):
    recipe = recipe_of(tmp_path, "full_scale = 1e-3\n" + SMALL)
    with pytest.raises(ItemError, match=r"item 4: its peak is .* Pa: expected at most full_scale = 0.001 Pa \(object"):
        render(recipe, items(recipe, range(4, 5))[0], Presets())


def test_error_of_a_clip_names_its_item(tmp_path):
    recipe = recipe_of(tmp_path, SMALL.replace("[impact]", "[impact]\nmass = 1000\nstiffness = 1"))
    with pytest.raises(ItemError, match=r"item 0: .*the contact would last .*impact.velocity = "):
        render(recipe, items(recipe, range(1))[0], Presets())


@pytest.mark.slow
def test_every_gesture_has_its_truth():
    recipe, presets, seen = read(find("gestures")), Presets(), {}
    for item in items(recipe, range(24)):
        if item.gesture not in seen:
            seen[item.gesture] = clip = render(recipe, item, presets)
            json.dumps(clip.truth, allow_nan=False)
            assert 0.5 <= clip.truth["peak"] / clip.truth["full_scale"] < 1.0 and clip.truth["contacts"]
            assert len(clip.force) == sum(each["force_count"] for each in clip.truth["contacts"])
    assert set(seen) == set(recipe.gestures)
    speeds = [each["speed"] for each in seen["bounce"].truth["contacts"]]
    assert len(speeds) > 3 and speeds[0] > speeds[1] > speeds[2]
    height = seen["bounce"].truth["factors"]["bounce.height"]
    assert speeds[0] == pytest.approx((2 * 9.80665 * height) ** 0.5, rel=1e-6)


def test_an_object_that_strikes_has_its_own_modes(tmp_path):
    text = SMALL.replace("[impact]", '[by]\npreset = "glass-ball"\nsize = 0.5\n\n[impact]')
    recipe = recipe_of(tmp_path, "seconds = 0.1\n" + text.replace("seconds = 0.25\n", ""))
    truth = render(recipe, items(recipe, range(1))[0], Presets()).truth
    bar, ball = truth["objects"]
    assert (bar["name"], ball["name"], truth["contacts"][0]["by"]) == ("object", "by", "by")
    whole = Presets().object("glass-ball").modes(20_000)
    assert ball["mass"] == pytest.approx(whole.mass / 8)  # half of every length
    assert ball["modes"]["frequency"][0] == pytest.approx(2 * whole.frequency[0])
    assert truth["contacts"][0]["mass"] == pytest.approx(ball["mass"])
