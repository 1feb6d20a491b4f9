"""carom strike: strike one object, and hear it or write it to a file."""

import argparse

from ..errors import tell
from .options import RATE, add_full_scale, add_presets
from .parser import Command, number, whole
from .progress import SECONDS_OF_SOUND, Work, shown_progress

_WORK = Work("strike", SECONDS_OF_SOUND, "s of sound")


def _options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("preset", metavar="PRESET", help="object from `carom presets`")
    out = "sound file, .wav or .flac; -: stdout (the default device plays the sound)"
    parser.add_argument("out", nargs="?", metavar="OUT", help=out)
    parser.add_argument("--velocity", type=number, help="speed of the striker, m/s (the preset's)")
    parser.add_argument("--position", type=number, help="position on the object's strike path, 0 to 1 (the preset's)")
    parser.add_argument("--striker", help="striker from `carom presets strikers` (the object's)")
    parser.add_argument("--rate", type=whole, help="sampling rate in Hz (the device's, 48000 for a file)")
    parser.add_argument("--seconds", type=number, help="length of the sound (until silence)")
    add_full_scale(parser)
    add_presets(parser)


def _run(arguments: argparse.Namespace) -> int:
    from ...dsp.runtime.engine import prepare
    from ...presets import Presets
    from ...server.render import Options
    from ..streams import require_out
    from ..strike import Strike, device_rate, play, write

    presets = Presets(arguments.presets)
    strike = Strike(arguments.preset, arguments.velocity, arguments.position, arguments.striker)
    strike.score(presets)  # mistakes are reported before a device is opened
    rate = arguments.rate
    if rate is None:
        rate = device_rate(arguments.preset) if arguments.out is None else RATE
    options = Options(rate, seconds=arguments.seconds, full_scale=arguments.full_scale)
    if arguments.out is not None:
        require_out(arguments.out)
    prepare()  # before there is another progress bar
    with shown_progress(_WORK, arguments.preset, arguments.seconds) as show:

        def progress(seconds: float) -> None:
            show(completed=seconds)

        if arguments.out is None:
            warnings = play(strike, presets, options, progress)
        else:
            warnings = write(strike, presets, options, arguments.out, progress)
    for warning in warnings:
        tell("strike", warning)
    return 0


COMMAND = Command("strike", "PRESET [OUT]", "strike an object, and play the sound or write a file", _options, _run)
