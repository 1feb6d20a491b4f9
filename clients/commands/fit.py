"""carom fit: make an object of recordings."""

import argparse
import sys
from pathlib import Path

from ..errors import tell
from .options import add_presets
from .parser import Command, number, pascals, whole
from .progress import AT_WORK, Work, shown_progress


def _options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "recordings",
        nargs="+",
        type=Path,
        metavar="RECORDING",
        help="sound files of single strikes, or a folder of them",
    )
    parser.add_argument(
        "out",
        type=Path,
        metavar="OUT",
        help="folder for the presets and the report; it is made if missing",
    )
    parser.add_argument("--name", required=True, help="name of the new object")
    parser.add_argument("--modes", type=whole, default=40, metavar="N", help="largest number of modes (%(default)s)")
    parser.add_argument(
        "--positions",
        type=_numbers,
        default=(),
        metavar="P,...",
        help="position of the strike of each recording, 0 to 1, such as 0.1,0.3,0.5",
    )
    parser.add_argument(
        "--strikers",
        metavar="NAME,...",
        help="striker of each recording, or of all: a preset, or a name for a new one",
    )
    parser.add_argument("--velocity", type=number, metavar="V", help="speed of the strikes, m/s (1)")
    parser.add_argument("--mass", type=number, metavar="KG", help="mass of the object, kg (1, a guess)")
    parser.add_argument(
        "--full-scale", type=pascals, metavar="PA", help="pressure of the recordings' full scale, such as 2 or 2Pa"
    )
    parser.add_argument("--distance", type=number, metavar="M", help="distance of the microphone, m (1)")
    parser.add_argument("--force", type=Path, metavar="HAMMER.wav", help="recording of the force, by an impact hammer")
    parser.add_argument("--source", metavar="TEXT", help="source of the recordings, kept in the preset")
    parser.add_argument("--licence", metavar="TEXT", help="licence of the recordings, kept in the preset")
    parser.add_argument("--no-report", action="store_true", help="presets only, no page to hear and look at")
    add_presets(parser)


def _run(arguments: argparse.Namespace) -> int:
    from ...dsp.runtime.engine import prepare
    from ...presets import Presets
    from ..fitting import Wanted, make, readable

    asked = ("mass", "velocity", "full_scale", "distance")
    given = {key: getattr(arguments, key) for key in asked if getattr(arguments, key) is not None}
    wanted = Wanted(
        name=arguments.name,
        modes=arguments.modes,
        positions=tuple(arguments.positions),
        strikers=tuple(_words(arguments.strikers)),
        force=arguments.force,
        source=_told(arguments.source, "Who recorded this, and where is it from?"),
        licence=_told(arguments.licence, "Under which licence?"),
        **given,
    )
    presets = Presets(arguments.presets)
    readable(arguments.recordings, arguments.out)
    prepare()  # before there is another progress bar
    with shown_progress(Work("fit", AT_WORK), f"fitting {wanted.name}"):
        made = make(arguments.recordings, arguments.out, wanted, presets)
        files = list(made.files)
        if not arguments.no_report:
            from ..fit_report import write_report

            files.append(write_report(made, wanted.name, arguments.out))
    for note in made.notes:
        tell("fit", note)
    for file in files:
        print(file)
    return 0


def _numbers(text: str) -> list[float]:
    return [number(word) for word in _words(text)]


def _words(text: str | None) -> list[str]:
    return [word.strip() for word in text.split(",") if word.strip()] if text else []


def _told(given: str | None, question: str) -> str | None:
    """Return what is given, or what a person at a terminal answers; None where nobody says anything."""
    if given is not None or not (sys.stdin.isatty() and sys.stderr.isatty()):
        return given
    print(f"{question} (Enter: unknown) ", end="", file=sys.stderr, flush=True)
    return sys.stdin.readline().strip() or None


COMMAND = Command(
    "fit",
    "RECORDING [RECORDING ...] OUT",
    "make an object from recordings, and compare both on a page (needs carom[fit])",
    _options,
    _run,
)
