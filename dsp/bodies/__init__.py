"""Modes of bodies from shape and material, computed once, in Python.

Each shape is a function of a `Material` and of named dimensions; it returns the `Modes` up to `top` (Hz). Dimensions
are keywords, as many as the shape has: the names that a preset's TOML file gives them. `Partials`, `Noise` and `Cavity`
add what a shape lacks. Names load when they are first used.
"""

import sys
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .added import Noise, Partials
    from .bar import bar
    from .cavity import Cavity
    from .disc import disc, membrane
    from .listed import listed
    from .material import Material, hertz
    from .mesh import Table, mesh
    from .modes import Modes
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
    "Table",
    "bar",
    "can",
    "disc",
    "glass",
    "hertz",
    "listed",
    "membrane",
    "mesh",
    "plate",
    "ring",
    "sphere",
    "string",
]

_HOMES = {
    "Cavity": "cavity", "Material": "material", "Modes": "modes", "Noise": "added", "Partials": "added",
    "Table": "mesh", "can": "ring", "glass": "ring", "hertz": "material", "membrane": "disc",
}  # fmt: skip
"""The module of each name that is not its module's, too."""


def __getattr__(name: str) -> Any:
    home = f"{__name__}.{_HOMES.get(name, name)}"
    if name.startswith("_") or not find_spec(home):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(home), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


class _Package(ModuleType):
    """A package in which a name that a shape and its module have in common is the shape's."""

    def __setattr__(self, name: str, value: Any) -> None:
        """Set an attribute; importing a module sets its name."""
        super().__setattr__(name, getattr(value, name, value) if isinstance(value, ModuleType) else value)


sys.modules[__name__].__class__ = _Package
