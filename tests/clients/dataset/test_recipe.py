"""Recipes: what is wrong with one is said in one line, which names file, key, value and what was expected."""

import math

import numpy as np
import pytest

from carom.clients.dataset.check import require_sound
from carom.clients.dataset.design import items
from carom.clients.dataset.recipe import find, read
from carom.clients.dataset.spread import spread_of
from carom.presets import BUILT_IN, PresetError, Presets
from tests.clients.dataset.support import SMALL, recipe_of, written

BAD = [
    # what is replaced, by what, what the line names, what it asks for or expects
    ("count = 6", "", "count is missing", "a whole number from 1"),
    ("count = 6", "count = 6.5", "count = 6.5", "a whole number from 1"),
    ("count = 6", "conut = 6", "conut = 6", "did you mean count?"),
    ("seed = 3", 'design = "gird"', "design = 'gird'", "did you mean grid?"),
    ("seed = 3", 'samples = "float"', "samples = 'float'", "expected 16 or 24, which FLAC holds"),
    ("seed = 3", "rate = 100", "rate = 100", "a whole number from 8000"),
    ("seed = 3", 'design = "pairs"\ndiffer = ["impact.speed"]', "impact.speed", "expected one of object.material"),
    ("count = 6", 'count = 5\ndesign = "pairs"', "count = 5", "expected an even number"),
    ("[impact]", "[imapct]", "imapct", "did you mean impact?"),
    ('preset = "xylophone-bar"', "", "[object] preset is missing", "expected the name of an object"),
    ("xylophone-bar", "xylophon-bar", "[object] no object 'xylophon-bar'", "did you mean xylophone-bar?"),
    ("material =", "matreial =", "[object] matreial = aluminium", "did you mean material?"),
    ("aluminium", "aluminum", "[object] material = 'aluminum'", "did you mean aluminium?"),
    ("velocity =", "velosity =", "[impact] velosity = ", "did you mean velocity?"),
    ("[impact]", '[rest]\nwhat = "feltt"\n[impact]', "[rest] what = 'feltt'", "did you mean felt?"),
    ("[impact]", '[rest]\nwhat = "by"\n[impact]', "[rest] what = 'by'", "expected one of felt"),
    ("velocity =", "# ", "[impact] velocity is missing", "expected velocity 0 to 1000 m/s"),
    ("[0.1, 1.0]", "[0.1, 1001.0]", "[impact] velocity = 1001", "expected a number from 0 to 1000 m/s"),
    ("[0.1, 1.0]", "[1.0, 0.1]", "[impact] velocity.log_uniform = [1.0, 0.1]", "the lower one first"),
    ("log_uniform = [0.1, 1.0]", "log_uniform = [0, 1.0]", "[impact] velocity.log_uniform: item 1 = 0", "1e-12"),
    ("log_uniform = [0.1, 1.0]", "normal = [1, 0.2]", "[impact] velocity.low is missing", "expected a number"),
    ("uniform = [0, 1]", "unifrom = [0, 1]", "position = {'unifrom': [0, 1]}", "did you mean uniform"),
    ("uniform = [0, 1]", "even = [0, 1]", "[impact] position = {'even': [0, 1]}", "expected one of uniform"),
    ("uniform = [0, 1]", "choice = [0, true]", "[impact] position.choice = [0, True]", "numbers, or of words"),
    ("uniform = [0, 1]", "choice = [0, 1], weights = [1]", "[impact] position.weights = [1.0]", "expected 2"),
    ("uniform = [0, 1]", "uniform = [0, 1.5]", "[impact] position = 1.5", "expected a number from 0 to 1"),
    ("[impact]", '[impact]\nstriker = "wod"', "[impact] no striker 'wod'", "did you mean wood?"),
    ("[impact]", '[impact]\nby = "cup"', "[impact] by = 'cup'", "expected a section [by]"),
    ("[impact]", "[impact]\nat = -1", "[impact] at = -1", "expected a number from 0 to 600 s"),
    ("[impact]", "[impact]\nseed = 1", "[impact] seed: no such key", "expected one of striker"),
    ("[object]", "[object]\nsize = 0", "[object] size = 0", "from 0.001"),
    ("xylophone-bar", "spoon", "[object] density = 2700", "that of the table; make the table anew (preset spoon)"),
    ("[object]", "[object]\nsize = 0.01", "[object] size = 0.01: ", "(preset xylophone-bar)"),
    ("[impact]", '[by]\npreset = "mug"\n[rain]\nrate = 9\n[impact]', "[rain] [by]: no object", "no such section"),
    ("[impact]", '[by]\npreset = "mug"\n[shatter]\nvelocity = 2\n[impact]', "[shatter] [by]", "no such section"),
    ("count = 6", "count = ", "not TOML", "line"),
]


@pytest.mark.parametrize(("old", "new", "named", "wanted"), BAD)
def test_a_bad_recipe_is_one_line(tmp_path, old, new, named, wanted):
    path = written(tmp_path, SMALL.replace(old, new, 1))
    with pytest.raises(PresetError) as raised:
        require_sound(read(path), Presets())
    text = str(raised.value)
    assert text.startswith(f"{path}: ") and named in text and wanted in text and "\n" not in text


def test_a_count_may_be_given(tmp_path):
    assert recipe_of(tmp_path, SMALL, 4).shards == 2
    with pytest.raises(PresetError, match="count = 0: expected a whole number from 1"):
        recipe_of(tmp_path, SMALL, 0)


def test_recipes_are_found_by_name():
    assert find("bars") == BUILT_IN / "recipes" / "bars.toml"
    with pytest.raises(PresetError, match=r"no recipe 'brs': did you mean bars\?"):
        find("brs")
    with pytest.raises(FileNotFoundError):
        find("mine/bars.toml")


@pytest.mark.parametrize("path", sorted((BUILT_IN / "recipes").glob("*.toml")), ids=lambda path: path.stem)
def test_the_built_in_recipes_are_sound(path):
    recipe = read(path)
    require_sound(recipe, Presets())
    assert recipe.description and recipe.factors


@pytest.mark.parametrize(
    ("table", "cumulative"),
    [
        ({"uniform": [2.0, 4.0]}, lambda x: (x - 2.0) / 2.0),
        ({"log_uniform": [0.1, 10.0]}, lambda x: math.log(x / 0.1) / math.log(100.0)),
        (
            {"normal": [0.0, 1.0], "low": -1.0, "high": 4.0},
            lambda x: (math.erf(x / 2**0.5) + math.erf(0.5**0.5)) / (math.erf(8**0.5) + math.erf(0.5**0.5)),
        ),
    ],
)
def test_distributions_have_their_cumulative(table, cumulative):
    spread = spread_of("", table)
    shares = np.linspace(0.001, 0.999, 97)
    assert [cumulative(spread.at(u)) for u in shares] == pytest.approx(shares, abs=1e-9)
    assert spread.at(0.0) == pytest.approx(spread.ends[0]) and spread.at(1 - 1e-16) <= spread.ends[1]


def test_choices_have_their_weights():
    spread = spread_of("", {"choice": ["a", "b", "c"], "weights": [1, 2, 1]})
    assert [spread.at(u) for u in (0.0, 0.249, 0.25, 0.749, 0.75, 0.999)] == ["a", "a", "b", "b", "c", "c"]
    assert [spread.at(spread.middle(n)) for n in range(3)] == ["a", "b", "c"]


def test_steps_are_a_few_values_with_both_ends():
    spread = spread_of("", {"log_uniform": [0.1, 10.0], "steps": 3})
    assert sorted({spread.at(u) for u in np.linspace(0, 0.999, 50)}) == pytest.approx([0.1, 1.0, 10.0])
    assert [spread.at(spread.middle(n)) for n in range(3)] == pytest.approx([0.1, 1.0, 10.0])


def test_an_item_follows_from_its_number_alone(tmp_path):
    for design in ("random", "sobol", "pairs", "grid"):
        recipe = recipe_of(tmp_path, f'design = "{design}"\n{SMALL}', 16)
        whole = items(recipe, range(16))
        assert items(recipe, range(6, 9)) == whole[6:9]
        assert len({item.factors["impact.velocity"] for item in whole}) > 1


def test_a_grid_has_every_point_once(tmp_path):
    text = SMALL.replace("count = 6", 'design = "grid"').replace("[0.1, 1.0]", "[0.1, 1.0], steps = 3")
    recipe = recipe_of(tmp_path, text)
    drawn = [(item.factors["object.material"], item.factors["impact.velocity"]) for item in items(recipe, range(6))]
    assert recipe.count == 6 and len(set(drawn)) == 6
    assert drawn[0] == ("rosewood", 0.1) and drawn[1][0] == "rosewood" and drawn[-1] == ("aluminium", 1.0)
    assert len({item.factors["impact.position"] for item in items(recipe, range(6))}) == 6  # no steps: it is drawn


def test_sobol_points_are_even(tmp_path):
    """Each of 64 equal boxes of two factors holds one of 64 points in a row: a (0, 6, 2)-net."""
    text = 'design = "sobol"\n' + SMALL.replace('material = { choice = ["rosewood", "aluminium"] }\n', "")
    recipe = recipe_of(tmp_path, text.replace("log_uniform = [0.1, 1.0]", "uniform = [0.0, 1.0]"), 192)
    for first in (0, 64, 128):
        drawn = [[*item.factors.values()] for item in items(recipe, range(first, first + 64))]
        for columns in (1, 2, 4, 8, 16, 32, 64):
            boxes = {(int(x * columns), int(y * 64 / columns)) for x, y in drawn}
            assert len(boxes) == 64


def test_a_pair_differs_in_one_factor(tmp_path):
    recipe = recipe_of(tmp_path, f'design = "pairs"\n{SMALL}', 60)
    made = items(recipe, range(60))
    seen = set()
    for first, second in zip(made[::2], made[1::2], strict=True):
        differ = [name for name in first.factors if first.factors[name] != second.factors[name]]
        assert differ == [first.differs] == [second.differs] and first.pair == second.pair == first.number // 2
        assert first.seed == second.seed
        seen.update(differ)
    assert seen == {"object.material", "impact.velocity", "impact.position"}
    chosen = recipe_of(tmp_path, f'design = "pairs"\ndiffer = ["object.material"]\n{SMALL}', 60)
    assert {item.differs for item in items(chosen, range(60))} == {"object.material"}


def test_of_several_gestures_an_item_has_one():
    recipe = read(find("gestures"))
    drawn = items(recipe, range(40))
    assert {item.gesture for item in drawn} == set(recipe.gestures)
    for item in drawn:
        assert set(item.values) == {"object", item.gesture}
        assert {name.partition(".")[0] for name in item.factors} <= {"gesture", "object", item.gesture}
