"""Every built-in preset as it sounds: level, partials, decay."""

import math

import numpy as np
import pytest

from carom.dsp.resonator.bank import state_of, top_of
from carom.dsp.runtime.engine import NOW, Engine
from carom.presets import Presets
from carom.server.osc.wire import Message
from carom.server.scene.session import Session
from tests import accuracy, needs

PRESETS = Presets()
RATE = 48_000
COUPLED = [name for name in PRESETS.names("objects") if "nonlinear_modes" in PRESETS.object(name).geometry]


def struck(name: str, seconds: float, *keys: str | float) -> tuple[np.ndarray, Engine]:
    """Return an object's sound at its preset's own strike, and the engine that made it. keys: of /object/new."""
    engine = Engine(RATE)
    scene = Session(engine, PRESETS)
    scene.perform([Message("/object/new", ("a", name, *keys))], NOW)
    assert scene.perform([Message("/object/a/impact", (PRESETS.object(name).velocity,))], NOW) == []
    return engine.process(round(seconds * RATE)).astype(float), engine


def hung(name: str) -> tuple[str, ...]:
    """Return the keys by which an object hangs freely."""
    return ("rest", "none") if PRESETS.object(name).standing else ()


def linear(name: str) -> tuple[str | float, ...]:
    """Return the keys by which an object hangs freely, and neither glides nor has coupled modes."""
    coupled = PRESETS.object(name).geometry.get("nonlinear_modes", 0)
    return ("glide", 0, *(("nonlinear_modes", 0) if coupled else ()), *hung(name))


def touched(name: str) -> float:
    """Return how long (s) the striker of an object's own strike is there, and at least 0.03 s."""
    _, engine = struck(name, 0.03, *linear(name))
    while engine.stats.contacts_active:
        assert engine.position < 60 * RATE, f"{name}: its striker is still there after a minute"
        engine.process(64)
    return engine.position / RATE


@pytest.mark.slow
@pytest.mark.parametrize("name", PRESETS.names("objects"))
def test_partials_and_decays_are_the_presets(name):
    """Damped sines of the preset's frequencies and decays, and nothing else, are heard once the contact is over.

    Strings and membranes are told not to glide, and no plate's modes are coupled; test_glide.py and test_sheets.py have
    them glide and coupled.
    """
    modes = PRESETS.object(name).modes(top_of(RATE))
    over = touched(name)
    seconds = over + min(0.5, 5.0 / modes.decay.min())
    sound = struck(name, seconds, *linear(name))[0][round(over * RATE) :, 0]
    loud = modes.decay * over < 20  # the others are over
    if loud.sum() > 64:
        return assert_alone_in_tune(modes, struck(name, 2.0, *linear(name))[0][:, 0])
    s = -modes.decay[loud] + 2j * np.pi * modes.frequency[loud]
    waves = np.exp(s * np.arange(len(sound))[:, None] / RATE)
    columns = np.concatenate([waves.real, waves.imag], axis=1)
    amplitudes, *_ = np.linalg.lstsq(columns, sound, rcond=None)
    # 0.1 cent off at 500 Hz would leave 5 %, 1 % of T60 about 1 %.
    silence = 1e-6 * math.sqrt((RATE / (4 * modes.decay[loud])).sum())  # each mode is put to rest at -120 dB
    assert np.linalg.norm(columns @ amplitudes - sound) < accuracy.PARTIALS.bound * np.linalg.norm(sound) + silence


def assert_alone_in_tune(modes, sound):
    """Assert that one partial that stands alone, where they are too many to be told apart, is within 0.1 cent and 1 %
    of T60."""
    spectrum = np.abs(np.fft.rfft(sound * np.hanning(len(sound))))
    gaps = np.diff(modes.frequency, prepend=0.0, append=np.inf)
    heard = spectrum[np.round(modes.frequency * 2.0).astype(int)] > 1e-3 * spectrum.max()
    alone = np.flatnonzero((np.minimum(gaps[:-1], gaps[1:]) > 40.0 + modes.decay) & heard & (modes.decay < 60))
    if not len(alone):
        needs.skip("its partials are too many and too close to be told apart", "others have a test for each")
    i = max(alone, key=lambda i: spectrum[round(modes.frequency[i] * 2.0)])
    span = min(0.5, 2.0 / modes.decay[i])
    first, second = (phasor(sound, modes.frequency[i], at) for at in (0.15, 0.15 + span))
    drift = np.angle(second / first) / (2 * math.pi * span)
    assert abs(1200 * math.log2(1 + drift / modes.frequency[i])) < accuracy.PITCH.bound
    assert -math.log(abs(second / first)) / span == pytest.approx(modes.decay[i], rel=accuracy.DECAY.bound)


def phasor(sound: np.ndarray, frequency: float, at: float) -> complex:
    """Return the partial at a frequency around a time, in that frequency's frame; 0.2 s of a steep window."""
    n = round(0.2 * RATE)
    start = round(at * RATE)
    t = (start + np.arange(n)) / RATE
    return (sound[start : start + n] * np.exp(-2j * np.pi * frequency * t) * np.kaiser(n, 14)).sum()


@pytest.mark.slow
@pytest.mark.parametrize("name", PRESETS.names("objects"))
def test_no_striker_gives_more_energy_than_it_brings(name):
    """Every built-in striker at 1 m/s, at the edge and inside: sum |z|^2/2 of the modes once the contact is over.

    A plate whose modes are coupled has its stretching besides. A dome's is below 0 while it is pushed in: its modes,
    which count what stretches linearly, have more by that. Such a plate takes ten times as long as others: each meets
    every fourth striker, others than the one before it, at its edge or inside.
    """
    engine = Engine(RATE)
    scene = Session(engine, PRESETS)
    scene.perform([Message("/object/new", ("a", name, *hung(name)))], NOW)
    engine.process(64)
    place = engine.state["objects"][0][scene.objects["a"].handle.slot]
    span = slice(place["first"], place["first"] + place["felt"])
    coupled = name in COUPLED
    for n, striker in enumerate(PRESETS.names("strikers")):
        if coupled and n % 4 != COUPLED.index(name) % 4:
            continue
        mass = PRESETS.striker(striker).mass
        for position in (0.01, 0.3)[n // 4 % 2 :: 2] if coupled else (0.01, 0.3):
            strike = Message("/object/a/impact", (1.0, position, "striker", striker))
            assert scene.perform([Message("/panic"), strike], NOW) == []
            engine.process(64)
            while engine.stats.contacts_active:
                engine.process(64)
            y1, y2, a1, a2, weight = (engine.state["bank"][key][0][span] for key in ("y1", "y2", "a1", "a2", "weight"))
            modes = [(complex(*state_of(*m[:4])), m[4]) for m in zip(y1, y2, a1, a2, weight, strict=True) if m[3]]
            energy = 0.5 * sum(abs(z / w) ** 2 for z, w in modes) + stretching(engine, place["sheet"])
            assert 2 * energy < mass * (1 + accuracy.GIVEN.bound), (striker, position)


def stretching(engine: Engine, place: int) -> float:
    """Return the energy (J) by which a plate at a place is stretched, beyond its modes'; 0 if they are not coupled."""
    if place < 0 or not engine.state["sheets"][0][place]["coupled"]:
        return 0.0
    sheet = engine.state["sheets"][0][place]
    return 0.5 * float(sheet["psi"] ** 2 - sheet["c0"])
