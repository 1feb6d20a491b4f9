"""carom chart: measure speed against accuracy on this machine, and draw it."""

import argparse
from pathlib import Path

from .parser import Command
from .progress import Work, shown_progress


def _options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "folder",
        type=Path,
        metavar="FOLDER",
        help="folder for index.html, tables (CSV, Markdown) and figures (SVG, PNG)",
    )
    parser.add_argument("--quick", action="store_true", help="coarse study, in less time")


def _run(arguments: argparse.Namespace) -> int:
    from ...dsp.errors import require_compiler
    from ..plot import require_matplotlib

    require_compiler("carom chart")
    require_matplotlib()
    from ...dsp.lab.chart.run import FULL, QUICK, chart

    with shown_progress(Work("chart"), total=1.0) as show:
        for what, done in chart(arguments.folder, QUICK if arguments.quick else FULL):
            show(description=what, completed=done)
    print(arguments.folder / "index.html")
    return 0


COMMAND = Command(
    "chart", "FOLDER", "measure and draw Carom's speed against its accuracy on this machine", _options, _run
)
