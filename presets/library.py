"""The library: presets by name, from TOML files in the user's folders and Carom's own."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterable
from functools import lru_cache
from os import PathLike
from pathlib import Path
from typing import Any

from ..dsp.arguments import explain_all_arguments
from ..dsp.bodies.material import Material
from ..dsp.wording import expected
from .kinds import ObjectPreset, StrikerPreset, SurfacePreset
from .schema import MATERIAL, MATERIAL_REQUIRED, NoPreset, PresetError, check
from .values import NAME, Name, shown

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

BUILT_IN = Path(__file__).resolve().parent
KINDS = ("objects", "strikers", "surfaces", "materials")

Folder = str | PathLike[str]

_MADE = "mesh-"
"""The beginning of names of objects that are looked for among those that are kept, too (presets/made.py)."""

MOST_BYTES, MOST_KEYS = 4_000_000, 10_000
"""Bounds of a preset's file, which is read within a second or two: an object of 4,096 modes takes a tenth of them. Each
= counts as a key, wherever it stands."""

_SETTLED = 3_000_000_000
"""ns after an edit from which on the next one surely gives a file another time: some file systems count by 2 s."""


@explain_all_arguments
class Presets:
    """Presets by name: your own, then Carom's.

    Files are read on each use, so that edits take effect at once.

    Parameters
    ----------
    folders : path or list of paths, optional
        Folders of your own presets, with objects/, strikers/, surfaces/ and materials/ in them. The first that has a
        name counts.

    Raises
    ------
    PresetError
        A folder does not exist; the text names it.

    Examples
    --------
    >>> import carom
    >>> carom.Presets().material("steel").density
    7850.0
    """

    def __init__(self, folders: Folder | Iterable[Folder] = ()) -> None:
        if not isinstance(folders, str | PathLike | Iterable):
            raise PresetError(f"presets = {folders!r}: expected a folder, or several")
        folders = [folders] if isinstance(folders, str | PathLike) else list(folders)
        for folder in folders:
            if not isinstance(folder, str | PathLike) or not os.path.isdir(folder):
                raise PresetError(f"{folder}: expected a folder with {', '.join(KINDS)}")
        self._folders = (*map(Path, folders), BUILT_IN)
        self._surfaces: dict[str, tuple[dict[str, Any], SurfacePreset]] = {}  # with the data of which each was made

    @property
    def folders(self) -> tuple[Path, ...]:
        """Folders in which presets are looked up, in this order."""
        return self._folders

    def names(self, kind: str) -> list[str]:
        """Return the names of all presets of a kind.

        Parameters
        ----------
        kind : {"objects", "strikers", "surfaces", "materials"}
            Kind of presets.

        Returns
        -------
        list of str
            Names, sorted.

        Raises
        ------
        ValueError
            There is no such kind.
        """
        if kind not in KINDS:
            raise ValueError(f"kind = {kind!r}: {expected(kind, KINDS)}")
        files = (path for folder in self._folders for path in (folder / kind).glob("*.toml"))
        return sorted({path.stem for path in files if NAME.fullmatch(path.stem) and path.is_file()})

    def material(self, name: str) -> Material:
        """Return a preset of a material.

        Parameters
        ----------
        name : str
            Name of the preset.

        Returns
        -------
        Material
            The material.

        Raises
        ------
        PresetError
            There is none, or its file is wrong; the text says why.
        """
        return _material(name, *self._read("materials", name))

    def striker(self, name: str) -> StrikerPreset:
        """Return a preset of a striker.

        Parameters
        ----------
        name : str
            Name of the preset.

        Returns
        -------
        StrikerPreset
            The striker.

        Raises
        ------
        PresetError
            There is none, or its file is wrong; the text says why.
        """
        return StrikerPreset.from_data(name, *self._read("strikers", name), self)

    def surface(self, name: str) -> SurfacePreset:
        """Return a preset of a surface.

        Parameters
        ----------
        name : str
            Name of the preset.

        Returns
        -------
        SurfacePreset
            The surface.

        Raises
        ------
        PresetError
            There is none, or its file is wrong; the text says why.
        """
        where, data = self._read("surfaces", name)
        if name not in self._surfaces or self._surfaces[name][0] is not data:  # another edition of the file
            self._surfaces[name] = data, SurfacePreset.from_data(name, where, data)
        return self._surfaces[name][1]

    def object(self, name: str) -> ObjectPreset:
        """Return a preset of an object.

        Parameters
        ----------
        name : str
            Name of the preset.

        Returns
        -------
        ObjectPreset
            The object.

        Raises
        ------
        PresetError
            There is none, or its file is wrong; the text says why.
        """
        return self._object(name, self.path("objects", name))

    def changed(self, name: str, changes: Iterable[tuple[str, Any]]) -> ObjectPreset:
        """Return a preset of an object with other values of some keys.

        Parameters
        ----------
        name : str
            Name of the preset.
        changes : iterable of (str, value)
            Keys of the preset, as of `/object/new`, and their values.

        Returns
        -------
        ObjectPreset
            The object.

        Raises
        ------
        PresetError
            There is no such preset, or a key is refused; the text names it.
        """
        given = dict(changes)
        if "size" in given:
            size = given.pop("size")
            return self.changed(name, tuple(given.items())).in_size(size, given)
        return self.object(name).replace(**given) if given else self.object(name)

    def load(self, kind: str, path: Path) -> Material | StrikerPreset | SurfacePreset | ObjectPreset:
        """Load a preset from a file; presets that it names are looked up here.

        Parameters
        ----------
        kind : {"objects", "strikers", "surfaces", "materials"}
            Kind of the preset.
        path : Path
            Its TOML file.

        Returns
        -------
        Material, StrikerPreset, SurfacePreset or ObjectPreset
            The preset.

        Raises
        ------
        PresetError
            The file is wrong; the text says why.
        ValueError
            There is no such kind.
        """
        where, data = read_file(path)
        if kind == "materials":
            return _material(path.stem, where, data)
        if kind == "strikers":
            return StrikerPreset.from_data(path.stem, where, data, self)
        if kind == "surfaces":
            return SurfacePreset.from_data(path.stem, where, data)
        if kind == "objects":
            return self._object(path.stem, path)
        raise ValueError(f"kind = {kind!r}: {expected(kind, KINDS)}")

    def description(self, kind: str, name: str) -> str:
        """Return the description of a preset, or its source if it has none.

        Parameters
        ----------
        kind : {"objects", "strikers", "surfaces", "materials"}
            Kind of the preset.
        name : str
            Name of the preset.

        Returns
        -------
        str
            One line.

        Raises
        ------
        PresetError
            There is no such preset.
        """
        data = self._read(kind, name)[1]
        return str(data.get("description", data.get("source", "")))

    def path(self, kind: str, name: str) -> Path:
        """Return the file of a preset.

        Parameters
        ----------
        kind : {"objects", "strikers", "surfaces", "materials"}
            Kind of the preset.
        name : str
            Name of the preset.

        Returns
        -------
        Path
            Its TOML file.

        Raises
        ------
        PresetError
            There is no such preset.
        """
        singular = kind.removesuffix("s")
        if not NAME.fullmatch(name):
            raise PresetError(f"{singular} {shown(name)}: expected {Name()}")
        for folder in self._folders:
            # Not as a Path before it is one of ours: pathlib keeps the parts of all it ever made.
            path = f"{folder}/{kind}/{name}.toml"
            if os.path.isfile(path):
                return Path(path)
        if kind == "objects" and name.startswith(_MADE):
            from .meshes import cache_folder

            made = cache_folder() / kind / f"{name}.toml"
            if made.is_file():
                return made
        raise NoPreset(f"no {singular} {name!r}", lambda: expected(name, self.names(kind)))

    def _object(self, name: str, path: Path) -> ObjectPreset:
        """Return the object of a file."""
        where, data = read_file(path)
        if data.get("shape") == "mesh":
            from .made import require_digest  # with what computes
            from .meshes import with_table

            data = with_table(where, data, path.parent, self)
            require_digest(name, data)
        return ObjectPreset.from_data(name, where, data, self)

    def _read(self, kind: str, name: str) -> tuple[str, dict[str, Any]]:
        """Return the beginning of errors about a preset's file, and the file's data."""
        return read_file(self.path(kind, name))


def read_file(path: Path) -> tuple[str, dict[str, Any]]:
    """Return the beginning of errors about a file, and its data, which nobody may change; raise PresetError if it
    cannot be read."""
    try:
        return f"{path}: ", _data(path)
    except PresetError:
        raise
    except (ValueError, RecursionError) as error:  # not only TOMLDecodeError: an integer may have too many digits
        raise PresetError(f"{path}: not TOML: {error}") from None
    except OSError as error:
        raise PresetError(f"{path}: {error.strerror}") from None


def _material(name: str, where: str, data: dict[str, Any]) -> Material:
    values = check(where, data, MATERIAL, MATERIAL_REQUIRED)
    values.pop("source")
    return Material(name, **values)


def _data(path: Path) -> dict[str, Any]:
    """Return the data of a TOML file as it is now; nobody may change them."""
    now, file = time.time_ns(), path.stat()
    if now - max(file.st_mtime_ns, file.st_ctime_ns) < _SETTLED:
        return _parsed(path)
    return _kept_data(path, (file.st_mtime_ns, file.st_ctime_ns, file.st_ino, file.st_size))


@lru_cache(maxsize=256)  # an object and its striker need eight files, which take 1.5 ms to parse
def _kept_data(path: Path, edition: tuple[int, ...]) -> dict[str, Any]:
    """Return the data of an edition of a file."""
    return _parsed(path)


def _parsed(path: Path) -> dict[str, Any]:
    with path.open("rb") as file:
        content = file.read(MOST_BYTES + 1)
    if len(content) > MOST_BYTES:
        raise PresetError(f"{path}: expected at most {MOST_BYTES} bytes")
    if (keys := content.count(b"=")) > MOST_KEYS:
        raise PresetError(f"{path}: {keys} keys: expected at most {MOST_KEYS}")
    return tomllib.loads(content.decode())
