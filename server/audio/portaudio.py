"""PortAudio as a library: its loading, its devices, and a fresh copy of it where the old one may not be touched."""

import atexit
import ctypes
import sys
import tempfile
import threading
from pathlib import Path
from typing import Any

from ...dsp.errors import CaromError

_NO_START_SERVER = 1  # JACK's option

NONE_FOUND = "no device can play: start JACK, PipeWire or PulseAudio, or `carom serve --device none`"
"""Text of the error where there is no output device."""

_spent = threading.Event()
"""Set where PortAudio may not be touched again: its JACK server has gone, or a stream of it does not end."""


class AudioError(CaromError, RuntimeError):
    """Sound cannot be played; the text says why, and what might help."""


def portaudio() -> Any:
    """Return the sounddevice module; raise AudioError where PortAudio is missing."""
    try:
        import sounddevice
    except OSError as error:
        raise AudioError(
            f"{error}: install PortAudio (Debian: apt install libportaudio2; macOS: brew install portaudio), "
            "or serve with --device none"
        ) from error
    return sounddevice


def give_up() -> None:
    """Give up the present copy of PortAudio for good; `look_for_devices` loads a fresh one."""
    _spent.set()


def never_end() -> None:
    """Keep PortAudio loaded and running to the end of the process, as its threads go on."""
    atexit.unregister(portaudio()._exit_handler)
    if sys.platform == "linux":
        ctypes.CDLL(_library("portaudio"))


def _leave_portaudio() -> None:
    """Load a fresh copy of PortAudio, and never touch the present one again.

    When PortAudio 19.6 or 19.7 stops a stream whose JACK server has gone, it waits ten minutes for its thread, and then
    an assertion ends the process. Another assertion does so when PortAudio is ended
    (https://github.com/PortAudio/portaudio/issues/820).
    """
    sd = portaudio()
    never_end()
    with tempfile.NamedTemporaryFile(suffix=".so") as copy:
        copy.write(Path(_library("portaudio")).read_bytes())
        copy.flush()
        ctypes.CDLL(copy.name)  # unlike ffi, ctypes never unloads it
        sd._lib = sd._ffi.dlopen(copy.name)
    sd._initialized = 0
    _spent.clear()


def _library(name: str) -> str:
    """Return the path that a library was loaded from."""
    for line in Path("/proc/self/maps").read_text(encoding="utf-8", errors="surrogateescape").splitlines():
        if f"/lib{name}" in line:
            return line.split(maxsplit=5)[-1]  # blanks in its path are its own
    raise OSError(f"lib{name} is not loaded")


def jack_rate() -> float:
    """Return the sampling rate (Hz) of the running JACK server, 0 without one: JACK says it, not PortAudio."""
    jack = ctypes.CDLL(_library("jack"))
    jack.jack_client_open.restype = ctypes.c_void_p
    client = jack.jack_client_open(b"carom-asks", _NO_START_SERVER, ctypes.byref(ctypes.c_int()))
    if not client:
        return 0.0
    try:
        return float(jack.jack_get_sample_rate(ctypes.c_void_p(client)))
    finally:
        jack.jack_client_close(ctypes.c_void_p(client))


def look_for_devices() -> None:
    """Make PortAudio list its devices anew. No stream may be open, but for those of devices that are gone.

    While PortAudio is connected to a JACK server the list stays as it is: if that server goes, opening a stream fails,
    and the next call here loads a fresh copy.
    """
    sd = portaudio()
    if _spent.is_set():
        _leave_portaudio()
    elif sd._initialized:
        if any("JACK" in api["name"] for api in sd.query_hostapis()):
            return
        sd._terminate()
    sd._initialize()


def devices() -> list[dict[str, Any]]:
    """Return PortAudio's output devices: index, name, hostapi, channels, default_samplerate, default."""
    sd = portaudio()
    apis = sd.query_hostapis()
    default = sd.default.device[1]
    return [
        {
            "index": index, "name": device["name"], "hostapi": apis[device["hostapi"]]["name"],
            "channels": device["max_output_channels"], "default_samplerate": device["default_samplerate"],
            "default": index == default,
        }
        for index, device in enumerate(sd.query_devices())
        if device["max_output_channels"] > 0
    ]  # fmt: skip
