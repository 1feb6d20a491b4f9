"""A baked scene as one file: a map as JSON, then words and commands. `carom.js` reads it.

    8 bytes     "carom 2\\n"
    32 bytes    SHA-256 of the other bytes
    u32         length of the map
    u32         0
    the map     JSON, padded by spaces to a multiple of 8 bytes from the file's beginning
    the data    runs and commands, at multiples of 8 bytes; the map says where, from the data's beginning

Tables of mode shapes along many positions are not among a page's words, but coded (`tables.py`), all of them one after
the other. What an engine has for all its scenes is not here (`mapping.rules`). Runs are a u32 of their number and a
u32 of 0; for each the first word and the number of words, u32; then all words. All is little-endian, as WebAssembly is.
"""

from __future__ import annotations

import json
import lzma
import struct
from typing import NamedTuple

import numpy as np

from ...dsp.engine.memory.commands import COMMAND
from ...dsp.runtime.series import terms
from .baking import MAKES, Baked, Patch, maker_of
from .mapping import Strikers, layout, scene_map
from .scene_file import HEAD, MAGIC, SUM, summed
from .tables import Laid, coded, taken_out


class PageEngine(NamedTuple):
    """A page's engine, as its scene names it."""

    name: str
    """Another engine's is another one: it lays its memory out otherwise, or lacks something else."""


def packed(
    baked: Baked,
    strikers: Strikers,
    places: dict[str, tuple[float, float]],
    title: str,
    engine: PageEngine | None = None,
) -> bytes:
    """Return a baked scene's file.

    places: of its objects on a table, from 0 to 1. engine: for a page, whose tables of mode shapes are coded; without
    it the map names the layout of the memory, for a library.
    """
    data = bytearray()

    def put(content: bytes) -> int:
        at = len(data)
        data.extend(content)
        data.extend(bytes(-len(data) % 8))
        return at

    said = scene_map(baked, strikers, put)
    said["title"] = title
    tables: list[Laid] = []
    rest = [batch.patches for batch in baked.batches]
    if engine is not None:
        tables, rest = taken_out(baked)
        said["engine"] = engine.name
        said["coded"] = put(coded([each.values for each in tables]))
        said["tables"] = [(each.first, *each.values.shape, terms(len(each.values))) for each in tables]
    else:
        said["layout"] = layout()
    said["start"] = put(_runs(baked.start))
    firsts = []
    brought = np.searchsorted([each.batch for each in tables], np.arange(len(rest) + 1)).tolist()
    for number, (batch, patches) in enumerate(zip(baked.batches, rest, strict=True)):
        numbers = put(_runs(patches)), put(batch.commands.tobytes()), len(batch.commands)
        firsts.append((batch.at, *numbers, brought[number], brought[number + 1]))
    said["batches"] = firsts
    size = COMMAND.itemsize
    for name, obj in baked.objects.items():
        number, place = maker_of(baked, obj)
        said["objects"][name] |= {"made": firsts[number][2] + place * size, "batch": number}
        said["objects"][name]["stays"] = _stays(baked, obj.handle.first)
        if name in places:
            said["objects"][name]["at"] = places[name]
    text = json.dumps(said, separators=(",", ":")).encode()
    text += b" " * (-(len(text) + HEAD) % 8)
    return summed(MAGIC + bytes(SUM) + struct.pack("<II", len(text), 0) + text + bytes(data))


def _runs(patches: list[Patch]) -> bytes:
    heads = np.array([(patch.first, len(patch.words)) for patch in patches], "<u4").tobytes()
    return (
        struct.pack("<II", len(patches), 0) + heads + b"".join(patch.words.astype("<u8").tobytes() for patch in patches)
    )


def _stays(baked: Baked, first: int) -> bool:
    """True if no object that is made later takes the modes of one that begins there."""
    makers = [each["layout"]["first"] for batch in baked.batches for each in batch.commands if each["kind"] == MAKES]
    return makers.count(first) == 1


def compressed(content: bytes, *, words: bool = False) -> bytes:
    """Return a file as LZMA has it, in the format .lzma, the same for the same content; words: of 4 bytes."""
    modelled = {"nice_len": 128, **({"lc": 0, "lp": 2} if words else {"lc": 3, "lp": 0})}
    filters = [{"id": lzma.FILTER_LZMA1, "preset": 9 | lzma.PRESET_EXTREME, **modelled}]
    made = lzma.compress(content, lzma.FORMAT_ALONE, filters=filters)
    return made[:5] + struct.pack("<Q", len(content)) + made[13:]  # with its size, where Python leaves that unsaid
