"""The bytes of a shard: a WebDataset tar of clips with their truths, the same whenever and wherever it is made."""

from __future__ import annotations

import io
import json
import tarfile
from collections.abc import Iterable

import numpy as np
import soundfile
from numpy.typing import NDArray

from ...server.files.floatwav import header
from .clip import Clip
from .level import QUANTIZED
from .recipe import Recipe

_SUBTYPES = {"16": "PCM_16", "24": "PCM_24"}


def shard_name(recipe: Recipe, number: int) -> str:
    """Return the name of a shard's file."""
    return f"{recipe.name}-{number:06d}.tar"


def key_of(item: int) -> str:
    """Return the name of an item's files in their shard, up to the first dot."""
    return f"{item:09d}"


def packed(recipe: Recipe, clips: Iterable[Clip]) -> bytes:
    """Pack clips into a tar: for each its sound, KEY.json with its truth, KEY.force.npy with its forces, and
    KEY.path.npy with the paths of contacts that move, if any does, and KEY.sensor.npy with the signals of sensors."""
    tar: list[bytes] = []
    for clip in clips:
        key = key_of(clip.truth["item"])
        parts = {
            recipe.format: sound_file(clip.samples, recipe),
            "json": json.dumps(clip.truth, allow_nan=False, separators=(",", ":")).encode(),
            "force.npy": _array_file(clip.force),
            **({"path.npy": _array_file(clip.path)} if len(clip.path) else {}),
            **({"sensor.npy": _array_file(clip.sensed)} if clip.sensed.shape[1] else {}),
        }
        for ending, content in parts.items():
            member = tarfile.TarInfo(f"{key}.{ending}")  # its time is 0, and it belongs to nobody
            member.size = len(content)
            tar += member.tobuf(tarfile.USTAR_FORMAT), content, bytes(-len(content) % tarfile.BLOCKSIZE)
    tar.append(bytes(2 * tarfile.BLOCKSIZE))
    return b"".join([*tar, bytes(-sum(map(len, tar)) % tarfile.RECORDSIZE)])


def sound_file(samples: NDArray[np.float32] | NDArray[np.float64], recipe: Recipe) -> bytes:
    """Return a sound file of samples (frames, channels), or of whole numbers of steps."""
    if recipe.samples not in QUANTIZED:
        return header(recipe.rate, len(samples), samples.shape[1]) + samples.astype("<f4").tobytes()
    memory = io.BytesIO()
    whole = samples.astype(np.int32) << (32 - QUANTIZED[recipe.samples])
    soundfile.write(memory, whole, recipe.rate, _SUBTYPES[recipe.samples], format=recipe.format.upper())
    return memory.getvalue()


def _array_file(values: NDArray[np.float32]) -> bytes:
    memory = io.BytesIO()
    np.save(memory, values.astype("<f4"))
    return memory.getvalue()
