"""Items of a recipe one after the other, without files."""

from __future__ import annotations

import itertools
import json
import signal
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from concurrent import futures
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ...dsp.arguments import ArgumentError, explain_arguments
from ...dsp.numerics.blas import on_one_thread
from ...presets import PresetError
from ...presets.values import shown
from ..errors import KINDS, is_expected, plain
from .check import require_sound
from .clip import Clip, ItemError, render, row_of
from .design import one_by_one
from .level import pascals
from .presets import presets_of
from .recipe import MOST, Recipe, Source, find, read, recipe_of

Given = str | PathLike[str] | Mapping[str, Any]
"""A recipe: the name of a file, or of one of Carom's own, or what a file says as a dictionary."""

Folders = str | PathLike[str] | Iterable[str | PathLike[str]]
"""A folder of presets, or several."""

_AT_ONCE = 8  # items that a process is given
_AHEAD = 3  # times as many for each process as it has at once


@explain_arguments
def render_many(
    recipe: Given,
    numbers: Iterable[int] | None = None,
    *,
    workers: int = 1,
    presets: Folders = (),
) -> Iterator[dict[str, Any]]:
    """Render items of a recipe one after the other, without files: the sounds that `carom dataset` writes.

    Parameters
    ----------
    recipe : str, path or dict
        As `carom dataset` takes it, or a dictionary with the keys of such a file; it needs no `count`.
    numbers : iterable of int, optional
        Numbers of the items. Default: all. An item follows from the recipe's seed and its number alone.
    workers : int, default 1
        Number of processes. With more than one, begin the program under `if __name__ == "__main__"`.
    presets : path or list of paths, optional
        Folders of your own presets.

    Yields
    ------
    dict
        A row of the data set's table, with `sound`, float32 (frames, channels) in Pa.

    Raises
    ------
    PresetError
        The recipe is refused; the text says why.
    ItemError
        An item cannot be rendered; the text names it.

    Examples
    --------
    >>> import carom
    >>> for row in carom.render_many("bars", range(2)):
    ...     print(row["sound"].shape, len(row["contacts"]))
    (48000, 1) 1
    (48000, 1) 1
    """
    plan, folders = checked(recipe, presets)
    if not hasattr(workers, "__index__") or workers < 1:
        raise ValueError(f"workers = {workers!r}: expected a whole number from 1")
    chosen = iter(valid(plan, range(plan.count) if numbers is None else numbers))
    return _by_processes(plan, folders, chosen, workers) if workers > 1 else rows(plan, folders, chosen)


def checked(recipe: Given, presets: Folders) -> tuple[Recipe, tuple[str, ...]]:
    """Return a recipe that was tried, and the folders of presets; PresetError or OSError say what is wrong."""
    given = (presets,) if isinstance(presets, str | PathLike) else tuple(presets)
    folders = tuple(str(Path(each)) for each in given)
    found = recipe_from(recipe, tuple(map(Path, folders)))
    require_sound(found, presets_of(folders))
    return found, folders


def recipe_from(given: Given, folders: tuple[Path, ...] = ()) -> Recipe:
    """Return a recipe from a name, a file, or a dictionary. PresetError or FileNotFoundError say what is wrong."""
    if not isinstance(given, Mapping):
        if not isinstance(given, str | PathLike):
            raise ArgumentError(f"recipe = {given!r}: expected the name of a recipe, a file, or a dictionary")
        return read(find(str(given), folders))
    data = _plain(given)
    count = None if "count" in data or data.get("design") == "grid" else MOST
    try:
        text = json.dumps(data)
    except (TypeError, ValueError) as error:
        raise PresetError(f"recipe: {error}: expected numbers, words, lists and dictionaries") from None
    return recipe_of(data, Source("recipe", "recipe: ", text, Path()), count)


def _plain(value: Any) -> Any:
    """Return dictionaries, lists and numbers as a file of TOML would give them."""
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    value = value.tolist() if hasattr(value, "tolist") else value
    return [_plain(each) for each in value] if isinstance(value, list | tuple) else value


def valid(recipe: Recipe, numbers: Iterable[int]) -> Iterator[int]:
    """Yield numbers of items. ValueError for what is none."""
    if not isinstance(numbers, Iterable):
        raise ValueError(f"numbers = {numbers!r}: expected several whole numbers, such as range(3)")
    for each in numbers:
        if isinstance(each, bool) or not hasattr(each, "__index__") or not 0 <= each < recipe.count:
            raise ValueError(f"numbers: {shown(each)}: expected whole numbers from 0 to {recipe.count - 1}")
        yield int(each)


def rows(recipe: Recipe, folders: tuple[str, ...], numbers: Iterable[int]) -> Iterator[dict[str, Any]]:
    """Yield the rows of some items, rendered in this process."""
    presets = presets_of(folders)
    for item in one_by_one(recipe, numbers):
        with on_one_thread():
            clip = render(recipe, item, presets)
        row = row_of(clip)
        row["sound"] = sound_of(recipe, clip)
        yield row


def sound_of(recipe: Recipe, clip: Clip) -> np.ndarray[Any, np.dtype[np.float32]]:
    """Return the sound of a clip in Pa; steps of a full scale that is a power of two are exact in float32."""
    return pascals(clip.samples, clip.truth["full_scale"], recipe.samples)


def _by_processes(
    recipe: Recipe, folders: tuple[str, ...], numbers: Iterator[int], workers: int
) -> Iterator[dict[str, Any]]:
    """Render items in processes, a few of them ahead of the one that is requested."""
    import multiprocessing  # slow to load

    context = multiprocessing.get_context("spawn")
    with futures.ProcessPoolExecutor(workers, context, _begin) as pool:
        try:
            waiting: deque[futures.Future[tuple[list[dict[str, Any]], str]]] = deque()
            while True:
                while len(waiting) < _AHEAD * workers and (some := list(itertools.islice(numbers, _AT_ONCE))):
                    waiting.append(pool.submit(_some, recipe, folders, some))
                if not waiting:
                    return
                made, failure = waiting.popleft().result()
                yield from made
                if failure:
                    raise ItemError(failure)
        finally:
            pool.shutdown(cancel_futures=True)


def _begin() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the first process ends us


def _some(recipe: Recipe, folders: tuple[str, ...], numbers: list[int]) -> tuple[list[dict[str, Any]], str]:
    """Render some items; those before the first that cannot be, and why that one cannot."""
    made = []
    try:
        for row in rows(recipe, folders, numbers):
            made.append(row)
    except KINDS as error:
        if not is_expected(error):
            raise
        return made, plain(error)
    return made, ""
