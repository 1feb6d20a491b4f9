"""Presets: materials, strikers, surfaces and objects as TOML files, scores as text, and their public face.

`Presets` finds them by name. `values` has the kinds of values, `schema` the keys of each kind of file, `kinds`
strikers, surfaces and objects, `making` the modes of objects and how they are kept, `library` the search through
folders.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..dsp.lazy import lazily

if TYPE_CHECKING:
    from .kinds import ObjectPreset, StrikerPreset, SurfacePreset
    from .library import BUILT_IN, KINDS, Presets
    from .schema import NoPreset, PresetError

__all__ = ["BUILT_IN", "KINDS", "NoPreset", "ObjectPreset", "PresetError", "Presets", "StrikerPreset", "SurfacePreset"]

__getattr__, __dir__ = lazily(
    __name__,
    {
        ".library": "BUILT_IN KINDS Presets",
        ".kinds": "ObjectPreset StrikerPreset SurfacePreset",
        ".schema": "NoPreset PresetError",
    },
)
"""The shapes of objects need scipy, which is slow to load."""
