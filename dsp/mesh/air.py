"""The sound that modes radiate: a layer of dipoles over the surface, by collocation.

The jump mu of the pressure over the surface moves the air along its normal as the modes do: K mu = i omega rho v, time
as exp(-i omega t), K = -d^2 G/(dn dn'), G = exp(ikr)/(4 pi r). Thin walls are one layer in their middle. A solid one
has monopoles of i/k's order beside the dipoles, so that no resonance of its inside stands in the way (A. Burton and
G. Miller, Proc. R. Soc. A 323, 1971). K is strongly singular: its static part is summed over samples of each point's
neighbours, and its diagonal follows from a constant jump, which moves nothing inside of a closed body.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..bodies.air import DENSITY, IMPEDANCE, SPEED
from ..bodies.material import Array
from .points import Samples, rows_of, sampled, spread, thickness_of
from .surface import Indices, Surface, faces_of

Complex = npt.NDArray[np.complex128]

_SAMPLES = 32  # of each point
_NEAR = 3.2  # spacings: nearer points are summed over their samples
_WINDOW = 0.9  # of the spacing: within, the plane's finite part stands for the samples
_WINDOWS = 6  # of the window: beyond, samples count in full
_INSET = 0.25  # of the spacing: by which a layer of even jumps ends before its rim, so that it acts as one as large
_MOST_INSET = 0.4  # of a point's samples
_SHARP = 0.4  # of the spacing: how far the rim is looked for
_GROUP = 0.06  # of a frequency: modes within are solved together
_LOSS = 0.02  # of the wavenumber: takes the edge off resonances of air inside thin walls
_DIRECTIONS = 240
_THIN = 0.35  # of the spacing: thinner walls are one layer
_APART = 0.7  # of the spacing: how far off the faces at an edge count, so that no point is of both
_LEAST_AREA = 0.05  # of the median's
_WAVE = 2.5  # points a wavelength at least
_TOGETHER = 8  # points whose samples are summed at a time


class Layer(NamedTuple):
    """Points (n, 3) of a layer with normals, areas (n,), and its samples: place, normal, area, and point of each."""

    places: Array
    normals: Array
    areas: Array
    samples: Samples
    weights: Array
    own: Indices
    closed: bool


class Radiation(NamedTuple):
    """Resistance R (n,) in 1/s of modes of unit mass: each radiates R q'^2/2. mass (n,): of the air that moves with
    them, as a share of theirs; 0 where it isn't known. piston (n,): R in 1/s if each area radiated for itself."""

    resistance: Array
    mass: Array
    piston: Array


def layer_of(surface: Surface, kind: str, points: int) -> tuple[Layer, Array]:
    """Return a layer of about so many points, and the points of the surface (samples, 3) that its samples stand for.

    kind: a "solid", of which thin walls become one layer in their middle; a "sheet", which is open; or "hollow", a
    sheet that is closed, and moves the air outside alone.
    """
    area = float(faces_of(surface).areas.sum())
    samples = sampled(surface, _SAMPLES * points)
    thickness = np.full(len(samples.places), np.inf)
    if kind == "solid":
        thickness = thickness_of(samples, _THIN * np.sqrt(area / points))
    thin = np.isfinite(thickness)
    share = float(thin.mean())
    spacing = np.sqrt(area * (1 - share / 2) / points)
    if share < 0.1:
        thin[:] = False
    elif share > 0.6:  # the rims of a thin body go with its walls
        thickness = np.where(thin, thickness, np.median(thickness[thin]))
        rim = ~thin & _beside(samples.places, thin, 1.5 * float(np.median(thickness[thin])))
        kept = ~rim
        samples = Samples(samples.places[kept], samples.normals[kept], samples.area)
        thickness, thin = thickness[kept], thin[kept]
    depth = np.where(thin, thickness, 0.0)
    middle = Samples(samples.places - samples.normals * depth[:, None] / 2, samples.normals, samples.area)
    weights = np.where(thin, samples.area / 2, samples.area)
    looks = np.where(thin[:, None], 0.0, middle.normals) * (_APART * spacing)
    places, own = spread(np.hstack([middle.places, looks]), spacing)
    places = places[:, :3]
    closed = kind != "sheet" and not thin.any()
    inner = np.ones(len(own), bool) if closed else _inset(middle, weights, own, spacing)
    middle, weights, own = Samples(middle.places[inner], middle.normals[inner], middle.area), weights[inner], own[inner]
    normals = _directions(middle.normals, own, len(places))
    if not closed:
        places = np.stack([np.bincount(own, each, len(places)) for each in middle.places.T], axis=1)
        places /= np.bincount(own, minlength=len(places))[:, None]
        normals = _alike(places, normals)
    areas = np.asarray(np.bincount(own, weights, len(places)), np.float64)
    keep = areas > _LEAST_AREA * np.median(areas)
    number = np.cumsum(keep) - 1
    stay = keep[own]
    middle = Samples(middle.places[stay], middle.normals[stay], middle.area)
    layer = Layer(places[keep], normals[keep], areas[keep], middle, weights[stay], number[own[stay]], closed)
    return layer, samples.places[inner][stay]


def _inset(samples: Samples, weights: Array, own: Indices, spacing: float) -> npt.NDArray[np.bool_]:
    """True for samples that stay: those near a rim go, of each point 40 % at most."""
    from scipy.spatial import cKDTree

    width = _SHARP * spacing
    tree = cKDTree(samples.places)
    near = tree.sparse_distance_matrix(tree, 2.5 * width, output_type="coo_matrix")
    shares = np.exp(-((near.data / width) ** 2)) * weights[near.col]
    covered = np.bincount(near.row, shares, len(own)) / (np.pi * width**2)
    aside = covered < (1 + math.erf(_INSET / _SHARP)) / 2
    # The place of each sample among those of its point, the nearest to the rim first.
    order = np.lexsort((covered, own))
    count = np.bincount(own)
    rank = np.empty(len(own))
    rank[order] = np.arange(len(own)) - np.repeat(np.cumsum(count) - count, count)
    inner: npt.NDArray[np.bool_] = ~(aside & (rank + 1 <= _MOST_INSET * count[own]))
    return inner


def _beside(places: Array, thin: npt.NDArray[np.bool_], reach: float) -> npt.NDArray[np.bool_]:
    """True for places that have a thin wall within reach (m)."""
    from scipy.spatial import cKDTree

    found: npt.NDArray[np.bool_] = cKDTree(places[thin]).query(places, distance_upper_bound=reach)[0] < reach
    return found


def _directions(normals: Array, own: Indices, count: int) -> Array:
    """Return the common direction (count, 3) of the samples' normals of each point, towards most of them."""
    products = np.stack(
        [np.bincount(own, normals[:, i] * normals[:, j], count) for i in range(3) for j in range(3)], axis=1
    )
    common = np.linalg.eigh(products.reshape(count, 3, 3))[1][:, :, 2]
    towards = np.bincount(own, np.einsum("ij,ij->i", normals, common[own]), count)
    directed: Array = common * np.where(towards < 0, -1.0, 1.0)[:, None]
    return directed


def _alike(places: Array, normals: Array) -> Array:
    """Return normals of which those of neighbours point to one side: signs go along a tree of the least turns."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree
    from scipy.spatial import cKDTree

    distance, near = cKDTree(places).query(places, k=min(9, len(places)))
    one = np.repeat(np.arange(len(places), dtype=np.int32), near.shape[1] - 1)
    other = near[:, 1:].ravel().astype(np.int32)  # scipy 1.15 takes no others
    turn = 1.01 - np.abs(np.einsum("ij,ij->i", normals[one], normals[other]))
    cost = turn * (distance[:, 1:] / np.median(distance[:, 1])).ravel() ** 2
    tree = minimum_spanning_tree(coo_array((cost, (one, other)), shape=(len(places),) * 2).tocsr())
    sign = np.zeros(len(places))
    for start in range(len(places)):
        if sign[start]:
            continue
        order, before = breadth_first_order(tree, start, directed=False)
        sign[start] = 1.0
        for each in order[1:]:
            sign[each] = sign[before[each]] * np.sign(normals[each] @ normals[before[each]] or 1.0)
    return normals * sign[:, None]


def nearest_pair(layer: Layer) -> Array:
    """Return the place (3,) between the two points of a layer that are nearest to each other."""
    from scipy.spatial import cKDTree

    distance, near = cKDTree(layer.places).query(layer.places, k=2)
    one = int(distance[:, 1].argmin())
    middle: Array = layer.places[[one, near[one, 1]]].mean(axis=0)
    return middle


def velocities(layer: Layer, shapes: Array) -> Array:
    """Return the velocity (points, modes) along the layer's normals of shapes (samples, 3, modes)."""
    along = np.einsum("ijm,ij->im", shapes, layer.normals[layer.own])
    return rows_of(layer.own, len(layer.places), along)


def radiation(layer: Layer, motion: Array, frequency: Array) -> Radiation:
    """Return the radiation of modes that move (points, modes) along the layer's normals, frequencies (Hz) ascending.

    Above some 2.5 points a wavelength each area radiates for itself, and between the two the powers are blended.
    """
    static = _static(layer)
    resistance, mass = np.zeros((2, len(frequency)))
    sides = 1 if layer.closed else 2
    flat = IMPEDANCE * sides * (layer.areas @ motion**2)
    limit = SPEED / (_WAVE * float(np.sqrt(np.median(layer.areas))))
    begin = 0
    while begin < len(frequency):
        end = int(np.searchsorted(frequency, frequency[begin] * (1 + _GROUP), side="right"))
        middle = float(np.sqrt(frequency[begin] * frequency[end - 1]))
        if frequency[begin] < limit:
            group = slice(begin, end)
            resistance[group], mass[group] = _solved(layer, static, motion[:, group], middle, frequency[group])
        begin = end
    share = np.clip((frequency / limit - 0.7) / 0.3, 0, 1)
    resistance = np.where(share >= 1, flat, (1 - share) * np.where(share >= 1, 0, resistance) + share * flat)
    return Radiation(resistance, mass, flat)


class _Static(NamedTuple):
    """The part that does not depend on frequency: distances (n, n), cosines, K at rest, and the monopoles' own part."""

    distance: Array
    both: Array  # n.n'
    here: Array  # n.r/r
    there: Array  # n'.r/r
    rest: Array
    monopoles: Array


def _static(layer: Layer) -> _Static:
    places, normals, areas = layer.places, layer.normals, layer.areas
    difference = places[:, None] - places[None]
    distance = np.linalg.norm(difference, axis=2)
    np.fill_diagonal(distance, 1.0)
    both = normals @ normals.T
    here = np.einsum("ijk,ik->ij", difference, normals) / distance
    there = np.einsum("ijk,jk->ij", difference, normals) / distance
    rest = (both - 3 * here * there) / (4 * np.pi * distance**3) * areas
    np.fill_diagonal(rest, 0.0)
    _near(layer, rest)
    own = 0.0 if layer.closed else _constant(layer)
    np.fill_diagonal(rest, own - rest.sum(axis=1))
    column = (-here / (4 * np.pi * distance**2) * areas[:, None] * (1 - np.eye(len(areas)))).sum(axis=0)
    return _Static(distance, both, here, there, rest, -0.5 - column)


def _kernel(layer: Layer, point: Indices, sample: Indices) -> Array:
    """Return the static motion at points by dipoles at samples, for the samples' areas and their points' normals."""
    places, normals = layer.samples.places[sample], layer.samples.normals[sample]
    turned = np.einsum("ij,ij->i", normals, layer.normals[layer.own[sample]])
    difference = layer.places[point] - places
    distance = np.maximum(np.linalg.norm(difference, axis=1), 1e-9)
    both = np.einsum("ij,ij->i", layer.normals[point], normals)
    p = np.einsum("ij,ij->i", layer.normals[point], difference) * np.einsum("ij,ij->i", normals, difference)
    value: Array = (both - 3 * p / distance**2) / (4 * np.pi * distance**3)
    return np.asarray(value * np.sign(turned) * layer.weights[sample])


def _near(layer: Layer, rest: Array) -> None:
    """Replace K at rest between near points by its sum over the samples, the mean of both ways: by those of one point
    at the other, and the other way round. One way alone is some dB too loud where much of the sound cancels."""
    from scipy.spatial import cKDTree

    reach = _NEAR * float(np.sqrt(np.median(layer.areas)))
    pairs = cKDTree(layer.samples.places).sparse_distance_matrix(cKDTree(layer.places), reach, output_type="ndarray")
    sample, point = pairs["i"], pairs["j"]
    other = point != layer.own[sample]
    point, sample = point[other], sample[other]
    count = len(rest)
    key = point * count + layer.own[sample]
    value = np.bincount(key, _kernel(layer, point, sample), count * count)
    met = np.bincount(key, minlength=count * count).reshape(count, count)
    whole = (met == np.bincount(layer.own, minlength=count)) & (met > 0)
    rest[whole] = value.reshape(count, count)[whole]
    both = layer.areas[:, None] * rest
    rest[:] = (both + both.T) / (2 * layer.areas[:, None])


def _constant(layer: Layer) -> Array:
    """Return the motion (n,) at each point by a constant jump over the layer, as a finite part.

    Samples count by 1 - exp(-(r/s)^4). What that leaves of a plane is -Gamma(3/4)/(2 s), less what lies beyond a
    straight rim, whose distance follows from how much of the plane about is there.
    """
    from scipy.special import erfinv

    width = _WINDOW * float(np.sqrt(np.median(layer.areas)))
    middle = layer.places.mean(axis=0)  # far from it digits would be lost
    places, normals = layer.samples.places - middle, layer.samples.normals
    # A constant jump along the normal of this point: samples count by their own point's side.
    weights = np.sign(np.einsum("ij,ij->i", normals, layer.normals[layer.own])) * layer.weights
    sums, covered = np.empty((2, len(layer.places)))
    apart = np.einsum("ij,ij->i", normals, places)
    for begin in range(0, len(layer.places), _TOGETHER):
        some = slice(begin, begin + _TOGETHER)
        here, look = layer.places[some] - middle, layer.normals[some]
        square = np.maximum((places**2).sum(axis=1) + (here**2).sum(axis=1)[:, None] - 2 * here @ places.T, 1e-18)
        turned = 3 * (np.einsum("ij,ij->i", here, look)[:, None] - look @ places.T) * (here @ normals.T - apart)
        value = weights * (look @ normals.T - turned / square) / (4 * np.pi * square * np.sqrt(square))
        row, near = np.nonzero(square < (_WINDOWS * width) ** 2)
        share = square[row, near] / width**2
        value[row, near] *= -np.expm1(-(share**2))
        sums[some] = value.sum(axis=1)
        covered[some] = np.bincount(row, layer.weights[near] * np.exp(-share), len(here)) / (np.pi * width**2)
    rim = erfinv(2 * np.clip(covered, 0.55, 1 - 1e-6) - 1)
    found: Array = sums - (math.gamma(0.75) / 2 + np.interp(rim, *_beyond_rim())) / width
    return found


@lru_cache(maxsize=1)
def _beyond_rim() -> tuple[Array, Array]:
    """Return distances of a straight rim, and the integral of exp(-r^4)/(4 pi r^3) beyond each."""
    distance = np.linspace(0.05, 3.0, 600)
    angle = (np.arange(400) + 0.5) / 400 * np.pi / 2
    r = distance[:, None] / np.cos(angle)
    each = np.exp(-(r**4)) * angle * np.sin(angle)
    return distance, each.sum(axis=1) * (np.pi / 2 / 400) / (2 * np.pi * distance)


def _solved(layer: Layer, static: _Static, motion: Array, frequency: float, own: Array) -> tuple[Array, Array]:
    """Return resistances and masses of motions (points, k) at a frequency (Hz); own (k,): theirs (Hz), which are near.

    The jump of a motion goes with its frequency, all but; what reaches the far field of it is found at its own.
    """
    from scipy.linalg.lapack import cgesv

    omega = 2 * np.pi * frequency
    k = omega / SPEED
    size = float(np.sqrt(layer.areas.sum() / (4 * np.pi)))
    beta = 1 / size + 1j * k if layer.closed else 0j
    matrix = _matrix(layer, static, complex(k, 0 if layer.closed else _LOSS * k), beta)
    scale = float(np.sqrt(np.median(layer.areas)))
    right = 1j * omega * DENSITY * motion
    jump = cgesv((matrix * scale).astype(np.complex64), (right * scale).astype(np.complex64))[2].astype(np.complex128)
    resistance = np.array([_far(layer, each, beta.real, jump[:, n] * each / frequency) for n, each in enumerate(own)])
    if layer.closed:
        return resistance, np.zeros(len(resistance))
    impedance = np.einsum("i,im,im->m", layer.areas, motion, jump)
    return resistance, np.maximum(-impedance.imag / omega, 0.0)


def _far(layer: Layer, frequency: float, beta: float, jump: Complex) -> float:
    """Return the resistance (1/s) of a jump (points,) at a frequency (Hz), by its far field."""
    k, directions = 2 * np.pi * frequency / SPEED, _sphere(_DIRECTIONS)
    source = -1j * k * (directions @ layer.normals.T) + (beta + 1j * k if beta else 0)
    angle = k * (directions @ (layer.places - layer.places.mean(axis=0)).T)
    far = (_turned(angle).conj() * source) @ (layer.areas * jump) / (4 * np.pi)
    return float((np.abs(far) ** 2).mean() * 4 * np.pi / IMPEDANCE)


def _turned(angle: Array) -> npt.NDArray[np.complex64]:
    """Return exp(i angle) to seven digits, in a tenth of the time of all."""
    single = angle.astype(np.float32)
    found = np.empty(single.shape, np.complex64)
    np.cos(single, out=found.real)
    np.sin(single, out=found.imag)
    return found


def _matrix(layer: Layer, static: _Static, k: complex, beta: complex) -> Complex:
    """Return the motions (n, n) by dipoles, and beta monopoles, of unit strength at each point."""
    r, areas = static.distance, layer.areas
    ikr = 1j * k * r
    wave = _turned(k.real * r)
    if k.imag:
        wave *= np.exp(np.asarray(-k.imag * r, np.float32))
    one, two = ikr - 1, ikr * ikr - 2 * ikr + 2
    turned = static.here * static.there
    moving = wave * (one * static.both + (two - one) * turned) - (3 * turned - static.both)
    matrix = static.rest - moving / (4 * np.pi * r**3) * areas
    radius = np.sqrt(areas / np.pi)
    own = np.diag(static.rest) + k.real**2 * radius / 4 + 1j * k.real**3 * radius**2 / 12
    if beta:
        matrix += beta * wave * one * static.here / (4 * np.pi * r**2) * areas
        own = own + beta * (static.monopoles - 0.5)
    np.fill_diagonal(matrix, own)
    return np.asarray(matrix)


def _sphere(count: int) -> Array:
    """Return directions (count, 3) evenly over the sphere, by the golden angle."""
    number = np.arange(count) + 0.5
    z = 1 - 2 * number / count
    angle = np.pi * (1 + 5**0.5) * number
    return np.stack([np.sqrt(1 - z * z) * np.cos(angle), np.sqrt(1 - z * z) * np.sin(angle), z], axis=1)
