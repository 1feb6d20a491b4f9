"""The addresses by which a simulation reports what happens in it, `/world/...`."""

from ...dsp.schema import RESTITUTION, SLIDE, Parameter
from .arguments import Either, Numbers, Verb, Word

BODY = "/world/body"

SIZES = {
    "box": "three edges, in m",
    "plate": "three edges, in m",
    "sphere": "a radius, in m",
    "cylinder": "a radius and a length, in m",
    "capsule": "a radius and the length between its ends' centres, in m",
    "mesh": "its vertices, an array (n, 3) in m, or these and its faces, an array (m, 3) of numbers of vertices",
}
"""The shapes of bodies, and the size that makes each."""

_FAR = 1e5
_PLACE = Parameter("metres", -_FAR, _FAR, "m")
_LENGTH = Parameter("x", 1e-5, 1e3, "m", "first edge, or radius", useful=(0.01, 1.0))
_GIVEN = ("roughness", "patch", "static", "dynamic", "stribeck", "tangential", "along")
PAIRED = (*(key for key in SLIDE.keys if key.name in _GIVEN), RESTITUTION)
"""The numbers that may be set for a pair of bodies."""


def _number(
    name: str, help: str, unit: str = "m", low: float = -_FAR, high: float = _FAR, otherwise: str = ""
) -> Parameter:
    return Parameter(name, low, high, unit, help, otherwise=otherwise)


TOUCHED = (
    _number("approach", "speed at which the bodies approach each other", "m/s"),
    _number("slip", "speed at which the bodies slip over each other", "m/s", 0.0),
    _number("depth", "depth of the bodies' overlap"),
    _number("force", "normal force", "N", 0.0, 1e6),
    _number("mass", "effective mass along the normal", "kg", 1e-9, 1e6),
    RESTITUTION,
    _number("friction", "coefficient of friction", "", 0.0, 100.0),
    _number("impulse", "impulse of the normal force in the step, in place of `approach`", "N s", 0.0, 1e6),
)
"""Quantities that may be reported of a point of contact."""

WORLD = (
    Verb(
        BODY,
        "makes a body of a simulation, and the object that sounds when the body is hit. A box or plate takes three "
        "lengths, a sphere a radius, a cylinder or capsule a radius and a length along z",
        (
            Word("name", "name of the body"),
            Either("shape", tuple(SIZES), "shape of the body"),
            Word("material", "preset of the material"),
            _LENGTH,
        ),
        (_number("y", "second edge, or length", low=1e-5, high=1e3), _number("z", "third edge", low=1e-5, high=1e3)),
        (
            _number("density", "density", "kg/m3", 1e-3, 1e5, otherwise="the material's"),
            _number("mass", "mass, in place of the density", "kg", 1e-9, 1e9),
            _number(
                "wall",
                "thickness of the wall of a hollow box, cylinder or capsule",
                low=1e-5,
                high=10.0,
                otherwise="solid",
            ),
            Parameter("held", 0, 1, "", "1: the body does not move", otherwise="0"),
            Parameter("rings", 0, 1, "", "0: the body is silent", otherwise="1"),
            Word("object", "preset of an object that rings in place of the body"),
            Parameter("most_modes", 1, 4096, "", "largest number of modes", whole=True),
        ),
    ),
    Verb(
        "/world/pair",
        "sets contact properties of two bodies, in place of those that follow from their materials",
        (Word("a", "name of a body"), Word("b", "name of the other body")),
        keys=(
            Word("surface", "preset of the surface"),
            Word("support", "support that sets the contact law: felt, foam, finger or palm"),
            *PAIRED,
        ),
    ),
    Verb(
        "/world/microphones",
        "places a microphone for each channel",
        many=Numbers(_PLACE, 3 * 64, "places", "x y z of each microphone"),
    ),
    Verb(
        "/world/pose",
        "sets the pose of a body: x y z (m) of its centre of mass, then optionally its quaternion w x y z, velocity "
        "x y z (m/s) and spin x y z (rad/s)",
        (Word("name", "name of the body"),),
        many=Numbers(Parameter("value", -_FAR, _FAR), 13, "values", "numbers of the pose, in the order above"),
    ),
    Verb(
        "/world/touch",
        "reports that two bodies touch at a point, with the normal from a to b",
        (
            Word("a", "name of a body"),
            Word("b", "name of the other body"),
            *(_number(name, f"{name} of the point") for name in "xyz"),
            *(_number(f"n{name}", f"{name} of the normal", "", -1.001, 1.001) for name in "xyz"),
        ),
        keys=TOUCHED,
    ),
    Verb(
        "/world/grains",
        "declares grains: small bodies, or a striker for `/world/pour`; all blows of grains on a body sound as one "
        "shake",
        (Word("name", "name of the grains"),),
        keys=(Word("bodies", "pattern of the bodies' names, such as stone*"), Word("striker", "preset of a striker")),
    ),
    Verb(
        "/world/pour",
        "reports how many grains hit a body since the last step; give at least one of speed, impulse and energy",
        (
            Word("name", "name of the grains"),
            Word("on", "name of the body"),
            _number("count", "number of blows", "", 0.0, 1e6),
        ),
        keys=(
            _number("speed", "rms speed", "m/s", 0.0, 1e3),
            _number("impulse", "impulse of all blows", "N s", 0.0, 1e6),
            _number("energy", "energy of all blows", "J", 0.0, 1e6),
            Parameter("position", 0, 1, "", "position on the strike path", otherwise="the object's"),
        ),
    ),
    Verb(
        "/world/step",
        "ends a step of the simulation; whatever was reported since the last step happens at `time`",
        (_number("time", "time of the simulation", "s", 0.0, 1e9),),
    ),
    Verb("/world/end", "ends the simulation; its objects fall silent"),
)
