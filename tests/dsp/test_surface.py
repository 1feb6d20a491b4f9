"""The rough surface by its statistics and spectrum, and the envelope of circles over it by brute force."""

import itertools

import numpy as np
import pytest
from scipy.signal import welch

from carom.dsp import envelope, surface


def make(roughness=1e-6, correlation=1e-3, slope=2.0, **more):
    return surface.make_surface(roughness, correlation, slope, **more)


@pytest.mark.parametrize("slope", [1.5, 2.0, 3.0])
def test_spectrum(slope):
    correlation, step = 1e-3, 64
    ground = make(1e-6, correlation, slope, seed=3)
    spacing = step * ground["unit"]
    z = surface.heights(ground, step * np.arange(2**20))
    assert z.std() == pytest.approx(1e-6, rel=0.03)
    k, power = welch(z, 1 / spacing, nperseg=2**16)
    edges = np.geomspace(2 / correlation, 0.05 / spacing, 20)
    bands = [power[(k >= low) & (k < high)].mean() for low, high in itertools.pairwise(edges)]
    fitted = np.polyfit(np.log(edges[:-1]), np.log(bands), 1)[0]
    assert fitted == pytest.approx(-slope, abs=0.1)
    # Flat below the corner.
    low, lower = (power[(k > a / correlation) & (k < b / correlation)].mean() for a, b in ((0.01, 0.03), (0.03, 0.09)))
    assert low == pytest.approx(lower, rel=0.25)


def test_correlation_length():
    ground = make(1e-6, 1e-3, 2.0, seed=5)
    step = 128
    z = surface.heights(ground, step * np.arange(2**20))
    spectrum = np.abs(np.fft.rfft(z, 2 * len(z))) ** 2
    correlation = np.fft.irfft(spectrum)
    length = np.argmax(correlation < correlation[0] / np.e) * step * ground["unit"]
    assert length == pytest.approx(1e-3, rel=0.1)


def test_a_place_has_its_height_whenever_it_is_read():
    places = np.random.default_rng(1).integers(-(2**60), 2**60, 500)
    ground = make(seed=7)
    z = surface.heights(ground, places)
    assert np.array_equal(surface.heights(ground, places[::-1])[::-1], z)
    assert np.array_equal(surface.heights(make(seed=7), np.sort(places))[np.argsort(np.argsort(places))], z)
    assert np.abs(surface.heights(make(seed=8), places) - z).min() > 0.0


def test_smooth_and_within_its_bound_far_from_the_origin():
    ground = make(seed=2)
    bound = surface.CREST * ground["height"].sum()
    for origin in (0, 10**15, -(10**15)):
        z = surface.heights(ground, origin + np.arange(100_000))
        assert np.abs(z).max() < bound
        # As steep as the finest octave can be.
        assert np.abs(np.diff(z)).max() < 4 * np.abs(ground["height"]).max() / 10


def test_no_repetition():
    ground = make(seed=4)
    step = 2**12
    z = surface.heights(ground, step * np.arange(2**18))
    spectrum = np.abs(np.fft.rfft(z - z.mean(), 2 * len(z))) ** 2
    correlation = np.fft.irfft(spectrum)[: len(z) // 2]
    assert np.abs(correlation[200:]).max() < 0.03 * correlation[0]


def test_corrugation():
    ground = make(0.0, ripple=2e-3, wavelength=0.03)
    places = np.arange(0, 2**20, 997)
    expected = 2e-3 * np.cos(2 * np.pi * places * ground["unit"] / 0.03)
    assert surface.heights(ground, places) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("roughness", -1e-9), ("roughness", np.nan), ("correlation", 0.0), ("correlation", np.inf), ("slope", 1.0),
        ("slope", 6.0), ("ripple", -1.0), ("wavelength", 0.0), ("seed", -1),
    ],
)  # fmt: skip
def test_bad_surfaces_are_named(key, value):
    with pytest.raises(ValueError, match=rf"{key} = "):
        surface.make_surface(**{"roughness": 1e-6, "correlation": 1e-3, key: value})


def path_at(pieces, s):
    i = np.searchsorted(pieces[:, 0], s, side="right") - 1
    start, level, incline, curvature = pieces[i].T
    q = s - start
    return level + q * (incline + 0.5 * curvature * q)


def brute_force(ground, radius, stride, s):
    """The greatest of all circles' parabolas at each s."""
    unit = ground["unit"]
    reach = 2 * np.sqrt(2 * radius * 2 * surface.CREST * ground["height"].sum())
    here = np.round(s / unit / stride).astype(np.int64) * stride
    across = np.arange(-int(reach / unit / stride), int(reach / unit / stride) + 1) * stride
    places = here[:, None] + across
    z = surface.heights(ground, places)
    return (z - (s[:, None] - places * unit) ** 2 / (2 * radius)).max(axis=1)


@pytest.mark.parametrize(
    ("roughness", "correlation", "slope", "radius", "speed"),
    [(1e-6, 1e-3, 2.0, 8e-3, 0.5), (3e-5, 1e-3, 1.5, 2e-3, 1.0), (3e-4, 5e-3, 2.2, 0.05, 3.0)],
)
def test_path_is_the_highest_circle(roughness, correlation, slope, radius, speed):
    ground = make(roughness, correlation, slope, seed=9)
    length = 0.02 * speed
    pieces = envelope.path_pieces(ground, radius, speed, length)
    path = np.zeros(1, envelope.ENVELOPE)[0]
    envelope._lay(path, ground, radius, 0.0, speed, 0)
    envelope._pieces(path, 1e-12, np.empty((1, 4)))
    unit, stride = ground["unit"], int(path["stride"])
    start = path["origin"][0] * unit + path["start"][0]
    ground["gain"] = path["surface"]["gain"]
    s = np.random.default_rng(0).uniform(0, length, 400)
    excess = path_at(pieces, s) - brute_force(ground, radius, stride, s + start)
    assert excess.min() > -1e-9 * roughness
    assert np.median(np.abs(excess)) < 1e-9 * roughness
    # Only where it turns smoothly between two neighbouring points does the path lie above their circles.
    turns = np.diff(pieces[:, 0])[pieces[:-1, 3] > -1 / radius]
    assert excess.max() < stride * unit * turns.max() / (8 * radius)


@pytest.mark.parametrize("speed", [0.05, 0.5, 4.0])
def test_path_has_no_steps_and_only_kinks_upwards(speed):
    pieces = envelope.path_pieces(make(2e-6), 8e-3, speed, 0.02)
    step = np.diff(pieces[:, 0])
    end = pieces[:-1, 1] + step * (pieces[:-1, 2] + 0.5 * pieces[:-1, 3] * step)
    kink = pieces[1:, 2] - pieces[:-1, 2] - pieces[:-1, 3] * step
    assert end == pytest.approx(pieces[1:, 1], abs=1e-15)
    assert kink.min() > -1e-9
    assert (kink > 1e-6).sum() > 10


def test_flat_is_flat():
    for radius in (1e-3, 1.0):
        pieces = envelope.path_pieces(make(0.0), radius, 1.0, 0.05)
        assert np.abs(pieces[:, 1:3]).max() < 1e-12


@pytest.mark.parametrize("corners", [3, 6, 40])
def test_corners(corners):
    """A body with corners turns about one after the other: arcs of its radius, kinks of nearly 2 pi/n."""
    pieces = envelope.path_pieces(make(0.0), 0.02, 0.5, 0.5, corners=corners)
    step = np.diff(pieces[:, 0])
    kink = pieces[1:, 2] - pieces[:-1, 2] - pieces[:-1, 3] * step
    turns = kink[kink > 0.5 * kink.max()]
    side = 2 * np.pi * 0.02 / corners
    assert len(turns) == pytest.approx(0.5 / side, abs=1.1)
    assert turns == pytest.approx(2 * np.pi / corners / (1 + envelope.EDGE), rel=0.02)
    assert np.ptp(pieces[:, 1]) == pytest.approx(side**2 / 8 / (0.02 * (1 + envelope.EDGE)), rel=0.1)


def test_smooth_surface_is_followed():
    """A corrugation wider than the body is felt as it is, but for the lift of half the slope's square times R."""
    ground = make(0.0, ripple=1e-4, wavelength=0.05)
    pieces = envelope.path_pieces(ground, 5e-3, 1.0, 0.2)
    s = np.linspace(0.01, 0.19, 1000)
    touching = s  # the place that touches is R z' further on
    for _ in range(50):
        touching = s + 5e-3 * -1e-4 * 2 * np.pi / 0.05 * np.sin(2 * np.pi * touching / 0.05)
    expected = 1e-4 * np.cos(2 * np.pi * touching / 0.05) - (s - touching) ** 2 / 1e-2
    assert path_at(pieces, s) == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("speed", [1e-4, 1.0, 100.0])
@pytest.mark.parametrize("radius", [1e-4, 0.1, 10.0])
@pytest.mark.parametrize("share", [1e-9, 1e-3, 0.1])
def test_extremes_stay_bounded(speed, radius, share):
    pieces = envelope.path_pieces(make(share * radius, 1e-3), radius, speed, 2e-3 * speed)
    assert np.isfinite(pieces).all()
    assert len(pieces) < 2e-3 * 2 * 2 * envelope.AUDIBLE + 10


def test_bad_paths_are_named():
    for key in ("radius", "speed", "length"):
        with pytest.raises(ValueError, match=f"{key} = -1"):
            envelope.path_pieces(make(), **{"radius": 1.0, "speed": 1.0, "length": 1.0, key: -1.0})
