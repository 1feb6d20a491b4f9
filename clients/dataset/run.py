"""A data set from its recipe to its files: what is missing is made, and the tables at the end."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...presets import Presets
from ...server.files.whole import appearing
from .card import CARD, card
from .check import require_sound
from .files import about, missing, opened, require_folder, rows_name, table_names, write
from .local import by_processes
from .plan import outlined, planned
from .recipe import Recipe
from .table import join


@dataclass(frozen=True)
class Workers:
    """The makers of shards: so many processes, or the workers of Dask's scheduler at an address."""

    processes: int = 1
    dask: str = ""


def require_possible(recipe: Recipe, out: Path, folders: Sequence[Path] = ()) -> None:
    """Raise the errors of `run` that need no engine, which may take minutes to compile."""
    require_sound(recipe, Presets(folders))
    require_folder(out, about(recipe, {}))


def run(
    recipe: Recipe,
    out: Path,
    workers: Workers,
    folders: Sequence[Path] = (),
    progress: Callable[[int, int], object] = lambda done, count: None,
    interrupted: Callable[[], bool] = lambda: False,
) -> list[Path]:
    """Make what a folder lacks of a recipe's data set; return the files of its tables, one for each side of a split.

    progress: called with the number of items that are there, and of all. KeyboardInterrupt if `interrupted` says so;
    what was made by then stays, and another run goes on from there. PresetError, ItemError, FolderError, VersionError,
    WorkerError or OSError say what cannot be.
    """
    require_sound(recipe, Presets(folders))
    plan = outlined(recipe, folders)
    said = about(recipe, plan.versions)
    with opened(out, said):
        shards = missing(out, recipe)
        done = recipe.count - sum(len(recipe.numbers(shard)) for shard in shards)
        progress(done, recipe.count)
        if workers.dask:
            from .dask import by_dask

            made = by_dask(planned(recipe, folders), out, shards, workers.dask, interrupted)
        else:
            made = by_processes(plan, out, shards, workers.processes, interrupted) if shards else iter(())
        for shard in made:
            done += len(recipe.numbers(shard))
            progress(done, recipe.count)
        return _tables(recipe, out, said)


def _tables(recipe: Recipe, out: Path, said: Mapping[str, Any]) -> list[Path]:
    """Return the tables of a data set whose shards are all there; the files of their rows go."""
    tables = {side: out / name for side, name in table_names(recipe).items()}
    parts = [out / rows_name(recipe, shard) for shard in range(recipe.shards)]
    for side, table in tables.items():
        if not table.exists():
            with appearing(table, durable=True) as descriptor, open(descriptor, "wb", closefd=False) as file:
                join(recipe, said, parts, side, file)
    write(out / CARD, card(recipe, said).encode())
    for part in parts:
        part.unlink(missing_ok=True)
    return list(tables.values())
