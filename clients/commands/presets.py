"""carom presets: list the presets, show some, or check files of your own."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from ...dsp.wording import expected, suggestion
from ..errors import tell
from .options import add_presets
from .parser import Command

if TYPE_CHECKING:
    from ...presets import Presets


def _options(parser: argparse.ArgumentParser) -> None:
    names = "presets to show, a kind to list (objects, strikers, materials, surfaces), or files to check"
    parser.add_argument("names", nargs="*", metavar="NAME", help=names)
    parser.add_argument(
        "--check", action="store_true", help="check the files NAME, or all in a folder NAME, and describe each"
    )
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--names", dest="bare", action="store_true", help="print names alone, one on each line")
    add_presets(parser)


def _run(arguments: argparse.Namespace) -> int:
    from ...presets import KINDS, Presets
    from ..preset_files import CheckError

    presets = Presets(arguments.presets)
    if arguments.check:
        if not arguments.names:
            raise CheckError("--check: no file; expected one or more")
        return _check(arguments.names, presets, arguments.json)
    if set(arguments.names) <= set(KINDS):
        _list([kind for kind in KINDS if kind in arguments.names or not arguments.names], presets, arguments)
    else:
        _show(arguments.names, presets, arguments.json)
    return 0


def _list(kinds: Sequence[str], presets: Presets, arguments: argparse.Namespace) -> None:
    """Print all presets of some kinds."""
    if arguments.json:
        _print({kind: list(_described(kind, presets)) for kind in kinds})
    elif arguments.bare:
        print("\n".join(dict.fromkeys(name for kind in kinds for name in presets.names(kind))))
    else:
        for kind in kinds:
            print(f"{kind}:")
            for each in _described(kind, presets):
                print(f"  {each['name']:20s} {each['description']}")


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
        kinds = [kind for kind in known if name in known[kind]]
        if not kinds:
            all_names = dict.fromkeys(each for kind in reversed(known) for each in known[kind])
            raise PresetError(f"no preset {name!r}: {suggestion(name, KINDS) or expected(name, all_names)}")
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
    """Print what each file holds, or on stderr what is wrong; returns the exit code."""
    from ..preset_files import checked, files_in

    results = [checked(path, presets) for file in files for path in files_in(file)]
    if as_json:
        _print([result._asdict() for result in results])
    for result in results:
        if result.error:
            tell("presets", result.error)
        elif not as_json:
            print(f"{result.file}: {result.holds}")
    return 1 if any(result.error for result in results) else 0


def _print(value: Any) -> None:
    print(json.dumps(value, indent=2, ensure_ascii=False))


COMMAND = Command("presets", "[NAME ...]", "list the presets, show some, or check files of your own", _options, _run)
