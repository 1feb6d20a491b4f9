"""The addresses by which a simulation is told, `/world/...`."""

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
_LENGTH = Parameter("x", 1e-5, 1e3, "m", "its first edge, or its radius", useful=(0.01, 1.0))
_GIVEN = ("roughness", "patch", "static", "dynamic", "stribeck", "tangential", "along")
PAIRED = (*(key for key in SLIDE.keys if key.name in _GIVEN), RESTITUTION)
"""The numbers that may be said of a pair of bodies."""


def _number(name: str, help: str, unit: str = "m", low: float = -_FAR, high: float = _FAR) -> Parameter:
    return Parameter(name, low, high, unit, help)


TOUCHED = (
    _number("approach", "how fast they close", "m/s"),
    _number("slip", "how fast they move over each other", "m/s", 0.0),
    _number("depth", "by how much they overlap"),
    _number("force", "along the normal", "N", 0.0, 1e6),
    _number("mass", "effective, along the normal", "kg", 1e-9, 1e6),
    RESTITUTION,
    _number("friction", "its coefficient", "", 0.0, 100.0),
)
"""Quantities that may be told of a point of contact."""

WORLD = (
    Verb(
        BODY,
        "makes a body of a simulation, and the object that rings as it does. A box, plate or mesh has three edges, a "
        "sphere a radius, a cylinder and a capsule a radius and a length along z",
        (Word("name"), Either("shape", tuple(SIZES)), Word("material"), _LENGTH),
        (_number("y", "", low=1e-5, high=1e3), _number("z", "", low=1e-5, high=1e3)),
        (
            _number("density", "its material's if not given", "kg/m3", 1e-3, 1e5),
            _number("mass", "in place of the density", "kg", 1e-9, 1e9),
            _number("wall", "thickness of the wall of a hollow box, cylinder or capsule", low=1e-5, high=10.0),
            Parameter("held", 0, 1, "", "1: it does not move"),
            Parameter("rings", 0, 1, "", "0: it is silent"),
            Word("object", "a preset that rings in its place"),
            Parameter("most_modes", 1, 4096, "", "of its object", whole=True),
        ),
    ),
    Verb(
        "/world/pair",
        "says how the contact of two bodies differs from that of their materials",
        (Word("a"), Word("b")),
        keys=(
            Word("surface", "a preset"),
            Word("support", "whose contact law they have in blows and at rest: felt, foam, finger or palm"),
            *PAIRED,
        ),
    ),
    Verb(
        "/world/microphones",
        "places a microphone for each channel: x y z (m), one after the other",
        many=Numbers(_PLACE, 3 * 64, "places"),
    ),
    Verb(
        "/world/pose",
        "says where a body is: x y z (m) of its centre of mass, and as many as are known of the quaternion w x y z of "
        "its axes, its velocity x y z (m/s) and its spin x y z (rad/s)",
        (Word("name"),),
        many=Numbers(Parameter("value", -_FAR, _FAR), 13, "values"),
    ),
    Verb(
        "/world/touch",
        "says that two bodies touch at a point, with the normal from a to b",
        (
            Word("a"),
            Word("b"),
            *(_number(name, "of the point") for name in "xyz"),
            *(_number(f"n{name}", "of the normal", "", -1.001, 1.001) for name in "xyz"),
        ),
        keys=TOUCHED,
    ),
    Verb(
        "/world/grains",
        "makes small bodies grains, or names a striker for `/world/pour`: a swarm is heard of their blows on each body",
        (Word("name"),),
        keys=(Word("bodies", "a pattern of their names, as stone*"), Word("striker", "a preset")),
    ),
    Verb(
        "/world/pour",
        "tells blows of grains on a body since the last step: how many, and at least one of speed, impulse and energy",
        (Word("name"), Word("on"), _number("count", "how many", "", 0.0, 1e6)),
        keys=(
            _number("speed", "rms", "m/s", 0.0, 1e3),
            _number("impulse", "of all of them", "N s", 0.0, 1e6),
            _number("energy", "of all of them", "J", 0.0, 1e6),
            Parameter("position", 0, 1, "", "on its strike path"),
        ),
    ),
    Verb(
        "/world/step",
        "ends a step of the simulation: what was told since the last one holds at this time",
        (_number("time", "of the simulation", "s", 0.0, 1e9),),
    ),
    Verb("/world/end", "forgets the simulation; its objects fall silent"),
)
