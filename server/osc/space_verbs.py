"""The addresses of space: places of objects, the listener and the room."""

from ...dsp.schema import Parameter
from .arguments import Either, Verb

LISTENER, ROOM, FLOOR, PLACE = "/listener", "/room", "/floor", "/object/NAME/place"

_FAR = 1e5
LAYOUTS = ("pan", "binaural", "ambisonics")
"""Ways in which directions are told to channels; their places are their numbers."""


def _metres(name: str, help: str, default: float | None = None, low: float = -_FAR) -> Parameter:
    return Parameter(name, low, _FAR, "m", help, default=default)


def _degrees(name: str, help: str) -> Parameter:
    return Parameter(name, -360.0, 360.0, "degrees", help, default=0.0)


OVER = Parameter("over", 0.0, 3600.0, "s", "time that it takes from where it is, evenly", default=0.0)
XYZ = tuple(_metres(name, "of the place") for name in "xyz")
T60 = Parameter("t60", 0.05, 60.0, "s", "time in which the late part falls by 60 dB; by the absorption if not given")

LISTENING = (
    Verb(
        LISTENER,
        "places the listener, who looks along x with y to the left and z up, turned by yaw to the left, pitch down, "
        "then roll to the right; objects with a place are heard from there",
        XYZ,
        keys=(
            _degrees("yaw", "to the left"),
            _degrees("pitch", "down"),
            _degrees("roll", "to the right"),
            OVER,
            Either("layout", LAYOUTS),
            Parameter("head", 0.02, 1.0, "m", "radius of the head, of the layout binaural", default=0.0875),
            Parameter("temperature", -20.0, 50.0, "degrees Celsius", "of the air", default=20.0),
            Parameter("humidity", 1.0, 100.0, "%", "of the air", default=50.0),
            Parameter("air", 0.0, 10.0, "times", "its absorption as it is; 0: it takes nothing", default=1.0),
        ),
    ),
    Verb(
        FLOOR,
        "lays a floor, which reflects, at a height; without arguments nothing reflects",
        optional=(_metres("z", "of the floor"),),
        keys=(Parameter("absorption", 0.0, 1.0, "", "share of the energy that it takes", default=0.1),),
    ),
    Verb(
        ROOM,
        "puts all into a box with first reflections and a late part: its lengths along x, y and z",
        tuple(_metres(name, "length of the room", low=0.5) for name in ("length", "width", "height")),
        keys=(
            *(_metres(name, "of its lowest corner", 0.0) for name in ("x", "y", "z")),
            Parameter("absorption", 0.001, 1.0, "", "share of the energy that each wall takes; by t60 if not given"),
            T60,
            Parameter("t60_high", 0.05, 60.0, "s", "the same of high frequencies; that of low ones if not given"),
            Parameter("late", 0, 1, "", "0: first reflections alone", default=1.0),
        ),
    ),
)

PLACING = Verb(
    PLACE,
    "puts it into space, or has it go there; without arguments it is placed by its pan again",
    optional=XYZ,
    keys=(OVER,),
)
