"""Sensors on objects: their signals against sums over modes, and that nothing else hears of them."""

import numpy as np
import pytest
from numpy.polynomial import legendre

from carom.dsp.bodies import Modes, bar
from carom.dsp.bodies.sensor import Sensor
from carom.dsp.engine.memory.commands import Command, Handle, Kind
from carom.dsp.runtime.engine import NOW, Engine
from tests.dsp.engine.support import RATE, bell, free, panic, setting, strike

SOFT = (0.05, 1e5, 0.3, 1.5)  # a contact of some 40 samples
STIFF = (0.005, 1e11, 0.3, 1.5)  # of one


def mount(
    handle: Handle, position: float, quantity: str = "acceleration", number: int = 0, sensor: Sensor | None = None,
    time: float = NOW,
) -> Command:  # fmt: skip
    """Return a command that mounts a sensor."""
    filter = (sensor or Sensor(quantity)).filter(RATE)
    place = {"position": position, "on_surface": 0, "spot": np.zeros(3), "direction": np.zeros(3)}
    values = {"acceleration": int(quantity == "acceleration"), **place, "filter": filter, "scale": 1.0}
    return Command(time, Kind.MOUNT, handle, values, value=1.0, channel=number)


def shapes_at(engine: Engine, handle: Handle, position: float, felt: int) -> np.ndarray:
    """Return the mass-normalised shapes of an object's first modes at a position: a cubic through its table."""
    record = engine.objects[handle.slot]
    rows, size = int(record["rows"]), int(record["size"])
    table = engine.state[0]["bank"]["shape"][record["table"] :][: rows * size].reshape(rows, size).astype(float)
    x = position * (rows - 1)
    first = min(max(int(x) - 1, 0), rows - 4)
    nodes = np.arange(4)
    weights = [np.prod([(x - first - j) / (i - j) for j in nodes if j != i]) for i in nodes]
    return weights @ table[first : first + 4, :felt]


def summed(engine: Engine, modes: Modes, handle: Handle, trace: np.ndarray, frames: int, at: float, struck: float):
    """Return acceleration and velocity (m/s^2, m/s) at a point of a body that was struck, by quadrature of the forces
    in a trace."""
    felt = int(engine.objects[handle.slot]["felt"])
    order = np.argsort(modes.decay, kind="stable")
    order = order[modes.frequency[order] <= engine.top_frequency]
    omega, sigma = 2 * np.pi * modes.frequency[order], modes.decay[order]
    s = -sigma + 1j * omega
    here, there = shapes_at(engine, handle, at, felt), shapes_at(engine, handle, struck, felt)
    nodes, weights = legendre.leggauss(32)
    passed = np.exp(s / RATE)
    acts = np.exp(s[:, None] * 0.5 * (1.0 - nodes) / RATE)
    forces = {int(each["sample"]): each for each in trace}
    z, found = np.zeros(len(s), complex), np.zeros((2, frames))
    for n in range(1, frames):
        z *= passed
        direct = 0.0
        if each := forces.get(n - 1):
            moments = np.r_[each["impulse"], each["moments"]] * (np.arange(6) + 0.5)
            z += there * ((acts * legendre.legval(nodes, moments)) @ weights)
            direct = (here @ there) * each["impulse"] * RATE
        speed = z.real - sigma / omega * z.imag
        found[0, n] = here @ (-2 * sigma * speed - (omega**2 + sigma**2) / omega * z.imag) + direct
        found[1, n] = here @ speed
    return found


@pytest.mark.slow
@pytest.mark.parametrize(("law", "error"), [(SOFT, 1e-6), (STIFF, 2e-5)], ids=["soft", "stiff"])
@pytest.mark.parametrize("struck", [0.5, 0.13])
def test_a_struck_free_bar_is_sensed_as_the_sum_of_its_modes(law, error, struck):
    """Sensed is q'' = phi F - 2 sigma q' - (omega^2 + sigma^2) q, times phi there, within -120 dB, the blow too.

    Of a blow of one sample the trace's six moments are not the whole: they bound what can be told.
    """
    modes = free_bar()
    engine = Engine(RATE, sensors=2)
    handle = engine.add(modes)
    engine.send([mount(handle, 0.9), mount(handle, 0.9, "velocity", 1)])
    engine.trace(True)
    strike(engine, handle, law, position=struck, time=100.25)
    sensed = engine.process(4_800)[:, 2:].T.astype(float)
    expected = summed(engine, modes, handle, engine.traced(), 4_800, 0.9, struck)
    for got, wanted in zip(sensed, expected, strict=True):
        assert np.abs(wanted).max() > 0.0
        assert np.abs(got - wanted).max() < error * np.abs(wanted).max()


def free_bar() -> Modes:
    """Return a free bar of steel, 300 mm long."""
    from carom.presets import Presets

    return bar(length=0.3, width=0.03, thickness=0.01, material=Presets().material("steel"), top=22_800.0)


def test_a_sensor_passes_neither_gain_nor_limiter():
    signals = []
    for gain, limited in ((1.0, False), (1e4, True)):
        engine = Engine(RATE, limited=limited, sensors=1)
        handle = engine.add(bell(), gain=gain)
        engine.send([mount(handle, 0.3)])
        strike(engine, handle)
        sound = engine.process(4_800 + engine.delay)[engine.delay :]
        signals.append(sound[:, 2])
        assert np.abs(sound[:, :2]).max() <= (1.0 if limited else 1e9)
    assert np.array_equal(signals[0], signals[1])


def test_a_sensor_changes_no_sound_and_blocks_no_bits():
    """The mix differs by less than what is put to rest, -120 dB of full scale."""
    sounds = []
    for sensors, block in ((0, 4_800), (1, 4_800), (1, 100)):
        engine = Engine(RATE, sensors=sensors)
        handle = engine.add(bell())
        if sensors:
            engine.send([mount(handle, 0.3)])
        strike(engine, handle)
        sounds.append(np.concatenate([engine.process(block) for _ in range(4_800 // block)]))
    assert np.abs(sounds[0] - sounds[1][:, :2]).max() < 1e-6
    assert np.array_equal(sounds[1], sounds[2])


def test_modes_in_the_spectral_bank_come_back_to_be_sensed():
    """A sensor that comes late senses the same as one that was there from the start."""
    engine = Engine(RATE, sensors=1)
    handles = [engine.add(bell(96)) for _ in range(10)]
    for handle in handles:
        strike(engine, handle)
    engine.process(9_600)
    assert engine.state[0]["spectral"]["modes"] > 0
    engine.send([mount(handles[0], 0.3)])
    late = engine.process(4_800)[:, 2]
    other = Engine(RATE, sensors=1)
    handle = other.add(bell(96))
    other.send([mount(handle, 0.3)])
    strike(other, handle)
    early = other.process(14_400)[9_600:, 2]
    assert np.abs(early).max() > 0.0
    assert np.abs(late - early).max() < 1e-4 * np.abs(early).max()


def test_sensors_go_with_tuning_and_end_with_their_object():
    engine = Engine(RATE, sensors=2)
    handle, other = engine.add(bell(4)), engine.add(bell(4))
    engine.send([mount(handle, 0.3), mount(other, 0.3, number=1), setting(other, "tune", 2.0)])
    for each in (handle, other):
        strike(engine, each, time=200.0)
    sensed = engine.process(9_600)[400:, 2:]
    peaks = [np.argmax(np.abs(np.fft.rfft(signal * np.hanning(len(signal))))[:300]) for signal in sensed.T]
    assert peaks[1] / peaks[0] == pytest.approx(2.0, abs=0.05)
    engine.send([free(handle, True), Command(NOW, Kind.MOUNT, values=BLANK, channel=1)])
    engine.process(9_600)
    strike(engine, other)
    assert not engine.process(960)[:, 2:].any()


BLANK = {
    "acceleration": 0, "position": 0.0, "on_surface": 0, "spot": np.zeros(3), "direction": np.zeros(3),
    "filter": (1.0, 0.0, 0.0, 0.0, 0.0), "scale": 0.0,
}  # fmt: skip


def test_a_panic_leaves_sensors_where_they_are():
    engine = Engine(RATE, sensors=1)
    handle = engine.add(bell())
    engine.send([panic(), mount(handle, 0.3)])
    engine.process(64)
    strike(engine, handle)
    assert np.abs(engine.process(960)[:, 2]).max() > 0.0


def test_a_striker_that_is_an_object_is_sensed_too():
    """A finger that knocks feels the blow that it gives. Both are pushed inwards, each by its own lightness."""
    from tests.dsp.engine.support import gesture

    engine = Engine(RATE, sensors=2)
    cup, finger = engine.add(bell()), engine.add(bell(8, modal_mass=0.5))
    engine.send([mount(cup, 0.5), mount(finger, 0.5, number=1)])
    engine.send([gesture("impact", cup, (0.5, 1e7, 0.3, 1.5), velocity=0.5, by=finger, by_position=0.5)])
    sensed = engine.process(2_400)[:, 2:]
    first = np.argmax(np.abs(sensed[:, 0]) > 0.0)
    assert sensed[first, 1] / sensed[first, 0] == pytest.approx((8 / 0.5) / (24 / 10.0), rel=0.05)


def test_sensors_of_too_many_channels_are_refused():
    with pytest.raises(ValueError, match="sensors = 5: expected 0 to 4, beside 60 channels"):
        Engine(RATE, 60, sensors=5)
