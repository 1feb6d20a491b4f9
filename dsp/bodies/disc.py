"""Circular plates and membranes, by Bessel functions."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache, lru_cache, partial
from typing import NamedTuple

import numpy as np

from ..numerics.bessel import ine, jn
from ..sizes import MOST_COUPLED, MOST_SCATTERED
from . import acceleration
from .acceleration import Click
from .air import plate_mass
from .choices import EDGES
from .dome import SHALLOW, Waves, at_edge, domed
from .felts import felt_losses, on_stand
from .heard import BAFFLES, Best, heard, largest, loaded
from .karman import Sheet, mixing
from .material import Array, Material
from .modes import MOST_MODES, Indices, Modes, audible, path, read_only, require_choice, require_positive
from .near import critical_frequency, near_field, round_field
from .radiation.round import Every, Loads, Round
from .residual import with_residual
from .ring import Doublets, doublets
from .tension import CONE, membrane_glide
from .unheard import Felt, completed, felt_of

_STEP = 0.6  # of the grid of wavenumbers
_FALSI_STEPS = 12
_TABLE_STEP = 0.2  # of Bessel functions: cubic Hermite interpolation errs by its fourth power over 384
_SIGN_AT = (0.83, math.radians(13.0))  # radius and angle: whose sign a mode's sound has
_FURTHER = 2.0  # times the wavenumbers that are heard: those that are felt
_FADED = 40.0  # of I_n(x) from its value at the edge on: less than rounding
_SIZES = 4  # numbers of radii in an octave
_NEARLY = 1.1  # times the highest frequency wanted: a pair's lower member and the air's mass bring a mode below it


def disc(
    material: Material,
    *,
    radius: float,
    thickness: float,
    top: float,
    dome: float = 0.0,
    nonlinear_modes: int = 0,
    edge: str = "free",
    felt: float = 0.0,
    stand: float = 0.0,
    split: float = 0.0,
    imperfection: float = 20.0,
    split_seed: int = 0,
    baffle: str = "free",
) -> Modes:
    """Return the modes of a thin circular plate (Kirchhoff), struck along a diameter.

    Parameters
    ----------
    material : Material
        Material of the body.
    radius, thickness : float
        Radius and thickness, m.
    top : float
        Highest frequency of a mode, Hz.
    dome : float, default 0
        Rise of the centre over a free edge, m, up to a quarter of the radius.
    nonlinear_modes : int, default 0
        Number of the lowest modes that are coupled by stretching; needs a `split`.
    edge : {"free", "clamped", "supported"}, default "free"
        Edge.
    felt : float, default 0
        Radius of felts at the centre, m; 0: none.
    stand : float, default 0
        Resistance of the stand, kg/s.
    split : float, default 0
        Difference of frequency within each pair of modes, as a share; 0: a round body, without pairs.
    imperfection : float, default 20
        Angle between the strike path and the lower mode of a pair, degrees.
    split_seed : int, default 0
        Seed of random splits, of rms `split`, and angles; 0: all pairs are alike.
    baffle : {"free", "wall", "closed"}, default "free"
        Surroundings: air on both sides; a wall; a wall, closed behind.

    Returns
    -------
    Modes
        The modes from 1 Hz up to `top`.

    Raises
    ------
    ValueError
        An argument is out of range, or the body has no such mode; the text names it.

    Notes
    -----
    f = lambda^2/(2 pi R^2) sqrt(D/(rho h)), lowered by the air; lambda are the roots of the edge's two conditions on
    J_n(lambda r) + c I_n(lambda r) (Leissa, Vibration of Plates, NASA SP-160, 1969). A dome is a shallow parabolic cap,
    on which the air acts as on a flat disc of the same frequencies.
    """
    require_positive(radius=radius, thickness=thickness)
    require_choice("edge", edge, EDGES)
    require_choice("baffle", baffle, BAFFLES)
    if nonlinear_modes:
        _require_coupled(nonlinear_modes, split, split_seed)
    if not 0 <= felt <= radius:
        raise ValueError(f"felt = {felt}: expected 0 to {radius:g}, the radius")
    if not 0 <= stand < math.inf:
        raise ValueError(f"stand = {stand}: expected 0 or more")
    areal = material.density * thickness
    rigidity = material.contact_modulus * thickness**3 / 12
    unit = math.sqrt(rigidity / areal) / (2 * math.pi * radius**2)
    most = MOST_SCATTERED if nonlinear_modes else MOST_MODES
    limit = min(_FURTHER * math.sqrt(top / unit), _enough(2 if split else 1, most))
    every, square = _plate_waves(edge, material.poisson_ratio, limit)
    mine = np.flatnonzero(every.root < limit)
    order, root = every.order[mine], every.root[mine]
    mass = areal * math.pi * radius**2
    waves = Waves(order, root, every.growing[mine], _scale(square[mine], mass, order))

    def flat(steps: int, mode: Indices) -> Array:
        return waves.scale[mode] * _plate_shapes(every, steps)[:, mine[mode]]

    surface = Round(radius, areal, baffle, every, mine, waves.scale)
    body = _Round(unit * root**2, mass, surface, flat, unit * limit**2, most=most, felt=felt / radius)
    stiffness = 4 * material.youngs_modulus * thickness * (dome / radius) ** 2
    parts: list[tuple[Indices, Array]] = []
    if dome:
        _require_cap(dome, radius, edge)
        body, parts = _domed(body, waves, limit, stiffness)
    if nonlinear_modes:
        stretching = math.sqrt(material.youngs_modulus * thickness / 4) / radius
        stress = _stress_functions(limit)
        mixes = mixing(material, radius, thickness, dome)
        made_of = waves, stress, math.sqrt(stiffness), stretching, mixes, parts, unit * root**2
        body = body._replace(sheet=partial(Sheet, nonlinear_modes, thickness, *made_of))
    made = _round(on_stand(material, stand, mass), body, Doublets(split, imperfection, split_seed), top)
    return replace(made, clicks=disc_clicks(material, radius=radius, thickness=thickness, edge=edge, baffle=baffle))


def disc_clicks(
    material: Material, *, radius: float, thickness: float, edge: str = "free", baffle: str = "free", **others: object
) -> tuple[Click, ...]:
    """Return the clicks of a disc; arguments as of `disc`."""
    if baffle != "free":
        return ()
    areal = material.density * thickness
    rigidity = material.contact_modulus * thickness**3 / 12
    whole = acceleration.disc(areal * math.pi * radius**2, radius, thickness)
    return round_field(areal, radius, whole, critical_frequency(areal, rigidity), held=edge != "free")


def _require_cap(dome: float, radius: float, edge: str) -> None:
    """Raise ValueError if a disc with this edge can't have such a dome."""
    if edge != "free":
        raise ValueError(f"dome = {dome}: expected 0 where edge = {edge}; only a free edge may be domed")
    if not 0 < dome <= SHALLOW * radius:
        raise ValueError(f"dome = {dome}: expected 0 to {SHALLOW * radius:g}, a quarter of the radius")


def _require_coupled(modes: int, split: float, seed: int) -> None:
    """Raise ValueError if so many modes of a disc with such pairs can't be coupled."""
    if not 0 < modes <= MOST_COUPLED:
        raise ValueError(f"nonlinear_modes = {modes}: expected 0 to {MOST_COUPLED}")
    if split == 0:
        raise ValueError(f"split = {split}: expected more than 0 where nonlinear_modes = {modes}; both of a pair move")
    if seed:
        raise ValueError(
            f"split_seed = {seed}: expected 0 where nonlinear_modes = {modes}; coupled pairs share one angle"
        )


def _domed(
    flat: "_Round", waves: Waves, limit: float, stiffness: float
) -> tuple["_Round", list[tuple[Indices, Array]]]:
    """Return a disc as a cap, from its waves up to a root, and its mixtures; stiffness as in `domed`."""
    cap = domed(waves, flat.frequency, _stress_functions(limit), stiffness)
    everything = np.arange(waves.order.size)

    def radial(steps: int, mode: Indices) -> Array:
        return cap.mix(flat.radial(steps, everything), mode)

    return flat._replace(frequency=cap.frequency, radial=radial), cap.parts


def _scale(square: Array, mass: float, order: Array) -> Array:
    """Return the factors on waves whose integrals of r times the square are given, so that that over a mass is 1."""
    scale: Array = 1 / np.sqrt(2 * square * mass * np.where(order == 0, 1.0, 0.5))
    return scale


def _stress_functions(limit: float) -> Waves:
    """Return the stress functions of a disc of radius 1 with a free edge: the modes of a clamped one, up to a root."""
    every, square = _plate_waves("clamped", 0.0, limit)
    mine = np.flatnonzero(every.root < limit)
    order, root, growing = (each[mine] for each in (every.order, every.root, every.growing))
    return Waves(order, root, growing, _scale(square[mine], math.pi, order))


def membrane(
    material: Material,
    *,
    radius: float,
    thickness: float,
    top: float,
    tension: float | None = None,
    fundamental: float | None = None,
    split: float = 0.0,
    imperfection: float = 20.0,
    split_seed: int = 0,
    baffle: str = "free",
    best: Best | None = None,
) -> Modes:
    """Return the modes of a circular membrane held at its edge, struck along a diameter.

    Parameters
    ----------
    material : Material
        Material of the body.
    radius, thickness : float
        Radius and thickness of the film, m.
    top : float
        Highest frequency of a mode, Hz.
    tension : float, optional
        Tension T, N/m. Give this or `fundamental`.
    fundamental : float, optional
        Lowest frequency without the air, Hz.
    split : float, default 0
        Difference of frequency within each pair of modes, as a share; 0: a round body, without pairs.
    imperfection : float, default 20
        Angle between the strike path and the lower mode of a pair, degrees.
    split_seed : int, default 0
        Seed of random splits, of rms `split`, and angles; 0: all pairs are alike.
    baffle : {"free", "wall", "closed"}, default "free"
        Surroundings: air on both sides; a wall; a wall, closed behind.
    best : Best, optional
        The modes to keep. Default: all.

    Returns
    -------
    Modes
        The modes from 1 Hz up to `top`.

    Raises
    ------
    ValueError
        An argument is out of range, or the body has no such mode; the text names it.

    Notes
    -----
    f = k/(2 pi) sqrt((T + D k^2)/(rho h)), k R the zeros of J_n, lowered by the air. The film's stiffness D raises
    short waves, those of a tom's head above some 2 kHz. Modes that are not kept count as one compliance (residual.py).
    """
    require_positive(radius=radius, thickness=thickness, tension=tension, fundamental=fundamental)
    require_choice("baffle", baffle, BAFFLES)
    areal = material.density * thickness
    rigidity = material.contact_modulus * thickness**3 / 12
    every, peak = _membrane_waves(_enough(2 if split else 1))
    order, root = every.order, every.root
    if (tension is None) == (fundamental is None):
        raise ValueError(f"tension = {tension}, fundamental = {fundamental}: expected one of the two")
    if fundamental is not None:
        longest = float(root.min()) / radius
        tension = areal * (2 * math.pi * fundamental / longest) ** 2 - rigidity * longest**2
        if tension <= 0:
            raise ValueError(f"fundamental = {fundamental}: expected more; so low it is that of the film's stiffness")
    assert tension is not None
    mass = areal * math.pi * radius**2

    # int_0^1 r J_n(j r)^2 dr = J_(n+1)(j)^2 / 2
    scale = 1 / np.sqrt(mass * np.where(order == 0, 1.0, 0.5)) / peak

    def radial(steps: int, mode: Indices) -> Array:
        shapes = np.take(_film_shapes(every, steps), mode, axis=1)  # row by row, as what follows goes
        shapes *= scale[mode]
        return shapes

    wave = root / radius
    frequency = wave / (2 * math.pi) * np.sqrt((tension + rigidity * wave**2) / areal)

    def extremes(steps: int, mode: Indices) -> tuple[Array, Array]:
        most, last = _film_extremes(every, steps)
        return most[mode] * scale[mode], last[mode] * scale[mode]

    surface = Round(radius, areal, baffle, every, np.arange(root.size), scale)
    body = _Round(frequency, mass, surface, radial, extremes=extremes)
    modes = _round(material, body, Doublets(split, imperfection, split_seed), top, best)
    if modes.frequency.size == MOST_MODES:
        shortest = float(np.sort(np.repeat(wave, 2 if split else 1))[MOST_MODES - 1])
        modes = with_residual(modes, tension, rigidity, areal, shortest, 2 * radius)
    clicks = near_field(areal, acceleration.disc(mass, radius), math.inf, held=True) if baffle == "free" else ()
    return replace(modes, clicks=clicks, glide=membrane_glide(material, radius, thickness, tension), cone=CONE * mass)


class _Round(NamedTuple):
    """A round body: its modes' frequencies without air (Hz, (k,)), and its mass (kg).

    radial: how many radii and modes by number (k,) -> their mass-normalised radial shapes at `_radii`, (p, k). complete
    (Hz): of a plate, up to where these are all that there are. most: of the modes that are kept. felt: radius of
    felts at the centre over the body's. extremes: how many radii and modes by number -> how far these shapes go along
    the radii at most, and what they are where a sound has its sign (k,), where that takes less than to lay them out.
    """

    frequency: Array
    mass: float
    surface: Round
    radial: Callable[[int, Indices], Array]
    complete: float | None = None
    sheet: Callable[[Indices, Array, Array, Indices, Indices], Sheet] | None = None
    most: int | None = None
    felt: float = 0.0
    extremes: Callable[[int, Indices], tuple[Array, Array]] | None = None


def _enough(members: int, most: int | None = None) -> float:
    """Return a k R below which so many modes lie surely: there are about (k R)^2 / 8 of each member."""
    return math.sqrt(8 * (most or MOST_MODES) / members) + 8


_RUNGS = (_enough(2) / 4, _enough(2) / 2, _enough(2), _enough(1), _enough(2, MOST_SCATTERED))
"""The limits up to which roots are searched: few searches serve all discs, and that for few modes takes little time."""


def _round(material: Material, body: _Round, pairs: Doublets, top: float, best: Best | None = None) -> Modes:
    """Return the modes of a round body; best: those that are kept, of one with `extremes`."""
    order, root = body.surface.order, body.surface.root
    near = np.argsort(body.frequency, kind="stable")
    near = near[body.frequency[near] <= _NEARLY * top][: body.most or MOST_MODES]
    alone = body.frequency[near]
    if not near.size:
        audible(alone, top)  # says so
    guess = plate_mass(body.surface.areal, root[near] / body.surface.radius, alone)
    air = loaded(alone, Loads(body.surface.only(near)), guess)
    frequency, which, phase = doublets(air.frequency, order[near], *pairs)
    keep = audible(frequency, top, body.most)
    mine, turned = which[keep], phase[keep]
    each, steps = order[near[mine]], _steps(float(root[near[mine]].max()))

    def laid_out(kept: Indices) -> tuple[Array, Modes]:
        base, member = np.unique(mine[kept], return_inverse=True)
        along = body.radial(steps, near[base])
        along *= air.shrinking[base]
        along = np.take(along, member, axis=1)
        shapes = _across(along[:-1], each[kept], turned[kept]), _signed(along[-1], each[kept], turned[kept])
        resistance = air.resistance[mine[kept]]
        return along, heard(material, frequency[keep[kept]], resistance, shapes, body.mass)

    if best is not None and body.extremes is not None:
        most, last = (part * air.shrinking[mine] for part in body.extremes(steps, near[mine]))
        reach = most * np.maximum(*(np.abs(np.cos(angle * each - turned)) for angle in (math.pi, 0.0)))
        rough = reach[None], _signed(last, each, turned)
        all_of_it = heard(material, frequency[keep], air.resistance[mine], rough, body.mass)
        if keep.size == MOST_MODES:
            all_of_it.pressure[:, -1] = 0.0  # `with_residual` puts one that is felt in its place
        kept, sides = best.among(all_of_it.frequency, all_of_it.pressure, reach, all_of_it.decay)
        along, made = laid_out(kept)
        made = replace(made, decay=all_of_it.decay[kept], pressure=sides)
    else:
        along, made = laid_out(np.arange(keep.size))
    if body.felt > 0:
        lost = felt_losses(body.felt, made.frequency, each, _radii(steps)[:-1], along[:-1])
        made = replace(made, decay=made.decay + lost)
    if body.sheet is not None:
        cosine, sine = _members(order[near], which, keep)
        made = replace(made, sheet=body.sheet(near, air.shrinking, air.frequency, cosine, sine))
    if body.complete is None and keep.size == MOST_MODES:
        return made

    felt = _others(body, pairs, 2 * near[mine] + (keep >= near.size), steps)
    if body.complete is not None:
        felt = completed(Felt(made.frequency, made.strike), felt, body.complete, 2 * top)
    return replace(made, unheard=felt_of(felt, material.decay, keep.size, top))


def _others(body: _Round, pairs: Doublets, kept: Indices, steps: int) -> Felt:
    """Return the modes of a round body but for those kept: twice their numbers, and 1 more for the upper of a pair."""
    order = body.surface.order
    frequency, other, phase = doublets(body.frequency, order, *pairs)
    upper = np.arange(other.size) >= order.size
    others = np.flatnonzero(~np.isin(2 * other + upper, kept))
    base, member = np.unique(other[others], return_inverse=True)
    shapes = _across(np.take(body.radial(steps, base)[:-1], member, axis=1), order[other[others]], phase[others])
    return Felt(frequency[others], shapes)


def _signed(along: Array, order: Array, phase: Array) -> Array:
    """Return what shapes are where a sound has its sign, from what they are there along a radius (k,)."""
    signed: Array = along * np.cos(_SIGN_AT[1] * order - phase)
    return signed


def _steps(root: float) -> int:
    """Return how many radii show waves up to a root: one of few numbers, so that shapes serve other discs, too."""
    least = path(2 * root).size // 2 + 1
    return math.ceil(2 ** (math.ceil(_SIZES * math.log2(least)) / _SIZES))


def _radii(steps: int) -> Array:
    """Return so many equally spaced radii, from the centre to the edge, and that at which a mode's sound has its
    sign."""
    return np.append(np.linspace(0, 1, steps), _SIGN_AT[0])


def _members(order: Array, which: Indices, keep: Indices) -> tuple[Indices, Indices]:
    """Return the places of the modes cos and sin of functions of some orders among those kept of `ring.doublets`, -1
    for none."""
    place = np.full(which.size, -1)
    place[keep] = np.arange(keep.size)
    cosine, sine = place[: order.size], np.full(order.size, -1)
    sine[which[order.size :]] = place[order.size :]
    return cosine, sine


def _across(along: Array, order: Array, phase: Array) -> Array:
    """Return shapes along a diameter from those along a radius, from the centre on (p, k): cos(n theta - phase) times
    them."""
    far, near = (np.cos(angle * order - phase) for angle in (math.pi, 0.0))
    steps = len(along)
    across = np.empty((2 * steps - 1, order.size))
    np.multiply(along[:0:-1], far, out=across[: steps - 1])
    np.multiply(along, near, out=across[steps - 1 :])
    return across


@lru_cache(maxsize=2)  # of single modes and of doublets; 30 ms each
def _membrane_waves(limit: float) -> tuple[Every, Array]:
    """Return the waves J_n(j r) with J_n(j) = 0, 0 < j < limit, and |J_(n+1)(j)| of each."""
    order, root = _roots(lambda root, order: jn(order, root), limit)
    every = Every(order, root, np.zeros_like(root))
    peak = np.abs(jn(every.order + 1, every.root))
    read_only(every.order, every.root, every.growing, peak)
    return every, peak


@lru_cache(maxsize=8)  # 3 MB each at most
def _film_shapes(every: Every, steps: int) -> Array:
    """Return the shapes (p, k) of a membrane's waves at `_radii`, read-only."""
    shapes = _bessel(every.order, np.outer(_radii(steps), every.root))
    read_only(shapes)
    return shapes


@lru_cache(maxsize=8)  # 16 kB each
def _film_extremes(every: Every, steps: int) -> tuple[Array, Array]:
    """Return how far the shapes of a membrane's waves go at most, and what they are where a sound has its sign."""
    shapes = _film_shapes(every, steps)
    return largest(shapes[:-1]), shapes[-1].copy()


def _bessel(order: Array, x: Array) -> Array:
    """Return J_n(x) of whole orders (k,) at x (p, k), within 5e-6; from a table, as many points share few orders."""
    table, slopes = _bessel_table()
    n, (t, cell) = order.astype(int), np.modf(x / _TABLE_STEP)
    i = cell.astype(int)
    left, right = table[n, i], table[n, i + 1]
    bow_left, bow_right = slopes[n, i] - (right - left), (right - left) - slopes[n, i + 1]
    value: Array = left + t * (right - left) + t * (1 - t) * ((1 - t) * bow_left + t * bow_right)
    return value


@cache  # 1.5 MB in all, 80 ms
def _bessel_table() -> tuple[Array, Array]:
    """Return J_n of the orders n from 0 and its change in a step, at the steps from 0, as far as roots go;
    read-only."""
    step, most = _TABLE_STEP, _RUNGS[-1]
    grid = np.arange(0, most + 2 * step, step)
    table = jn(np.arange(-1.0, math.ceil(most) + 1)[:, None], grid)
    slopes = (table[:-2] - table[2:]) * step / 2  # J_n' = (J_(n-1) - J_(n+1)) / 2
    table = table[1:-1]
    read_only(table, slopes)
    return table, slopes


def _conditions(edge: str, nu: float, root: Array, order: Array) -> tuple[Array, Array, Array, Array]:
    """Return the edge's conditions on J_n(root r) and I_n(root r) / I_n(root) at r = 1: (J1, J2, I1, I2)."""
    j, dj, di = at_edge(order, root)
    dj, di, square = root * dj, root * di, root**2

    def moment(laplacian: Array | float, w: Array | float, slope: Array) -> Array:
        return laplacian - (1 - nu) * (slope - order**2 * w)

    def shear(slope_of_laplacian: Array, w: Array | float, slope: Array) -> Array:
        return slope_of_laplacian - (1 - nu) * order**2 * (slope - w)

    if edge == "clamped":
        return j, dj, np.ones_like(j), di
    if edge == "supported":
        return j, moment(-square * j, j, dj), np.ones_like(j), moment(square, 1.0, di)
    return (
        moment(-square * j, j, dj),
        shear(-square * dj, j, dj),
        moment(square, 1.0, di),
        shear(square * di, 1.0, di),
    )


def _search(edge: str, nu: float, limit: float) -> tuple[Array, Array]:
    """Return orders and roots of a plate up to a limit."""

    def determinant(root: Array, order: Array) -> Array:
        j1, j2, i1, i2 = _conditions(edge, nu, root, order)
        return j1 * i2 - j2 * i1

    return _roots(determinant, limit)


def _roots(determinant: Callable[[Array, Array], Array], limit: float) -> tuple[Array, Array]:
    """Return orders and roots, up to a limit, of a function of both; a root does not depend on the limit, to the bit.

    For one order n they lie about pi apart, the first of them above n/2.
    """
    grid = np.arange(_STEP, limit + 1, _STEP)
    orders = np.arange(math.ceil(limit) + 1.0)
    value = determinant(grid[None], orders[:, None])
    row, cell = np.nonzero(np.signbit(value[:, :-1]) != np.signbit(value[:, 1:]))
    low, high, order = grid[cell], grid[cell + 1], orders[row]
    at_low, at_high = value[row, cell], value[row, cell + 1]
    found, settled = np.zeros_like(low), np.zeros(low.shape, np.bool_)
    for _ in range(_FALSI_STEPS):  # regula falsi, the stale end's value halved (Illinois): to rounding in 8 to 11 steps
        root = (low * at_high - high * at_low) / (at_high - at_low)
        at_root = determinant(root, order)
        crossed = np.signbit(at_root) != np.signbit(at_high)
        low, at_low = np.where(crossed, high, low), np.where(crossed, at_high, at_low / 2)
        high, at_high = root, at_root
        found = np.where(settled, found, root)
        settled |= (np.abs(high - low) < 1e-13 * high) | (at_root == 0)
        if settled.all():
            break
    mine = found < limit
    return order[mine], found[mine]


def _plate_waves(edge: str, nu: float, limit: float) -> tuple[Every, Array]:
    """Return all waves J_n(root r) + c I_n(root r)/I_n(root) up to a root of `limit` or more, and the integrals of r
    times their squares (k,)."""
    return _waves_to(edge, nu, min(rung for rung in _RUNGS if rung >= limit))


@lru_cache(maxsize=16)  # 1 MB each, and as much as is solved of the air
def _waves_to(edge: str, nu: float, rung: float) -> tuple[Every, Array]:
    order, root = _search(edge, nu, rung)
    j1, j2, i1, i2 = _conditions(edge, nu, root, order)
    second = np.abs(i2) > np.abs(i1)  # the better conditioned of the two
    c = -np.where(second, j2, j1) / np.where(second, i2, i1)

    # int_0^1 r (J + c I)^2 dr in closed form; I is taken relative to its value at the edge
    j, dj, di = at_edge(order, root)
    ratio = (order / root) ** 2
    square = 0.5 * (dj**2 + (1 - ratio) * j**2)
    square += c**2 * 0.5 * ((1 + ratio) - di**2)
    square += 2 * c * (j * di - dj) / (2 * root)
    read_only(order, root, c, square)
    return Every(order, root, c), square


@lru_cache(maxsize=8)  # 3 MB each at most
def _plate_shapes(every: Every, steps: int) -> Array:
    """Return the shapes J + c I (p, k) of a plate's waves at `_radii`, read-only."""
    x = np.outer(_radii(steps), every.root)
    shapes = _bessel(every.order, x)
    row, mode = np.nonzero(x > every.root - _FADED)
    order, root, at = every.order[mode], every.root[mode], x[row, mode]
    edge = ine(every.order, every.root)
    shapes[row, mode] += every.growing[mode] * ine(order, at) / edge[mode] * np.exp(at - root)
    read_only(shapes)
    return shapes
