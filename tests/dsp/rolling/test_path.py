"""The path of a body's lowest point by brute force, and what geometry says about it."""

import numpy as np
import pytest

from carom.dsp.lab.rolling_path import path_pieces, pieces_of, restart
from carom.dsp.rolling import path, surface
from carom.dsp.rolling.lattice import CREST

pytestmark = pytest.mark.slow


def make(roughness=1e-6, correlation=1e-3, slope=2.0, **more):
    return surface.make_surface(roughness, correlation, slope, **more)


def path_at(pieces, s):
    i = np.searchsorted(pieces[:, 0], s, side="right") - 1
    start, level, incline, curvature = pieces[i].T
    q = s - start
    return level + q * (incline + 0.5 * curvature * q)


def brute_force(ground, radius, stride, s):
    """Return the greatest of all circles' parabolas at each s."""
    unit = ground["unit"]
    crest = CREST * ground["variation"]["most"] * ground["height"].sum()
    reach = 2 * np.sqrt(2 * radius * 2 * crest)
    here = np.round(s / unit / stride).astype(np.int64) * stride
    across = np.arange(-int(reach / unit / stride), int(reach / unit / stride) + 1) * stride
    places = here[:, None] + across
    z = surface.heights(ground, places)
    return (z - (s[:, None] - places * unit) ** 2 / (2 * radius)).max(axis=1)


@pytest.mark.parametrize(
    ("roughness", "correlation", "slope", "radius", "speed", "variation", "tolerance"),
    [
        (1e-6, 1e-3, 2.0, 8e-3, 0.5, 0.0, 1e-9), (3e-5, 1e-3, 1.5, 2e-3, 1.0, 0.0, 1e-9),
        (3e-4, 5e-3, 2.2, 0.05, 3.0, 0.0, 1e-9), (1e-6, 1e-3, 2.0, 8e-3, 0.5, 9.0, 2e-3),
    ],
)  # fmt: skip
def test_path_is_the_highest_circle(roughness, correlation, slope, radius, speed, variation, tolerance):
    """A surface that varies is met to within its blocks' difference from it, as these vary evenly."""
    ground = make(roughness, correlation, slope, seed=9, variation=variation, variation_length=0.1)
    length = 0.02 * speed
    pieces = path_pieces(ground, radius, speed, length)
    record = np.zeros(1, path.PATH)[0]
    restart(record, ground, radius, 0.0, speed, 0)
    pieces_of(record, 1e-12, np.empty((1, 4)))
    unit, stride = ground["unit"], int(record["stride"])
    laid = record["length"][: record["made"]].sum()
    start = record["place"][record["first"]] * unit + record["left"] - laid
    ground["gain"] = record["surface"]["gain"]
    s = np.random.default_rng(0).uniform(0, length, 400)
    excess = path_at(pieces, s) - brute_force(ground, radius, stride, s + start)
    assert excess.min() > -tolerance * roughness
    assert np.median(np.abs(excess)) < tolerance * roughness
    # Only where it turns smoothly between two neighbouring points does the path lie above their circles.
    turns = np.diff(pieces[:, 0])[pieces[:-1, 3] > -1 / radius]
    assert excess.max() < stride * unit * turns.max(initial=0.0) / (8 * radius) + tolerance * roughness


@pytest.mark.parametrize(("speed", "roughness"), [(0.05, 2e-6), (0.5, 2e-6), (4.0, 2e-5)])
def test_path_has_no_steps_and_only_kinks_upwards(speed, roughness):
    pieces = path_pieces(make(roughness), 8e-3, speed, 0.02)
    step = np.diff(pieces[:, 0])
    end = pieces[:-1, 1] + step * (pieces[:-1, 2] + 0.5 * pieces[:-1, 3] * step)
    kink = pieces[1:, 2] - pieces[:-1, 2] - pieces[:-1, 3] * step
    assert end == pytest.approx(pieces[1:, 1], abs=1e-15)
    assert kink.min() > -1e-9
    assert (kink > 1e-6).sum() > 10


def test_flat_is_flat():
    for radius in (1e-3, 1.0):
        pieces = path_pieces(make(0.0), radius, 1.0, 0.05)
        assert np.abs(pieces[:, 1:3]).max() < 1e-12


@pytest.mark.parametrize("corners", [3, 6, 40])
def test_corners(corners):
    """A body with corners turns about one after the other: arcs of its radius, kinks of nearly 2 pi/n."""
    pieces = path_pieces(make(0.0), 0.02, 0.5, 0.5, corners=corners)
    step = np.diff(pieces[:, 0])
    kink = pieces[1:, 2] - pieces[:-1, 2] - pieces[:-1, 3] * step
    turns = kink[kink > 0.5 * kink.max()]
    side = 2 * np.pi * 0.02 / corners
    assert len(turns) == pytest.approx(0.5 / side, abs=1.1)
    assert turns == pytest.approx(2 * np.pi / corners / (1 + path.EDGE), rel=0.02)
    assert np.ptp(pieces[:, 1]) == pytest.approx(side**2 / 8 / (0.02 * (1 + path.EDGE)), rel=0.1)


def test_smooth_surface_is_followed():
    """A corrugation wider than the body is felt as it is, but for the lift of half the slope's square times R."""
    ground = make(0.0, ripple=1e-4, wavelength=0.05)
    pieces = path_pieces(ground, 5e-3, 1.0, 0.2)
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
    pieces = path_pieces(make(share * radius, 1e-3), radius, speed, 2e-3 * speed)
    assert np.isfinite(pieces).all()
    assert len(pieces) < 2e-3 * 2 * 2 * path.AUDIBLE + 10


def test_bad_paths_are_named():
    for key in ("radius", "speed", "length"):
        with pytest.raises(ValueError, match=f"{key} = -1"):
            path_pieces(make(), **{"radius": 1.0, "speed": 1.0, "length": 1.0, key: -1.0})


def ahead_of(record, piece, along, s):
    """Return the heights of a path at distances s ahead of a body that is so far along a piece."""
    path.extend_path(record, piece + 2 * path.AHEAD)
    columns = np.arange(piece, record["made"]) % path.PIECES
    rows = [record[name][columns] for name in ("level", "incline", "curvature")]
    begins = np.cumsum(np.append(-along, record["length"][columns]))
    assert s[-1] < begins[-1]
    return path_at(np.column_stack([begins[:-1], *rows]), s)


@pytest.mark.parametrize("radius", [0.004, 0.02])
def test_a_path_that_is_renewed_is_the_same_path(radius):
    """Renewed for the radius that it has, anywhere on a piece: to the last bits. Where a body hops they change its
    sound, but so do the last bits of a radius that stays."""
    ground = make(3e-7, seed=4)
    for piece in range(3, 300, 11):
        found = []
        for renewed in (False, True):
            record = np.zeros(1, path.PATH)[0]
            restart(record, ground, radius, 0.0, 0.3, 0)
            for n in range(0, piece + path.AHEAD, path.AHEAD):
                path.extend_path(record, min(n, piece) + path.AHEAD)
            at, along = piece, 0.4 * record["length"][piece % path.PIECES]
            if renewed:
                at, along = 0, path.restart_path(record, 0, at, along)
                path.extend_path(record, 1)
                while along > record["length"][at]:
                    along -= record["length"][at]
                    at += 1
                    path.extend_path(record, at + 1)
            found.append(ahead_of(record, at, along, np.linspace(0.0, 2e-4, 100)))
        np.testing.assert_allclose(found[1], found[0], rtol=0, atol=1e-19)
