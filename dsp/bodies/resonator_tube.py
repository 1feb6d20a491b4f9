"""Resonator tubes: columns of air, closed below, under the bars of a marimba or a vibraphone.

A bar that is short beside the sound's wave hardly radiates: the air flows round its edges. Its flow moves the air in
the mouth of a tube below, which radiates to all sides. With X the volume (m^3) that leaves the mouth, and q_i the bar's
modes,

    q_i'' + 2 sigma_i q_i' + omega_i^2 q_i + B_i X'' = phi_i F
    M (X'' + 2 sigma X' + omega^2 X) + sum_i B_i q_i'' = 0

for each resonance of the tube, where its length is an odd number of quarter waves; M = rho L/(2 S) for a length L and
an opening S. B_i is the pressure in the mouth for a unit of q_i'', and by reciprocity the force of X'' on the bar: that
of the potential flow round it, and that of the flow which the mouth stops: as much as stands in front of it, its end
correction times rho and the flow's velocity into it. That is within 10 % of the flow between a flat strip and a closed
mouth, from gaps of half the mouth's radius on (a test solves it). A bar as thick as a xylophone's moves more air than a
strip. Its section counts as the ellipse that moves as much along with it, and displaces as much, a by b: the flow is
the real part of rho a (a + b)/(i (p + sqrt(p^2 - a^2 + b^2))) at p = y + i z from its middle, within 10 % of that round
a rectangle (another test). The air in the tube loses by viscosity and conduction at the wall (G. Kirchhoff
1868), and by what the open end radiates (H. Levine and J. Schwinger 1948; N. Fletcher and T. Rossing, The Physics of
Musical Instruments, ch. 8). Air that moves farther than the edge of the mouth is round sheds vortices there at each
turn. At an amplitude u (m/s), an opening of radius a, a sharp edge resists by 0.6 (omega a/u)^(1/3) u/c of rho c/S
(an estimate, after J. Disselhorst and L. van Wijngaarden, J. Fluid Mech. 99, 1980). Loud blows lose more by that: modes
take what they lose at one amplitude, `flow`.

That resistance goes with |u|^(2/3), so its pressure goes with |u|^(2/3) u, and holds odd multiples of a sound's
frequency. The tube, closed below, is in tune with them and radiates them: ten recorded marimba and vibraphone bars have
a partial at 3.00 times the lowest, 20 to 42 dB under it, where the bar itself has none. They are modes here: as loud,
beside the lowest, as they are at the amplitude `flow`, and falling 5/3 times as fast. A blow excites them as it does
all modes, so a soft mallet makes them fainter than they are: yarn the third of a C4 by some 8 dB.

The coupled system is solved exactly. Its modes are complex; a body's are real, so each keeps the size of what it
radiates, and its phase becomes 0 or 180 degrees: that of a tube which is in tune.
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .air import DENSITY, IMPEDANCE, SPEED
from .material import Array
from .modes import MOST_MODES, Indices, Modes, ascending, require_positive, selected
from .radiation import line

GAP = 0.012
"""m, between the middle of the bar and the mouth, by default."""
_END = 0.6133  # of the radius: the air outside that moves along with an open end (Levine and Schwinger)
_VISCOSITY, _RATIO, _PRANDTL = 1.51e-5, 1.4, 0.71  # of air at 20 degrees: kinematic (m^2/s), of heats, Prandtl's number
_RADII = (np.arange(6) + 0.5) / 6  # of rings that share the mouth, as fractions of its radius
_ANGLES = np.linspace(0, 2 * math.pi, 16, endpoint=False)
_MOST_RESONANCES = 300  # of a tube: the coupled equations take a second then
_OVERDAMPED = 0.5  # by how much losses lower what is no resonance any more
_MOST_TAKEN = 0.3  # of what is felt of a bar's mode: what belongs to the tube's
_SHED = 0.6  # of the resistance of vortices at a sharp edge
_SHED_POWER = 5 / 3  # of the amplitude: as their pressure goes
_ODD = ((3, 1 / 7), (5, 1 / 35))
"""Multiples of the frequency that |cos|^(2/3) cos holds, over the first: from m to m + 2 by (5/3 - m)/(5/3 + m + 2)."""
_MOVES = 0.05  # share of a bar's mode from which on it counts as moving
_NEAR = 0.5  # octave about the lowest resonance: what moves the mouth's air enough for vortices
_SILENT = 1e-3  # of the tube's loudest: fainter modes of it are left out

Complex = npt.NDArray[np.complex128]


@dataclass(frozen=True)
class Tube:
    """A tube under the middle of a bar: its inner diameter (m), its length (m; None: in tune with the bar's lowest
    mode, but for `detuning`) and its distance (m).

    detuning: by what fraction of the frequency a tube without a given length is too high. A room that is warmer than
    the one where it was tuned does so, by 0.0017 a kelvin, and half of its resonance's width is 0.006 to 0.01.

    flow: the amplitude (m/s) of the air's velocity in its mouth at which it loses by vortices. Such a sound that falls
    evenly from an amplitude u loses in all as much as it does at 0.65 u, as losses go with its power 2/3.

    fan: turns of the vibraphone's disc in its mouth, per second, each of which closes it twice, by fan_depth (0..1) of
    its sound; it stands open at each blow. ValueError names what is out of range.
    """

    diameter: float
    length: float | None = None
    gap: float = GAP
    fan: float = 0.0
    fan_depth: float = 0.0
    detuning: float = 0.0
    flow: float = 0.0

    def __post_init__(self) -> None:
        require_positive(tube_diameter=self.diameter, tube_length=self.length, tube_gap=self.gap)
        if not 0 <= self.fan < math.inf or not 0 <= self.fan_depth <= 1:
            raise ValueError(
                f"fan = {self.fan}, fan_depth = {self.fan_depth}: expected a number from 0 on, and one in [0, 1]"
            )
        if not 0 <= self.flow < math.inf:
            raise ValueError(f"tube_flow = {self.flow}: expected a number from 0 on")
        if not abs(self.detuning) < 0.5:
            raise ValueError(f"tube_detuning = {self.detuning}: expected a number in (-0.5, 0.5)")

    @property
    def end(self) -> float:
        """The length (m) of the air outside that moves along with its open end."""
        return _END * self.diameter / 2

    @property
    def mouth(self) -> tuple[Array, Array]:
        """Points of the mouth that share it equally, along and across the bar (m), from its middle."""
        weighted = np.sqrt(_RADII) * self.diameter / 2
        return np.outer(weighted, np.cos(_ANGLES)).ravel(), np.outer(weighted, np.sin(_ANGLES)).ravel()

    def tuned(self, frequency: float) -> "Tube":
        """Return the tube of a length that puts its lowest resonance at a frequency (Hz), or off it by its detuning, if
        it has no length yet."""
        if self.length is not None:
            return self
        frequency *= 1 + self.detuning
        slower = 1 - wall_loss(self.diameter / 2, np.array([frequency]))[0] * SPEED / (2 * math.pi * frequency)
        length = SPEED * slower / (4 * frequency) - self.end
        if length <= 0:
            raise ValueError(f"tube_diameter = {self.diameter}: too wide to be in tune with {frequency:g} Hz")
        return replace(self, length=length, detuning=0.0)

    def resonances(self, top: float) -> "Column":
        """Return the resonances of the air in it up to `top` (Hz)."""
        assert self.length is not None
        length = self.length + self.end
        quarters = np.arange(1.0, max(4 * length * top / SPEED, 0.0), 2.0)
        frequency = quarters * SPEED / (4 * length)
        slowed = wall_loss(self.diameter / 2, frequency) * SPEED / (2 * math.pi * frequency)
        frequency = (frequency * (1 - slowed))[slowed < _OVERDAMPED]
        lost = wall_loss(self.diameter / 2, frequency)
        mass = DENSITY * length / (2 * math.pi * (self.diameter / 2) ** 2)
        radiated = DENSITY * (2 * math.pi * frequency) ** 2 / (4 * math.pi * SPEED)
        return Column(frequency, SPEED * (lost + self._shed(length) / length) + radiated / (2 * mass), mass)

    def _shed(self, length: float) -> float:
        """Return the resistance of the mouth's edge, over that of the air, as its lowest resonance moves; length (m):
        with its end."""
        if self.flow == 0:
            return 0.0
        around = math.pi * SPEED / (2 * length) * self.diameter / 2
        return _SHED * math.pow(around / self.flow, 1 / 3) * self.flow / SPEED

    def overtones(self, frequency: Array, column: "Column", top: float) -> list[tuple[int, Array]]:
        """Return the multiples up to `top` (Hz) that vortices add to its sound at frequencies (Hz), if these are near
        its lowest resonance, and how loud each is over that: 0 for what is not there."""
        assert self.length is not None
        pressure = DENSITY * SPEED * self._shed(self.length + self.end)  # Pa for 1 m/s
        near = np.abs(np.log2(frequency / column.frequency[0])) < _NEAR
        found = []
        for order, share in _ODD:
            heard = near & (order * frequency < top)
            flow = column.admittance(order * frequency) / (math.pi * (self.diameter / 2) ** 2)
            found.append((order, np.where(heard, order * share * pressure * flow, 0.0)))
        return found


class Column(NamedTuple):
    """Resonances of a tube: frequencies (Hz) and decay rates (1/s) (m,), and the modal mass of each (kg/m^4)."""

    frequency: Array
    decay: Array
    mass: float

    def admittance(self, frequency: Array) -> Array:
        """Return the size of the flow (m^3/s) out of the mouth for a pressure of 1 Pa in it, at frequencies (Hz)."""
        omega, own = 2 * math.pi * frequency[:, None], 2 * math.pi * self.frequency
        each = 1j * omega / (self.mass * (own**2 - omega**2 + 2j * self.decay * omega))
        flow: Array = np.abs(each.sum(axis=1))
        return flow


def wall_loss(radius: float, frequency: Array) -> Array:
    """Return how sound of frequencies (Hz) falls in a tube of a radius (m), 1/m: by viscosity and conduction at the
    wall."""
    layer = np.sqrt(np.pi * frequency * _VISCOSITY)
    loss: Array = layer * (1 + (_RATIO - 1) / math.sqrt(_PRANDTL)) / (radius * SPEED)
    return loss


def bar_flow(sides: tuple[float, float], across: Array, below: float, stopped: float = 0.0) -> Array:
    """Return the potential (m) of the flow round a bar that moves with unit speed across itself.

    sides: its width and its thickness (m). At points `across` (m) from its middle line, at a distance (m) from its
    lower face; stopped (m): how much of the air in front of a mouth there stands, which adds by the velocity into it.
    """
    width, thickness = sides
    moved = line.added_of(thickness / width) * (width / 2) ** 2
    long = math.sqrt(moved)
    dipole = moved + width * thickness / math.pi  # long (long + short), of the ellipse
    focus = np.sqrt(moved - (dipole / long - long) ** 2 + 0j)
    point = across + 1j * (below + thickness / 2)
    around = np.sqrt(point - focus) * np.sqrt(point + focus)
    turned = dipole / (point + around)
    flow: Array = -turned.imag - stopped * (turned / around).real
    return flow


class Coupled(NamedTuple):
    """Modes of bar and tube: s (k,) in 1/s, of positive imaginary parts.

    After a blow of 1 N s where one of the bar's modes has a shape of 1, that mode moves with the sum over k of
    Re(share exp(s t)), and the tube is heard at 1 m with that of Re(sound exp(s t)) (Pa); share and sound (n, k).
    """

    s: Complex
    share: Complex
    sound: Complex


def coupled(frequency: Array, decay: Array, coupling: Array, column: Column) -> Coupled:
    """Return the modes of a bar (n,) with a tube; coupling (n,): B of each, Pa s^2/(sqrt(kg) m)."""
    n, m = frequency.size, column.frequency.size
    mass = np.eye(n + m)
    mass[n:, n:] *= column.mass
    mass[:n, n:] = coupling[:, None]
    mass[n:, :n] = coupling
    weight = np.concatenate([np.ones(n), np.full(m, column.mass)])
    omega = 2 * np.pi * np.concatenate([frequency, column.frequency])
    loss = weight * 2 * np.concatenate([decay, column.decay])
    inverse = np.linalg.inv(mass)
    # x = (positions, velocities), x' = A x; a unit blow on mode i begins with the velocities inverse[:, i].
    a = np.block([[np.zeros((n + m, n + m)), np.eye(n + m)], [-inverse * (weight * omega**2), -inverse * loss]])
    s, right = np.linalg.eig(a)
    begins = np.linalg.solve(right, np.concatenate([np.zeros((n + m, n)), inverse[:, :n]]))
    up = s.imag > 0
    s, right, begins = s[up], right[:, up], begins[up]
    velocity = right[n + m :]
    share = 2 * velocity[:n] * begins.T
    sound = 2 * DENSITY / (4 * math.pi) * (s * velocity[n:].sum(axis=0))[None] * begins.T
    return Coupled(s, share, sound)


def with_tube(modes: Modes, bends: Indices, flow: Array, tube: Tube, top: float) -> Modes:
    """Return a bar's modes with a tube under its middle.

    bends (n,): indices of its modes that move it up and down. flow (n,): the mean over the mouth of such a mode's shape
    times the potential of the flow round the bar (m kg^-1/2). top in Hz. Only what is so slow that the mouth is small
    beside the sound's wave (k a < 1) is coupled. ValueError: the tube has too many resonances there.
    """
    slow = min(top, SPEED / (math.pi * tube.diameter))
    column = tube.resonances(slow)
    if column.frequency.size > _MOST_RESONANCES:
        longest = _MOST_RESONANCES * SPEED / (2 * slow)
        raise ValueError(
            f"tube_length = {tube.length:g}, tube_diameter = {tube.diameter:g}: {column.frequency.size} resonances up "
            f"to {slow:.0f} Hz; expected at most {_MOST_RESONANCES}, as in {longest:.2g} m"
        )
    coupled_modes = modes.frequency[bends] < slow
    bends, flow = bends[coupled_modes], flow[coupled_modes]
    if not column.frequency.size or not bends.size:
        return modes
    found = coupled(modes.frequency[bends], modes.decay[bends], DENSITY * flow, column)
    rest = np.setdiff1d(np.arange(modes.frequency.size), bends)
    parts = [Part(modes.frequency[rest], modes.decay[rest], modes.strike[:, rest], modes.pressure[0, rest])]
    overtones = tube.overtones(np.abs(found.s) / (2 * math.pi), column, slow) if tube.flow else []
    parts += _parts(selected(modes, bends), found, tube, overtones)
    frequency, decay, strike, pressure = (np.concatenate(arrays, axis=-1) for arrays in zip(*parts, strict=True))
    order = ascending(frequency)
    order = order[frequency[order] <= top][:MOST_MODES]
    return replace(
        modes,
        frequency=frequency[order],
        decay=decay[order],
        strike=strike[:, order],
        pressure=np.tile(pressure[order], (2, 1)),
    )


class Part(NamedTuple):
    """Modes, as in `Modes`: frequency and decay (k,), strike (P, k), and the pressure of either side (k,)."""

    frequency: Array
    decay: Array
    strike: Array
    pressure: Array


def _parts(bar: Modes, found: Coupled, tube: Tube, overtones: list[tuple[int, Array]]) -> list[Part]:
    """Return the modes of a bar with its tube, as real ones: where the bar moves, where the tube alone does, what its
    fan adds, and what its vortices do, their multiples and how loud these are.

    Together they are felt as the bar's own are. Those where the tube alone moves are felt as little as can be: their
    sound is all that they lose.
    """
    each = np.arange(found.s.size)
    own = np.argmax(np.abs(found.share), axis=0)  # which of the bar's modes it belongs to
    share, sound = found.share[own, each], found.sound[own, each]
    moves = share.real > _MOVES
    lead = np.argmax(found.share.real, axis=1)[own]
    sign = np.where((sound * np.conj(sound[lead])).real < 0, -1.0, 1.0) * np.where(bar.pressure[0, own] < 0, -1.0, 1.0)
    still = np.abs(sound) * (1 - tube.fan_depth / 2 if tube.fan else 1.0)
    beside = np.abs(sound) * tube.fan_depth / 4
    heard = np.hypot(bar.pressure[0, own] * np.abs(share), still)
    frequency, decay = np.abs(found.s) / (2 * math.pi), -found.s.real

    faint = [(frequency[~moves], decay[~moves], own[~moves], (sign * heard)[~moves])]
    for turns in (-2 * tube.fan, 2 * tube.fan) if tube.fan and tube.fan_depth else ():
        faint.append((np.abs(frequency + turns), decay, own, sign * beside))
    for order, louder in overtones:
        faint.append((order * frequency, _SHED_POWER * decay, own, sign * louder * still))
    f, lost, of, loud = (np.concatenate(arrays) for arrays in zip(*faint, strict=True))
    most = np.sqrt(IMPEDANCE * lost / (2 * math.pi))  # Pa: of a mode that loses nothing but its sound
    taken = np.bincount(of, (loud / most) ** 2, bar.frequency.size)
    most *= np.sqrt(np.maximum(taken / _MOST_TAKEN, 1.0))[of]
    whole = np.bincount(own[moves], share.real[moves], bar.frequency.size)[own]
    felt = np.sqrt(share.real[moves] / whole[moves] * (1 - np.minimum(taken, _MOST_TAKEN))[own][moves])
    audible = np.abs(loud) * np.abs(bar.strike).max(axis=0)[of]
    keep = audible > _SILENT * audible.max(initial=0.0)
    return [
        Part(frequency[moves], decay[moves], bar.strike[:, own[moves]] * felt, (sign * heard)[moves] / felt),
        Part(f[keep], lost[keep], bar.strike[:, of[keep]] * (np.abs(loud) / most)[keep], (np.sign(loud) * most)[keep]),
    ]
