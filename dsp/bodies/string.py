"""Strings: stiff, between two rigid supports."""

import math
from dataclasses import asdict, dataclass, replace
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from ..kept import Kept
from .choices import MOST_WIRES
from .heard import Best, heard, largest, pressure
from .material import Array, Material
from .modes import (
    MOST_MODES,
    Indices,
    Modes,
    ascending,
    audible,
    path,
    read_only,
    require_choice,
    require_positive,
    selected,
)
from .radiation.board import BOARDS, Board
from .tension import string_glide
from .unheard import FINER, felt_of, shares_of
from .unison import in_unison

_FURTHER = 8  # times the modes that are heard: those that are felt
_ORDERS = 64  # orders by which tables of waves grow, so that few are made
_RESONANCE = "frequency", "quality", "mass"
_SIGN_AT = 0.07  # of the length: whose sign a mode's sound has


def string(
    material: Material,
    *,
    length: float,
    diameter: float,
    top: float,
    tension: float | None = None,
    fundamental: float | None = None,
    linear_density: float | None = None,
    inharmonicity: float | None = None,
    bending_loss: float = 0.0,
    board: str = "piano",
    wires: int = 1,
    mistuning: float = 1.0,
    best: Best | None = None,
) -> Modes:
    """Return the modes of a stiff string with pinned ends, heard through a board.

    Parameters
    ----------
    material : Material
        Material of the body.
    length : float
        Length, m, which is the strike path.
    diameter : float
        Diameter, m; of a wound string, its core's.
    top : float
        Highest frequency of a mode, Hz.
    tension : float, optional
        Tension T, N. Give this or `fundamental`.
    fundamental : float, optional
        Lowest frequency f0 of the string without stiffness, Hz.
    linear_density : float, optional
        Mass of a wound string per length, kg/m. Default: that of the core.
    inharmonicity : float, optional
        Coefficient B. Default: the core's, pi^3 E d^4/(64 T L^2) (Fletcher 1964).
    bending_loss : float, default 0
        Loss factor of the energy that bends the string, beside the material's losses.
    board : {"piano", "box", "cello", "guitar"}, default "piano"
        Sounding board at its end.
    wires : int, default 1
        Number of such strings that share a hammer and a bridge, 1 to 3.
    mistuning : float, default 1
        Detuning from the lowest to the highest of them, cents.
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
    f_n = n f0 sqrt(1 + B n^2). The string loses the power that enters the board, and the share of it that the board
    radiates is heard. How several strings decay follows from the losses and the board (unison.py).
    """
    require_choice("board", board, tuple(BOARDS))
    body = BOARDS[board]
    if wires not in range(1, MOST_WIRES + 1) or not 0 <= mistuning < math.inf:
        raise ValueError(f"wires = {wires}, mistuning = {mistuning}: expected 1 to {MOST_WIRES}, and cents from 0 on")
    if wires > 1 and material.losses != "material":
        raise ValueError(f"wires = {wires}, losses = {material.losses}: expected losses = material for several wires")
    require_positive(length=length, diameter=diameter, tension=tension)
    require_positive(fundamental=fundamental, linear_density=linear_density)
    density = linear_density or material.density * math.pi * diameter**2 / 4
    if tension is not None and fundamental is None:
        fundamental = math.sqrt(tension / density) / (2 * length)
    elif fundamental is not None and tension is None:
        tension = density * (2 * length * fundamental) ** 2
    else:
        raise ValueError(f"tension = {tension}, fundamental = {fundamental}: expected one of the two")
    if inharmonicity is None:
        inharmonicity = math.pi**3 * material.youngs_modulus * diameter**4 / (64 * tension * length**2)
    if not 0 <= bending_loss < math.inf:
        raise ValueError(f"bending_loss = {bending_loss}: expected a loss factor, 0 or more")
    if bending_loss:
        material = _Bent(**asdict(material), fundamental=fundamental, inharmonicity=inharmonicity, bending=bending_loss)

    orders = np.arange(1.0, MOST_MODES + 1)
    frequencies = orders * fundamental * np.sqrt(1 + inharmonicity * orders**2)
    order, frequency = (values[audible(frequencies, top)] for values in (orders, frequencies))
    mass = density * length
    peak = math.sqrt(2 / mass)
    force = tension * math.pi * order / length * peak / (2 * math.pi * frequency)  # at the bridge, per modal velocity
    lost = force**2 * body.conductance(frequency)
    at = path(np.pi * FINER * order[-1])
    waves, sign = _waves(at.size, order.size), peak * np.sin(np.pi * (_SIGN_AT * order))
    which = order.astype(int) - 1
    resistance = lost * body.radiated_share(frequency)
    if wires > 1 or body.single or best is None:
        shapes = peak * waves.take(which, axis=1)
        modes = heard(material, frequency, resistance, (shapes, sign), mass, lost)
        if wires > 1:
            modes = in_unison(modes, material.decay(frequency), lost, wires, mistuning, top)
        if body.single:
            modes = _with_single(modes, body, fundamental, top)
        count = modes.frequency.size
        modes = modes if best is None else best.of(modes)
    else:
        count, reach = order.size, peak * _peaks(at.size, order.size)[which]
        every = heard(material, frequency, resistance, (reach[None], sign), mass, lost)
        kept, sides = best.among(every.frequency, every.pressure, reach, every.decay)
        shapes = peak * waves.take(which[kept], axis=1)  # row by row, as it lies in memory
        modes = replace(selected(every, kept), strike=shapes, pressure=sides)
    higher = slice(order.size, _FURTHER * order.size)
    felt = _Sines(frequencies[higher], orders[higher], at.size, peak / math.sqrt(wires))
    glide = string_glide(material, length, diameter, tension) / wires
    return replace(modes, glide=glide, unheard=felt_of(felt, material.decay, count, top))


def _with_single(modes: Modes, board: Board, fundamental: float, top: float) -> Modes:
    """Return a string's modes with the board's single ones: each moves the bridge, and the string with it, as one end
    of a string that is driven there: sin(k (L - x))/sin(k L). The string's lowest is what notes are tuned by.

    Near a mode of the string both share what moves: 1/sin becomes sin/(sin^2 + m/M) for a string's mass m and a
    modal mass M.
    """
    single = [mode for mode in board.single if mode.frequency <= top]
    frequency, quality, modal = (np.array([getattr(mode, name) for mode in single]) for name in _RESONANCE)
    turn, x = np.pi * frequency / fundamental, np.linspace(0, 1, len(modes.strike))[:, None]
    moved = np.sin(turn * (1 - x)) * np.sin(turn) / (np.sin(turn) ** 2 + modes.mass / modal) / np.sqrt(modal)
    decay = np.pi * frequency / quality
    sound = pressure(2 * decay * board.radiated_share(frequency), np.ones(frequency.size))
    both = np.concatenate([modes.frequency, frequency])
    order = ascending(both)[:MOST_MODES]
    return replace(
        modes,
        fundamental=float(modes.frequency[0]),
        frequency=both[order],
        decay=np.concatenate([modes.decay, decay])[order],
        strike=np.concatenate([modes.strike, moved], axis=1)[:, order],
        pressure=np.concatenate([modes.pressure, sound], axis=1)[:, order],
    )


@dataclass(frozen=True)
class _Bent(Material):
    """A string's material, of which the bending loses more than the tension does.

    A mode n has B n^2/(1 + B n^2) of its stiffness by bending, and the complex modulus E (1 + i eta) makes that share
    of eta its loss factor (J. Woodhouse, Acta Acustica united with Acustica 90, 2004).
    """

    fundamental: float = 1.0
    inharmonicity: float = 0.0
    bending: float = 0.0

    def decay(self, frequency: npt.ArrayLike) -> Array:
        """Return the amplitude decay rates (1/s) of modes at `frequency` (Hz)."""
        f = np.asarray(frequency, dtype=np.float64)
        stiff = (np.sqrt(1 + 4 * self.inharmonicity * (f / self.fundamental) ** 2) - 1) / 2  # B n^2
        return super().decay(f) + np.pi * f * self.bending * stiff / (1 + stiff)


@dataclass(frozen=True, eq=False)
class _Sines:
    """Modes that are felt: frequency (k,) in Hz, and peak x sin(n pi x) of orders n (k,), at so many places."""

    frequency: Array
    order: Array
    places: int
    peak: float

    def shapes(self, which: Indices) -> Array:
        """Return the shapes of some modes, as `Felt.shapes`."""
        if not which.size:
            return np.empty((self.places, 0))
        order = self.order[which].astype(int) - 1
        return np.asarray(self.peak * _waves(self.places, int(order.max()) + 1).take(order, axis=1))

    def squares(self, which: Indices, u: Array, grid: Array) -> Array:
        """Return sums of squares as `Felt.squares`: by sin^2(n pi x) = (1 - cos(2 pi n x))/2, the sum of cosines by a
        Fourier transform."""
        shares = shares_of(u, grid)
        period = self.places - 1
        weights = np.zeros((period, shares.shape[1]))
        places = self.order[which].astype(int) % period
        for weight, share in zip(weights.T, shares.T, strict=True):
            weight[:] = np.bincount(places, u * share, period)
        cosines = np.fft.rfft(weights, axis=0).real  # of the first half: the other one mirrors it
        sums = np.maximum(0.5 * self.peak**2 * (cosines[0] - cosines), 0.0)
        return np.concatenate([sums, sums[(period - 1) // 2 :: -1]])


def _waves(places: int, least: int) -> Array:
    """Return sin(n pi x) at equally spaced places x in 0..1, of at least so many orders n from 1 on, (places, orders),
    read-only."""
    orders = math.ceil(least / _ORDERS) * _ORDERS
    found = _kept.get((places, orders))
    if found is None:
        found = np.sin(np.pi * np.outer(np.linspace(0, 1, places), np.arange(1.0, orders + 1)))
        read_only(found)
        _kept.put((places, orders), found)
    return found


@lru_cache(maxsize=64)  # 8 kB each at most
def _peaks(places: int, least: int) -> Array:
    """Return how far each of `_waves` goes at most."""
    return largest(_waves(places, least))


_kept: Kept[tuple[int, int], Array] = Kept(32_000_000, lambda waves: waves.nbytes)
