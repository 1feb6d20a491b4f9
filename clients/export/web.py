"""A scene as a folder of static files that play in a browser."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path

from ...dsp.engine.memory.commands import Kind
from ...dsp.errors import CaromError
from ...dsp.native.wasm import data_end, wasm
from ...dsp.runtime import callback
from ...presets import Presets
from ...server.osc.score import Line
from ...server.render import Options
from .baking import Baked, bake
from .mapping import Strikers
from .packing import compressed, packed

TABLE = "# carom table"
"""The beginning of a score that a page has saved as a table."""

_PLACE = re.compile(r"^# at (\S+) (\S+) (\S+)", re.MULTILINE)
_TITLE = re.compile(rf"{TABLE}:? *(.*)")
_FILES = Path(__file__).parent / "web"

_ROOMS = {
    "space": ("carom.dsp.engine.output.space", "carom.dsp.engine.output.late."),
    "sensors": ("carom.dsp.engine.bodies.sensing.",),
    "plates that stretch": ("carom.dsp.karman.", "carom.dsp.engine.bodies.sheets."),
}
"""Parts of the engine that a scene may lack: the kernels that it does without."""


class ExportError(CaromError, RuntimeError):
    """A scene that cannot be exported; the text says why."""


def export(
    score: Sequence[Line], text: str, name: str, folder: Path, presets: Presets, options: Options,
    warn: Callable[[str], object],
) -> Baked:  # fmt: skip
    """Write a scene's files into a folder, which is made if missing, and return the scene, baked.

    text: of the score, which says where the objects of a table lie. name: the title, if it has none.
    """
    if folder.exists() and not folder.is_dir():
        raise ExportError(f"{folder}: expected a folder, and a file is there")
    strikers = Strikers(presets)
    baked = bake(score, presets, options, strikers.sounds(), warn)
    engine = wasm(callback.__name__, without(baked))
    titled = _TITLE.match(text)
    scene = packed(baked, strikers, _places(text), (titled and titled[1]) or name, data_end(engine))
    folder.mkdir(parents=True, exist_ok=True)
    for file in sorted(_FILES.iterdir()):
        if file.suffix != ".py":
            shutil.copyfile(file, folder / file.name)
    (folder / "carom.wasm.gz").write_bytes(compressed(engine))
    (folder / "scene.carom.gz").write_bytes(compressed(scene))
    return baked


def without(baked: Baked) -> list[str]:
    """Return the beginnings of the names of kernels that a scene does without."""
    kinds = {int(kind) for batch in baked.batches for kind in batch.commands["kind"]}
    has = {
        "space": bool(kinds & {Kind.POSE, Kind.LISTEN, Kind.FURNISH}),
        "sensors": Kind.MOUNT in kinds,
        "plates that stretch": any(obj.handle.sheet >= 0 for obj in baked.objects.values()),
    }
    return [kernels for room, names in _ROOMS.items() if not has[room] for kernels in names]


def _places(text: str) -> dict[str, tuple[float, float]]:
    """Return the places of a table's objects, from 0 to 1, by name."""
    found = {}
    for x, y, name in _PLACE.findall(text):
        place = float(x), float(y)
        if all(0.0 <= each <= 1.0 for each in place):
            found[name] = place
    return found
