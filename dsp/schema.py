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
MASS = Parameter("mass", 1e-9, 1e6, "kg", "overrides the striker preset", useful=(1e-4, 10.0))
STIFFNESS = Parameter("stiffness", 1e-3, 1e16, "N/m^a", "overrides the striker preset", useful=(1e3, 1e12))
DISSIPATION = Parameter(
    "dissipation", 0.0, 1e6, "s/m", "overrides the striker preset, or a roll's surface", useful=(0.0, 10.0)
)
EXPONENT = Parameter("exponent", 1.0, 6.0, "", "overrides the striker preset", useful=(1.0, 4.0))
LAW = (MASS, STIFFNESS, DISSIPATION, EXPONENT)
"""The contact law f = k x^a (1 + mu v): m, k, mu, a."""
RESTITUTION = Parameter(
    "restitution", 1e-6, 1.0, "",
    "in place of dissipation: the share of its speed that it keeps at a rigid wall, at any speed; not for rolls",
    useful=(0.1, 1.0),
)  # fmt: skip

POSITION = Parameter(
    "position", 0.0, 1.0, "", "where it is struck, from one end of the object's strike path to the other",
    steerable=True, glide=0.02,
)  # fmt: skip
POINT = tuple(
    Parameter(
        axis, -1000.0, 1000.0, "m", f"{axis} in its own frame of the point of its surface where it is struck",
        useful=(-0.2, 0.2), steerable=True, glide=POSITION.glide,
    )
    for axis in "xyz"
)  # fmt: skip
"""The place of a gesture on an object that has a surface, in place of the position: the nearest point of it."""
BY_POINT = tuple(
    replace(each, name=f"by_{each.name}", help=f"{each.name} of the point of that object on which it rests")
    for each in POINT
)
"""The same of the object that strikes, or on which it rests: only a rest's is steered."""
DIRECTION = tuple(
    Parameter(
        f"direction_{axis}", -1000.0, 1000.0, "", f"{axis} in its own frame of the direction in which it is pushed",
        useful=(-1.0, 1.0),
    )
    for axis in "xyz"
)  # fmt: skip
"""The direction of a blow's force, or of a slide's friction, at a point of a surface, in place of the normal."""
BY_DIRECTION = tuple(
    replace(each, name=f"by_{each.name}", help=f"the same of that object's: {each.name[-1]}") for each in DIRECTION
)
"""The same of the object that strikes."""
GAIN = Parameter(
    "gain", -120.0, 40.0, "dB", "of this gesture", default=0.0, useful=(-40.0, 12.0), steerable=True, glide=0.02
)
BY_POSITION = Parameter("by_position", 0.0, 1.0, "", "the point of that object that strikes")
LOAD = Parameter(
    "load", 1e-6, 1e5, "N", "that presses it on: its weight, or a hand's usual force, if not given",
    useful=(0.1, 50.0), steerable=True, glide=0.1,
)  # fmt: skip
RESISTANCE = Parameter(
    "resistance", 0.01, 1e9, "N s/m", "of the ground under a support; 0: it is rigid; the support's if not given",
    useful=(0.1, 1e5), or_zero=True,
)  # fmt: skip
BY_RADIUS = Parameter(
    "by_radius", 1e-4, 10.0, "m",
    "of that object where it touches, for the law that both materials make; 0.01 if not given", useful=(1e-3, 0.1),
)  # fmt: skip
STRIKE = (*LAW, RESTITUTION, POSITION, GAIN)
"""The parameters that all gestures share."""

VELOCITY = Parameter(
    "velocity", 0.0, 1000.0, "m/s", "of the striker as it meets the object; 0 does nothing", useful=(0.01, 5.0)
)
HEIGHT = Parameter("height", 0.0, 1000.0, "m", "from which it falls", useful=(0.01, 2.0))
THROW = Parameter("velocity", -100.0, 100.0, "m/s", "thrown downwards, or upwards", default=0.0, useful=(-5.0, 5.0))
SPEED = Parameter(
    "speed", 0.0, 100.0, "m/s", "along the surface; 0 stops it", useful=(0.01, 5.0), steerable=True, glide=0.02
)
RADIUS = Parameter(
    "radius", 1e-4, 10.0, "m", "of the body; the striker's if it is a ball", useful=(1e-3, 0.2), steerable=True
)
FORCE = Parameter("force", 0.0, 1e5, "N", "that presses it on", useful=(0.1, 50.0), steerable=True, glide=0.1)
GRAVITY = Parameter(
    "gravity", 0.01, 1000.0, "m/s^2", "", default=STANDARD_GRAVITY, useful=(1.0, 30.0), steerable=True, glide=0.02
)
IRREGULARITY = Parameter(
    "irregularity", 0.0, 1.0, "", "how far from round: energy comes and goes between flight and rotation",
    default=0.0, steerable=True, steered="from its next contact on",
)  # fmt: skip
SEED = Parameter("seed", 0, 2**31 - 1, "", "of its random numbers; another for each gesture if not given", whole=True)
OTHER_SEED = 2.0**40
"""What the seed of a shatter's thick parts is above that of its other pieces."""
ROUGHNESS = Parameter(
    "roughness", 0.0, 100.0, "times", "the surface's own", default=1.0, useful=(0.0, 10.0), steerable=True
)
TRAVEL = Parameter(
    "travel", 0.0, 1e3, "m", "length of the strike path, along which it goes to and fro; 0: it stays", default=0.0,
    useful=(0.0, 2.0),
)  # fmt: skip

IMPACT = Gesture("impact", "strikes it once; with `by`, another object strikes it, and rings too", VELOCITY)
BOUNCE = Gesture(
    "bounce", "drops or throws the striker on it, which bounces until it rests", HEIGHT,
    (
        THROW,
        replace(GRAVITY, steered="from its next flight on"),
        IRREGULARITY,
        SEED,
        Parameter("weight", 0, 1, "", "1: gravity acts in every contact too, not only near rest", default=0.0),
    ),
    repeats=True, falls=True,
)  # fmt: skip
ROLL = Gesture(
    "roll", "rolls the striker over it until 0, or steers the roll of that id (NAME if none)", SPEED,
    (
        replace(MASS, steerable=True, glide=0.02),
        RADIUS,
        ROUGHNESS,
        Parameter(
            "asymmetry", 0.0, 1.0, "", "how far the centre of mass is from the middle, as a share of the radius",
            default=0.0, steerable=True,
        ),
        Parameter(
            "friction", 0.0, 10.0, "", "share of its weight that slows it down", default=0.0, useful=(0.0, 0.2),
            steerable=True,
        ),
        GRAVITY,
        SEED,
        Parameter("corners", 0, 100, "", "of the body; 0: it is round", default=0.0, whole=True),
        TRAVEL,
    ),
    rolls=True,
)  # fmt: skip
PRESS = Gesture(
    "press", "lays the striker on it and presses, until it is stopped: a hand, a mute", FORCE,
    fixed=("gain",), held=True,
)  # fmt: skip
DURATION = Parameter("duration", 0.0, 3600.0, "s", "until it lies still; 0 does nothing", useful=(0.1, 10.0))
SPIN = Gesture(
    "spin", "lets a coin, a lid or a ring spin down on it: contacts ever faster and fainter, then silence", DURATION,
    (
        Parameter("angle", 0.1, 80.0, "degrees", "of its tilt at first", default=20.0, useful=(1.0, 40.0)),
        Parameter("radius", 1e-3, 10.0, "m", "of the disc", default=0.0116, useful=(0.005, 0.2)),
        Parameter(
            "quickening", 0.1, 0.9, "", "n, where t before its end the rate of contacts goes as t^-n: 1/3 by rolling "
            "friction, 1/2 where it loses power evenly", default=0.4, useful=(0.3, 0.5),
        ),
        Parameter(
            "flat", 0.001, 1.0, "", "length of the flat on its rim that hits once a turn, as a share of the radius",
            default=0.2, steerable=True, steered="from its next contact on",
        ),
        replace(IRREGULARITY, help="how much its contacts differ in time and strength"),
        replace(GRAVITY, steered="from its next contact on"),
        SEED,
    ),
    repeats=True, meets=0.2,  # of a free disc, what its rim touches: 1/m + R^2/(m R^2/4) = 5/m
)  # fmt: skip
SLIDE = Gesture(
    "slide", "drags the striker over it until 0, or steers the slide of that id (NAME if none): a scrape, a rub, a bow",
    replace(SPEED, help="at which the striker slips over the surface; 0 stops it"),
    (
        replace(FORCE, help="that presses it on; its weight if not given"),
        Parameter(
            "sweep", -1.0, 100.0, "m/s", "at which the contact moves over the object: 0 for a bow, which stays, "
            "or goes along its travel as it slips; -1: the slip's", useful=(0.0, 5.0), steerable=True, glide=0.02,
        ),
        Parameter("radius", 1e-4, 10.0, "m", "of the tip", useful=(1e-4, 0.05), steerable=True),
        Parameter("patch", 0.0, 1.0, "m", "width of the contact", useful=(0.0, 0.02), steerable=True),
        ROUGHNESS,
        Parameter("static", 0.0, 10.0, "", "friction where they stick", useful=(0.0, 1.5), steerable=True),
        Parameter("dynamic", 0.0, 10.0, "", "friction of a fast slip", useful=(0.0, 1.0), steerable=True),
        Parameter("stribeck", 1e-6, 100.0, "m/s", "slip halfway between them", useful=(0.001, 1.0), steerable=True),
        Parameter(
            "tangential", 1e-3, 1e12, "N/m", "stiffness of the contact along the surface, before it slips; 0: rigid",
            useful=(1e2, 1e7), steerable=True, or_zero=True,
        ),
        Parameter(
            "along", 0.0, 1.0, "", "by how much of their shapes modes move along the slip: 1 for what is bowed, "
            "0: no friction is heard, only the roughness", steerable=True,
        ),
        SEED,
        TRAVEL,
    ),
    slips=True,
)  # fmt: skip
REST = Gesture(
    "rest", "lays it on another object or on a support, until it is stopped: both ring shorter, and may buzz", LOAD,
    (
        replace(BY_POSITION, help="the point of that object on which it rests", steerable=True, glide=POSITION.glide
        ),
    ),
    fixed=("gain",), rests=True, what="another object, or a support: felt, foam, finger, palm or table",
)  # fmt: skip
MOST_BLOWS = 1e6
"""1/s: of a swarm's blows of its own, at most."""
RATE = Parameter("rate", 0.0, MOST_BLOWS, "1/s", "of its blows, on average", useful=(1.0, 1e5), steerable=True)
SPREAD = Parameter(
    "spread", 0.0, 1.0, "", "share of the strike path over which its blows fall, about the position", default=1.0,
)  # fmt: skip
VARIETY = Parameter(
    "variety", 0.0, 1.0, "", "the largest grains are 1 + variety times as large as the striker, the smallest as much "
    "smaller", default=0.0, steerable=True,
)  # fmt: skip
EXCITATION = Parameter(
    "excitation", 0.0, 0.98, "", "share of the blows that others set off", default=0.0, steerable=True
)  # fmt: skip
MEMORY = Parameter(
    "memory", 1e-4, 10.0, "s", "for which one sets off others", default=0.05, useful=(0.001, 0.1), steerable=True,
)  # fmt: skip
RAIN = Gesture(
    "rain", "lets drops fall on it until it is stopped", replace(RATE, help="of drops, on average"),
    (
        Parameter(
            "size", 5e-5, 2e-3, "m", "mean diameter of the drops in the air, above 0.5 mm; 0.4 mm in moderate rain",
            default=5e-4, useful=(2e-4, 1e-3), steerable=True,
        ),
        Parameter(
            "reach", 1.0, 100.0, "", "how far the farthest drops are from the ear, in the distance of the nearest, as "
            "on a wide level: those are fainter; 1: all are as near", default=1.0, useful=(1.0, 10.0),
        ),
        SPREAD,
        SEED,
    ),
    swarms=DROPS,
)  # fmt: skip
SHAKE = Gesture(
    "shake", "lets many of the striker hit it at random times, until it is stopped: gravel, dice in a cup", RATE,
    (
        Parameter(
            "speed", 0.0, 100.0, "m/s", "of the grains as they hit: one in e is faster; rms, with an evenness of 2",
            default=1.0, useful=(0.05, 5.0), steerable=True, glide=0.02,
        ),
        Parameter(
            "evenness", 0.5, 10.0, "", "of their speeds: as many are above v as exp(-(v/speed)^evenness); 2 for a gas",
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
    "crumple", "crushes it: crackles of all energies, each as a blow of the striker, until it is stopped",
    replace(SPEED, help="at which it is crushed; 0 pauses"),
    (
        Parameter(
            "density", 1.0, 1e7, "1/m", "of crackles, over the length by which it is crushed", default=3000.0,
            useful=(100.0, 1e5), steerable=True,
        ),
        Parameter("energy", 1e-9, 10.0, "J", "of the strongest", default=1e-3, useful=(1e-6, 1e-1), steerable=True),
        Parameter(
            "steepness", 0.0, 5.0, "", "b, where energies are as many as E^-b: 1.3 to 1.6 for paper (Houle and "
            "Sethna 1996)", default=1.5, useful=(1.0, 2.0), steerable=True,
        ),
        Parameter("decades", 0.1, 9.0, "", "of energy that they span", default=4.0, useful=(1.0, 6.0), steerable=True),
        replace(EXCITATION, default=0.5),
        replace(MEMORY, default=0.005),
        VARIETY,
        SPREAD,
        SEED,
    ),
    swarms=ENERGIES,
)  # fmt: skip
POUR = Gesture(
    "pour", "pours many of the striker on it, until it is stopped: rice, gravel, coins",
    replace(RATE, help="of grains, on average"),
    (
        replace(HEIGHT, help="from which they fall", default=0.2, useful=(0.02, 2.0), steerable=True),
        VARIETY,
        replace(SPREAD, default=0.3),
        SEED,
    ),
    swarms=FALLS,
)  # fmt: skip
STEP = Gesture(
    "step", "treads on it once, from heel to toe: crackles as the weight comes and goes, each as a blow of the striker",
    replace(FORCE, help="the weight of who walks; it comes and goes as a foot's force does", useful=(100.0, 1500.0)),
    (
        Parameter(
            "crackles", 0.0, 1e4, "1/N", "for each change of the force; it changes by three times the weight in a step",
            default=0.5, useful=(0.05, 10.0), steerable=True,
        ),
        replace(DURATION, help="of the foot on the ground", low=0.05, default=0.65, useful=(0.3, 2.0)),
        *(each for each in CRUMPLE.keys if each.name in ("energy", "steepness", "decades")),
        VARIETY,
        SPREAD,
        SEED,
    ),
    swarms=ENERGIES, treads=True,
)  # fmt: skip
MOST_PIECES = 256
SHATTER = Gesture(
    "shatter", "breaks it: it cracks and falls silent; its pieces, each as the striker, bounce until they lie still",
    replace(VELOCITY, help="at which it hits something, and breaks; 0 does nothing"),
    (
        Parameter("pieces", 1, MOST_PIECES, "", "into which it breaks", default=60.0, whole=True),
        replace(HEIGHT, help="up to which the pieces are as it breaks, each at its own", default=0.1),
        Parameter("steepness", 1.01, 3.0, "", "b, where as many pieces have a mass m as m^-b", default=1.35),
        replace(
            MASS, name="wall_mass", help="of all pieces as thick as the striker; 0: the object's", useful=None,
            default=0.0, or_zero=True,
        ),
        replace(
            MASS, name="thick_mass", help="of its thick parts besides: a foot, a bottom, a neck; 0: it has none",
            useful=None, default=0.0, or_zero=True,
        ),
        Parameter("thick_ratio", 0.1, 10.0, "times", "their thickness, in that of the striker", default=2.5),
        Parameter("thick_parts", 1, MOST_PIECES, "", "how many of these there are", default=1.0, whole=True),
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
        Parameter("gain", -120.0, 40.0, "dB", "its level", default=0.0, useful=(-40.0, 12.0)),
        Parameter(
            "pan", -1.0, 1.0, "",
            "its place from left, -1, to right, 1; on a ring from behind over left, front (0) and right to behind",
            default=0.0,
        ),
        Parameter(
            "distance", 0.1, 1000.0, "m", "to the listener: twice as far is half the pressure", default=1.0,
            useful=(0.5, 20.0),
        ),
        Parameter(
            "tune", -60.0, 60.0, "semitones", "moves all its frequencies up or down", default=0.0, useful=(-24.0, 24.0)
        ),
        Parameter(
            "decay", 0.001, 100.0, "times", "makes all its decay times longer or shorter", default=1.0,
            useful=(0.1, 10.0),
        ),
        Parameter("damp", 0.0, 1.0, "", "a hand on it, until changed: 0 none, 1 the firmest", default=0.0),
    )
}  # fmt: skip

# Settings of the whole.
CHANNELS = Parameter(
    "channels", 1, CAPACITY.channels, "", "of the output; 2: left and right, else a ring", default=2, whole=True
)
SENSED = Parameter("sensors", 0, CAPACITY.sensors, "", "channels after those of the sound", whole=True)
FULL_SCALE = Parameter(
    "full_scale", 1e-6, 1e6, "Pa", "that a sample of 1.0 is, of an object whose level is 0 dB",
    default=FULL_SCALE_PRESSURE, useful=(0.1, 100.0),
)  # fmt: skip
FORMS = ("float64", "float32")
"""Numbers that the spectral bank can keep its modes in; their places are their numbers."""
MAIN_GAIN = Parameter("gain", -120.0, 40.0, "dB", "of everything", default=0.0, useful=(-40.0, 12.0))
STEPS = Parameter(
    "steps", 0, 1_000_000, "", "per sample that a coupled contact may take on average; 0: as many as it needs",
    default=0.0, useful=(0, 64), whole=True,
)  # fmt: skip
ROOM = Parameter(
    "modes", 0, 2**31 - 1, "",
    "that may be coupled to contacts at once, each as often as it is, and 32 more for each contact; 0: any number",
    default=0.0, useful=(0, 65_536), whole=True,
)  # fmt: skip
OVER = Parameter("over", 0.0, 3600.0, "s", "time from the present value", default=0.0, useful=(0.01, 10.0))
CURVE = Parameter(
    "curve", -20.0, 20.0, "", "0: evenly, below 0: fast at first, above 0: slowly at first, as in SuperCollider's Env",
    default=0.0, useful=(-8.0, 8.0),
)  # fmt: skip
OWN_GAIN = Parameter("gain", -100.0, 100.0, "", "factor of one channel", useful=(0.0, 1.0))
