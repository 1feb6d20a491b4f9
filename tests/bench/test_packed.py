"""Sounds within archives of games, of bytes that are laid out here."""

import struct
import zipfile
from pathlib import Path

from .packed import packed


def resources(version: int, files: dict[str, bytes]) -> bytes:
    """Return Qt's resources of files in one folder."""
    names, data, tree = b"", b"", struct.pack(">IHII", 0, 2, 1, 1) + struct.pack(">IHII", 0, 2, len(files), 2)
    stamp = b"" if version < 2 else bytes(8)
    nodes = [tree[:14] + stamp, tree[14:] + stamp]
    all_of: dict[str, bytes | None] = {"sounds": None, **files}
    for name, content in all_of.items():
        at = len(names)
        names += struct.pack(">HI", len(name), 0) + name.encode("utf-16-be")
        if content is not None:
            nodes.append(struct.pack(">IHHHI", at, 0, 0, 1, len(data)) + stamp)
            data += struct.pack(">I", len(content)) + content
    begin = 20 + len(data)
    return b"qres" + struct.pack(">4I", version, begin + len(names), 20, begin) + data + names + b"".join(nodes)


def test_resources_of_both_versions_are_read(tmp_path: Path) -> None:
    for version in (1, 2):
        (tmp_path / "a.rcc").write_bytes(resources(version, {"two.ogg": b"22", "one.ogg": b"1", "one.txt": b"-"}))
        assert [found.read() for found in packed(tmp_path, "a.rcc/*.ogg")] == [b"1", b"22"]
    assert list(packed(tmp_path, "b.rcc/*.ogg")) == []


def test_zip_files_are_read(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "a.pk3", "w") as archive:
        for name in ("sound/two.ogg", "sound/one.ogg", "other/one.ogg"):
            archive.writestr(name, name)
    assert [found.read() for found in packed(tmp_path, "a.pk3/sound/*.ogg")] == [b"sound/one.ogg", b"sound/two.ogg"]
