"""The board that strings and tongues are heard through, as a curve of its means.

The force at its bridge or clamp, F per unit modal velocity, puts the power |F|^2 Y/2 into the board. Y is the mean
conductance of a plate, 1/(8 sqrt(D m)) (Cremer, Heckl, Petersson, Structure-Borne Sound, 2005). Of this power the share
R/(R + eta omega) is radiated, R = 2 rho c sigma/m, with the efficiency of a plate in a wall: P c/(pi^2 S f_c)
sqrt(f/f_c) below the critical frequency, 1/sqrt(1 - f_c/f) above. Wood is stiffer along its grain, by a ratio r:
bending waves at theta to the grain have the rigidity D (r^(1/4) cos^2 theta + r^(-1/4) sin^2 theta)^2, of the geometric
mean D (Huber's plate), and f_c of their own. Modes lie evenly in the plane of wavenumbers, so evenly in phi, of which
f_c (r^(-1/4) cos^2 phi + r^(1/4) sin^2 phi) is the critical frequency: coincidence is spread over the root of r
(Cremer, Heckl, Petersson on orthotropic plates). Outlines are curved, so directions share their energy, and R is the
mean. Below its lowest mode Y falls as f^4. Single modes stand out of the mean only where they are listed: a mode of
mass M at f_1, of a quality Q, adds Re[j omega/(M (omega_1^2 - omega^2 + j omega omega_1/Q))]. Such a mode rings, too,
as the string pulls at it (string.py).

A ribbed board is one plate only as long as its waves are long. Where half of one fits between two ribs, waves stay
between these, and the board yields and radiates as the bare panel does (Ege and Boutillon, Proc. ICA, 2010: the rise
of a piano's mobility above 1.1 kHz), whose edges the ribs are, too.

A bridge on two feet turns on its legs, and its upper part, on which the strings lie, turns on a spring against its
lower one (Reinicke 1973; J. Woodhouse, "On the 'bridge hill' of the violin", Acta Acustica united with Acustica 91,
2005): above these resonances little of a string's force reaches the board.

A bridge that is glued on is a beam across the board: its impedance adds to the board's 1/Y. That of a slender one is
2 m' c (1 + j), of a mass m' per length and bending waves of the speed c (Cremer, Heckl, Petersson); a high one shears,
too, and its sections have inertia as they turn (Timoshenko 1921).

What holds tongues is shorter than the waves on it, so it moves as one block of a mass M, and adds j omega M. It lifts a
tongue off the board's middle plane by h: the force of a tongue that bends sideways turns the board by the moment F h.
The conductance of a plate to a moment is omega/(16 D) (Cremer, Heckl, Petersson), to which the block's inertia adds.
"""

import math
from dataclasses import dataclass

import numpy as np

from .. import choices
from ..air import IMPEDANCE, SPEED
from ..material import Array

_JOIN = 1.25  # times the critical frequency: up to here from its inverse the efficiency follows a power law
_DIRECTIONS = 16  # of waves, from along the grain to across


@dataclass(frozen=True)
class Resonance:
    """A single mode of a board: its frequency (Hz), its quality, and its modal mass at the bridge (kg)."""

    frequency: float
    quality: float
    mass: float

    def conductance(self, frequency: Array) -> Array:
        """Return its real mobility (s/kg)."""
        omega, own = 2 * math.pi * frequency, 2 * math.pi * self.frequency
        mobility = 1j * omega / (self.mass * (own**2 - omega**2 + 1j * omega * own / self.quality))
        return np.asarray(mobility.real, np.float64)


@dataclass(frozen=True)
class Beam:
    """A bridge that is glued on: its mass per length (kg/m) and its rigidity (N m^2); if it is not slender, its
    resistance to shear (N) and the inertia of its sections as they turn (kg m)."""

    mass: float
    rigidity: float
    shear: float = math.inf
    turning: float = 0.0

    @classmethod
    def of(cls, width: float, height: float, density: float, modulus: float, shear_modulus: float) -> "Beam":
        """Return that of a rectangle (m), of a density (kg/m^3) and moduli (Pa)."""
        area, second = width * height, width * height**3 / 12
        return cls(density * area, modulus * second, 5 / 6 * shear_modulus * area, density * second)

    def mobility(self, frequency: Array) -> Array:
        """Return the mobility (s/kg) at a point of a long beam, by residues: of a travelling wave and a near field, the
        roots k of EI k^4 - omega^2 (J + m' EI/S) k^2 - omega^2 m' (1 - omega^2 J/S)."""
        omega, soft = 2 * math.pi * np.asarray(frequency), 1 / self.shear
        turned = 1 - omega**2 * self.turning * soft
        half = omega**2 * (self.turning + self.mass * self.rigidity * soft) / (2 * self.rigidity)
        apart = np.sqrt(half**2 + omega**2 * self.mass * turned / self.rigidity)
        given = [1j * omega * (self.rigidity * square * soft + turned) for square in (half + apart, half - apart)]
        near = np.sqrt(apart - half + 0j)
        found: Array = given[0] / (2j * np.sqrt(half + apart)) - given[1] / (2 * near)
        return found / (2 * apart * self.rigidity)

    def under(self, mean: Array, frequency: Array) -> Array:
        """Return the conductance (s/kg) on the beam, on a board of a mean conductance, where both move alike."""
        both: Array = np.real(1 / (1 / mean + 1 / self.mobility(frequency)))
        return both


@dataclass(frozen=True)
class Block:
    """A holder of tongues on a board: its mass (kg), its inertia (kg m^2) as the board turns across the tongues, and
    how far they are above the middle plane of the board (m)."""

    mass: float
    inertia: float
    raised: float

    @classmethod
    def of(cls, mass: float, length: float, raised: float) -> "Block":
        """Return that of slender bars across the tongues, of a mass in all (kg) and a length (m)."""
        return cls(mass, mass * length**2 / 12, raised)

    def under(self, mean: Array, frequency: Array) -> Array:
        """Return the conductance (s/kg) on the block, on a board of a mean conductance."""
        both: Array = np.real(1 / (1 / mean + 2j * math.pi * frequency * self.mass))
        return both

    def aside(self, rigidity: float, frequency: Array) -> Array:
        """Return the conductance (s/kg) to a force along the board, of a rigidity (N m), at a tongue."""
        omega = 2 * math.pi * frequency
        both: Array = np.real(self.raised**2 / (16 * rigidity / omega + 1j * omega * self.inertia))
        return both


@dataclass(frozen=True)
class Bridge:
    """A bridge on two feet: a lower part on a leg of so many N/m over each, and an upper one on a joint (N m).

    Lengths (m): of the joint over the feet, of the strings over the joint; half of that between the feet. Masses (kg):
    of each foot; of the lower part, at the joint; of the upper part, in two halves so far (m) to either side, above the
    joint by `raised` (m). loss_factor: of its wood.
    """

    leg: float
    joint: float
    height: float
    strings: float
    aside: float
    foot: float
    lower: float
    upper: float
    upper_aside: float
    raised: float
    loss_factor: float

    @property
    def lever(self) -> float:
        """The conductance at the strings over that under a foot, at low frequencies: the force's moment is that of
        greater ones at the feet, and each foot has a mobility of its own."""
        return 2 * ((self.height + self.strings) / (2 * self.aside)) ** 2

    def passed_on(self, frequency: Array, mobility: float) -> Array:
        """Return the power that strings put into a board, of a mobility (s/kg) under each foot, over that which they
        would by a rigid bridge without mass.

        A force of 1 N turns the lower part by a and the upper one by b: (G + K - omega^2 I) a - k b = height and
        (K - omega^2 I') b - k a = strings, with the joint's K, k = K + omega^2 upper height raised, and the legs and
        feet's G: legs of stiffness L on feet that take j omega C - omega^2 I_f, as springs in series.
        """
        omega, wood = 2 * math.pi * frequency, 1 + 1j * self.loss_factor
        legs, joint = 2 * self.leg * self.aside**2 * wood, self.joint * wood
        board = (2 * self.aside) ** 2 / (2 * mobility)
        feet = 1j * omega * board - omega**2 * 2 * self.foot * self.aside**2
        followed = legs / (legs + feet)  # by the feet, as the lower part turns
        lower = feet * followed + joint - omega**2 * (self.lower + self.upper) * self.height**2
        upper = joint - omega**2 * self.upper * (self.raised**2 + self.upper_aside**2)
        both = joint + omega**2 * self.upper * self.height * self.raised
        turned = followed * (self.height * upper + both * self.strings) / (lower * upper - both**2)
        share: Array = np.abs(omega * board * turned / (self.height + self.strings)) ** 2
        return share


@dataclass(frozen=True)
class Ribs:
    """Ribs of a board: the frequency (Hz) from which waves stay between them, their length in all (m), and the mass per
    area (kg/m^2), the rigidity (N m), and the ratio of rigidities along and across the grain, of the panel between
    them, as which the board behaves an octave higher."""

    between: float
    length: float
    areal: float
    rigidity: float
    grain: float


@dataclass(frozen=True)
class Board:
    """A board's mass per area (kg/m^2), its rigidity (N m), the geometric mean of both directions, its loss factor, its
    area (m^2), its perimeter (m), and the frequency (Hz) of its lowest mode.

    ribs: if it has any. bridge: one on feet; glued: one that is glued on; block: what holds tongues. grain: the ratio
    of rigidities along and across the grain. single: modes that stand out of the mean, as they are measured at the
    strings.
    """

    areal: float
    rigidity: float
    loss_factor: float
    area: float
    perimeter: float
    lowest: float
    ribs: Ribs | None = None
    bridge: Bridge | None = None
    glued: Beam | None = None
    block: Block | None = None
    grain: float = 1.0
    single: tuple[Resonance, ...] = ()

    def conductance(self, frequency: Array) -> Array:
        """Return the real mobility (s/kg) at the bridge: the mean, and that of single modes."""
        mean = _mobility(self.areal, self.rigidity) / (1 + (self.lowest / frequency) ** 4)
        if self.ribs:
            stiffer = _mobility(self.ribs.areal, self.ribs.rigidity) / _mobility(self.areal, self.rigidity)
            mean = mean * stiffer ** _between(self.ribs, frequency)
        if self.glued:
            mean = self.glued.under(mean, frequency)
        if self.block:
            mean = self.block.under(mean, frequency)
        single = sum(mode.conductance(frequency) for mode in self.single)
        if not self.bridge:
            return np.asarray(mean + single)
        passed = self.bridge.passed_on(frequency, _mobility(self.areal, self.rigidity))
        return np.asarray((mean * self.bridge.lever + single) * passed)

    def conductance_aside(self, frequency: Array) -> Array:
        """Return the real mobility (s/kg) that a force along the board meets, at the tongues that its block holds."""
        return self.block.aside(self.rigidity, frequency) if self.block else np.zeros_like(frequency)

    def radiated_share(self, frequency: Array) -> Array:
        """Return the share of the board's power that becomes sound."""
        resistance = _resistance(frequency, self.areal, self.rigidity, self.perimeter, self.area, self.grain)
        if self.ribs:
            edges = self.perimeter + 2 * self.ribs.length
            ribs = self.ribs
            panel = _resistance(frequency, ribs.areal, ribs.rigidity, edges, self.area, ribs.grain)
            resistance = resistance * (panel / resistance) ** _between(self.ribs, frequency)
        share: Array = resistance / (resistance + self.loss_factor * 2 * math.pi * frequency)
        return share


def _between(ribs: Ribs, frequency: Array) -> Array:
    """Return by how much a board behaves as the panel between its ribs: 0 to 1."""
    share: Array = np.clip(np.log2(frequency / ribs.between), 0, 1)
    return share


def _mobility(areal: float, rigidity: float) -> float:
    """Return the mean mobility (s/kg) of a plate."""
    return 1 / (8 * math.sqrt(rigidity * areal))


def _resistance(frequency: Array, areal: float, rigidity: float, perimeter: float, area: float, grain: float) -> Array:
    """Return the resistance R (1/s) of a plate's modes in a wall, the mean of their directions."""
    along = np.cos(0.5 * math.pi * (np.arange(_DIRECTIONS) + 0.5) / _DIRECTIONS) ** 2
    spread = grain**-0.25 * along + grain**0.25 * (1 - along)
    critical = SPEED**2 / (2 * math.pi) * math.sqrt(areal / rigidity) * spread
    ratio = np.asarray(frequency)[..., None] / critical
    low = perimeter * SPEED / (math.pi**2 * area * critical) * np.sqrt(np.minimum(ratio, 1 / _JOIN))
    high = 1 / np.sqrt(1 - 1 / np.maximum(ratio, _JOIN))
    rise = np.clip((np.log(ratio) / math.log(_JOIN) + 1) / 2, 0, 1)
    resistance: Array = 2 * IMPEDANCE / areal * np.mean(low ** (1 - rise) * high**rise, axis=-1)
    return resistance


_THICKNESS, _DENSITY = 0.008, 390.0
_ALONG, _ACROSS = 11.5e9, 0.47e9
_RIGIDITY = math.sqrt(_ALONG * _ACROSS) * _THICKNESS**3 / 12
_SPRUCE, _HARDWOOD = _ALONG / _ACROSS, 10.0
"""Spruce: its thickness (m), its density (kg/m^3), its moduli along and across the grain (Pa), estimates after Ege's
thesis, and its rigidity (N m). Ratios of moduli; of hard woods it is 8 to 14 (an estimate, after Wood Handbook)."""

PIANO = Board(
    areal=4.0, rigidity=2000.0, loss_factor=0.02, area=1.4, perimeter=5.0, lowest=60.0,
    ribs=Ribs(between=1100.0, length=10.0, areal=_DENSITY * _THICKNESS, rigidity=_RIGIDITY, grain=_SPRUCE),
    glued=Beam.of(width=0.032, height=0.032, density=705.0, modulus=12.6e9, shear_modulus=1.1e9),
)  # fmt: skip
"""8 mm of spruce with eleven ribs of 0.9 m: a conductance of 1.4e-3 s/kg, where a piano's is 1e-3 within a factor of 2
up to the frequency from which waves stay between the ribs (Giordano, J. Acoust. Soc. Am. 103, 1998; Ege and Boutillon
2010), and 7e-3 s/kg above, beside the bridge; on it, where the strings are, 0.9 to 0.5e-3. The bridge: 32 mm wide, 30
to 34 high (D. Fandrich, pianotech, 24 March 2009), of sugar maple (12.6 GPa, in shear 0.063
and 0.111 of that, an estimate after Wood Handbook). Without it the board took more from a string above 1.5 kHz than
strings are measured to lose. Losses: of 1 to 3 % (Ege, Boutillon, Rebillat, J. Sound Vib. 332, 2013)."""

BOX = Board(
    areal=7.0, rigidity=350.0, loss_factor=0.02, area=0.02, perimeter=0.6, lowest=150.0, grain=_HARDWOOD,
    block=Block.of(mass=0.031, length=0.075, raised=0.0095),
)  # fmt: skip
"""The top of a hollow box for tongues, 200 x 100 x 10 mm of hard wood, estimated: a conductance of 2.5e-3 s/kg. The
lowest mode is that of the air in it. Tongues lie on two rods of steel, of 4 x 75 mm, under one of aluminium, of 10 x 75
mm (M. Portuondo Alvarez, waldorf-ideen-pool.de, a kalimba to build): 15 and 16 g."""

CELLO = Board(
    areal=2.0, rigidity=25.0, loss_factor=0.025, area=0.24, perimeter=2.0, lowest=220.0,
    grain=_SPRUCE,
    bridge=Bridge(
        leg=3.6e5, joint=716.8, height=0.052, strings=0.032, aside=0.035,
        foot=0.0024, lower=0.0046, upper=0.0059, upper_aside=0.026, raised=0.011, loss_factor=0.02,
    ),
    single=(Resonance(100.0, 30.0, 3.0), Resonance(180.0, 30.0, 0.4), Resonance(220.0, 35.0, 0.6)),
)  # fmt: skip
"""The top of a cello: 4.5 mm of spruce, 0.75 m long, with what its bass bar adds, estimated. Its air resonance and two
modes of its corpus, near where they lie in most cellos (an estimate, after Bynum and Rossing 1997); qualities and
masses estimated. The bridge: sizes, masses and stiffnesses as a cello's are in IRCAM's Modalys by default; its loss
factor estimated, as of maple across its grain."""

GUITAR = Board(
    areal=1.3, rigidity=10.0, loss_factor=0.02, area=0.14, perimeter=1.5, lowest=350.0,
    ribs=Ribs(
        between=600.0, length=2.4, grain=_SPRUCE,
        areal=_DENSITY * 0.0025, rigidity=_RIGIDITY * (0.0025 / _THICKNESS) ** 3,
    ),
    glued=Beam(mass=0.19, rigidity=13.7), grain=_SPRUCE,
    single=(Resonance(100.0, 25.0, 0.6), Resonance(195.0, 18.0, 0.12), Resonance(390.0, 40.0, 0.15)),
)  # fmt: skip
"""The top of a classical guitar: 2.5 mm of spruce with its struts, estimated: seven of 0.25 m along the grain, 45 mm
apart, and two of 0.3 m across it; half a wave fits between two of them, across the grain, at 600 Hz. Its bridge:
Indian rosewood of 830 kg/m^3 and 11.5 GPa (dealers' data), 28 x 8 mm under the saddle, as is usual. Its coupled
modes of air and top near 100 and 195 Hz, where an effective mass of 0.1 kg is usual (an estimate, after Christensen
and Vistisen, J. Acoust. Soc. Am. 68, 1980), and one more. The quality of that near 195 Hz is as it rings in seven
notes of three recorded guitars, a T60 of 0.20 s in their median (FluidR3, freepats, A320U); the other qualities and
masses estimated."""

BOARDS = dict(zip(choices.BOARDS, (PIANO, BOX, CELLO, GUITAR), strict=True))
