"""carom strike: strike one object, and hear it or write it to a file."""

import argparse

from ..errors import tell
from .options import RATE, add_presets
from .parser import Command, number, whole


def _options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("preset", metavar="PRESET", help="an object from `carom presets`")
    out = "sound file, .wav or .flac; - for WAV on stdout; without it, the default device plays the sound"
    parser.add_argument("out", nargs="?", metavar="OUT", help=out)
    parser.add_argument("--velocity", type=number, help="of the striker, m/s (the preset's)")
    parser.add_argument("--position", type=number, help="0 to 1 along the object's strike path (the preset's)")
    parser.add_argument("--striker", help="a preset (the object's own)")
    parser.add_argument("--rate", type=whole, help="sampling rate in Hz (the device's, 48000 for a file)")
    parser.add_argument("--seconds", type=number, help="length of the sound (until silence)")
    add_presets(parser)


def _run(arguments: argparse.Namespace) -> int:
    from ...presets import Presets
    from ...server.render import Options
    from ..strike import Strike, device_rate, play, write

    presets = Presets(arguments.presets)
    presets.object(arguments.preset)  # before a device is looked for
    strike = Strike(arguments.preset, arguments.velocity, arguments.position, arguments.striker)
    if arguments.out is None:
        rate = device_rate(arguments.preset) if arguments.rate is None else arguments.rate
        warnings = play(strike, presets, Options(rate, seconds=arguments.seconds))
    else:
        rate = RATE if arguments.rate is None else arguments.rate
        warnings = write(strike, presets, Options(rate, seconds=arguments.seconds), arguments.out)
    for warning in warnings:
        tell("strike", warning)
    return 0


COMMAND = Command("strike", "PRESET [OUT]", "strike an object, and hear it or write it to a file", _options, _run)
