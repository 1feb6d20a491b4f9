"""Additions to the modes of a body's shape, as measured: single partials, bands of noise, a cavity (cavity.py).

Each is a dataclass of what a preset's section of the same name says, and becomes modes of the body. They are driven by
the contacts' forces as all modes are, wherever along the path it is struck, and hold the losses that they are given.

Levels are in dB against the loudest of the shape's own modes up to 20 kHz, at any sampling rate: that of the highest
rms along the path of its shape times its sound pressure. So much louder or softer a partial rings after an ideal blow,
infinitely short, at a point where that mode moves by its rms. A fit to a recording first divides the recording by the
spectrum of its blow's force.

The mass of added modes does not change the sound, only how far a contact feels them. Unless it is given, all modes of a
section together yield to a force as a rigid body of LOAD times the body's mass does: contacts don't feel that.
"""

import math
import zlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import Any, NamedTuple, Protocol

import numpy as np

from .air import IMPEDANCE
from .material import Array, Material
from .modes import MOST_MODES, Modes, columns, read_only

LOAD = 100.0

_WHOLE = 20_000.0  # Hz: up to which the shape's modes are that levels refer to

Values = float | tuple[float, ...]


class Lines(NamedTuple):
    """Modes to add: frequency (Hz), t60 (s), level (dB), each (n,), and modal masses (kg) (n,) or None.

    loudness (n,), in place of levels: sound pressure at 1 m after a blow of 1 N s (Pa); None: by the levels.
    """

    frequency: Array
    t60: Array
    level: Array
    modal_mass: Array | None
    loudness: Array | None = None


class Added(Protocol):
    """A source of modes to add to a body whose lowest mode, or that which is played, is at `lowest` (Hz)."""

    def lines(self, lowest: float) -> Lines: ...


@dataclass(frozen=True)
class Partials:
    """Partials that are given one by one.

    Parameters
    ----------
    t60 : float or tuple (n,)
        Decay times, s.
    level : float or tuple (n,)
        Levels against the shape's loudest mode, dB.
    frequency : tuple (n,)
        Frequencies, Hz. Give these or `ratio`.
    ratio : tuple (n,)
        Frequencies as multiples of the shape's lowest mode.
    modal_mass : float or tuple (n,), optional
        Modal mass of each, kg.

    Raises
    ------
    ValueError
        An argument does not fit; the text names it.
    """

    t60: Values
    level: Values
    frequency: tuple[float, ...] = ()
    ratio: tuple[float, ...] = ()
    modal_mass: Values | None = None

    def __post_init__(self) -> None:
        self.lines(1.0)

    def lines(self, lowest: float) -> Lines:
        frequency = _either(lowest, frequency=self.frequency, ratio=self.ratio)
        masses = {} if self.modal_mass is None else {"modal_mass": self.modal_mass}
        t60, level, *mass = columns(frequency.size, "frequencies", t60=self.t60, level=self.level, **masses)
        return Lines(frequency, t60, level, mass[0] if mass else None)


@dataclass(frozen=True)
class Noise:
    """Bands in which modes are too dense to be told apart.

    Parameters
    ----------
    t60 : float or tuple (n,)
        Decay times, s.
    level : float or tuple (n,)
        Level of all modes of a band together, against the shape's loudest mode, dB.
    edges : tuple (n + 1,)
        Edges of the bands, Hz. Give these or `edge_ratio`.
    edge_ratio : tuple (n + 1,)
        Edges as multiples of the shape's lowest frequency.
    modes : float or tuple (n,), default 24
        Number of modes in a band.
    modal_mass : float or tuple (n,), optional
        Modal mass of each, kg.

    Raises
    ------
    ValueError
        An argument does not fit; the text names it.

    Notes
    -----
    The modes of a band are equally loud, and lie at pseudo-random places in as many equal parts. The edges alone decide
    which.
    """

    t60: Values
    level: Values
    edges: tuple[float, ...] = ()
    edge_ratio: tuple[float, ...] = ()
    modes: float | tuple[float, ...] = 24
    modal_mass: Values | None = None

    def __post_init__(self) -> None:
        edges = self.edges or self.edge_ratio
        if len(edges) == 1 or any(high <= low for low, high in pairwise(edges)):
            raise ValueError(f"edges = {list(edges)}: expected two or more, in ascending order")
        self.lines(1.0)

    def lines(self, lowest: float) -> Lines:
        edges = _either(lowest, edges=self.edges, edge_ratio=self.edge_ratio)
        masses = {} if self.modal_mass is None else {"modal_mass": self.modal_mass}
        t60, level, count, *mass = columns(
            edges.size - 1, "bands", t60=self.t60, level=self.level, modes=self.modes, **masses
        )
        counts = count.astype(int)
        written = self.edges or self.edge_ratio
        frequency = [
            low + (high - low) / number * (np.arange(number) + _random(written[band], number))
            for band, ((low, high), number) in enumerate(zip(pairwise(edges), counts, strict=True))
        ]
        level = level - 10 * np.log10(counts)
        return Lines(
            np.concatenate(frequency),
            np.repeat(t60, counts),
            np.repeat(level, counts),
            np.repeat(mass[0], counts) if mass else None,
        )


@dataclass(frozen=True)
class Complete:
    """A shape's function that makes modes, with modes that are added to its own.

    written: the material that their decay times are meant with. In a body of another one, what they lose inside goes as
    the materials' decay rates do.
    """

    make: Callable[..., Modes]
    added: tuple[Added, ...]
    written: Material | None

    def __call__(self, *, top: float, **arguments: Any) -> Modes:
        """Return the modes up to `top` (Hz); where there would be more than MOST_MODES, without the shape's highest."""
        own = self.make(top=top, **arguments)
        loudest = _loudest(own if top >= _WHOLE else self.make(top=_WHOLE, **arguments))
        parts = [_modes(each.lines(own.pitch), loudest, own.mass, top) for each in self.added]
        most, added = max(MOST_MODES, own.frequency.size), sum(part.frequency.size for part in parts)
        room = most - added
        if room < 1:
            raise ValueError(f"{added} modes are added: expected fewer than {most}")
        material = arguments.get("material")
        frequency = np.concatenate([own.frequency[:room], *(part.frequency for part in parts)])
        decay = np.concatenate([part.decay for part in parts])
        if material is not None and self.written is not None and material != self.written:
            decay = _decays(decay, frequency[own.frequency[:room].size :], self.written, material)
        order = np.argsort(frequency, kind="stable")
        strikes = [own.strike[:, :room], *(np.repeat(part.strike, len(own.strike), axis=0) for part in parts)]
        place = np.full(own.frequency.size, -1)
        place[:room] = np.argsort(order)[: own.frequency[:room].size]
        return replace(
            own,
            sheet=own.sheet and own.sheet.moved(place),
            frequency=frequency[order],
            decay=np.concatenate([own.decay[:room], decay])[order],
            strike=np.concatenate(strikes, axis=1)[:, order],
            pressure=np.concatenate([own.pressure[:, :room], *(part.pressure for part in parts)], axis=1)[:, order],
        )


def _loudest(own: Modes) -> float:
    """Return the loudness (Pa per N s) of the loudest of a shape's own modes."""
    return float(np.sqrt(np.mean(own.strike**2, axis=0) * np.mean(own.pressure**2, axis=0)).max())


def _modes(lines: Lines, loudest: float, mass: float, top: float) -> Modes:
    """Return the lines as modes up to `top` (Hz), their weights of pseudo-random signs."""
    masses = np.full(lines.frequency.shape, LOAD * lines.frequency.size * mass)
    masses = masses if lines.modal_mass is None else lines.modal_mass
    loudness = loudest * 10 ** (lines.level / 20) if lines.loudness is None else lines.loudness  # Pa per N s
    # A mode of mass M radiates 4 pi loudness^2 M/(rho c) (1/s), and no more than it loses.
    with np.errstate(divide="ignore"):  # of what is silent
        masses = np.minimum(masses, IMPEDANCE * math.log(1000) / lines.t60 / (2 * math.pi * loudness**2))
    shape = 1 / np.sqrt(masses)
    sign = np.where(_random(len(masses), len(masses)) < 0.5, -1.0, 1.0)
    weight = sign * loudness / shape
    keep = lines.frequency <= top
    return Modes(
        frequency=lines.frequency[keep],
        decay=math.log(1000) / lines.t60[keep],
        strike=shape[None, keep],
        pressure=np.repeat(weight[None, keep], 2, axis=0),
        mass=mass,
    )


def _decays(decay: Array, frequency: Array, written: Material, material: Material) -> Array:
    """Return the decay rates (1/s) of modes that were given for a body of another material; what exceeds its loss
    stays."""
    inside, other = written.decay(frequency), material.decay(frequency)
    changed: Array = np.maximum(decay - inside, 0) + other * decay / np.maximum(decay, inside)
    return changed


def _either(lowest: float, **given: tuple[float, ...]) -> Array:
    """Return the frequencies (Hz) from those that are given in Hz or as multiples of the lowest."""
    (absolute, frequency), (relative, ratio) = given.items()
    if bool(frequency) == bool(ratio):
        raise ValueError(f"{absolute} and {relative}: expected one of the two")
    return np.array(frequency or [lowest * each for each in ratio])


@lru_cache(maxsize=1024)  # 100 bytes each, most often
def _random(seed: float, count: int) -> Array:
    """Return numbers (count,) in 0..1, always the same for the same seed; read-only."""
    numbers: Array = np.random.PCG64(zlib.crc32(repr(float(seed)).encode())).random_raw(count) / 2.0**64
    read_only(numbers)
    return numbers
