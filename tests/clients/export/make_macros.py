"""Export five objects for C, and write what turned macros sound like: run by a process that has a page's sizes and
bits.

    python -m tests.clients.export.make_macros FOLDER

The folder gets the library, `played.txt`, messages to send to it live, each with its time, and `sound.f32`, the render
of a score of the same messages; and a plug-in, `events.txt` for its host, and `plugin.f32`, what they shall sound like.
"""

import sys
from pathlib import Path

from carom.clients.export.baking import lay_out_macros
from carom.clients.export.c import write_library
from carom.clients.export.machines import machine_of
from carom.clients.export.plugins import RATES, write_plugin
from carom.clients.export.scene import bake_scene
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.macros import MACROS as OF_OBJECTS
from carom.presets import Presets
from carom.server.osc.score import parse
from carom.server.render import Options, blocks
from carom.server.scene.session import Session
from tests.clients.export.make_plugin import Played

SHAPES = {
    "bell": "church-bell", "bar": "marimba-bar", "plate": "glass-plate", "drum": "tom", "string": "piano-string",
}  # fmt: skip
OBJECTS = "".join(f"0 /object/new {name} {preset} gain -12\n" for name, preset in SHAPES.items())
LIVE = 1 << 20
"""The number after which a library numbers gestures."""
RATE, SECONDS = 48_000, 1.6
MACROS = {
    "material": 0.6, "size": 0.7, "brightness": 0.3, "damping": 0.6, "hardness": 0.65, "force": 0.6, "place": 0.3,
    "roughness": 0.6,
}  # fmt: skip


def played() -> str:
    """Return messages to each object: blows, a roll and a slide, while every macro goes to its place and back."""
    lines = []
    for n, name in enumerate(SHAPES):
        goes_on = ("roll 0.3 striker glass-marble", "slide 0.2 force 0.5")[n % 2]
        lines += [(0.01 * n + 0.05 * k, f"/object/{name}/macro/{macro} {at}") for k, (macro, at) in
            enumerate(MACROS.items())]  # fmt: skip
        lines += [(0.03 + 0.01 * n + 0.2 * k, f"/object/{name}/impact {1.0 + 0.3 * k} 0.4") for k in range(5)]
        lines += [
            (0.45 + 0.01 * n, f"/object/{name}/{goes_on} id g{n}"),
            *((0.6 + 0.01 * n + 0.04 * k, f"/object/{name}/macro/{macro} {1.0 - at} over 0.1 curve 1")
                for k, (macro, at) in enumerate(MACROS.items())),
            (1.2 + 0.01 * n, f"/object/{name}/note 62 90"),
            (1.3 + 0.01 * n, f"/object/{name}/macro/size 0.45"),
        ]  # fmt: skip
    return "".join(f"{time!r} {message}\n" for time, message in sorted(lines))


def main(folder: Path) -> None:
    presets = Presets()
    scene = bake_scene(parse(OBJECTS.encode(), "score"), OBJECTS, "macros", presets, Options(RATE, seconds=0.1), print)
    lay_out_macros(scene.baked, all_objects=True)
    assert set(scene.baked.tables) == set(SHAPES)
    write_library(scene, folder, machine_of(None))
    (folder / "played.txt").write_text(played())
    sound_of(OBJECTS + played(), presets, SECONDS, folder / "sound.f32")
    of_plugin(folder, presets)


BELL = "0 /object/new bell church-bell gain -6\n"
FRAMES = 24_000


def of_plugin(folder: Path, presets: Presets) -> None:
    """Write a plug-in of a bell, events for its host, and the sound of a score of the same messages."""
    scenes = [
        bake_scene(parse(BELL.encode(), "score"), BELL, "two of them", presets, Options(rate, seconds=0.1), print)
        for rate in RATES
    ]
    write_plugin(scenes, folder, machine_of(None))
    events = Played(69.0)
    for n, (name, at) in enumerate(MACROS.items()):
        place = 8 + list(OF_OBJECTS).index(name)
        events.both(100 + n, f"param {place} {at}", f"/object/bell/macro/{name} {at}")
        for k in range(8):  # a sweep while it rings
            value = at + (1.0 - at) * k / 8
            events.both(5_000 + 900 * n + 90 * k, f"param {place} {value!r}", f"/object/bell/macro/{name} {value!r}")
    for n, (key, velocity) in enumerate(((60, 0.5), (64, 0.75), (60, 1.0))):
        events.both(1_000 + 8_000 * n, f"on {key} {velocity} {n} 0", f"/object/bell/note {key} {127.0 * velocity!r}")
    events.sort()
    (folder / "events.txt").write_text(events.events)
    delay = scenes[0].baked.engine.delay + QUANTUM - 1
    sound_of(BELL + events.score(delay), presets, FRAMES / RATE, folder / "plugin.f32")


def sound_of(text: str, presets: Presets, seconds: float, path: Path) -> None:
    """Render a score whose gestures have the numbers that a library gives them."""
    options, lines = Options(RATE, seconds=seconds), parse(text.encode(), "score")
    engine = options.engine(lines)
    session = Session(engine, presets, steers_ended=True, scale=options.scale_of(lines))
    session.gestures._last = LIVE  # a surface is drawn by the number of what rolls on it
    with path.open("wb") as file:
        for sound in blocks(lines, engine, presets, options, session):
            file.write(sound.astype("<f4").tobytes())


if __name__ == "__main__":
    main(Path(sys.argv[1]))
