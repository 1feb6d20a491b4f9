"""The addresses of space: places of objects, the listener and the room."""

from ...dsp.schema import Parameter
from ...dsp.space.layouts import Layout
from .arguments import Either, Verb

LISTENER, ROOM, FLOOR, PLACE = "/listener", "/room", "/floor", "/object/NAME/place"

_FAR = 1e5
LAYOUTS = tuple(each.name.lower() for each in Layout)
"""Ways in which directions become channels; their places are their numbers."""


def _metres(name: str, help: str, default: float | None = None, low: float = -_FAR) -> Parameter:
    return Parameter(name, low, _FAR, "m", help, default=default)


def _degrees(name: str, help: str) -> Parameter:
    return Parameter(name, -360.0, 360.0, "degrees", help, default=0.0)


OVER = Parameter("over", 0.0, 3600.0, "s", "duration of the move", default=0.0)
XYZ = tuple(_metres(name, f"{name} of the place") for name in "xyz")
T60 = Parameter(
    "t60", 0.05, 60.0, "s", "time in which the reverberation falls by 60 dB", otherwise="from `absorption`, or else 0.5"
)

LISTENING = (
    Verb(
        LISTENER,
        "places the listener, who looks along x unless turned, with y to the left and z up",
        XYZ,
        keys=(
            _degrees("yaw", "turn to the left"),
            _degrees("pitch", "turn down, after the yaw"),
            _degrees("roll", "tilt to the right, after the pitch"),
            OVER,
            Either("layout", LAYOUTS, "way in which directions become channels", "pan"),
            Parameter("head", 0.02, 1.0, "m", "radius of the head, in the layout `binaural`", default=0.0875),
            Parameter("temperature", -20.0, 50.0, "degrees Celsius", "temperature of the air", default=20.0),
            Parameter("humidity", 1.0, 100.0, "%", "humidity of the air", default=50.0),
            Parameter("air", 0.0, 10.0, "times", "factor that multiplies the air's absorption", default=1.0),
        ),
    ),
    Verb(
        FLOOR,
        "lays a reflecting floor, in place of any room; without arguments, removes either",
        optional=(_metres("z", "height of the floor"),),
        keys=(Parameter("absorption", 0.0, 1.0, "", "share of the energy that the floor absorbs", default=0.1),),
    ),
    Verb(
        ROOM,
        "puts the listener and all objects that have a `place` into a box that reflects and reverberates",
        tuple(
            _metres(name, f"{name} of the room, along {axis}", low=0.5)
            for name, axis in (("length", "x"), ("width", "y"), ("height", "z"))
        ),
        keys=(
            *(_metres(name, f"{name} of the lowest corner", 0.0) for name in ("x", "y", "z")),
            Parameter("absorption", 0.001, 1.0, "", "share of the energy that each wall absorbs", otherwise="by `t60`"),
            T60,
            Parameter("t60_high", 0.05, 60.0, "s", "`t60` at high frequencies", otherwise="`t60`"),
            Parameter("late", 0, 1, "", "1: reflections and reverberation; 0: reflections alone", default=1.0),
        ),
    ),
)

PLACING = Verb(
    PLACE,
    "gives the object a place in space, instead of its pan; without arguments, restores that",
    optional=XYZ,
    keys=(OVER,),
)
