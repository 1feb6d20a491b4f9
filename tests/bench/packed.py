"""Sounds within archives of games: zip files (.pk3), and Qt's binary resources (.rcc).

A resource file has a header of big-endian words: "qres", its version, and where its tree, its data and its names begin.
A node of the tree (14 bytes, 22 from version 2 on) has the place of its name and flags; of a folder then follow how
many nodes it holds, and the first of these; of a file its country, its language, and the place of its data, which begin
with their size (Qt's rcc.cpp).
"""

import struct
import zipfile
from collections.abc import Iterator
from fnmatch import fnmatch
from io import BytesIO
from pathlib import Path

KINDS = ".pk3", ".rcc"
_FOLDER = 2  # a flag


def packed(root: Path, pattern: str) -> Iterator[BytesIO]:
    """Yield the files of a pattern ARCHIVE/PATTERN below a folder, by their names."""
    kind = next(kind for kind in KINDS if kind + "/" in pattern)
    archive, _, name = pattern.partition(kind + "/")
    path = root / (archive + kind)
    if path.exists():
        files = _zipped(path) if kind == ".pk3" else _resources(path)
        for found, data in sorted(files):
            if fnmatch(found, name):
                yield BytesIO(data)


def _zipped(path: Path) -> Iterator[tuple[str, bytes]]:
    with zipfile.ZipFile(path) as archive:
        for name in archive.namelist():
            yield name, archive.read(name)


def _resources(path: Path) -> Iterator[tuple[str, bytes]]:
    """Yield the files of Qt's resources, by their names without folders."""
    all_of = path.read_bytes()
    version, tree, data, names = struct.unpack_from(">4I", all_of, 4)
    size, nodes = 14 if version < 2 else 22, [0]
    while nodes:
        at = tree + nodes.pop() * size
        named, flags, count, first = struct.unpack_from(">IHII", all_of, at)
        if flags & _FOLDER:
            nodes.extend(range(first, first + count))
            continue
        (length,) = struct.unpack_from(">H", all_of, names + named)
        name = all_of[names + named + 6 : names + named + 6 + 2 * length].decode("utf-16-be")
        begin = data + first
        yield name, all_of[begin + 4 : begin + 4 + struct.unpack_from(">I", all_of, begin)[0]]
