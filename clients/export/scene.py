"""A score, or a table of the page, as a baked scene that is ready to be written."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from ...dsp.errors import CaromError
from ...presets import Presets
from ...server.osc.score import Line
from ...server.render import Options
from .baking import Baked, bake
from .mapping import Strikers
from .packing import PageEngine, packed

TABLE = "# carom table"
"""The beginning of a score that a page has saved as a table."""

_PLACE = re.compile(r"^# at (\S+) (\S+) (\S+)", re.MULTILINE)
_TITLE = re.compile(rf"{TABLE}:? *(.*)")


class ExportError(CaromError, RuntimeError):
    """A scene that cannot be exported; the text says why."""


class Scene(NamedTuple):
    """A baked scene, with what its file says of it besides."""

    baked: Baked
    strikers: Strikers
    title: str
    places: dict[str, tuple[float, float]]
    """The places of a table's objects, from 0 to 1, by name."""

    def file(self, engine: PageEngine | None = None) -> bytes:
        """Return the scene's file; engine: the page's, if it is for a page."""
        return packed(self.baked, self.strikers, self.places, self.title, engine)


def bake_scene(
    score: Sequence[Line], text: str, name: str, presets: Presets, options: Options, warn: Callable[[str], object]
) -> Scene:
    """Render a score and return it baked.

    text: of the score, which says where the objects of a table lie. name: the title, if it has none.
    """
    strikers = Strikers(presets)
    baked = bake(score, presets, options, strikers.sounds(), warn)
    titled = _TITLE.match(text)
    return Scene(baked, strikers, (titled and titled[1]) or name, _places(text))


def made_folder(folder: Path) -> Path:
    """Return a folder for files, which is made if missing."""
    if folder.exists() and not folder.is_dir():
        raise ExportError(f"{folder}: expected a folder, and a file is there")
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _places(text: str) -> dict[str, tuple[float, float]]:
    """Return the places of a table's objects, from 0 to 1, by name."""
    found = {}
    for x, y, name in _PLACE.findall(text):
        place = float(x), float(y)
        if all(0.0 <= each <= 1.0 for each in place):
            found[name] = place
    return found
