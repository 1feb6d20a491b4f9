"""One strike on one object: its score, its sound file, or its sound on the default device."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..dsp.errors import CaromError
from ..presets import Presets
from ..server.audio.portaudio import AudioError, devices, portaudio
from ..server.limiting import LimiterWatch
from ..server.osc.score import Line
from ..server.osc.wire import Argument, Message
from ..server.render import Options, blocks, render
from ..server.scene.session import Session
from .streams import sound_file

Progress = Callable[[float], object]
"""Function that is called with the seconds of a sound that are computed."""


class StrikeError(CaromError, ValueError):
    """A strike that makes no sound; the text says why."""


class Strike(NamedTuple):
    """A strike on an object of a preset; None stands for the preset's value. Velocity in m/s, position 0 to 1."""

    preset: str
    velocity: float | None = None
    position: float | None = None
    striker: str | None = None

    def score(self, presets: Presets) -> list[Line]:
        """Return the strike as a score. PresetError if there is no such object or striker, StrikeError if nothing
        sounds."""
        if self.velocity == 0:
            raise StrikeError("velocity = 0: nothing would sound; expected more than 0 m/s")
        name = self.preset
        velocity = presets.object(name).velocity if self.velocity is None else self.velocity
        position = () if self.position is None else (self.position,)
        keys: tuple[Argument, ...] = ()
        if self.striker is not None:
            presets.striker(self.striker)
            keys = ("striker", self.striker)
        messages = (
            Message("/object/new", (name, name)),
            Message(f"/object/{name}/impact", (velocity, *position, *keys)),
        )
        return [Line(0.0, message, name) for message in messages]


def write(strike: Strike, presets: Presets, options: Options, out: str, progress: Progress) -> list[str]:
    """Write a strike's sound to a .wav or .flac file, or to stdout; return warnings."""
    warnings: list[str] = []
    with sound_file(out) as path:
        done = render(strike.score(presets), path, presets, options, progress, warnings.append)
    limited = done.limiting.said()
    return [*warnings, limited] if limited else warnings


def play(strike: Strike, presets: Presets, options: Options, progress: Progress) -> list[str]:
    """Play a strike's sound on the default device and wait for its end; return warnings. AudioError says why not."""
    warnings: list[str] = []
    pieces = []
    score = strike.score(presets)
    engine = options.engine(score)
    session = Session(engine, presets, steers_ended=True, scale=options.scale_of(score))
    watch = LimiterWatch(engine, lambda: session.objects.slots)
    for piece in blocks(score, engine, presets, options, session, warnings.append, watch.look):
        pieces.append(piece)
        progress(sum(map(len, pieces)) / options.rate)
    sound = np.concatenate(pieces)
    device = portaudio()
    try:
        device.play(sound, options.rate, blocking=True)
    except device.PortAudioError as error:
        raise AudioError(f"the default device: {error}; {_file_instead(strike.preset)}") from error
    limited = watch.take().within(0.0, len(sound) / options.rate).said()
    return [*warnings, limited] if limited else warnings


def device_rate(preset: str) -> int:
    """Return the sampling rate (Hz) of the default device. AudioError, with what to do instead, if there is none."""
    try:
        found = [device for device in devices() if device["default"]]
    except AudioError as error:
        raise AudioError(f"{error}; {_file_instead(preset)}") from error
    if not found:
        raise AudioError(f"no device can play; {_file_instead(preset)}")
    return int(found[0]["default_samplerate"])


def _file_instead(preset: str) -> str:
    return f"name a file instead: carom strike {preset} {preset}.wav"
