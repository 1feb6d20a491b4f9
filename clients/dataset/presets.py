"""Presets each of whose files is read once: they do not change while a data set is made."""

from functools import cache

from ...presets import Presets


class _Remembered(Presets):
    material = cache(Presets.material)
    striker = cache(Presets.striker)
    surface = cache(Presets.surface)
    object = cache(Presets.object)


presets_of = cache(_Remembered)
"""Presets of a tuple of folders, the same for all who ask for them."""
