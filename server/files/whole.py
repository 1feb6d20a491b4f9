"""Sound files that appear under their names once they are whole."""

import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...dsp.errors import CaromError
from .soundfiles import WAV_BYTES, open_sound

_ENDINGS = {".wav": "WAV", ".flac": "FLAC"}
_SUBTYPES = {"16": "PCM_16", "24": "PCM_24", "float": "FLOAT"}
_MOST_IN_FLAC = 8  # channels


class RenderError(CaromError, ValueError):
    """The render cannot be made; the text says why."""


@contextmanager
def writing(
    out: Path, rate: int, channels: int, format: str | None = None, comment: str = ""
) -> Iterator[Callable[[NDArray[np.float32]], None]]:
    """Open a WAV or FLAC file, chosen by its ending, at a rate in Hz; yield a function that appends float32 (frames,
    channels).

    format: 16, 24 or float (None: 24 for FLAC, else float). comment: in the file's metadata. The file appears under its
    name once it is whole.
    RenderError or OSError say what went wrong.
    """
    require_name(out)
    container = _ENDINGS[out.suffix.lower()]
    require_format(format)
    if container == "FLAC" and format == "float":
        raise RenderError(f"format = {format}: {container} holds 16 or 24")
    subtype = _SUBTYPES[format or ("24" if container == "FLAC" else "float")]
    if container == "FLAC" and channels > _MOST_IN_FLAC:
        raise RenderError(f"{out}: {channels} channels: FLAC holds at most {_MOST_IN_FLAC}")
    with appearing(out) as descriptor:
        with _naming(out):
            file = open_sound(descriptor, rate, channels, container, subtype, comment)

        def write(sound: NDArray[np.float32]) -> None:
            with _naming(out):
                file.write(sound)
            if container == "WAV" and os.fstat(descriptor).st_size > WAV_BYTES:
                raise RenderError(f"{out}: longer than the 4 GiB that a WAV file holds; FLAC holds more")

        try:
            yield write
        finally:
            with _naming(out):
                file.close()


def require_name(out: Path) -> None:
    """Raise RenderError for a name that no sound file can have, or whose folder is not there."""
    if out.suffix.lower() not in _ENDINGS:
        raise RenderError(f"{out}: expected a name that ends in {' or '.join(_ENDINGS)}")
    if not out.parent.is_dir():
        raise RenderError(f"{out}: there is no folder {out.parent}")


def require_format(format: str | None) -> None:
    """Raise RenderError for a sample format that does not exist."""
    if format not in (None, *_SUBTYPES):
        raise RenderError(f"format = {format}: expected {', '.join(_SUBTYPES)}")


@contextmanager
def _naming(out: Path) -> Iterator[None]:
    """Name the file in an error of writing inside."""
    try:
        yield
    except RuntimeError as error:  # libsndfile's
        raise RenderError(f"{out}: {error} Is the disk full?") from error
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(out)) from error


@contextmanager
def appearing(out: Path, durable: bool = False) -> Iterator[int]:
    """Yield a new file (its descriptor) that takes its name once it is whole, and is removed if it never is.

    durable: it is on the disk before it has its name.
    """
    descriptor, name = tempfile.mkstemp(prefix=f"{out.name}.", suffix=".part", dir=out.parent)
    part = Path(name)
    try:
        try:
            yield descriptor
            if durable:
                os.fsync(descriptor)
        finally:
            os.close(descriptor)  # Windows renames no file that is open
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(part, 0o666 & ~umask)  # mkstemp's are private
        os.replace(part, out)
    finally:
        part.unlink(missing_ok=True)
