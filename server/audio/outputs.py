"""Real-time outputs: PortAudio's devices, or none, paced by the clock.

PortAudio is handed the compiled callback itself, so that no Python runs, and no GIL is waited for, between the device
and the engine. sounddevice offers the hook to library authors: `_StreamBase` with `wrap_callback=None`.
"""

import math
import sys
import threading
import time
from typing import Any, Protocol

import numpy as np

from ...dsp.native.atomics import publish
from ...dsp.native.code import load
from ...dsp.runtime.engine import Engine
from ...dsp.runtime.handover import Handover
from ...dsp.runtime.pacer import keep_pace
from .portaudio import NONE_FOUND, AudioError, devices, give_up, jack_rate, never_end, portaudio

_BLOCKS = {"none": 480, "page": 128}
"""Frames of a block without a device: short where pages hear it, as a message waits for the next block."""
_WRONG_RATE, _DEVICE_UNAVAILABLE = -9997, -9985  # PortAudio's errors
_CALL = 0.2  # s for a call of the engine to end
_PATIENCE = 3.0  # s for a device to be closed
_PATIENCE_STALLED = 10.0  # s for a stalled device to come back by itself


class Output(Protocol):
    """Something that makes an engine run, from `start` until `rest`."""

    name: str
    latency: float  # s
    patience: float  # s for which it is worth waiting once it has stalled

    def prepare(self) -> None:
        """Do all that may take long, before `start`. AudioError if that fails."""

    def start(self) -> None:
        """Run the engine; a device does so again after `rest`."""

    def rest(self) -> bool:
        """Stop running the engine; return False while a call of it still goes on."""

    def active(self) -> bool:
        """True if the device is there, even if it has stalled."""

    def calls(self) -> int:
        """Return how many times it has requested sound."""

    def close(self) -> bool:
        """End it, at rest or not, within a few seconds; return False if it does not end."""


class ClockOutput:
    """No device: a compiled loop, in a thread of its own, that computes a block whenever its time has come."""

    patience = math.inf

    def __init__(self, engine: Engine, block: int, latency: float | None, name: str = "none") -> None:
        self.name = name
        frames = block or _BLOCKS[name]
        self.latency = max(frames / engine.rate, latency or 0.0)
        self._engine = engine
        self._running = np.ones(1, np.int64)
        load(keep_pace.__module__)  # now, not in the thread: it may have to be compiled
        memory = np.zeros((frames, engine.width), np.float32), np.zeros(3)
        args = self._running, engine.address, engine.pointer, engine.rate, *memory
        self._thread = threading.Thread(target=keep_pace, args=args, name="carom-clock", daemon=True)

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
        return int(self._engine.stats.callbacks)

    def close(self) -> bool:
        return self.rest()


class DeviceOutput:
    """A PortAudio device, which calls the compiled engine from its own thread."""

    def __init__(self, engine: Engine, device: int | str | None, block: int, latency: float | None) -> None:
        self._sd = portaudio()
        self._engine = engine  # the callback writes to its memory: it must live as long as the stream
        self._handover = Handover(engine.address, engine.pointer, engine.width)
        self._asked = _asked(device)
        self._api, self._own_rate = "", 0.0
        ffi = self._sd._ffi
        found = _found(device)
        try:
            self._api = str(self._sd.query_hostapis(found["hostapi"])["name"])
            self._own_rate = float(found["default_samplerate"])
            self._stream = self._sd._StreamBase(
                kind="output", samplerate=engine.rate, blocksize=block, device=device, channels=engine.width,
                dtype="float32", latency="low" if latency is None else latency,
                userdata=ffi.cast("void*", self._handover.pointer),
                callback=ffi.cast("PaStreamCallback*", self._handover.address), wrap_callback=None,
            )  # fmt: skip
        except (self._sd.PortAudioError, ValueError) as error:
            raise self._refused(error) from error
        self.name = str(found["name"])
        self.full_name = f"{self.name}, {self._api}"
        """Name by which the device is found again."""
        self.latency = float(self._stream.latency)
        self.patience = _PATIENCE_STALLED
        self._prepared = False
        if self._on_jack():
            self.patience = math.inf  # JACK reports when it goes
            never_end()

    def _on_jack(self) -> bool:
        return "JACK" in self._api and sys.platform == "linux"  # elsewhere it is a rarity

    def _refused(self, error: Exception) -> AudioError:
        """Return the error that says why the device cannot be opened. Gives PortAudio up where its JACK server has
        gone."""
        if self._on_jack() and _DEVICE_UNAVAILABLE in error.args:
            give_up()
        if _WRONG_RATE not in error.args:
            return self._error(str(error))
        asked = self._engine.rate
        if self._on_jack():
            # PortAudio knows the rate of the server it first met, which may have gone, or come back at another rate.
            self._own_rate = jack_rate()
            if not self._own_rate or abs(self._own_rate - asked) <= 1.0:
                give_up()
                return self._error("its JACK server has gone")
        return self._error(f"{error}: expected its own rate, {self._own_rate:.0f} Hz, not {asked:.0f}")

    def _error(self, text: str) -> AudioError:
        return _error(self._asked, text)

    def prepare(self) -> None:
        """Start the device's callbacks, which play silence until `start`."""
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
        self._handover.allow()

    def rest(self) -> bool:
        deadline = time.monotonic() + _CALL
        while not (taken := self._handover.revoke()) and time.monotonic() < deadline:
            time.sleep(1e-3)
        return taken

    def active(self) -> bool:
        return bool(self._stream.active)

    def calls(self) -> int:
        return self._handover.calls

    def close(self) -> bool:
        self.rest()
        if self._on_jack():
            # If the server goes just now, PortAudio would end the process: so its thread is left to play silence.
            give_up()
            if self._stream.active:
                time.sleep(min(self.latency, _PATIENCE))  # until all that was computed is played
            return True
        # A stalled device may never let the stream end, and must not hold up the end of the process.
        closing = threading.Thread(target=self._close, name="carom-closing", daemon=True)
        closing.start()
        closing.join(_PATIENCE)
        if closing.is_alive():
            give_up()
            never_end()
        return not closing.is_alive()

    def _close(self) -> None:
        if self._stream.active:
            self._stream.stop(ignore_errors=True)  # once all that was computed is played
        self._stream.close(ignore_errors=True)


def _asked(device: int | str | None) -> str:
    return "default" if device is None else str(device)


def _error(asked: str, text: str) -> AudioError:
    hint = "`carom devices` lists them, `--device none` plays without one"
    return AudioError(f"device {asked}: {' '.join(text.split())}; {hint}")


def _found(device: int | str | None) -> dict[str, Any]:
    """Return the device of an index or a name, None: the default one, as PortAudio describes it. AudioError if there is
    none."""
    sd = portaudio()
    if device is None and not devices():
        raise AudioError(NONE_FOUND)
    try:
        found: dict[str, Any] = sd.query_devices(device, "output")
    except (sd.PortAudioError, ValueError) as error:
        raise _error(_asked(device), str(error)) from error
    return found


def require_device(device: str | None) -> None:
    """Raise AudioError if there is no device as `open_output` asks for."""
    if device not in _BLOCKS:
        _found(_index_or_name(device))


def _index_or_name(device: str | None) -> int | str | None:
    return int(device) if device and device.isdigit() else device


def open_output(engine: Engine, device: str | None, block: int, latency: float | None = None) -> Output:
    """Open an output for an engine, to be started. AudioError if there is no such device.

    device: None for the default device, "none" for no device, "page" for none but the pages that hear it, else its
    index or part of its name. block: frames, 0 for the device's own. latency: s to ask the device for, None for its
    lowest; the output's `latency` says what it gives.
    """
    if device is not None and device in _BLOCKS:
        return ClockOutput(engine, block, latency, device)
    return DeviceOutput(engine, _index_or_name(device), block, latency)
