"""Items that follow a score: worlds, and whatever takes more than one gesture."""

import itertools
import pickle

import numpy as np
import pytest

from carom.clients.dataset.check import require_sound
from carom.clients.dataset.clip import ItemError, render, row_of
from carom.clients.dataset.design import items
from carom.clients.dataset.files import FolderError
from carom.clients.dataset.plan import make, planned
from carom.clients.dataset.recipe import find, read
from carom.clients.dataset.run import Workers, run
from carom.clients.dataset.truth import AMPLIFIED
from carom.clients.rebuilding import rebuild
from carom.dsp.runtime.engine import Engine
from carom.presets import PresetError, Presets
from carom.server.osc.score import parse
from carom.server.render import Options, blocks
from carom.server.scene.scale import Scale
from carom.server.scene.session import Session
from tests.clients.dataset.support import contents, unpacked, written

SCORE = """
0.1  /object/bar/impact $velocity $position striker rubber
0    /object/new bar xylophone-bar material $material
0.15 /object/bar/roll 0.3 0.5 striker glass-marble id marble seed $seed
0.2  /gesture/marble/speed $velocity
"""
RECIPE = """
count = 4
seed = 3
seconds = 0.3
shard = 2
full_scale = 100.0
format = "wav"
samples = "float"

[score]
file = "two.txt"
material = { choice = ["rosewood", "aluminium"] }
velocity = { log_uniform = [0.1, 1.0] }
position = { uniform = [0, 1] }
"""


def placed(folder, recipe=RECIPE, **scores):
    """Write a recipe's file, beside scores."""
    for name, text in {"two": SCORE, **scores}.items():
        (folder / f"{name}.txt").write_text(text)
    return written(folder, recipe)


@pytest.mark.slow
def test_an_item_is_its_score_with_its_values(tmp_path):
    """An item sounds as the score that has its values written out, to the bit, on an engine as quiet as its own."""
    recipe = read(placed(tmp_path))
    require_sound(recipe, Presets())
    for item in items(recipe, range(4)):
        text = SCORE
        for key, value in {**item.values["score"], "seed": item.seed}.items():
            text = text.replace(f"${key}", repr(value) if isinstance(value, float) else str(value))
        options = Options(48_000, calibrated=True, channels=1, seconds=0.3)
        engine, scale = Engine(48_000, 1), Scale(True, amplified=AMPLIFIED)
        session = Session(engine, Presets(), steers_ended=True, scale=scale)
        sound = np.concatenate([*blocks(parse(text.encode(), "two"), engine, Presets(), options, session)])
        clip = render(recipe, item, Presets())
        assert (clip.samples == sound / np.float32(AMPLIFIED) / np.float32(100.0)).all()
        assert {each["gesture"] for each in clip.truth["contacts"]} == {"impact", "roll"}
        assert clip.truth["contacts"][1]["id"] == "marble"
        hardest = max(clip.truth["contacts"], key=lambda contact: contact["impulse"])
        (bar,) = clip.truth["objects"]
        assert (bar["name"], bar["material"]) == ("bar", item.values["score"]["material"])
        assert bar["position"] == hardest["position"]


@pytest.mark.slow
def test_a_ball_that_falls_gives_the_floor_its_momentum():
    recipe = read(find("worlds"), 40)
    fallen = [each for each in items(recipe, range(40)) if each.values["score"]["file"] == "drop.txt"]
    assert 10 < len(fallen) < 30
    for item in fallen[:4]:
        truth = render(recipe, item, Presets()).truth
        ball = next(each for each in truth["objects"] if each["name"] == "ball")
        first = truth["contacts"][0]
        starts = [each["start"] for each in truth["contacts"]]
        falls = sum(after > before + 0.05 for before, after in itertools.pairwise([-1.0, *starts]))
        assert first["object"] == "floor" and first["by"] == "ball" and falls == 7  # a floor may swing back after one
        # It is as fast as a fall of 0.3 m makes it. The floor yields, so that it takes less than a wall.
        assert first["speed"] == pytest.approx((2 * 9.81 * 0.3) ** 0.5, rel=1e-3)
        share = first["impulse"] / (ball["mass"] * first["speed"])
        assert 1.0 < share < 1.71


def test_a_word_that_another_score_says_is_no_factor(tmp_path):
    """No pair differs in such a word."""
    recipe = RECIPE.replace('"two.txt"', '{ choice = ["two.txt", "one.txt"] }').replace("count = 4", "count = 40")
    one = "0 /object/new a church-bell\n0 /object/a/impact $hard\n"
    path = placed(tmp_path, f'design = "pairs"\n{recipe}hard = {{ uniform = [1, 2] }}\n', one=one)
    made = items(read(path), range(40))
    assert {item.differs for item in made} > {"score.hard", "score.velocity"}
    for item in made:
        said = {"hard"} if item.values["score"]["file"] == "one.txt" else {"material", "velocity", "position"}
        assert {name.partition(".")[2] for name in item.factors} == {"file", *said}
        assert item.differs in item.factors


def test_sensors_rests_and_space_in_scores(tmp_path):
    """A score has presets of sensors; what rests is rebuilt from its contacts, what is heard from a place is not, nor
    what a pad covers, of which no contact is solved."""
    sensing = SCORE + "0.01 /sensor/new tip bar 0.9 preset piezo-27 full 10\n0.05 /object/bar/rest finger 0.3\n"
    placed_in_space, padded = "0.01 /listener 0 0 1\n0.02 /object/bar/place 2 1 0\n", "0.05 /object/bar/rest felt 0.6\n"
    for more, linear in (("", True), (placed_in_space, False), (padded, False)):
        recipe = read(placed(tmp_path, two=sensing + more))
        require_sound(recipe, Presets())
        (item,) = items(recipe, range(1))
        clip = render(recipe, item, Presets())
        assert clip.truth["linear"] is linear
        assert [each["name"] for each in clip.truth["sensors"]] == ["tip"] and clip.sensed.any()
        if linear:
            heard = clip.samples * clip.truth["full_scale"]
            assert np.abs(rebuild(row_of(clip)) - heard).max() < 1e-4 * np.abs(heard).max()
    wrong = read(placed(tmp_path, two=sensing.replace("piezo-27", "piezo-2")))
    with pytest.raises(PresetError, match=r"two.txt:6: /sensor/new: .*piezo-2.*did you mean piezo-2"):
        require_sound(wrong, Presets())


def test_scores_go_along_to_a_worker(tmp_path):
    plan = planned(read(placed(tmp_path)), ())
    here = make(plan, 1, "here")
    (tmp_path / "two.txt").unlink()
    there = make(pickle.loads(pickle.dumps(plan)), 1, "there")
    assert (here.tar, here.rows) == (there.tar, there.rows) and len(unpacked(here.tar)) == 2


@pytest.mark.slow
def test_a_folder_holds_the_data_set_of_one_score(tmp_path):
    path, out = placed(tmp_path), tmp_path / "out"
    run(read(path), out, Workers(1))
    before = contents(out)
    (tmp_path / "two.txt").write_text(SCORE.replace("0.2 ", "0.21 "))
    with pytest.raises(FolderError, match="it holds a data set of another score; expected a new or empty folder"):
        run(read(path), out, Workers(1))
    assert contents(out) == before


BAD = [
    # what is replaced in the recipe, by what; in the score; what the line names, what it asks for or expects
    ('file = "two.txt"', "", "", "", "[score] file is missing", "expected the name of a score"),
    ('file = "two.txt"', "file = 3", "", "", "[score] file = 3", "expected the name of a score"),
    ("two.txt", "tow.txt", "", "", "[score] file = 'tow.txt'", "tow.txt: No such file or directory"),
    ("", "", SCORE, "", "[score] file = 'two.txt'", "it is empty; expected lines"),
    ("", "", "rubber", "'rubber", "two.txt:2", "a quote that is not closed"),
    ("", "", "$position", "$place", "$place", "expected one of material, velocity, position, seed"),
    ("", "", "$position", "$positoin", "$positoin", "did you mean position?"),
    ("", "", " $position", "", "[score] position: no score has $position", "expected a line of two.txt to"),
    ("seconds = 0.3", "seconds = 0.1", "", "", "its last line is at 0.2 s", "expected at most seconds = 0.1"),
    ("[0.1, 1.0]", "[0.1, 1001.0]", "", "", "two.txt:2: /object/bar/impact: velocity = 1001", "from 0 to 1000 m/s"),
    ("", "", "impact", "impcat", "two.txt:2: /object/bar/impcat", "impact"),
    ("", "", "rubber", "rubbr", "two.txt:2: /object/bar/impact: no striker 'rubbr'", "did you mean rubber?"),
    ("", "", "xylophone-bar", "xylophone", "two.txt:3: /object/new: no object 'xylophone'", "did you mean"),
    ("", "", "/gesture/marble/speed", "/status", "two.txt:5: /status", "an address that a score may hold"),
    ("[score]", '[object]\npreset = "gong"\n[score]', "", "", "[object]", "expected no section beside [score]"),
]


@pytest.mark.parametrize(("old", "new", "line", "other", "named", "wanted"), BAD)
def test_a_bad_score_is_one_line(tmp_path, old, new, line, other, named, wanted):
    path = placed(tmp_path, RECIPE.replace(old, new, 1), two=SCORE.replace(line, other, 1))
    with pytest.raises(PresetError) as raised:
        require_sound(read(path), Presets())
    text = str(raised.value)
    assert named in text and wanted in text and "\n" not in text


def test_a_line_that_is_refused_names_item_and_line(tmp_path):
    recipe = read(placed(tmp_path, two=SCORE.replace("/object/bar/roll", "/object/baz/roll")))
    require_sound(recipe, Presets())
    (item,) = items(recipe, range(1))
    with pytest.raises(ItemError, match=r"item 0: .*two.txt:4: .*baz: no such object"):
        render(recipe, item, Presets())


def test_a_line_that_comes_too_late_is_told(tmp_path):
    recipe = read(placed(tmp_path, two=SCORE.replace("rubber", "rubber id blow") + "0.25 /gesture/blow/gain -6\n"))
    for item in items(recipe, range(2)):
        (told,) = render(recipe, item, Presets()).truth["warnings"]
        assert told.startswith("/gesture/blow/gain: blow: no such gesture is running")
