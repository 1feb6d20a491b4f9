"""Coupled contacts against DOP853, and their energy."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numba import carray, cfunc, from_dtype, types

from carom.dsp.contact import coupled, coupled_flight
from carom.dsp.contact.accuracy import LEVELS, TOLERANCE, closed_form_will_do
from carom.dsp.contact.coupled import ContactLaw
from carom.dsp.contact.coupled_group import MOST_STEPS
from carom.dsp.contact.coupled_records import COUPLED_GROUP
from carom.dsp.contact.coupled_step import HELD
from carom.dsp.contact.power_series import FORCES_THERE, WHOLE_SAMPLE, legendre_moments
from carom.dsp.contact.pulse import contact_time
from carom.dsp.lab import coupled_sampled
from carom.dsp.lab.coupled import MEMBER, Case, error, extreme_case, random_cases, simulate, step_alone
from carom.dsp.numerics.sums import add_powers
from carom.dsp.resonator import bank, coefficients
from tests import accuracy
from tests.dsp.contact.coupled_reference import reference
from tests.dsp.runtime.test_realtime_safety import forbidden

pytestmark = pytest.mark.slow

EXACT = TOLERANCE[LEVELS.index("exact")]


def errors(cases, tolerance):
    """Return the errors of the object's velocity (dB), as a share of what the contact adds to it; contacts that are
    miscounted."""
    found, miscounted = [], 0
    for case in cases:
        expected, _, contacts = reference(case)
        run = simulate(case, tolerance)
        alone = simulate(replace(case, v_in=0.0, m=1e-30, k=1e-30)).velocity if np.ndim(case.ringing) else 0.0
        found.append(error(run.velocity - alone, expected - alone))
        miscounted += run.contacts[-1] != contacts
    return np.array(found), miscounted


@pytest.fixture(scope="module")
def heard():
    return random_cases(200, seed=5)


@pytest.mark.parametrize(("level", "tolerance"), list(zip(LEVELS, TOLERANCE, strict=True)))
def test_two_hundred_contacts_against_dop853(heard, level, tolerance):
    found, miscounted = errors(heard, tolerance)
    asked = {"exact": accuracy.COUPLED_EXACT.bound, "-60": accuracy.COUPLED.bound}.get(level) or float(level)
    assert np.median(found) < asked - 15 and np.quantile(found, 0.9) < asked
    assert miscounted == 0


def test_objects_that_already_ring():
    random = np.random.default_rng(8)
    cases = []
    for case in random_cases(40, seed=8):
        n = len(case.frequency)
        z = 0.3 * math.sqrt(case.m / n) * (random.normal(size=n) + 1j * random.normal(size=n))
        cases.append(replace(case, ringing=z))
    found, miscounted = errors(cases, EXACT)
    assert np.quantile(found, 0.9) < -120 and miscounted == 0


def hits_on_light_objects(yielding, count, seed):
    """Yield elastic hits on 24 modes with sum r = `yielding`."""
    random = np.random.default_rng(seed)
    for _ in range(count):
        phi = random.normal(size=24)
        phi *= math.sqrt(yielding / (0.01 * phi @ phi))
        frequency = np.sort(random.uniform(200, 19_000, 24))
        yield Case(frequency, np.full(24, 5.0), phi, 1.0, 0.01, 10 ** random.uniform(9, 12), 0.0, 1.5, samples=400)


def test_light_objects_are_touched_again():
    cases = list(hits_on_light_objects(3.0, 40, seed=2))
    found, miscounted = errors(cases, EXACT)
    assert np.quantile(found, 0.9) < -100 and miscounted == 0
    assert np.mean([simulate(case).contacts[-1] for case in cases]) > 2


def test_chaotic_contacts_keep_their_statistics():
    """A contact at sum r = 30 has tens of micro-contacts: their effect on the average is tested, not their waveform."""
    cases = list(hits_on_light_objects(30.0, 60, seed=3))
    runs = [simulate(case, TOLERANCE[1]) for case in cases]
    truths = [reference(case, tolerance=1e-11) for case in cases]
    counts = np.array([[run.contacts[-1], truth[2]] for run, truth in zip(runs, truths, strict=True)])
    left = np.array([[run.striker[-1], truth[1][-1]] for run, truth in zip(runs, truths, strict=True)])
    assert counts[:, 1].mean() > 15
    assert counts[:, 0].mean() == pytest.approx(counts[:, 1].mean(), rel=0.03)
    assert (left[:, 0] ** 2).mean() == pytest.approx((left[:, 1] ** 2).mean(), rel=0.03)
    assert max(run.growth(case) for run, case in zip(runs, cases, strict=True)) < 1e-8


@pytest.mark.parametrize("k", [1e8, 1e10, 1e12])
@pytest.mark.parametrize("modes", [1, 4, 16, 64])
def test_lossless_hits_keep_their_energy(modes, k):
    random = np.random.default_rng(modes)
    frequency = np.sort(np.geomspace(100, 20_000, 1000)[random.integers(0, 1000, modes)])
    phi = random.normal(size=modes)
    phi *= math.sqrt(0.5 / (0.01 * phi @ phi))
    case = Case(frequency, np.zeros(modes), phi, 1.0, 0.01, k, 0.0, 1.5, samples=300, fraction=0.3)
    for tolerance in (*TOLERANCE, 1e-7):
        run = simulate(case, tolerance)
        assert np.abs(run.energy / case.energy - 1).max() < (accuracy.LOSSLESS.bound if tolerance < 1e-3 else 1e-5)
        assert run.growth(case) < 1e-8


@pytest.mark.parametrize("tolerance", [HELD, 1e-1, 1e-3, EXACT])
def test_extreme_contacts_stay_finite_passive_and_bounded(tolerance):
    random = np.random.default_rng(17)
    for _ in range(1_000):
        case = extreme_case(random)
        run = simulate(case, tolerance)
        assert np.isfinite(run.energy).all() and np.isfinite(run.velocity).all()
        assert run.growth(case) < accuracy.GROWTH.bound, case
        assert run.steps <= (MOST_STEPS + 1) * case.samples


class Modes:
    """Modes through the kernels that the engine calls."""

    def __init__(self, frequency, sigma, phi, rate=48_000.0):
        groups = -(-len(frequency) // bank.LANES)
        n = groups * bank.LANES
        self.state, self.tuning = np.zeros((2, n)), np.zeros((2, n))
        self.modes = bank.Modes(*self.state, *self.tuning, np.zeros(n), np.zeros(groups * bank.RESPONSES))
        for i in range(len(frequency)):
            coefficients.set_mode(self.modes, i, frequency[i], sigma[i], rate, 1.0)
        shape = np.zeros(4 * n)
        shape[n : n + len(phi)] = phi
        self.point = bank.Point(shape, n, 0, np.array([0.0, 1.0, 0.0, 0.0]))
        self.work = np.zeros((3 + bank.FINE) * n)

    def receptance(self):
        seen = np.zeros(bank.FINE)
        bank.receptance(self.modes, self.point, self.work, seen)
        return seen

    def observe(self):
        seen = np.zeros(bank.FINE)
        bank.observe(self.modes, self.point, self.work, seen)
        return seen

    def reach(self):
        distance, speed, change = bank.reach(self.modes, self.point, self.work)
        return distance, speed, 48_000.0 * change

    def step(self, moments):
        bank.inject_fine(self.modes, self.point, moments)
        self.ring()

    def ring(self):
        self.state[:] = (self.tuning * self.state).sum(axis=0), self.state[0].copy()


def contact_of(law, receptance, tolerance, push=0.0, fraction=0.0):
    contacts, group = np.zeros(1, MEMBER), np.zeros(1, COUPLED_GROUP)[0]
    contact = contacts[0]["coupled"]
    v, *law = law
    coupled.begin_coupled(contact, v, ContactLaw(*law), push, fraction, 48_000.0, tolerance)
    coupled.respond_with(contact, receptance)

    def step(seen, moments):
        step_alone(contacts, group, seen, moments)

    return contact, step


def test_a_pressed_striker_comes_to_rest_and_leaves_when_released():
    """A striker at rest compresses x_eq; let go, the bent modes and the contact throw it off, for good."""
    frequency, sigma, phi = np.array([180.0, 470.0, 1100.0, 2900.0]), np.full(4, 60.0), np.full(4, 2.0)
    law, push, rest = (0.3, 0.02, 1e7, 5.0, 1.5), 3.0, 12_000
    modes = Modes(frequency, sigma, phi)
    contact, step = contact_of(law, modes.receptance(), 1e-3, push)
    velocities, apart, moments = [], [], np.zeros(bank.FINE)
    for t in range(rest + 2_000):
        if t == rest:
            _, _, k, _, a = law
            assert contact["motion"][0] == pytest.approx((push / k) ** (1 / a), rel=1e-5)
            assert abs(contact["v"]) < 1e-5
            assert contact["steps"] < 1.2 * rest  # where it lies, a step a sample is enough
            contact["push"] = 0.0
        step(modes.observe(), moments)
        modes.step(moments)
        velocities.append(float(contact["v"]))
        apart.append(coupled_flight.apart_for(contact, *modes.reach(), 0.0))
    assert max(apart[1_000:rest]) == 0.0
    gone = apart.index(math.inf)
    assert gone > rest and set(apart[gone:]) == {math.inf}
    assert velocities[gone] < 0 and set(velocities[gone:]) == {velocities[gone]}


def bounced(longest):
    """Drop a weight back on a ringing plate: return contacts, samples looked at, its last velocity."""
    modes = Modes(300.0 * np.arange(1, 5), np.full(4, 80.0), np.full(4, 2.0))
    contact, step = contact_of((0.5, 0.002, 1e9, 0.2, 1.5), modes.receptance(), 1e-5, 0.002 * 9.81, 0.25)
    looked = skip = 0
    moments = np.zeros(bank.FINE)
    for _ in range(20_000):
        if skip > 0:
            skip -= 1
            coupled_flight.fly_on(contact, 1)
            modes.ring()
            continue
        looked += 1
        step(modes.observe(), moments)
        modes.step(moments)
        skip = int(min(coupled_flight.apart_for(contact, *modes.reach(), 0.0), longest - 1))
    return contact["contacts"], looked, float(contact["v"])


def test_a_striker_that_is_apart_may_fly_unseen():
    """Skipping what `apart_for` allows changes nothing."""
    contacts, looked, v = bounced(1)
    skipping = bounced(1_000_000)
    assert skipping[0] == contacts > 3
    assert skipping[1] < 0.5 * looked
    assert skipping[2] == pytest.approx(v, rel=1e-6)


def left(modes, law, tolerance, skips):
    """Strike a modal object until the striker is gone for good, and fly unseen or not: return samples looked at,
    contacts, steps, its last velocity."""
    contact, step = contact_of(law, modes.receptance(), tolerance)
    looked = skip = 0
    moments = np.zeros(bank.FINE)
    while skip != math.inf and looked < 20_000:
        looked += 1
        step(modes.observe(), moments)
        modes.step(moments)
        skip = coupled_flight.apart_for(contact, *modes.reach(), 0.0)
        if skips and 0 < skip < math.inf:
            coupled_flight.fly_on(contact, skip)
            for _ in range(int(skip)):
                modes.ring()
    return looked, contact["contacts"], contact["steps"], float(contact["v"])


def blow_of_six_samples():
    """Return an object of 24 modes, with sum m phi^2 = 0.5, and the law of a blow that lasts six samples on a wall."""
    v, m, mu, a = 1.0, 0.01, 0.5, 1.5
    k = (contact_time(v, m, 1.0, mu, a) * 48_000.0 / 6.0) ** (a + 1.0)
    frequency, phi = np.geomspace(100.0, 15_000.0, 24), np.full(24, math.sqrt(0.5 / (24 * m)))
    return Modes(frequency, np.full(24, 500.0), phi), (v, m, k, mu, a)


def test_a_blow_is_solved_in_a_step_a_sample_and_its_striker_soon_let_go():
    """The first step is as long as the tolerance lets it be, and the gap says itself when nothing can close it."""
    modes, law = blow_of_six_samples()
    looked, contacts, steps, v = left(modes, law, 0.1, True)
    assert contacts == 1 and steps <= 6 and looked <= 8
    modes, law = blow_of_six_samples()
    assert v == pytest.approx(left(modes, law, 1e-7, True)[3], rel=1e-3)


def test_a_force_over_a_whole_sample_has_three_moments():
    """A quadratic over the sample has no others: quadrature by powers says the same."""
    from numba import njit

    forces = np.array([0.3, -1.7, 0.9])
    by_powers = njit(lambda powers, f0, f1, f2: add_powers(powers, FORCES_THERE, (f0, f1, f2), (-1.0, 2.0), bank.FINE))
    moments = np.zeros(bank.FINE)
    by_powers(moments, *forces)
    legendre_moments(moments)
    np.testing.assert_allclose(moments[:3], WHOLE_SAMPLE @ forces, atol=1e-15)
    assert np.abs(moments[3:]).max() < 1e-13


@pytest.mark.parametrize("seed", range(6))
def test_a_striker_that_leaves_misses_no_touch_unseen(seed):
    """Light objects swing after it: what it is not looked at for changes nothing."""
    random = np.random.default_rng(seed)
    frequency, phi = np.sort(random.uniform(100, 9_000, 12)), random.normal(size=12) * 10 ** random.uniform(0.5, 1.5)
    law = (1.0, 0.01, 10 ** random.uniform(7, 9), 0.1, 1.5)
    seen, unseen = (left(Modes(frequency, np.full(12, 20.0), phi), law, 1e-7, skips) for skips in (False, True))
    assert unseen[0] <= seen[0] and unseen[1] == seen[1]
    assert unseen[3] == pytest.approx(seen[3], rel=1e-6)


def test_two_objects_that_both_ring():
    """The striker's own modes yield as the object's do: both banks together are one."""
    random = np.random.default_rng(9)
    frequency, phi = np.sort(random.uniform(100, 15_000, 16)), random.normal(size=16)
    case = Case(frequency, np.full(16, 20.0), phi, 1.0, 0.02, 1e9, 0.3, 1.5, samples=200, fraction=0.6)
    banks = [Modes(frequency[half], case.sigma[half], phi[half]) for half in (slice(0, 8), slice(8, 16))]
    receptance = banks[0].receptance() + banks[1].receptance()
    law = (case.v_in, case.m, case.k, case.mu, case.a)
    contact, step = contact_of(law, receptance, EXACT, fraction=case.fraction)
    velocities, moments = [], np.zeros(bank.FINE)
    for _ in range(case.samples):
        step(banks[0].observe() - banks[1].observe(), moments)
        banks[0].step(moments)
        banks[1].step(-moments)
        velocities.append(float(contact["v"]))
    np.testing.assert_allclose(velocities, simulate(case, EXACT).striker, rtol=0, atol=1e-9)


def test_bad_cases_are_named():
    modes = (np.array([440.0]), np.array([1.0]), np.array([1.0]))
    for name, value in (("m", 0.0), ("k", math.inf), ("mu", -1.0), ("a", 0.5), ("v_in", math.nan), ("push", math.nan)):
        striker = {"v_in": 1.0, "m": 0.01, "k": 1e8, "mu": 0.0, "a": 1.5, "push": 0.0, name: value}
        with pytest.raises(ValueError, match=f"{name} = "):
            Case(*modes, **striker)
    with pytest.raises(ValueError, match="frequency = 30000"):
        Case(np.array([30_000.0]), modes[1], modes[2], 1.0, 0.01, 1e8, 0.0, 1.5)


def test_sampled_methods_converge_to_the_coupled_solver():
    """RK4 in many steps is a third, independent, way to the same sound."""
    for case in random_cases(6, seed=4):
        case = replace(case, fraction=0.0)
        fine = coupled_sampled.sample(case, "rk4", 2_000)
        assert error(fine.velocity, simulate(case).velocity) < -70
        for method in ("am1", "heun", "verlet"):
            assert error(coupled_sampled.sample(case, method, 2_000).velocity, fine.velocity) < -30


PLACE = np.dtype(
    [
        ("contacts", MEMBER, (1,)),
        ("group", COUPLED_GROUP),
        ("modes", np.float64, (5, bank.LANES)),
        ("response", np.float64, bank.RESPONSES),
        ("shape", np.float32, 4 * bank.LANES),
        ("weights", np.float64, 4),
        ("work", np.float64, (3 + bank.FINE) * bank.LANES),
        ("seen", np.float64, bank.FINE),
        ("moments", np.float64, bank.FINE),
    ],
    align=True,
)


def every_kernel(data):
    """Call what the engine will call, one after the other."""
    place = carray(data, (1,))[0]
    contact, seen, moments, work = place.contacts[0].coupled, place.seen, place.moments, place.work
    modes = bank.Modes(
        place.modes[0], place.modes[1], place.modes[2], place.modes[3], place.modes[4], place.response
    )  # fmt: skip
    point = bank.Point(place.shape, 8, 0, place.weights)
    coupled.begin_coupled(contact, 1.0, ContactLaw(0.01, 1e8, 0.5, 1.5), 0.0, 0.3, 48_000.0, 1e-5)
    bank.receptance(modes, point, work, seen)
    coupled.respond_with(contact, seen)
    bank.observe(modes, point, work, seen)
    step_alone(place.contacts, place.group, seen, moments)
    bank.inject_fine(modes, point, moments)
    distance, speed, change = bank.reach(modes, point, work)
    apart = coupled_flight.apart_for(contact, distance, speed, change, 0.0)
    coupled_flight.fly_on(contact, apart)
    return closed_form_will_do(1, distance, speed, apart, 1.0)


def test_kernels_neither_allocate_nor_raise():
    signature = types.boolean(types.CPointer(from_dtype(PLACE)))
    compiled = cfunc(signature, error_model="numpy", forceinline=True)(every_kernel)
    assert forbidden(compiled.inspect_llvm(), compiled.native_name) == set()
