"""Completion of a gesture's message by what the object's preset says."""

from dataclasses import replace

from ...dsp.schema import GESTURES, VELOCITY
from ...presets import ObjectPreset
from ..osc.arguments import Refused, Values, Verb


def completed(values: Values, verb: Verb | None, preset: ObjectPreset) -> Values:
    """Return the values of a message; of a gesture's with those that the preset has for what it leaves out.

    A message that says what strikes takes none of the preset's striker; the surface is the object's all the same.
    Refused if neither says the gesture's first argument.
    """
    if verb is None or verb.action not in GESTURES or GESTURES[verb.action].what:
        return values
    usual, gesture = preset.gestures.get(verb.action), GESTURES[verb.action]
    argument, words, defaults = gesture.argument.name, values.words, values.defaults
    instead = values.numbers.get(gesture.instead)
    if instead is not None and argument in values.numbers:
        both = f"{argument} = {values.numbers[argument]:g}, {gesture.instead} = {instead:g}"
        raise Refused(f"{both}: expected one of the two")
    if not usual and argument == VELOCITY.name:
        defaults = {**defaults, argument: preset.velocity}
    if usual:
        strikes = {"striker", "by"} & words.keys() or {"mass", "stiffness"} <= values.numbers.keys()
        named = {"surface": usual.surface} if usual.surface else {}
        words = {**named, **({} if strikes else {"striker": usual.striker}), **words}
        defaults = {**defaults, **({argument: usual.numbers[argument]} if strikes else usual.numbers)}
    if instead is not None:
        defaults = {**defaults, argument: 0.0}
    elif argument not in values.numbers and argument not in defaults:
        raise Refused(f"{argument} is missing, and {preset.name} has none: expected {verb.usage()}")
    return replace(values, words=words, defaults=defaults)
