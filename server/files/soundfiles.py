"""Sound files as Carom writes them."""

import soundfile

_SET_ADD_PEAK_CHUNK = 0x1050  # libsndfile's command numbers
_RF64_AUTO_DOWNGRADE = 0x1210
_SET_UPDATE_HEADER_AUTO = 0x1061

WAV_BYTES = (1 << 32) - (1 << 16)
"""What a WAV file can hold; RF64 has no such limit."""


def open_sound(descriptor: int, rate: int, container: str, subtype: str) -> soundfile.SoundFile:
    """Write stereo to an open file (its descriptor stays open): container WAV, FLAC, or RF64, which becomes a WAV if
    its size allows. LibsndfileError where it can't be.

    A descriptor, as libsndfile then sees write errors itself.
    """
    file = soundfile.SoundFile(descriptor, "w", rate, 2, subtype=subtype, format=container, closefd=False)
    # The peak chunk holds the time of day, and equal sounds would not be equal files. soundfile has no word for this.
    for command, value in ((_SET_ADD_PEAK_CHUNK, 0), (_RF64_AUTO_DOWNGRADE, 1)):
        _tell(file, command, value)
    return file


def keep_readable(file: soundfile.SoundFile) -> None:
    """Have the sizes in a file's header made right at every write, and not only at its end."""
    _tell(file, _SET_UPDATE_HEADER_AUTO, 1)


def _tell(file: soundfile.SoundFile, command: int, value: int) -> None:
    soundfile._snd.sf_command(file._file, command, soundfile._ffi.NULL, value)
