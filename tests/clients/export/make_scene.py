"""Export a random score of all gestures, and write beside it what the page of it shall do: run by a process that has a
page's sizes and bits.

    python -m tests.clients.export.make_scene FOLDER SEED [ENGINE]

ENGINE is a module whose callback takes the place of the engine's, as `tests.clients.export.tiny` has one.
"""

import importlib
import json
import random
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from carom.clients.export import c, web
from carom.clients.export.machines import machine_of
from carom.clients.export.scene import Scene, bake_scene
from carom.dsp import runtime
from carom.dsp.engine.memory.state import RING
from carom.dsp.runtime import engine
from carom.dsp.schema import GESTURES, SETTINGS, STEERABLE, STRIKE, Parameter
from carom.presets import Presets
from carom.server.osc.addresses import VERBS
from carom.server.osc.score import Line, format_line, parse, sample_at
from carom.server.osc.wire import Message
from carom.server.render import Options
from carom.server.scene.session import Session

OBJECTS = ("church-bell", "marimba-bar", "glass-plate", "tom", "guitar-string", "crash-cymbal")
"""Presets of the objects: of many kinds, and one whose modes are coupled."""

STRIKERS = ("wood", "steel", "coin", "felt", "glass-marble", "fingertip")
SURFACES = ("wood", "slate", "glass")
ONE_LAW = ("wood", "steel", "coin", "glass-marble")
"""Strikers of swarms: a scene has tables for the exponents of its own swarms, and room for two and for drops."""
PLAYED = [name for name, each in GESTURES.items() if not each.what and not each.breaks]
"""The gestures that a page can begin."""
SECONDS = 1.6
PART, PARTS = 0.4, 3
"""A score's parts, in s, each with a third of the gestures: more at once cost a hundred times real time."""
STIFF = 3
"""The first objects, which are stiff: a swarm costs that much, too, on one that yields."""
MESSAGES = 400


SWARMING = 0.4
"""The part of a wide range, as its logarithm goes, that swarms keep to: some 100 blows per s at most."""


def number(chance: random.Random, of: Parameter, part: float = 1.0) -> float:
    """Return a number from the useful range of a parameter; part: of a wide range, as its logarithm goes."""
    low, high = of.useful or (of.low, of.high)
    if of.whole:
        return chance.randint(int(low), int(min(high, 1000)))
    wide = low > 0.0 and high / low > 30.0
    return low * (high / low) ** (part * chance.random()) if wide else chance.uniform(low, high)


def gesture(chance: random.Random, name: str, target: str, others: list[str]) -> Message:
    """Return a gesture on an object, with some of its keys."""
    declared = GESTURES[name]
    part = SWARMING if declared.swarms else 1.0
    args: list[Any] = [number(chance, declared.argument, part), chance.random()]
    if declared.instead and chance.random() < 0.3:
        instead = next(key for key in declared.keys if key.name == declared.instead)
        args = [instead.name, number(chance, instead), "position", chance.random()]
    for key in (*STRIKE[:4], *declared.keys):
        if chance.random() < 0.15 and key.name not in ("seed", "position", "static", "dynamic", declared.instead):
            args += [key.name, number(chance, key, part)]
    if not declared.along and "dissipation" not in args and chance.random() < 0.1:
        args += ["restitution", chance.uniform(0.2, 0.95)]
    if declared.swarms and "exponent" in args:
        del args[(place := args.index("exponent")) : place + 2]
    if declared.swarms or chance.random() < 0.6:
        args += ["striker", chance.choice(ONE_LAW if declared.swarms else STRIKERS)]
    if not declared.swarms and chance.random() < 0.2:
        args += ["by", chance.choice([each for each in others if each != target])]
    if declared.along and chance.random() < 0.7:
        args += ["surface", chance.choice(SURFACES)]
    if any(key.name == "seed" for key in declared.keys):
        args += ["seed", chance.randrange(1000)]
    return Message(f"/object/{target}/{name}", (*args, "gain", chance.uniform(-12.0, 6.0)))


def messages(chance: random.Random, names: list[str]) -> Iterator[Message]:
    """Yield gestures, changes of settings and steering."""
    while True:
        target, kind = chance.choice(names), chance.choice([*PLAYED, "set", "change", "gain", "steer", "steer"])
        if kind in PLAYED:
            yield gesture(chance, kind, target, names)
        elif kind == "steer":  # a roll or a slide that goes by its object's name, if there is one
            declared = VERBS[f"/gesture/ID/{(name := chance.choice(STEERABLE))}"].number
            yield Message(f"/gesture/{target}/{name}", (number(chance, declared), "over", chance.random()))
        elif kind == "gain":
            yield Message("/gain", (chance.uniform(-20.0, 0.0), "over", chance.random()))
        else:
            setting = chance.choice([each for each in SETTINGS.values() if each.name != "decay"])
            value = number(chance, setting)
            more = ("over", chance.random(), "curve", chance.uniform(-4, 4)) if kind == "change" else ()
            yield Message(f"/object/{target}/{setting.name}", (value, *more))


def score(seed: int) -> str:
    """Return a random score: objects that come one after the other, and all gestures, in parts that end."""
    chance, lines = random.Random(seed), []
    names = [preset.replace("-", "_") for preset in OBJECTS]
    for n, (name, preset) in enumerate(zip(names, OBJECTS, strict=True)):
        lines.append(
            (0.1 * (n // 3), Message("/object/new", (name, preset, "gain", -9.0, "pan", chance.uniform(-1, 1))))
        )
    for n, kind in enumerate(chance.sample(PLAYED, len(PLAYED))):
        begins = 0.2 + PART * (n % PARTS)
        target = chance.choice(names[: STIFF if GESTURES[kind].swarms else None])
        lines.append((begins + chance.uniform(0.0, 0.2), gesture(chance, kind, target, names)))
        if n % 2:
            tuned = Message(f"/object/{target}/tune", (chance.uniform(-3, 3), "over", 0.1))
            lines.append((begins + chance.uniform(0.1, 0.3), tuned))
    lines.append((0.65, Message("/object/tom/rest", ("felt", "load", 3.0))))
    lines.append((1.1, Message("/object/glass_plate/shatter", (2.0, "onto", "marimba_bar", "striker", "glass-marble"))))
    lines += [(0.2 + PART * (part + 1), Message("/panic")) for part in range(PARTS)]
    return "".join(f"{format_line(time, message)}\n" for time, message in sorted(lines, key=lambda line: line[0]))


def accepted(text: str, presets: Presets) -> str:
    """Return a score without the lines that are refused: too long a contact, too small a ball."""
    lines = parse(text.encode(), "score")
    session = Session(Options().engine(lines), presets)
    kept = [line for line in lines if all(reply.address != "/fail" for reply in _told(session, line))]
    return "".join(f"{format_line(line.time, line.message)}\n" for line in kept)


def _told(session: Session, line: Line) -> list[Message]:
    return session.perform([line.message], sample_at(line.time, session.engine.rate))


def random_scene(seed: int, presets: Presets) -> tuple[str, Scene]:
    """Return a random score, and the scene that is baked of it."""
    text = accepted(score(seed), presets)
    return text, bake_scene(parse(text.encode(), "score"), text, "random", presets, Options(seconds=SECONDS), print)


def main(folder: Path, seed: int) -> None:
    """Export the score, and write its sound, random messages, and the commands that a session makes of them."""
    text, scene = random_scene(seed, Presets())
    (folder / "score.txt").write_text(text)
    baked = scene.baked
    web.write_page(scene, folder)
    if shutil.which("cc"):
        c.write_library(scene, folder, machine_of(None))
    baked.sound.astype("<f4").tofile(folder / "sound.f32")
    sent, session, asked = baked.engine, baked.session, []
    chance = random.Random(seed)
    for message in messages(chance, list(baked.objects)):
        if len(asked) == MESSAGES:
            break
        first = sent.sent
        replies = session.perform([message], -1.0)
        if any(reply.address == "/fail" for reply in replies):
            continue
        if sent.sent == first:  # what steers a gesture of the score that has ended
            continue
        entries = sent.ring.entries[first % RING : sent.sent % RING or RING]
        if any("so nothing changes" in str(reply.args) for reply in replies):  # an export refuses it
            entries = entries[:0]
        asked.append({"message": [message.address, *message.args], "commands": [_said(entry) for entry in entries]})
    (folder / "asked.json").write_text(json.dumps(asked))


def _said(entry: Any) -> dict[str, float]:
    """Return the fields of a command that its kind has."""
    names = ["kind", "slot", "serial", "by_slot", "by_serial", "value", "channel"]
    kind = int(entry["kind"])
    if kind == 2:
        names += ["what", *(f"values.{name}" for name in entry["values"].dtype.names)]
        if GESTURES[list(GESTURES)[int(entry["what"])]].along:
            names += ["given", *(f"surface.{name}" for name in entry["surface"].dtype.names)]
    if kind in (3, 5):
        names += ["parameter"]
    if kind in (3, 5, 11):
        names += [f"ramp.{name}" for name in entry["ramp"].dtype.names]
    return {name: _field(entry, name) for name in names}


def _field(entry: Any, path: str) -> float:
    for name in path.split("."):
        entry = entry[name]
    return float(entry)


def use(name: str) -> None:
    """Put a module's callback in the place of the engine's."""
    other = importlib.import_module(name)
    engine.callback, engine.MODULE = SimpleNamespace(compute=other.callback), name
    runtime.callback = web.callback = c.callback = other


if __name__ == "__main__":
    for name in sys.argv[3:]:
        use(name)
    main(Path(sys.argv[1]), int(sys.argv[2]))
