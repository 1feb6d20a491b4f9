"""Every gesture, parameter and setting of the engine, declared once; `counters.py` has its counters.

From these declarations come the engine's records (`engine/memory`), the check of OSC messages, the
addresses that steer gestures, OSCQuery's ranges, the ranges of presets, the methods' keys in Python and the tables in
the documentation. To add a parameter to a gesture, add it to the gesture's `keys` here and read it in the kernel.
"""

from dataclasses import dataclass, replace
from functools import cached_property

from .numerics.constants import FULL_SCALE_PRESSURE, STANDARD_GRAVITY
from .numerics.quantities import Parameter as Parameter
from .sizes import CAPACITY

DROPS, SPEEDS, ENERGIES, FALLS = 1, 2, 3, 4
"""Laws of a swarm's blows: drops of rain; grains at the speeds of a gas; a power law of energies; grains that fall."""


@dataclass(frozen=True)
class Gesture:
    """Something that strikes an object: its first argument, the keys that may follow, and the traits that kernels ask
    for. `engine/contacts/gesture_kernels.py` says which kernels begin it, and bring its striker back."""

    name: str
    help: str
    argument: Parameter
    keys: tuple[Parameter, ...] = ()
    instead: str = ""
    """The key that may be given in place of the argument."""
    fixed: tuple[str, ...] = ()
    """Keys that can be steered elsewhere, but not in this gesture."""
    repeats: bool = False
    """True if it is many contacts: when one is over, its kernel says when and how fast the next one comes."""
    falls: bool = False
    """True if gravity acts on its striker, which flies between contacts, and presses by its weight near rest."""
    held: bool = False
    """True if a hand holds its striker, and presses it on until the gesture is stopped."""
    rolls: bool = False
    """True if its striker turns on a surface."""
    slips: bool = False
    """True if its striker slips over a surface, with friction."""
    rests: bool = False
    """True if the object lies on something, at rest under a load that is no part of the force that modes get."""
    what: str = ""
    """The help of the word `what`, which comes first and says on what it rests; its argument is a key then."""
    meets: float = 1.0
    """Share of the striker's mass that meets the object."""
    swarms: int = 0
    """The law of its blows, DROPS, SPEEDS, ENERGIES or FALLS, if it is many small ones at random times; else 0."""
    treads: bool = False
    """True if its blows come as the force of a foot comes and goes, after which it is over."""
    breaks: bool = False
    """True if the object breaks, and its pieces fall on what lies below."""

    @property
    def along(self) -> bool:
        """True if its contact moves along a surface; a gesture of that id that goes on is steered."""
        return self.rolls or self.slips

    @property
    def lasts(self) -> bool:
        """True if it is one contact, or swarm of them, until it is stopped."""
        return self.held or self.along or self.rests or self.swarms > 0

    @property
    def single(self) -> bool:
        """True if it is one blow, after which the striker is gone."""
        return not (self.repeats or self.lasts)

    @cached_property
    def steerable(self) -> tuple[str, ...]:
        """Names of the parameters that a running gesture takes anew."""
        given = (self.argument, *STRIKE, *POINT, *(BY_POINT if self.rests else ()), *self.keys)
        named = {each.name: each.steerable for each in given}
        return tuple(name for name, steerable in named.items() if steerable and name not in self.fixed)


# Parameters of any striker. Presets have the same ranges.
_STRIKERS, _OBJECTS = "the striker's", "the object's"
MASS = Parameter("mass", 1e-9, 1e6, "kg", "mass of the striker", useful=(1e-4, 10.0), otherwise=_STRIKERS)
STIFFNESS = Parameter("stiffness", 1e-3, 1e16, "N/m^a", "contact stiffness k", useful=(1e3, 1e12), otherwise=_STRIKERS)
DISSIPATION = Parameter(
    "dissipation", 0.0, 1e6, "s/m", "contact dissipation mu", useful=(0.0, 10.0),
    otherwise="the striker's; for rolls and slides the surface's",
)  # fmt: skip
EXPONENT = Parameter("exponent", 1.0, 6.0, "", "contact exponent a", useful=(1.0, 4.0), otherwise=_STRIKERS)
LAW = (MASS, STIFFNESS, DISSIPATION, EXPONENT)
"""The contact law f = k x^a (1 + mu v): m, k, mu, a."""
_STEERED_LAW = tuple(replace(each, steerable=True, glide=0.02) for each in LAW)
"""The same of gestures that go on, which take it anew."""
RESTITUTION = Parameter(
    "restitution", 1e-6, 1.0, "",
    "coefficient of restitution at a rigid wall, in place of `dissipation`; not for rolls",
    useful=(0.1, 1.0),
)  # fmt: skip

POSITION = Parameter(
    "position", 0.0, 1.0, "", "position on the object's strike path, from one end (0) to the other (1)",
    steerable=True, glide=0.02, otherwise=_OBJECTS,
)  # fmt: skip
POINT = tuple(
    Parameter(
        axis, -1000.0, 1000.0, "m", f"{axis} of the point that is touched, in the object's own frame",
        useful=(-0.2, 0.2), steerable=True, glide=POSITION.glide,
    )
    for axis in "xyz"
)  # fmt: skip
"""The place of a gesture on an object that has a surface, in place of the position: the nearest point of it."""
BY_POINT = tuple(
    replace(each, name=f"by_{each.name}", help=f"{each.name} of the point on the other object, in its own frame")
    for each in POINT
)
"""The same of the object that strikes, or on which it rests: only a rest's is steered."""
DIRECTION = tuple(
    Parameter(
        f"direction_{axis}", -1000.0, 1000.0, "", f"{axis} of the direction of the force, in the object's own frame",
        useful=(-1.0, 1.0),
    )
    for axis in "xyz"
)  # fmt: skip
"""The direction of a blow's force, or of a slide's friction, at a point of a surface, in place of the normal."""
BY_DIRECTION = tuple(
    replace(each, name=f"by_{each.name}", help=f"{each.name[-1]} of the direction of the force on the other object")
    for each in DIRECTION
)
"""The same of the object that strikes."""
GAIN = Parameter(
    "gain", -120.0, 40.0, "dB", "level of the gesture", default=0.0, useful=(-40.0, 12.0), steerable=True, glide=0.02
)
BY_POSITION = Parameter(
    "by_position", 0.0, 1.0, "", "position on the striking object's strike path", otherwise="the other object's"
)
LOAD = Parameter(
    "load", 1e-6, 1e5, "N", "normal force",
    useful=(0.1, 50.0), steerable=True, glide=0.1, otherwise="the object's weight, or a hand's usual force",
)  # fmt: skip
RESISTANCE = Parameter(
    "resistance", 0.01, 1e9, "N s/m", "resistance of the ground under a support; 0: rigid",
    useful=(0.1, 1e5), or_zero=True, otherwise="the support's",
)  # fmt: skip
BY_RADIUS = Parameter(
    "by_radius", 1e-4, 10.0, "m",
    "radius of curvature of the contact with the other object", useful=(1e-3, 0.1), otherwise="0.01",
)  # fmt: skip
STRIKE = (*LAW, RESTITUTION, POSITION, GAIN)
"""The parameters that all gestures share."""

VELOCITY = Parameter(
    "velocity", 0.0, 1000.0, "m/s", "speed of the striker as it meets the object; 0 does nothing", useful=(0.01, 5.0),
    otherwise=_OBJECTS,
)  # fmt: skip
IMPULSE = Parameter("impulse", 0.0, 1e6, "N s", "impulse of the blow, in place of `velocity`", useful=(1e-4, 1.0))
HEIGHT = Parameter("height", 0.0, 1000.0, "m", "height of the drop", useful=(0.01, 2.0), otherwise=_OBJECTS)
THROW = Parameter(
    "velocity", -100.0, 100.0, "m/s", "speed of a throw, downwards; negative: upwards", default=0.0, useful=(-5.0, 5.0)
)
SPEED = Parameter(
    "speed", 0.0, 100.0, "m/s", "speed along the surface; 0: the striker stops", useful=(0.01, 5.0), steerable=True,
    glide=0.02, otherwise=_OBJECTS,
)  # fmt: skip
RADIUS = Parameter(
    "radius", 1e-4, 10.0, "m", "radius of the rolling body", useful=(1e-3, 0.2), steerable=True,
    otherwise="the striker's, if it is a ball",
)  # fmt: skip
FORCE = Parameter("force", 0.0, 1e5, "N", "normal force", useful=(0.1, 50.0), steerable=True, glide=0.1)
GRAVITY = Parameter(
    "gravity", 0.01, 1000.0, "m/s^2", "gravity", default=STANDARD_GRAVITY, useful=(1.0, 30.0), steerable=True,
    glide=0.02,
)  # fmt: skip
IRREGULARITY = Parameter(
    "irregularity", 0.0, 1.0, "", "deviation of the striker from a ball, so that its bounces are uneven",
    default=0.0, steerable=True, steered="from its next contact on",
)  # fmt: skip
SEED = Parameter(
    "seed", 0, 2**31 - 1, "", "seed of the random numbers", whole=True, otherwise="another for each gesture"
)
OTHER_SEED = 2.0**40
"""What the seed of a shatter's thick parts is above that of its other pieces."""
ROUGHNESS = Parameter("roughness", 0.0, 100.0, "times",
    "factor on the roughness of the surface", default=1.0, useful=(0.0, 10.0), steerable=True,
)  # fmt: skip
TRAVEL = Parameter(
    "travel", 0.0, 1e3, "m", "length of the strike path, on which the striker goes to and fro; 0: no motion",
    default=0.0, useful=(0.0, 2.0),
)  # fmt: skip

IMPACT = Gesture(
    "impact", "strikes the object once; the key `by` lets another object strike, and both ring", VELOCITY, (IMPULSE,),
    instead="impulse")  # fmt: skip
BOUNCE = Gesture(
    "bounce", "drops or throws the striker onto the object; it bounces until it lies still", HEIGHT,
    (
        THROW,
        replace(GRAVITY, steered="from its next flight on"),
        IRREGULARITY,
        SEED,
        Parameter("weight", 0, 1, "", "1: gravity acts in every contact; 0: only in slow contacts", default=0.0),
    ),
    repeats=True, falls=True,
)  # fmt: skip
ROLL = Gesture(
    "roll", "rolls the striker over the object until the speed is 0. "
    "A message whose `id` (default: NAME) is a running roll steers that", SPEED,
    (
        *_STEERED_LAW,
        RADIUS,
        ROUGHNESS,
        Parameter("asymmetry", 0.0, 1.0, "", "offset of the centre of mass, in radii", default=0.0, steerable=True),
        Parameter(
            "friction", 0.0, 10.0, "", "braking force, as a share of the weight", default=0.0, useful=(0.0, 0.2),
            steerable=True,
        ),
        GRAVITY,
        SEED,
        Parameter("corners", 0, 100, "", "number of corners; 0: round", default=0.0, whole=True),
        TRAVEL,
    ),
    rolls=True,
)  # fmt: skip
PRESS = Gesture(
    "press", "presses the striker, such as a hand, against the object until `/stop`", FORCE, _STEERED_LAW,
    fixed=("gain",), held=True,
)  # fmt: skip
DURATION = Parameter(
    "duration", 0.0, 3600.0, "s", "time until the disc is still; 0 does nothing", useful=(0.1, 10.0), otherwise=_OBJECTS
)
SPIN = Gesture(
    "spin", "lets a coin, a lid or a ring spin down on the object, rattling ever faster and fainter",
    DURATION,
    (
        Parameter("angle", 0.1, 80.0, "degrees", "tilt at the beginning", default=20.0, useful=(1.0, 40.0)),
        Parameter("radius", 1e-3, 10.0, "m", "radius of the disc", default=0.0116, useful=(0.005, 0.2)),
        Parameter(
            "quickening", 0.1, 0.9, "", "exponent n: with a time t left, the rate of contacts is proportional to t^-n",
            default=0.4, useful=(0.3, 0.5),
        ),
        Parameter(
            "flat", 0.001, 1.0, "", "length of a flat on the rim, which hits once a turn, as a share of the radius",
            default=0.2, steerable=True, steered="from its next contact on",
        ),
        replace(IRREGULARITY, help="variation of the contacts in time and strength"),
        replace(GRAVITY, steered="from its next contact on"),
        SEED,
    ),
    repeats=True, meets=0.2,  # of a free disc, what its rim touches: 1/m + R^2/(m R^2/4) = 5/m
)  # fmt: skip
SLIDE = Gesture(
    "slide", "drags the striker over the object until the speed is 0. "
    "A message whose `id` (default: NAME) is a running slide steers that",
    replace(SPEED, help="slip speed of the striker over the surface; 0: the striker stops"),
    (
        replace(FORCE, otherwise="the striker's weight"),
        Parameter(
            "sweep", -1.0, 100.0, "m/s", "speed of the contact over the object; 0: in place (a bow); -1: slip speed",
            useful=(0.0, 5.0), steerable=True, glide=0.02, otherwise=_STRIKERS,
        ),
        Parameter(
            "radius", 1e-4, 10.0, "m", "radius of the tip", useful=(1e-4, 0.05), steerable=True, otherwise=_STRIKERS
        ),
        Parameter(
            "patch", 0.0, 1.0, "m", "width of the contact; roughness finer than this averages out", useful=(0.0, 0.02),
            steerable=True, otherwise=_STRIKERS,
        ),
        ROUGHNESS,
        Parameter(
            "static", 0.0, 10.0, "", "coefficient of static friction", useful=(0.0, 1.5), steerable=True,
            otherwise=_STRIKERS,
        ),
        Parameter(
            "dynamic", 0.0, 10.0, "", "coefficient of friction in fast slip", useful=(0.0, 1.0), steerable=True,
            otherwise=_STRIKERS,
        ),
        Parameter(
            "stribeck", 1e-6, 100.0, "m/s", "slip speed at which friction is halfway from static to dynamic",
            useful=(0.001, 1.0), steerable=True, otherwise=_STRIKERS,
        ),
        Parameter(
            "tangential", 1e-3, 1e12, "N/m", "stiffness of the contact along the surface, before it slips; 0: rigid",
            useful=(1e2, 1e7), steerable=True, or_zero=True, otherwise=_STRIKERS,
        ),
        Parameter(
            "along", 0.0, 1.0, "", "share of the modes' motion that is along the slip; 0: only roughness is heard",
            steerable=True, otherwise=_STRIKERS,
        ),
        SEED,
        TRAVEL,
    ),
    slips=True,
)  # fmt: skip
REST = Gesture(
    "rest", "lays the object on another object or a support until `/stop`; objects in contact ring for less time",
    LOAD,
    (
        replace(_STEERED_LAW[0], help="mass that moves at the contact", otherwise="from the load, or the hand's"),
        *(replace(each, otherwise="the support's, or from both materials") for each in _STEERED_LAW[1:]),
        replace(BY_POSITION, help="position on the strike path of the other object", steerable=True,
            glide=POSITION.glide),
    ),
    fixed=("gain",), rests=True, what="name of another object, or a support: felt, foam, finger, palm or table",
)  # fmt: skip
MOST_BLOWS = 1e6
"""1/s: of a swarm's blows of its own, at most."""
RATE = Parameter("rate", 0.0, MOST_BLOWS, "1/s", "blows per second, on average", useful=(1.0, 1e5), steerable=True)
SPREAD = Parameter(
    "spread", 0.0, 1.0, "", "share of the strike path that the blows cover, around the position", default=1.0
)
VARIETY = Parameter("variety", 0.0, 1.0, "",
    "variation of size: strikers are up to 1 + variety times larger or smaller", default=0.0, steerable=True,
)  # fmt: skip
EXCITATION = Parameter(
    "excitation", 0.0, 0.98, "", "share of the blows that are set off by other blows", default=0.0, steerable=True
)
MEMORY = Parameter("memory", 1e-4, 10.0, "s",
    "mean time from a blow to the blows that it sets off", default=0.05, useful=(0.001, 0.1), steerable=True,
)  # fmt: skip
RAIN = Gesture(
    "rain", "lets drops fall on the object until `/stop`", replace(RATE, help="drops per second, on average"),
    (
        Parameter(
            "size", 5e-5, 2e-3, "m", "scale of the drops' diameters; 0.0004 in moderate rain",
            default=5e-4, useful=(2e-4, 1e-3), steerable=True,
        ),
        Parameter(
            "reach", 1.0, 100.0, "", "distance of the farthest drops, as a multiple of the nearest drops' distance",
            default=1.0, useful=(1.0, 10.0),
        ),
        SPREAD,
        SEED,
    ),
    swarms=DROPS,
)  # fmt: skip
SHAKE = Gesture(
    "shake", "lets many copies of the striker, such as dice, hit the object at random times until `/stop`",
    RATE,
    (
        Parameter(
            "speed", 0.0, 100.0, "m/s", "scale of the speeds at which grains hit; 37 % of the grains are faster",
            default=1.0, useful=(0.05, 5.0), steerable=True, glide=0.02,
        ),
        Parameter(
            "evenness", 0.5, 10.0, "",
            "evenness of the speeds: a share exp(-(v/speed)^evenness) is faster than v; 2: as in a gas",
            default=2.0, steerable=True,
        ),
        EXCITATION,
        MEMORY,
        VARIETY,
        SPREAD,
        SEED,
    ),
    swarms=SPEEDS,
)  # fmt: skip
CRUMPLE = Gesture(
    "crumple", "crushes the object, which crackles by blows of the striker, until `/stop`",
    replace(SPEED, help="speed of crushing; 0 pauses"),
    (
        Parameter(
            "density", 1.0, 1e7, "1/m", "crackles per metre of crushing", default=3000.0,
            useful=(100.0, 1e5), steerable=True,
        ),
        Parameter("energy", 1e-9, 10.0, "J", "energy of the strongest crackle", default=1e-3, useful=(1e-6, 1e-1),
            steerable=True),
        Parameter(
            "steepness", 0.0, 5.0, "", "exponent b in the distribution E^-b of energies; 1.3 to 1.6 for paper",
            default=1.5, useful=(1.0, 2.0), steerable=True,
        ),
        Parameter("decades", 0.1, 9.0, "", "decades of energy from the weakest to the strongest", default=4.0,
            useful=(1.0, 6.0), steerable=True),
        replace(EXCITATION, default=0.5),
        replace(MEMORY, default=0.005),
        VARIETY,
        SPREAD,
        SEED,
    ),
    swarms=ENERGIES,
)  # fmt: skip
POUR = Gesture(
    "pour", "pours many copies of the striker, such as rice, onto the object until `/stop`",
    replace(RATE, help="grains per second, on average"),
    (
        replace(HEIGHT, help="height of the fall", default=0.2, useful=(0.02, 2.0), steerable=True),
        VARIETY,
        replace(SPREAD, default=0.3),
        SEED,
    ),
    swarms=FALLS,
)  # fmt: skip
STEP = Gesture(
    "step",
    "treads on the object once, from heel to toe; it crackles by blows of the striker",
    replace(FORCE, help="weight of the person who walks", useful=(100.0, 1500.0)),
    (
        Parameter(
            "crackles", 0.0, 1e4, "1/N", "crackles per newton of change in the force of the foot",
            default=0.5, useful=(0.05, 10.0), steerable=True,
        ),
        replace(DURATION, help="time for which the foot is on the ground", low=0.05, default=0.65, useful=(0.3, 2.0)),
        *(each for each in CRUMPLE.keys if each.name in ("energy", "steepness", "decades")),
        VARIETY,
        SPREAD,
        SEED,
    ),
    swarms=ENERGIES, treads=True,
)  # fmt: skip
MOST_PIECES = 256
SHATTER = Gesture(
    "shatter",
    "breaks the object into pieces that bounce until they lie still; `striker` is the preset of a piece",
    replace(VELOCITY, help="speed at which the object hits something and breaks; 0 does nothing"),
    (
        Parameter("pieces", 1, MOST_PIECES, "", "number of pieces", default=60.0, whole=True),
        replace(HEIGHT, help="greatest height from which a piece falls", default=0.1),
        Parameter("steepness", 1.01, 3.0, "", "exponent b in the distribution m^-b of the masses", default=1.35),
        replace(MASS, name="wall_mass", help="total mass of all pieces but the thick parts; 0: the object's mass",
            useful=None, default=0.0, or_zero=True),
        replace(MASS, name="thick_mass", help="mass of the thick parts, such as foot, bottom and neck; 0: none",
            useful=None, default=0.0, or_zero=True),
        Parameter("thick_ratio", 0.1, 10.0, "times", "ratio of the thick parts' thickness to that of the other pieces",
            default=2.5),
        Parameter("thick_parts", 1, MOST_PIECES, "", "number of thick parts", default=1.0, whole=True),
        SPREAD,
        SEED,
    ),
    fixed=("x", "y", "z"), swarms=ENERGIES, breaks=True, meets=1.0 / 7.0,  # of a piece on a corner, as of a square
)  # fmt: skip
GESTURES = {
    gesture.name: gesture
    for gesture in (IMPACT, BOUNCE, ROLL, PRESS, SPIN, SLIDE, REST, RAIN, SHAKE, CRUMPLE, POUR, STEP, SHATTER)
}

TRAIT_NAMES = (
    "single", "repeats", "falls", "held", "rolls", "slips", "rests", "along", "lasts", "meets", "swarms", "treads",
    "breaks",
)  # fmt: skip
"""Traits of gestures that kernels ask for: 1 or 0, but for `meets` and `swarms`."""

STEERABLE = tuple(dict.fromkeys(name for gesture in GESTURES.values() for name in gesture.steerable))
"""Names of all parameters that a gesture can take anew while it runs; their places are their numbers."""


def gestures_steered_by(name: str) -> dict[str, Parameter]:
    """Return the gestures that a steerable parameter steers, by name, each with the parameter as it has it."""
    found = {}
    for gesture in GESTURES.values():
        own = {each.name: each for each in (*STRIKE, *POINT, *BY_POINT, *gesture.keys, gesture.argument)}
        if name in gesture.steerable:
            found[gesture.name] = own[name]
    return found


# Settings of an object.
SETTINGS = {
    setting.name: setting
    for setting in (
        Parameter("gain", -120.0, 40.0, "dB", "level of the object", default=0.0, useful=(-40.0, 12.0)),
        Parameter(
            "pan", -1.0, 1.0, "",
            "pan: -1 left, 1 right; with more than two channels, the angle on the ring of speakers, 0 in front",
            default=0.0,
        ),
        Parameter(
            "distance", 0.1, 1000.0, "m", "distance to the listener; twice as far is half the pressure", default=1.0,
            useful=(0.5, 20.0),
        ),
        Parameter("tune", -60.0, 60.0, "semitones", "shift of all frequencies", default=0.0, useful=(-24.0, 24.0)),
        Parameter("decay", 0.001, 100.0, "times", "factor on all decay times", default=1.0, useful=(0.1, 10.0)),
        Parameter("damp", 0.0, 1.0, "", "damping as by a hand: 0 none, 1 the firmest", default=0.0),
    )
}  # fmt: skip

# Settings of the whole.
CHANNELS = Parameter(
    "channels", 1, CAPACITY.channels, "", "number of channels; 2: left and right; others: a ring", default=2, whole=True
)
SENSED = Parameter(
    "sensors", 0, CAPACITY.sensors, "", "number of channels for sensors, after those of the sound", whole=True
)
FULL_SCALE = Parameter(
    "full_scale", 1e-6, 1e6, "Pa", "pressure of a sample of 1.0, for objects of level 0 dB",
    default=FULL_SCALE_PRESSURE, useful=(0.1, 100.0),
)  # fmt: skip
FORMS = ("float64", "float32")
"""Numbers that the spectral bank can keep its modes in; their places are their numbers."""
MAIN_GAIN = Parameter("gain", -120.0, 40.0, "dB", "level of everything", default=0.0, useful=(-40.0, 12.0))
STEPS = Parameter(
    "steps", 0, 1_000_000, "", "steps per sample that a coupled contact may take, on average; 0: as many as it needs",
    default=0.0, useful=(0, 64), whole=True,
)  # fmt: skip
ROOM = Parameter(
    "modes", 0, 2**31 - 1, "",
    "largest number of modes coupled at once; each contact counts as 32 more; 0: any number",
    default=0.0, useful=(0, 65_536), whole=True,
)  # fmt: skip
OVER = Parameter("over", 0.0, 3600.0, "s", "duration of the change", default=0.0, useful=(0.01, 10.0))
CURVE = Parameter(
    "curve", -20.0, 20.0, "", "shape of the change: 0 even, below 0 fast at first, above 0 slow at first",
    default=0.0, useful=(-8.0, 8.0),
)  # fmt: skip
OWN_GAIN = Parameter("gain", -100.0, 100.0, "", "gain factor of a channel", useful=(0.0, 1.0))
