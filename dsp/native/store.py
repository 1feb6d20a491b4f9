"""The files of compiled code: what came along with the package, and what is kept in the user's cache.

    translations/COMPILER/NAME        a kernel's translation, or a record's fields (in the cache alone)
    units/KEY/source.HASH.bc          a unit's bitcode before it is optimised (in the cache alone)
    units/KEY/TARGET.HASH.bc          the same, optimised for a target (in the cache alone)
    units/KEY/TARGET.HASH.o           machine code for a target
    units/KEY/TARGET.HASH.image       units' machine code, linked (`images.py`): all that a package holds of them
    modules/MODULE/KEY/listed.json    the sources of a module with functions of C, and for each target its units

A target is written SYSTEM-PROCESSOR; HASH is one of the file's own content, by which a damaged one is found out. Files
appear whole, whoever reads them at the same time.
"""

import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import NamedTuple

import platformdirs

from .digests import digest
from .targets import Target

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

PACKAGED = Path(__file__).parent / "objects"
"""The folder in which a wheel holds its code."""

_FOLDERS = ("translations", "units", "modules")
_MOST = 200e6  # bytes in the cache before what was not used for longest goes
_VERSIONS_KEPT = 8  # of a module's list of units
_COMPILERS_KEPT = 2


def user_cache() -> Path:
    """Return the folder of the user's cache; where it can't be written, one that goes with this process."""
    root = platformdirs.user_cache_path("carom") / "code"
    try:
        for folder in (root, *(root / name for name in _FOLDERS)):
            folder.mkdir(parents=True, exist_ok=True)
            if not os.access(folder, os.W_OK):
                return _passing_cache(f"no right to write {folder}")
        return root
    except OSError as error:
        return _passing_cache(str(error))


@cache
def _passing_cache(why: str) -> Path:
    text = "cannot write the code cache (%s): every start makes it anew; XDG_CACHE_HOME may name another folder"
    _warn(text, why)
    folder = tempfile.TemporaryDirectory(prefix="carom-code-")
    _PASSING.append(folder)  # it is removed at the end of the process
    return Path(folder.name)


_PASSING: list[tempfile.TemporaryDirectory[str]] = []


class Listed(NamedTuple):
    """The content of a module's list."""

    sources: list[str]  # names of modules
    units: dict[str, list[str]]  # their keys, for each target


class Store:
    """The files under one root.

    compiler: a digest of all that makes translations; those of another compiler are not found.
    """

    def __init__(self, root: Path, compiler: str = "") -> None:
        self.root = root
        self._translations = root / "translations" / compiler

    def read_translation(self, name: str) -> bytes | None:
        """Return what `write_translation` kept by a name; None where there is none that is whole."""
        file = self._translations / name
        with suppress(OSError):
            content = file.read_bytes()
            if content[:20] == digest(content[20:]).encode():
                _touch(file)
                return content[20:]
        return None

    def write_translation(self, name: str, content: bytes) -> None:
        """Keep the content of a translation, or of a record's fields."""
        _write(self._translations / name, digest(content).encode() + content)

    def read_unit(self, key: str, what: str, kind: str) -> bytes | None:
        """Return a file of a unit, "source" or of a target, by its kind; None where there is none that is whole."""
        found = self.unit_file(key, what, kind)
        return found[1] if found else None

    def unit_file(self, key: str, what: str, kind: str) -> tuple[Path, bytes] | None:
        """Return the path and the content of what `read_unit` reads."""
        for file in self._unit(key).glob(f"{what}.*.{kind}"):
            with suppress(OSError):
                content = file.read_bytes()
                if file.suffixes[-2] == f".{digest(content)}":
                    return file, content
                _warn("the compiled code in %s is damaged", file)
        return None

    def write_unit(self, key: str, what: str, kind: str, content: bytes) -> None:
        """Keep a file of a unit."""
        _write(self._unit(key) / f"{what}.{digest(content)}.{kind}", content)

    def read_object(self, key: str, target: Target) -> bytes | None:
        """Return a unit's machine code for a target."""
        return self.read_unit(key, str(target), "o")

    def write_object(self, key: str, target: Target, made: bytes) -> None:
        """Keep a unit's machine code for a target."""
        self.write_unit(key, str(target), "o", made)

    def lists(self, module: str) -> Iterator[tuple[str, Listed]]:
        """Yield the keys of a module's lists that can be read, and what they say."""
        for folder in sorted(self._module(module).glob("*")):
            with suppress(OSError, ValueError, KeyError, TypeError, AttributeError):
                said = json.loads((folder / "listed.json").read_text())
                units = {str(target): [str(each) for each in keys] for target, keys in said["units"].items()}
                yield folder.name, Listed([str(each) for each in said["sources"]], units)

    def write_list(self, module: str, key: str, listed: Listed) -> None:
        """Keep a module's list by its key, and remove all but the last few others."""
        _write(self._module(module) / key / "listed.json", json.dumps(listed._asdict()).encode())
        _remove_but(self._module(module).glob("*"), _VERSIONS_KEPT)

    def use_list(self, module: str, key: str, image: str) -> None:
        """Note that a module's list, its units and an image of them are in use."""
        _touch(self._unit(image))
        for name, listed in self.lists(module):
            if name == key:
                _touch(self._module(module) / key)
                for unit in {unit for units in listed.units.values() for unit in units}:
                    _touch(self._unit(unit))

    def prune(self) -> None:
        """Remove the units and translations that were not used for longest, where there are too many."""
        _remove_but(self.root.glob("translations/*"), _COMPILERS_KEPT)
        kept = [*self.root.glob("units/*"), *self.root.glob("translations/*/*")]
        sizes = {path: _size(path) for path in kept}
        total = sum(sizes.values())
        for path in sorted(kept, key=_last_used):
            if total <= _MOST:
                break
            total -= sizes[path]
            if path.is_dir():
                shutil.rmtree(path, ignore_errors=True)
            else:
                path.unlink(missing_ok=True)

    @contextmanager
    def alone(self, module: str) -> Iterator[None]:
        """Keep other processes from compiling a module meanwhile: they wait, and load what this one made. Where no file
        can be locked, each compiles for itself."""
        with ExitStack() as stack:
            if fcntl:
                with suppress(OSError):
                    folder = self._module(module)
                    folder.mkdir(parents=True, exist_ok=True)
                    fcntl.flock(stack.enter_context((folder / "lock").open("w")), fcntl.LOCK_EX)
            yield

    def _unit(self, key: str) -> Path:
        return self.root / "units" / key

    def _module(self, module: str) -> Path:
        return self.root / "modules" / module


def _warn(text: str, value: object) -> None:
    import logging  # slow to load

    logging.getLogger(__name__).warning(text, value)


def _write(file: Path, content: bytes) -> None:
    """Write a file that another process may read at the same time."""
    partly = file.with_name(f"{file.name}.{os.getpid()}")
    try:
        partly.write_bytes(content)
    except FileNotFoundError:
        file.parent.mkdir(parents=True, exist_ok=True)
        partly.write_bytes(content)
    partly.replace(file)


def _touch(path: Path) -> None:
    with suppress(OSError):
        os.utime(path)


def _last_used(path: Path) -> float:
    with suppress(OSError):
        return path.stat().st_mtime
    return 0.0


def _size(path: Path) -> int:
    with suppress(OSError):
        return sum(each.stat().st_size for each in path.glob("*")) if path.is_dir() else path.stat().st_size
    return 0


def _remove_but(folders: Iterator[Path], kept: int) -> None:
    """Remove all but a number of folders: those that were used last stay."""
    for folder in sorted((each for each in folders if each.is_dir()), key=_last_used, reverse=True)[kept:]:
        shutil.rmtree(folder, ignore_errors=True)
