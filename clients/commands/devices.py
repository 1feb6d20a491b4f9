"""carom devices: list sound outputs and MIDI inputs."""

import argparse
from contextlib import suppress

from .options import no_options
from .parser import Command


def _run(_: argparse.Namespace) -> int:
    from ...server.audio.portaudio import NONE_FOUND, AudioError, devices

    for text in _midi_inputs():
        print(text)
    found = devices()
    if not found:
        raise AudioError(NONE_FOUND)
    for device in found:
        mark = "*" if device["default"] else " "
        what = f"{device['channels']} channels, {device['default_samplerate']:.0f} Hz"
        print(f"{mark}{device['index']:3d}  {device['name']} ({device['hostapi']}), {what}")
    return 0


def _midi_inputs() -> list[str]:
    """Return a line for each MIDI input, where the extra for it is installed and the system has any."""
    from ...server.options import ServeError

    with suppress(ModuleNotFoundError, ServeError):
        from ...server.midi.ports import inputs

        return [f" {index:3d}  {name} (MIDI input)" for index, name in enumerate(inputs())]
    return []


COMMAND = Command("devices", "", "list sound outputs and MIDI inputs", no_options, _run)
