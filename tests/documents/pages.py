"""The parts of the documents that the program writes itself: `make documents` rewrites them, a test compares them.

A part stands in a page between `<!-- begin NAME -->` and `<!-- end NAME -->`.
"""

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path

from carom.dsp.schema import GESTURES
from carom.server.osc.tables import change_table, gesture_table, macro_table, shared_table
from tests.documents import commands, figures, methods, presets, protocol, recipes, records, scattered, swarms
from tests.documents.addresses import addresses

ROOT = Path(__file__).parents[2]
FOLDERS = ("server", "server/gestures", "clients", "presets", "dsp", "tests")
IN_FOLDERS = [f"{folder}/{page.name}" for folder in FOLDERS for page in sorted((ROOT / folder).glob("*.md"))]
PAGES = ("README.md", "CONTRIBUTING.md", *IN_FOLDERS)

PARTS: dict[str, Callable[[], str]] = {
    "addresses": addresses,
    "shared keys": shared_table,
    "change keys": change_table,
    "macros": macro_table,
    **{f"keys of {name}": partial(gesture_table, name) for name in GESTURES},
    "status": protocol.status,
    "limits": protocol.limits,
    "commands that play": commands.playing,
    "other commands": commands.others,
    "recipe keys": recipes.keys,
    "recipes": recipes.listed,
    "object keys": presets.object_keys,
    "other keys": presets.other_keys,
    "shapes": presets.shapes,
    "supports": presets.supports,
    "support sources": presets.support_sources,
    "presets": presets.listed,
    "levels": presets.levels,
    "scores": presets.scores,
    "accuracy": figures.accuracy,
    "speed": figures.speed,
    "space": figures.space,
    "exports": figures.web,
    "meshes": figures.meshes,
    "swarms": swarms.swarms,
    "recordings": swarms.recordings,
    "grain families": swarms.grain_families,
    "compile time": figures.compiling,
    "edits": figures.edits,
    "failures": figures.failures,
    "rebounds": figures.rebounds,
    "choices": figures.choices,
    "yielding": figures.yielding,
    "fits": figures.fits,
    "held": figures.held,
    "scatter": scattered.near,
    "endurance": figures.endurance,
}
"""Function that writes each part, by the part's name."""

_PART = re.compile(r"(<!-- begin ([a-z ]+) -->\n).*?(<!-- end \2 -->)", re.DOTALL)


def parts(text: str) -> list[str]:
    """Return the names of the parts of a page."""
    return [name for _, name, _ in _PART.findall(text)]


def written(text: str) -> str:
    """Return a page with all its parts as the program writes them now."""
    return _PART.sub(lambda found: f"{found[1]}{PARTS[found[2]]()}\n{found[3]}", text)


def main() -> None:
    for each in (records, methods):
        each.STUB.write_text(each.stub(), encoding="utf-8")
    for page in PAGES:
        path = ROOT / page
        path.write_text(written(path.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
