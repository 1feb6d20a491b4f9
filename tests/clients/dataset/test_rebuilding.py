"""The truth rebuilds the sound, attack and tail: of every gesture, of worlds, and at the places of any recipe."""

import numpy as np
import pytest

import carom
from carom.clients.dataset.clip import render, row_of
from carom.clients.dataset.design import items
from carom.clients.dataset.recipe import find, read
from carom.presets import Presets
from tests.clients.dataset.support import SMALL, recipe_of, written

ATTACK = 96  # frames from the first force on


def missed(recipe, number, presets=None):
    """Return how far a rebuilt clip is from what was rendered, dB of the whole and of its attack."""
    clip = render(recipe, items(recipe, range(number, number + 1))[0], presets or Presets())
    heard = clip.samples * (clip.truth["full_scale"] / 2**23)
    rebuilt = carom.rebuild(row_of(clip))
    first = min(contact["first"] for contact in clip.truth["contacts"])

    def level(part):
        return 10 * np.log10(np.square(rebuilt[part] - heard[part]).sum() / np.square(heard[part]).sum())

    return level(slice(None)), level(slice(first, first + ATTACK))


@pytest.mark.parametrize("number", [0, 1, 3])
def test_a_blow_is_rebuilt(tmp_path, number):
    recipe = recipe_of(tmp_path, SMALL)
    assert max(missed(recipe, number)) < -80


@pytest.mark.parametrize(
    ("object_keys", "by", "gesture"),
    [
        ('preset = "glass-plate"\npan = 0.4\ntune = -3', "", '[impact]\nvelocity = 1\nstriker = "ping-pong"\ngain = 6'),
        ('preset = "aluminium-pipe"', 'preset = "glass-ball"', "[impact]\nvelocity = 1\nposition = 0.2"),
        (
            'preset = "steel-ring"\nmaterial = "brass"',
            "",
            '[press]\nforce = 2\nstriker = "fingertip"\nuntil = 0.05',
        ),
        (
            'preset = "glass-plate"',
            'preset = "iron-pan"',
            '[rest]\nwhat = "by"\nby_position = 0.3\nposition = 0.4\nuntil = 0.05',
        ),
        ('preset = "ceramic-tile"', "", '[spin]\nduration = 0.1\nstriker = "coin"'),
        ('preset = "marimba-bar"', "", '[bounce]\nheight = 0.001\nstriker = "ball-bearing"'),
        ('preset = "wood-board"', "", '[roll]\nspeed = 0.5\nstriker = "glass-marble"\nsurface = "wood"\ntravel = 0.2'),
        ('preset = "steel-plate"', "", '[slide]\nspeed = 0.4\nstriker = "box"\nsurface = "wood"\ntravel = 0.3'),
        ('preset = "cymbal"', "", '[slide]\nspeed = 0.03\nstriker = "bow"\nsurface = "steel"\nuntil = 0.07'),
        ('preset = "pot-lid"', "", "[impact]\nvelocity = 1\nposition = 0.93"),
        ('preset = "gong"', "", '[roll]\nspeed = 0.5\nstriker = "glass-marble"\nsurface = "wood"\ntravel = 0.6'),
    ],
    ids=["tuned", "by", "press", "rest", "spin", "bounce", "roll", "slide", "bow", "disc", "rolled"],
)
@pytest.mark.slow
def test_clips_unlike_the_built_in_recipes_are_rebuilt(tmp_path, object_keys, by, gesture):
    by = f"[by]\n{by}\n" if by else ""
    text = f"count = 1\nseconds = 0.1\nchannels = 2\n[object]\n{object_keys}\n{by}{gesture}\n"
    assert max(missed(recipe_of(tmp_path, text), 0)) < -60


@pytest.mark.slow
@pytest.mark.parametrize("number", [2, 5])
def test_impacts_are_rebuilt(number):
    assert max(missed(read(find("impacts")), number)) < -80


@pytest.mark.slow
def test_a_world_is_rebuilt():
    """Gains go with the distance, and two bodies sound."""
    assert max(missed(read(find("worlds")), 1)) < -80


def test_a_blow_off_the_strike_path_is_refused_by_name(tmp_path):
    """A row tells a place along the path alone, and so another sound."""
    key = "point = [0.0, 0.0, 0.0]\ndirection = [1.0, 0.0, 1.0]"
    text = f'count = 1\nseconds = 0.05\n[object]\npreset = "wrench"\n[impact]\nvelocity = 1\n{key}\n'
    with pytest.raises(carom.NotLinear, match="object: it is not linear"):
        missed(recipe_of(tmp_path, text), 0)


@pytest.mark.slow
def test_a_swarm_is_refused_by_name(tmp_path):
    """Most of its blows are no contacts of their own."""
    text = 'count = 1\nseconds = 0.05\n[object]\npreset = "glockenspiel-bar"\n[rain]\nrate = 500\n'
    with pytest.raises(carom.NotLinear, match="object: it is not linear"):
        missed(recipe_of(tmp_path, text), 0)


def test_standing_object_is_refused_by_name(tmp_path):
    text = 'count = 1\nseconds = 0.05\n[object]\npreset = "tumbler"\n[press]\nforce = 9\nstriker = "wood"\n'
    with pytest.raises(carom.NotLinear, match="object: it is not linear"):
        missed(recipe_of(tmp_path, text), 0)


@pytest.mark.slow
@pytest.mark.parametrize("preset", ["tom", "splash-cymbal"])
def test_stretching_objects_are_refused_by_name(tmp_path, preset):
    recipe = recipe_of(
        tmp_path, SMALL.replace('"xylophone-bar"\nmaterial = { choice = ["rosewood", "aluminium"] }', f'"{preset}"')
    )
    with pytest.raises(ValueError, match="object: it is not linear"):
        missed(recipe, 0)


def followed(folder, *lines, rate=48_000, preset="wood-board"):
    """Return the row of a clip that follows a score of an object, o."""
    (folder / "score.txt").write_text("\n".join([f"0 /object/new o {preset}", *lines]))
    head = f'count = 1\nseconds = 0.1\nrate = {rate}\nsamples = "float"\nformat = "wav"\n'
    path = written(folder, f'{head}[score]\nfile = "score.txt"\n')
    return next(carom.render_many(path))


def test_the_level_of_everything_is_in_the_truth(tmp_path):
    """The level goes with an object's own gain, whenever either changes."""
    for score in (["0 /gain -6"], ["0.01 /gain -6 over 0.03", "0.02 /object/o/gain -3 over 0.05"]):
        row = followed(tmp_path, *score, "0.005 /object/o/impact 1")
        assert np.square(carom.rebuild(row) - row["sound"]).sum() < 1e-8 * np.square(row["sound"]).sum()


def test_a_panic_is_refused_by_name(tmp_path):
    row = followed(tmp_path, "0 /object/o/impact 1", "0.05 /panic")
    assert not row["linear"]
    with pytest.raises(carom.NotLinear, match="o: it is not linear"):
        carom.rebuild(row)


@pytest.mark.parametrize("gesture", ["impact 1", "press 1 striker wood"])
def test_a_clip_with_an_object_that_is_gone_is_refused(tmp_path, gesture):
    """Later messages forget it, and another may have its name by then: the table cannot tell it."""
    free = ["0.05 /object/o/free", "0.08 /object/new pane glass-plate"]
    row = followed(tmp_path, f"0 /object/o/{gesture}", *free)
    assert not row["linear"] and [each["name"] for each in row["objects"]] == ["pane"]
    with pytest.raises(carom.NotLinear, match="was freed before the clip's end"):
        carom.rebuild(row)


@pytest.mark.parametrize("gesture", ["slide 3 0.166 striker bowling-ball", "roll 3 0.166 striker glass-marble"])
def test_contacts_that_pass_more_than_a_row_of_shapes_in_a_line_are_rebuilt(tmp_path, gesture):
    """A contact that feels the modes is at its own place in each frame."""
    row = followed(
        tmp_path, f"0.01 /object/o/{gesture} seed 661 surface wood travel 0.1338", rate=8_000, preset="marimba-bar"
    )
    rows = len(row["objects"][0]["places"]["modes"][0])
    assert not row["contacts"][0]["fed"] and 3 / 0.1338 * 16 / 8_000 * (rows - 1) > 1
    assert np.square(carom.rebuild(row) - row["sound"]).sum() < 1e-7 * np.square(row["sound"]).sum()


def test_a_slide_that_travels_is_rebuilt_when_it_is_put_elsewhere(tmp_path):
    """The quantum before ends where the slide would have gone on to."""
    slide = "0 /object/lid/slide 0.2 0.5 striker chair-leg surface wood travel 0.3 id leg seed 5"
    lines = "0 /object/new lid tin-lid", slide, "0.05 /gesture/leg/position 0.65"
    row = followed(tmp_path, *lines, rate=16_000)
    assert row["contacts"][0]["fed"]
    assert np.square(carom.rebuild(row) - row["sound"]).sum() < 1e-7 * np.square(row["sound"]).sum()


@pytest.mark.slow
@pytest.mark.parametrize("travel", [0.0, 0.1])
def test_a_slide_whose_friction_is_steered_to_and_fro_is_rebuilt(tmp_path, travel):
    """Such a slide feels the modes, then not, then again: each is a contact, whose force drives them in its way."""
    slide = f"slide 0.3 0.4 striker wood surface slate seed 3 id g static 0.9 dynamic 0.9 along 0 travel {travel}"
    steers = "0.03 /gesture/g/along 0.9", "0.07 /gesture/g/along 0"
    row = followed(tmp_path, f"0 /object/o/{slide}", *steers, preset="drinks-can")
    assert [each["fed"] for each in row["contacts"]] == [False, True, False]
    assert np.square(carom.rebuild(row) - row["sound"]).sum() < 1e-7 * np.square(row["sound"]).sum()


@pytest.mark.slow
@pytest.mark.parametrize("preset", ["wine-glass", "tin-lid"])
@pytest.mark.parametrize("travels", [(0.0, 0.1), (0.0,) * 6], ids=["one travels", "many"])
def test_slides_beside_each_other_are_rebuilt(tmp_path, preset, travels):
    """Few modes get them all by moments, many by one number a frame, whatever else acts on the object."""
    lines = [
        f"0.001 /object/o/slide 0.2 0.{n + 1} striker chair-leg surface wood travel {travel} id leg{n} seed {n}"
        for n, travel in enumerate(travels)
    ]
    row = followed(tmp_path, *lines, rate=16_000, preset=preset)
    assert [contact["fed"] for contact in row["contacts"]] == [True] * len(travels)
    assert np.square(carom.rebuild(row) - row["sound"]).sum() < 1e-7 * np.square(row["sound"]).sum()


def test_a_slide_of_an_object_of_few_modes_on_one_of_many_is_rebuilt(tmp_path):
    """One gets the force by moments, the other by one number a frame."""
    lines = "0 /object/new bar marimba-bar", "0.01 /object/o/slide 0.2 0.4 by bar striker chair-leg surface wood seed 3"
    row = followed(tmp_path, *lines, rate=16_000, preset="tin-lid")
    assert [len(each["modes"]["frequency"]) for each in row["objects"]] == [34, 24]
    assert [len(each["by_moments"]) for each in row["objects"]] == [2, 24]
    assert np.square(carom.rebuild(row) - row["sound"]).sum() < 1e-7 * np.square(row["sound"]).sum()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rate", "preset", "lines"),
    [
        (44_100, "wine-glass", ["0.01 /object/o/slide 0.27 0.76 striker ball-bearing seed 7 travel 0.05"]),
        (
            44_100,
            "wine-glass",
            [
                "0.015 /object/o/roll 0.08 0.89 id g striker rubber surface concrete seed 12 travel 0.03",
                "0.05 /gesture/g/speed 0.18 over 0.024",
            ],
        ),
        (96_000, "pot-lid", ["0.001 /object/o/slide 0.9 0.94 striker glass-marble surface glass seed 65 travel 0.04"]),
    ],
    ids=["turns", "steered", "fast"],
)
def test_travelling_contacts_are_rebuilt(tmp_path, rate, preset, lines):
    row = followed(tmp_path, *lines, rate=rate, preset=preset)
    assert not row["contacts"][0]["fed"]
    assert np.square(carom.rebuild(row) - row["sound"]).sum() < 1e-7 * np.square(row["sound"]).sum()


def test_a_finger_that_goes_round_a_glass_is_rebuilt(tmp_path):
    """The contact goes along as fast as it slips, and its friction acts where it is."""
    finger = "0.001 /object/o/slide 0.3 0.9 striker wet-finger surface skin force 2 travel 0.02 seed 3"
    row = followed(tmp_path, finger, rate=44_100, preset="wine-glass")
    place = np.reshape(row["contacts"][0]["path"], (len(row["contacts"][0]["force"]), -1))[:, 0]
    assert place[-1] == pytest.approx(0.9 + 0.3 * 0.099 / 0.02 - 2.0, abs=0.03)  # over 1 and 0
    assert np.square(carom.rebuild(row) - row["sound"]).sum() < 1e-7 * np.square(row["sound"]).sum()


def test_a_roll_is_where_its_speed_takes_it_from_its_beginning(tmp_path):
    """A roll begins amid a quantum, and is put anew every 16 frames at least."""
    row = followed(tmp_path, "0.0021 /object/o/roll 0.5 0.2 striker glass-marble travel 0.1")
    contact = row["contacts"][0]
    place = np.reshape(contact["path"], (len(contact["force"]), -1))[:, 0]
    expected = 0.2 + 0.5 * np.arange(len(place)) / 48_000 / 0.1
    assert np.abs(place - expected).max() < 17 * 0.5 / 48_000 / 0.1
