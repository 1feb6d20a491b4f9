"""carom dataset: render a data set from its recipe."""

import argparse
from pathlib import Path
from threading import Event

from ...dsp.errors import CaromError
from ..processors import processors
from .options import add_presets, on_end
from .parser import Command, whole
from .progress import Work, shown_progress

MOST_WORKERS = 256
_FORM = "{bar} {n} of {total} {rate_noinv_fmt} {remaining}"


class DatasetError(CaromError, RuntimeError):
    """The data set cannot be made; the text says why."""


def _options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("recipe", metavar="RECIPE", help="TOML file, or the name of one of Carom's recipes")
    parser.add_argument(
        "out",
        type=Path,
        metavar="OUT",
        help="folder for shards and table; files that are already in it are kept",
    )
    parser.add_argument("--count", type=whole, metavar="N", help="number of items (the recipe's)")
    parser.add_argument("--workers", type=whole, metavar="N", help="number of processes (one for each processor)")
    parser.add_argument("--dask", metavar="ADDRESS", help="address of a Dask scheduler, whose workers compute")
    add_presets(parser)


def _run(arguments: argparse.Namespace) -> int:
    try:
        from ..dataset.recipe import find, read
        from ..dataset.run import Workers, require_possible, run

        if arguments.dask:
            from ..dataset import dask  # noqa: F401
    except ModuleNotFoundError as error:
        extra = "dask" if arguments.dask else "dataset"
        raise DatasetError(f"{error.name} is missing: pip install 'carom[{extra}]'") from None
    from ...dsp.runtime.engine import prepare

    workers = processors() if arguments.workers is None else arguments.workers
    if not 1 <= workers <= MOST_WORKERS:
        raise DatasetError(f"workers = {workers}: expected 1 to {MOST_WORKERS}")
    recipe = read(find(arguments.recipe, arguments.presets), arguments.count)
    require_possible(recipe, arguments.out, arguments.presets)
    prepare()  # once, before the processes that share the compiled code
    interrupted = Event()
    on_end(interrupted.set)
    with shown_progress(Work("dataset", _FORM, "items")) as show:
        told: list[int] = []  # how many items are there; at first those of a run before

        def progress(done: int, count: int) -> None:
            told.append(done)
            show(completed=done, total=count, before=told[0])

        spread = Workers(workers, arguments.dask or "")
        tables = run(recipe, arguments.out, spread, arguments.presets, progress, interrupted.is_set)
    print(*tables, sep="\n")
    return 0


COMMAND = Command("dataset", "RECIPE OUT", "from a recipe, render a data set with its ground truth", _options, _run)
