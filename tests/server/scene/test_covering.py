"""Hands and pads that cover an area: no mode is spared, and a heavy body loses little."""

import numpy as np
import pytest

import carom
from carom.presets.supports import SUPPORTS
from tests.server.scene.support import ends, say, seconds

FIRM = 50.0
"""N: of a firm hand."""


def held(session, name="cup"):
    """Return the decay (1/s) that what covers an object adds to its modes."""
    obj = session.engine.objects[session.objects[name].handle.slot]
    return session.engine.state["bank"][0]["held"][obj["first"] : obj["first"] + obj["felt"]].copy()


def level(samples, at):
    """Return the level (dB) of 50 ms from a time (s) on."""
    first = int(48_000 * at)
    return 10.0 * np.log10(np.square(samples[first : first + 2_400].astype(float)).mean() + 1e-30)


def fall(preset, rest):
    """Return by how many dB an object falls in half a second after a hand was laid on it."""
    score = f"0 /object/new a {preset}\n0 /object/a/impact\n{rest}"
    samples = carom.render(score, seconds=1.1).samples
    return level(samples, 0.45) - level(samples, 1.0)


@pytest.mark.parametrize("preset", ["steel-plate", "crash-cymbal", "iron-pan", "wine-glass", "mug"])
def test_a_firm_hand_mutes_bodies_of_some_kilograms_wherever_it_lies(preset):
    for place in ("", 0.1, 0.4, 0.5, 0.75):
        assert fall(preset, f"0.5 /object/a/rest palm {place} load {FIRM}\n") > 20.0, place


def test_a_church_bell_falls_as_slowly_as_its_mass_says():
    more = fall("church-bell", f"0.5 /object/a/rest palm load {FIRM}\n") - fall("church-bell", "")
    resistance, mass = SUPPORTS["palm"].dissipation * FIRM, 500.0
    assert more == pytest.approx(0.5 * resistance / (2 * mass) * 20 / np.log(10), abs=0.3)


@pytest.mark.parametrize("support", ["palm", "felt", "foam"])
def test_each_mode_loses_the_resistance_over_twice_the_mass(played, support):
    law = SUPPORTS[support]
    say(played, "/object/new", "bell", "church-bell")
    say(played, "/object/bell/rest", support, "load", 20.0, "id", "one")
    seconds(played, 2.0)
    assert np.allclose(held(played, "bell"), law.dissipation * 20.0 / (2.0 * played.objects["bell"].mass))


def test_hands_add_up_are_steered_and_leave(played):
    played.engine.process(64)
    used = played.engine.state["objects"][0]["used"].sum()
    say(played, "/object/pane/rest", "palm", 0.3, "load", 10.0, "id", "one")
    seconds(played, 2.0)
    alone = held(played, "pane")
    assert (alone > 0.0).all()
    say(played, "/object/pane/rest", "palm", 0.3, "load", 10.0, "id", "two")
    say(played, "/gesture/one/load", 30.0)
    seconds(played, 2.0)
    assert np.allclose(held(played, "pane"), 4.0 * alone, rtol=1e-5)
    say(played, "/gesture/one/stop")
    seconds(played, 0.1)
    assert np.allclose(held(played, "pane"), alone, rtol=1e-5)
    say(played, "/gesture/two/position", 0.6)
    seconds(played, 2.0)
    assert not np.allclose(held(played, "pane"), alone, rtol=0.1)
    say(played, "/panic")
    seconds(played, 0.1)
    assert not held(played, "pane").any()
    assert sorted(id for id, _ in ends(played)) == ["one", "two"]
    assert played.engine.state["objects"][0]["used"].sum() == used


def test_a_press_of_a_hand_covers_as_much_and_ends_once(played):
    say(played, "/object/pane/press", 10.0, 0.3, "striker", "hand", "id", "one")
    seconds(played, 2.0)
    assert (held(played, "pane") > 0.0).all()
    say(played, "/gesture/one/force", 20.0)
    before = held(played, "pane")
    seconds(played, 2.0)
    assert np.allclose(held(played, "pane"), 2.0 * before, rtol=1e-5)
    say(played, "/gesture/one/stop")
    seconds(played, 1.0)
    assert not held(played, "pane").any()
    assert [id for id, _ in ends(played)] == ["one"]
    say(played, "/object/pane/press", 10.0, 0.3, "striker", "fingertip", "id", "one")
    seconds(played, 0.2)
    assert not held(played, "pane").any()


def test_a_law_of_its_own_touches_at_a_point(played):
    say(played, "/object/cup/rest", "palm", "stiffness", 1e6, "id", "one")
    seconds(played, 0.1)
    assert not held(played).any()
