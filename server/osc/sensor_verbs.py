"""The addresses of sensors, `/sensor/...`: contact microphones and accelerometers on objects."""

from ...dsp.bodies.sensor import QUANTITIES
from ...dsp.schema import DIRECTION, POINT, Parameter
from .arguments import Either, Vector, Verb, Word

SENSOR = "/sensor/new"

PLACE = Parameter("position", 0.0, 1.0, "", "position on the object's strike path", otherwise="the object's")
RESONANCE = Parameter(
    "resonance",
    1.0,
    1e6,
    "Hz",
    "resonance of the sensor; 0: none",
    useful=(500.0, 100_000.0),
    or_zero=True,
    otherwise="the preset's",
)
DAMPING = Parameter(
    "damping", 1e-4, 10.0, "", "damping ratio of the resonance", useful=(0.01, 1.0), otherwise="the preset's"
)
FULL = Parameter(
    "full", 1e-9, 1e9, "", "acceleration or velocity, in SI units, of a sample of 1.0", default=1.0,
    useful=(0.01, 10_000.0),
)  # fmt: skip

SENSORS = (
    Verb(
        SENSOR,
        "mounts a sensor on an object; its signal, in SI units, gets a channel after the sound's",
        (Word("name", "name of the sensor"), Word("object", "name of the object")),
        (PLACE,),
        (
            Word("preset", "kind: ideal, velocity, accelerometer, mems, piezo-20, piezo-27 or piezo-35", "ideal"),
            Either("quantity", tuple(QUANTITIES), "quantity that the sensor measures", "the preset's"),
            RESONANCE,
            DAMPING,
            FULL,
            Vector(
                "point", POINT, "point in the object's frame, in place of `position`; the nearest surface point counts"
            ),
            Vector("direction", DIRECTION, "direction in which the sensor measures at `point`, in place of the normal"),
        ),
    ),
    Verb("/sensor/NAME/free", "removes a sensor; its channel falls silent"),
)
