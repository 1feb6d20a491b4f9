"""carom dataset: render a data set from its recipe."""

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Event

from .options import add_presets, on_end, processors
from .parser import Command, whole

MOST_WORKERS = 256


class DatasetError(RuntimeError):
    """The data set cannot be made; the text says why."""


def _options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("recipe", metavar="RECIPE", help="a TOML file, or the name of one of Carom's own")
    parser.add_argument(
        "out",
        type=Path,
        metavar="OUT",
        help="folder for shards and table; if it holds a part of them, the rest is made",
    )
    parser.add_argument("--count", type=whole, metavar="N", help="items (as the recipe says)")
    parser.add_argument("--workers", type=whole, metavar="N", help="processes (one for each processor)")
    parser.add_argument("--dask", metavar="ADDRESS", help="of Dask's scheduler, whose workers take their place")
    add_presets(parser)


def _run(arguments: argparse.Namespace) -> int:
    try:
        from ..dataset.recipe import find, read
        from ..dataset.run import Workers, run

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
    prepare()  # once, before the processes that share the compiled code
    interrupted = Event()
    on_end(interrupted.set)
    with _shown_progress() as show:
        table = run(
            recipe, arguments.out, Workers(workers, arguments.dask or ""), arguments.presets, show, interrupted.is_set
        )
    print(table)
    return 0


@contextmanager
def _shown_progress() -> Iterator[Callable[[int, int], object]]:
    """A function that shows how many items there are, of how many, on a terminal, with the rate and the time left."""
    if not sys.stderr.isatty():
        yield lambda done, count: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, Task, TextColumn, TimeRemainingColumn
    from rich.text import Text

    class Rate(TextColumn):
        def render(self, task: Task) -> Text:
            return Text(f"{task.speed:.0f} per second" if task.speed else "")

    columns = (BarColumn(), MofNCompleteColumn(), Rate(""), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        shown = bar.add_task("", total=None)
        yield lambda done, count: bar.update(shown, completed=done, total=count)


COMMAND = Command("dataset", "RECIPE OUT", "render a data set with its ground truth from a recipe", _options, _run)
