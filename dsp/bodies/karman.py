"""Tables of a round plate's stretching by large deflections: von Karman's equations on a polar grid.

A plate that bends by as much as its thickness stretches. With Airy's stress function F, lap^2 F = -(E h/2) L(w, w), and
at an edge that nothing holds in its plane F = F_r = 0: so F is a sum over the modes psi_k of a clamped disc, of roots
z_k, and the energy of stretching one of squares, V = 1/2 sum s_k^2, s_k = sqrt(E h/(4 R^2))/z_k^2 <psi_k, L(w, w)>. A
shape f(r) cos(m t) has three curvatures, by which L(w, w) = (a^2 - b^2 - c^2)/2. Of waves scale (J_m + c I_m):

    a = k^2 (-J_m + c I_m),    b, c = k^2/2 (J_(m+2) +- J_(m-2) + c (I_(m+2) +- I_(m-2))).

A dome adds a strain l_k, linear in w (dome.py). Such a plate is struck on the side to which it bulges.
"""

import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..numerics.bessel import ine, jn
from ..numerics.settled import single
from ..sizes import MOST_SCATTERED
from .dome import Waves, strains_of
from .material import Array, Indices, Material

_STRESSES = 0.7  # times the modes' highest wavenumber: that of the stress functions
_FIRST_STRESSES = 3.0  # added to it
_LEAST_WAVENUMBER = 15.0  # of few modes, whose stress has twice their orders
_POINTS = 1.0  # radii for each unit of that wavenumber
_LANES = 8
_SPARE = 3  # rows more in tables that are read four rows at a time
_HEARD_FLAT, _HEARD_DOMED = 20.0, 40.0  # the thickness over the amplitude at which coupling is heard
_MIXED = 1e-7  # share of a flat disc's mode in a cap's that counts
_GROWTH = 2.2  # c0 over the energy of a flat plate
_FOURFOLD, _THREEFOLD = 0.15, 3.0  # exchange above the coupled modes: as in karman/scatter.py
_SPAN = 0.25  # modes of a block that exchange energy with the next, over those below


@dataclass(frozen=True, eq=False)
class Tables:
    """A polar grid of a plate, as karman/layout.py lays it out: sizes, and values of float32 in one piece.

    first, count (orders,): functions of each order, those that are coupled; places: where each table begins.
    """

    points: int
    angles: int
    first: Indices
    count: Indices
    row: Indices
    stress: Indices
    strain: Indices
    places: dict[str, int | tuple[int, int]]
    values: NDArray[np.float32]


Mask = NDArray[np.bool_]
_FiveIndices = tuple[Indices, Indices, Indices, Indices, Indices]


class Ladder(NamedTuple):
    """The modes that exchange energy with those that are not coupled, by frequency: their places among those laid out.

    below: modes below the first. span: as in karman/scatter.py. start, free: of each grid the first that exchanges
    energy, and the first that is not coupled. mixing (1/(J^2 s), 1/(J s)): as `mixing` returns it.
    """

    place: Indices
    below: int
    span: float
    start: tuple[int, int]
    free: tuple[int, int]
    mixing: tuple[float, float]


class Laid(NamedTuple):
    """A plate's coupling as it is laid out: the modes (n,), those that are coupled in the order of the grids, then the
    others by frequency, and one grid of all that are coupled, one of half of them.

    drained (coupled,): the share in what the auxiliary variable gets where it is far behind the grid's. growth: c0 over
    the energy. least (J): that below which coupling is not heard. highest (Hz): of the coupled modes.
    """

    mode: Indices
    functions: int
    plain: int
    grids: tuple[Tables, Tables]
    drained: Array
    growth: float
    least: float
    highest: float
    ladder: Ladder


@dataclass(frozen=True, eq=False)
class Sheet:
    """A round plate of which modes are coupled by its stretching.

    flat: the waves of the flat disc of radius 1, mass-normalised; stress: those of its stress functions, more than are
    needed; rise: 2 d sqrt(E h)/R of a dome, else 0; parts: as in `dome.Mixed`, empty without one; stretching: sqrt(E
    h/4)/R; mixing: as `mixing` returns it. Functions, by frequency: their numbers among the flat waves (k,), what the
    air shrinks them by, frequencies (Hz), and the places of their modes cos and sin in the body's list, -1 for none.
    bending (Hz): frequencies of the flat waves.
    """

    modes: int
    thickness: float
    flat: Waves
    stress: Waves
    rise: float
    stretching: float
    mixing: tuple[float, float]
    parts: list[tuple[Indices, Array]]
    bending: Array
    function: Indices
    shrinking: Array
    frequency: Array
    cosine: Indices
    sine: Indices
    kept: dict[float, Laid | None] = field(default_factory=dict, repr=False)

    def moved(self, place: Indices) -> "Sheet":
        """Return the same plate, mode i of whose list has moved to place[i], or is gone where that is -1."""
        cosine, sine = (np.where(each >= 0, place[each], -1) for each in (self.cosine, self.sine))
        return replace(self, cosine=cosine, sine=sine, kept={})

    def laid_out(self, top: float) -> Laid | None:
        """Return what is coupled of the modes up to a frequency (Hz), a pair at least; None where there is none."""
        if top not in self.kept:
            self.kept[top] = _lay(self, top)
        return self.kept[top]


def mixing(material: Material, radius: float, thickness: float, dome: float) -> tuple[float, float]:
    """Return how fast a plate's modes exchange energy above those that are coupled: 4 n^2 D of karman/scatter.py by
    N E^2 (1/(J^2 s)), N the modes below, and what a dome adds by E (1/(J s))."""
    mass = material.density * thickness * math.pi * radius**2
    density = math.pi * radius**2 / (2 * thickness * math.sqrt(material.contact_modulus / 12 / material.density))
    ring = math.sqrt(material.youngs_modulus / material.density) * dome / (math.pi * radius**2)  # Hz
    unit = 4 * (1 - material.poisson_ratio**2) ** 2 * density**3
    by_energy = 1 / (thickness**2 * mass)
    return _FOURFOLD * unit * by_energy**2, _THREEFOLD * unit * by_energy * ring**2


def _lay(sheet: Sheet, top: float) -> Laid | None:
    """Return the layout of `Sheet.laid_out`."""
    order = sheet.flat.order[sheet.function].astype(int)
    whole = (sheet.frequency <= top) & (sheet.cosine >= 0) & ((order == 0) | (sheet.sine >= 0))
    near = np.flatnonzero(whole)[np.argsort(sheet.frequency[whole], kind="stable")]
    if not near.size:
        return None
    members = np.cumsum(np.where(order[near] == 0, 1, 2))
    coupled, half = (near[members <= max(most, members[0])] for most in (sheet.modes, sheet.modes // 2))
    listed = coupled[np.lexsort((sheet.frequency[coupled], order[coupled]))]
    plain = int((order[listed] == 0).sum())
    mode = np.concatenate([sheet.cosine[listed], sheet.sine[listed[plain:]]])
    others = _ascending(sheet, np.setdiff1d(np.flatnonzero(sheet.frequency <= top), coupled))
    others = others[: MOST_SCATTERED - mode.size]
    highest = sheet.frequency[coupled].max()
    share = (sheet.frequency[listed] / highest) ** 2
    grids = tuple(_grid(sheet, listed, np.isin(listed, few)) for few in (coupled, half))
    stiffest = _stiffest(sheet)
    return Laid(
        np.concatenate([mode, others]),
        listed.size,
        plain,
        (grids[0], grids[1]),
        single(np.concatenate([share, share[plain:]])),
        float(single(_GROWTH * max(1.0, stiffest))),
        float(single(_least(sheet, int(coupled[0])))),
        float(highest),
        _ladder(sheet, mode, _ascending(sheet, coupled), _ascending(sheet, half).size, others.size),
    )


def _ascending(sheet: Sheet, functions: Indices) -> Indices:
    """Return the places in the body's list of the modes of functions, by frequency."""
    place = np.concatenate([sheet.cosine[functions], sheet.sine[functions]])
    order = np.argsort(np.tile(sheet.frequency[functions], 2), kind="stable")
    return place[order[place[order] >= 0]]


def _ladder(sheet: Sheet, mode: Indices, coupled: Indices, half: int, others: int) -> Ladder:
    """Return the ladder of modes (n,) that are coupled, by frequency `coupled`, of so few of these where half are, and
    of so many others that are laid out after them."""
    number = {int(each): i for i, each in enumerate(mode)}
    whole = np.concatenate([[number[int(each)] for each in coupled], mode.size + np.arange(others)]).astype(int)
    ends = coupled.size, half
    starts = [end - max(int(_SPAN * end / (1 + _SPAN)), 1) for end in ends]
    below = min(starts)
    start, free = ((each[0] - below, each[1] - below) for each in (starts, ends))
    return Ladder(whole[below:], below, _SPAN, start, free, sheet.mixing)


def _stiffest(sheet: Sheet) -> float:
    """Return how much of a flat disc's bending energy the linear stretching of a dome can be, in any shape."""
    most, strains = 0.0, strains_of(sheet.stress, sheet.flat)
    for column, _ in sheet.parts:
        row = np.flatnonzero(sheet.stress.order == sheet.flat.order[column[0]])
        strain = sheet.rise * strains(row, column) / (2 * math.pi * sheet.bending[column])
        most = max(most, float(np.linalg.eigvalsh(strain.T @ strain)[-1]))
    return most


def _only(waves: Waves, which: Indices) -> Waves:
    return Waves(*(each[which] for each in waves))


def _least(sheet: Sheet, lowest: int) -> float:
    """Return the energy (J) of the lowest mode at the amplitude from which on coupling is heard, wherever it moves
    most."""
    radii = np.linspace(0, 1, 65)
    shape = _fields(sheet, np.array([lowest]), radii)[0, 0]
    share = _HEARD_DOMED if sheet.rise else _HEARD_FLAT
    velocity = 2 * math.pi * sheet.frequency[lowest] * sheet.thickness / share / float(np.abs(shape).max())
    return 0.5 * float(velocity) ** 2


def _fields(sheet: Sheet, functions: Indices, r: Array) -> Array:
    """Return values and the three curvatures of functions along radii r (4, functions, points)."""
    wave = sheet.function[functions]
    found = np.empty((4, wave.size, r.size))
    if not sheet.parts:
        found[:] = _waves(_only(sheet.flat, wave), r)
    for column, mixture in sheet.parts:
        mine = np.flatnonzero(np.isin(wave, column))
        if mine.size:
            mix = _mixture(column, mixture, wave[mine])
            used = np.abs(mix).max(axis=1) > _MIXED
            found[:, mine] = np.einsum("wi,fwr->fir", mix[used], _waves(_only(sheet.flat, column[used]), r))
    shrunk: Array = found * sheet.shrinking[functions][:, None]
    return shrunk


def _mixture(column: Indices, mixture: Array, wave: Indices) -> Array:
    """Return the columns of a mixture that make some modes, which have the numbers of flat waves."""
    place = {int(each): i for i, each in enumerate(column)}
    mixed: Array = mixture[:, [place[int(each)] for each in wave]]
    return mixed


def _waves(waves: Waves, r: Array) -> Array:
    """Return values and curvatures a, b and c of waves along radii r (4, waves, points)."""
    m, k = waves.order[:, None], waves.root[:, None]
    x = k * r
    rises = np.exp(x - k) / ine(m, k)
    scale, growing = waves.scale[:, None], waves.growing[:, None]

    def both(order: Array) -> tuple[Array, Array]:
        return jn(order, x), growing * ine(np.abs(order), x) * rises

    (j, i), (j_up, i_up), (j_down, i_down) = both(m), both(m + 2), both(m - 2)
    up, down = j_up + i_up, j_down + i_down
    square = scale * k**2
    found: Array = np.stack([scale * (j + i), square * (i - j), square / 2 * (down + up), square / 2 * (down - up)])
    return found


def _grid(sheet: Sheet, listed: Indices, coupled: Mask) -> Tables:
    """Return the tables of a grid for functions that are listed, of which some are coupled."""
    order = sheet.flat.order[sheet.function[listed]].astype(int)
    orders = int(order[coupled].max()) + 1
    each = np.arange(orders)
    first = np.searchsorted(order, each)
    count = np.array([int(coupled[order == m].sum()) for m in each])
    members = int((np.where(order == 0, 1, 2) * coupled).sum())
    wavenumber = max(2 * math.sqrt(members), _LEAST_WAVENUMBER)
    stress = _chosen(sheet.stress, _STRESSES * wavenumber + _FIRST_STRESSES)
    stresses = int(stress.order.max()) + 1
    points = math.ceil(_POINTS * wavenumber / _LANES) * _LANES
    angles = math.ceil((2 * orders + stresses - 2) / 4)  # for the gradient to be exact
    x, weight = np.polynomial.legendre.leggauss(points)
    r, weight = (x + 1) / 2, weight / 2
    fields = _fields(sheet, listed[coupled], r)[1:]
    shapes = np.concatenate(list(fields), axis=1)
    values = _waves(stress, r)[0]
    scale = sheet.stretching / stress.root**2
    stretch = scale[:, None] * values * r * weight * (2 * math.pi / (4 * angles)) / 2
    starts = np.searchsorted(stress.order, np.arange(stresses + 1))
    bent, strain = _bent(sheet, listed[coupled], stress, orders)
    theta = (np.arange(angles) + 0.5) * 2 * math.pi / (4 * angles)
    pieces = {"shapes": _padded(shapes), "stretch": _padded(stretch), "bent": bent}
    for name, wave in (("cosine", np.cos), ("sine", np.sin)):
        for odd in range(2):
            pieces[f"{name}{odd}"] = wave(np.outer(theta, np.arange(odd, orders, 2)))
            pieces[f"stress_{name}{odd}"] = wave(np.outer(theta, np.arange(odd, stresses, 2)))
    return _packed(pieces, points, angles, (first, count, np.cumsum(count) - count, starts, strain))


def _chosen(stress: Waves, limit: float) -> Waves:
    """Return the stress functions up to a root, by order and root."""
    kept = np.flatnonzero(stress.root <= limit)
    return _only(stress, kept[np.lexsort((stress.root[kept], stress.order[kept]))])


def _bent(sheet: Sheet, functions: Indices, stress: Waves, orders: int) -> tuple[Array, Indices]:
    """Return the linear strains by functions, of each order (its stress functions, its functions), flat, and where each
    order begins."""
    wave = sheet.function[functions]
    pieces: list[Array] = []
    strains = strains_of(stress, sheet.flat)
    for order in range(orders):
        mine = np.flatnonzero(sheet.flat.order[wave] == order)
        row = np.flatnonzero(stress.order == order)
        part = [each for each in sheet.parts if each[0].size and sheet.flat.order[each[0][0]] == order]
        if not part or not mine.size or not row.size:
            pieces.append(np.zeros(0))
            continue
        column, mixture = part[0]
        strain = sheet.rise * strains(row, column)
        shrunk = strain @ _mixture(column, mixture, wave[mine]) * sheet.shrinking[functions[mine]]
        pieces.append(shrunk.ravel())
    sizes = np.array([each.size for each in pieces])
    return np.concatenate(pieces), np.cumsum(sizes) - sizes


def _padded(rows: Array) -> Array:
    return np.concatenate([rows, np.zeros((_SPARE, rows.shape[1]))])


def _packed(pieces: dict[str, Array], points: int, angles: int, indices: _FiveIndices) -> Tables:
    """Return tables in one piece, each from a multiple of LANES on."""
    places: dict[str, int | tuple[int, int]] = {}
    values: list[Array] = []
    at = 0
    for name, piece in pieces.items():
        places[name] = at
        size = math.ceil(piece.size / _LANES) * _LANES
        values.append(np.pad(piece.ravel(), (0, size - piece.size)))
        at += size
    for name in ("cosine", "sine", "stress_cosine", "stress_sine"):
        places[name] = places.pop(f"{name}0"), places.pop(f"{name}1")  # type: ignore[assignment]
    packed = np.concatenate(values).astype(np.float32)
    return Tables(points, angles, *indices, places, packed)
