"""carom devices: list the devices that can play."""

import argparse

from .options import no_options
from .parser import Command


def _run(_: argparse.Namespace) -> int:
    from ...server.audio.portaudio import AudioError, devices

    found = devices()
    if not found:
        raise AudioError("no device can play: start JACK, PipeWire or PulseAudio, or `carom serve --device none`")
    for device in found:
        mark = "*" if device["default"] else " "
        what = f"{device['channels']} channels, {device['default_samplerate']:.0f} Hz"
        print(f"{mark}{device['index']:3d}  {device['name']} ({device['hostapi']}), {what}")
    return 0


COMMAND = Command("devices", "", "list the devices that can play", no_options, _run)
