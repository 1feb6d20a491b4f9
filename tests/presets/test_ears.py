"""The cues that ears go by, for the built-in presets: material, size, hardness, speed, the rhythm of bounces.

R. P. Wildes and W. A. Richards 1988; R. L. Klatzky, D. K. Pai, E. P. Krotkov 2000 (material); M. Grassi 2005 (size);
M. M. J. Houben 2004 (rolling); W. H. Warren and R. R. Verbrugge 1984 (bouncing).
"""

import math
from itertools import pairwise
from statistics import median

import numpy as np
import pytest

import carom
from carom.dsp.contact.law import restitution
from carom.presets import Presets

PRESETS = Presets()
RATE = 48_000
STRIKE = {"mass": 0.01, "dissipation": 0.2, "exponent": 1.5}

KINDS = {
    "metal": {"aluminium", "bell-bronze", "brass", "iron", "piano-wire", "spring-steel", "steel", "tin"},
    "glass": {"glass"},
    "ceramic": {"ceramic"},
    "wood": {"rosewood", "wood"},
    "plastic": {"plastic", "polycarbonate"},
}

LENGTHS = ("length", "width", "thickness", "radius", "height", "diameter", "wall", "dome")


def struck(name: str, velocity: float, seconds: float = 0.5, keys: dict | None = None, **strike: object) -> np.ndarray:
    """Return the sum of both channels of a strike, without a limiter."""
    with carom.Scene(RATE, limiter=False) as scene:
        scene.new("a", name, **(keys or {})).impact(velocity, **strike)
        return scene.render(seconds).samples.sum(axis=1).astype(float)


def rolled(name: str, speed: float, seconds: float = 2.0, **keys: object) -> np.ndarray:
    """Return the sum of both channels of a roll, from when it has got going."""
    with carom.Scene(RATE, limiter=False) as scene:
        scene.new("a", name).roll(speed, **{"seed": 1, **keys})
        return scene.render(seconds).samples[RATE // 2 :].sum(axis=1).astype(float)


def level(sound: np.ndarray) -> float:
    return 10 * math.log10(np.mean(sound**2))


def centroid(sound: np.ndarray) -> float:
    """Return the centroid of the spectrum's power, Hz."""
    power = np.abs(np.fft.rfft(sound)) ** 2
    return float(power @ np.fft.rfftfreq(len(sound), 1 / RATE) / power.sum())


@pytest.mark.slow
def test_t60_times_frequency_tells_the_materials():
    """Radiation included: the median of each preset, then of each kind of material. 1/tan(phi) = T60 f pi/ln(1000).

    But for solid balls, which are so stiff that the air takes next to nothing of what their material leaves, and for a
    door, a table's top and a floor, of which it takes more than their wood does.
    """
    found: dict[str, list[float]] = {kind: [] for kind in KINDS}
    for name in PRESETS.names("objects"):
        preset = PRESETS.object(name)
        kind = next((kind for kind, names in KINDS.items() if preset.material and preset.material.name in names), None)
        if kind and preset.shape != "sphere" and name not in ("door-panel", "table-top", "wooden-floor"):
            modes = preset.modes(20_000)
            found[kind].append(median(math.log(1000) / modes.decay * modes.frequency))
    order = [median(each) for each in found.values()]
    assert all(brighter > 1.25 * duller for brighter, duller in pairwise(order)), order


def grown(name: str, factor: float) -> dict[str, object]:
    """Return the keys of an object whose every length is a factor larger."""
    geometry = PRESETS.object(name).geometry
    keys: dict[str, object] = {key: factor * geometry[key] for key in LENGTHS if key in geometry}
    if PRESETS.object(name).shape in ("membrane", "string"):
        keys |= {"fundamental": geometry["fundamental"] / factor}
    return keys


SHAPES = (
    *("aluminium-pipe", "wine-glass", "plastic-cup", "glass-plate", "wood-board", "tin-lid", "gong", "splash-cymbal"),
    *("glass-ball", "glockenspiel-bar", "kalimba-tine"),
)
"""Of each shape with lengths of its own, a thin and a thick one; but for a can, whose lowest mode is its cavity's."""

HIGH = ("plastic-cup", "splash-cymbal", "kalimba-tine")
"""A larger one is heard by modes that lie above 20 kHz in a smaller one: a splash cymbal radiates best from 27 kHz on,
and from 18 kHz on where it is larger; a ball of steel clatters on a tine."""


@pytest.mark.slow
@pytest.mark.parametrize("name", SHAPES)
def test_size_lowers_the_pitch_and_raises_the_level(name):
    """Body and striker, all lengths 1.5 times: by similarity all is 1.5 times slower and louder, but for losses."""
    factor = 1.5
    preset = PRESETS.object(name)
    ball = {"dissipation": 0.1, "exponent": 1.5}
    small = struck(name, 2.0, 0.3, mass=0.01, stiffness=1e9, **ball)  # slow ones meet a tine again as it happens
    slower = 0.3 * factor
    large = struck(name, 2.0, slower, grown(name, factor), mass=0.01 * factor**3, stiffness=1e9 * factor, **ball)
    lowest = [preset.replace(**keys, most_modes=4096).modes(20_000).frequency[0] for keys in ({}, grown(name, factor))]
    assert lowest[1] < lowest[0] / 1.3
    assert name in HIGH or centroid(large) < centroid(small)
    assert np.abs(large).max() > 1.2 * np.abs(small).max()


def attack(name: str, stiffness: float) -> float:
    """Return the centroid (Hz) of the first 30 ms, over strikes of about that stiffness: a pulse's spectrum has
    zeros."""
    strikes = (struck(name, 1.0, 0.03, stiffness=stiffness * share, **STRIKE) for share in (0.5, 1.0, 2.0))
    return math.exp(np.mean([math.log(centroid(each)) for each in strikes]))


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [name for name in PRESETS.names("objects") if PRESETS.object(name).shape != "membrane"]
)
def test_hardness_raises_the_centroid(name):
    """A membrane yields so easily that it alone decides how long a striker stays."""
    found = [attack(name, stiffness) for stiffness in (1e5, 3e6, 1e8, 3e9)]
    assert all(softer < 1.1 * harder for softer, harder in pairwise(found)), found
    assert found[-1] > 1.4 * found[0], found


ROLLS = [
    ("wood-board", "glass-marble", "wood"),
    ("glass-plate", "glass-marble", "glass"),
    ("steel-plate", "ball-bearing", "steel"),
    ("ceramic-tile", "glass-marble", "tile"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "striker", "surface"), ROLLS)
def test_faster_rolls_are_brighter_and_louder(name, striker, surface):
    """The mean over seeds rises by 1 dB at least from speed to speed; on a tile it is as bright, within 4 %. One seed's
    centroid there is within 3 % of the mean of eight, and those means lie 2 % apart."""
    keys = {"striker": striker, "surface": surface}
    sounds = [[rolled(name, speed, seed=seed, **keys) for seed in (1, 2, 3)] for speed in (0.2, 0.6, 1.8)]
    levels = [np.mean([level(each) for each in same]) for same in sounds]
    assert all(slow + 1.0 < fast for slow, fast in pairwise(levels))
    slowest, fastest = (np.mean([centroid(each) for each in same]) for same in (sounds[0], sounds[-1]))
    assert slowest < 1.04 * fastest


@pytest.mark.slow
@pytest.mark.parametrize("name", ["wood-board", "glass-plate", "steel-plate", "ceramic-tile", "iron-pan"])
def test_bigger_balls_are_lower_and_louder(name):
    """Glass balls of 8, 16 and 32 mm, at the same speed."""
    glass = PRESETS.material("glass")
    sounds = []
    for radius in (0.004, 0.008, 0.016):
        stiffness = PRESETS.striker("glass-marble").contact(PRESETS.object(name).material)[1] * (radius / 0.008) ** 0.5
        mass = glass.density * 4 / 3 * math.pi * radius**3
        sounds.append(struck(name, 0.5, mass=mass, stiffness=stiffness, dissipation=0.08, exponent=1.5))
    assert all(level(small) < level(big) for small, big in pairwise(sounds))
    assert all(centroid(small) > centroid(big) for small, big in pairwise(sounds))


def test_bounces_come_by_their_restitution():
    """A ball bounces on a bell of 500 kg: each flight lasts 2 v/g, and v is e(v) times that of before."""
    with carom.Scene(RATE, limiter=False, contacts=True) as scene:
        scene.new("a", "church-bell").bounce(0.3, mass=0.01, stiffness=1e8, dissipation=0.3, exponent=1.5)
        contacts = scene.render(2.0).contacts
    flights = np.diff([each.start for each in contacts])[:8]
    speeds = flights * 9.80665 / 2  # as it left, and as it came back
    assert len(speeds) == 8
    assert speeds[1:] / speeds[:-1] == pytest.approx(restitution(speeds[:-1], 0.3), rel=0.01)
    assert speeds[0] / math.sqrt(2 * 9.80665 * 0.3) == pytest.approx(
        float(restitution(math.sqrt(2 * 9.80665 * 0.3), 0.3)), rel=0.01
    )
