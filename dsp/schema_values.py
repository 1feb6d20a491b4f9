"""The values that a command carries, as parameters: those of gestures, those that all of these share, and of ramps."""

from .schema import (
    BY_DIRECTION,
    BY_POINT,
    BY_POSITION,
    CURVE,
    DIRECTION,
    GESTURES,
    OVER,
    POINT,
    STRIKE,
    VELOCITY,
    Gesture,
    Parameter,
)

_MOST_PLACE = 2**53
"""Of whole numbers that a float holds."""

_SOUND = (
    Parameter("sound", 0, _MOST_PLACE, "", "its place among the strikers that are laid out", default=0.0),
    Parameter("sound_serial", 0, _MOST_PLACE, "", "its serial there; 0: it does not sound", default=0.0),
)
_PRESSED = Parameter(
    "press", 0, _MOST_PLACE, "", "number of the press that sets a slide's normal force; 0: none", default=0.0
)  # fmt: skip
_PULSES = Parameter("pulses", 0, _MOST_PLACE, "", "number of the table of pulses of small blows", default=0.0)
_WHOLE = Parameter("whole", 0.0, 1e9, "kg", "mass of what breaks", default=0.0)
_FRICTION = Parameter("friction", 0.0, 10.0, "", "coefficient, of pieces on what they fall on", default=0.0)
_OWN_LAW = (
    Parameter("own_stiffness", 0.0, 1e21, "N/m^a", "of pieces if they fall on nothing", default=0.0),
    Parameter("own_dissipation", 0.0, 1e6, "s/m", "the same", default=0.0),
    Parameter("own_level", 0.0, 1e12, "", "of pieces if they fall on nothing: as `level`", default=0.0),
)
_LEVEL = Parameter(
    "level", 0.0, 1e12, "", "factor on its gain: its make-up; of what breaks, so that all of it sounds at one level",
    default=1.0,
)  # fmt: skip
_STAGE = Parameter(
    "stage", 0, 2, "", "of what breaks: 0 its cracks, 1 its pieces on an object, 2 on nothing", default=0.0
)  # fmt: skip
_DELAY = Parameter("delay", 0.0, 1e9, "s", "from the beginning to the first contact", default=0.0)

_ON_SURFACE = (
    Parameter("on_surface", 0, 1, "", "1: at its point, 0: at its position", default=0.0, whole=True),
    Parameter("by_on_surface", 0, 1, "", "the same of the object that strikes", default=0.0, whole=True),
)

SHARED = {
    each.name: each
    for each in (
        VELOCITY, *STRIKE, *POINT, BY_POSITION, *BY_POINT, *DIRECTION, *BY_DIRECTION, *_ON_SURFACE, *_SOUND, _PRESSED,
        _DELAY, _PULSES, _WHOLE, _FRICTION, *_OWN_LAW, _LEVEL, _STAGE,
    )
}  # fmt: skip
"""Parameters that every gesture has, by name."""


def _own(gesture: Gesture) -> dict[str, Parameter]:
    """Return the parameters of a gesture that not every gesture has; one that falls gets the velocity, not the
    height."""
    given = (*gesture.keys, *(() if gesture.falls else (gesture.argument,)))
    return {each.name: each for each in given if each.name not in SHARED}


OWN = {name: _own(gesture) for name, gesture in GESTURES.items()}
"""Parameters of each gesture that not every gesture has, by name."""

_AFTER = Parameter("after", 0.0, 1e9, "s", "until it begins; 0: what was requested before ends", default=0.0)

OF_RAMPS = {each.name: each for each in (OVER, CURVE, _AFTER)}
"""Parameters of a ramp, by name."""
