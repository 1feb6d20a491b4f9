"""Ground truth: the contacts as played, and each object's stem."""

import numpy as np
import pytest

import carom
from carom.clients.contacts import Striking, assemble
from carom.dsp.engine.memory.state import TRACE
from carom.presets import Presets

RATE = 1000.0


def trace(*entries):
    return np.array(
        [(entry[0], 0, entry[1], 0, 0.5, 1.0, 0.8, *entry[2:], 0.0, 1.0, 0, 0, -1, 0.0, 1.0, 1.0) for entry in entries],
        TRACE,
    )


def test_entries_are_assembled_into_contacts_by_start():
    said = {7: Striking("bell", "", "ding", "impact", 0.2), 9: Striking("bell", "cup", "", "bounce")}
    entries = trace(
        (9, 3, 120, 120.5, 121.0, 0.2),
        (7, 4, 119, 119.25, 120.0, 0.1),
        (9, 3, 121, 121.0, 121.75, 0.3),
        (7, 4, 120, 120.0, 121.0, 0.4),
        (7, 5, 122, 122.5, 122.6, 0.2),
        (7, 6, 122, 122.8, 122.9, 0.2),
    )
    first, second, *again = assemble(entries, RATE, 100, said.__getitem__)
    assert (first.object, first.striker, first.id, first.gesture) == ("bell", "", "ding", "impact")
    assert (second.object, second.striker, second.id, second.gesture) == ("bell", "cup", "", "bounce")
    assert first.start == pytest.approx(0.11925) and first.duration == pytest.approx(1.75e-3)
    assert (first.position, first.speed, first.velocity, first.mass) == (0.5, 1.0, 0.8, 0.2)
    assert first.first == 20 and first.impulse == pytest.approx(0.5) and first.peak == pytest.approx(400.0)
    np.testing.assert_allclose(first.force, [100.0, 400.0])
    assert [each.start for each in again] == pytest.approx([0.1225, 0.1228])
    assert [each.impulse for each in again] == pytest.approx([0.2, 0.2])
    np.testing.assert_allclose(second.force, [200.0, 300.0])
    assert assemble(trace(), RATE, 0, said.__getitem__) == ()


SCORE = """
0      /object/new a steel-plate
0      /object/new b ceramic-tile pan -1
0.0101 /object/a/impact 1.0 mass 1e-6 stiffness 1e9 dissipation 0 exponent 1.5 id tick gain -20
0.1    /object/b/bounce 0.02 striker ping-pong
0.15   /object/a/impact 0.45 by b
"""


def test_contacts_are_told_as_they_were_played():
    sound = carom.render(SCORE, seconds=0.4, contacts=True)
    contacts = sound.contacts
    assert contacts is not None and len(contacts) == sound.report.contacts > 3
    tick = contacts[0]
    assert (tick.object, tick.striker, tick.id, tick.gesture) == ("a", "", "tick", "impact")
    # A light striker without loss leaves as fast as it came, after Hertz's 2.9432 x/v, x = (5 m v^2/(4 k))^(2/5).
    assert tick.impulse == pytest.approx(2e-6, rel=1e-3)
    assert tick.start == pytest.approx(0.0101, abs=1e-9)
    assert tick.duration == pytest.approx(2.9432 * (1.25e-6 / 1e9) ** 0.4, rel=1e-3)
    assert (tick.speed, tick.mass, tick.position) == (1.0, 1e-6, 0.265)
    assert {(c.object, c.striker, c.gesture) for c in contacts[1:]} == {("b", "", "bounce"), ("a", "b", "impact")}
    for contact in contacts:
        assert contact.impulse == pytest.approx(contact.force.sum() / 48_000)
        assert contact.first == int(contact.start * 48_000) + 1 and contact.duration > 0.0


def test_striker_that_a_yielding_object_catches_up_with_strikes_again():
    """A ball on a sheet of polycarbonate stops, and the sheet swings back: two contacts, each with its own figures.

    As in an independent model, by Ritz's method with Legendre's polynomials and DOP853: 0.95 ms, and 0.35 ms from
    1.47 ms on, at 0.17 m/s, with 0.095 of the first one's impulse.
    """
    score = "0 /object/new a polycarbonate-sheet\n0.01 /object/a/impact 1.5 0.583 striker plastic mass 0.0123 id x"
    sound = carom.render(score, seconds=0.1, contacts=True)
    one, other = sound.contacts
    assert sound.report.contacts == 2 and one.id == other.id == "x"
    assert (one.start, one.speed, one.velocity) == (0.01, 1.5, 1.5)
    assert one.duration == pytest.approx(0.95e-3, rel=0.02)
    assert other.start == pytest.approx(0.01147, abs=0.05e-3) and other.duration == pytest.approx(0.35e-3, rel=0.1)
    assert other.speed == pytest.approx(0.15, abs=0.03)
    assert other.velocity == pytest.approx(1.5 - one.impulse / one.mass, rel=1e-6)
    assert other.impulse == pytest.approx(0.09 * one.impulse, rel=0.1)


def test_a_sheet_of_polycarbonate_is_struck_once_by_default():
    velocity = Presets().object("polycarbonate-sheet").velocity
    for factor in (0.3, 1.0, 2.0):
        score = f"0 /object/new a polycarbonate-sheet\n0 /object/a/impact {factor * velocity}"
        assert len(carom.render(score, seconds=0.1, contacts=True).contacts) == 1


def test_contacts_of_cut_sounds_are_those_of_the_whole():
    def play(scene):
        scene.new("a", "steel-plate").impact(0.5, at=0.01, striker="felt")
        return scene

    with carom.Scene(contacts=True) as scene:
        (whole,) = play(scene).render(frames=2000).contacts
    with carom.Scene(contacts=True) as scene:
        play(scene)
        parts = [contact for _ in range(20) for contact in scene.render(frames=100).contacts]
    np.testing.assert_array_equal(np.concatenate([part.force for part in parts]), whole.force)
    assert len(parts) > 1 and sum(part.impulse for part in parts) == pytest.approx(whole.impulse)


def test_stems_add_up_to_the_sound():
    quieter = f"0 /gain -6\n{SCORE}"  # the limiter has nothing to do
    sound = carom.render(quieter, seconds=0.4, stems=True)
    assert set(sound.stems) == {"a", "b"} and sound.report.limited == ()
    np.testing.assert_allclose(sum(sound.stems.values()), sound.samples, atol=1e-6)
    alone = carom.render("\n".join(quieter.splitlines()[:5]), seconds=0.1)
    np.testing.assert_allclose(sound.stems["a"][:4800], alone.samples, atol=1e-7)
    assert np.abs(sound.stems["b"][:, 0]).max() > 1e-4 and np.abs(sound.stems["b"][:, 1]).max() < 1e-6


def test_stems_of_cut_sounds_are_those_of_the_whole():
    def play(scene):
        scene.new("a", "wood-block").impact(0.5, at=0.01)
        scene.free("a", at=0.02)
        scene.new("a", "marimba-bar", at=0.03)
        scene.impact("a", 0.5, at=0.035)
        return scene

    with carom.Scene(stems=True) as scene:
        whole = play(scene).render(frames=3000).stems["a"]
    with carom.Scene(stems=True) as scene:
        play(scene)
        parts = [scene.render(frames=100).stems.get("a", np.zeros((100, 2), np.float32)) for _ in range(30)]
    assert np.abs(whole).max() > 0.01
    np.testing.assert_array_equal(np.concatenate(parts), whole)


def test_the_blows_of_a_swarm_are_added_up_where_its_places_take_turns():
    sound = carom.render("0 /object/new pan iron-pan\n0 /object/pan/rain 3000", seconds=0.03, contacts=True)
    (rain,) = sound.contacts
    said = {2: Striking("pan", "", "", "rain")}
    entries = trace((2, 1, 105, 105.0, 106.0, 0.2), (2, 1, 108, 108.0, 109.0, 0.1), (2, 1, 101, 101.0, 102.0, 0.3))
    (placed,) = assemble(np.concatenate([entries, entries[:1]]), RATE, 100, said.__getitem__)
    assert placed.first == 2 and placed.start == pytest.approx(0.101) and placed.duration == pytest.approx(8e-3)
    np.testing.assert_allclose(placed.force, [300.0, 0, 0, 0, 400.0, 0, 0, 100.0])
    assert rain.force.sum() / 48_000 == pytest.approx(rain.impulse)
    assert np.flatnonzero(rain.force)[0] == 0 and rain.start * 48_000 == pytest.approx(rain.first - 1, abs=1)


def test_a_rest_says_where_the_other_is_touched_and_what_it_is():
    with carom.Scene(contacts=True) as scene:
        for name, preset in (("pane", "glass-plate"), ("pan", "iron-pan")):
            scene.new(name, preset)
        scene.rest("pane", "pan", by_position=0.3, at=0.0)
        scene.impact("pane", 0.5, at=0.02)
        (rest,) = [each for each in scene.render(0.1).contacts if each.gesture == "rest"]
    assert (rest.object, rest.striker, rest.by_position) == ("pane", "pan", 0.3)
