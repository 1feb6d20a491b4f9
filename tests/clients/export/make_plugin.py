"""Export a plug-in, and write beside it what its first object sounds like by a score: run by a process that has a
page's sizes and bits.

    python -m tests.clients.export.make_plugin FOLDER [ENGINE]

The folder gets the plug-in in each format, `played.txt`, events for the host of the tests, and `sound.f32`, the render
of a score of the same notes and settings, each as much later as the plug-in's latency says.
"""

import math
import sys
from pathlib import Path

from carom.clients.export.machines import machine_of
from carom.clients.export.plugins import FORMATS, RATES, write_plugin
from carom.clients.export.scene import bake_scene
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.sizes import CAPACITY
from carom.presets import Presets
from carom.server.osc.score import parse
from carom.server.render import Options, blocks
from tests.clients.export.make_scene import use

COPIES = 62
"""Room for copies besides the objects."""
OBJECTS = "".join(
    f"0 /object/new {each}\n"
    for each in (
        "bell church-bell gain -6 pan 0.25",
        "block marimba-bar",
        *(f"mute.{n} glass-ball size 0.1" for n in range(CAPACITY.objects - COPIES - 2)),
    )
)
"""Two that are heard, and some that are too small for it, and so no instruments: they leave room for COPIES."""
RATE = 48_000
FRAMES = 28_000


class Played:
    """Events for a host, each with the messages of a score that it shall become."""

    def __init__(self, pitch: float) -> None:
        self.pitch = pitch
        self._events: list[tuple[int, str, tuple[str, ...]]] = []

    def both(self, sample: int, event: str, *messages: str) -> None:
        self._events.append((sample, event, messages))

    def tuned(self, copy: int, note: float) -> str:
        """Return the message that tunes a copy."""
        return f"/object/bell.{copy}/tune {note - self.pitch!r}"

    def sort(self) -> None:
        self._events.sort(key=lambda each: each[0])

    @property
    def events(self) -> str:
        return "".join(f"{sample} {event}\n" for sample, event, _ in self._events)

    def score(self, delay: int) -> str:
        return "".join(
            f"{(sample + delay) / RATE!r} {message}\n" for sample, _, messages in self._events for message in messages
        )


def play(to: Played, striker: str) -> None:
    """Play notes, expressions, macros and MIDI; striker: the name of the second one."""
    velocity = 0.7
    to.both(100, f"on 60 {velocity} 7 0", f"/object/bell/note 60 {127.0 * velocity!r}")
    to.both(101, "on 61 0.25 8 1", "/object/bell/note 61 31.75")
    to.both(4_096, "express 2 0.5 60 7 -1", to.tuned(60, 60.5))
    to.both(4_097, "express 1 1.0 61 8 -1", "/object/bell.61/pan 1")
    to.both(5_000, "express 0 2.0 -1 8 -1", f"/object/bell.61/gain {20.0 * math.log10(2.0) - 6.0!r}")
    to.both(6_000, "param 5 0.5")  # of the hand on what is released
    to.both(7_001, "off 60 7 0", "/object/bell.60/damp 0.5")
    to.both(8_000, "param 0 0.75")  # position
    to.both(8_000, "param 1 2")  # striker
    blow = f"/object/bell/note 60 63.5 0.75 striker {striker}"
    to.both(9_000, "on 60 0.5 9 0", to.tuned(60, 60), "/object/bell.60/damp 0", blow)
    to.both(9_500, "param 1 0")
    to.both(9_500, "param 0 0.0")
    to.both(10_000, "midi 144 62 100", "/object/bell/note 62 100")
    to.both(11_000, "midi 224 0 96", to.tuned(60, 61), to.tuned(62, 63))  # a bend by half
    to.both(12_000, "choke 61 8 1", "/object/bell.61/damp 1")
    to.both(13_000, "param 2 -12", to.tuned(60, 49), to.tuned(61, 49), to.tuned(62, 51))


def fill(to: Played) -> None:
    """Play more keys than there is room for: those that were struck longest ago play the last ones."""
    keys = [key for key in range(20, 120) if key not in (60, 61, 62)]
    room = COPIES - 3
    for n, key in enumerate(keys[:room]):
        to.both(14_000 + 10 * n, f"on {key} 0.5 -1 5", f"/object/bell/note {key} 63.5", to.tuned(key, key - 12))
    one, other = keys[room : room + 2]
    as_made = ("/object/bell.61/gain -6", "/object/bell.61/pan 0.25", "/object/bell.61/damp 0")
    to.both(20_000, f"on {one} 0.5 -1 5", to.tuned(61, one - 12), *as_made, "/object/bell/note 61 63.5")
    to.both(21_000, f"on {other} 1 3 5", to.tuned(60, other - 12), "/object/bell/note 60 127")
    to.both(21_500, f"on {other} 1 4 5", "/object/bell/note 60 127")


def main(folder: Path) -> None:
    presets = Presets()
    scenes = [
        bake_scene(parse(OBJECTS.encode(), "score"), OBJECTS, "two of them", presets, Options(rate), print)
        for rate in RATES
    ]
    for form in FORMATS:
        write_plugin(scenes, folder, machine_of(None), form)
    baked = scenes[0].baked
    played = Played(69.0 + 12.0 * math.log2(float(baked.objects["bell"].modes.frequency[0]) / 440.0))
    play(played, scenes[0].strikers.names[1])
    fill(played)
    (folder / "played.txt").write_text(played.events)
    lines = parse((OBJECTS + played.score(baked.engine.delay + QUANTUM - 1)).encode(), "score")
    options = Options(RATE, seconds=FRAMES / RATE)
    with (folder / "sound.f32").open("wb") as file:
        for sound in blocks(lines, options.engine(lines), presets, options):
            file.write(sound.astype("<f4").tobytes())


if __name__ == "__main__":
    for name in sys.argv[2:]:
        use(name)
    main(Path(sys.argv[1]))
