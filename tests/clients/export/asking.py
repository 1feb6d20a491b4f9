"""A program that says what the library for C makes of messages (ask.c), and that library's rules."""

import json
from pathlib import Path
from typing import Any

_LIBRARY = Path(__file__).parents[3] / "clients" / "export" / "c"


def asking(folder: Path) -> list[str]:
    """Return a C compiler's words for ask.c with an exported scene's library, but for how, and what to write."""
    program = Path(__file__).parent / "ask.c"
    return ["-I", str(_LIBRARY), str(program), str(folder / "libcarom.a"), "-lm"]


def rules_of(folder: Path) -> dict[str, Any]:
    """Return what a folder's library is told of all scenes of its engine."""
    held = (folder / "libcarom.so").read_bytes()
    begin = held.index(b'{"quantum":')
    return dict(json.loads(held[begin : held.index(b"\0", begin)]))
