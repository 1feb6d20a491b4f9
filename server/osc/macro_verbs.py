"""The addresses of macros: the knobs of an object, the die that turns them, and the way to another object."""

from dataclasses import dataclass

from ...dsp.macros import MACROS, MORPH
from ...dsp.schema import SEED, Parameter
from .arguments import Values, Verb, Word
from .points import Change
from .wire import Argument

MACRO, DICE, UNDO, MORPHING = (f"/object/NAME/{name}" for name in ("macro", "dice", "undo", MORPH.name))
OTHER = Word("preset", "name of a preset of the same shape")


@dataclass(frozen=True)
class Morph(Change):
    """An address that changes a number which counts for a preset that is named first."""

    @property
    def number(self) -> Parameter:
        """The number that it changes."""
        return MORPH

    def parse(self, args: tuple[Argument, ...]) -> Values:
        """Return the preset, the last value, and the points on the way there; raise Refused that names the argument
        that does not fit."""
        if len(args) < len(self.required):
            return Verb.parse(self, args)
        preset = OTHER.check(args[0])
        values = super().parse(args[1:])
        values.words[OTHER.name] = preset
        return values


MACRO_VERBS = (
    *(
        Change(f"{MACRO}/{name}", f"{macro.number.help}, from {' to '.join(macro.ends)}", (macro.number,))
        for name, macro in MACROS.items()
    ),
    Verb(
        DICE,
        "sets all macros at random, in ranges that sound good; `/object/NAME/macros` answers with the macros' values",
        optional=(SEED,),
    ),
    Verb(UNDO, "restores the macros' values from before the last `dice`"),
    Morph(MORPHING, "changes the object's sound part of the way to another preset of the same shape", (OTHER, MORPH)),
)  # fmt: skip
