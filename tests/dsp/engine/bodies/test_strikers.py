"""Strikers that sound: with the object that they strike, by the contact's force, until they have rung out."""

import math

import numpy as np
import pytest

from carom.dsp import contact
from carom.dsp.bodies import acceleration
from carom.dsp.bodies.modes import Modes
from carom.dsp.bodies.striker import Ringing, Snap, StrikerSound
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.engine.memory.striker_state import STRIKERS, VOICES
from carom.dsp.runtime.engine import Engine
from tests.dsp.engine.support import HARD, RATE, active, bell, free, gesture, impact, panic, setting, stop
from tests.dsp.engine.test_clicks import answer_of, sphere_by_quadrature, steel

RADIUS = 0.008
BALL = steel(RADIUS)
BALL_SOUND = StrikerSound(BALL[0], acceleration.sphere(BALL[0], RADIUS), RADIUS)
RING = Ringing((9000.0, 12_000.0), (500.0, 400.0), (30.0, 20.0), 900.0)
PING_PONG = (0.0027, 3.8e4, 0.1, 1.0)
SNAP = Snap(1e-4, 1.86, 0.0, 4e-4)
SHELL = StrikerSound(0.0027, None, 1.0, RING)


def wall(engine, level=1.0, **settings):
    """Return an object that is struck and neither moves nor sounds."""
    modes = Modes(np.array([440.0]), np.array([50.0]), np.full((1, 1), 1e-9), np.zeros((2, 1)), 1e9)
    return engine.add(modes, level, **settings)


def started(rate=RATE):
    return Engine(rate)


def sound_of(*commands, engine, frames=2048):
    engine.send(commands)
    return engine.process(frames).astype(float)


@pytest.mark.slow
@pytest.mark.parametrize("mass", [1.0, 1.7])
def test_a_ball_clicks_as_koss_and_alfredson_say(mass):
    """The click agrees at each sample, also with another mass than its own: it is accelerated less."""
    engine = started()
    law = (mass * BALL[0], *BALL[1:])
    sound = sound_of(impact(wall(engine), law, 100.37, **engine.lay_out_striker(BALL_SOUND)), engine=engine, frames=512)
    exact = sphere_by_quadrature(law, 1.0, RADIUS, (np.arange(512) - 100.37) / RATE, answer_of(RADIUS))
    np.testing.assert_allclose(sound[:, 0], exact, atol=2e-6 * np.abs(exact).max())
    np.testing.assert_allclose(sound[:, 0], sound[:, 1], atol=1e-12)


def test_a_ball_that_is_an_object_clicks_alike():
    """An object that strikes clicks by its own bank, and a striker by a voice: with the same sound."""
    engine = started()
    other = engine.add(
        Modes(np.empty(0), np.empty(0), np.empty((1, 0)), np.empty((2, 0)), BALL[0], (BALL_SOUND.click,))
    )
    by_object = sound_of(impact(wall(engine), BALL, 100.0, by=other), engine=engine)
    engine = started()
    by_voice = sound_of(impact(wall(engine), BALL, 100.0, **engine.lay_out_striker(BALL_SOUND)), engine=engine)
    np.testing.assert_allclose(by_voice, by_object, atol=1e-7 * np.abs(by_object).max())


@pytest.mark.parametrize("level", [0.05, 2.0])
def test_striker_has_the_level_gain_place_and_stem_of_its_object(level):
    """The striker has the object's level, gain, place and stem."""
    engine = started()
    values = engine.lay_out_striker(BALL_SOUND)
    plain = sound_of(impact(wall(engine), BALL, 100.0, **values), engine=engine)
    engine = started()
    engine.stems.keep(True)
    handle = wall(engine, level, gain=0.5, pan=-1.0)
    engine.send([impact(handle, BALL, 100.0, **engine.lay_out_striker(BALL_SOUND))])
    stems = []
    for _ in range(2048 // QUANTUM):
        sound = engine.process(QUANTUM)
        stems.append(engine.stems.shares()[handle.slot].T.copy())
        np.testing.assert_allclose(sound, stems[-1], atol=1e-6)
    expected = plain * [0.5 * level * math.sqrt(2), 0]
    np.testing.assert_allclose(np.concatenate(stems), expected, atol=1e-6 * level)


def test_modes_of_a_striker_ring_by_its_force():
    """A short blow moves each by its momentum; heard is its velocity: weight exp(-sigma t) (cos - sigma/omega sin)."""
    engine = started()
    law = (1e-6, 1e14, 0.1, 1.5)
    sound = StrikerSound(1e-6, None, 1.0, RING)
    heard = sound_of(impact(wall(engine), law, 100.5, **engine.lay_out_striker(sound)), engine=engine, frames=512)[:, 0]
    t = np.arange(101 - 100.5, 400)[:, None] / RATE
    frequency, decay, weight = map(np.array, _columns(RING))
    omega = 2 * np.pi * frequency
    momentum = 1e-6 * (1.0 - contact.release_velocity(1.0, 0.1))
    exact = momentum * (weight * np.exp(-decay * t) * (np.cos(omega * t) - decay / omega * np.sin(omega * t))).sum(
        axis=1
    )
    np.testing.assert_allclose(heard[101:501], exact, atol=0.01 * np.abs(exact).max())


def test_striker_that_a_force_bends_slowly_is_not_heard():
    engine = started()
    law = (0.1, 1e4, 0.1, 1.0)  # 10 ms
    slow = sound_of(impact(wall(engine), law, 100.0, **engine.lay_out_striker(SHELL)), engine=engine, frames=4800)
    push = math.sqrt(0.1 * 1e4) / 0.1  # N of its greatest force, per kg
    bent = 0.0027 * push * (np.array(RING.weight) / (2 * np.pi * np.array(RING.frequency))).sum()
    assert np.abs(slow).max() < 0.05 * bent


def _columns(ringing):
    return ringing.frequency, ringing.decay, ringing.weight


def test_rolling_striker_clicks_by_the_force_that_the_object_feels():
    engine = started()
    rolling = dict(speed=0.5, radius=RADIUS, seed=3.0, number=1)
    heard = {}
    for name in ("object", "voice"):
        engine = started()
        click = Modes(np.empty(0), np.empty(0), np.empty((1, 0)), np.empty((2, 0)), 1.0, (BALL_SOUND.click,))
        handle = engine.add(click) if name == "object" else wall(engine)
        values = engine.lay_out_striker(BALL_SOUND) if name == "voice" else {}
        heard[name] = sound_of(gesture("roll", handle, BALL, 100.0, **rolling, **values), engine=engine, frames=9600)
    assert np.abs(heard["object"]).max() > 1e-6
    np.testing.assert_allclose(heard["voice"], heard["object"], atol=1e-6 * np.abs(heard["object"]).max())


def test_rolling_striker_clicks_as_large_as_it_is():
    engine = started()
    larger = StrikerSound(BALL[0], acceleration.sphere(BALL[0], 2 * RADIUS), 2 * RADIUS)
    heard = []
    for sound in (BALL_SOUND, larger):
        engine = started()
        values = engine.lay_out_striker(sound)
        roll = gesture("roll", wall(engine), BALL, 100.0, 1, speed=0.5, radius=2 * RADIUS, seed=3.0, **values)
        heard.append(sound_of(roll, engine=engine, frames=4800))
    np.testing.assert_allclose(heard[0], heard[1], atol=1e-6 * np.abs(heard[1]).max())


def voices(engine):
    return int(engine.state["voices_active"][0])


def test_a_voice_lasts_until_it_has_rung_out_and_the_object_with_it():
    engine = started()
    handle = wall(engine)
    engine.send([impact(handle, BALL, 10.0, **engine.lay_out_striker(SHELL))])
    engine.process(2 * QUANTUM)
    engine.send([free(handle, at_once=False)])
    engine.process(QUANTUM)
    assert voices(engine) == 1 and engine.stats.sounding == 1 and not engine.quiet()
    engine.process(4800)
    assert voices(engine) == 0 and engine.quiet() and active(engine) == 0


def test_a_panic_ends_voices():
    engine = started()
    engine.send([impact(wall(engine), BALL, 10.0, **engine.lay_out_striker(SHELL))])
    engine.process(2 * QUANTUM)
    engine.send([panic()])
    engine.process(round(0.5 * RATE))
    assert voices(engine) == 0 and not engine.process(QUANTUM).any()


def test_a_bounce_has_a_voice_at_every_contact():
    engine = started()
    values = engine.lay_out_striker(SHELL)
    engine.send([gesture("bounce", wall(engine), (0.0027, 3.8e4, 0.2, 1.0), 0.0, 1, velocity=0.5, seed=1.0, **values)])
    seen = []
    for _ in range(600):
        impacts = engine.stats.impacts
        engine.process(QUANTUM)
        if engine.stats.impacts > impacts:
            seen.append(voices(engine))
    assert len(seen) > 5 and set(seen) == {1} and voices(engine) <= 1


def test_quietest_voice_is_cut_and_counted_where_all_are_taken():
    engine = started()
    handle = wall(engine)
    values = engine.lay_out_striker(SHELL)
    engine.send(
        [
            impact(handle, HARD, 10.0, velocity=1.0 + n / VOICES, gain=0.1 if n == 7 else 1.0, **values)
            for n in range(VOICES)
        ]
    )
    engine.process(2 * QUANTUM)
    assert voices(engine) == VOICES and engine.stats.strikers_cut == 0
    before = {int(each["loudness"] * 1e12) for each in engine.state["voices"][0]}
    engine.send([impact(handle, HARD, velocity=2.0, **values)])
    engine.process(QUANTUM)
    after = {int(each["loudness"] * 1e12) for each in engine.state["voices"][0]}
    assert voices(engine) == VOICES and engine.stats.strikers_cut == 1
    assert min(before) < 0.1 * sorted(before)[1] and min(after) > 5 * min(before)


def test_kinds_are_kept_by_what_they_are_and_make_room_for_others():
    engine = started()
    kinds = [StrikerSound(1e-3 * (n + 1), acceleration.sphere(1e-3, 0.01)) for n in range(STRIKERS)]
    laid_out = [engine.lay_out_striker(kind) for kind in kinds]
    assert [engine.lay_out_striker(kind) for kind in kinds] == laid_out
    assert len({each["sound"] for each in laid_out}) == STRIKERS
    engine.send([impact(wall(engine), BALL, 1000.0, **laid_out[0])])
    assert engine.lay_out_striker(BALL_SOUND)["sound"] == laid_out[0]["sound"]
    assert np.abs(engine.process(2048)).max() < 1e-12 and engine.stats.strikers_cut == 1  # it would be another's click
    assert engine.lay_out_striker(kinds[0]) != laid_out[0]


def test_rolling_striker_keeps_its_place_however_many_others_are_asked_for():
    engine = started()
    rolls = engine.lay_out_striker(BALL_SOUND)
    engine.send([gesture("roll", engine.add(bell(), 1.0), BALL, 0.0, 1, speed=0.5, radius=RADIUS, seed=3, **rolls)])
    engine.process(QUANTUM)
    others = [StrikerSound(1e-3 * (n + 1), acceleration.sphere(1e-3, 0.01)) for n in range(2 * STRIKERS)]
    assert rolls["sound"] not in {engine.lay_out_striker(other)["sound"] for other in others}
    engine.process(QUANTUM)
    engine.send([stop(1)])
    engine.process(24_000)
    assert engine.stats.contacts_active == 0 and rolls["sound"] in {
        engine.lay_out_striker(other)["sound"] for other in others
    }


def snap_of(velocity, snap=SNAP):
    """Return the energy of the sound of a second pulse."""
    engine = started()
    values = engine.lay_out_striker(StrikerSound(0.0027, None, 1.0, RING, snap))
    return float((sound_of(impact(wall(engine), PING_PONG, 100.0, velocity, **values), engine=engine) ** 2).sum())


def test_a_second_pulse_grows_as_its_power_of_the_velocity():
    levels = 10 * np.log10([snap_of(v) for v in (0.1, 0.3, 1.0)])
    np.testing.assert_allclose(np.diff(levels), 20 * 1.86 * np.diff(np.log10([0.1, 0.3, 1.0])), atol=0.05)


def test_a_second_pulse_is_a_blow_to_the_modes_at_its_time():
    """The pulse goes to them alone: the click is what it is without."""
    snap = Snap(1e-5, 0.0, 0.0, 3.7 / RATE)
    heard = []
    for sound in (StrikerSound(0.0027, BALL_SOUND.click, RADIUS, RING, snap), StrikerSound(0.0027, BALL_SOUND.click)):
        engine = started()
        one = impact(wall(engine), PING_PONG, 100.0, **engine.lay_out_striker(sound))
        heard.append(sound_of(one, engine=engine, frames=512)[:, 0])
    t = np.maximum(np.arange(512) - 103.7, 0)[:, None] / RATE
    frequency, decay, weight = map(np.array, _columns(RING))
    exact = 1e-5 * (weight * np.exp(-decay * t) * np.sin(2 * np.pi * frequency * t)).sum(axis=1)
    loudest = np.abs(exact).max() + np.abs(heard[1]).max()
    np.testing.assert_allclose(heard[0] - heard[1], exact, atol=1e-6 * loudest)


def test_second_pulses_scatter_and_equal_blows_are_equal():
    snap = Snap(1e-6, 0.0, 2.8, 0.0)
    energies = [snap_of(1.0 + 1e-3 * n, snap=snap) for n in range(60)]
    level = 10 * np.log10(energies)
    assert np.std(level) == pytest.approx(2.8, abs=0.7)
    assert snap_of(1.0, snap=snap) == energies[0]


@pytest.mark.parametrize(("irregularity", "scatter"), [(0.0, (0.0, 0.1)), (0.3, (1.0, 6.0))])
def test_second_pulses_of_a_round_body_that_bounces_fall_with_its_velocity(irregularity, scatter):
    """A round body lands on the same spot; one that turns lands on others."""
    engine = started()
    engine.trace(True)
    values = engine.lay_out_striker(StrikerSound(0.0027, None, 1.0, RING, Snap(1e-6, 1.86, 2.8, 4e-4)))
    values |= {"velocity": 1.0, "irregularity": irregularity, "seed": 3}
    bounce = gesture("bounce", wall(engine), PING_PONG, 100.0, 7, **values)
    sound = sound_of(bounce, engine=engine, frames=48_000)[:, 0]
    entries = engine.traced()
    begins = np.unique(entries["contact"], return_index=True)[1]
    times, speeds = entries["begin"][begins].astype(int), entries["speed"][begins]
    energies = [(sound[time : time + 2_000] ** 2).sum() for time in times if time < 46_000]
    levels = 10 * np.log10(energies) - 1.86 * 20 * np.log10(speeds[: len(energies)])
    assert len(levels) > 4 and scatter[0] <= np.std(levels) < scatter[1]


def test_a_second_pulse_gives_no_more_than_the_contact_takes():
    """The modes get what a wall takes from the striker, however strong the pulse was said to be."""
    engine = started()
    values = engine.lay_out_striker(StrikerSound(0.0027, None, 1.0, RING, Snap(1.0, 2.0, 0.0, 2e-3)))
    engine.send([impact(wall(engine), PING_PONG, 10.0, **values)])
    engine.process(QUANTUM)
    voice = engine.state["voices"][0][-1]
    e = engine.state["contacts"][0][voice["contact"]]["pulse"]["restitution"]
    assert voice["snap"] ** 2 * RING.mobility / 2 == pytest.approx((1 - e**2) * 0.0027 / 2)


def test_settings_of_the_objects_modes_leave_its_strikers():
    heard = []
    for name, value in (("tune", 1.0), ("tune", 2.0), ("decay", 0.01), ("damp", 1.0)):
        engine = started()
        handle = wall(engine)
        engine.send([setting(handle, name, value)])
        heard.append(sound_of(impact(handle, BALL, 100.0, **engine.lay_out_striker(SHELL)), engine=engine))
    for each in heard[1:]:
        np.testing.assert_array_equal(each, heard[0])


def test_a_striker_clicks_by_all_of_its_blow_however_much_it_rings():
    """Modes that radiate nothing leave the click as it is without modes: all of the momentum moves the striker. By what
    these modes are left of the blow it was 0.06 of that."""
    heard = []
    for modes in (None, Ringing((9000.0, 12_000.0), (500.0, 400.0), (0.0, 0.0), 40.0 / BALL[0])):
        engine = started()
        values = engine.lay_out_striker(BALL_SOUND._replace(ringing=modes))
        heard.append(sound_of(impact(wall(engine), BALL, 100.5, **values), engine=engine))
    np.testing.assert_array_equal(*heard)
    assert np.abs(heard[0]).max() > 0.0
