"""A data set for Hugging Face's datasets, by its table: `python with_huggingface.py FOLDER`."""

import io
import sys
import tarfile
from pathlib import Path
from typing import Any

import datasets
import soundfile

folder = Path(sys.argv[1])


def with_sound(row: dict[str, Any]) -> dict[str, Any]:
    """Return the row's sound (Pa), from its shard."""
    with tarfile.open(folder / row["shard"]) as tar, tar.extractfile(f"{row['key']}.flac") as file:  # type: ignore[union-attr]
        return {"sound": soundfile.read(io.BytesIO(file.read()), dtype="float32")[0] * row["full_scale"]}


table = datasets.load_dataset(str(folder), split="train")  # which tables, the card of the folder says
for clip in (
    table.select_columns(["shard", "key", "full_scale", "factors", "contacts"]).map(with_sound).with_format("numpy")
):
    print(clip["key"], clip["sound"].shape, clip["factors"], clip["contacts"][0]["impulse"])
