"""Gestures as they are rendered: alike at any sampling rate and block size, louder when faster, without clicks."""

import math
import re

import numpy as np
import pytest

from carom.dsp import contact
from carom.dsp.runtime.engine import Engine
from carom.presets.library import Presets
from carom.server.osc.score import read
from carom.server.render import Options, blocks

OBJECT = """description = "Seven modes below 16 kHz"
source = "these tests"
shape = "listed"
level = 26.0  # dB

[geometry]
frequency = [310.0, 877.0, 1930.0, 3410.0, 5370.0, 8230.0, 12700.0]  # Hz
t60 = [0.8, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1]  # s
modal_mass = 0.2  # kg
mass = 0.8  # kg

[strike]
striker = "steel"
velocity = 1.0  # m/s
position = 0.5  # 0..1 along the path
"""


def silent(name: str) -> str:
    """Return the file of a built-in striker that makes no sound of its own."""
    text = Presets().path("strikers", name).read_text().split("\n[")[0]
    return re.sub("^mass = .*$", "", text, flags=re.M) + f"\nmass = {Presets().striker(name).mass!r}\n"


@pytest.fixture
def render(tmp_path):
    """Renders the text of a score, float64 (frames, 2).

    Over the built-in presets, `seven`, `wall`, which neither moves nor sounds, silent strikers `silent-...`, and `even`
    glass, which is everywhere as rough.
    """
    for kind in ("objects", "strikers", "surfaces"):
        (tmp_path / kind).mkdir()
    (tmp_path / "objects" / "seven.toml").write_text(OBJECT)
    (tmp_path / "objects" / "wall.toml").write_text(
        re.sub("mass = .*", "mass = 1e5", re.sub("t60 = .*", "t60 = 0.01", OBJECT))
    )
    for name in ("glass-marble", "steel", "pencil"):
        (tmp_path / "strikers" / f"silent-{name}.toml").write_text(silent(name))
    even = re.sub("^variation.*$", "", Presets().path("surfaces", "glass").read_text(), flags=re.M)
    (tmp_path / "surfaces" / "even.toml").write_text(even)

    def render(text: str, seconds: float, rate: int = 48_000, block: int = 4096) -> np.ndarray:
        path = tmp_path / "score.txt"
        path.write_text(text)
        options = Options(rate=rate, block=block, seconds=seconds)
        return np.concatenate(list(blocks(read(path), Engine(rate), Presets([tmp_path]), options))).astype(float)

    return render


ROLLS = [
    "0.5 0.5 striker {}glass-marble surface glass",
    "0.5 0.5 striker {}steel surface wood",
    "0.05 0.5 striker {}steel surface glass friction 0.001",
    "0.2 0.5 striker {}pencil surface polished-wood corners 6",
    "0.3 0.5 striker {}steel surface corrugated asymmetry 0.2",
]


def faded_spectrum(sound: np.ndarray, rate: int) -> np.ndarray:
    """Return the spectrum of a sound that goes on, without a step at its end."""
    return np.fft.rfft(sound * np.cos(np.linspace(0, np.pi / 2, len(sound), endpoint=False)) ** 2) / rate


@pytest.mark.slow
@pytest.mark.parametrize("roll", ROLLS)
def test_a_roll_sounds_the_same_at_any_rate(render, roll):
    """The spectra below 16 kHz, where all modes are, agree within -60 dB: two seconds of what rings, phases and all, on
    a dashpot."""

    def spectrum(rate: int) -> np.ndarray:
        begin = "0 /accuracy -50\n0 /quality 1\n0 /object/new a seven\n"
        text = f"{begin}0.01 /object/a/roll {roll.format('silent-')} seed 3\n"
        return faded_spectrum(render(text, 2.0, rate)[:, 0], rate)[:32_000]

    reference = spectrum(96_000)
    for rate in (44_100, 48_000):
        assert np.linalg.norm(spectrum(rate) - reference) < 1e-3 * np.linalg.norm(reference)


def third_octaves(sound: np.ndarray, rate: int, low: float, high: float) -> np.ndarray:
    """Return the energies of a sound in bands of a third of an octave, all of which lie from `low` to `high` (Hz)."""
    spectrum = np.abs(faded_spectrum(sound, rate)) ** 2
    edges = high * 2.0 ** (np.arange(-math.floor(3 * math.log2(high / low)), 1) / 3)
    at = np.searchsorted(np.fft.rfftfreq(len(sound), 1 / rate), edges)
    return np.add.reduceat(spectrum, at)[:-1]


@pytest.mark.slow
@pytest.mark.parametrize("gesture", [*(f"roll {roll} seed 3" for roll in ROLLS), "impact 1 striker {}steel"])
def test_strikers_are_heard_alike_at_any_sampling_rate(render, gesture):
    """A body's own sound, in thirds of an octave up to 0.4 of the lowest rate, within 0.6 dB.

    Clicks have the right values at each sample: a marble's treble folds, and covers what is 50 dB fainter.
    """
    text = f"0 /limiter off\n0 /object/new a wall gain 40\n0.01 /object/a/{gesture.format('')}\n"
    rates = (44_100, 48_000, 96_000)
    bands = [third_octaves(render(text, 1.0, rate)[:, 0], rate, 320.0, 0.4 * rates[0]) for rate in rates]
    loud = bands[-1] > 1e-5 * bands[-1].max()
    assert loud.sum() > 8
    for each in bands[:-1]:
        np.testing.assert_allclose(10 * np.log10(each / bands[-1])[loud], 0.0, atol=0.6)


def rolled(render, *keys: object, steer: str = "") -> np.ndarray:
    text = " ".join(map(str, keys))
    return render(f"0 /object/new a seven gain 30\n0 /object/a/roll {text} seed 2 id g\n{steer}", 2.0)[:, 0]


@pytest.mark.slow
def test_faster_and_over_rougher_ground_is_louder(render):
    """Both rise with each step, whether it rides the ground or leaps; and there is no direct current."""

    def level(*keys: object) -> float:
        sound = rolled(render, *keys)[24_000:]
        assert abs(sound.mean()) < 1e-2 * sound.std()
        return 20 * np.log10(sound.std())

    speeds = np.array([level(v, "striker", "glass-marble", "surface", "even") for v in (0.01, 0.05, 0.2, 0.8)])
    assert (np.diff(speeds) > 2.0).all()
    heights = np.array(
        [level(0.3, "striker", "glass-marble", "surface", "even", "roughness", r) for r in (0.1, 0.5, 2.0, 8.0)]
    )
    assert (np.diff(heights) > 3.0).all()
    assert heights[-1] - heights[0] < 60.0


def test_a_roll_over_what_is_quite_smooth_is_silent(render):
    assert np.abs(rolled(render, 0.5, "striker", "steel", "surface", "glass", "roughness", 0)).max() < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize(
    "steer",
    ["speed 0.9", "speed 0", "mass 0.02", "radius 0.02", "gravity 3", "position 0.9", "gain 6", "friction 1"],
)
def test_neither_the_start_nor_steering_clicks(render, steer):
    """The sound bends nowhere more than it does while it rolls at its loudest."""
    roll = (0.4, 0.3, "striker", "steel", "surface", "tile")
    bend = np.abs(np.diff(rolled(render, *roll, steer=f"1 /gesture/g/{steer}\n"), 2))
    loudest = max(bend[24_000:47_000].max(), bend[53_000:].max())
    assert bend[:480].max() < loudest
    assert bend[47_900:50_000].max() < 1.2 * loudest


def test_flights_of_a_bounce_shrink_as_contacts_leave_it(render):
    """Onsets, heard on something heavy and dull: each flight is that of the velocity the contact law leaves."""
    heavy = "0 /object/new a seven modal_mass 1000 mass 10000 t60 0.01 gain 40\n"
    sound = render(f"{heavy}0 /object/a/bounce 0.05 striker steel dissipation 0.2\n", 2.0)[:, 0]
    loud = np.abs(sound)
    hits = np.flatnonzero(loud > 0.1 * loud.max())
    hits = hits[np.diff(hits, prepend=-1000) > 960][:9] / 48_000
    assert hits[0] == pytest.approx(np.sqrt(2 * 0.05 / 9.80665), abs=1e-3)
    speeds = 9.80665 * np.diff(hits) / 2
    np.testing.assert_allclose(speeds[1:], -contact.release_velocity(speeds[:-1], 0.2), rtol=5e-3)


def test_a_ringing_striker_rests_too(render):
    """A lid dropped on a board, both ringing: it doesn't dance on for ever."""
    text = """0 /object/new board wood-board thickness 0.04
0 /object/new lid pot-lid
0 /object/board/bounce 0.02 0.6 by lid by_position 0.95 striker coin dissipation 0.3
"""
    sound = render(text, 3.0)[:, 0]
    assert np.abs(sound[-24_000:]).max() < 0.05 * np.abs(sound).max()


def test_a_roll_sounds_the_same_beside_other_contacts(render):
    """Other contacts cut an object's time into single samples; a roll's own is several of them at a time."""
    rolls = """0 /accuracy -50
0 /quality 1
0 /object/new pane glass-plate
0 /object/new glass wine-glass
0.01 /object/pane/roll 0.4 striker glass-marble surface glass travel 0.3 seed 1 id one
0.02 /object/pane/roll 0.3 by glass surface wood radius 0.01 gain 6 seed 2 id other
"""
    # 50 ms long, and too faint to be heard
    soft = "0.05 /object/*/impact 1 0.3 mass 2.5e-7 stiffness 1e-3 exponent 1 gain -80\n"
    alone, beside = render(rolls, 0.2), render(rolls + soft, 0.2)
    np.testing.assert_allclose(beside, alone, atol=2e-6 * np.abs(alone).max())
    assert np.abs(alone).max() > 1e-3 and not np.array_equal(beside, alone)


@pytest.mark.slow
@pytest.mark.parametrize("accuracy", ["-60", "-80"])
@pytest.mark.parametrize("preset", ["glass-plate", "church-bell"])
def test_a_roll_whose_law_is_steered_is_as_loud_as_one_that_began_with_it(render, preset, accuracy):
    """On an object that yields, and on one that is as good as a wall."""
    begin = f"0 /accuracy {accuracy}\n0 /object/new a {preset}\n"
    roll = "0 /object/a/roll 0.1 striker glass-marble mass 1e-4 surface glass seed 1 id r"
    soft = {"stiffness": 1e5, "dissipation": 5.0, "exponent": 1.3}
    keys = "".join(f" {name} {value}" for name, value in soft.items())
    steers = "".join(f"0 /gesture/r/{name} {value}\n" for name, value in soft.items())
    levels = [
        20 * np.log10(np.std(render(begin + each, 1.5)[24_000:]))
        for each in (f"{roll}\n", f"{roll}{keys}\n", f"{roll}\n{steers}")
    ]
    assert levels[0] - levels[1] > 20.0 and abs(levels[2] - levels[1]) < 1.0
