"""Hostile files: presets, scores, meshes, tables, sounds and MIDI, cut, swapped, and with numbers that can't be."""

import io
import random
import re
import struct
import tempfile
from collections.abc import Callable, Iterator
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

import numpy as np
import soundfile

from carom.clients.recordings import read as read_recording
from carom.dsp.errors import CaromError
from carom.presets import BUILT_IN, Presets
from carom.presets.gltf import glb_of
from carom.presets.gltf_tables import model_bytes
from carom.presets.meshes import read_parts
from carom.presets.tables import table_of
from carom.server.osc import score, wire
from carom.server.osc.wire import Message
from tests.attack import Tried, kind
from tests.attack.children import Child, Died
from tests.attack.extremes import NUMBERS

_SECONDS = 20
_TOKENS = (b"-1", b"0", b"4294967295", b"-2147483648", b"1e999", b"nan", b"5e-324", b"1e308", b"", b"[", b'"', b"\xff")
_WORD = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE]-?\d+)?")
_SCORES = Path(BUILT_IN) / "scores"


class File(NamedTuple):
    """A valid file: its name, its bytes, and the function of its path that reads it."""

    name: str
    data: bytes
    read: Callable[[Path], object]


@kind("files", 150)
def files(chance: random.Random) -> Iterator[Tried]:
    """A mutated file, or a valid one whose numbers were changed, that is read."""
    known = valid()
    with Child() as child, tempfile.TemporaryDirectory() as folder:
        while True:
            file = chance.choice(known)
            path = Path(folder) / file.name
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(mutated(chance, file.data))
            try:
                refused = child.run(read, file.read, path, cpu=_SECONDS)
                silent = (f"{file.name}: a refusal that says nothing",) if refused == "" else ()
                yield Tried(int(bool(refused)), int(refused is None), silent)
            except Died as died:
                yield Tried(faults=(f"{died}: {kept(path)}",))


def kept(path: Path) -> Path:
    """Keep a file that did harm, and return where."""
    data = path.read_bytes()
    place = Path(tempfile.gettempdir()) / "carom-attack" / sha256(data).hexdigest()[:8] / path.name
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_bytes(data)
    return place


def read(how: Callable[[Path], object], path: Path) -> str | None:
    """Read a file; return the error that says what is wrong with it, None if there is none."""
    try:
        how(path)
    except CaromError as error:
        return str(error)
    return None


def mutated(chance: random.Random, data: bytes) -> bytes:
    """Return bytes that were cut, swapped or doubled, or in which numbers became others."""
    found = bytearray(data)
    for _ in range(chance.choice((1, 1, 1, 2, 4))):
        at, what = chance.randrange(len(found) or 1), chance.randrange(8)
        if what < 3:  # a word of a text, or of a header
            words = list(_WORD.finditer(found[:200_000])) or [None]
            if word := chance.choice(words):
                found[word.start() : word.end()] = chance.choice(_TOKENS)
        elif what == 3:
            found[at : at + 1] = bytes([chance.randrange(256)])
        elif what == 4:
            del found[at:]
        elif what == 5:
            del found[at : at + chance.choice((1, 4, 100))]
        elif what == 6:
            found[at : at + 4] = struct.pack("<i", chance.choice((-1, 0, 1, 2**31 - 1, -(2**31))))
        else:
            with_float = chance.choice([each for each in NUMBERS if isinstance(each, float)])
            found[at : at + 8] = struct.pack("<d", with_float)
        found = found or bytearray(b"\0")
    return bytes(found)


@cache
def valid() -> list[File]:
    """Return valid files of all kinds."""
    found = [File("a.txt", path.read_bytes(), score.read) for path in sorted(_SCORES.glob("*.txt"))[:6]]
    packet = wire.encode_bundle(1, [Message("/object/new", ("a", "wine-glass")), Message("/object/a/impact", (1.0,))])
    found.append(File("a.osc", 3 * (len(packet).to_bytes(4, "big") + packet), score.read))
    for folder in ("objects", "strikers", "surfaces", "materials"):
        for path in sorted((Path(BUILT_IN) / folder).glob("*.toml"))[::7]:
            found.append(File(f"{folder}/{path.name}", path.read_bytes(), load))
    return [*found, *meshes(), *tables(), *sounds()]


def load(path: Path) -> None:
    """Load a preset of the kind that its folder's name says."""
    preset = Presets().load(path.parent.name, path)
    if path.parent.name == "objects":
        preset.modes(2_000.0)  # type: ignore[union-attr]


def meshes() -> Iterator[File]:
    """Yield a tetrahedron in each format."""
    points = np.array([(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)], np.float32)
    faces = np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], np.int32)
    head = "ply\nformat {} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    head += "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    rows = "".join(f"{x:g} {y:g} {z:g}\n" for x, y, z in points.tolist())
    yield File("a.ply", (head.format("ascii") + rows + "".join(f"3 {a} {b} {c}\n" for a, b, c in faces)).encode(), mesh)
    packed = points.tobytes() + b"".join(struct.pack("<B3i", 3, *face) for face in faces.tolist())
    yield File("b.ply", head.format("binary_little_endian").encode() + packed, mesh)
    lines = "".join(f"v {row}\n" for row in rows.splitlines())
    yield File("a.obj", (lines + "".join(f"f {a} {b} {c}\n" for a, b, c in faces + 1)).encode(), mesh)
    triangles = b"".join(bytes(12) + points[face].tobytes() + bytes(2) for face in faces)
    yield File("a.stl", bytes(80) + struct.pack("<I", len(faces)) + triangles, mesh)
    mug = Presets().object("mug")
    yield File("a.glb", glb_of("mug", mug.geometry["table"], mug.material), mesh)  # type: ignore[arg-type]
    yield File("b.glb", glb_of("mug", mug.geometry["table"], mug.material), model)  # type: ignore[arg-type]


def mesh(path: Path) -> None:
    """Read a mesh."""
    read_parts(path, 1.0)


def model(path: Path) -> None:
    """Read a modal model."""
    data = model_bytes(path.read_bytes(), str(path), Presets().material("steel"))
    if data:
        table_of(data, str(path))


def tables() -> Iterator[File]:
    """Yield a table of modes."""
    yield File("a.npz", (Path(BUILT_IN) / "objects" / "goblet.npz").read_bytes(), table)


def table(path: Path) -> None:
    """Read a table of modes."""
    table_of(path.read_bytes(), str(path))


def sounds() -> Iterator[File]:
    """Yield a sound in two formats."""
    sound = np.sin(np.arange(2000) / 10.0) * np.exp(-np.arange(2000) / 300.0)
    for format, subtype in (("WAV", "FLOAT"), ("FLAC", "PCM_24")):
        memory = io.BytesIO()
        soundfile.write(memory, sound, 44_100, format=format, subtype=subtype)
        yield File(f"a.{format.lower()}", memory.getvalue(), read_recording)
