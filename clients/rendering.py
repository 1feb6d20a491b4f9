"""Scores to sound files: one in this process, many in several at once."""

import signal
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent import futures
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..presets import Presets
from ..server.files.whole import RenderError
from ..server.options import loss_of
from ..server.osc.score import Line
from ..server.provenance import logged_otherwise
from ..server.render import Options, render, require_objects
from .errors import KINDS, is_expected, plain
from .plot import plotter, require_picture
from .streams import STREAM, playing, read_score, require_out, score_name, score_path, sound_file

if TYPE_CHECKING:
    from multiprocessing.synchronize import Event

PLACE = "{}"
"""Mark that stands for the score's name without its ending, in the name of a file to be written."""

_LOOK = 0.2  # s between looks at whether to go on


@dataclass(frozen=True)
class Task:
    """A score to read, a sound file to write, a picture of that and a folder for stems (None: none); - is stdin and
    stdout. objects: presets that play the channels of a MIDI file."""

    score: str
    out: str
    plot: Path | None
    stems: Path | None = None
    objects: Mapping[int, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Result:
    """The outcome of a task: warnings, and why it failed (None: it did not)."""

    task: Task
    warnings: list[str]
    failure: str | None


def tasks(
    scores: Sequence[str], out: str, plot: str | None, stems: str | None = None, objects: Sequence[str] = ()
) -> list[Task]:
    """Return a task for each score. `out` and `plot` are files, or folders or names with {} for several scores; `stems`
    is a folder, in which each of several scores has its own. objects: what plays MIDI files, as `playing` takes it.

    RenderError for names that cannot be.
    """
    several = len(scores) > 1
    played = playing(objects)
    made = [Task(score, _placed(score, out, ".wav", several), None, objects=played) for score in scores]
    if plot is not None:
        made = [replace(task, plot=Path(_placed(task.score, plot, ".png", several))) for task in made]
    if stems is not None:
        made = [replace(task, stems=_stems(task.score, stems, several)) for task in made]
    if several:
        for name, target in (("OUT", out), ("--plot", plot)):
            if target is not None and PLACE not in target and not _is_folder(target, True):
                wanted = f"expected a folder, or a name with {PLACE}, for {len(scores)} scores"
                raise RenderError(f"{name} = {target}: {wanted}")
        _require_different(made)
    return made


def make_folders(made: Sequence[Task]) -> None:
    """Make the folders of several tasks' files, if they are missing. OSError where that fails."""
    for path in (path for task in made for path in (Path(task.out), task.plot) if path):
        path.parent.mkdir(parents=True, exist_ok=True)


def _is_folder(name: str, several: bool) -> bool:
    """True if a name means a folder: one that is there, or for several scores one that can be made."""
    path = Path(name)
    return name != STREAM and (name.endswith("/") or path.is_dir() or (several and not (path.suffix or path.exists())))


def _placed(score: str, out: str, ending: str, several: bool) -> str:
    """Return the file to write for a score."""
    stem = Path(score_name(score)).stem
    if PLACE not in out and _is_folder(out, several):
        return str(Path(out, stem + ending))
    return out.replace(PLACE, stem)


def _stems(score: str, folder: str, several: bool) -> Path:
    """Return the folder for a score's stems."""
    stem = Path(score_name(score)).stem
    return Path(folder, stem) if several and PLACE not in folder else Path(folder.replace(PLACE, stem))


def _require_different(made: Sequence[Task]) -> None:
    before: dict[str, str] = {}
    for task in made:
        if task.out in before:
            raise RenderError(
                f"{task.score}: {before[task.out]} is rendered to {task.out} already; rename one of the two"
            )
        before[task.out] = task.score


def checked(task: Task, options: Options, presets: Presets) -> list[Line]:
    """Return the score of a task. The errors are those of `render_task` that need no engine, which may take minutes to
    compile."""
    score = read_score(task.score, task.objects)
    options.channels_and_sensors(options.lines_of(score))
    require_objects(score, presets, options.seconds)
    require_out(task.out)
    if task.plot:
        require_picture(task.plot)
    return score


def refusals(todo: Sequence[Task], options: Options, presets: Presets) -> list[Result]:
    """Return the outcomes of several tasks if `checked` refuses all of them; none if the engine is needed for one."""
    found = []
    for task in todo:
        if task.score == STREAM:  # it can be read once
            return []
        try:
            checked(task, options, presets)
            return []
        except KINDS as error:
            if not is_expected(error):
                raise
            found.append(Result(task, [], plain(error)))
    return found


def render_task(
    task: Task, options: Options, presets: Presets, progress: Callable[[float], object], score: list[Line] | None = None
) -> list[str]:
    """Carry out a task; return warnings. `progress` gets the seconds computed. score: if it was read already."""
    score = read_score(task.score, task.objects) if score is None else score
    draw = plotter(task.plot, options.calibrated) if task.plot else None
    warnings: list[str] = []
    with sound_file(task.out) as out:
        done = render(score, out, presets, options, progress, warnings.append, task.stems)
        if draw:
            draw(out)
    if task.score != STREAM and (otherwise := logged_otherwise(score_path(task.score), done.engine)):
        warnings.append(otherwise)
    if limited := done.limiting.said():
        warnings.append(limited)
    if done.normalized is not None:
        warnings.append(f"normalized by {done.normalized:+.3g} dB")
    for name in ("contacts_dropped", "over_budget", "faults"):
        if count := getattr(done.engine.stats, name):
            warnings.append(loss_of(name, count, done.engine.take_loudest_dropped()))
    return warnings


def render_all(
    todo: Sequence[Task], options: Options, folders: Sequence[Path], jobs: int, interrupted: Callable[[], bool]
) -> Iterator[Result]:
    """Carry out tasks in so many processes at once, and yield the results as they come.

    KeyboardInterrupt, once nothing runs any more, if `interrupted` says so.
    """
    import multiprocessing  # slow to load, and one score needs none

    context = multiprocessing.get_context("spawn")
    stop = context.Event()
    with futures.ProcessPoolExecutor(jobs, context, _begin, (stop, options, folders)) as pool:
        waiting: set[futures.Future[Result]] = {pool.submit(_carry_out, task) for task in todo}
        while waiting:
            done, waiting = futures.wait(waiting, _LOOK, futures.FIRST_COMPLETED)
            if interrupted():
                stop.set()
                pool.shutdown(cancel_futures=True)
                raise KeyboardInterrupt
            for future in done:
                yield future.result()


_process: dict[str, Any] = {}
"""The arguments that a process of `render_all` was started with."""


def _begin(stop: "Event", options: Options, folders: Sequence[Path]) -> None:
    for each in (signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)):  # the first process ends us
        signal.signal(each, signal.SIG_IGN)
    _process.update(stop=stop, options=options, presets=Presets(folders))


def _carry_out(task: Task) -> Result:
    try:
        return Result(task, render_task(task, _process["options"], _process["presets"], _go_on), None)
    except KINDS as error:
        if not is_expected(error):
            raise
        return Result(task, [], plain(error))


def _go_on(seconds: float) -> None:
    if _process["stop"].is_set():
        raise KeyboardInterrupt
