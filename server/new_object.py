"""An object that a message asks for: its preset with the message's changes, and its modes."""

from typing import NamedTuple

from ..dsp.bodies.modes import Modes
from ..dsp.schema import SETTINGS
from ..dsp.wording import expected
from ..presets import ObjectPreset, Presets
from .osc.addresses import VERBS, Call
from .osc.arguments import Refused, Values, shown

NEW = "/object/new"
TUNINGS = ("note", "pitch")
"""Keys of /object/new that tune it."""


class NewObject(NamedTuple):
    """A preset, changed as a message asks, and its modes."""

    preset: ObjectPreset
    modes: Modes


def new_object(call: Call, presets: Presets, top: float) -> NewObject:
    """Make the object that a call of NEW asks for, with modes up to `top` (Hz). Any thread may ask; it can take
    seconds.

    Refused or PresetError say why there is none.
    """
    values = VERBS[NEW].parse(call.message.args)
    preset = changed(presets, values)
    modes = preset.modes(top)
    if modes.sheet:
        modes.sheet.laid_out(top)  # which is kept, and may take longer than the modes
    return NewObject(preset, modes)


def changed(presets: Presets, values: Values) -> ObjectPreset:
    """Return the preset that /object/new names, with what its keys change. Refused or PresetError name a key that
    cannot be."""
    name = values.words["preset"]
    if values.others:
        preset = presets.object(name)
        known = dict.fromkeys((*VERBS[NEW].named, *preset.keys))
        for key, value in values.others.items():
            if key not in known:
                none = f"{name}, of the shape {preset.shape}, has no such key"
                raise Refused(f"{key} = {shown(value)}: {none}; {expected(key, known)}")
    given = {**values.numbers, **values.words}
    changes = {key: value for key, value in given.items() if key not in ("name", "preset", *SETTINGS, *TUNINGS)}
    return presets.changed(name, (*values.others.items(), *changes.items()))
