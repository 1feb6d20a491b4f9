"""The engine as a whole: exact sums, time, rest, limits and faults."""

import math

import numpy as np
import pytest

from carom.dsp import contact
from carom.dsp.bodies.modes import Modes, listed
from carom.dsp.contact.closed_form import contact_time
from carom.dsp.engine.state import CONTACTS, EVENTS, MODES, OBJECTS, QUANTUM, RING, Command
from carom.dsp.resonator.bank import state_of
from carom.dsp.runtime.arena import EngineFull
from carom.dsp.runtime.engine import NOW, Engine

RATE = 48_000.0
HARD = (0.01, 1e9, 0.5, 1.5)  # m, k, mu, a: about 6 samples


def bell(n=24, t60=1.0, modal_mass=10.0):
    return listed(
        frequency=np.linspace(300, 15_000, n), t60=np.full(n, t60), modal_mass=modal_mass, mass=10.0, top=20_000
    )  # fmt: skip


def add(engine, modes=None, level=0.05, gain=1.0, pan=0.0):
    handle, size, rows = engine.lay_out(modes or bell(), level)
    engine.send([(NOW, Command.NEW, handle, (handle.first, size, handle.table, rows, gain, pan, 1.0, 1.0, 0.0))])
    return handle


def strike(engine, handle, time=NOW, v_in=1.0, position=0.5, law=HARD, gain=1.0):
    engine.send([(time, Command.IMPACT, handle, (v_in, position, *law, gain))])


def test_a_strike_is_the_sum_of_its_modes():
    """A blow far shorter than a sample, at a sub-sample time, on a heavy object: damped sines from that time on."""
    engine = Engine(RATE)
    modes = bell(5, modal_mass=1e6)
    law = (1e-3, 1e16, 0.0, 1.5)
    strike(engine, add(engine, modes, level=1e7), time=1000.25, law=law, v_in=2.0)
    out = engine.process(4096)[:, 0].astype(float)
    momentum = 1e-3 * (2.0 - contact.release_velocity(2.0, 0.0))
    middle = 1000.25 / RATE + 0.5 * contact_time(2.0, *law)
    t = np.maximum(np.arange(4096) / RATE - middle, 0)[:, None]
    phi = modes.strike[0] * modes.pickup[0]
    expected = 1e7 * momentum * (phi * np.exp(-modes.decay * t) * np.sin(2 * np.pi * modes.frequency * t)).sum(axis=1)
    assert np.abs(out - expected).max() < 1e-4 * np.abs(expected).max()


@pytest.mark.parametrize("block", [1, 37, 480, 4096])
def test_block_size_changes_no_bit(block):
    def run(size):
        engine = Engine(RATE)
        handles = [add(engine, bell(n), pan=p) for n, p in ((5, -1.0), (24, 0.0), (40, 0.7))]
        for i in range(30):
            law = (0.01, 10.0 ** (4 + i % 7), 0.5, 1.5)
            strike(engine, handles[i % 3], time=97.31 * i, v_in=0.1 + 0.1 * i, law=law)
        engine.send([(1500.0, Command.TUNE, handles[0], (1.5,)), (1600.0, Command.GAIN, handles[1], (0.2,))])
        engine.send([(2000.0, Command.FREE, handles[2], (1.0,)), (2500.0, Command.DAMP, handles[1], (0.7,))])
        return np.concatenate([engine.process(size) for _ in range(math.ceil(8192 / size))])[:8192]

    np.testing.assert_array_equal(run(block), run(64))


def test_a_heavier_object_is_quieter_by_its_mass():
    def peak(mass):
        engine = Engine(RATE)
        strike(engine, add(engine, bell(modal_mass=mass), level=10.0))
        return np.abs(engine.process(4096)).max()

    assert peak(100.0) / peak(1000.0) == pytest.approx(10, rel=0.02)


@pytest.mark.parametrize("mu", [0.3, 0.0])
def test_the_effective_mass_is_what_the_coupled_contact_gives(mu):
    """m phi^2 = .2 on one slow mode: DOP853 of striker and mode together gives the momentum that m* stands for."""
    from scipy.integrate import solve_ivp

    modal_mass, (m, k, a), frequency = 0.1, (0.02, 1e10, 1.5), 200.0
    omega = 2 * math.pi * frequency

    def motion(_t, y):
        x, v, q, p = y
        f = k * max(x - q, 0.0) ** a * max(1 + mu * (v - p), 0.0)
        return [v, -f / m, p, f / modal_mass - omega**2 * q]

    def apart(t, y):
        return y[0] - y[2] if t > 1e-7 else 1.0

    apart.terminal, apart.direction = True, -1
    run = solve_ivp(motion, (0, 1), (0, 1.0, 0, 0), "DOP853", events=apart, rtol=1e-11, atol=1e-14, first_step=1e-8)
    _, _, q, p = run.y[:, -1]
    expected = math.hypot(omega * q, p)
    engine = Engine(RATE)
    modes = listed(frequency=[frequency], t60=[1000.0], modal_mass=modal_mass, mass=1.0, top=20_000)
    strike(engine, add(engine, modes, level=math.sqrt(modal_mass) * 0.1), law=(m, k, mu, a))
    got = np.abs(engine.process(4096)[400:]).max() / 0.1 / math.sqrt(modal_mass)
    wall = m * (1 + contact.restitution(1.0, mu)) / modal_mass
    assert engine.counter("impacts") == 1 and engine.counter("coupled") == 0
    assert got == pytest.approx(expected, rel=1e-3)
    assert abs(wall / expected - 1) > 0.15  # so the correction matters


def test_silence_costs_nothing_and_is_silent():
    engine = Engine(RATE)
    handle = add(engine, bell(64, t60=0.2))
    engine.process(640)
    assert engine.counter("live_modes") == 0 and engine.counter("sounding") == 0
    strike(engine, handle)
    engine.process(640)
    assert engine.counter("live_modes") == 64
    engine.process(48_000)
    assert engine.counter("live_modes") == 0 and engine.quiet()
    assert not engine.process(1024).any()


def test_modes_fall_silent_one_group_after_another():
    engine = Engine(RATE)
    t60 = np.repeat([2.0, 0.5, 0.05], 8)
    modes = listed(frequency=np.linspace(500, 5000, 24), t60=t60, modal_mass=10.0, mass=10.0, top=20_000)
    strike(engine, add(engine, modes))
    live = []
    for _ in range(100):
        engine.process(4800)
        live.append(engine.counter("live_modes"))
    assert live == sorted(live, reverse=True) and {24, 16, 8, 0} >= set(live) >= {16, 8, 0}


def test_nothing_leaves_above_full_scale_and_it_is_counted():
    engine = Engine(RATE)
    strike(engine, add(engine, level=1e4))
    out = engine.process(9600)
    assert np.abs(out).max() <= 1.0 and np.abs(out).max() > 0.9
    assert engine.counter("limited") > 100 and engine.counter("limit_lowest") < 0.1
    quiet = Engine(RATE)
    strike(quiet, add(quiet, level=1e-2))
    quiet.process(9600)
    assert quiet.counter("limited") == 0


def test_a_limited_sound_recovers():
    engine = Engine(RATE)
    handle = add(engine, bell(8, t60=0.05), level=1e3)
    strike(engine, handle)
    engine.process(96_000)
    soft = strike(engine, handle, v_in=1e-4) or engine.process(4800)
    reference = Engine(RATE)
    strike(reference, add(reference, bell(8, t60=0.05), level=1e3), v_in=1e-4)
    np.testing.assert_allclose(np.abs(soft).max(), np.abs(reference.process(4800)).max(), rtol=1e-3)


def test_a_fault_silences_its_object_alone():
    engine = Engine(RATE)
    good, bad = add(engine), add(engine)
    reference = Engine(RATE)
    lone = add(reference)
    for e, h in ((engine, good), (reference, lone)):
        strike(e, h)
    strike(engine, bad)
    engine.process(QUANTUM), reference.process(QUANTUM)
    engine.state["y1"][0][bad.first] = np.nan
    np.testing.assert_array_equal(engine.process(4800), reference.process(4800))
    assert engine.counter("faults") == 1 and engine.state["objects"][0][bad.slot]["faults"] == 1
    strike(engine, bad)  # and it plays again
    assert np.isfinite(engine.process(4800)).all() and engine.counter("sounding") == 2


@pytest.mark.parametrize(
    ("command", "value"),
    [(Command.GAIN, 0.01), (Command.PAN, 1.0), (Command.TUNE, 1.3), (Command.DECAY, 0.3), (Command.DAMP, 1.0)],
)
def test_changes_do_not_click(command, value):
    """A click is energy far above the only mode there is."""

    def run(changed):
        engine = Engine(RATE)
        modes = listed(frequency=[300.0], t60=[5.0], modal_mass=10.0, mass=10.0, top=20_000)
        handle = add(engine, modes, level=5.0)
        strike(engine, handle, law=(0.01, 1e6, 0.5, 1.5))
        engine.process(4800)
        if changed:
            engine.send([(NOW, command, handle, (value,))])
        out = engine.process(4096)[:, 0]
        spectrum = np.abs(np.fft.rfft(out * np.blackman(len(out))))
        return spectrum[600:].max() / spectrum.max()  # above 7 kHz

    assert run(False) < 1e-6
    assert run(True) < 3e-4


def test_changes_while_nobody_hears_are_there_at_once():
    def sound(before, after):
        engine = Engine(RATE)
        handle = add(engine, gain=before[0], pan=before[1])
        engine.process(640)
        engine.send([(NOW, Command.GAIN, handle, after[:1]), (NOW, Command.PAN, handle, after[1:])])
        strike(engine, handle)
        return engine.process(640)

    np.testing.assert_array_equal(sound((1.0, 0.0), (0.2, 0.7)), sound((0.2, 0.7), (0.2, 0.7)))


def test_pan_goes_where_it_says():
    for pan, quiet, loud in ((-1.0, 1, 0), (1.0, 0, 1)):
        engine = Engine(RATE)
        strike(engine, add(engine, pan=pan))
        levels = np.abs(engine.process(4800)).max(axis=0)
        assert levels[quiet] < 1e-6 * levels[loud]
    middle, left = Engine(RATE), Engine(RATE)
    strike(middle, add(middle)), strike(left, add(left, pan=-1.0))
    ratio = np.abs(left.process(4800)[:, 0]).max() / np.abs(middle.process(4800)[:, 0]).max()
    assert ratio == pytest.approx(math.sqrt(2), rel=1e-3)  # equal power


def test_the_limiter_lets_go_within_half_a_second():
    engine = Engine(RATE)
    strike(engine, add(engine, bell(8, t60=0.02), level=1e4))
    engine.process(2400)
    assert engine.counter("limit") < 0.5
    engine.process(24_000)
    assert engine.counter("limit") > 0.95


def test_a_mode_is_heard_at_either_side():
    """One that only the right pickup hears rings on as long as it is heard there."""
    modes = Modes(np.array([500.0]), np.array([3.0]), np.full((4, 1), 0.1), np.array([[0.0], [0.1]]), 1.0)
    engine = Engine(RATE)
    strike(engine, add(engine, modes, level=1e3), law=(1e-4, 1e9, 0.5, 1.5))
    out = engine.process(48_000)
    assert np.abs(out[24_000:, 1]).max() > 0.1 * np.abs(out[:, 1]).max() and np.abs(out[:, 0]).max() < 1e-6


def test_no_subnormal_slows_the_callback():
    engine = Engine(RATE)
    handle = add(engine)
    strike(engine, handle)
    engine.process(QUANTUM)
    engine.state["y1"][0][handle.first] = engine.state["y2"][0][handle.first] = 1e-310
    engine.state["live_modes"] = 0
    engine.process(1)
    assert engine.state["y2"][0][handle.first] == 0.0


def test_panic_keeps_frees_and_what_comes_later():
    engine = Engine(RATE)
    going, staying = add(engine), add(engine)
    engine.process(QUANTUM)
    engine.send([(1000.0, Command.FREE, going, (1.0,)), (2000.0, Command.IMPACT, staying, (1.0, 0.5, *HARD, 1.0))])
    engine.send([(500.0, Command.PANIC, None, ()), (3000.0, Command.IMPACT, staying, (1.0, 0.5, *HARD, 1.0))])
    out = engine.process(4800)
    assert engine.counter("active") == 1 and engine.counter("impacts") == 1
    assert not out[: 3000 - QUANTUM].any() and out[3000:].any()


@pytest.mark.parametrize("v_in", [1e-9, 1e-150, 1e-300, 5e-324])
@pytest.mark.parametrize("mu", [0.0, 1e-300, 5e-324, 1e6])
def test_no_contact_lasts_for_ever(v_in, mu):
    engine = Engine(RATE)
    handle = add(engine)
    strike(engine, handle, v_in=v_in, law=(0.01, 1e9, mu, 1.5))
    engine.process(48_000)
    assert engine.counter("contacts_active") == 0 and engine.counter("faults") == 0


def test_a_strike_never_gives_more_energy_than_the_striker_had():
    """Light objects, heavy strikers, no losses: sum |z|^2/2 of the modes and what the striker keeps."""
    rng = np.random.default_rng(5)
    for _ in range(60):
        n = int(rng.integers(1, 60))
        frequency = np.sort(10 ** rng.uniform(1.5, 4.2, n))
        engine = Engine(RATE)
        modal_mass = 10 ** rng.uniform(-4, 1)
        modes = listed(frequency=frequency, t60=np.full(n, 1e6), modal_mass=modal_mass, mass=1.0, top=20_000)
        m, v_in, mu, a = 10 ** rng.uniform(-4, 0), 10 ** rng.uniform(-1, 1), rng.choice([0.0, 0.1]), rng.uniform(1, 3)
        k = 10 ** rng.uniform(4, 12)
        handle = add(engine, modes, level=1e-3)
        strike(engine, handle, v_in=v_in, law=(m, k, mu, a))
        engine.process(48_000)
        columns = (
            engine.state[name][0][handle.first : handle.first + n] for name in ("y1", "y2", "a1", "a2", "weight")
        )
        z2 = [
            (re * re + im * im) / w**2 for re, im, w in ((*state_of(*c[:4]), c[4]) for c in zip(*columns, strict=True))
        ]
        assert 0.5 * sum(z2) < 0.5 * m * v_in**2 * (1 + 1e-3), (n, modal_mass, m, v_in, mu, a, k)


def test_soft_strikes_do_not_see_high_modes():
    """Modes far above the pulse's spectrum take nothing from it, however many they are."""

    def level(frequency):
        engine = Engine(RATE)
        modes = listed(frequency=frequency, t60=np.full(len(frequency), 1.0), modal_mass=0.05, mass=1.0, top=22_000)
        strike(engine, add(engine, modes, level=1e-3), law=(0.05, 1e5, 0.3, 1.5))
        return np.abs(np.fft.rfft(engine.process(24_000)[:, 0]))[50]  # of the mode at 100 Hz

    few = np.array([100.0])
    assert level(np.concatenate([few, np.linspace(12_000, 20_000, 200)])) == pytest.approx(level(few), rel=0.01)


def test_events_take_their_order_from_time_and_then_arrival():
    engine = Engine(RATE)
    handle = add(engine)
    strike(engine, handle, time=500.0)
    engine.send([(400.0, Command.GAIN, handle, (0.0,)), (400.0, Command.GAIN, handle, (1.0,))])
    engine.process(4800)
    assert engine.state["objects"][0][handle.slot]["amplitude"] == 1.0
    assert engine.counter("late") == 0
    strike(engine, handle, time=10.0)
    engine.process(QUANTUM)
    assert engine.counter("late") == 1


def test_freed_objects_give_their_room_back():
    engine = Engine(RATE)
    for _ in range(3 * MODES // 4096):
        handle = add(engine, bell(1024))
        strike(engine, handle)
        engine.send([(NOW, Command.FREE, handle, (1.0,))])
        engine.leave(handle)
        engine.process(9600)
    assert engine.counter("active") == 0


def test_free_waits_for_silence_and_then_ignores_commands():
    engine = Engine(RATE)
    handle = add(engine, bell(8, t60=0.1))
    strike(engine, handle)
    engine.send([(NOW, Command.FREE, handle, (0.0,))])
    assert engine.process(960).any() and engine.counter("active") == 1
    engine.process(48_000)
    assert engine.counter("active") == 0
    strike(engine, handle)
    assert not engine.process(960).any()


def test_panic_silences_at_once_and_forgets_strikes():
    engine = Engine(RATE)
    handle = add(engine)
    strike(engine, handle)
    strike(engine, handle, time=5000.0)
    engine.process(1024)
    engine.send([(NOW, Command.PANIC, None, ())])
    assert not engine.process(9600)[64:].any()
    strike(engine, handle)
    assert engine.process(9600).any()


def test_capacities_are_kept_and_said():
    engine = Engine(RATE)
    handle = add(engine)
    with pytest.raises(EngineFull, match=f"{RING + 1} events"):
        engine.send([(NOW, Command.IMPACT, handle, (1.0, 0.5, *HARD, 1.0))] * (RING + 1))
    for _ in range(OBJECTS - 1):
        engine.lay_out(bell(8), 1.0)
    with pytest.raises(EngineFull, match=f"all {OBJECTS} are taken"):
        engine.lay_out(bell(8), 1.0)
    with pytest.raises(EngineFull, match="modes"):
        big = Engine(RATE)
        for _ in range(MODES // 1024 + 1):
            big.lay_out(bell(1024), 1.0)


def test_a_full_queue_waits_in_the_ring_and_loses_nothing():
    engine = Engine(RATE)
    handle = add(engine)
    engine.process(QUANTUM)
    for batch in range(2):
        engine.send([(1e4 + i, Command.SYNC, handle, (batch * EVENTS + i,)) for i in range(EVENTS)])
        engine.process(QUANTUM)
    assert engine.counter("queued") == EVENTS and engine.room() == 0
    engine.process(30_000)
    assert engine.counter("queued") == 0 and engine.room() == RING and engine.counter("synced") == 2 * EVENTS - 1


def test_too_many_contacts_are_left_out_and_counted():
    engine = Engine(RATE)
    handle = add(engine)
    slow = (1e-6, 1e-2, 0.5, 1.5)
    engine.send([(NOW, Command.IMPACT, handle, (1.0, 0.5, *slow, 0.001))] * (CONTACTS + 10))
    engine.process(QUANTUM)
    assert engine.counter("contacts_dropped") == 10 and engine.counter("contacts_active") == CONTACTS
    engine.process(48_000)
    assert engine.counter("contacts_active") == 0


def test_positions_select_modes():
    frequency = np.array([500.0, 1500.0])
    positions = np.linspace(0, 1, 33)
    shape = np.stack([np.sin(np.pi * positions), np.sin(2 * np.pi * positions)], axis=1)
    modes = Modes(frequency, np.full(2, 2.0), shape * 0.1, np.full((2, 2), 0.1), 1.0)

    def levels(position):
        engine = Engine(RATE)
        strike(engine, add(engine, modes, level=1e3), position=position, law=(1e-4, 1e9, 0.5, 1.5))
        spectrum = np.abs(np.fft.rfft(engine.process(48_000)[:, 0]))
        return spectrum[500], spectrum[1500]

    low, high = levels(0.5)
    assert high < 1e-3 * low
    quarter_low, quarter_high = levels(0.25)
    assert quarter_low / low == pytest.approx(math.sin(math.pi / 4), rel=2e-3)
    assert quarter_high / low == pytest.approx(1.0, rel=0.02)
    assert levels(0.0)[0] < 1e-6 * low


@pytest.mark.parametrize("rate", [8000.0, 22_050.0, 44_100.0, 192_000.0])
def test_partials_and_decays_at_any_rate(rate):
    engine = Engine(rate)
    modes = listed(frequency=[440.0, 3000.0], t60=[0.6, 1.5], modal_mass=10.0, mass=10.0, top=engine.top_frequency)
    strike(engine, add(engine, modes, level=1.0))
    out = engine.process(round(2 * rate))[:, 0].astype(float)
    for f, t60 in ((440.0, 0.6), (3000.0, 1.5)):
        first, second = (analytic(out, f, rate, start) for start in (0.1, 0.4))
        cents = 1200 * math.log2((np.angle(second / first) / (2 * math.pi * 0.3) + f) / f)
        assert abs(cents) < 0.1
        assert math.log(1000) * 0.3 / -math.log(abs(second / first)) == pytest.approx(t60, rel=0.01)


def analytic(out, frequency, rate, start):
    """Amplitude and phase at a frequency around a time, in the frame of that frequency."""
    n = round(0.1 * rate)
    at = round(start * rate)
    t = (at + np.arange(n)) / rate
    return (out[at : at + n] * np.exp(-2j * np.pi * frequency * t) * np.blackman(n)).sum()


def test_no_mode_above_the_nyquist_share():
    engine = Engine(22_050.0)
    frequency = [1000.0, 10_400.0, 10_500.0]
    handle = add(engine, listed(frequency=frequency, t60=[1, 1, 1], modal_mass=1.0, mass=1.0, top=20_000))
    obj = engine.state["objects"][0][handle.slot]
    strike(engine, handle)
    engine.process(QUANTUM)
    assert (engine.state["frequency"][0][obj["first"] : obj["first"] + obj["size"]] > 0).sum() == 2
    engine.send([(NOW, Command.TUNE, handle, (1.01,))])
    engine.process(QUANTUM)
    lane = obj["first"] + 1
    assert engine.state["response"][0][0] != 0 and engine.state["response"][0][1] == 0  # of moment 0: it is not excited
    engine.process(22_050 // 4)
    assert abs(engine.state["y1"][0][lane]) < 1e-9  # and what it rang has faded
