"""Where the sound goes in real time: PortAudio's devices, or nowhere, paced by the clock.

PortAudio is handed the compiled callback itself, so that no Python runs, and no GIL is waited for, between the device
and the engine. sounddevice offers the hook to library authors: `_StreamBase` with `wrap_callback=None`.
"""

import threading
import time
from typing import Any, Protocol

from ..dsp.host import Engine

_CLOCK_BLOCK = 480


class AudioError(RuntimeError):
    """Sound can't be played; the text says why, and what might help."""


class Output(Protocol):
    """Something that makes an engine run until it is closed."""

    name: str
    latency: float  # s

    def close(self) -> None: ...


class ClockOutput:
    """No device: a thread that computes a block whenever its time has come."""

    name = "none"

    def __init__(self, engine: Engine, block: int, latency: float | None) -> None:
        self._engine = engine
        self._block = block or _CLOCK_BLOCK
        self.latency = max(self._block / engine.rate, latency or 0.0)
        engine.set_latency(self.latency)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="carom-clock", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        started = time.monotonic()
        frames = 0
        while not self._stop.is_set():
            self._engine.process(self._block)
            frames += self._block
            ahead = started + frames / self._engine.rate - time.monotonic()
            if ahead < -1.0:  # the machine slept or is too slow: don't rush to catch up
                started -= ahead
            self._stop.wait(max(ahead, 0.0))

    def close(self) -> None:
        self._stop.set()
        self._thread.join()


class DeviceOutput:
    """A PortAudio device, which calls the compiled engine from its own thread."""

    def __init__(self, engine: Engine, device: int | str | None, block: int, latency: float | None) -> None:
        sd = portaudio()
        self._engine = engine  # the callback writes to its memory: it must live as long as the stream
        try:
            self._stream = sd._StreamBase(
                kind="output", samplerate=engine.rate, blocksize=block, device=device, channels=2, dtype="float32",
                latency="low" if latency is None else latency, userdata=sd._ffi.cast("void*", engine.pointer),
                callback=sd._ffi.cast("PaStreamCallback*", engine.address), wrap_callback=None,
            )  # fmt: skip
            self._stream.start()
        except (sd.PortAudioError, ValueError) as error:
            name = "default" if device is None else device
            hint = "`carom devices` lists what there is, `--device none` plays without one"
            raise AudioError(f"device {name}: {error}; {hint}") from error
        self.name = str(sd.query_devices(self._stream.device)["name"])
        self.latency = float(self._stream.latency)
        engine.set_latency(self.latency)

    def close(self) -> None:
        self._stream.stop()
        self._stream.close()


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


def open_output(engine: Engine, device: str | None, block: int, latency: float | None = None) -> Output:
    """Play an engine on a device: None the default, "none" no device, else an index or part of a name.

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
