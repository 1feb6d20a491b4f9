"""Where the sound goes in real time: PortAudio's devices, or nowhere, paced by the clock.

PortAudio is handed the compiled callback itself, so that no Python runs, and no GIL is waited for, between the device
and the engine. sounddevice offers the hook to library authors: `_StreamBase` with `wrap_callback=None`.
"""

import atexit
import ctypes
import sys
import tempfile
import threading
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from ..dsp.atomic import publish
from ..dsp.host import Engine
from ..dsp.pacer import pacer

_CLOCK_BLOCK = 480
_DEVICE_UNAVAILABLE = -9985  # PortAudio's error


class AudioError(RuntimeError):
    """Sound can't be played; the text says why, and what might help."""


class Output(Protocol):
    """Something that makes an engine run, from `start` until it is closed."""

    name: str
    latency: float  # s

    def start(self) -> None: ...

    def active(self) -> bool: ...

    def close(self) -> None: ...


class ClockOutput:
    """No device: a compiled loop, in a thread of its own, that computes a block whenever its time has come."""

    name = "none"

    def __init__(self, engine: Engine, block: int, latency: float | None) -> None:
        frames = block or _CLOCK_BLOCK
        self.latency = max(frames / engine.rate, latency or 0.0)
        self._engine = engine
        self._running = np.ones(1, np.int64)
        memory = np.zeros((frames, 2), np.float32), np.zeros(3)
        args = self._running, engine.address, engine.pointer, engine.rate, *memory
        self._thread = threading.Thread(target=pacer(), args=args, name="carom-clock", daemon=True)

    def start(self) -> None:
        self._engine.set_latency(self.latency)
        self._thread.start()

    def active(self) -> bool:
        return True

    def close(self) -> None:
        publish(self._running, 0)
        if self._thread.ident:
            self._thread.join()


class DeviceOutput:
    """A PortAudio device, which calls the compiled engine from its own thread."""

    def __init__(self, engine: Engine, device: int | str | None, block: int, latency: float | None) -> None:
        self._sd = portaudio()
        self._engine = engine  # the callback writes to its memory: it must live as long as the stream
        self._asked = "default" if device is None else str(device)
        ffi = self._sd._ffi
        try:
            found = self._sd.query_devices(device, "output")
            self._api = str(self._sd.query_hostapis(found["hostapi"])["name"])
            self._stream = self._sd._StreamBase(
                kind="output", samplerate=engine.rate, blocksize=block, device=device, channels=2, dtype="float32",
                latency="low" if latency is None else latency, userdata=ffi.cast("void*", engine.pointer),
                callback=ffi.cast("PaStreamCallback*", engine.address), wrap_callback=None,
            )  # fmt: skip
        except (self._sd.PortAudioError, ValueError) as error:
            if _DEVICE_UNAVAILABLE in error.args and self._on_jack():
                _leave_portaudio()
            raise self._error(error) from error
        self.name = str(found["name"])
        self.full_name = f"{self.name}, {self._api}"
        """By which it is found again."""
        self.latency = float(self._stream.latency)
        if self._on_jack():
            # At the end, too, JACK may have gone: PortAudio is not told to end, and stays loaded, as its threads go on.
            atexit.unregister(self._sd._exit_handler)
            ctypes.CDLL(_library())

    def _on_jack(self) -> bool:
        return "JACK" in self._api and sys.platform == "linux"  # elsewhere it is a rarity

    def _error(self, error: Exception) -> AudioError:
        hint = "`carom devices` lists what there is, `--device none` plays without one"
        return AudioError(f"device {self._asked}: {' '.join(str(error).split())}; {hint}")

    def start(self) -> None:
        self._engine.set_latency(self.latency)
        try:
            self._stream.start()
        except self._sd.PortAudioError as error:
            self._stream.close(ignore_errors=True)
            raise self._error(error) from error

    def active(self) -> bool:
        return bool(self._stream.active)

    def close(self) -> None:
        if self._stream.active:
            self._stream.stop(ignore_errors=True)  # once all that was computed is played
        elif self._on_jack():
            _leave_portaudio()
            return
        self._stream.close(ignore_errors=True)


def portaudio() -> Any:
    """The sounddevice module, or AudioError where PortAudio is missing."""
    try:
        import sounddevice
    except OSError as error:
        raise AudioError(
            f"{error}: install PortAudio (Debian: apt install libportaudio2; macOS: brew install portaudio), "
            "or serve with --device none"
        ) from error
    return sounddevice


def _leave_portaudio() -> None:
    """Go on with a fresh copy of PortAudio, and never touch the present one again.

    Told to stop a stream whose JACK server has gone, PortAudio 19.6 and 19.7 wait ten minutes for its thread, and then
    an assertion ends the process, as another does when they are told to end
    (https://github.com/PortAudio/portaudio/issues/820).
    """
    sd = portaudio()
    with tempfile.NamedTemporaryFile(suffix=".so") as copy:
        copy.write(Path(_library()).read_bytes())
        copy.flush()
        ctypes.CDLL(copy.name)  # which, unlike ffi, never unloads it
        sd._lib = sd._ffi.dlopen(copy.name)
    sd._initialized = 0
    sd._initialize()


def _library() -> str:
    """Where PortAudio was loaded from."""
    lines = Path("/proc/self/maps").read_text().splitlines()
    return next(line.split()[-1] for line in lines if "libportaudio" in line)


def look_for_devices() -> None:
    """Have PortAudio see what has come and gone; no stream may be open.

    Connected to a JACK server it stays as it is: if that goes, opening a stream tells, and begins with a fresh copy.
    """
    sd = portaudio()
    if not any("JACK" in api["name"] for api in sd.query_hostapis()):
        sd._terminate()
        sd._initialize()


def open_output(engine: Engine, device: str | None, block: int, latency: float | None = None) -> Output:
    """An output for an engine, to be started: None the default device, "none" no device, else its index or part of its
    name.

    Its latency (s) is asked for, None meaning the lowest; what it gives is the output's `latency`.
    """
    if device == "none":
        return ClockOutput(engine, block, latency)
    return DeviceOutput(engine, int(device) if device and device.isdigit() else device, block, latency)


def devices() -> list[dict[str, Any]]:
    """PortAudio's output devices: index, name, hostapi, channels, default_samplerate, default."""
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
