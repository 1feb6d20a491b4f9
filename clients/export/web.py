"""A scene as a folder of static files that play in a browser."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Sequence
from pathlib import Path

from ...dsp.engine.memory.commands import Kind
from ...dsp.native.digests import digest
from ...dsp.native.wasm import data_end, wasm, with_note
from ...dsp.runtime import callback
from ...server.bridge import touching
from .baking import Baked
from .mapping import layout, rules
from .packing import PageEngine, compressed
from .parting import parted
from .scene import Scene

_FILES = Path(__file__).parent / "web"

_ROOMS = {
    "space": ("carom.dsp.engine.output.space", "carom.dsp.engine.output.late."),
    "sensors": ("carom.dsp.engine.bodies.sensing.",),
    "plates that stretch": ("carom.dsp.karman.", "carom.dsp.engine.bodies.sheets."),
    "swarms": ("carom.dsp.engine.contacts.swarms.", "carom.dsp.engine.bodies.strikers.sound_grains."),
}
"""Parts of the engine that a scene may lack: the kernels that it does without."""

WORKLET = ("messages.js", "bodies.js", "scene.js", "worklet.js")
"""The scripts of the audio thread, each after those that it imports: a page has them as one file."""

_NAME = "carom"
"""The section of a module that has the engine's rules and its name; `carom.js` reads it."""

_COMMENT = re.compile(r"(?<=[;,{}]) // [^\"'`]*$")
"""A comment that ends a line of a script."""


def write_page(scene: Scene, folder: Path) -> None:
    """Write a scene's files into a folder that is there."""
    code, engine = engine_for(scene.baked)
    for file in sorted(_FILES.iterdir()):
        if file.suffix == ".js" and file.name not in WORKLET:
            (folder / file.name).write_text(shortened(file.read_text(encoding="utf-8")), encoding="utf-8")
        elif file.suffix not in (".js", ".py"):
            shutil.copyfile(file, folder / file.name)
    if scene.baked.session.simulation:
        (folder / "touch.wasm.lzma").write_bytes(compressed(parted(tracker())))
    (folder / "worklet.js.lzma").write_bytes(compressed(joined(WORKLET).encode()))
    (folder / "carom.wasm.lzma").write_bytes(compressed(parted(code)))
    (folder / "scene.carom.lzma").write_bytes(compressed(scene.file(engine), words=True))


def engine_for(baked: Baked) -> tuple[bytes, PageEngine]:
    """Return the WebAssembly of the engine that plays a scene, and how it is named, there and in the scene."""
    lacking = without(baked)
    code = wasm(callback.__name__, lacking)
    end = data_end(code)
    name = digest(f"{layout()} {lacking} {end}")
    told = {**rules(), "engine": name, "data_end": end}
    return with_note(code, _NAME, json.dumps(told, separators=(",", ":"))), PageEngine(name)


def tracker() -> bytes:
    """Return the WebAssembly of what finds blows and slides of bodies, with where its data end."""
    code = wasm(touching.__name__)
    return with_note(code, _NAME, json.dumps({"data_end": data_end(code)}))


def shortened(script: str) -> str:
    """Return a script without its indents and comments. Strings have one line, and no comment in them."""
    first, *lines = (_COMMENT.sub("", line.strip()) for line in script.splitlines())
    return "\n".join([first, *(each for each in lines if each and not each.startswith(("//", "/**")))]) + "\n"


def joined(names: Sequence[str]) -> str:
    """Return scripts that import from each other alone as one, shortened."""
    lines = [line for name in names for line in shortened((_FILES / name).read_text(encoding="utf-8")).splitlines()]
    return "\n".join(line for line in lines if not line.startswith("import ")) + "\n"


def without(baked: Baked) -> list[str]:
    """Return the beginnings of the names of kernels that a scene does without."""
    kinds = {int(kind) for batch in baked.batches for kind in batch.commands["kind"]}
    has = {
        "space": bool(kinds & {Kind.POSE, Kind.LISTEN, Kind.FURNISH}),
        "sensors": Kind.MOUNT in kinds,
        "plates that stretch": baked.engine.had_plates,
        "swarms": baked.engine.pulses.reached > 0,
    }
    return [kernels for room, names in _ROOMS.items() if not has[room] for kernels in names]
