"""Modes of bodies from shape and material, computed once, in Python.

Each shape is a function of a `Material` and of named dimensions; it returns the `Modes` up to `top` (Hz). Dimensions
are keywords, as many as the shape has: the names that a preset's TOML file gives them.
"""

from .bar import bar
from .disc import disc, membrane
from .material import Material, hertz
from .modes import Modes, listed
from .plate import plate
from .ring import glass, ring
from .string import string

__all__ = [
    "Material",
    "Modes",
    "bar",
    "disc",
    "glass",
    "hertz",
    "listed",
    "membrane",
    "plate",
    "ring",
    "string",
]
