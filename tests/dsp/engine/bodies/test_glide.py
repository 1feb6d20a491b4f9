"""Pitch that glides as tension follows what rings, against Kirchhoff's and Carrier's equations."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from carom.dsp.bodies import Modes, listed
from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.resonator.bank import state_of
from carom.dsp.runtime.engine import NOW, Engine
from tests.dsp.engine.support import HARD, gesture, panic, set_limiter, setting, strike

RATE = 48_000
LIGHT = (1e-4, 1e7, 0.0, 1.5)
STICK = (0.01, 3e8, 0.3, 1.5)
FELT = (0.03, 1e5, 0.3, 1.5)


def string(frequencies=(200.0,), t60=1e5, glide=0.0, cone=0.0, modal_mass=0.01) -> Modes:
    """Return the modes that share a tension."""
    modes = listed(frequency=frequencies, t60=[t60] * len(frequencies), modal_mass=modal_mass, mass=0.1, top=20_000)
    return replace(modes, glide=glide, cone=cone)


def place(engine, handle):
    return engine.state["objects"][0][handle.slot]


def energies(engine, handle):
    """Return the energy of each of an object's modes, J."""
    obj = place(engine, handle)
    span = slice(obj["first"], obj["first"] + obj["felt"])
    columns = (engine.state["bank"][name][0][span] for name in ("y1", "y2", "a1", "a2", "weight"))
    return np.array(
        [abs(complex(*state_of(*c[:4])) / c[4]) ** 2 / 2 if c[3] else 0.0 for c in zip(*columns, strict=True)]
    )


def rung_out(engine, handle):
    """Run until the contact ends."""
    engine.process(QUANTUM)
    while engine.stats.contacts_active:
        engine.process(QUANTUM)
    return energies(engine, handle)


def frequency_of(sound, near, rate=RATE):
    """Return the frequency (Hz) of the loudest partial within 20 % of `near`: by the phase between two halves."""
    n = len(sound) // 2
    t, window = np.arange(n) / rate, np.hanning(n)
    guess = near * np.linspace(0.85, 1.3, 400)
    loudest = guess[np.argmax([abs((sound[:n] * window * np.exp(-2j * np.pi * f * t)).sum()) for f in guess])]
    first, second = (
        (part * window * np.exp(-2j * np.pi * loudest * (t + at))).sum()
        for part, at in ((sound[:n], 0.0), (sound[n : 2 * n], n / rate))
    )
    return loudest + np.angle(second / first) / (2 * np.pi * n / rate)


def kirchhoff(frequencies, glide, amplitudes, seconds):
    """Solve for the sum of modes under q_i'' + omega_i^2 (1 + 2 glide V) q_i = 0, V = sum omega_i^2 q_i^2/2, from rest
    at speeds."""
    omega = 2 * np.pi * np.asarray(frequencies)

    def motion(_, state):
        q, v = state.reshape(2, -1)
        potential = 0.5 * (omega**2 * q**2).sum()
        return np.concatenate([v, -(omega**2) * (1 + 2 * glide * potential) * q])

    t = np.arange(round(seconds * RATE)) / RATE
    start = np.concatenate([np.zeros(len(omega)), amplitudes])
    return solve_ivp(motion, (0, seconds), start, "DOP853", t, rtol=1e-10, atol=1e-14).y[: len(omega)] * omega[:, None]


@pytest.mark.slow
@pytest.mark.parametrize("frequencies", [(200.0,), (200.0, 310.0, 543.0)])
def test_pitch_is_kirchhoffs(frequencies):
    """The rise of each partial where the tension rises by 2 %: as far from the exact motion's as the square of that."""
    engine = Engine(RATE)
    handle = engine.add(string(frequencies))
    strike(engine, handle, LIGHT, velocity=1.0)
    found = rung_out(engine, handle)[: len(frequencies)]
    glide = 0.02 / found.sum()
    engine = Engine(RATE)
    handle = engine.add(string(frequencies, glide=glide))
    strike(engine, handle, LIGHT, velocity=1.0)
    found = rung_out(engine, handle)[: len(frequencies)]
    sound = engine.process(RATE // 2)[:, 0].astype(float)
    exact = kirchhoff(frequencies, glide, np.sqrt(2 * found), 0.5)
    for n, frequency in enumerate(frequencies):
        rise, expected = (frequency_of(each, frequency) / frequency - 1 for each in (sound, exact[n]))
        assert expected > 0.01
        assert rise == pytest.approx(expected, rel=0.03)


@pytest.mark.slow
def test_one_mode_alone_rises_by_half_as_much_again():
    """The 3/4 of Duffing's oscillator, where the tension of all modes together would make it 1/2."""
    engine = Engine(RATE)
    handle = engine.add(string(glide=80.0))
    strike(engine, handle, LIGHT, velocity=8.0)
    rise = 80.0 * rung_out(engine, handle).sum()
    assert 0.005 < rise < 0.02
    frequency = frequency_of(engine.process(RATE)[:, 0].astype(float), 200.0)
    assert frequency / 200 - 1 == pytest.approx(0.5 * 1.5 * rise, rel=0.03)


def test_energy_never_grows():
    """Hundreds of retunes, then a strike in the middle of the glide: never more than there was and what it brings."""
    engine = Engine(RATE)
    modes = string(np.linspace(100, 4_000, 64), t60=2.0, glide=80.0, cone=0.1, modal_mass=0.02)
    handle = engine.add(modes)
    retunes = 0
    for velocity in (5.0, 8.0):
        before = energies(engine, handle).sum()
        strike(engine, handle, STICK, velocity=velocity)
        last = rung_out(engine, handle).sum()
        assert last < before + 0.5 * STICK[0] * velocity**2
        assert place(engine, handle)["stretch"] > 0.3
        for _ in range(300):
            stretch = float(place(engine, handle)["stretch"])
            engine.process(QUANTUM)
            now = energies(engine, handle).sum()
            assert now < last * (1 + 1e-12)
            retunes += place(engine, handle)["stretch"] != stretch
            last = now
    assert retunes > 300


def test_string_glides_back_to_its_own_pitch_and_its_own_tables():
    def ringing(glide):
        engine = Engine(RATE)
        handle = engine.add(string((200.0, 310.0, 543.0), t60=0.5, glide=glide))
        strike(engine, handle, LIGHT, velocity=10.0)
        engine.process(RATE)
        obj = place(engine, handle)
        span = slice(obj["first"], obj["first"] + obj["felt"])
        assert obj["stretch"] == 0.0 and obj["detuned"] == 0 and obj["stale_modes"] == 0
        tables = engine.state["bank"]["response"][0][: 26 * 8]
        return [engine.state["bank"][name][0][span].copy() for name in ("a1", "a2")] + [tables.copy()]

    for bent, straight in zip(ringing(2.0), ringing(0.0), strict=True):
        assert np.array_equal(bent, straight)


def test_glide_below_a_cent_changes_no_bit():
    """Every bit below a cent is that of an object that does not glide."""

    def sound(glide, velocity):
        engine = Engine(RATE)
        handle = engine.add(string((200.0, 310.0, 543.0), t60=0.5, glide=glide))
        strike(engine, handle, LIGHT, velocity=velocity)
        return engine.process(9_600)

    energy = 0.0011
    engine = Engine(RATE)
    handle = engine.add(string((200.0, 310.0, 543.0), t60=0.5))
    strike(engine, handle, LIGHT, velocity=1.0)
    most = rung_out(engine, handle).sum()
    assert np.array_equal(sound(energy / most, 1.0), sound(0.0, 1.0))
    assert not np.array_equal(sound(4 * energy / most, 1.0), sound(0.0, 1.0))


def test_bits_do_not_depend_on_the_block():
    def played(blocks):
        engine = Engine(RATE)
        handle = engine.add(string(np.linspace(100, 4_000, 64), t60=0.3, glide=20.0, cone=0.1))
        for time, velocity in ((10.5, 5.0), (3_000.25, 7.0), (4_700.0, 1.0)):
            strike(engine, handle, STICK, time, velocity)
        return np.concatenate([engine.process(n) for n in blocks])

    whole = played([9_600])
    assert np.array_equal(whole, played([64] * 150))
    assert np.array_equal(whole, played([37, 1, 1_000, 4_096, 513, 3_953]))


def test_settings_act_on_what_glides():
    engine = Engine(RATE)
    modes = string((200.0, 310.0), t60=20.0, glide=4.0)
    handle = engine.add(modes)
    strike(engine, handle, LIGHT, velocity=10.0)
    rung_out(engine, handle)
    before = frequency_of(engine.process(9_600)[:, 0].astype(float), 200.0)
    engine.send([setting(handle, "tune", 1.5)])
    engine.process(QUANTUM)
    assert frequency_of(engine.process(9_600)[:, 0].astype(float), 300.0) == pytest.approx(1.5 * before, rel=2e-3)
    whole = energies(engine, handle).sum()
    engine.send([setting(handle, "decay", 0.01)])
    engine.process(4_800)
    assert energies(engine, handle).sum() == pytest.approx(whole * math.exp(-2 * math.log(1000) / 0.2 * 0.1), rel=0.05)


def test_a_striker_tightens_the_head_about_itself_while_it_touches():
    glide, cone, velocity = 2.0, 0.05, 3.0
    engine = Engine(RATE)
    handle = engine.add(string(np.linspace(100, 4_000, 64), t60=0.1, glide=glide, cone=cone))
    strike(engine, handle, STICK, 640.5, velocity)
    engine.process(640)
    assert place(engine, handle)["stretch"] == 0.0
    engine.process(QUANTUM)
    tau = place(engine, handle)["stretch"]
    assert tau * (1 + tau) == pytest.approx(glide * cone * velocity**2)
    rung_out(engine, handle)
    engine.process(1_920)
    energy = energies(engine, handle).sum()
    engine.process(QUANTUM)
    assert place(engine, handle)["stretch"] == pytest.approx(glide * energy, rel=0.05, abs=1.2e-3)


def _between_rates(modes, times, seconds, law=STICK):
    """Return by how much two strikes differ between two rates: the greatest difference over the greatest value."""

    def sound(rate):
        engine = Engine(rate)
        set_limiter(engine, False)
        engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index("exact"))])
        handle = engine.add(modes)
        for time, velocity in zip(times, (1.0, 1.5), strict=True):
            strike(engine, handle, law, time * rate, velocity)
        return engine.process(int(seconds * rate))[:: int(rate / RATE), 0].astype(float)

    coarse, fine = sound(RATE), sound(4 * RATE)
    return np.abs(coarse - fine).max() / np.abs(fine).max()


@pytest.mark.parametrize("cone", [0.0, 0.05])
def test_a_glide_is_alike_at_any_rate(cone):
    """The tension takes its steps at the same times, and a striker tightens the head from its touch on."""
    head = string(np.linspace(100, 4_000, 64), t60=0.1, glide=2.0, cone=cone)
    assert _between_rates(head, (0.0135, 0.03), 0.1) < 0.003


def test_head_that_a_soft_blow_bends_is_retuned_without_a_step():
    """The tension changes while felt presses the head down: by 0.3 of its sound, were its bend to ring."""
    head = string(np.linspace(100, 4_000, 64), t60=0.1, glide=2.0, cone=0.05)
    assert _between_rates(head, (0.0135, 0.05), 0.1, FELT) < 0.003


def test_soft_blows_in_a_glide_give_no_more_than_they_bring():
    """Blows meet a head that swings and bend it while it is tightened and slackens."""
    for mass, stiffness in ((0.03, 1e5), (0.3, 1e4), (0.01, 1e6)):
        engine = Engine(RATE)
        handle = engine.add(string(np.linspace(100, 4_000, 64), t60=1e5, glide=20.0, cone=0.1, modal_mass=0.02))
        set_limiter(engine, False)
        brought = 0.0
        for k in range(6):
            strike(engine, handle, (mass, stiffness, 0.0, 1.5), 10.0 + 150.0 * k, 2.0)
            brought += 0.5 * mass * 2.0**2
        for _ in range(400):
            engine.process(QUANTUM)
        assert rung_out(engine, handle).sum() < brought * (1 + 1e-9)


def test_string_that_rings_long_glides_in_finer_steps():
    """A step that is left out puts it out of phase for as long as it rings: by 0.02 of its sound, were steps cents."""
    slow = string(np.linspace(200, 4_000, 24), t60=8.0, glide=0.2)
    assert _between_rates(slow, (0.0135, 0.2), 0.5) < 0.008


def test_a_panic_ends_the_glide():
    engine = Engine(RATE)
    handle = engine.add(string((200.0, 310.0), glide=4.0))
    strike(engine, handle, LIGHT, velocity=10.0)
    rung_out(engine, handle)
    engine.send([panic()])
    engine.process(2 * QUANTUM)
    assert place(engine, handle)["stretch"] == 0.0


def test_a_hand_that_presses_feels_no_step_as_the_tension_falls():
    """The contact goes on through every retune: where quanta meet, its force has no jumps that it has not where nothing
    glides, though all is quicker under the tension."""

    def jumps(glide):
        """Return the greatest second difference (N) of the force where quanta meet, and of all."""
        engine = Engine(RATE)
        engine.trace(True)
        handle = engine.add(string(np.linspace(100, 4_000, 64), t60=0.3, glide=glide, modal_mass=0.05))
        hand = gesture("press", handle, (0.1, 3e6, 3.0, 2.0), number=3, velocity=0.01, force=5.0)
        engine.send([hand])
        strike(engine, handle, HARD, 9_600.0, 3.0)
        force = []
        for _ in range(300):
            engine.process(QUANTUM)
            traced = engine.traced()
            force.append(traced["impulse"][traced["command"] == 1] * RATE)
        found = np.abs(np.diff(np.concatenate(force)[-110 * QUANTUM :], 2))
        middle = np.arange(1, len(found) + 1) % QUANTUM
        found /= 1.0 + place(engine, handle)["stretch"]
        return found[(middle == 0) | (middle == QUANTUM - 1)].max(), found.max()

    assert jumps(200.0)[0] < 1.5 * jumps(0.0)[1]


def test_gains_are_heard_and_not_felt():
    """A strike is as much out of tune at any gain, also after a louder one."""

    def rises(first, second):
        engine = Engine(RATE)
        handle = engine.add(string((200.0, 310.0), t60=0.2, glide=40.0))
        strike(engine, handle, LIGHT, velocity=10.0, gain=first)
        rung_out(engine, handle)
        engine.process(QUANTUM)
        one = float(place(engine, handle)["stretch"])
        engine.process(RATE // 2)
        strike(engine, handle, LIGHT, velocity=20.0, gain=second)
        rung_out(engine, handle)
        engine.process(QUANTUM)
        return one, float(place(engine, handle)["stretch"])

    plain = rises(1.0, 1.0)
    assert plain[1] > 3.5 * plain[0] > 0.01
    assert rises(20.0, 1.0) == pytest.approx(plain, rel=1e-3)
    assert rises(0.05, 20.0) == pytest.approx(plain, rel=1e-3)


def test_modes_that_a_press_makes_too_high_to_be_heard_leave_no_step():
    """The mix subtracts their share of the bend no more: with steps of 0.23 of the sound, were that a quantum late."""
    engine = Engine(RATE)
    handle = engine.add(string(np.linspace(100, 19_900, 150), t60=0.1, glide=40.0))
    set_limiter(engine, False)
    engine.send([gesture("press", handle, FELT, velocity=0.01, force=20.0)])
    sound = engine.process(RATE // 2)[:, 0].astype(float)
    edges = np.abs(np.diff(sound))[QUANTUM - 1 :: QUANTUM]
    assert edges.max() < 0.01 * np.abs(sound).max()


@pytest.mark.parametrize("force", (2.0, 20.0, 60.0))
def test_a_press_tightens_it_by_the_energy_of_its_bend(force):
    """Kirchhoff's equation gives q = F phi/(omega^2 (1 + s)) at rest and s = glide sum omega^2 q^2."""
    glide, frequencies = 40.0, np.array((200.0, 310.0))
    engine = Engine(RATE)
    handle = engine.add(string(frequencies, t60=0.1, glide=glide))
    engine.send([gesture("press", handle, (0.1, 3e6, 3.0, 2.0), velocity=0.01, force=force)])
    engine.process(RATE)
    compliance = (1.0 / (0.01 * (2 * np.pi * frequencies) ** 2)).sum()
    rise = brentq(lambda s: s - glide * compliance * (force / (1.0 + s)) ** 2, 0.0, 100.0)
    assert rise > 0.005
    assert place(engine, handle)["stretch"] == pytest.approx(rise, rel=0.01, abs=0.001)


@pytest.mark.parametrize("by", (False, True), ids=("a hand", "another object"))
@pytest.mark.parametrize("force", (5.0, 20.0, 60.0))
def test_a_hand_that_presses_does_not_feed_what_swings(force, by):
    """Whatever rings under a press falls by its losses, though the press tightens the object."""
    engine = Engine(RATE)
    handle = engine.add(string(np.linspace(100, 2_000, 20), t60=0.5, glide=40.0))
    other = {"by": engine.add(string((150.0, 700.0), t60=0.5, glide=40.0))} if by else {}
    engine.send([gesture("press", handle, (0.01, 5e5, 3.0, 2.0), velocity=0.01, force=force, **other)])
    levels = []
    for _ in range(8):
        levels.append(np.abs(engine.process(RATE // 4)).max())
    assert all(later < 0.6 * before for before, later in zip(levels[1:], levels[3:], strict=False)), levels
