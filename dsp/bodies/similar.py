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
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from .bar import bar, bar_clicks, over_tube, tube_of
from .disc import disc, disc_clicks
from .felts import on_stand
from .heard import Best, pressure
from .material import Array, Indices, Material
from .modes import Modes, Silent, Unheard, audible
from .plate import plate, plate_clicks
from .radiation.board import BOARDS, Board
from .radiation.lattice import cubic_weights
from .ring import glass, glass_clicks, ring, ring_clicks
from .similar_table import Beyond, Store, Table, table_of
from .sphere import sphere, sphere_clicks
from .unheard import felt_of

_CLICKS: Mapping[Callable[..., Modes], Callable[..., Any]] = {
    bar: bar_clicks, plate: plate_clicks, disc: disc_clicks, ring: ring_clicks, glass: glass_clicks,
    sphere: sphere_clicks,
}  # fmt: skip
"""Shapes that are elastic bodies in air and no more, with what makes their clicks."""

_UNDER = ("tube_diameter", "tube_length", "tube_gap", "tube_detuning", "tube_flow", "fan", "fan_depth")
"""Arguments of a bar that say what stands under it, and changes its modes."""

_ASIDE = ("felt", "stand", "board", "cords", *_UNDER)
"""Arguments of discs and bars that say what takes from them or sounds besides, and does not change their shapes."""

_FLAT = {"across": 0.0, "tilt": 0.0}
"""Arguments of a bar that is struck flat on its middle line."""

_RUNGS = 2  # highest frequencies of tables in an octave


def has_similar(make: Callable[..., Modes], arguments: Mapping[str, Any]) -> bool:
    """True if the bodies that a shape's function makes of such arguments are similar in all sizes."""
    return make in _CLICKS and not arguments.get("nonlinear_modes")


@dataclass(frozen=True)
class Sized:
    """A shape's function that makes modes, in a size: `lengths` of its arguments are those of the body of size 1.

    store: of its tables.
    """

    make: Callable[..., Modes]
    size: float
    lengths: tuple[str, ...]
    store: Store | None = None

    def __call__(self, *, top: float, material: Material, best: Best | None = None, **arguments: Any) -> Modes:
        """Return the modes up to `top` (Hz) of the body in its size; best: those that are kept. Silent if there is
        none."""
        size, own = self.size, {key: value for key, value in arguments.items() if key not in _ASIDE}
        table = self._table(top, material, own)
        modes = table.modes
        frequency = modes.frequency / size
        heard = audible(frequency, top)
        found, resistance = frequency[heard], 2 * modes.decay[heard] / size
        radiated, lost = resistance, resistance
        if board := arguments.get("board"):
            into = self._into(BOARDS[str(board)], top, material, {**own, "board": board}, heard)
            radiated, lost = resistance + BOARDS[str(board)].radiated_share(found) * into, resistance + into
        material = on_stand(material, arguments.get("stand", 0.0), modes.mass * size**3)
        decay = material.decay(found)
        if material.losses == "material":
            decay = decay + lost / 2
        if felt := arguments.get("felt"):
            held = self._table(top, material, {**own, "felt": felt}).modes
            decay = decay + (held.decay - modes.decay)[heard] / size**2
        if cords := arguments.get("cords"):
            held = self._table(top, material, {**own, "cords": 1.0}).modes
            decay = decay + cords * (held.decay - modes.decay)[heard] / size**3
        sized = {key: value * size if key in self.lengths else value for key, value in arguments.items()}
        sides = pressure(np.minimum(radiated, 2 * decay), modes.pressure[0, heard])
        kept, has_tube = heard, "tube_diameter" in arguments
        if best and not has_tube:
            keep, sides = best.among(found, sides, table.largest[heard] * size**-1.5, decay)
            kept, found, decay = heard[keep], found[keep], decay[keep]
        made = Modes(
            found, decay, table.shapes[kept].T * size**-1.5, sides, modes.mass * size**3,
            _CLICKS[self.make](material, **sized), unheard=self._felt(table, heard, material, top),
        )  # fmt: skip
        if not has_tube:
            return made
        made = self._over_tube(made, np.flatnonzero(self._upright(top, material, own)[heard]), sized, top)
        return best.of(made) if best else made

    def _over_tube(self, made: Modes, upright: Indices, sized: Mapping[str, Any], top: float) -> Modes:
        """Return a bar with its tube; upright: the modes that move it up and down."""
        tube = tube_of(**{key: sized[key] for key in _UNDER if key in sized})
        sides = sized["length"], sized["width"], sized["thickness"] * (1 - sized.get("undercut", 0.0))
        return over_tube(made, upright, partial(_along, made.strike), tube, sides, top)

    def _upright(self, top: float, material: Material, own: Mapping[str, Any]) -> npt.NDArray[np.bool_]:
        """Return which of a bar's modes move it up and down: those alone that a flat blow on its middle line moves."""
        modes, flat = (self._table(top, material, {**own, **more}).modes for more in ({}, _FLAT))
        return np.isin(modes.frequency, flat.frequency[flat.strike.any(axis=0)])

    def _into(self, board: Board, top: float, material: Material, boarded: Mapping[str, Any], heard: Indices) -> Array:
        """Return what a bar's modes lose (1/s) to the board that it is clamped in.

        Over the board's conductance it goes with omega^2 and the mass that they move, so with the size; that of the bar
        of size 1 is what a table with the board has more.
        """
        own = {key: value for key, value in boarded.items() if key != "board"}
        upright = self._upright(top, material, own)
        modes, more = (self._table(top, material, each).modes for each in (own, boarded))
        lost = 2 * (more.decay - modes.decay) / _met(board, modes.frequency, upright)
        return np.asarray(lost[heard] * self.size * _met(board, modes.frequency[heard] / self.size, upright[heard]))

    def _table(self, top: float, material: Material, arguments: Mapping[str, Any]) -> Table:
        """Return the table of the body of size 1 that reaches up to `top` (Hz) in this one's. Silent if it is empty."""
        rung = 2.0 ** (math.ceil(_RUNGS * math.log2(top * self.size)) / _RUNGS)
        table = table_of(self.make, rung, material, arguments, self.store)
        if table is None:
            raise Silent(top)
        return table

    def _felt(self, table: Table, heard: Indices, material: Material, top: float) -> Unheard | None:
        """Return what is felt alone: the modes of a table after those that are heard, and those that it has so."""
        own = table.modes.unheard
        if own is None:
            return None
        first = int(heard[-1]) + 1
        if first < table.modes.frequency.size:
            return felt_of(Beyond(table, first, self.size), material.decay, heard.size, top)
        frequency = own.frequency / self.size
        decay = np.maximum(material.decay(frequency), own.decay / self.size)
        return Unheard(frequency, decay, own.strike * self.size**-1.5)


def _met(board: Board, frequency: Array, upright: npt.NDArray[np.bool_]) -> Array:
    """Return the conductance (s/kg) that modes of a bar meet in a board; upright: those that move the bar up and
    down."""
    if not board.block:
        return board.conductance(frequency)
    return np.where(upright, board.conductance(frequency), board.conductance_aside(frequency))


def _along(strike: Array, positions: Array) -> Array:
    """Return shapes at positions (p,) in 0..1, by cubics through four rows around each."""
    place = positions * (len(strike) - 1)
    first = np.clip(place.astype(int) - 1, 0, len(strike) - 4)
    rows = np.stack([strike[first + i] for i in range(4)])
    return np.asarray(np.einsum("ip,ipn->pn", cubic_weights(place - first), rows))
