"""Points all over a surface: samples by area, points about equally far apart, how thick the body is, how it curves."""

from typing import NamedTuple

import numpy as np

from ..bodies.material import Array
from .surface import Indices, Surface, faces_of

_LLOYD = 4  # steps
_DISCS = 0.82  # of the spacing: the radius in which one seed is
_FACING = -0.5  # cosine of the normals of two skins
_ASIDE = 0.35  # of the thickness: how far off the opposite point may lie
_NEIGHBOURS = 48
_CURVED = 24  # samples about one that say how the surface turns
_SMOOTH = 0.77  # cosine of the normals there, of one side of an edge
_GOLDEN = np.array([0.7548776662466927, 0.5698402909980532])  # of the plastic number: an even sequence in the plane


class Samples(NamedTuple):
    """Points of a surface, each for the same area (m^2): places and normals (n, 3)."""

    places: Array
    normals: Array
    area: float


def sampled(surface: Surface, count: int) -> Samples:
    """Return so many samples, evenly over the area, by a sequence of low discrepancy."""
    faces = faces_of(surface)
    whole = np.cumsum(faces.areas)
    face = np.searchsorted(whole, (np.arange(count) + 0.5) / count * whole[-1])
    share = (np.arange(count)[:, None] * _GOLDEN) % 1
    over = share.sum(axis=1) > 1
    share[over] = 1 - share[over]
    a, b, c = surface.points[surface.faces[face]].transpose(1, 0, 2)
    places = a + share[:, :1] * (b - a) + share[:, 1:] * (c - a)
    return Samples(places, faces.normals[face], float(whole[-1]) / count)


def thickness_of(samples: Samples, most: float) -> Array:
    """Return the thickness (m) of a solid at each sample, up to `most`; infinite where no skin is opposite."""
    from scipy.spatial import cKDTree

    count = min(_NEIGHBOURS, len(samples.places))
    reach = max(most, 2 * np.sqrt(samples.area)) * 1.2
    tree = cKDTree(samples.places)
    near = tree.query(samples.places, k=count, distance_upper_bound=reach)[1]
    thickness = np.full(len(samples.places), np.inf)
    for column in near.T[1:]:
        there = np.flatnonzero(column < len(samples.places))
        other = column[there]
        across = samples.places[other] - samples.places[there]
        depth = -np.einsum("ij,ij->i", across, samples.normals[there])
        aside = np.linalg.norm(across + depth[:, None] * samples.normals[there], axis=1)
        facing = np.einsum("ij,ij->i", samples.normals[there], samples.normals[other])
        fits = (facing < _FACING) & (depth > 0) & (depth <= most) & (aside < _ASIDE * depth + np.sqrt(samples.area))
        thickness[there[fits]] = np.minimum(thickness[there[fits]], depth[fits])
    return thickness


def spread(places: Array, spacing: float) -> tuple[Array, Indices]:
    """Return points (m, k) about `spacing` apart among places (n, k), and the nearest of them to each place."""
    from scipy.spatial import cKDTree

    seeds = places[_apart(places, spacing * _DISCS)]
    own = cKDTree(seeds).query(places)[1]
    for _ in range(_LLOYD):
        count = np.bincount(own, minlength=len(seeds))
        sums = np.stack([np.bincount(own, each, len(seeds)) for each in places.T], axis=1)
        seeds = sums[count > 0] / count[count > 0, None]
        own = cKDTree(seeds).query(places)[1]
    names, numbers = np.unique(own, return_inverse=True)
    return seeds[names], numbers.astype(np.int64)


def _apart(places: Array, radius: float) -> Indices:
    """Return the numbers of places of which none lies within a radius of another one, as many as fit."""
    from scipy.spatial import cKDTree

    tree = cKDTree(places)
    alive = np.ones(len(places), bool)
    chosen = []
    for number in np.random.default_rng(1).permutation(len(places)):
        if alive[number]:
            chosen.append(int(number))
            alive[tree.query_ball_point(places[number], radius)] = False
    return np.array(chosen, np.int64)


def curvature(samples: Samples, reach: float) -> Array:
    """Return both principal curvatures (n, 2) in 1/m at samples, the larger first, positive where the body is convex.

    They are the turn of the normals about that turn less than over an edge.
    """
    from scipy.spatial import cKDTree

    places, normals = samples.places, samples.normals
    distance, near = cKDTree(places).query(places, k=min(_CURVED, len(places)), distance_upper_bound=reach)
    there = np.isfinite(distance) & (distance > 0)
    near = np.where(there, near, 0)
    there &= np.einsum("ikc,ic->ik", normals[near], normals) > _SMOOTH
    moved = (places[near] - places[:, None]) * there[..., None]
    turned = (normals[near] - normals[:, None]) * there[..., None]
    one, other = tangents(normals)
    p, q = (np.einsum("ikc,ic->ik", moved, axis) for axis in (one, other))
    r, s = (np.einsum("ikc,ic->ik", turned, axis) for axis in (one, other))
    zero = np.zeros_like(p)
    rows = np.concatenate([np.stack([p, q, zero], axis=2), np.stack([zero, p, q], axis=2)], axis=1)
    right = np.concatenate([r, s], axis=1)
    normal = np.einsum("ika,ikb->iab", rows, rows)
    normal += 1e-6 * reach**2 * np.eye(3)
    a, b, c = np.linalg.solve(normal, np.einsum("ika,ik->ia", rows, right)[..., None])[..., 0].T
    mean, apart = (a + c) / 2, np.hypot((a - c) / 2, b)
    return np.stack([mean + apart, mean - apart], axis=1)


def tangents(normals: Array) -> tuple[Array, Array]:
    """Return two unit vectors (n, 3) across each of the normals (n, 3), and across each other."""
    axis = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    one = np.cross(normals, axis)
    one /= np.maximum(np.linalg.norm(one, axis=1), 1e-300)[:, None]
    return one, np.cross(normals, one)


def rows_of(own: Indices, count: int, values: Array) -> Array:
    """Return the mean (count, k) of values (n, k) over the samples of each point."""
    from scipy.sparse import csr_array

    gather = csr_array((np.ones(len(own)), (own, np.arange(len(own)))), shape=(count, len(own)))
    mean: Array = (gather @ values) / np.maximum(np.bincount(own, minlength=count), 1)[:, None]
    return mean
