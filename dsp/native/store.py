"""The files of compiled code: what came along with the package, and what is kept in the user's cache.

    translations/COMPILER/NAME        a kernel's translation, or a record's fields (in the cache alone)
    units/KEY/source.HASH.bc          a unit's bitcode before it is optimised (in the cache alone)
    units/KEY/TARGET.HASH.bc          the same, optimised for a target (in the cache alone)
    units/KEY/TARGET.HASH.o           machine code for a target
    units/KEY/TARGET.HASH.image       units' machine code, linked (`images.py`): all that a package holds of them
    modules/MODULE/KEY/listed.json    the sources of a module with functions of C, and for each target its units
    modules/MODULE/KEY/lock           a file that whoever compiles these sources locks meanwhile

A target is written SYSTEM-PROCESSOR; HASH is one of the file's own content, by which a damaged one is found out. Files
appear whole, whoever reads them at the same time.
"""

import json
import os
import shutil
import stat
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import NamedTuple

import platformdirs

from .digests import digest
from .sources import hash_of
from .targets import Target

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

PACKAGED = Path(__file__).parent / "objects"
"""The folder in which a wheel holds its code."""

_FOLDERS = ("translations", "units", "modules")
_MOST = 200e6  # bytes in the cache before what was not used for longest goes, and is not in use
_IN_USE = 30 * 86_400.0  # s since a list was used last, in which its units and images stay
_FRESH = 3_600.0  # s in which what was made or used stays: another process may compile, whose list is not written yet
_VERSIONS_KEPT = 8  # of a module's list of units
_COMPILERS_KEPT = 2  # of those that were not used lately


def user_cache() -> Path:
    """Return the folder of the user's cache; where it can't be written, one of the user's among temporary files."""
    why = _unwritable(usual_cache())
    return _other_cache(why) if why else usual_cache()


def usual_cache() -> Path:
    """Return the folder of the user's cache, whether or not it can be written."""
    return platformdirs.user_cache_path("carom") / "code"


def is_kept(root: Path) -> bool:
    """True if later processes find what lies in a folder of the cache."""
    return root not in [Path(each.name) for each in _PASSING]


def _unwritable(root: Path) -> str:
    """Make the folders of a cache; say why they can't be written, if they can't."""
    try:
        for folder in (root, *(root / name for name in _FOLDERS)):
            folder.mkdir(parents=True, exist_ok=True)
            if not os.access(folder, os.W_OK):
                return f"no right to write {folder}"
    except OSError as error:
        return str(error)
    return ""


@cache
def _other_cache(why: str) -> Path:
    """Return a folder among temporary files that this user alone can write, kept from one start to the next; one that
    goes with this process where that can't be had. Its code will run, so that others' folders are not taken."""
    root = Path(tempfile.gettempdir()) / (f"carom-code-{os.getuid()}" if hasattr(os, "getuid") else "carom-code")
    with suppress(FileExistsError):
        root.mkdir(mode=0o700)
        _warn("cannot write the code cache (%s): it is kept in %s; XDG_CACHE_HOME may name another folder", why, root)
    refused = _foreign(root) or _unwritable(root)
    if not refused:
        return root
    text = "cannot write the code cache (%s; %s): each start compiles anew; XDG_CACHE_HOME may name another folder"
    _warn(text, why, refused)
    folder = tempfile.TemporaryDirectory(prefix="carom-code-")
    _PASSING.append(folder)  # it is removed at the end of the process
    return Path(folder.name)


def _foreign(root: Path) -> str:
    """Say why others than this user might write what a folder among temporary files holds, if they might."""
    if not hasattr(os, "getuid"):
        return ""  # Windows has a folder of temporary files for each user
    above, own = root.parent.stat(), root.lstat()
    if above.st_mode & 0o022 and not above.st_mode & stat.S_ISVTX:
        return f"others may rename what is in {root.parent}"
    if not stat.S_ISDIR(own.st_mode) or own.st_uid != os.getuid() or own.st_mode & 0o077:
        return f"{root} is not this user's alone"
    return ""


_PASSING: list[tempfile.TemporaryDirectory[str]] = []


def image_key(units: list[str]) -> str:
    """Return the name by which an image of units is kept."""
    return digest(f"{units} {hash_of([f'{__package__}.images'])}")


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
                _touch(self._translations)
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

    def use_list(self, module: str, key: str) -> None:
        """Note that a module's list is in use, and so its units and images."""
        _touch(self._module(module) / key)

    def use_unit(self, key: str) -> None:
        """Note that a unit, or what is kept like one, is in use."""
        _touch(self._unit(key))

    def prune(self) -> None:
        """Remove the units and translations that were not used for longest, where there are too many. What a list in
        use names stays, whatever its size, and what is being made."""
        _remove_but(self.root.glob("translations/*"), _COMPILERS_KEPT)
        kept, now = [*self.root.glob("units/*"), *self.root.glob("translations/*/*")], time.time()
        sizes = {path: _size(path) for path in kept}
        total, used = sum(sizes.values()), self._units_in_use(now)
        for path in sorted(kept, key=_last_used):
            if total <= _MOST or now - _last_used(path) < _FRESH:
                break
            if path.name in used:
                continue
            total -= sizes[path]
            if path.is_dir():
                shutil.rmtree(path, ignore_errors=True)
            else:
                path.unlink(missing_ok=True)

    def _units_in_use(self, now: float) -> set[str]:
        """Return the keys of the units that lists in use name, and of their images."""
        found: set[str] = set()
        for module in self.root.glob("modules/*"):
            for key, listed in self.lists(module.name):
                if now - _last_used(module / key) < _IN_USE:
                    found.update(*listed.units.values(), map(image_key, listed.units.values()))
        return found

    @contextmanager
    def alone(self, module: str, key: str) -> Iterator[None]:
        """Keep other processes from compiling a module of the same sources meanwhile: they wait, and load what this one
        made. Where no file can be locked, each compiles for itself."""
        with ExitStack() as stack:
            if fcntl:
                with suppress(OSError):
                    folder = self._module(module) / key
                    folder.mkdir(parents=True, exist_ok=True)
                    fcntl.flock(stack.enter_context((folder / "lock").open("w")), fcntl.LOCK_EX)
            yield

    def _unit(self, key: str) -> Path:
        return self.root / "units" / key

    def _module(self, module: str) -> Path:
        return self.root / "modules" / module


def _warn(text: str, *values: object) -> None:
    import logging  # slow to load

    logging.getLogger(__name__).warning(text, *values)


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
    """Remove all but a number of folders: those that were used last stay, and what another process may be using."""
    for folder in sorted((each for each in folders if each.is_dir()), key=_last_used, reverse=True)[kept:]:
        if time.time() - _last_used(folder) >= _FRESH:
            shutil.rmtree(folder, ignore_errors=True)
