"""Notes: the tuning of an object to a pitch, and the copies of it that notes are played on."""

import math

from ...dsp.bodies.modes import Modes
from ...dsp.schema import SETTINGS
from ..new_object import TUNINGS
from ..osc.arguments import Refused, Values, check_number
from ..osc.wire import Argument
from .objects import PlayedObject

_A4, _A4_NUMBER = 440.0, 69
_SLOWEST, _FASTEST = 0.05, 5.0  # m/s of the velocities 1 and 127


def tuned(modes: Modes, values: Values) -> float:
    """Return the tuning (semitones) of an object: `tune`, from the note or the pitch that is requested if one is.

    Refused where both are given, the tuning goes too far, or it has no mode.
    """
    given = [key for key in TUNINGS if key in values.numbers]
    tune = values.number("tune")
    if not given:
        return tune
    if len(given) > 1:
        raise Refused("note and pitch: expected one of the two")
    if not modes.pitch:
        raise Refused(f"{given[0]}: it has no audible mode, and so no pitch; expected an object with one")
    pitch = values.numbers.get("pitch") or _A4 * 2.0 ** ((values.numbers["note"] - _A4_NUMBER) / 12.0)
    tune += 12.0 * math.log2(pitch / modes.pitch)
    try:
        return check_number(SETTINGS["tune"], tune)
    except Refused as error:
        raise Refused(f"{given[0]}: its pitch is {modes.pitch:.1f} Hz: {error}") from None


def speed_of(velocity: float) -> float:
    """Return the speed (m/s) of a MIDI velocity from 1 to 127: equal steps are equal ratios."""
    return float(_SLOWEST * (_FASTEST / _SLOWEST) ** ((max(velocity, 1.0) - 1.0) / 126.0))


def keys_of(obj: PlayedObject) -> dict[str, Argument]:
    """Return the keys of the /object/new that makes an object anew, as it is set now."""
    keys = {str(key): value for key, value in zip(obj.made[2::2], obj.made[3::2], strict=True) if key not in TUNINGS}
    keys.update({key: value for key, value in obj.settings.items() if value != SETTINGS[key].default or key in keys})
    return keys


def copy_of(obj: PlayedObject, name: str, note: float) -> tuple[Argument, ...]:
    """Return the arguments of the /object/new that makes an object anew, as it is set now, tuned to a note."""
    keys = {key: value for key, value in keys_of(obj).items() if key != "tune"}
    keys["note"] = note
    return name, obj.preset.name, *(each for pair in keys.items() for each in pair)
