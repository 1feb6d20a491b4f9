"""Rests over OSC: on objects and supports, their loads, masses and grounds, and what is refused."""

import numpy as np
import pytest

import carom
from carom.dsp.numerics.constants import STANDARD_GRAVITY
from carom.dsp.schema import REST
from carom.presets.supports import SUPPORTS, plate_resistance
from tests.server.scene.support import ends, refusal, say, seconds


def resting(played):
    """Return the contacts that there are."""
    return [contact for contact in played.engine.state["contacts"][0] if contact["gesture"]]


def test_an_object_rests_on_another_by_its_weight(played):
    assert say(played, "/object/cup/rest", "pane", 0.2, "by_position", 0.7, "id", "foot") == []
    played.engine.process(64)
    (contact,) = resting(played)
    cup, pane = played.objects["cup"], played.objects["pane"]
    assert [point["slot"] for point in contact["point"]] == [cup.handle.slot, pane.handle.slot]
    assert contact["m"] == pytest.approx(cup.mass)
    assert contact["now"]["load"] == pytest.approx(cup.mass * STANDARD_GRAVITY)
    assert (contact["k"], contact["mu"], contact["a"]) == pytest.approx(cup.preset.struck_by(pane.preset))
    say(played, "/gesture/foot/stop")
    played.engine.process(64)
    assert [id for id, _ in ends(played)] == ["foot"] and resting(played) == []


@pytest.mark.parametrize("name", SUPPORTS)
def test_an_object_rests_on_each_support(played, name):
    support, cup = SUPPORTS[name], played.objects["cup"]
    played.engine.process(64)
    used = played.engine.state["objects"][0]["used"].sum()
    assert say(played, "/object/cup/rest", name, "id", "x", "load", 0.01) == []
    played.engine.process(64)
    (contact,) = resting(played)
    assert contact["m"] == pytest.approx(support.mass or 0.01 / STANDARD_GRAVITY)
    below = support.resistance > 0 or support.area > 0
    assert (contact["point"][1]["slot"] >= 0) == below
    if not support.material:
        stiffness = 0.0 if support.area else support.stiffness
        assert (contact["k"], contact["mu"], contact["a"]) == (stiffness, support.dissipation, support.exponent)
    assert played.engine.state["objects"][0]["used"].sum() == used + below
    say(played, "/object/cup/impact", 0.5)
    seconds(played, 0.2)
    assert len(resting(played)) == 1
    say(played, "/gesture/x/stop")
    seconds(played, 3.0)
    assert played.engine.state["objects"][0]["used"].sum() == used  # its ground is gone
    assert cup.handle.slot in {int(i) for i in np.flatnonzero(played.engine.state["objects"][0]["used"])}


def test_the_words_of_the_declaration_are_the_supports():
    assert all(name in REST.what for name in SUPPORTS)


@pytest.mark.parametrize("what", ["pane", "table"])
@pytest.mark.parametrize("at_once", [False, True])
def test_support_freed_under_a_sleeping_rest_goes_when_the_rest_ends(played, what, at_once):
    """A ground, or an object, below what has been still for long; its end, or that of what lies there."""
    played.engine.process(64)
    used = played.engine.state["objects"][0]["used"].sum()
    say(played, "/object/cup/rest", what, "id", "x")
    seconds(played, 1.0)
    if what == "pane":
        say(played, "/object/pane/free")
    seconds(played, 1.0)
    assert resting(played)[0]["asleep"] == 1
    say(played, *(("/object/cup/free", 1) if at_once else ("/gesture/x/stop",)))
    seconds(played, 0.1)
    assert played.engine.state["objects"][0]["used"].sum() == used - (what == "pane") - at_once


def test_a_plates_resistance_is_eight_times_the_root_of_stiffness_and_mass():
    assert plate_resistance(12.0, 0.0, 4.0, 1.0) == pytest.approx(16.0)


EXPECTED = "expected another object, felt, foam, finger, palm, table or none"


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        (("felz",), f"what = felz: {EXPECTED}; did you mean felt?"),
        (("cup",), f"what = cup: {EXPECTED}"),
        (("pane", "resistance", 5), "resistance = 5: expected none, as pane is an object"),
        (("felt", "load", 1e5, "mass", 1e-7), "load = 100000, mass = 1e-07: expected at most 1e+09 N per kg"),
        (("felt", "load", 2e4), "load = 20000: expected at most 10000 N on felt"),
        (("finger", "load", 300), "load = 300: expected at most 200 N on finger"),
        (("palm", "load", 3000), "load = 3000: expected at most 2000 N on palm"),
        (("felt", "by_position", 0.5), "by_position = 0.5: expected it beside an object that touches"),
        (("felt", "striker", "steel"), "striker: no such key"),
        ((), "what is missing: expected /object/NAME/rest what [position] [key value ...]"),
        ((3,), "what = 3: expected a name"),
    ],
)
def test_refusals_name_the_culprit(played, given, reason):
    assert refusal(played, "/object/cup/rest", *given).startswith(reason)


def test_an_object_that_has_a_supports_name_is_meant(played):
    say(played, "/object/new", "table", "wood-board")
    assert say(played, "/object/cup/rest", "table") == []
    played.engine.process(64)
    (contact,) = resting(played)
    assert contact["point"][1]["slot"] == played.objects["table"].handle.slot


LEVELS = ("-50", "-60")


@pytest.mark.slow
@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("under", SUPPORTS)
def test_a_glass_plate_that_lies_on_something_rings_shorter(level, under):
    def fall(lines):
        """Return by how many dB the sound falls from 50 to 350 ms after the blow."""
        score = f"0 /accuracy {level}\n0 /object/new a glass-plate\n{lines}0.2 /object/a/impact 0.5 0.3\n"
        sound = carom.render(score, seconds=0.7).samples.astype(float)
        first, last = (np.square(sound[int(48_000 * t) : int(48_000 * (t + 0.1))]).mean() for t in (0.25, 0.55))
        return 10 * np.log10(first / last)

    assert fall(f"0 /object/a/rest {under} 0.2\n") > fall("") + 1.0


def test_a_scene_an_object_and_a_score_rest_alike():
    lines = (
        "0 /object/new a glass-plate\n0 /object/new b wood-board\n0 /object/a/rest b 0.2 load 5 id x\n"
        "0 /object/a/impact 0.5\n0.1 /gesture/x/load 1\n0.2 /gesture/x/stop\n"
    )
    with carom.Scene() as scene:
        plate, board = scene.new("a", "glass-plate"), scene.new("b", "wood-board")
        plate.rest(board.name, 0.2, load=5, id="x")
        plate.impact(0.5)
        scene.steer("x", load=1, at=0.1)
        scene.stop("x", at=0.2)
        sound = scene.render(seconds=0.3).samples
    assert np.array_equal(sound, carom.render(lines, seconds=0.3).samples) and sound.any()


def test_a_load_is_steered_as_far_as_one_may_begin(played):
    for id, what, *keys in (("tip", "finger"), ("pad", "felt", "mass", 1e-6), ("foot", "pane", 0.2)):
        assert say(played, "/object/cup/rest", what, *keys, "id", id) == []
    refused = refusal(played, "/gesture/tip/load", 300.0)
    assert refused.startswith("load = 300: expected at most 200 N of tip")
    assert refusal(played, "/gesture/pad/load", 2_000.0, "over", 1.0).startswith("load = 2000: expected at most 1000 N")
    assert refusal(played, "/gesture/*/load", 300.0).startswith("load = 300: expected at most 200 N of tip")
    assert say(played, "/gesture/tip/load", 200.0) == say(played, "/gesture/foot/load", 1e5) == []
