"""Levels of clips: a full scale of each item's own, samples that hold it, and a warning where they do not; splits of
items; a card's licence."""

import numpy as np
import pytest

from carom.clients.dataset.card import card
from carom.clients.dataset.clip import render
from carom.clients.dataset.design import items
from carom.clients.dataset.level import pascals, quantized, whole_of
from carom.clients.dataset.recipe import read
from carom.clients.dataset.shard import sound_file
from carom.presets import PresetError, Presets
from tests.clients.dataset.support import SMALL, recipe_of, written


@pytest.mark.parametrize("peak", [1e-12, 1e-5, 0.1, 0.5, 1.0, 270.0])
def test_full_scale_is_the_least_power_of_two_above_the_peak(peak):
    whole = whole_of(peak)
    assert whole / 2 <= peak < whole and np.log2(whole).is_integer()


@pytest.mark.parametrize("samples", ["16", "24"])
def test_samples_are_the_nearest_steps(tmp_path, samples):
    import io

    import soundfile

    bits = int(samples)
    pressure = np.random.default_rng(1).uniform(-3, 3, (1_000, 1)).astype(np.float32)
    recipe = recipe_of(tmp_path, f'samples = "{samples}"\n' + SMALL)
    steps = quantized(pressure.copy(), float(abs(pressure).max()), 4.0, samples)
    back = soundfile.read(io.BytesIO(sound_file(steps, recipe)), always_2d=True)[0]
    assert np.abs(4.0 * back - pressure).max() <= 2.0 ** (2 - bits) * 1.001


@pytest.mark.parametrize("full_scale", [2.0**-9, 4.0, 400.0])
def test_steps_and_pressures_are_those_of_double_precision(full_scale):
    """Single precision, which is used for powers of two, loses nothing."""
    pressure = (full_scale * np.random.default_rng(2).uniform(-1, 1, (1_000, 1))).astype(np.float32)
    steps = quantized(pressure.copy(), float(abs(pressure).max()), full_scale, "24")
    exact = np.rint(pressure.astype(np.float64) * (2**23 / full_scale))
    np.testing.assert_array_equal(steps, np.minimum(exact, 2**23 - 1))
    np.testing.assert_array_equal(pascals(steps, full_scale, "24"), (exact * (full_scale / 2**23)).astype(np.float32))


def test_a_faint_clip_keeps_its_sound_and_warns_under_a_full_scale_for_all(tmp_path):
    faint = SMALL.replace("log_uniform = [0.1, 1.0]", "log_uniform = [1e-6, 2e-6]")
    own = recipe_of(tmp_path, faint)
    clip = render(own, items(own, range(1))[0], Presets())
    assert not clip.truth["warnings"] and np.abs(clip.samples).max() >= 2**22
    shared = recipe_of(tmp_path, "full_scale = 400\n" + faint)
    (said,) = render(shared, items(shared, range(1))[0], Presets()).truth["warnings"]
    assert "dB above the noise of its samples; expected at least 40" in said or said == "it is silent"


def test_a_split_keeps_what_is_alike_together(tmp_path):
    text = 'split = { by = "geometry", test = 0.25 }\n' + SMALL.replace(
        '"xylophone-bar"', '{ choice = ["xylophone-bar", "marimba-bar", "vibraphone-bar", "glockenspiel-bar"] }'
    )
    recipe = recipe_of(tmp_path, text, 200)
    sides = {}
    for item in items(recipe, range(200)):
        sides.setdefault(item.factors["object.preset"], set()).add(recipe.split.side(item.factors, Presets()))
    assert sorted(map(sorted, sides.values())) == [["test"], ["train"], ["train"], ["train"]]


@pytest.mark.slow
@pytest.mark.parametrize(
    "keys",
    [
        "preset = { choice = ['steel-plate', 'glass-plate'] }\nlength = SOME\nwidth = 0.1\nthickness = 0.004",
        "preset = 'steel-plate'\nlength = SOME\nwidth = SOME",
        "preset = 'steel-plate'\nlength = SOME\nwidth = 0.1\nthickness = 0.004\nsize = { choice = [1, 2] }",
        "preset = 'steel-plate'\nlength = SOME\nloss_factor = { uniform = [1e-4, 1e-3] }",
        "preset = 'steel-plate'\nlength = SOME\nvelocity = { uniform = [1, 2] }\nlevel = { uniform = [0, 1] }",
    ],
    ids=["two presets", "turned", "size of none", "loss", "strike and level"],
)
def test_objects_of_the_same_lengths_are_on_one_side(tmp_path, keys):
    keys = keys.replace("SOME", "{ choice = [0.1, 0.2, 0.3, 0.4] }")
    text = f"split = {{ by = 'geometry', test = 0.5 }}\n[object]\n{keys}\n[impact]\nvelocity = 1.0\n"
    recipe = recipe_of(tmp_path, text, 200)
    sides, presets = {}, Presets()
    for item in items(recipe, range(200)):
        made = item.values["object"]
        lengths = tuple(sorted((made["length"], made.get("width", 0.0))))
        sides.setdefault(lengths, set()).add(recipe.split.side(item.factors, presets))
    assert {len(each) for each in sides.values()} == {1}
    assert set.union(*sides.values()) == {"train", "test"}


@pytest.mark.parametrize(
    ("split", "said"),
    [
        ('{ by = "shape" }', r"split.by = 'shape': expected one of geometry"),
        ('{ by = "geometry" }', r"split.by = 'geometry': no preset or length is drawn"),
        ('{ by = "object.material", test = 0.6, validation = 0.6 }', "expected less than 1 together"),
        ("{ test = 0.5 }", "split.by is missing"),
    ],
)
def test_a_bad_split_is_one_line(tmp_path, split, said):
    with pytest.raises(PresetError, match=said):
        read(written(tmp_path, f"split = {split}\n{SMALL}"))


def test_pairs_that_a_split_would_part_are_refused(tmp_path):
    text = 'design = "pairs"\nsplit = { by = "object.material" }\n' + SMALL
    with pytest.raises(PresetError, match=r"split: pairs may differ in object.material; expected differ"):
        read(written(tmp_path, text))


@pytest.mark.parametrize(
    ("licence", "lines"),
    [
        ("CC-BY-4.0", "license: cc-by-4.0"),
        ("GPL-3.0-or-later", "license: gpl-3.0"),
        ("ODbL-1.0", "license: odbl"),
        ("MIT-0", "license: other\nlicense_name: mit-0"),
        ("LicenseRef-Ours", "license: other\nlicense_name: licenseref-ours"),
    ],
)
def test_a_card_names_a_licence_by_a_word_of_the_hub(tmp_path, licence, lines):
    recipe = recipe_of(tmp_path, f"licence = '{licence}'\n{SMALL}")
    told = card(recipe, {"tables": {"train": "small.parquet"}, "computed_by": {"carom": "0"}})
    assert told.startswith(f"---\n{lines}\npretty_name")
