"""Bodies of any size are bodies of a simulation: they ring, click or are silent, and none is refused."""

import numpy as np
import pytest

from carom.dsp.bodies import acceleration
from carom.presets import Presets
from carom.server.bridge.bodies import BodyMaker

TOP = 7_600.0  # Hz, as at 16 kHz
SMALL = [
    ("box", (0.1, 0.1, 0.1)), ("box", (0.02, 0.01, 0.01)), ("cylinder", (0.01, 0.02)), ("capsule", (0.005, 0.01)),
    ("sphere", (0.02,)),
]  # fmt: skip


@pytest.mark.parametrize(("shape", "size"), SMALL)
def test_a_small_body_clicks_as_a_sphere_of_its_volume_does(shape, size):
    """The low end is compared, where sound is longer than the body."""
    body = BodyMaker(Presets(), TOP).make("a", shape, size, "steel")
    assert body.modes and body.modes.frequency.size == 0 and len(body.modes.clicks) == 1
    radius = (body.shape.volume / (4 / 3 * np.pi)) ** (1 / 3)
    expected = _low(acceleration.sphere(body.mass, radius))
    assert abs(20 * np.log10(_low(body.modes.clicks[0]) / expected)) < 3


def _low(click):
    """Return the pressure of a click's low end: that of an acceleration that changes slowly, (Pa s^2 per N s)."""
    return click.strength / ((2 * np.pi * click.frequency) ** 2 + click.decay**2)


@pytest.mark.slow
@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("shape", ["box", "plate", "sphere", "cylinder", "capsule"])
def test_a_body_of_any_size_can_be_made(shape, held):
    count = {"sphere": 1, "cylinder": 2, "capsule": 2}.get(shape, 3)
    for length in np.geomspace(1e-5, 100.0, 8):
        for flat in (1.0, 0.1):
            size = (length, *(flat * length,) * (count - 1))
            body = BodyMaker(Presets(), TOP).make("a", shape, size, "steel", held=held, most_modes=8)
            assert body.rings != bool(body.silence)


def test_a_silent_body_says_why():
    make = BodyMaker(Presets(), TOP).make
    assert make("a", "box", (0.02, 0.02, 0.02), "steel", held=True).silence.startswith("it is held, and no mode lies")
    assert make("a", "sphere", 1e-4, "steel").silence == "no object can be so large, or so small"
    assert make("a", "sphere", 0.1, "steel", rings=0).silence == "rings = 0"


HOLLOW = [("box", (0.3, 0.2, 0.1)), ("cylinder", (0.05, 0.2)), ("capsule", (0.05, 0.2))]


@pytest.mark.slow
@pytest.mark.parametrize(("shape", "size"), HOLLOW)
def test_a_hollow_body_has_the_mass_and_the_inertia_of_its_wall(shape, size):
    """The moments are sums over points of a grid; those of a capsule are taken as those of a cylinder of its volume."""
    body = BodyMaker(Presets(), TOP).make("a", shape, size, "steel", wall=0.01)
    grid = np.stack(np.meshgrid(*[np.linspace(-0.149, 0.149, 150)] * 3, indexing="ij"), axis=-1)
    filled = _inside(shape, size, grid, 0.0) & ~_inside(shape, size, grid, 0.01)
    points = grid[filled]
    mass = 7_850 * len(points) * 0.002**3
    assert body.mass == pytest.approx(mass, rel=0.1)
    squares = (points**2).mean(axis=0)
    expected = body.mass * (squares.sum() - squares)
    assert body.inertia == pytest.approx(expected, rel=0.15 if shape == "capsule" else 0.03)


def _inside(shape, size, points, wall):
    """True where points lie in a body less a wall."""
    if shape == "box":
        return (np.abs(points) <= np.array(size) / 2 - wall).all(axis=-1)
    across, along = np.hypot(points[..., 0], points[..., 1]), np.abs(points[..., 2])
    if shape == "cylinder":
        return (across <= size[0] - wall) & (along <= size[1] / 2 - wall)
    return np.hypot(across, np.maximum(along - size[1] / 2, 0)) <= size[0] - wall


def test_a_cup_rings_by_frenchs_formula_and_a_box_as_its_widest_face():
    """The formulas are those in vacuum; the air lowers both by a few per cent."""
    make = BodyMaker(Presets(), 20_000.0).make
    steel = Presets().material("steel")
    cup = make("a", "cylinder", (0.04, 0.1), "steel", wall=0.001)
    radius, thin = 0.0395, 0.001 * (steel.youngs_modulus / steel.density / 12) ** 0.5
    french = 6 / 5**0.5 * thin / radius**2 * (1 + 4 / 3 * (radius / 0.1) ** 4) ** 0.5 / (2 * np.pi)
    assert cup.modes.frequency[0] == pytest.approx(french, rel=0.03)
    box = make("b", "box", (0.3, 0.2, 0.1), "steel", wall=0.001)
    bending = thin / (1 - steel.poisson_ratio**2) ** 0.5
    assert box.modes.frequency[0] == pytest.approx(np.pi / 2 * bending * (1 / 0.3**2 + 1 / 0.2**2), rel=0.1)


@pytest.mark.parametrize(
    ("shape", "size", "words"), [("box", (0.1, 0.1, 0.1), "below 0.05 m"), ("sphere", 0.1, "none but of")]
)
def test_a_wall_that_cannot_be_is_an_error(shape, size, words):
    with pytest.raises(ValueError, match=f"body a: wall = 0.06: expected .*{words}"):
        BodyMaker(Presets(), TOP).make("a", shape, size, "steel", wall=0.06)
