"""Sound files as Carom writes them: float WAV by itself, PCM and FLAC by libsndfile."""

from typing import Any, Protocol

from numpy.typing import NDArray

from .floatwav import FloatWav

_SET_ADD_PEAK_CHUNK = 0x1050  # libsndfile's command number

WAV_BYTES = (1 << 32) - (1 << 16)
"""Bytes that a WAV file can hold; RF64 has no such limit."""


class SoundWriter(Protocol):
    """A sound file that is being written."""

    def write(self, frames: NDArray[Any], /) -> None:
        """Append frames, (frames, channels)."""

    def close(self) -> None:
        """Complete the file; its descriptor stays open."""


def open_sound(
    descriptor: int, rate: int, channels: int, container: str, subtype: str, comment: str = ""
) -> SoundWriter:
    """Write sound at a rate (Hz) to an open, empty file: container WAV or FLAC, subtype as libsndfile names it.

    comment: ASCII, in its metadata. Errors here and in `write`: OSError for float WAV, a RuntimeError for the rest.
    """
    if (container, subtype) == ("WAV", "FLOAT"):
        return FloatWav(descriptor, rate, channels, comment)
    import soundfile  # slow to load

    # libsndfile gets the descriptor itself, so that it sees errors of writing.
    file = soundfile.SoundFile(descriptor, "w", rate, channels, subtype=subtype, format=container, closefd=False)
    # The peak chunk holds the time of day, and equal sounds would not be equal files. soundfile has no word for this.
    soundfile._snd.sf_command(file._file, _SET_ADD_PEAK_CHUNK, soundfile._ffi.NULL, 0)
    if comment:
        file.comment = comment
    writer: SoundWriter = file
    return writer
