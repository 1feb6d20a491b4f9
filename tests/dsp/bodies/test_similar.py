"""Bodies in a size, by the table of similar ones, against the same bodies made by themselves."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from carom.dsp import bodies
from carom.dsp.bodies.heard import Best
from carom.dsp.bodies.modes import Silent
from carom.dsp.bodies.similar import Sized, has_similar
from carom.dsp.bodies.similar_table import Beyond, Table, table_of
from carom.dsp.bodies.unheard import Felt
from carom.presets import PresetError, Presets

TOP = 23_520.0  # Hz

STEEL = Presets().material("steel")
WOOD = replace(Presets().material("wood"), losses="measured")

BODIES = {
    "ring": (bodies.ring, STEEL, ("radius", "thickness", "length"), dict(radius=0.06, thickness=0.005, length=0.1)),
    "glass": (bodies.glass, STEEL, ("radius", "height", "thickness"), dict(
        radius=0.035, height=0.09, thickness=0.002, rows=2, split=0.003, split_seed=5)),
    "sphere": (bodies.sphere, STEEL, ("radius",), dict(radius=0.2)),
    "disc": (bodies.disc, STEEL, ("radius", "thickness", "dome"), dict(
        radius=0.1, thickness=0.0015, dome=0.008, split=0.004, imperfection=37.0)),
    "cymbal": (bodies.disc, STEEL, ("radius", "thickness", "felt"), dict(
        radius=0.1, thickness=0.0015, felt=0.01, stand=1.5, split=0.004, imperfection=37.0)),
    "plate": (bodies.plate, STEEL, ("length", "width", "thickness"), dict(
        length=0.25, width=0.15, thickness=0.003, edges=("free", "free", "clamped", "supported"),
        path_from=(0.0, 0.9), path_to=(0.9, 0.3))),
    "wall": (bodies.plate, WOOD, ("length", "width", "thickness"), dict(
        length=0.25, width=0.15, thickness=0.008, edges=("supported",) * 4, baffle="closed")),
    "bar": (bodies.bar, WOOD, ("length", "width", "thickness"), dict(
        length=0.3, width=0.04, thickness=0.02, undercut=0.5)),
    "marimba": (bodies.bar, WOOD, ("length", "width", "thickness", "tube_diameter"), dict(
        length=0.35, width=0.05, thickness=0.02, undercut=0.6, undercut_span=0.7, tube_diameter=0.05, fan=3.0,
        cords=4.0)),
    "tube": (bodies.bar, STEEL, ("length", "diameter", "wall"), dict(
        length=0.49, diameter=0.03, wall=0.0015, split=0.005, imperfection=20.0)),
    "tine": (bodies.bar, STEEL, ("length", "width", "thickness"), dict(
        length=0.09, width=0.006, thickness=0.004, ends="cantilever")),
    "tongue": (bodies.bar, STEEL, ("length", "width", "thickness"), dict(
        length=0.09, width=0.006, thickness=0.004, ends="cantilever", board="box")),
}  # fmt: skip


def both(name, size):
    """Return the modes of a body in a size by the table, and made by itself."""
    make, material, lengths, arguments = BODIES[name]
    sized = Sized(make, size, lengths)(top=TOP, material=material, **arguments)
    scaled = {key: size * value if key in lengths else value for key, value in arguments.items()}
    return sized, make(top=TOP, material=material, **scaled)


def along(strike):
    """Return shapes (9, n) at as many positions, the same of tables whose rows lie otherwise."""
    path = np.linspace(0, 1, 9)
    return CubicSpline(np.linspace(0, 1, len(strike)), strike)(path) if len(strike) > 1 else strike


def heard_at(modes):
    """Return the sound pressure of each mode (9, n) for a blow there: no sign that is a mode's own is left."""
    return along(modes.strike) * modes.pressure[0]


def yielding(modes):
    """Return how far a body yields at rest where it is struck, (9,): sum phi^2/omega^2 (m/N)."""
    parts = [each for each in (modes, modes.unheard) if each is not None]
    return sum((along(each.strike) ** 2 / (2 * np.pi * each.frequency) ** 2).sum(axis=1) for each in parts)


@pytest.mark.slow
@pytest.mark.parametrize("size", [0.83, 1.37])
@pytest.mark.parametrize("name", BODIES)
def test_a_body_in_a_size_is_that_of_the_table_of_similar_ones(name, size):
    """Twists have converged to within 4e-5: near the ends, sections warp and are distorted over a short way."""
    sized, own = both(name, size)
    assert sized.frequency == pytest.approx(own.frequency, rel=4e-5)
    assert sized.decay == pytest.approx(own.decay, rel=2e-3)
    assert sized.mass == pytest.approx(own.mass, rel=1e-12)
    pairs = zip(sized.clicks, own.clicks, strict=True)
    assert all(one[:3] == pytest.approx(other[:3], rel=1e-12) and one.along == other.along for one, other in pairs)
    heard, expected = heard_at(sized), heard_at(own)
    assert heard == pytest.approx(expected, abs=5e-3 * np.abs(expected).max())
    given, yields = yielding(sized), yielding(own)
    assert given == pytest.approx(yields, rel=0.01, abs=1e-3 * yields.max())


@pytest.mark.parametrize("name", ["ring", "sphere"])
def test_closed_forms_are_similar_to_rounding(name):
    sized, own = both(name, 1.21)
    for each in ("frequency", "decay", "pressure"):
        assert getattr(sized, each) == pytest.approx(getattr(own, each), rel=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ring", "sphere", "cymbal", "bar", "marimba", "tongue"])
def test_the_best_modes_in_a_size_are_those_of_all_to_the_bit(name):
    make, material, lengths, arguments = BODIES[name]
    sized, best = Sized(make, 1.13, lengths), Best(0.6, 5)
    few = sized(top=TOP, material=material, best=best, **arguments)
    expected = best.of(sized(top=TOP, material=material, **arguments))
    assert few.frequency.size == 5
    for each in ("frequency", "decay", "strike", "pressure"):
        assert np.array_equal(getattr(few, each), getattr(expected, each))
    for one, other in zip(few.unheard or (), expected.unheard or (), strict=True):
        assert np.array_equal(one, other)


@pytest.mark.parametrize("grid", [(3e3, 3e4), (4.1e3, 4.2e3, 2e4, 9e4), (2.5e3,)])
def test_a_table_s_sums_are_those_over_its_modes(grid):
    """Differences of sums over all higher modes err by the rounding of these."""
    make, material, _, arguments = BODIES["plate"]
    table = table_of(make, 8_000.0, material, arguments)
    assert isinstance(table, Table)
    beyond = Beyond(table, 11, 1.3)
    felt = Felt(beyond.frequency, table.shapes[11:].T * 1.3**-1.5)
    which = np.flatnonzero(felt.frequency >= grid[0])
    u, places = 1 / (2 * np.pi * felt.frequency[which]) ** 2, 1 / (2 * np.pi * np.array(grid)) ** 2
    expected = felt.squares(which, u, places)
    assert beyond.squares(which, u, places) == pytest.approx(expected, rel=1e-9, abs=1e-13 * expected.max())


def test_a_body_that_is_too_small_to_ring_is_silent_in_its_size():
    with pytest.raises(Silent, match="23520"):
        Sized(bodies.sphere, 0.01, ("radius",))(top=TOP, material=STEEL, radius=0.2)


def test_nonlinear_discs_and_strings_have_no_table_of_similar_bodies():
    assert has_similar(bodies.bar, dict(length=0.3, board="box"))
    assert has_similar(bodies.disc, dict(radius=0.1, felt=0.01))
    assert not has_similar(bodies.disc, dict(radius=0.1, nonlinear_modes=20))
    assert not has_similar(bodies.string, dict(length=1.0))


@pytest.mark.slow
def test_a_preset_takes_a_size_that_scales_the_lengths_that_are_not_given():
    plate = Presets().object("steel-plate")
    assert plate.replace(size=2.0).geometry["thickness"] == 2 * plate.geometry["thickness"]
    mixed = plate.replace(size=2.0, thickness=0.001)
    assert mixed.geometry["thickness"] == 0.001 and mixed.geometry["width"] == 2 * plate.geometry["width"]
    assert mixed.modes(2_000.0).mass == pytest.approx(4 / 3 * plate.modes(2_000.0).mass)
    as_one = plate.replace(**{key: 1.5 * plate.geometry[key] for key in ("length", "width", "thickness")})
    assert plate.replace(size=1.5).modes(9_000.0).frequency == pytest.approx(as_one.modes(9_000.0).frequency, rel=2e-5)


@pytest.mark.parametrize(
    "name, size, error",
    [
        ("church-bell", 2.0, "size = 2.0: expected none, as the modes of church-bell are listed"),
        ("steel-plate", 0.0, "size = 0.0: expected a number from 0.001 to 1000 times"),
        ("steel-plate", 600.0, "length = 240.0: expected a number from 0.001 to 20 m"),
    ],
)
def test_a_size_that_cannot_be_is_refused(name, size, error):
    with pytest.raises(PresetError, match=error):
        Presets().object(name).replace(size=size)
