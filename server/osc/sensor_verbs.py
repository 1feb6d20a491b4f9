"""The addresses of sensors, `/sensor/...`: contact microphones and accelerometers on objects."""

from ...dsp.bodies.sensor import QUANTITIES
from ...dsp.schema import DIRECTION, POINT, Parameter
from .arguments import Either, Vector, Verb, Word

SENSOR = "/sensor/new"

PLACE = Parameter("position", 0.0, 1.0, "", "along the object's strike path; the object's own if not given")
RESONANCE = Parameter(
    "resonance", 1.0, 1e6, "Hz", "of the sensor; 0: it has none", useful=(500.0, 100_000.0), or_zero=True
)
DAMPING = Parameter("damping", 1e-4, 10.0, "", "the damping ratio of its resonance", useful=(0.01, 1.0))
FULL = Parameter("full", 1e-9, 1e9, "", "the value that is a sample of 1.0", default=1.0, useful=(0.01, 10_000.0))

SENSORS = (
    Verb(
        SENSOR,
        "mounts a sensor on an object: a channel of its own after those of the sound, in m/s^2 or m/s along the "
        "normal or a direction, without gain and limiter",
        (Word("name"), Word("object")),
        (PLACE,),
        (
            Word("preset", "accelerometer, mems, piezo-20, piezo-27, piezo-35, velocity, or ideal, if none is given"),
            Either("quantity", tuple(QUANTITIES)),
            RESONANCE,
            DAMPING,
            FULL,
            Vector("point", POINT, "in place of its position: the nearest point of its surface or strike path (m)"),
            Vector("direction", DIRECTION, "beside a point, in the object's own frame: in which it senses"),
        ),
    ),
    Verb("/sensor/NAME/free", "takes a sensor away; its channel is silent"),
)
