"""Slides in the engine: what is bowed sings, what is scraped hisses, and a slide without slip is a roll."""

from itertools import pairwise

import numpy as np
import pytest

from carom.dsp.bodies import listed
from carom.dsp.engine.memory.state import End
from carom.dsp.runtime.engine import NOW, Engine
from tests.dsp.engine.support import RATE, bell, gesture, numbered, steer, stop, strike

TIP = (0.02, 3e8, 0.5, 1.5)
"""m, k, mu, a of a hard tip."""
SCRAPE = {"speed": 0.2, "sweep": -1.0, "force": 0.5, "radius": 5e-4, "patch": 0.0, "static": 0.0, "dynamic": 0.0,
          "stribeck": 0.1, "tangential": 0.0, "along": 0.0, "seed": 1}  # fmt: skip
BOW = {**SCRAPE, "radius": 0.01, "roughness": 0.0, "sweep": 0.0, "speed": 0.1, "force": 5.0, "static": 0.8,
       "dynamic": 0.3, "along": 1.0}  # fmt: skip
CREAK = {**BOW, "tangential": 1e5}
STEEP = (3e-7, 1e-3, 2.4, 0.0, 1.0, 0.0, 1.0)


LIGHT = bell(24, t60=0.3, modal_mass=0.05)


def glass(rate=RATE):
    return listed(
        frequency=[620.0, 1480.0, 2690.0], t60=[1.5, 1.0, 0.5], modal_mass=[0.06, 0.08, 0.1], mass=0.3, top=0.4 * rate
    )


def slid(seconds, modes=None, rate=RATE, surface=STEEP, events=(), **keys):
    """Return the left output of a slide, the engine and the handle of its object."""
    engine = Engine(rate)
    handle = engine.add(modes or glass(rate), 0.05)
    begin = gesture("slide", handle, TIP, 0.0, 7, **{**SCRAPE, **keys})
    engine.send([begin._replace(surface=surface), *events])
    return engine.process(round(seconds * rate))[:, 0].astype(float), engine, handle


def third_octaves(sound, rate, lowest, highest):
    """Return the power (dB) in bands of a third of an octave."""
    spectrum = np.abs(np.fft.rfft(sound)) ** 2 / len(sound) ** 2
    bins = np.arange(len(spectrum)) * rate / len(sound)
    edges = lowest * 2.0 ** (np.arange(int(3.0 * np.log2(highest / lowest)) + 1) / 3.0)
    bands = [spectrum[(bins >= low) & (bins < high)].sum() for low, high in pairwise(edges)]
    return 10.0 * np.log10(bands)


def power_at(sound, rate, frequencies):
    spectrum = np.abs(np.fft.rfft(sound * np.hanning(len(sound)))) ** 2
    bins = np.arange(len(spectrum)) * rate / len(sound)
    near = np.zeros(len(spectrum), bool)
    for frequency in frequencies:
        near |= np.abs(bins - frequency) < 8.0
    return spectrum[near].sum() / spectrum.sum()


def test_a_bowed_glass_sings_just_below_its_lowest_mode():
    sound, _, _ = slid(2.0, **BOW)
    late = sound[48_000:]
    spectrum = np.abs(np.fft.rfft(late * np.hanning(len(late)), 1 << 19))
    pitch = spectrum.argmax() * RATE / (1 << 19)
    assert -20.0 < 1200.0 * np.log2(pitch / 620.0) <= 0.5
    assert power_at(late, RATE, pitch * np.arange(1, 20)) > 0.98
    windows = np.abs(late.reshape(10, -1)).max(axis=1)
    assert windows.min() > 0.9 * windows.max()


def test_without_friction_or_roughness_nothing_is_heard():
    assert np.abs(slid(0.5, roughness=0.0)[0]).max() < 1e-9


@pytest.mark.parametrize("keys", [BOW, SCRAPE, CREAK])
def test_a_slide_that_is_stopped_ends_silent(keys):
    sound, engine, _ = slid(4.0, LIGHT, events=[stop(7, 24_000.0)], **keys)
    assert np.abs(sound[12_000:24_000]).max() > 1e-6
    assert engine.stats.contacts_active == engine.stats.rolls_active == 0
    assert dict(engine.ended()) == {7: End.STOPPED}
    assert np.abs(sound[-4_800:]).max() == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("keys", [BOW, CREAK])
def test_a_bow_that_stops_on_a_body_lets_it_rest(keys):
    """The body sticks to a bow at rest, and the bow's force bends it without a sound."""
    sound, _, _ = slid(6.0, LIGHT, events=[steer(7, "speed", 1e-6, 24_000.0)], **keys)
    assert np.abs(sound[-4_800:]).max() < 1e-3 * np.abs(sound[12_000:24_000]).max()


def test_an_elastic_contact_sounds_otherwise_and_may_be_stiffened_and_softened():
    """The contact changes while it goes on; the limit is a rigid one."""
    rigid, elastic = (slid(1.0, LIGHT, **keys)[0][24_000:] for keys in (BOW, CREAK))
    assert np.std(rigid - elastic) > 0.1 * np.std(rigid)
    events = [steer(7, "tangential", value, 8_000.0 * (n + 1)) for n, value in enumerate((1e7, 1e4, 0.0, 1e6))]
    sound, engine, _ = slid(1.0, LIGHT, events=events, **CREAK)
    assert np.isfinite(sound).all() and engine.stats.faults == 0
    assert 0.0 < np.abs(sound).max() < 3.0 * max(np.abs(rigid).max(), np.abs(elastic).max())


def test_a_slide_without_slip_is_a_roll():
    """One state of contact: the same motion, to the bit."""
    keys = {"radius": 0.01, "seed": 5}
    weight = TIP[0] * 25.0
    slide, _, _ = slid(0.5, speed=0.0, sweep=0.3, force=weight, **{k: v for k, v in keys.items()})
    engine = Engine(RATE)
    handle = engine.add(glass(), 0.05)
    begin = gesture("roll", handle, TIP, 0.0, 7, speed=0.3, gravity=25.0, **keys)
    engine.send([begin._replace(surface=STEEP)])
    np.testing.assert_array_equal(slide, engine.process(24_000)[:, 0])
    assert np.abs(slide).max() > 1e-7


def test_a_second_message_steers_the_slide_that_goes_on():
    sound, engine, handle = slid(0.5, LIGHT, force=5.0)
    again = gesture("slide", handle, TIP, NOW, 7, given=["speed", "force"], **{**SCRAPE, "speed": 0.5, "force": 10.0})
    engine.send([again])
    louder = engine.process(24_000)[:, 0]
    assert dict(engine.ended()) == {7: End.JOINED} and engine.stats.rolls_active == 1
    assert np.std(louder[12_000:]) > 1.3 * np.std(sound[12_000:])


@pytest.mark.slow
def test_levels_follow_speed_and_roughness():
    """Ben Abdelounis et al. 2010: as speed^.7, and as roughness^.8 to 1; a hard tip on a surface of slope 2.4, which it
    hardly ever leaves."""
    modes = bell(60, t60=0.2)

    def level(**keys):
        return np.log(np.mean([np.std(slid(1.0, modes, seed=n, force=5.0, **keys)[0][9_600:]) for n in range(1, 5)]))

    speeds = (0.05, 0.1, 0.2, 0.4)
    by_speed = np.polyfit(np.log(speeds), [level(speed=v) for v in speeds], 1)[0]
    assert by_speed == pytest.approx(0.7, abs=0.1)
    heights = (0.5, 1.0, 2.0)
    by_roughness = np.polyfit(np.log(heights), [level(roughness=r) for r in heights], 1)[0]
    assert 0.8 < by_roughness < 1.01


def test_a_wide_contact_is_dull():
    """The contact averages away what is shorter than itself."""

    modes = bell(60, t60=0.2)

    def treble(**keys):
        """Return the treble over the bass, on average over motions that are chaos."""
        shares = []
        for seed in range(1, 6):
            sound = slid(1.0, modes, seed=seed, **keys)[0]
            spectrum = np.abs(np.fft.rfft(sound[9_600:])) ** 2
            bins = np.arange(len(spectrum)) * RATE / (len(sound) - 9_600)
            shares.append(spectrum[bins > 5_000.0].sum() / spectrum[bins < 1_000.0].sum())
        return np.exp(np.mean(np.log(shares)))

    assert treble(patch=0.002) < 0.3 * treble()


def test_a_scrape_sounds_the_same_at_any_rate():
    levels = []
    for rate in (44_100.0, 48_000.0, 96_000.0):
        modes = listed(
            frequency=np.linspace(300.0, 12_000.0, 40), t60=np.full(40, 0.2), modal_mass=np.full(40, 1.0), mass=10.0,
            top=20_000.0,
        )  # fmt: skip
        levels.append(third_octaves(slid(2.0, modes, rate)[0][int(0.1 * rate) :], rate, 315.0, 10_000.0))
    assert np.ptp(levels, axis=0).max() < 1.0


def test_friction_feels_the_force_of_a_press():
    """The press feels the object: as it rings, so does the normal force. None is felt where the press is gone."""
    engine = Engine(RATE)
    handle = engine.add(LIGHT, 0.05)
    hand = gesture("press", handle, (0.02, 1e5, 5.0, 1.5), 0.0, 8, force=5.0, velocity=0.01)
    engine.send([hand, gesture("slide", handle, TIP, 0.0, 7, **{**BOW, "force": 1e-6, "press": 8})])

    def normal(blocks):
        slide = next(each["roll"] for each in numbered(engine) if each["gesture"] == 7)
        found = []
        for _ in range(blocks):
            engine.process(64)
            found.append(engine.state["slides"][0][slide]["friction"]["normal"][1])
        return np.array(found)

    engine.process(64)
    still = normal(750)[-20:]
    np.testing.assert_allclose(still, 5.0, rtol=0.02)
    strike(engine, handle, velocity=0.5)
    struck = normal(20)
    assert np.std(struck) > 10.0 * np.std(still) and struck.min() >= 0.0
    engine.send([stop(8, NOW)])
    assert np.abs(normal(20)[-5:]).max() == 0.0


def test_an_object_may_bow_another():
    """Friction acts on both: the one that slides, of 2,100 Hz, sings too."""
    engine = Engine(RATE)
    stick = listed(frequency=[2_100.0], t60=[0.3], modal_mass=[0.005], mass=0.01, top=20_000.0)
    by = engine.add(stick, 0.05)
    engine.send([gesture("slide", engine.add(glass(), 0.05), TIP, 0.0, 7, by=by, **BOW, by_position=0.5)])
    sound = engine.process(48_000)[24_000:, 0].astype(float)
    alone = slid(1.0, **BOW)[0][24_000:]
    assert np.isfinite(sound).all() and np.abs(sound).max() < 1.0
    assert not np.allclose(sound, alone, atol=0.1 * np.abs(alone).max())
