"""Modes of bodies from shape and material, computed once, in Python.

Each shape is a function of a `Material` and of named dimensions; it returns the `Modes` up to `top` (Hz). Dimensions
are keywords, as many as the shape has: the names that a preset's TOML file gives them. `Partials`, `Noise` and `Cavity`
add what a shape lacks.
"""

from importlib import import_module
from importlib.util import find_spec
from typing import Any

from .added import Noise, Partials
from .bar import bar
from .cavity import Cavity
from .disc import disc, membrane
from .listed import listed
from .material import Material, hertz
from .mesh import mesh
from .modes import Modes, loudest
from .plate import plate
from .ring import can, glass, ring
from .sphere import sphere
from .string import string

__all__ = [
    "Cavity",
    "Material",
    "Modes",
    "Noise",
    "Partials",
    "bar",
    "can",
    "disc",
    "glass",
    "hertz",
    "listed",
    "loudest",
    "membrane",
    "mesh",
    "plate",
    "ring",
    "sphere",
    "string",
]


def __getattr__(name: str) -> Any:
    """Return the shape of a module that is not named above: the function that has the module's name."""
    if name.startswith("_") or not find_spec(f"{__name__}.{name}"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    shape = getattr(import_module(f"{__name__}.{name}"), name)
    globals()[name] = shape  # importing has put the module there
    return shape
