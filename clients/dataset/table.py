"""The table of a data set: a row for each item, with all that is known of it, as Parquet."""

from __future__ import annotations

import io
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import pyarrow as pa
import pyarrow.parquet as pq

from .clip import Clip, row_of
from .recipe import Recipe
from .shard import key_of, shard_name

_LIST = pa.list_(pa.float64())
_SINES = pa.struct({"frequency": _LIST, "decay": _LIST, "gain": pa.list_(_LIST)})
_CLICK = pa.struct({"frequency": pa.float64(), "decay": pa.float64(), "gain": _LIST})
_MATRIX = pa.list_(pa.list_(pa.float32()))
_STRIKER = pa.struct(
    {"clicks": pa.list_(_CLICK), "ringing": _SINES, "second": _SINES, "snaps": pa.list_(pa.list_(pa.float64()))}
)
_OBJECT = pa.struct(
    {
        **dict.fromkeys(("name", "preset", "shape", "material"), pa.string()),
        **dict.fromkeys(("mass", "position"), pa.float64()),
        "modes": _SINES,
        "clicks": pa.list_(pa.struct([*_CLICK, pa.field("along", _LIST)])),
        "relief": _SINES,
        "linear": pa.bool_(),
        "by_moments": pa.list_(pa.int64()),
        **dict.fromkeys(("rubbed_relief", "rubbed_clicks"), pa.int64()),
        "places": pa.struct({"modes": pa.list_(_MATRIX), "relief": pa.list_(_MATRIX)}),
        "fades": pa.list_(pa.list_(_LIST)),
        "bends": pa.list_(pa.list_(_LIST)),
    }
)
_CONTACT = pa.struct(
    {
        **dict.fromkeys(("object", "by", "gesture", "id"), pa.string()),
        **dict.fromkeys(("start", "duration", "position", "by_position", "speed", "velocity"), pa.float64()),
        **dict.fromkeys(("mass", "impulse", "peak", "gain", "energy", "loss"), pa.float64()),
        "first": pa.int64(),
        "force": pa.list_(pa.float32()),
        "moments": pa.list_(pa.float32()),
        "path": pa.list_(pa.float32()),
        "fed": pa.bool_(),
        "striker": _STRIKER,
    }
)


def schema(recipe: Recipe, about: Mapping[str, Any]) -> pa.Schema:
    """Return the columns of a recipe's table. about: its metadata, as JSON under the key `carom`."""
    paired = {"pair": pa.int64(), "differs": pa.string()} if recipe.design == "pairs" else {}
    factors = {factor.name: _kind(factor.spread.ends) for factor in recipe.factors}
    columns = {
        "item": pa.int64(), "key": pa.string(), "shard": pa.string(), "seed": pa.int64(), **paired,
        "gesture": pa.string(), "licence": pa.string(), "split": pa.string(), "linear": pa.bool_(),
        "factors": pa.struct(factors) if factors else None, "rate": pa.int64(),
        "frames": pa.int64(), "full_scale": pa.float64(), "peak": pa.float64(), "exposure": _LIST,
        "objects": pa.list_(_OBJECT), "contacts": pa.list_(_CONTACT), "warnings": pa.list_(pa.string()),
    }  # fmt: skip
    made = pa.schema({name: kind for name, kind in columns.items() if kind is not None})
    return made.with_metadata({"carom": json.dumps(about)})


def rows_file(recipe: Recipe, shard: int, clips: Iterable[Clip]) -> bytes:
    """Return a shard's rows, as a table of their own."""
    columns = schema(recipe, {})
    rows = [{"shard": shard_name(recipe, shard), "key": key_of(clip.truth["item"]), **row_of(clip)} for clip in clips]
    memory = io.BytesIO()
    pq.write_table(pa.Table.from_pylist(rows, columns), memory, compression="zstd")
    return memory.getvalue()


def join(recipe: Recipe, about: Mapping[str, Any], parts: Sequence[Path], side: str, out: BinaryIO) -> None:
    """Write one table of the rows of all shards that are on a side of the split, a group of rows for each shard."""
    columns = schema(recipe, about)
    with pq.ParquetWriter(out, columns, compression="zstd") as writer:
        for part in parts:
            rows = pq.read_table(part, use_threads=False, filters=[("split", "=", side)])
            writer.write_table(rows.replace_schema_metadata(columns.metadata), row_group_size=max(1, len(rows)))


def _kind(ends: Sequence[object]) -> pa.DataType:
    return pa.string() if isinstance(ends[0], str) else pa.float64()
