"""Plates whose modes are coupled, under a hand: they come to rest, and their bend is not heard."""

import numpy as np
import pytest

import carom


@pytest.mark.slow
def test_a_plate_under_a_hand_makes_no_sound():
    """The bend's own energy counts: without it stretching gave beyond that, and cymbals roared under a hand: pressure
    changed by 0.03 Pa in a sample."""
    with carom.Scene(48_000, calibrated=True) as scene:
        scene.new("a", "splash-cymbal").press(20.0, position=0.4, striker="felt")
        sound = scene.render(1.5).samples.sum(axis=1, dtype=float)
    assert 0.0 < np.abs(np.diff(sound)).max() < 1e-3


@pytest.mark.slow
def test_a_flat_sheet_under_a_hand_comes_to_rest():
    """Stretching gets nothing of the hand's own work: the sheet roared at 0.8 Pa for as long as that lay there."""
    with carom.Scene(48_000, calibrated=True) as scene:
        scene.new("a", "thunder-sheet").press(100.0, position=0.4, striker="hand")
        sound = scene.render(2.0).samples.sum(axis=1, dtype=float)
    touched, left = sound[2_400:14_400].std(), sound[-12_000:].std()
    assert 0.0 < left < 0.2 * touched


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rate", "force", "position", "striker", "left"),
    [
        (8_000, 100.0, 0.4, "felt", -35.0),
        (16_000, 20.0, 0.4, "felt", -70.0),
        (48_000, 100.0, 0.4, "felt", -65.0),
        (48_000, 20.0, 0.9, "steel", -60.0),
    ],
)
def test_cymbal_under_a_hand_dies_away(rate, force, position, striker, left):
    """The splash sounded on, 0 to 26 dB under the most that there was: stretching pulled at nothing now and then, and
    modes that exchange energy took half of a kick, which a bent mode gets at every sample, for its motion."""
    with carom.Scene(rate, calibrated=True) as scene:
        cymbal = scene.new("a", "splash-cymbal", stand=1.0)
        cymbal.impact(1.0, position=0.7)
        cymbal.press(force, position=position, striker=striker, at=0.1)
        sound = scene.render(3.0).samples.sum(axis=1, dtype=float)
    powers = [np.var(part) for part in np.split(sound, 30)]
    assert 10 * np.log10(max(powers[28:]) / max(powers)) < left


@pytest.mark.slow
def test_all_that_kicks_bend_is_taken_from_the_sound():
    """Kicks bend a mode by a little less than a steady force does, (theta/2)/tan(theta/2): 27 mPa stayed in the sound
    for as long as a hand lay on a splash. The rest is of clicks, which this does not take out."""
    with carom.Scene(48_000, calibrated=True) as scene:
        scene.new("a", "splash-cymbal").press(100.0, position=0.4, striker="felt")
        sound = scene.render(1.5).samples.sum(axis=1, dtype=float)
    assert abs(sound[-9_600:].mean()) < 0.022
