"""A program that says what the library for C makes of messages (ask.c), and the map of a scene's file."""

import json
import struct
from pathlib import Path
from typing import Any

_LIBRARY = Path(__file__).parents[3] / "clients" / "export" / "c"


def asking(folder: Path) -> list[str]:
    """Return a C compiler's words for ask.c with an exported scene's library, but for how, and what to write."""
    layout = map_of((folder / "scene.carom").read_bytes())["layout"]
    program = Path(__file__).parent / "ask.c"
    return [f'-DLAYOUT="{layout}"', "-I", str(_LIBRARY), str(program), str(folder / "libcarom.a"), "-lm"]


def map_of(scene: bytes) -> dict[str, Any]:
    """Return the map in the bytes of a scene."""
    (size,) = struct.unpack("<I", scene[8:12])
    return dict(json.loads(scene[12 : 12 + size]))
