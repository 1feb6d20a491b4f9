"""Common code of the tests of data sets: recipes, and shards that are read back."""

import io
import json
import tarfile
from pathlib import Path
from typing import Any

import numpy as np
import soundfile

from carom.clients.dataset.recipe import Recipe, read

SMALL = """
count = 6
seed = 3
seconds = 0.25
shard = 2

[object]
preset = "xylophone-bar"
material = { choice = ["rosewood", "aluminium"] }

[impact]
velocity = { log_uniform = [0.1, 1.0] }
position = { uniform = [0, 1] }
"""


def written(folder: Path, text: str, name: str = "small") -> Path:
    """Write a recipe's file."""
    path = folder / f"{name}.toml"
    path.write_text(text)
    return path


def recipe_of(folder: Path, text: str, count: int | None = None) -> Recipe:
    return read(written(folder, text), count)


def unpacked(tar: bytes | Path) -> list[dict[str, Any]]:
    """Return the items of a shard: truth, samples (frames, channels) and force, as any program reads them."""
    with tarfile.open(fileobj=io.BytesIO(tar if isinstance(tar, bytes) else tar.read_bytes())) as opened:
        files = {member.name: opened.extractfile(member).read() for member in opened}
        assert all((member.mtime, member.uid, member.gid, member.uname) == (0, 0, 0, "") for member in opened)
    found: dict[str, dict[str, Any]] = {}
    for name, content in files.items():
        key, ending = name.split(".", 1)
        item = found.setdefault(key, {"key": key})
        if ending == "json":
            item["truth"] = json.loads(content)
        elif ending == "force.npy":
            item["force"] = np.load(io.BytesIO(content))
        else:
            item["samples"], item["rate"] = soundfile.read(io.BytesIO(content), always_2d=True)
            item["ending"] = ending
    return list(found.values())


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}
