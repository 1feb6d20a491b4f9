"""carom presets: list the presets, show some, or check files of your own."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...dsp.wording import suggestion
from ..errors import tell
from ..folding import columns_of, folded
from .options import add_presets
from .parser import Command
from .progress import Work, shown_progress

if TYPE_CHECKING:
    from ...presets import Presets


def _options(parser: argparse.ArgumentParser) -> None:
    names = "preset to show, kind to list (objects, strikers, surfaces, materials), or file to check"
    parser.add_argument("names", nargs="*", metavar="NAME", help=names)
    parser.add_argument("--check", action="store_true", help="check the files NAME, or all in the folder NAME")
    parser.add_argument("--json", action="store_true", help="output as JSON")
    parser.add_argument("--glb", type=Path, metavar="FILE", help="glTF file to write, of the object NAME of shape mesh")
    parser.add_argument("--names", dest="bare", action="store_true", help="names alone, one on each line")
    add_presets(parser)


def _run(arguments: argparse.Namespace) -> int:
    from ...presets import KINDS, Presets
    from ..preset_files import CheckError

    presets = Presets(arguments.presets)
    if arguments.glb:
        return _write_glb(arguments.names, presets, arguments.glb)
    if arguments.check:
        if not arguments.names:
            raise CheckError("--check: no file; expected one or more")
        return _check(arguments.names, presets, arguments.json)
    if set(arguments.names) <= set(KINDS):
        _list(arguments.names or KINDS, presets, arguments)
    else:
        _show(arguments.names, presets, arguments.json)
    return 0


def _list(kinds: Sequence[str], presets: Presets, arguments: argparse.Namespace) -> None:
    """Print all presets of some kinds; where none is requested, objects with their descriptions and the other names."""
    if arguments.json:
        _print({kind: list(_described(kind, presets)) for kind in kinds})
    elif arguments.bare:
        print("\n".join(dict.fromkeys(name for kind in kinds for name in presets.names(kind))))
    elif arguments.names:
        for kind in kinds:
            _describe(kind, presets)
    else:
        _overview(kinds, presets)


def _overview(kinds: Sequence[str], presets: Presets) -> None:
    """Print the first kind's presets with their descriptions, and the names of the others, and how to see more."""
    from ..streams import own_scores

    _describe(kinds[0], presets)
    for kind, names in (*((kind, presets.names(kind)) for kind in kinds[1:]), ("scores", list(own_scores()))):
        print(f"{kind}:")
        print(folded(f"  {', '.join(names)}", columns_of(sys.stdout), 2))
    more = "carom presets KIND describes those of a kind, carom presets NAME shows one, carom strike OBJECT plays one"
    print(folded(more, columns_of(sys.stdout), 0))


def _describe(kind: str, presets: Presets) -> None:
    print(f"{kind}:")
    width = max(map(len, presets.names(kind)))
    for each in _described(kind, presets):
        print(folded(f"  {each['name']:{width}}  {each['description']}", columns_of(sys.stdout), width + 4))


def _described(kind: str, presets: Presets) -> Iterator[dict[str, str]]:
    for name in presets.names(kind):
        yield {
            "name": name,
            "description": presets.description(kind, name),
            "file": str(presets.path(kind, name)),
        }


def _show(names: Sequence[str], presets: Presets, as_json: bool) -> None:
    """Print the files of the presets that have one of the names."""
    from ...presets import KINDS, PresetError
    from ...presets.library import read_file

    known = {kind: presets.names(kind) for kind in KINDS}
    found = []
    for name in names:
        if name in KINDS:
            raise PresetError(f"{name}: expected names of presets, or kinds alone")
        kinds = [kind for kind in known if name in known[kind]]
        if not kinds:
            all_names = dict.fromkeys(each for kind in known for each in known[kind])
            meant = suggestion(name, KINDS) or suggestion(name, all_names)
            listed = f"expected a name that `carom presets` lists, or one of {', '.join(KINDS)}"
            raise PresetError(f"no preset {name!r}: {meant or listed}")
        found += [(kind, name, presets.path(kind, name)) for kind in kinds]
    if as_json:
        _print(
            [{"kind": kind, "name": name, "file": str(path), "data": read_file(path)[1]} for kind, name, path in found]
        )
        return
    for kind, _, path in found:
        print(f"# {kind}/{path.name}")
        print(path.read_text(encoding="utf-8"))


def _check(files: Sequence[str], presets: Presets, as_json: bool) -> int:
    """Print what each file holds, or on stderr what is wrong; return the exit code."""
    from ..preset_files import checked, files_in

    paths = [path for file in files for path in files_in(file)]
    with shown_progress(Work("presets", unit="files"), "checking", len(paths)) as show:
        results = []
        for path in paths:
            results.append(checked(path, presets))
            show(completed=len(results))
    if as_json:
        _print([result._asdict() for result in results])
    for result in results:
        if result.error:
            tell("presets", result.error)
        elif not as_json:
            print(f"{result.file}: {result.holds}")
    return 1 if any(result.error for result in results) else 0


def _write_glb(names: Sequence[str], presets: Presets, file: Path) -> int:
    """Write the modal model of an object as glTF."""
    from ...presets import PresetError
    from ...presets.gltf import glb_of

    if len(names) != 1:
        raise PresetError(f"--glb: {len(names)} names: expected that of one object")
    preset = presets.object(names[0])
    table = preset.geometry.get("table")
    if table is None or preset.material is None:
        raise PresetError(f"{names[0]}: shape = {preset.shape}: expected an object of the shape mesh")
    file.write_bytes(glb_of(preset.name, table, preset.material))
    print(file)
    return 0


def _print(value: Any) -> None:
    print(json.dumps(value, indent=2, ensure_ascii=False))


COMMAND = Command("presets", "[NAME ...]", "list the presets, show some, or check files of your own", _options, _run)
