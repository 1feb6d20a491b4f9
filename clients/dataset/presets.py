"""Presets each of whose files is read once: they do not change while a data set is made."""

from functools import cache, lru_cache

from ...presets import Presets


class _Remembered(Presets):
    material = cache(Presets.material)
    striker = cache(Presets.striker)
    surface = cache(Presets.surface)
    object = cache(Presets.object)
    changed = lru_cache(maxsize=512)(Presets.changed)  # type: ignore[assignment]


presets_of = cache(_Remembered)
"""Presets of a tuple of folders, the same for all who ask for them."""
