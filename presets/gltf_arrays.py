"""glTF files as they lie on disk: JSON, buffers, and the arrays in them, however these are packed.

Source: Khronos, glTF 2.0 Specification, section 3.6; KHR_mesh_quantization; EXT_meshopt_compression.
"""

from __future__ import annotations

import base64
import binascii
import json
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
import numpy.typing as npt

from ..dsp.mesh.surface import MeshError

MAGIC, VERSION, JSON, BIN = b"glTF", 2, 0x4E4F534A, 0x004E4942
KINDS: dict[int, str] = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")
_EXPONENTS = "EXPONENTIAL"
_MOST = 1 << 28  # values of an array

Numbers = npt.NDArray[Any]


class Document:
    """A glTF file: what its JSON says, and its buffers. Errors are MeshErrors that begin with `where`."""

    def __init__(self, where: str, data: bytes, folder: Path | None = None) -> None:
        """data: of a .glb or a .gltf file. folder: where files lie that it names; None: it may name none."""
        self.where, self.folder = where, folder
        self._own = b""
        try:
            self.said = self._chunks(data) if data[:4] == MAGIC else json.loads(data)
        except MeshError:
            raise
        except (ValueError, struct.error) as error:
            raise self.error(f"expected JSON, as all glTF files hold ({error})") from None
        if not isinstance(self.said, dict):
            raise self.error("expected a JSON object")
        version = str(self.at(self.said.get("asset", {}), "version", "2.0"))
        if not version.startswith("2."):
            raise self.error(f"asset.version = {version}: expected 2.0; export it again, as glTF 2.0")
        self._buffers: dict[int, bytes] = {}

    def error(self, text: str) -> MeshError:
        """Return an error of this file."""
        return MeshError(f"{self.where}: {text}")

    def _chunks(self, data: bytes) -> Any:
        """Return what a .glb file says, and keep its buffer."""
        (version,) = struct.unpack_from("<I", data, 4)
        if version != VERSION:
            raise self.error(f"a .glb file of version {version}: expected {VERSION}")
        found: dict[int, bytes] = {}
        at = 12
        while at + 8 <= len(data):
            size, kind = struct.unpack_from("<II", data, at)
            if at + 8 + size > len(data):
                raise self.error(f"cut short: {len(data)} bytes: expected {at + 8 + size} at least")
            found.setdefault(kind, data[at + 8 : at + 8 + size])
            at += 8 + size
        if JSON not in found:
            raise self.error("it holds no JSON: expected a whole .glb file")
        self._own = found.get(BIN, b"")
        return json.loads(found[JSON])

    @staticmethod
    def at(values: Any, key: str, usual: Any) -> Any:
        """Return a value of a JSON object; the usual one if it has none."""
        return values.get(key, usual) if isinstance(values, Mapping) else usual

    def listed(self, kind: str, number: Any) -> dict[str, Any]:
        """Return one of the file's accessors, bufferViews, meshes, nodes and so on."""
        every = self.said.get(kind, [])
        if not isinstance(number, int) or isinstance(number, bool) or not 0 <= number < len(every):
            raise self.error(f"{kind} has no number {number!r}: expected 0 to {len(every) - 1}")
        found = every[number]
        if not isinstance(found, dict):
            raise self.error(f"{kind}[{number}] = {str(found)[:40]}: expected an object")
        return found

    def whole(self, values: Mapping[str, Any], key: str, usual: int, least: int = 0) -> int:
        """Return a whole number of a JSON object."""
        found = values.get(key, usual)
        if not isinstance(found, int) or isinstance(found, bool) or not least <= found <= _MOST * 16:
            raise self.error(f"{key} = {found!r}: expected a whole number from {least} on")
        return found

    def buffer(self, number: int) -> bytes:
        """Return a buffer's bytes: the file's own, written in its JSON, or of a file beside it."""
        if number not in self._buffers:
            uri = self.listed("buffers", number).get("uri")
            self._buffers[number] = self._own if uri is None else self._named(str(uri))
        return self._buffers[number]

    def _named(self, uri: str) -> bytes:
        if uri.startswith("data:"):
            try:
                return base64.b64decode(uri.partition(",")[2])
            except (ValueError, binascii.Error) as error:
                raise self.error(f"a buffer in its JSON: expected base64 ({error})") from None
        if self.folder is None:
            raise self.error(f"a buffer in {uri!r}: expected none beside the file")
        path = (self.folder / unquote(uri)).resolve()
        if "://" in uri or not path.is_relative_to(self.folder.resolve()):
            raise self.error(f"a buffer in {uri!r}: expected a file in its folder")
        try:
            return path.read_bytes()
        except OSError as error:
            raise self.error(f"its buffer {uri}: {error.strerror}") from None

    def view(self, number: Any) -> tuple[bytes, int]:
        """Return the bytes of a bufferView, unpacked, and its stride; 0 if it has none."""
        view = self.listed("bufferViews", number)
        packed = next((each for each in MESHOPT if each in self.at(view, "extensions", {})), None)
        if packed:
            return self._unpacked(packed, view["extensions"][packed])
        begin, size = self.whole(view, "byteOffset", 0), self.whole(view, "byteLength", -1)
        held = self.buffer(self.whole(view, "buffer", -1))
        if begin + size > len(held):
            raise self.error(f"cut short: bufferViews[{number}] ends at byte {begin + size} of {len(held)}")
        return held[begin : begin + size], self.whole(view, "byteStride", 0)

    def _unpacked(self, name: str, packed: Mapping[str, Any]) -> tuple[bytes, int]:
        """Return the bytes of a bufferView that meshoptimizer packed, and its stride."""
        try:
            from meshoptimizer import decoder
        except ImportError:
            raise self.error(
                f"packed by {name}: pip install 'carom[meshopt]' (it compiles C++), or export it without, or unpack "
                f"it: gltfpack -i {Path(self.where).name} -o plain.glb -noq"
            ) from None
        count, stride = self.whole(packed, "count", -1), self.whole(packed, "byteStride", -1, 1)
        begin, size = self.whole(packed, "byteOffset", 0), self.whole(packed, "byteLength", -1)
        mode, sieve = packed.get("mode"), packed.get("filter", "NONE")
        data = np.frombuffer(self.buffer(self.whole(packed, "buffer", -1))[begin : begin + size], np.uint8)
        if (
            sieve not in (("NONE", _EXPONENTS) if stride % 4 == 0 else ("NONE",))
            or mode not in ("ATTRIBUTES", "TRIANGLES", "INDICES")
            or count * stride > _MOST * 4
        ):
            raise self.error(
                f"{name} of mode {mode}, filter {sieve}: expected ATTRIBUTES, TRIANGLES or INDICES, no filter but "
                f"{_EXPONENTS}"
            )
        try:
            if mode == "ATTRIBUTES":
                rows = decoder.decode_vertex_buffer(count, stride, data, np.dtype((np.void, stride))).tobytes()
                if sieve == _EXPONENTS:
                    bits = np.frombuffer(rows, "<i4")  # an exponent of 8 bits, and a mantissa of 24
                    rows = np.ldexp((bits << 8 >> 8).astype("<f4"), bits >> 24).astype("<f4").tobytes()
                return rows, stride
            decode = decoder.decode_index_buffer if mode == "TRIANGLES" else decoder.decode_index_sequence
            return decode(count, 4, data).astype(f"<u{stride}").tobytes(), 0
        except (RuntimeError, ValueError, TypeError) as error:
            raise self.error(f"packed by {name}: {error}") from None

    def array(self, number: Any, as_stored: bool = False) -> Numbers:
        """Return an accessor's values (n,) or (n, width); those that are normalised as shares, unless they are wanted
        as they are stored."""
        said = self.listed("accessors", number)
        count = self.whole(said, "count", -1, 1)
        width = WIDTHS.get(str(said.get("type")))
        kind = KINDS.get(said.get("componentType", 0))
        if width is None or kind is None or count * width > _MOST:
            kinds = f"{', '.join(WIDTHS)}, of {min(KINDS)} to {max(KINDS)}"
            text = f"{count} of type {said.get('type')}, componentType {said.get('componentType')}"
            raise self.error(f"accessors[{number}]: {text}: expected {kinds}")
        if "bufferView" in said:
            data, stride = self.view(said["bufferView"])
            values = self._rows(number, data, stride, self.whole(said, "byteOffset", 0), kind, (count, width))
        else:
            values = np.zeros((count, width), kind)
        if "sparse" in said:
            values = self._spread(number, values, said["sparse"])
        if said.get("normalized") and not as_stored and kind != "<f4":
            most = np.iinfo(np.dtype(kind)).max
            values = np.maximum(values / most, -1.0)
        return values if width > 1 else values[:, 0]

    def _rows(self, number: Any, data: bytes, stride: int, begin: int, kind: str, shape: tuple[int, int]) -> Numbers:
        count, width = shape
        size = np.dtype(kind).itemsize
        step = stride or size * width
        if begin + (count - 1) * step + size * width > len(data):
            raise self.error(
                f"cut short: accessors[{number}] counts {count} values of {step} bytes, in {len(data) - begin}"
            )
        return np.ndarray(shape, kind, data, begin, (step, size)).copy()

    def _spread(self, number: Any, values: Numbers, sparse: Any) -> Numbers:
        """Return values of which some are replaced."""
        count = self.whole(sparse, "count", -1, 1)
        rows, new = self.at(sparse, "indices", {}), self.at(sparse, "values", {})
        kind = KINDS.get(rows.get("componentType", 0), "<u4")
        at, replaced = (
            self._rows(number, self.view(each.get("bufferView"))[0], 0, self.whole(each, "byteOffset", 0), own, shape)
            for each, own, shape in (
                (rows, kind, (count, 1)),
                (new, values.dtype.str, (count, values.shape[1])),
            )
        )
        if at.max() >= len(values):
            raise self.error(f"accessors[{number}].sparse of number {at.max()}: expected 0 to {len(values) - 1}")
        values[at[:, 0]] = replaced
        return values


def unpacked_draco(document: Document, packed: Mapping[str, Any]) -> tuple[Numbers, Numbers]:
    """Return the points (n, 3) and the corners (m,) of triangles of a primitive that Draco packed."""
    try:
        import DracoPy
    except ImportError:
        raise document.error(
            "packed by KHR_draco_mesh_compression: pip install 'carom[draco]', or export it without compression"
        ) from None
    try:
        found = DracoPy.decode(document.view(packed.get("bufferView"))[0])
        return np.asarray(found.points), np.asarray(found.faces, np.int64).ravel()
    except MeshError:
        raise
    except Exception as error:  # the library raises what it likes
        raise document.error(f"packed by KHR_draco_mesh_compression: {type(error).__name__}: {error}") from None
