"""The macros: eight knobs that every object has, declared once. All else that knows of them follows from this list.

A macro goes from 0 to 1, and in the middle the object is as its preset has it. Those of the body change its modes while
they ring; the others change the values of its gestures.
"""

from dataclasses import dataclass

from .numerics.constants import NEUTRAL as NEUTRAL
from .numerics.quantities import Parameter
from .schema import SETTINGS

GLIDE = 0.05
"""s: in which a macro changes that is given no time, so that a jump of it is not heard as one."""


@dataclass(frozen=True)
class Macro:
    """A knob of an object: what its ends are called, and the law by which it acts."""

    number: Parameter
    ends: tuple[str, str]
    law: str
    of_body: bool
    """True if it changes the object's modes; else it changes the values of its gestures."""
    controller: int
    """Number of the MIDI controller that turns it, unless another one is learnt."""
    dice: tuple[float, float]
    """Range within which a die chooses: what sounds good on all objects."""

    @property
    def name(self) -> str:
        """Its name, the last part of its address."""
        return self.number.name


def _macro(
    name: str, help: str, ends: tuple[str, str], law: str, controller: int, dice: tuple[float, float], of_body: bool
) -> Macro:
    return Macro(Parameter(name, 0.0, 1.0, "", help, default=NEUTRAL), ends, law, of_body, controller, dice)


MACROS = {
    macro.name: macro
    for macro in (
        _macro("size", "size of the body", ("small", "large"),
            "all lengths times s = 16^(m - 0.5); so frequencies times 1/s, masses times s^3",
            20, (0.25, 0.8), True),
        _macro("material", "material of the body", ("plastic", "steel"),
            "the material, in the order below; density, stiffness and losses change gradually in between",
            21, (0.3, 1.0), True),
        _macro("brightness", "decay time of high partials", ("dark", "bright"),
            "below 0.5: a loss that grows as the frequency squared; above 0.5: less loss of high partials",
            22, (0.2, 0.9), True),
        _macro("damping", "damping of the body", ("free", "held"),
            "below 0.5: longer decay times, up to fourfold; above 0.5: damping as by a hand",
            23, (0.2, 0.75), True),
        _macro("hardness", "hardness of strikers", ("soft", "hard"),
            "striker's stiffness times 1000^(2 m - 1), its mass times 2^(2 m - 1)",
            24, (0.2, 0.8), False),
        _macro("force", "strength of gestures", ("gentle", "strong"),
            "velocity, force or load times 8^(2 m - 1)",
            25, (0.4, 0.65), False),
        _macro("place", "position of gestures", ("one end", "the other end"),
            "positions, shifted towards one or the other end of the strike path",
            26, (0.2, 0.8), False),
        _macro("roughness", "roughness of surfaces under rolls and slides", ("smooth", "rough"),
            "roughness times 10^(2 m - 1)",
            27, (0.2, 0.8), False),
    )
}  # fmt: skip
"""All macros, by name."""

MORPH = Parameter("morph", 0.0, 1.0, "", "share of the way to the other preset: 0 none, 1 all", default=0.0)

SHAPING = (*(each.number for each in MACROS.values() if each.of_body), MORPH)
"""The numbers that change an object's modes."""
ENGINE_SETTINGS = {
    **SETTINGS,
    **{each.name: each.number for each in MACROS.values() if not each.of_body},
    **{each.name: each for each in SHAPING},
}
"""All settings of an object in the engine, those that change its modes last. It only keeps those of its gestures."""
