"""Contacts in the engine with objects that yield, ring already, touch back, or are pressed on."""

import math
from dataclasses import replace

import numpy as np
import pytest

from carom.dsp.bodies import listed
from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import QUANTUM, End, Solver
from carom.dsp.lab.coupled import Case, error
from carom.dsp.resonator.bank import state_of
from carom.dsp.runtime.engine import NOW, Engine
from carom.presets.library import Presets
from tests import accuracy
from tests.dsp.contact.coupled_reference import Blow, reference, several
from tests.dsp.engine.support import gesture, impact, numbered, panic, setting, stop, strike

RATE = 48_000
PRESETS = Presets()


def body(modal_mass=0.1, n=24, t60=1.0, top=9_000):
    return listed(
        frequency=np.linspace(200, top, n), t60=np.full(n, t60), modal_mass=modal_mass, mass=1.0, top=20_000
    )  # fmt: skip


def press(engine, handle, law, force, by=None):
    """Press with a hand, which is number 3."""
    hand = gesture("press", handle, law, number=3, by=by, velocity=0.01, force=force, by_position=0.5)
    engine.send([hand])


def budget(engine, steps, modes):
    engine.send([Command(NOW, Kind.BUDGET, values={"steps": steps, "modes": modes})])


def felt(engine, handle):
    """Return the numbers of the modes that contacts feel: those that are heard first. After the first quantum."""
    place = engine.state["objects"][0][handle.slot]
    numbers = np.concatenate([np.arange(place["felt"]), np.arange(place["unheard"], place["size"])])
    return numbers[engine.state["bank"]["frequency"][0, handle.first + numbers] > 0]


def modal(engine, handle, size):
    """Return the frequencies (Hz), decays (1/s), shapes in the middle (kg^-1/2) and states z of an object's first
    modes.

    size: how many, or which.
    """
    bank, place = engine.state["bank"][0], engine.state["objects"][0][handle.slot]
    which = np.arange(size) if np.ndim(size) == 0 else size
    i = handle.first + which
    table = bank["shape"][handle.table : handle.table + place["rows"] * place["size"]].astype(float)
    rows = table.reshape(place["rows"], place["size"])
    x = 0.5 * (place["rows"] - 1)
    row = min(max(int(x) - 1, 0), place["rows"] - 4)
    at = x - row
    weights = [
        -(at - 1) * (at - 2) * (at - 3) / 6, at * (at - 2) * (at - 3) / 2,
        -at * (at - 1) * (at - 3) / 2, at * (at - 1) * (at - 2) / 6,
    ]  # fmt: skip
    phi = (np.array(weights)[:, None] * rows[row : row + 4]).sum(axis=0)[which]
    columns = zip(*(bank[name][i] for name in ("y1", "y2", "a1", "a2", "weight")), strict=True)
    z = np.array([complex(*state_of(*c[:4])) / c[4] if c[3] else 0j for c in columns])
    turns = np.sign(np.sin(2 * np.pi * bank["frequency"][i] / engine.rate))  # backwards above the Nyquist frequency
    return bank["frequency"][i].copy(), bank["sigma"][i].copy(), phi, turns * z.real + 1j * z.imag


def velocity(engine, handle, size):
    frequency, sigma, phi, z = modal(engine, handle, size)
    return phi @ (z.real - sigma / (2 * np.pi * frequency) * z.imag)


def energy(engine, handle, size):
    frequency, sigma, _, z = modal(engine, handle, size)
    damping = sigma / (2 * np.pi * frequency)
    return 0.5 * float(((z.real - damping * z.imag) ** 2 + (1 + damping**2) * z.imag**2).sum())


PAIRS = [
    ("tom", "felt", 1.0), ("church-bell", "clapper", 1.0), ("piano-string", "felt-hammer", 2.0),
    ("wood-block", "wood", 1.0), ("glass-plate", "steel", 1.0), ("marimba-bar", "yarn", 0.5),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("name", "striker", "v_in"), PAIRS)
def test_heavy_and_light_strikers_against_dop853(name, striker, v_in):
    """Twelve milliseconds of the object's point, struck by built-in strikers."""
    engine = Engine(RATE)
    preset = PRESETS.object(name)
    modes = replace(preset.modes(engine.top_frequency), glide=0.0)
    law = PRESETS.striker(striker).contact(preset.material)
    handle = engine.add(modes, 0.05)
    strike(engine, handle, law, 3.25, v_in)
    states = []
    for _ in range(9):
        engine.process(QUANTUM)
        frequency, sigma, phi, z = modal(engine, handle, felt(engine, handle))
        states.append(z)
    times = (np.arange(1, 10) * QUANTUM - 1 - 3.25) / RATE
    expected, _, contacts = several(frequency, sigma, phi[None], [Blow(0.0, v_in, *law)], times, tolerance=1e-12)
    heard = len(modes.frequency)  # what nobody hears is put to rest once the striker has left

    def velocity_of(z):
        return (z.real - sigma / (2 * np.pi * frequency) * z.imag)[:, :heard] @ phi[:heard]

    right = velocity_of(expected)
    assert 20 * math.log10(np.abs(velocity_of(np.array(states)) - right).max() / np.abs(right).max()) < -60
    assert engine.stats.impacts + engine.stats.recontacts == contacts


@pytest.mark.slow
def test_a_coin_rattles_on_a_tin_lid():
    """Dozens of touches in milliseconds are chaos, of which the first are like DOP853's; energy is what can be said."""
    engine = Engine(RATE)
    preset = PRESETS.changed("tin-lid", [("split_seed", 0)])  # pairs lie alike, else there is one touch
    modes = preset.modes(engine.top_frequency)
    handle = engine.add(modes, 0.05)
    law = PRESETS.striker("coin").contact(preset.material)
    strike(engine, handle, law)
    most = 0.0
    for _ in range(40):
        engine.process(QUANTUM)
        most = max(most, energy(engine, handle, felt(engine, handle)))
    assert engine.stats.recontacts > 10 and 0.1 < most / (0.5 * law[0]) < 1.0 + 1e-6


@pytest.mark.slow
def test_an_object_that_rings_meets_the_striker_half_way():
    engine = Engine(RATE)
    law = (0.02, 1e6, 0.3, 1.5)
    handle = engine.add(body(), 0.05)
    strike(engine, handle, law, 0.0, 2.0)
    while engine.stats.contacts_active or engine.position < 2000:
        engine.process(QUANTUM)
    frequency, sigma, phi, z = modal(engine, handle, 24)
    start = engine.position + 5
    strike(engine, handle, law, start + 0.5)
    later = z * np.exp((-sigma + 2j * np.pi * frequency) * 6 / RATE)
    m, k, mu, a = law
    case = Case(frequency, sigma, phi, 1.0, m, k, mu, a, rate=RATE, samples=400, fraction=0.5, ringing=later)
    expected = reference(case)[0]
    heard = []
    for n in range(6):
        engine.process(QUANTUM)
        heard.append((64 * (n + 1) - 1 - 5 - 1, velocity(engine, handle, 24)))
    at, got = np.array(heard).T
    assert error(got, expected[at.astype(int)]) < accuracy.ENGINE_COUPLED.bound
    quiet = reference(Case(frequency, sigma, phi, 1.0, m, k, mu, a, rate=RATE, samples=400, fraction=0.5))[0]
    assert error(expected - quiet, expected) > -20  # so that it rings matters


@pytest.mark.parametrize("modal_mass", [0.01, 1.0])
def test_two_that_ring_keep_the_energy_of_a_lossless_blow(modal_mass):
    """A mass that is an object: kinetic energy before, and that of it and of both objects' modes after, undamped."""
    engine = Engine(RATE)
    engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index("exact"))])
    one, other = (engine.add(body(modal_mass * ratio, n, t60=1e9), 0.05) for ratio, n in ((1.0, 24), (0.5, 16)))
    law = (0.05, 1e9, 0.0, 1.5)
    engine.send([gesture("impact", one, law, by=other, velocity=1.0, by_position=0.5)])
    v = []
    while engine.position == 0 or engine.stats.contacts_active:
        engine.process(QUANTUM)
        v += [float(c["coupled"]["v"]) for c in engine.state["contacts"][0] if c["solver"] == int(Solver.COUPLED)]
    left = 0.5 * law[0] * v[-1] ** 2 if v else None
    modes = energy(engine, one, 24), energy(engine, other, 16)
    assert min(modes) > 1e-4
    if left is None:  # it left within the first quantum
        contact = max(engine.state["contacts"][0], key=lambda c: abs(c["coupled"]["v"]))
        left = 0.5 * law[0] * contact["coupled"]["v"] ** 2
    assert sum(modes) + left == pytest.approx(0.5 * law[0], rel=1e-6)


def test_a_pressed_striker_rests_where_it_must_and_leaves_when_let_go():
    engine = Engine(RATE)
    handle = engine.add(body(modal_mass=10.0), 0.05)
    law, force = (0.02, 1e7, 5.0, 1.5), 4.0
    press(engine, handle, law, force)
    engine.process(int(1.5 * RATE))
    (contact,) = numbered(engine)
    assert contact["coupled"]["motion"][0] == pytest.approx((force / law[1]) ** (1 / law[3]), rel=1e-4)
    assert abs(contact["coupled"]["v"]) < 1e-4 and engine.ended() == []
    before = np.abs(np.diff(engine.process(QUANTUM)[:, 0])).max()
    engine.send([stop(3)])
    sound = engine.process(int(0.8 * RATE))
    assert engine.stats.contacts_active == 0 and engine.ended() == [(3, End.STOPPED)]
    assert np.abs(np.diff(sound[:, 0])).max() > 10 * before  # heard


def test_a_press_that_has_ended_has_no_force():
    """The place behind the last one may be that of a roll on another object."""

    def sound(elsewhere):
        engine = Engine(RATE)
        press(engine, engine.add(body(modal_mass=10.0), 0.05), (0.02, 1e7, 5.0, 1.5), 4.0)
        engine.process(RATE // 2)
        engine.send([stop(3)])
        made = []
        while engine.stats.contacts_active:
            engine.state["feeds"][0][-1] = elsewhere
            made.append(engine.process(QUANTUM))
        return np.concatenate(made)

    np.testing.assert_array_equal(sound(1.0), sound(0.0))


def test_a_hand_damps():
    """A soft and lossy striker that is pressed on: what is struck then dies away sooner."""

    def left_after(seconds, pressed):
        engine = Engine(RATE)
        handle = engine.add(body(modal_mass=0.05, n=8, t60=4.0, top=2_000), 0.05)
        if pressed:
            press(engine, handle, (0.05, 2e5, 20.0, 1.5), 2.0)
        engine.process(RATE // 2)
        rest = energy(engine, handle, 8)
        strike(engine, handle, (0.005, 1e7, 0.2, 1.5))
        engine.process(int(seconds * RATE))
        return energy(engine, handle, 8) - rest

    assert left_after(0.5, True) < 0.1 * left_after(0.5, False)


@pytest.mark.slow
@pytest.mark.parametrize("side", [0, 1])
def test_an_object_that_is_retuned_under_a_press_is_felt_as_it_is(side):
    """Either of the two that touch: a strike sounds as if it had been tuned so from the beginning."""

    def sound(before, after):
        engine = Engine(RATE)
        pair = [engine.add(body(mass, n, t60=0.1), 0.05) for mass, n in ((0.1, 16), (0.01, 8))]
        engine.send([setting(pair[side], "tune", before)])
        press(engine, pair[0], (0.05, 1e6, 3.0, 1.5), 4.0, by=pair[1])
        engine.process(4800)
        engine.send([setting(pair[side], "tune", after)])
        engine.process(RATE)
        strike(engine, pair[0], (0.002, 1e6, 0.3, 1.5))
        return engine.process(4800)[:, 0].astype(float)

    retuned, fresh = sound(1.0, 2.0), sound(2.0, 2.0)
    assert np.abs(retuned - fresh).max() < 1e-6 * np.abs(fresh).max()
    assert np.abs(sound(1.0, 1.0) - fresh).max() > 0.1 * np.abs(fresh).max()  # so the tuning matters


def test_accuracy_moves_the_gate():
    def coupled(level):
        engine = Engine(RATE)
        engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index(level))])
        handles = [engine.add(body(modal_mass=mass, t60=0.01), 0.05) for mass in np.geomspace(0.01, 1e6, 40)]
        for handle in handles:
            strike(engine, handle, (0.01, 1e8, 0.3, 1.5))
        engine.process(4800)
        return engine.stats.coupled

    counts = [coupled(level) for level in LEVELS]
    assert counts == sorted(set(counts)) and counts[-1] == 40


@pytest.mark.slow
@pytest.mark.parametrize(
    ("frequency", "modal_mass", "law", "v_in"),
    [
        (52.7, 0.654, (0.168, 7.03e13, 9.22, 1.0), 82.4),
        (214.0, 0.286, (0.799, 5.06e15, 4.6, 1.0), 34.7),
        (236.0, 0.111, (6.88, 1.97e15, 0.0228, 1.0), 91.5),
    ],
)
def test_a_stiff_striker_that_rides_on_a_slow_mode_stays_finite(frequency, modal_mass, law, v_in):
    """The striker touches hundreds of times in some ms, by steps down to what rounding leaves of them."""
    engine = Engine(RATE)
    engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index("exact")), Command(NOW, Kind.LIMITER, value=0.0)])
    slow = listed(frequency=[frequency], t60=[700.0], modal_mass=modal_mass, mass=1.0, top=20_000)
    handle = engine.add(slow)
    engine.send([impact(handle, law, 30.5, v_in)])
    engine.process(14 * QUANTUM)
    assert engine.stats.recontacts > 400 and engine.stats.faults == 0
    assert energy(engine, handle, felt(engine, handle)) < 0.5 * law[0] * v_in**2


@pytest.mark.slow
def test_coupled_contacts_are_bounded():
    """512 heavy strikers at once on a light object: most are left out, and energy doesn't grow."""
    engine = Engine(RATE)
    budget(engine, 4, 8_192)
    n = 200
    handle = engine.add(body(modal_mass=0.01, n=n, t60=0.5), 0.05)
    for _ in range(512):
        strike(engine, handle, (0.1, 1e6, 0.1, 1.5))
    most, contacts = 0, engine.state["contacts"][0]
    for _ in range(60):
        engine.process(QUANTUM)
        most = max(most, engine.stats.coupled_modes)
        counted = (contacts["solver"] == int(Solver.COUPLED)) & (contacts["aside"] == 0)
        assert engine.stats.coupled_modes == contacts["modes"][counted].sum()
    assert 0 < most <= 8_192
    taken = 512 - engine.stats.contacts_dropped
    assert energy(engine, handle, n) < taken * 0.5 * 0.1 and 10 < taken < 40 and engine.stats.faults == 0


@pytest.mark.slow
def test_no_force_is_held_where_a_striker_leaves_at_once():
    """No force is held however little of a step is left of 300 contacts when they end."""
    engine = Engine(RATE)
    engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index("exact"))])
    for mass in np.geomspace(0.003, 10.0, 100):
        handle = engine.add(body(modal_mass=mass, t60=0.5), 0.05)
        for time, law in (
            (0.0, (0.01, 1e9, 0.3, 1.5)),
            (200.0, (0.003, 1e8, 0.1, 1.5)),
            (300.0, (3e-4, 1e8, 0.4, 1.5)),
        ):
            strike(engine, handle, law, time)
    engine.process(4_800)
    assert engine.stats.coupled == 300 and engine.stats.held == 0


def test_a_contact_is_not_held_for_those_before_it():
    """The contact takes the place of one that chattered until it had to hold its force."""
    engine = Engine(RATE)
    engine.send([Command(NOW, Kind.ACCURACY, value=LEVELS.index("exact"))])
    budget(engine, 4, 0)
    light, heavy = (engine.add(body(modal_mass), 0.05) for modal_mass in (1e-4, 1.0))
    strike(engine, light, (0.05, 1e9, 0.0, 1.5))
    for _ in range(40):
        engine.process(QUANTUM)
        if engine.state["contacts"]["debt"].max() > 300:
            break
    engine.send([panic()])
    engine.process(QUANTUM)
    held = engine.stats.held
    strike(engine, heavy, (0.05, 1e6, 0.2, 1.5))
    engine.process(4800)
    assert engine.stats.coupled == 2 and held == engine.stats.held > 0


def test_gain_makes_it_louder_and_nothing_else():
    def sound(gain):
        engine = Engine(RATE)
        strike(engine, engine.add(body(modal_mass=0.02), 0.05), (0.05, 1e6, 0.2, 1.5), gain=gain)
        return engine.process(4800).astype(float)

    np.testing.assert_allclose(sound(0.1), 0.1 * sound(1.0), atol=1e-5)


def test_strikers_at_once_are_solved_together():
    """Two that touch an object in the same sample: it does not matter who came first in the list."""

    def sound(order):
        engine = Engine(RATE)
        handle = engine.add(body(modal_mass=0.05), 0.05)
        laws = [(0.05, 1e6, 0.2, 1.5), (0.02, 3e6, 0.4, 1.5)]
        for n in order:
            strike(engine, handle, laws[n], 10.0, 1.0 + 0.3 * n)
        return engine.process(2048)[:, 0].astype(float)

    there, back = sound((0, 1)), sound((1, 0))
    assert np.abs(there - back).max() < 1e-6 * np.abs(there).max()
