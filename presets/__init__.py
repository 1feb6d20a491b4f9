"""Presets: materials, strikers, surfaces and objects as TOML files, scores as text, and their public face.

`Presets` finds them by name. `values` has the kinds of values, `schema` the keys of each kind of file, `kinds`
strikers, surfaces and objects, `making` the modes of objects and how they are kept, `library` the search through
folders.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .kinds import ObjectPreset, StrikerPreset, SurfacePreset
    from .library import BUILT_IN, KINDS, Presets
    from .schema import NoPreset, PresetError

__all__ = ["BUILT_IN", "KINDS", "NoPreset", "ObjectPreset", "PresetError", "Presets", "StrikerPreset", "SurfacePreset"]

_HOMES = {
    "library": ("BUILT_IN", "KINDS", "Presets"),
    "kinds": ("ObjectPreset", "StrikerPreset", "SurfacePreset"),
    "schema": ("NoPreset", "PresetError"),
}


def __getattr__(name: str) -> object:
    """Import a public name when it is first asked for: the shapes of objects need scipy, which is slow to load."""
    for module, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"{__name__}.{module}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
