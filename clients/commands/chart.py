"""carom chart: measure speed against accuracy on this machine, and draw it."""

import argparse
from pathlib import Path

from .parser import Command


def _options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "folder",
        type=Path,
        metavar="FOLDER",
        help="for index.html, tables (CSV, Markdown) and figures (SVG, PNG); made if missing",
    )
    parser.add_argument("--quick", action="store_true", help="a coarse study")


def _run(arguments: argparse.Namespace) -> int:
    from rich.console import Console
    from rich.progress import Progress

    from ..chart.run import FULL, QUICK, chart

    terminal = Console(stderr=True)
    with Progress(console=terminal, disable=not terminal.is_terminal, transient=True) as bar:
        task = bar.add_task("", total=1.0)
        for what, done in chart(arguments.folder, QUICK if arguments.quick else FULL):
            bar.update(task, description=what, completed=done)
    print(arguments.folder / "index.html")
    return 0


COMMAND = Command("chart", "FOLDER", "measure speed against accuracy on this machine, and draw it", _options, _run)
