"""Portable code that came along with the package: one compressed file for each of the engine's sizes.

Few need it, so it is unpacked into the user's cache when it is first requested. It holds lists of modules and files of
units, as a store has them (`store.py`).
"""

import json
import struct
from functools import cache
from pathlib import Path
from typing import Any

from .. import sizes
from ..errors import NoCodeError
from . import store as stores
from .store import Listed, Store
from .targets import targets

_X86, _LZMA2, _XZ = 0x04, 0x21, 1  # of the module `lzma`, which is loaded where it is needed


def place(root: Path) -> Path:
    """Return the file, in a folder of compiled code."""
    return root / f"portable-{sizes.NAME}.xz"


class Carried:
    """Lists and files that are put together to be packed."""

    def __init__(self) -> None:
        self._lists: dict[str, tuple[str, Listed]] = {}
        self._units: list[tuple[str, str, str, bytes]] = []

    def add_list(self, module: str, key: str, listed: Listed) -> None:
        """Take a module's list."""
        self._lists[module] = key, listed

    def add_unit(self, key: str, what: str, kind: str, content: bytes) -> None:
        """Take a file of a unit."""
        self._units.append((key, what, kind, content))

    def packed(self) -> bytes:
        """Return all of it, compressed."""
        import lzma

        units = [(*named, len(content)) for *named, content in self._units]
        lists = {module: (key, listed._asdict()) for module, (key, listed) in self._lists.items()}
        said = json.dumps({"lists": lists, "units": units})
        content = struct.pack("<I", len(said)) + said.encode() + b"".join(each[-1] for each in self._units)
        filters: list[dict[str, Any]] = [{"id": _X86}, {"id": _LZMA2, "preset": 9 | lzma.PRESET_EXTREME}]
        return lzma.compress(content, _XZ, lzma.CHECK_CRC32, filters=filters)


def held() -> set[str]:
    """Return the targets of the code that came along. NoCodeError if the file cannot be read."""
    file = place(stores.PACKAGED)
    said = _read(file)[0] if file.exists() else {"lists": {}}
    return {target for _, listed in said["lists"].values() for target in listed["units"]}


def came_along() -> bool:
    """True if portable code came along, and plays here."""
    return targets()[0].is_portable and place(stores.PACKAGED).exists()


def unpacked(kept: Store) -> bool:
    """Write what came along into a store, once in a process; False where nothing did, or other code plays here.

    NoCodeError if the file cannot be read.
    """
    return came_along() and _unpack(place(stores.PACKAGED), kept.root)


@cache
def _unpack(file: Path, root: Path) -> bool:
    (said, content), kept, at = _read(file), Store(root), 0
    for key, what, kind, size in said["units"]:
        kept.write_unit(key, what, kind, content[at : at + size])
        at += size
    for module, (key, listed) in said["lists"].items():
        before = next((each.units for name, each in kept.lists(module) if name == key), {})
        kept.write_list(module, key, Listed(listed["sources"], {**before, **listed["units"]}))
    return True


def _read(file: Path) -> tuple[dict[str, Any], bytes]:
    """Return what the file says of itself, and the contents of its units' files, one after the other."""
    try:
        import lzma
    except ImportError as error:
        raise NoCodeError(f"{file}: to unpack it, Python needs its module lzma, which this one lacks") from error
    try:
        content = lzma.decompress(file.read_bytes())
    except (OSError, EOFError, lzma.LZMAError) as error:
        raise NoCodeError(f"{file}: this file is damaged ({error}); install Carom again") from error
    (length,) = struct.unpack_from("<I", content)
    return json.loads(content[4 : 4 + length]), content[4 + length :]
