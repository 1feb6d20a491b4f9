"""The folder of a data set: which of its files are there, and files that appear whole or not at all."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ...dsp.errors import CaromError
from ...server.files.whole import appearing
from ...server.osc.score import Line, format_line
from .plan import Made
from .recipe import Recipe
from .shard import shard_name
from .split import SIDES
from .versions import require_same

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

ABOUT = "dataset.json"
"""The file that says by which recipe, and by what, a folder's data set is made."""


SCHEMA = 4
"""The version of the form of a data set: of its files, of the table's columns, and of the truth."""


class FolderError(CaromError, RuntimeError):
    """A folder that cannot take the data set; the text says why."""


def about(recipe: Recipe, versions: Mapping[str, str]) -> dict[str, Any]:
    """Return the contents of the file ABOUT."""
    return {
        "schema": SCHEMA,
        "recipe": recipe.name,
        "licence": recipe.licence,
        "items": recipe.count,
        "shards": [shard_name(recipe, number) for number in range(recipe.shards)],
        "tables": table_names(recipe),
        "seconds": recipe.seconds,
        "rate": recipe.rate,
        "channels": recipe.channels,
        "pascals_per_full_scale": recipe.full_scale,
        "computed_by": dict(versions),
        "recipe_text": recipe.text,
        "scores": {name: [_text(line) for line in score.lines] for name, score in recipe.scores.items()},
    }


def _text(line: Line) -> str:
    return format_line(line.time, line.message)


def table_names(recipe: Recipe) -> dict[str, str]:
    """Return the names of the tables' files, by sides of the split; without one, all rows are to learn from."""
    if recipe.split is None:
        return {SIDES[0]: f"{recipe.name}.parquet"}
    return {side: f"{recipe.name}-{side}.parquet" for side in recipe.split.sides}


def rows_name(recipe: Recipe, shard: int) -> str:
    """Return the name of the file of a shard's rows, which is there until the tables are."""
    return shard_name(recipe, shard).removesuffix(".tar") + ".rows"


def require_folder(out: Path, said: Mapping[str, Any]) -> None:
    """Make a folder if it is not there. FolderError or OSError if it can't take the data set, whatever computes it."""
    out.mkdir(parents=True, exist_ok=True)
    path = out / ABOUT
    if path.exists():
        _require_same_recipe(out, json.loads(path.read_bytes()), said)
    elif others := sorted(each.name for each in out.iterdir() if not each.name.startswith(f"{ABOUT}.")):
        raise FolderError(f"{out}: {others[0]} is there: expected a new or empty folder, or one with {ABOUT}")


@contextmanager
def opened(out: Path, said: Mapping[str, Any]) -> Iterator[None]:
    """Open a folder, new or with a part of the same data set, that no other run writes to meanwhile.

    FolderError, VersionError or OSError say why it cannot be. Files that killed runs left half done are removed.
    """
    require_folder(out, said)
    path = out / ABOUT
    if not path.exists():
        write(path, json.dumps(said, indent=2).encode() + b"\n")
    with path.open("rb") as file:
        if fcntl:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise OSError(error.errno, "is being written already", str(out)) from error
        there = json.load(file)
        _require_same_recipe(out, there, said)
        require_same(there["computed_by"], said["computed_by"], f"{out}: it was begun by other versions")
        _remove_halves(out)
        try:
            yield
        finally:  # a worker of a run that was killed may have begun one since
            _remove_halves(out)


def _remove_halves(out: Path) -> None:
    for half in out.glob("*.part"):
        half.unlink(missing_ok=True)


def _require_same_recipe(out: Path, there: Mapping[str, Any], said: Mapping[str, Any]) -> None:
    """Raise FolderError unless a folder holds the data set that is meant."""
    parts = {"recipe": "recipe", "recipe_text": "text of the recipe", "scores": "score", "items": "number of items"}
    for key, what in parts.items():
        if there.get(key) != said[key]:
            shown = f": {said[key]}, there are {there.get(key)}" if key in ("recipe", "items") else ""
            raise FolderError(f"{out}: it holds a data set of another {what}{shown}; expected a new or empty folder")


def missing(out: Path, recipe: Recipe) -> list[int]:
    """Return the numbers of the shards that are not there."""
    whole = all((out / name).exists() for name in table_names(recipe).values())
    return [
        number
        for number in range(recipe.shards)
        if not (out / shard_name(recipe, number)).exists() or not (whole or (out / rows_name(recipe, number)).exists())
    ]


def write_shard(out: Path, recipe: Recipe, made: Made) -> None:
    """Write a shard to a folder: first its rows, then its clips, each of them whole or not at all. OSError names it."""
    write(out / rows_name(recipe, made.shard), made.rows)
    write(out / shard_name(recipe, made.shard), made.tar)


def write(path: Path, content: bytes) -> None:
    """Write a file that appears whole, and is on the disk then. OSError, naming it, where that fails."""
    try:
        with appearing(path, durable=True) as descriptor, open(descriptor, "wb", closefd=False) as file:
            file.write(content)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error
