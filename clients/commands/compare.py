"""carom compare: how far apart two sounds are, in figures, a picture and a page with players."""

import argparse
from html import escape
from pathlib import Path

from ..errors import tell
from .parser import Command
from .progress import AT_WORK, Work, shown_progress


def _options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("a", type=Path, metavar="A.wav", help="reference sound")
    parser.add_argument(
        "b", type=Path, metavar="B.wav", help="other sound, which is shifted and levelled to agree with A"
    )
    parser.add_argument(
        "--kind",
        type=Path,
        metavar="FOLDER",
        help="folder of recordings like A, whose distances from each other are shown for comparison",
    )
    parser.add_argument(
        "--plot", type=Path, metavar="OUT.png", help="picture of both spectrograms, third octaves and decays"
    )
    parser.add_argument("--page", type=Path, metavar="OUT.html", help="page with players, figures and the picture")
    parser.add_argument("--json", action="store_true", help="output as JSON")


def _run(arguments: argparse.Namespace) -> int:
    from ..comparison import as_json, beside, compare, draw, kind_table, require_page, table, verdict, write_page
    from ..plot import require_picture

    if arguments.plot:
        require_picture(arguments.plot)
    if arguments.page:
        require_page(arguments.page)
    names = (arguments.a.name, arguments.b.name)
    with shown_progress(Work("compare", AT_WORK), f"{names[0]} and {names[1]}"):
        found, notes = compare(arguments.a, arguments.b)
        kind = beside(arguments.a, arguments.b, arguments.kind) if arguments.kind else None
        if arguments.plot:
            draw(found, arguments.plot, names)
        if arguments.page:
            more = f"<pre>{escape(kind_table(kind))}</pre>" if kind else ""
            write_page(arguments.page, f"{names[0]} and {names[1]}", [(found, names)], more=more)
    for note in notes:
        tell("compare", note)
    if arguments.json:
        print(as_json(found, kind))
    else:
        print("\n\n".join([table(found), *([kind_table(kind)] if kind else []), verdict(found)]))
    return 0


COMMAND = Command(
    "compare", "A.wav B.wav", "measure how much two sounds differ, and picture both (needs carom[fit])", _options, _run
)
