"""carom render: turn scores into sound files."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from threading import Event
from typing import TYPE_CHECKING

from ..errors import tell
from ..processors import processors
from .options import RATE, SCORE, SWITCH, add_bank, add_full_scale, add_presets, on_end, switch
from .parser import Command, number, one_of, whole
from .progress import SECONDS_OF_SOUND, Work, shown_progress

if TYPE_CHECKING:
    from ...presets import Presets
    from ...server.osc.score import Line
    from ...server.render import Options
    from ..rendering import Result, Task

FORMATS = ("16", "24", "float")
"""Formats of samples."""

MOST_JOBS = 256

_ONE = Work("render", SECONDS_OF_SOUND, "s of sound")

PEAK = -1.0
"""dBFS: of a render that is normalized, unless another is given."""


def _options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "scores",
        nargs="+",
        metavar="SCORE",
        help=SCORE,
    )
    out = "sound file, .wav or .flac; -: stdout; for several scores a folder, or a name such as 'out/{}.flac'"
    parser.add_argument("out", metavar="OUT", help=out)
    parser.add_argument(
        "--jobs", type=whole, metavar="N", help="number of scores to render at once (one for each processor)"
    )
    parser.add_argument("--rate", type=whole, default=RATE, help="sampling rate in Hz (%(default)s)")
    parser.add_argument(
        "--block", type=whole, default=16_384, help="frames per block; has no effect on the sound (%(default)s)"
    )
    parser.add_argument("--format", choices=FORMATS, type=one_of(*FORMATS), help="sample format (WAV: float, FLAC: 24)")
    parser.add_argument("--seconds", type=number, help="length of the sound (until silence)")
    parser.add_argument("--plot", metavar="OUT.png", help="picture of the wave and the spectrogram of each channel")
    parser.add_argument("--stems", metavar="DIR", help="folder for a file of each object")
    parser.add_argument(
        "--calibrated", action="store_true", help="write samples in pascals, as floats, without limiter"
    )
    parser.add_argument("--channels", type=whole, metavar="N", help="number of channels, 1 to 64 (the score's, else 2)")
    parser.add_argument("--gain", type=number, metavar="DB", help="level of everything, dB (the score's, else 0)")
    parser.add_argument(
        "--limiter", **SWITCH, help="limiter, which keeps the sound within full scale (the score's, else on)"
    )
    normalize = f"peak of the file, dB of full scale; turns off the limiter, unless you add --limiter on ({PEAK:g})"
    parser.add_argument("--normalize", type=number, nargs="?", const=PEAK, metavar="DBFS", help=normalize)
    add_full_scale(parser, otherwise="the score's, else 4")
    add_bank(parser, None, "the score's, else float64")
    budget = "limits on the cost of coupled contacts, as in /budget; 16 8192: as on a server (the score's)"
    parser.add_argument("--budget", type=number, nargs=2, metavar=("STEPS", "MODES"), help=budget)
    parser.add_argument(
        "--object", action="append", default=[], metavar="[CHANNEL:]PRESET",
        help="object that plays a MIDI file or one of its channels, such as 10:tom; may be repeated",
    )  # fmt: skip
    add_presets(parser)


def _run(arguments: argparse.Namespace) -> int:
    from ...dsp.runtime.engine import prepare
    from ...presets import Presets
    from ...server.files.whole import RenderError
    from ...server.render import Options
    from ..rendering import checked, make_folders, refusals, render_all, tasks

    keys = ("rate", "block", "format", "seconds", "channels", "gain", "calibrated", "normalize", "bank", "full_scale")
    given = {key: getattr(arguments, key) for key in keys}
    budget = None if arguments.budget is None else tuple(arguments.budget)
    options = Options(**given, limiter=switch(arguments.limiter), budget=budget)
    todo = tasks(arguments.scores, arguments.out, arguments.plot, arguments.stems, arguments.object)
    jobs = min(len(todo), processors() if arguments.jobs is None else arguments.jobs)
    if not 1 <= jobs <= MOST_JOBS:
        raise RenderError(f"jobs = {arguments.jobs}: expected 1 to {MOST_JOBS}")
    presets = Presets(arguments.presets)
    score = None
    if len(todo) == 1:
        score = checked(todo[0], options, presets)
    else:
        make_folders(todo)
        if refused := refusals(todo, options, presets):
            return _render_many(iter(refused), len(todo))
    prepare()  # once, before processes that share the compiled code, and before there is another progress bar

    # An exception that a signal raises may be lost inside a library's callback: so the signal only sets a flag.
    interrupted = Event()
    on_end(interrupted.set)
    if score is None:
        return _render_many(render_all(todo, options, arguments.presets, jobs, interrupted.is_set), len(todo))
    _render_one(todo[0], score, options, presets, interrupted)
    return 0


def _render_one(task: Task, score: list[Line], options: Options, presets: Presets, interrupted: Event) -> None:
    """Carry out a task, with its progress in seconds of sound."""
    from ..rendering import render_task
    from ..streams import score_name

    with shown_progress(_ONE, score_name(task.score), options.seconds) as show:

        def progress(seconds: float) -> None:
            show(completed=seconds)
            if interrupted.is_set():
                raise KeyboardInterrupt

        warnings = render_task(task, options, presets, progress, score)
    for warning in warnings:
        tell("render", warning)


def _render_many(results: Iterator[Result], count: int) -> int:
    """Report results as they come, with progress in scores on a terminal; return the exit code."""
    from ..streams import score_name

    failed = False
    with shown_progress(Work("render", "{bar} {n} of {total} {remaining}", "scores"), total=count) as show:
        for done, result in enumerate(results, start=1):
            show(completed=done)
            name = score_name(result.task.score)
            for text in (*result.warnings, *([result.failure] if result.failure else [])):
                tell("render", text if text.startswith(name) else f"{name}: {text}")
            failed |= result.failure is not None
    return 1 if failed else 0


COMMAND = Command("render", "SCORE [SCORE ...] OUT", "turn scores into sound files", _options, _run)
