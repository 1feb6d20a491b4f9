"""Where the sound goes in real time: PortAudio's devices, or nowhere, paced by the clock.

PortAudio is handed the compiled callback itself, so that no Python runs, and no GIL is waited for, between the device
and the engine. sounddevice offers the hook to library authors: `_StreamBase` with `wrap_callback=None`.
"""

import atexit
import ctypes
import math
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from ...dsp.native.atomics import publish
from ...dsp.runtime.engine import Engine
from ...dsp.runtime.handover import Loan
from ...dsp.runtime.pacer import pacer

_CLOCK_BLOCK = 480
_WRONG_RATE, _DEVICE_UNAVAILABLE = -9997, -9985  # PortAudio's errors
_NO_START_SERVER = 1  # JACK's option
_CALL = 0.2  # s for a call of the engine to end
_PATIENCE = 3.0  # s for a device to be closed
_PATIENCE_STALLED = 10.0  # s for it to come back by itself

_spent = threading.Event()
"""Set where PortAudio may not be touched again: its JACK server has gone, or a stream of its does not end."""


class AudioError(RuntimeError):
    """Sound can't be played; the text says why, and what might help."""


class Output(Protocol):
    """Something that makes an engine run, from `start` until `rest`."""

    name: str
    latency: float  # s
    patience: float  # s for which it is worth waiting once it has stalled

    def prepare(self) -> None:
        """Do what may take its time, or raise AudioError, before `start`."""

    def start(self) -> None:
        """Run the engine; a device does so again after `rest`."""

    def rest(self) -> bool:
        """Run the engine no more from here on; false if that can't be had yet, as a call of it goes on."""

    def active(self) -> bool:
        """Is it there, even if it may have stalled?"""

    def calls(self) -> int:
        """Times that it has asked for sound."""

    def close(self) -> bool:
        """End it, at rest or not, in a few seconds at the most; false if it would not end."""


class ClockOutput:
    """No device: a compiled loop, in a thread of its own, that computes a block whenever its time has come."""

    name = "none"
    patience = math.inf

    def __init__(self, engine: Engine, block: int, latency: float | None) -> None:
        frames = block or _CLOCK_BLOCK
        self.latency = max(frames / engine.rate, latency or 0.0)
        self._engine = engine
        self._running = np.ones(1, np.int64)
        memory = np.zeros((frames, 2), np.float32), np.zeros(3)
        args = self._running, engine.address, engine.pointer, engine.rate, *memory
        self._thread = threading.Thread(target=pacer(), args=args, name="carom-clock", daemon=True)

    def prepare(self) -> None:
        pass

    def start(self) -> None:
        self._engine.set_latency(self.latency)
        self._thread.start()

    def rest(self) -> bool:
        publish(self._running, 0)
        if self._thread.ident:
            self._thread.join()
        return True

    def active(self) -> bool:
        return True

    def calls(self) -> int:
        return int(self._engine.counter("callbacks"))

    def close(self) -> bool:
        return self.rest()


class DeviceOutput:
    """A PortAudio device, which calls the compiled engine from its own thread."""

    def __init__(self, engine: Engine, device: int | str | None, block: int, latency: float | None) -> None:
        self._sd = portaudio()
        self._engine = engine  # the callback writes to its memory: it must live as long as the stream
        self._loan = Loan(engine.address, engine.pointer)
        self._asked = "default" if device is None else str(device)
        self._api, self._own_rate = "", 0.0
        ffi = self._sd._ffi
        try:
            found = self._sd.query_devices(device, "output")
            self._api = str(self._sd.query_hostapis(found["hostapi"])["name"])
            self._own_rate = float(found["default_samplerate"])
            self._stream = self._sd._StreamBase(
                kind="output", samplerate=engine.rate, blocksize=block, device=device, channels=2, dtype="float32",
                latency="low" if latency is None else latency, userdata=ffi.cast("void*", self._loan.pointer),
                callback=ffi.cast("PaStreamCallback*", self._loan.address), wrap_callback=None,
            )  # fmt: skip
        except (self._sd.PortAudioError, ValueError) as error:
            raise self._refused(error) from error
        self.name = str(found["name"])
        self.full_name = f"{self.name}, {self._api}"
        """By which it is found again."""
        self.latency = float(self._stream.latency)
        self.patience = _PATIENCE_STALLED
        self._prepared = False
        if self._on_jack():
            self.patience = math.inf  # JACK tells when it goes
            never_end()

    def _on_jack(self) -> bool:
        return "JACK" in self._api and sys.platform == "linux"  # elsewhere it is a rarity

    def _refused(self, error: Exception) -> AudioError:
        """Why it can't be opened; where that is a JACK server that has gone, PortAudio is spent."""
        if self._on_jack() and _DEVICE_UNAVAILABLE in error.args:
            _spent.set()
        if _WRONG_RATE not in error.args:
            return self._error(str(error))
        asked = self._engine.rate
        if self._on_jack():
            # PortAudio has the rate of the server that it met, which may have gone since, or come back at another.
            self._own_rate = _jack_rate()
            if not self._own_rate or abs(self._own_rate - asked) <= 1.0:
                _spent.set()
                return self._error("the JACK server that it was on has gone")
        return self._error(f"{error}: {asked:.0f} Hz is asked for, its own is {self._own_rate:.0f}")

    def _error(self, text: str) -> AudioError:
        hint = "`carom devices` lists what there is, `--device none` plays without one"
        return AudioError(f"device {self._asked}: {' '.join(text.split())}; {hint}")

    def prepare(self) -> None:
        """Have the device ask for sound, and play silence until `start`."""
        self._prepared = True
        try:
            self._stream.start()
        except self._sd.PortAudioError as error:
            self.close()
            raise self._error(str(error)) from error

    def start(self) -> None:
        if not self._prepared:
            self.prepare()
        self._engine.set_latency(self.latency)
        self._loan.give()

    def rest(self) -> bool:
        deadline = time.monotonic() + _CALL
        while not (taken := self._loan.take()) and time.monotonic() < deadline:
            time.sleep(1e-3)
        return taken

    def active(self) -> bool:
        return bool(self._stream.active)

    def calls(self) -> int:
        return self._loan.asked

    def close(self) -> bool:
        self.rest()
        if self._on_jack():
            # A server that goes just now would have PortAudio end the process: its thread is left to play silence.
            _spent.set()
            if self._stream.active:
                time.sleep(min(self.latency, _PATIENCE))  # until all that was computed is played
            return True
        # A device that has stalled may never let it end, nor may the end of the process be held up by it.
        closing = threading.Thread(target=self._close, name="carom-closing", daemon=True)
        closing.start()
        closing.join(_PATIENCE)
        if closing.is_alive():
            _spent.set()
            never_end()
        return not closing.is_alive()

    def _close(self) -> None:
        if self._stream.active:
            self._stream.stop(ignore_errors=True)  # once all that was computed is played
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


def never_end() -> None:
    """Have PortAudio not told to end when the process does, but stay loaded, as its threads go on."""
    atexit.unregister(portaudio()._exit_handler)
    if sys.platform == "linux":
        ctypes.CDLL(_library("portaudio"))


def _leave_portaudio() -> None:
    """Go on with a fresh copy of PortAudio, and never touch the present one again.

    Told to stop a stream whose JACK server has gone, PortAudio 19.6 and 19.7 wait ten minutes for its thread, and then
    an assertion ends the process, as another does when they are told to end
    (https://github.com/PortAudio/portaudio/issues/820).
    """
    sd = portaudio()
    never_end()
    with tempfile.NamedTemporaryFile(suffix=".so") as copy:
        copy.write(Path(_library("portaudio")).read_bytes())
        copy.flush()
        ctypes.CDLL(copy.name)  # which, unlike ffi, never unloads it
        sd._lib = sd._ffi.dlopen(copy.name)
    sd._initialized = 0
    _spent.clear()


def _library(name: str) -> str:
    """Where a library was loaded from."""
    for line in Path("/proc/self/maps").read_text().splitlines():
        if f"/lib{name}" in line:
            return line.split()[-1]
    raise OSError(f"lib{name} is not loaded")


def _jack_rate() -> float:
    """The sampling rate (Hz) of the JACK server that is there now, 0: none.

    JACK itself is asked, by the library that PortAudio uses.
    """
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
    """Have PortAudio see what has come and gone; no stream may be open but those that were closed, or are gone.

    Connected to a JACK server it stays as it is: if that goes, opening a stream tells, and then it is spent.
    """
    sd = portaudio()
    if _spent.is_set():
        _leave_portaudio()
    elif sd._initialized:
        if any("JACK" in api["name"] for api in sd.query_hostapis()):
            return
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
