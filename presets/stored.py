"""The modes of presets on disk, and the tables of those that come in all sizes: to read them takes less time than to
make them.

    modes/KEY        a hash of what follows, then the modes, pickled

KEY is a hash of what they are made of, of the sources that make them, of the libraries these call, and of the machine,
as processors round differently. Files appear whole, whoever reads them at the same time. One that is damaged is none.
"""

import hashlib
import os
import pickle
import platform
import sys
import tempfile
from collections.abc import Hashable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path

import numpy as np
import platformdirs

from ..dsp.bodies.modes import Modes
from ..dsp.bodies.similar_table import Store

MOST_BYTES = 128_000_000
"""Bytes on disk before what was not read for longest goes: at 48 kHz the modes of all presets take 13 MB, the tables of
those of the recipe `impacts`, in sizes of 0.8 to 1.25, another 28 MB."""

_DSP = Path(__file__).parents[1] / "dsp"
_HASHED = 16  # bytes of a hash


def folder() -> Path:
    """Return the folder of the files."""
    return platformdirs.user_cache_path("carom") / "modes"


def read(key: Hashable) -> Modes | None:
    """Return the modes that were written by a key."""
    file = _file(key)
    try:
        content = file.read_bytes()
        os.utime(file)
    except OSError:
        return None
    if _hash(content[_HASHED:]) != content[:_HASHED]:
        return None
    found = pickle.loads(content[_HASHED:])
    return found if isinstance(found, Modes) else None


def write(key: Hashable, modes: Modes) -> None:
    """Write modes by a key, if there is room: what was not read for longest goes."""
    content = pickle.dumps(modes, pickle.HIGHEST_PROTOCOL)
    file = _file(key)
    with suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=file.parent, delete=False) as partly:
            partly.write(_hash(content) + content)
        os.replace(partly.name, file)
        _make_room(file.parent)


STORE = Store(read, write)
"""The store of the tables of bodies in all sizes."""


def _make_room(root: Path) -> None:
    """Remove what was not read for longest."""
    used = 0
    for _, size, file in sorted(((told.st_mtime, told.st_size, entry) for entry, told in _told(root)), reverse=True):
        used += size
        if used > MOST_BYTES:
            Path(file).unlink(missing_ok=True)


def _told(root: Path) -> Iterator[tuple[str, os.stat_result]]:
    """Yield the files of a folder, and what the system says of each."""
    with os.scandir(root) as entries:
        for entry in entries:
            with suppress(FileNotFoundError):
                yield entry.path, entry.stat()


def _file(key: Hashable) -> Path:
    return folder() / _hash(_makers() + pickle.dumps(key, pickle.HIGHEST_PROTOCOL)).hex()


def _hash(content: bytes) -> bytes:
    return hashlib.blake2b(content, digest_size=_HASHED).digest()


@cache
def _makers() -> bytes:
    """Return a hash of all that modes are made by."""
    own = [Path(__file__).with_name(name) for name in ("making.py", "settled.py", "settled.npz")] + [_DSP / "sizes.py"]
    for package in ("bodies", "karman", "numerics"):
        own += sorted((_DSP / package).rglob("*.py"))
    found = hashlib.blake2b(f"{sys.version} {np.__version__} {platform.node()}".encode())
    for file in own:
        with suppress(OSError):
            found.update(file.read_bytes())
    return found.digest()
