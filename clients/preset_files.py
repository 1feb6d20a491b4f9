"""Checks of preset files: what kind of preset a file holds, and whether it is sound."""

import errno
import os
from pathlib import Path
from typing import NamedTuple

from ..dsp.bodies.material import Material
from ..dsp.errors import CaromError
from ..presets import KINDS, ObjectPreset, PresetError, Presets, StrikerPreset
from ..presets.library import read_file
from .dataset.check import require_sound
from .dataset.recipe import read
from .errors import plain

RECIPE = "recipes"
_TOP = 20_000.0  # Hz up to which modes are made


class CheckError(CaromError, RuntimeError):
    """Error of a check without anything to check; the text says why."""


class Checked(NamedTuple):
    """A file, the kind of preset that it holds, and in words what that is or why it is wrong."""

    file: str
    kind: str
    holds: str
    error: str


def checked(path: Path, presets: Presets) -> Checked:
    """Check a preset's file as it is used: its keys and values, the presets that it names, an object's modes.

    Its kind is that of its folder (objects, strikers, materials, surfaces, recipes), elsewhere that of its keys.
    """
    kind = ""
    if not path.exists():
        named = [kind for kind in KINDS if str(path) in presets.names(kind)]
        missing = FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(path))
        text = f"{path}: a preset's name; expected a file, as {presets.path(named[0], str(path))}" if named else None
        return Checked(str(path), kind, "", text or plain(missing))
    try:
        kind = path.resolve().parent.name
        if kind not in (*KINDS, RECIPE):
            kind = _kind_of(path)
        holds = _drawn(path, presets) if kind == RECIPE else _holds(presets.load(kind, path))
        return Checked(str(path), kind, holds, "")
    except PresetError as error:
        return Checked(str(path), kind, "", str(error))


def files_in(name: str) -> list[Path]:
    """Return the file of a name, or all presets below it if it is a folder. CheckError if it holds none."""
    path = Path(name)
    if not path.is_dir():
        return [path]
    if files := sorted(each for each in path.rglob("*.toml") if each.is_file()):
        return files
    raise CheckError(f"{name}: expected a preset, or a folder of presets; there is no .toml file in it")


def _kind_of(path: Path) -> str:
    """Return the kind of preset that a file's keys show."""
    data = read_file(path)[1]
    kinds = {"shape": "objects", "youngs_modulus": "materials", "roughness": "surfaces", "object": RECIPE}
    return next((kind for key, kind in kinds.items() if key in data), "strikers")


def _drawn(path: Path, presets: Presets) -> str:
    """Return a data set's recipe in a few words. PresetError if it draws what cannot be played."""
    recipe = read(path)
    require_sound(recipe, presets)
    return f"a recipe of a data set: {recipe.count} items of {recipe.seconds:g} s, {recipe.design}"


def _holds(preset: object) -> str:
    """Return a preset in a few words. PresetError if an object's geometry gives no modes."""
    if isinstance(preset, ObjectPreset):
        modes = preset.modes(_TOP)
        of = f" of {preset.material.name}" if preset.material else ""
        what = f"{preset.shape}{of}, {modes.mass:.3g} kg"
        if not modes.frequency.size:
            return f"an object: {what}, no mode below {_TOP:.0f} Hz, but a click"
        low, high = modes.frequency[0], modes.frequency[-1]
        return f"an object: {what}, {modes.frequency.size} modes from {low:.1f} to {high:.0f} Hz"
    if isinstance(preset, StrikerPreset):
        return f"a striker of {preset.mass:.3g} kg"
    return "a material" if isinstance(preset, Material) else "a surface"
