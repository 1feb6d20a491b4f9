"""The rough surface by its statistics and spectrum."""

import itertools

import numpy as np
import pytest
from numba import njit
from scipy.signal import welch

from carom.dsp.rolling import lattice, surface


def make(roughness=1e-6, correlation=1e-3, slope=2.0, **more):
    return surface.make_surface(roughness, correlation, slope, **more)


@pytest.mark.slow
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


@pytest.mark.slow
def test_correlation_length():
    ground = make(1e-6, 1e-3, 2.0, seed=5)
    step = 128
    z = surface.heights(ground, step * np.arange(2**20))
    spectrum = np.abs(np.fft.rfft(z, 2 * len(z))) ** 2
    correlation = np.fft.irfft(spectrum)
    length = np.argmax(correlation < correlation[0] / np.e) * step * ground["unit"]
    assert length == pytest.approx(1e-3, rel=0.1)


@pytest.mark.slow
def test_a_place_has_its_height_whenever_it_is_read():
    places = np.random.default_rng(1).integers(-(2**60), 2**60, 500)
    ground = make(seed=7)
    z = surface.heights(ground, places)
    assert np.array_equal(surface.heights(ground, places[::-1])[::-1], z)
    assert np.array_equal(surface.heights(make(seed=7), np.sort(places))[np.argsort(np.argsort(places))], z)
    assert np.abs(surface.heights(make(seed=8), places) - z).min() > 0.0


@pytest.mark.slow
def test_smooth_and_within_its_bound_far_from_the_origin():
    ground = make(seed=2)
    bound = lattice.CREST * ground["height"].sum()
    for origin in (0, 10**15, -(10**15)):
        z = surface.heights(ground, origin + np.arange(100_000))
        assert np.abs(z).max() < bound
        # As steep as the finest octave can be.
        assert np.abs(np.diff(z)).max() < 4 * np.abs(ground["height"]).max() / 10


@pytest.mark.slow
def test_a_surface_does_not_repeat_itself():
    ground = make(seed=4)
    step = 2**12
    z = surface.heights(ground, step * np.arange(2**18))
    spectrum = np.abs(np.fft.rfft(z - z.mean(), 2 * len(z))) ** 2
    correlation = np.fft.irfft(spectrum)[: len(z) // 2]
    assert np.abs(correlation[200:]).max() < 0.03 * correlation[0]


@pytest.mark.slow
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
        ("variation", -1.0), ("variation", 12.1), ("variation_length", 0.0),
    ],
)  # fmt: skip
def test_bad_surfaces_are_named(key, value):
    with pytest.raises(ValueError, match=rf"{key} = "):
        surface.make_surface(**{"roughness": 1e-6, "correlation": 1e-3, key: value})


@njit(error_model="numpy")
def read(ground, place, stride, gains, ripple_gain, z):
    surface.read_heights(ground, place, stride, gains, ripple_gain, z)


@pytest.mark.slow
@pytest.mark.parametrize("level", [0, 1, 6, 9, 14])
def test_blocks_are_octaves_whose_gains_go_evenly_at_any_stride(level):
    """Block after block, from before the origin on, with gains that glide, rest and are 0; strides double and halve."""
    random, block = np.random.default_rng(level), surface.BLOCK
    ground, octaves = make(seed=11, ripple=2e-7, wavelength=0.01), surface.OCTAVES
    place = -int(random.integers(40 * block * 2**level))
    ground["gain"][:], ground["ripple_gain"] = random.uniform(0.0, 1.0, octaves), 0.5
    for turn in range(30):
        stride = 2 ** max(min(level + (turn // 10) % 2, 15), 0)
        before, ripple_before = ground["gain"].copy(), float(ground["ripple_gain"])
        gains = before if turn % 3 == 0 else random.uniform(0.0, 1.0, octaves) * (random.uniform(size=octaves) > 0.2)
        ripple_gain = ripple_before if turn % 3 == 0 else random.uniform()
        places = place + stride * np.arange(block)
        z = np.empty(block)
        read(ground, place, stride, gains.copy(), ripple_gain, z)
        after, share = ground["gain"].copy(), (np.arange(block) + 1) / block
        assert (after == gains).all() and ground["ripple_gain"] == ripple_gain
        expected = np.zeros(block)
        for j in range(octaves + 1):
            alone = np.eye(octaves + 1)[j]
            ground["gain"][:], ground["ripple_gain"] = alone[:octaves], alone[octaves]
            old, new = (ripple_before, ripple_gain) if j == octaves else (before[j], gains[j])
            expected += (old + (new - old) * share) * surface.heights(ground, places)
        ground["gain"][:], ground["ripple_gain"] = after, ripple_gain
        np.testing.assert_allclose(z, expected, rtol=0, atol=1e-12 * ground["height"].sum())
        place += block * stride


@pytest.mark.slow
@pytest.mark.parametrize("decibels", [3.0, 6.0])
def test_a_surface_that_varies_is_as_rough_on_the_whole_and_bounded(decibels):
    """The local roughness has the standard deviation that is given, in dB, and a mean square of 1."""
    places = 512 * np.arange(2**20)
    ground = make(1e-6, 1e-4, 2.0, seed=9, variation=decibels, variation_length=0.002)
    z, even = surface.heights(ground, places), surface.heights(make(1e-6, 1e-4, 2.0, seed=9), places)
    assert z.std() == pytest.approx(1e-6, rel=0.05)
    factor = (z / even)[np.abs(even) > 1e-9]
    assert factor.min() > 0.0 and factor.max() < ground["variation"]["most"]
    assert np.std(20 * np.log10(factor)) == pytest.approx(decibels, rel=0.05)
    kurtosis = (factor**4).mean() / (factor**2).mean() ** 2
    lognormal = np.exp(4 * (decibels * np.log(10) / 20) ** 2)
    assert 0.4 * lognormal < kurtosis < 1.05 * lognormal  # bounded noise reaches less far than a Gaussian's


def test_the_lattices_of_a_variation_have_nothing_in_common():
    coarse, fine = ({lattice.drawn(seed, n) for n in range(100)} for seed in make(seed=9)["variation"]["seed"])
    assert len(coarse | fine) == 200


@pytest.mark.slow
def test_blocks_vary_as_the_surface_does():
    """A block varies evenly from place to place: within the bend of the finer lattice in between."""
    ground, block, stride = make(1e-6, 1e-3, 2.0, seed=5, variation=6.0, variation_length=0.02), surface.BLOCK, 64
    for place in range(0, 40 * block * stride, block * stride):
        z = np.empty(block)
        read(ground, place, stride, ground["gain"].copy(), 1.0, z)
        expected = surface.heights(ground, place + stride * np.arange(block))
        np.testing.assert_allclose(z, expected, rtol=0.02, atol=1e-12)
