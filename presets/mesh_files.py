"""Readers of mesh files that hold polygons: .obj, .stl, .ply. Each returns what a file says, or names what is wrong.

Sources: Wavefront's Object Files (.obj), appendix B1; 3D Systems' StereoLithography Interface Specification, 1989;
G. Turk, The PLY Polygon File Format, 1994.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from ..dsp.bodies.material import Array
from ..dsp.mesh.polygons import Polygons, require_indices
from ..dsp.mesh.surface import Indices, MeshError

_STL_HEAD, _STL_ROW = 84, 50  # bytes
_STL = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
_STREAMED = (0, 0xFFFFFFFF)  # counts of writers that don't know it before the end
_PLY = {
    **dict(zip(("char", "uchar", "short", "ushort", "int", "uint", "float", "double"),
               ("i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8"), strict=True)),
    **dict(zip(("int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"),
               ("i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8"), strict=True)),
}  # fmt: skip
_PLY_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">"}
_LEFT = 2  # bytes of an end of a line
_INDICES = ("vertex_indices", "vertex_index")


def _text(data: bytes) -> str | None:
    """Return the text of a file, its lines ended by \\n; None if its bytes are no text."""
    wide = data[:2] in (b"\xff\xfe", b"\xfe\xff")
    if b"\0" in data and not wide:
        return None
    text = data.decode("utf-16" if wide else "utf-8-sig", "replace")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def read_obj(where: str, data: bytes) -> Polygons:
    """Return the faces of an .obj file; its parts are those of an object, a group and a material."""
    text = _text(data)
    if text is None:
        raise MeshError(f"{where}: its bytes are no text: expected an .obj file")
    text = text.replace("\\\n", " ")
    points: list[tuple[float, ...]] = []
    corners: list[int] = []
    sizes: list[int] = []
    of: list[int] = []
    parts: dict[tuple[str, str, str], int] = {}
    own = {"o": "", "g": "", "usemtl": ""}
    lines: list[int] = []  # of each face
    for number, line in enumerate(text.split("\n"), 1):
        word, _, rest = (
            line.strip().partition(" ") if "\t" not in line else line.strip().replace("\t", " ").partition(" ")
        )
        if word == "v":
            points.append(_numbers(where, number, rest))
        elif word in ("f", "fo"):
            ring = [_index(where, number, each, len(points)) for each in rest.split("#")[0].split()]
            if len(ring) > 2:
                corners += ring
                sizes.append(len(ring))
                lines.append(number)
                of.append(parts.setdefault((own["o"], own["g"], own["usemtl"]), len(parts)))
        elif word in own:
            own[word] = rest.strip()
            if word == "o":
                own["g"] = ""
    every = np.array(corners, np.int64)
    wrong = np.flatnonzero(every >= len(points))
    if len(wrong):
        line_number = lines[int(np.searchsorted(np.cumsum(sizes), wrong[0], side="right"))]
        raise MeshError(
            f"{where}: line {line_number}: a face of point {every[wrong[0]] + 1}: expected 1 to {len(points)}"
        )
    if not sizes and re.search(r"^(surf|curv)", text, re.MULTILINE):
        raise MeshError(f"{where}: free-form surfaces alone: expected polygons; export it as a mesh")
    names = tuple(tuple(dict.fromkeys(each for each in part if each)) for part in parts)
    return Polygons(
        np.array(points, float).reshape(-1, 3), every, np.array(sizes, np.int64), np.array(of, np.int64), names
    )


def _numbers(where: str, number: int, text: str) -> tuple[float, ...]:
    try:
        x, y, z = map(float, text.split()[:3])
    except ValueError:
        raise MeshError(f"{where}: line {number}: v {text.strip()[:60]!r}: expected three numbers") from None
    return x, y, z


def _index(where: str, number: int, text: str, count: int) -> int:
    """Return the number, from 0 on, of a corner's point: they count from 1, or back from the last point before."""
    try:
        said = int(text.partition("/")[0])
    except ValueError:
        raise MeshError(f"{where}: line {number}: a face of {text[:40]!r}: expected the numbers of points") from None
    if said == 0 or said < -count:
        back = f", or -1 to -{count} back from the last one before the face" if count else ""
        also = "; the file counts from 0, and must count from 1" if said == 0 else ""
        raise MeshError(f"{where}: line {number}: a face of point {said}: expected 1 and above{back}{also}")
    return said - 1 if said > 0 else count + said


def read_stl(where: str, data: bytes) -> Polygons:
    """Return the triangles of an .stl file, of bytes or of text."""
    text = _text(data)
    if text is not None and text.lstrip()[:5].lower() == "solid" and "vertex" in text.lower():
        return _read_text_stl(where, text)
    if len(data) < _STL_HEAD:
        raise MeshError(f"{where}: {len(data)} bytes: expected a whole .stl file, of {_STL_HEAD} at least")
    said = int.from_bytes(data[80:_STL_HEAD], "little")
    there, rest = divmod(len(data) - _STL_HEAD, _STL_ROW)
    count = there if said in _STREAMED else said
    if count > there:
        raise MeshError(
            f"{where}: cut short: {there:,} of its triangles are there: expected the {said:,} that its header announces"
        )
    if count < there and not rest:
        raise MeshError(f"{where}: {there:,} triangles: expected the {said:,} that its header announces")
    points = np.frombuffer(data, _STL, count, _STL_HEAD)["corners"].reshape(-1, 3).astype(float)
    return _soup(points, np.full(count, 3, np.int64))


def _read_text_stl(where: str, text: str) -> Polygons:
    found = re.findall(r"vertex[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)|(endloop)", text, re.IGNORECASE)
    ends = np.flatnonzero([bool(each[3]) for each in found])
    begun = len(re.findall(r"^\s*facet\b", text, re.IGNORECASE | re.MULTILINE))
    if len(found) and (not len(ends) or ends[-1] != len(found) - 1 or begun > len(ends)):
        raise MeshError(f"{where}: cut short: its last facet has no endloop")
    try:
        points = np.array([each[:3] for each in found if not each[3]]).astype(float)
    except ValueError as error:
        raise MeshError(f"{where}: a vertex that is no number: expected three numbers ({error})") from None
    sizes = np.diff(np.r_[-1, ends]) - 1
    return _soup(points.reshape(-1, 3), sizes)


def _soup(points: Array, sizes: Indices) -> Polygons:
    """Return faces that share no points."""
    return Polygons(points, np.arange(len(points)), sizes, np.zeros(len(sizes), np.int64), ((),))


class _Rows:
    """The values of a .ply file's body, taken one after the other."""

    def __init__(self, where: str, body: bytes, order: str | None) -> None:
        self.where, self.body, self.order, self.at = where, body, order, 0
        self.words = body.split() if order is None else []

    def take(self, kind: str, count: int) -> Array:
        """Return the next values (count,) of a kind."""
        if self.order is None:
            words = self.words[self.at : self.at + count]
            try:
                values = np.array(words, "S").astype(float) if words else np.zeros(0)
            except ValueError as error:
                raise MeshError(f"{self.where}: expected numbers ({error})") from None
            used = count
        else:
            own = np.dtype(self.order + kind)
            values = np.frombuffer(
                self.body, own, min(count, max(0, len(self.body) - self.at) // own.itemsize), self.at
            )
            used = count * own.itemsize
        if len(values) < count:
            raise MeshError(f"{self.where}: cut short: its header announces more data than the file holds")
        self.at += used
        return values

    def require_end(self) -> None:
        """Raise MeshError if more follows than an end of a line."""
        left, what = (
            (len(self.words) - self.at, "numbers") if self.order is None else (len(self.body) - self.at, "bytes")
        )
        if left > _LEFT:
            raise MeshError(f"{self.where}: {left:,} {what} follow the rows that its header announces: expected none")

    def alike(self, kinds: list[tuple[str, str]], count: int) -> list[Array] | None:
        """Return the columns of the next rows if their lists are all as long as the first row's; else None, and
        nothing is taken. kinds: those of a list's length and of its values, or "" and that of a value."""
        begin, widths = self.at, []
        for length, kind in kinds:
            widths.append(int(self.take(length, 1)[0]) if length else 1)
            if not 0 <= widths[-1] < 1 << 24:
                raise MeshError(f"{self.where}: a list of {widths[-1]} values: expected a count from 0 on")
            self.take(kind, widths[-1])
        self.at = begin
        if self.order is None:
            wide = sum(widths) + sum(bool(length) for length, _ in kinds)
            if len(self.words) - begin < wide * count:
                return None
            rows = self.take("f8", wide * count).reshape(count, wide)
            split = np.cumsum([part for (length, _), width in zip(kinds, widths, strict=True)
                               for part in ((1, width) if length else (width,))])  # fmt: skip
            columns = np.split(rows, split[:-1], axis=1)
        else:
            parts = [
                (self.order + each, (wide,))
                for (length, kind), width in zip(kinds, widths, strict=True)
                for each, wide in (((length, 1), (kind, width)) if length else ((kind, width),))
            ]
            row = np.dtype([(str(number), *each) for number, each in enumerate(parts)])
            if len(self.body) - begin < row.itemsize * count:
                return None
            table: Any = np.frombuffer(self.body, row, count, begin)
            columns = [table[name] for name in row.names or ()]
            self.at = begin + row.itemsize * count
        values = []
        for (length, _), width in zip(kinds, widths, strict=True):
            if length and (columns.pop(0) != width).any():
                self.at = begin
                return None
            values.append(columns.pop(0))
        return values


def read_ply(where: str, data: bytes) -> Polygons:
    """Return the faces of a .ply file, of text or of bytes in either order."""
    head, end, body = data.partition(b"end_header")
    lines = [line.split() for line in head.decode("ascii", "replace").splitlines()]
    if data[:3] != b"ply" or not end:
        raise MeshError(f"{where}: begins with {data[:8]!r}: expected ply, and a head that ends in end_header")
    _require_counts(where, head, body)
    body = body[2:] if body[:2] == b"\r\n" else body[1:]
    form = next((line[1] for line in lines if line[:1] == ["format"] and len(line) > 1), "")
    if form != "ascii" and form not in _PLY_ORDERS:
        raise MeshError(f"{where}: format {form}: expected ascii, {' or '.join(_PLY_ORDERS)}")
    rows = _Rows(where, body, _PLY_ORDERS.get(form))
    points, corners, sizes = np.zeros((0, 3)), np.zeros(0, np.int64), np.zeros(0, np.int64)
    for name, count, kinds, names in _elements(where, lines):
        if name == "tristrips":
            raise MeshError(f"{where}: strips of triangles: expected faces; export it again as triangles")
        if not count or not kinds:
            continue
        wanted = next((names.index(each) for each in _INDICES if each in names), -1)
        values = rows.alike(kinds, count)
        if values is None:
            lists = [[rows.take(kind, int(rows.take(length, 1)[0]) if length else 1) for length, kind in kinds]
                     for _ in range(count)]  # fmt: skip
            if name == "face" and wanted >= 0:
                corners = np.concatenate([row[wanted] for row in lists]).astype(np.int64)
                sizes = np.array([len(row[wanted]) for row in lists], np.int64)
        elif name == "face" and wanted >= 0:
            corners, sizes = values[wanted].astype(np.int64).ravel(), np.full(count, values[wanted].shape[1])
        if name == "vertex" and values is not None:
            if not set("xyz") <= set(names):
                raise MeshError(f"{where}: vertex of {', '.join(names)}: expected x, y and z")
            points = np.concatenate([values[names.index(axis)] for axis in "xyz"], axis=1).astype(float)
    require_indices(where, corners, len(points))
    rows.require_end()
    return Polygons(points, corners, sizes, np.zeros(len(sizes), np.int64), ((),))


def _elements(where: str, lines: list[list[str]]) -> Iterator[tuple[str, int, list[tuple[str, str]], list[str]]]:
    """Give the name, the count, and the kinds and names of the properties of each element that a head counts."""
    starts = [number for number, line in enumerate(lines) if line[:1] == ["element"]]
    for start, end in zip(starts, [*starts[1:], len(lines)], strict=True):
        kinds, names = [], []
        for line in lines[start + 1 : end]:
            if line[:1] != ["property"]:
                continue
            given = line[2:4] if line[1:2] == ["list"] else line[1:2]
            if len(line) < len(given) + 2 or any(each not in _PLY for each in given):
                raise MeshError(
                    f"{where}: {' '.join(line)[:80]}: expected a type and a name, or list, two types and a name"
                )
            kinds.append((_PLY[given[0]], _PLY[given[1]]) if len(given) == 2 else ("", _PLY[given[0]]))
            names.append(line[-1])
        yield lines[start][1], int(lines[start][2]), kinds, names


def _require_counts(where: str, head: bytes, body: bytes) -> None:
    """Raise MeshError for a .ply file whose head counts less than nothing, or more rows of text than there are."""
    said = re.findall(rb"^element\s+(\S+)\s+(\S+)", head, re.MULTILINE)
    counts = [int(count) if count.isdigit() and len(count) < 19 else -1 for _, count in said]  # of 64 bits
    for (name, count), number in zip(said, counts, strict=True):
        if number < 0:
            raise MeshError(f"{where}: element {name.decode(errors='replace')} {count[:20].decode(errors='replace')}: "
                            "expected a count from 0 on")  # fmt: skip
    rows = sum(1 for line in body.splitlines() if line.strip()) if b"format ascii" in head else sum(counts)
    if rows < sum(counts):
        raise MeshError(f"{where}: {rows} rows: expected the {sum(counts)} that its header announces")


READERS: dict[str, Callable[[str, bytes], Any]] = {".obj": read_obj, ".stl": read_stl, ".ply": read_ply}
"""Readers of files by their ending: each takes the file's name for errors, and its bytes."""
