"""The versions that decide over the bytes of a data set, by name: all workers of one, and all runs, must agree on
them."""

from __future__ import annotations

import hashlib
import io
import re
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path

import numpy as np
import soundfile
import threadpoolctl

from ... import clients, dsp, presets, server
from ...dsp.errors import CaromError
from ...dsp.runtime.entry import callback
from ...server.provenance import computing

_VENDOR = re.compile(rb"reference libFLAC [\w.-]+")


class VersionError(CaromError, RuntimeError):
    """Something that computes is not what it is elsewhere; the text names it and says both."""


@cache
def versions(folders: tuple[str, ...] = ()) -> Mapping[str, str]:
    """Return the versions of all that computes here. folders: of the user's presets."""
    return {
        "carom": version("carom"),
        "sources": _hash(path for package in (dsp, presets, server, clients) for path in _files(_home(package))),
        "presets": _hash(path for folder in folders for path in _files(Path(folder))),
        **computing(callback.code),
        "scipy": version("scipy"),
        "blas": _blas(),
        "simd": " ".join(np.show_config(mode="dicts")["SIMD Extensions"].get("found", ())),
        "libsndfile": soundfile.__libsndfile_version__,
        "libflac": _flac(),
        "pyarrow": version("pyarrow"),
    }


def require_same(expected: Mapping[str, str], found: Mapping[str, str], where: str) -> None:
    """Raise VersionError that names all that differs; `where` begins the text: of what it is."""
    names = [name for name in {**expected, **found} if expected.get(name) != found.get(name)]
    if names:
        told = (f"{name} {found.get(name, 'missing')}: expected {expected.get(name, 'none')}" for name in names)
        raise VersionError(f"{where}: {'; '.join(told)}")


def _home(package: object) -> Path:
    return Path(str(package.__path__[0]))  # type: ignore[attr-defined]


def _files(folder: Path) -> Iterator[Path]:
    """Return the programs and presets in a folder, in an order that is the same everywhere."""
    found = (path for path in folder.rglob("*") if path.suffix in (".py", ".toml"))
    return iter(sorted(found, key=lambda path: path.relative_to(folder).as_posix()))


def _hash(paths: Iterator[Path]) -> str:
    """Hash files' names and contents; "none" of no file."""
    digest = hashlib.sha256()
    count = 0
    for count, path in enumerate(paths, 1):  # noqa: B007 - the last one counts them
        content = path.read_bytes()
        digest.update(f"{path.name}\0{len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest()[:16] if count else "none"


def _blas() -> str:
    """Return the libraries of linear algebra, and the kinds of processor that they chose code for."""
    import scipy.linalg  # noqa: F401 - its library is to be found

    found = [each for each in threadpoolctl.threadpool_info() if each["user_api"] == "blas"]
    return ", ".join(
        sorted({f"{each['internal_api']} {each['version']} {each.get('architecture', '')}".strip() for each in found})
    )


def _flac() -> str:
    """Return the encoder of FLAC, as it signs its files."""
    memory = io.BytesIO()
    soundfile.write(memory, np.zeros(1), 48_000, format="FLAC")
    found = _VENDOR.search(memory.getvalue())
    return found[0].decode().rsplit(" ", 1)[1] if found else "unknown"
