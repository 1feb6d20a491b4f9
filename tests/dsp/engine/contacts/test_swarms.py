"""Swarms in the engine: the same blows at any sampling rate, as loud, and no more energy than they bring."""

from itertools import pairwise

import numpy as np
import pytest

from carom.dsp.bodies import listed
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import QUANTUM, End
from carom.dsp.resonator.mode import mode_energy
from carom.dsp.runtime.arena import EngineFull
from carom.dsp.runtime.engine import NOW, Engine
from carom.dsp.swarm.record import PULSES, SWARMS
from carom.dsp.swarm.tables import pulse_table
from tests.dsp.engine.support import RATE, free, gesture, impact, panic, steer, stop

GRAIN = (1e-4, 3e8, 0.3, 1.5)
"""m, k, mu, a of a grain of 0.1 g: 20 µs at 1 m/s."""
FINGER = (0.01, 1e6, 1.0, 1.5)
SHAKE = {"rate": 2000.0, "speed": 0.5, "seed": 7}
CRUMPLE = {"speed": 0.5, "density": 4000.0, "energy": 1e-6, "seed": 7}
RAIN = {"rate": 2000.0, "seed": 7}
POUR = {"rate": 2000.0, "height": 0.1, "seed": 7}
STEP = {"force": 700.0, "crackles": 1.0, "duration": 0.9, "energy": 1e-6, "seed": 7}


def plate(count=40, modal_mass=0.5, t60=0.3):
    """Return a body whose modes lie up to 16 kHz."""
    frequency = 150.0 * np.arange(1, count + 1) ** 1.25
    return listed(
        frequency=frequency, t60=np.full(count, t60), modal_mass=np.full(count, modal_mass), mass=modal_mass, top=20_000
    )  # fmt: skip


def swarmed(kind, keys, rate=RATE, seconds=1.0, events=(), modes=None, blocks=(), law=GRAIN):
    """Return the left output of a swarm on an object, and its engine."""
    engine = Engine(rate)
    handle = engine.add(modes or plate(), 1.0)
    pulses = engine.lay_out_pulses(0.0 if kind == "rain" else law[3])
    events = [each._replace(time=each.time * rate) for each in events]
    engine.send([gesture(kind, handle, law, 0.0, 7, **pulses, **{"spread": 1.0, **keys}), *events])
    left, parts = round(seconds * rate), []
    sizes = iter(blocks)
    while left > 0:
        size = min(next(sizes, left), left)
        parts.append(engine.process(size)[:, 0].astype(float))
        left -= size
    return np.concatenate(parts), engine


def third_octaves(sound, rate):
    """Return the power (dB) in bands of a third of an octave from 100 Hz to 16 kHz."""
    spectrum = np.abs(np.fft.rfft(sound)) ** 2 / len(sound) ** 2
    bins = np.arange(len(spectrum)) * rate / len(sound)
    edges = 100.0 * 2.0 ** (np.arange(23) / 3.0)
    return 10.0 * np.log10([spectrum[(bins >= low) & (bins < high)].sum() for low, high in pairwise(edges)])


def drawn(engine):
    """Return what the blows of an engine's swarm add up to."""
    swarm = engine.state[0]["swarms"][0]
    return int(swarm["index"]), float(swarm["time"]), float(swarm["reached"]), float(swarm["energy"])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "keys"),
    [
        ("shake", SHAKE), ("shake", {**SHAKE, "excitation": 0.6, "memory": 0.01}), ("crumple", CRUMPLE),
        ("rain", RAIN), ("pour", POUR), ("step", STEP),
    ],
)  # fmt: skip
def test_blows_are_the_same_and_as_loud_at_any_sampling_rate(kind, keys):
    name = {"crumple": "speed", "step": "force"}.get(kind, "rate")
    events = [steer(7, name, 2.0 * keys[name], 0.3), steer(7, name, keys[name], 0.6001), stop(7, 0.95)]
    found, bands = [], []
    for rate in (44_100.0, 48_000.0, 96_000.0, 192_000.0):
        sound, engine = swarmed(kind, keys, rate, 1.3, events)
        found.append(drawn(engine))
        bands.append(third_octaves(sound, rate))
        assert (
            engine.ended()[0][1] == (End.RESTED if kind == "step" else End.STOPPED)
            and not engine.state[0]["swarms"]["used"].any()
        )
    assert found[0][0] > 1500 and found == [found[0]] * 4
    assert np.abs(np.array(bands) - bands[0]).max() < 0.2


@pytest.mark.slow
def test_soft_blows_are_as_loud_at_any_sampling_rate():
    """Blows of some 2 ms last for 400 frames at 192 kHz: a grid of so many samples would not hold them."""
    law, bands = (1e-4, 3e3, 0.3, 1.5), []
    for rate in (44_100.0, 48_000.0, 88_200.0, 96_000.0, 192_000.0):
        bands.append(third_octaves(swarmed("shake", SHAKE, rate, law=law)[0], rate))
    heard = bands[0] > bands[0].max() - 60.0
    assert heard.sum() > 8 and np.abs(np.array(bands) - bands[0])[:, heard].max() < 0.3


@pytest.mark.slow
def test_rain_on_a_wide_level_is_as_loud_as_its_drops_at_all_distances_are():
    """The mean of 1/r^2 over an area up to R times as far as its middle is ln(R^2)/(R^2 - 1)."""
    near, far = ((swarmed("rain", {**RAIN, "rate": 3e5, "reach": reach})[0][4800:] ** 2).mean() for reach in (1.0, 4.0))
    assert far / near == pytest.approx(np.log(16.0) / 15.0, rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("speed", [0.1, 2.0])
def test_a_swarm_of_one_blow_sounds_as_that_impact(speed):
    """The swarm's first blow, at its time and place, against the closed form's impact, up to 0.3 of the rate."""
    keys = {"rate": 3.0, "speed": speed, "seed": 11, "spread": 0.0, "position": 0.5, "gain": 1e3}
    modes = plate(24, modal_mass=20.0)
    sound, engine = swarmed("shake", keys, seconds=0.001, modes=modes)
    while (swarm := engine.state[0]["swarms"][0])["index"] == 0:
        sound = np.concatenate([sound, engine.process(QUANTUM)[:, 0]])
    time, energy = float(swarm["time"]), float(swarm["energy"])
    sound = np.concatenate([sound, engine.process(1024)[:, 0]])
    assert swarm["index"] == 1
    other = Engine(RATE)
    handle = other.add(modes, 1.0)
    begin = (time + 1e-3) * RATE
    other.send([impact(handle, GRAIN, begin, np.sqrt(2.0 * energy / GRAIN[0]), gain=1e3)])
    wanted = other.process(len(sound))[:, 0]
    after = np.clip((np.arange(len(sound)) - begin - 300) / 700, 0.0, 1.0)
    window = 0.5 + 0.5 * np.cos(np.pi * after)
    found, right = (np.fft.rfft(each * window)[: round(0.3 * len(sound))] for each in (sound, wanted))
    assert np.abs(found - right).max() < 4e-3 * np.abs(right).max()


def energy_of(engine):
    """Return the energy (J) of the first object's modes."""
    bank, obj = engine.state[0]["bank"], engine.state[0]["objects"][0]
    names = ("y1", "y2", "a1", "a2", "weight")
    felt = slice(int(obj["first"]), int(obj["first"]) + int(obj["felt"]))
    return sum(
        mode_energy.py_func(*each) for each in zip(*(bank[name][felt] for name in names), strict=True) if each[4]
    )


@pytest.mark.slow
@pytest.mark.parametrize("modal_mass", [1e-5, 1e-4, 1e-2, 1.0])
@pytest.mark.parametrize(("kind", "keys"), [("shake", SHAKE), ("rain", RAIN)])
def test_modes_get_no_more_energy_than_the_blows_bring(kind, keys, modal_mass):
    modes = plate(40, modal_mass, t60=100.0)
    _, engine = swarmed(kind, {**keys, "rate": 300.0}, seconds=1.0, modes=modes)
    brought = drawn(engine)[3]
    assert 0.0 < energy_of(engine) < brought
    if modal_mass == 1e-4:
        assert energy_of(engine) > 0.005 * brought


@pytest.mark.parametrize(
    ("kind", "keys"),
    [
        ("shake", {**SHAKE, "rate": 1e6}), ("crumple", {**CRUMPLE, "speed": 100.0, "density": 1e4, "excitation": 0.9}),
        ("step", {**STEP, "crackles": 400.0}),
    ],
)  # fmt: skip
def test_a_dense_stream_of_heavy_grains_brings_no_more_energy_than_they_have(kind, keys):
    """Some hundred kilograms a second, before which a plate of half a kilogram moves as a whole: ten times as much."""
    _, engine = swarmed(kind, keys, seconds=0.02, modes=plate(t60=100.0), law=(1e-3, *GRAIN[1:]))
    assert 1e-3 * drawn(engine)[3] < energy_of(engine) < drawn(engine)[3]


@pytest.mark.slow
@pytest.mark.parametrize(("modal_mass", "rate"), [(0.1, 22_050.0), (0.1, 192_000.0), (10.0, 44_100.0)])
def test_blows_that_last_longer_than_the_grid_bring_no_more_energy(modal_mass, rate):
    """Soft grains of 4 g, each of whose blows lasts a tenth of a second: the modes from 150 Hz on hardly hear them."""
    modes, law = plate(24, modal_mass, t60=100.0), (4e-3, 7e3, 0.3, 2.5)
    _, engine = swarmed("crumple", {**CRUMPLE, "spread": 0.0}, rate, 0.2, modes=modes, law=law)
    assert engine.stats.coupled == 0 and drawn(engine)[3] > 0.0
    assert 0.0 < energy_of(engine) < 0.01 * drawn(engine)[3]


@pytest.mark.parametrize("stopped", [False, True])
def test_a_step_is_over_by_itself_or_when_it_is_stopped(stopped):
    _, engine = swarmed("step", STEP, seconds=1.0, events=[stop(7, 0.4)] if stopped else [])
    assert engine.ended() == [(7, End.STOPPED if stopped else End.RESTED)]
    count, time, *_ = drawn(engine)
    assert count == pytest.approx((0.5 if stopped else 1.0) * 2100.0, rel=0.08)
    assert time < (0.4 if stopped else 0.9)


def test_a_step_crackles_as_the_force_of_a_foot_changes():
    """Nine tenths of the crackles with each change of the force, as multiples of the weight, and a tenth evenly."""
    times, changes = np.array([0.0, 0.22, 0.5, 0.78, 1.0]), np.array([1.15, 0.4, 0.35, 1.1])
    keys = {**STEP, "crackles": 10.0}
    _, engine = swarmed("step", keys, seconds=1e-3)
    counts = []
    for end in times[1:]:
        engine.process(round((0.9 * end + 1e-3) * RATE) - engine.position)
        counts.append(drawn(engine)[0])
    expected = 21_000.0 * (0.9 * changes / 3.0 + 0.1 * np.diff(times))
    assert np.diff([0, *counts]) == pytest.approx(expected, rel=0.06)


def test_a_step_that_is_steered_just_after_its_force_turns_has_the_same_crackles_at_any_sampling_rate():
    """The force turns at 0.099 s, within the same 64 frames at 22 kHz."""
    events = [steer(7, "force", 7000.0, 0.0995), steer(7, "steepness", 2.5, 0.1995)]
    found = [drawn(swarmed("step", STEP, rate, 1.0, events)[1]) for rate in (22_050.0, 48_000.0, 192_000.0)]
    assert found[0][0] > 1000 and found == [found[0]] * 3


@pytest.mark.parametrize("duration", [0.05, 0.0731, 0.65])
def test_a_short_step_has_the_same_crackles_at_any_sampling_rate(duration):
    """A step's rate falls fast at last: a bend on the lattice of knots was 1e-6 of it off, and blows 15 ns."""
    keys = {**STEP, "duration": duration, "force": 2e4 * duration}
    found = [drawn(swarmed("step", keys, rate, duration + 0.01)[1]) for rate in (22_050.0, 48_000.0, 192_000.0)]
    assert found[0][0] > 700 and found == [found[0]] * 3


SHATTER = {"velocity": 3.0, "pieces": 80.0, "whole": 0.1, "height": 0.1, "seed": 7, "spread": 0.0}


@pytest.mark.slow
@pytest.mark.parametrize("stage", [0.0, 1.0])
def test_shattering_is_alike_at_any_rate_and_spends_no_more_than_it_has(stage):
    """Cracks have a quarter of the energy of what hits; pieces land with as much at most and that of their fall."""
    found, spent, bands = [], [], []
    for rate in (44_100.0, 48_000.0, 96_000.0):
        sound, engine = swarmed("shatter", {**SHATTER, "stage": stage}, rate, 2.5)
        assert engine.ended() == [(7, End.RESTED)] and not engine.state[0]["swarms"]["used"].any()
        swarm = engine.state[0]["swarms"][0]
        pieces = [name for name in swarm.dtype.names if name.endswith("_of") or name == "bounced"]
        told = np.concatenate([swarm[name].ravel() for name in pieces])
        found.append((*drawn(engine)[:3], engine.stats.impacts, *told))
        spent.append(drawn(engine)[3])
        bands.append(third_octaves(sound, rate))
    assert found[1] == found[0] == found[2]
    assert spent == pytest.approx([spent[0]] * 3, rel=1e-12)  # pieces are summed quantum by quantum
    hit = 0.25 * 0.5 * 0.1 * 3.0**2
    assert spent[0] <= hit * (1 + 1e-9) if stage == 0.0 else spent[0] > 0.0
    assert found[0][3] > (100 if stage == 0.0 else 160)
    assert np.abs(np.array(bands) - bands[0]).max() < 0.2


def test_pieces_take_no_more_energy_to_an_object_than_they_bring():
    modes = plate(40, 1e-3, t60=100.0)
    _, engine = swarmed("shatter", {**SHATTER, "stage": 1.0}, modes=modes, seconds=1.5)
    assert 0.0 < energy_of(engine) < drawn(engine)[3]


def test_pieces_of_all_sizes_have_edges_alike():
    """Pieces are of one sheet: how long the blow of one lasts follows from its mass and speed alone. Had a piece of a
    hundred times the mass an edge of 4.6 times the radius, its blow would be shorter by a quarter."""
    widths, mass_before = [], 0.0
    for whole in (1e-3, 1e-1):
        keys = {**SHATTER, "stage": 1.0, "pieces": 1.0, "whole": whole}
        _, engine = swarmed("shatter", keys, modes=plate(modal_mass=1e6), seconds=0.4, law=(1e-4, 3e8, 0.0, 1.5))
        landed = engine.state[0]["scratch"]["batch"]
        mass, v, width = (float(landed[name][0]) for name in ("mass", "v", "width"))
        assert v > 0.0 and mass > 10.0 * mass_before
        widths.append(width - (np.log(mass) - 0.5 * np.log(v)) / 2.5)
        mass_before = mass
    assert widths[1] == pytest.approx(widths[0], abs=1e-3)


def test_a_swarm_pauses_at_a_rate_of_0_and_goes_on():
    events = [steer(7, "rate", 0.0, 0.2), steer(7, "rate", 2000.0, 0.6)]
    _, engine = swarmed("shake", SHAKE, seconds=0.55, events=events)
    count = drawn(engine)[0]
    assert count == pytest.approx(400, abs=80)
    engine.process(round(0.2 * RATE))
    assert drawn(engine)[0] - count == pytest.approx(300, abs=70)


def test_a_ramp_of_the_rate_gives_the_blows_of_its_integral():
    ramp = Command(0.0, Kind.STEER, value=4000.0, gesture=7, parameter="rate", values={"over": 1.0})
    counts = []
    for rate in (44_100.0, 96_000.0):
        _, engine = swarmed("shake", {**SHAKE, "rate": 0.0}, rate, 1.0, [ramp])
        counts.append(drawn(engine)[:2])
    assert counts[0][0] == pytest.approx(2000, abs=180)
    assert counts[0] == pytest.approx(counts[1], rel=0.005)


STEERED = {
    "shake": (SHAKE, {"rate": (100.0, 4000.0), "speed": (0.1, 1.0), "evenness": (1.0, 4.0)}),
    "crumple": (CRUMPLE, {"speed": (0.1, 2.0), "density": (1000.0, 5000.0)}),
    "step": (STEP, {"force": (100.0, 1000.0), "crackles": (0.1, 2.0)}),
}


@pytest.mark.parametrize("kind", STEERED)
def test_blows_of_ramps_that_begin_where_a_quantum_does_are_the_same_at_any_block(kind):
    """Ramps, and a stop, on the beginnings of quanta and elsewhere."""
    keys, steered = STEERED[kind]
    numbers, time, events = np.random.default_rng(4), 0.0, []
    for name, (low, high) in [*steered.items()] * 2:
        time += numbers.choice([QUANTUM / RATE * numbers.integers(1, 40), numbers.uniform(0.01, 0.05)])
        values = {"over": float(numbers.choice([0.033, 20 * QUANTUM / RATE]))}
        value = float(numbers.uniform(low, high))
        events.append(Command(time, Kind.STEER, value=value, gesture=7, parameter=name, values=values))
    events.append(stop(7)._replace(time=QUANTUM / RATE * 260))
    found = [swarmed(kind, keys, seconds=0.4, events=events, blocks=each) for each in ((), [37] * 999, [63, 1000] * 99)]
    whole, engine = found[0]
    assert drawn(engine)[0] > 50
    for sound, other in found[1:]:
        assert drawn(other) == drawn(engine) and np.array_equal(sound, whole)


def test_there_is_room_for_so_many_swarms_and_no_more():
    engine = Engine(RATE)
    handle, pulses = engine.add(plate(), 1.0), engine.lay_out_pulses(1.5)
    engine.send([gesture("shake", handle, GRAIN, 0.0, n + 1, **pulses, **SHAKE) for n in range(SWARMS + 1)])
    assert np.abs(engine.process(4800)).max() > 0.0
    assert engine.ended() == [(SWARMS + 1, End.NO_ROOM)]


EXPONENTS = [1.0 + 0.1 * n for n in range(PULSES + 1)]


@pytest.fixture
def tables(monkeypatch):
    """Tables of pulses that are made at once: all are those of one exponent."""
    monkeypatch.setattr("carom.dsp.swarm.tables.pulse_table", lambda exponent: pulse_table(GRAIN[3]))


def shaken(engine, handle, exponent, time=NOW, number=0):
    """Return the command of a shake whose table is laid out."""
    values = {**SHAKE, "spread": 1.0, **engine.lay_out_pulses(exponent)}
    return gesture("shake", handle, (*GRAIN[:3], exponent), time, number, **values)


FATES = {
    "stopped": lambda handle: [stop(n + 1) for n in range(PULSES)],
    "freed at once": lambda handle: [free(handle, True)],
    "panic as they go on": lambda handle: [panic()],
    "panic as they wait": lambda handle: [panic()],
    "object is gone": lambda handle: [],
    "no room": lambda handle: [],
}
"""The commands that end swarms on an object, by the name of their fate."""


@pytest.mark.slow
@pytest.mark.parametrize("fate", FATES)
def test_swarms_that_are_over_leave_the_places_of_their_tables_to_others(fate, tables):
    engine = Engine(RATE)
    handle, crowded = engine.add(plate(4), 1.0), fate == "no room"
    if fate == "object is gone":
        engine.send([free(handle, True)])
    others = [shaken(engine, handle, EXPONENTS[0], NOW, 100 + n) for n in range(SWARMS) if crowded]
    time = 1e6 if "wait" in fate else NOW
    engine.send([*others, *(shaken(engine, handle, each, time, n + 1) for n, each in enumerate(EXPONENTS[:PULSES]))])
    with pytest.raises(EngineFull, match=r"exponent 1.8: others, of 1, of 1.1, .* go on or wait"):
        engine.lay_out_pulses(EXPONENTS[PULSES])
    engine.process(64)
    engine.send(FATES[fate](handle))
    engine.process(24_000)
    ended = [number for number, _ in engine.ended() if number <= PULSES]
    assert sorted(ended) == list(range(1, PULSES + 1))
    free_again = [2.0 + 0.1 * n for n in range(PULSES - crowded)]
    engine.send([shaken(engine, handle, exponent, 1e9) for exponent in free_again])
    with pytest.raises(EngineFull):
        engine.lay_out_pulses(EXPONENTS[PULSES])


def test_a_table_stays_while_a_swarm_goes_on_or_waits_or_is_to_be_sent(tables):
    alone, _ = swarmed("shake", SHAKE, seconds=0.3)
    engine = Engine(RATE)
    handle = engine.add(plate(), 1.0)
    engine.send([shaken(engine, handle, GRAIN[3], 0.0, 7)])
    sound = [engine.process(4_800)]
    engine.send([shaken(engine, handle, 3.0, 1e9, 8)])
    laid = [engine.lay_out_pulses(exponent)["pulses"] for exponent in (GRAIN[3], 3.0)]
    for exponent in EXPONENTS:
        if exponent != GRAIN[3]:
            assert engine.lay_out_pulses(exponent)["pulses"] not in laid
    assert [engine.lay_out_pulses(exponent)["pulses"] for exponent in (GRAIN[3], 3.0)] == laid
    kept = [3.1 + 0.1 * n for n in range(PULSES - 2)]
    assert len({engine.lay_out_pulses(exponent, kept)["pulses"] for exponent in kept} | {*laid}) == PULSES
    with pytest.raises(EngineFull):
        engine.lay_out_pulses(3.9, kept)
    sound.append(engine.process(9_600))
    assert np.array_equal(np.concatenate(sound)[:, 0].astype(float), alone)


def test_heavy_grains_are_contacts_of_their_own():
    _, engine = swarmed("shake", {**SHAKE, "rate": 100.0}, modes=plate(8, 0.01), law=(0.01, 1e7, 0.2, 1.5), seconds=0.5)
    assert engine.stats.impacts == drawn(engine)[0] or engine.stats.impacts == drawn(engine)[0] - 1
    assert engine.stats.coupled > 20


def test_of_many_heavy_grains_few_are_contacts_of_their_own_and_seldom_at_once():
    """Contacts that touch one object at once are solved together, which costs most. They are the strongest blows."""
    heavy = (0.01, 1e7, 0.2, 1.5)
    engine, at_once, speeds = Engine(RATE), [], set()
    handle = engine.add(plate(), 1.0)
    pulses = engine.lay_out_pulses(1.5)
    engine.send([gesture("shake", handle, heavy, 0.0, 7, **pulses, **SHAKE)])
    for _ in range(1_000):
        engine.process(48)
        at_once.append(engine.stats.contacts_active - 1)
        speeds |= set(engine.state[0]["contacts"]["v_in"].tolist())
    assert 80 <= engine.stats.coupled <= 120 and engine.stats.impacts > 1_800
    assert max(at_once[100:]) <= 4 and np.mean(at_once[100:]) < 1.0
    assert np.median(list(speeds - {0.0, 1.0})) > 1.5 * SHAKE["speed"]  # rms


def test_heavy_grains_that_fly_before_a_light_object_are_not_awaited_for_long():
    """The object sways slowly and far, so that it may always reach them yet: two hundred were at once."""
    engine = Engine(RATE)
    handle, pulses = engine.add(plate(8, 0.003, t60=3.0), 1.0), engine.lay_out_pulses(1.5)
    heavy = (0.01, 1e7, 0.2, 1.5)
    engine.send([gesture("shake", handle, heavy, 0.0, 7, **pulses, **{**SHAKE, "rate": 400.0, "speed": 0.02})])
    engine.send([gesture("press", handle, FINGER, 0.0, 8, velocity=0.01, force=5.0)])
    most = 0
    for _ in range(400):
        engine.process(QUANTUM)
        most = max(most, engine.stats.contacts_active)
    assert engine.stats.coupled > 50 and most <= 12


def test_a_swarm_that_ends_leaves_its_place_to_heavy_grains_of_others():
    """Short steps end, one in each quantum or so, while heavy grains take the places that they leave."""
    engine = Engine(RATE)
    heavy = (0.01, 1e7, 0.2, 1.5)
    handle, pulses = engine.add(plate(8, 0.01), 1.0), engine.lay_out_pulses(1.5)
    steps = [
        gesture("step", handle, GRAIN, 0.002 * RATE * n, n + 10, **pulses, **{**STEP, "duration": 0.05, "seed": n})
        for n in range(300)
    ]
    shake = gesture("shake", handle, heavy, 0.001 * RATE, 7, **pulses, **{**SHAKE, "rate": 400.0})
    engine.send([steps[0], shake, *steps[1:]])
    sound = engine.process(round(RATE))
    state = engine.state[0]
    assert np.isfinite(sound).all() and engine.stats.coupled > 50
    assert state["rests_placed"] == 0 and len(set(state["free_roll"])) == len(state["free_roll"])
    seen, index = [], int(state["objects"][0]["contact"])
    while index >= 0:
        assert index not in seen
        seen.append(index)
        index = int(state["contacts"][index]["next"])
    assert len(seen) == engine.stats.contacts_active
