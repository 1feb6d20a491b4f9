"""Bodies of one shape in all sizes: similar ones have one table of modes.

Where all lengths of an elastic body of one material go with a size s, its frequencies go with 1/s, its shapes stay, and
its mass goes with s^3. So does the air about it: sound's waves and the body's have one ratio, the air's mass is one
share of the body's, and resistances (1/s) go with 1/s (A. D. Pierce, Acoustics, 1989, 1-6; L. Cremer, M. Heckl,
B. Petersson, Structure-Borne Sound, 2005, for plates and bars). Mass-normalised shapes go with s^-3/2, and pressures
with s^-1/2. What goes otherwise is found anew for each size: the losses of the material, what felts take, which
goes with s^-2 (felts.py), what cords take, which goes with s^-3, the clicks, whose band ends where hearing does, and
which modes are heard, and which are felt alone.

A table holds the modes of the body of size 1 without losses, up to a frequency that is one of few, so that many sizes
share it. What is felt alone beyond a table is gathered twice, which keeps how far it yields (unheard.py).
"""

import math
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ..kept import Kept
from .bar import bar, bar_clicks, over_tube, tube_of
from .disc import disc, disc_clicks
from .felts import on_stand
from .heard import pressure
from .material import Array, Material
from .modes import Modes, Silent, Unheard, audible
from .plate import plate, plate_clicks
from .radiation.board import BOARDS
from .radiation.lattice import cubic_weights
from .ring import glass, glass_clicks, ring, ring_clicks
from .sphere import sphere, sphere_clicks
from .unheard import Felt, with_unheard

_CLICKS: Mapping[Callable[..., Modes], Callable[..., Any]] = {
    bar: bar_clicks, plate: plate_clicks, disc: disc_clicks, ring: ring_clicks, glass: glass_clicks,
    sphere: sphere_clicks,
}  # fmt: skip
"""Shapes that are elastic bodies in air and no more, with what makes their clicks."""

_UNDER = ("tube_diameter", "tube_length", "tube_gap", "tube_detuning", "tube_flow", "fan", "fan_depth")
"""Arguments of a bar that say what stands under it, and changes its modes."""

_ASIDE = ("felt", "stand", "board", "cords", *_UNDER)
"""Arguments of discs and bars that say what takes from them or sounds besides, and does not change their shapes."""

_RUNGS = 2  # highest frequencies of tables in an octave
_KEPT_BYTES = 128_000_000


def has_similar(make: Callable[..., Modes], arguments: Mapping[str, Any]) -> bool:
    """True if the bodies that a shape's function makes of such arguments are similar in all sizes."""
    return make in _CLICKS and not arguments.get("nonlinear_modes")


@dataclass(frozen=True)
class Sized:
    """A shape's function that makes modes, in a size: `lengths` of its arguments are those of the body of size 1."""

    make: Callable[..., Modes]
    size: float
    lengths: tuple[str, ...]

    def __call__(self, *, top: float, material: Material, **arguments: Any) -> Modes:
        """Return the modes up to `top` (Hz) of the body in its size. Silent if there is none."""
        size, own = self.size, {key: value for key, value in arguments.items() if key not in _ASIDE}
        table = self._table(top, material, own)
        frequency = table.frequency / size
        heard = audible(frequency, top)
        rest = np.delete(np.arange(frequency.size), heard)
        strike = table.strike * size**-1.5
        found, resistance = frequency[heard], 2 * table.decay[heard] / size
        radiated, lost = resistance, resistance
        if board := arguments.get("board"):
            into = self._into(str(board), top, material, own, table)[heard] * BOARDS[str(board)].conductance(found)
            radiated, lost = resistance + BOARDS[str(board)].radiated_share(found) * into, resistance + into
        material = on_stand(material, arguments.get("stand", 0.0), table.mass * size**3)
        decay = material.decay(found)
        if material.losses == "material":
            decay = decay + lost / 2
        if felt := arguments.get("felt"):
            held = self._table(top, material, {**own, "felt": felt})
            decay = decay + (held.decay - table.decay)[heard] / size**2
        if cords := arguments.get("cords"):
            held = self._table(top, material, {**own, "cords": 1.0})
            decay = decay + cords * (held.decay - table.decay)[heard] / size**3
        sized = {key: value * size if key in self.lengths else value for key, value in arguments.items()}
        made = Modes(
            found, decay, strike[:, heard], pressure(np.minimum(radiated, 2 * decay), table.pressure[0, heard]),
            table.mass * size**3, _CLICKS[self.make](material, **sized),
        )  # fmt: skip
        made = self._felt(made, table, Felt(frequency[rest], strike[:, rest]), material, top)
        if "tube_diameter" not in arguments:
            return made
        # Of the same bar, struck flat on its middle line, a blow moves those modes alone that move it up and down.
        flat = self._table(top, material, {**own, "across": 0.0, "tilt": 0.0})
        upright = np.flatnonzero(np.isin(table.frequency[heard], flat.frequency[flat.strike.any(axis=0)]))
        tube = tube_of(**{key: sized[key] for key in _UNDER if key in sized})
        sides = sized["length"], sized["width"], sized["thickness"] * (1 - sized.get("undercut", 0.0))
        return over_tube(made, upright, partial(_along, made.strike), tube, sides, top)

    def _into(self, board: str, top: float, material: Material, own: Mapping[str, Any], table: Modes) -> Array:
        """Return what a bar's modes lose to the board that it is clamped in, over the board's conductance.

        It goes with omega^2 and the mass that they move, so with the size; that of the bar of size 1 is what a table
        with the board has more.
        """
        boarded = self._table(top, material, {**own, "board": board})
        more: Array = 2 * (boarded.decay - table.decay) / BOARDS[board].conductance(table.frequency)
        return more * self.size

    def _table(self, top: float, material: Material, arguments: Mapping[str, Any]) -> Modes:
        """Return the table of the body of size 1 that reaches up to `top` (Hz) in this one's. Silent if it is empty."""
        table = _table(self.make, 2.0 ** (math.ceil(_RUNGS * math.log2(top * self.size)) / _RUNGS), material, arguments)
        if table is None:
            raise Silent(top)
        return table

    def _felt(self, modes: Modes, table: Modes, others: Felt, material: Material, top: float) -> Modes:
        """Return the modes that are heard with those that are felt alone: others of a table, and those it has so."""
        own = table.unheard
        if own is None:
            return modes
        frequency, strike = own.frequency / self.size, own.strike * self.size**-1.5
        if others.frequency.size:
            together = np.append(others.frequency, frequency), np.concatenate([others.strike, strike], axis=1)
            return with_unheard(modes, Felt(*together), material.decay, top)
        decay = np.maximum(material.decay(frequency), own.decay / self.size)
        return replace(modes, unheard=Unheard(frequency, decay, strike))


def _along(strike: Array, positions: Array) -> Array:
    """Return shapes at positions (p,) in 0..1, by cubics through four rows around each."""
    place = positions * (len(strike) - 1)
    first = np.clip(place.astype(int) - 1, 0, len(strike) - 4)
    rows = np.stack([strike[first + i] for i in range(4)])
    return np.asarray(np.einsum("ip,ipn->pn", cubic_weights(place - first), rows))


def _table(make: Callable[..., Modes], top: float, material: Material, arguments: Mapping[str, Any]) -> Modes | None:
    """Return the modes of a body of size 1 without losses, whose decay is half of its resistance; None if it has none
    up to `top` (Hz)."""
    lossless = replace(material, alpha=0.0, beta=0.0, loss_factor=0.0, losses="material")
    key = (make, top, lossless, *sorted(arguments.items()))
    found = _tables.get(key)
    if found is None:
        try:
            found = (make(material=lossless, top=top, **arguments),)
        except Silent:
            found = ()
        _tables.put(key, found)
    return found[0] if found else None


def _bytes(table: tuple[Modes, ...]) -> int:
    return sum(each.strike.nbytes + (each.unheard.strike.nbytes if each.unheard else 0) for each in table)


_tables: Kept[Hashable, tuple[Modes, ...]] = Kept(_KEPT_BYTES, _bytes)
