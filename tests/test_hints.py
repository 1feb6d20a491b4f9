"""mypy reads kernels: all have hints, none of which is Any, and a field that a record has not is found."""

import ast
import re
import shutil
import subprocess
import sys
from collections import defaultdict
from contextlib import suppress
from functools import cache
from itertools import chain, zip_longest
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[1]
KERNELS = {"kernel", "noinline_kernel", "simd_kernel", "c_function", "intrinsic"}
PLANTED = 20


class Place(NamedTuple):
    """An attribute of a record in a kernel: a file, a line, the column after it."""

    file: str
    line: int
    end: int


@cache
def trees() -> dict[str, ast.Module]:
    """Return the modules of the package's code, by their paths."""
    found = [path for folder in ("dsp", "server") for path in sorted((ROOT / folder).rglob("*.py"))]
    return {path.relative_to(ROOT).as_posix(): ast.parse(path.read_text()) for path in found}


def kernels(tree: ast.Module) -> list[ast.FunctionDef]:
    """Return the kernels of a module, those within functions too."""
    functions = [each for each in ast.walk(tree) if isinstance(each, ast.FunctionDef)]
    return [each for each in functions if KERNELS & {name for part in each.decorator_list for name in names(part)}]


def names(node: ast.AST | None) -> set[str]:
    """Return the names in an expression, those within strings too."""
    if node is None:
        return set()
    strings = [each.value for each in ast.walk(node) if isinstance(each, ast.Constant) and isinstance(each.value, str)]
    words = {word for text in strings for word in re.findall(r"\w+", text)}
    return words | {getattr(each, "id", getattr(each, "attr", "")) for each in ast.walk(node)}


def records() -> dict[str, ast.ClassDef]:
    """Return the declarations of all records, by their names."""
    classes = [each for tree in trees().values() for each in tree.body if isinstance(each, ast.ClassDef)]
    found = {"Record"}
    for _ in classes:
        found |= {each.name for each in classes if {name for base in each.bases for name in names(base)} & found}
    return {each.name: each for each in classes if each.name in found}


@pytest.mark.slow
def test_kernels_have_hints_and_none_is_any():
    found = []
    for path, tree in trees().items():
        for each in kernels(tree):
            hints = [each.returns, *(given.annotation for given in each.args.args)]
            if None in hints or any("Any" in names(hint) for hint in hints):
                found.append(f"{path}:{each.lineno} {each.name}")
    assert found == []


@pytest.mark.slow
def test_no_field_of_a_record_is_any():
    known = records()
    assert len(known) > 40
    fields = [each for record in known.values() for each in record.body if isinstance(each, ast.AnnAssign)]
    assert [ast.unparse(each) for each in fields if "Any" in names(each.annotation)] == []


def places(known: set[str]) -> list[Place]:
    """Return one attribute of a record in each of PLANTED kernels, spread over all packages."""
    packages = defaultdict(list)
    for path, tree in trees().items():
        for each in kernels(tree):
            given = {arg.arg for arg in each.args.args if names(arg.annotation) & known}
            read = [node for node in ast.walk(each) if isinstance(node, ast.Attribute) and names(node.value) & given]
            plain = [node for node in read if isinstance(node.value, ast.Name)]
            if plain:
                packages[Path(path).parent].append(Place(path, plain[0].end_lineno or 0, plain[0].end_col_offset or 0))
    return [each for each in chain(*zip_longest(*packages.values())) if each][:PLANTED]


def copy(folder: Path) -> Path:
    """Return a copy of the package under a folder."""
    package = folder / "carom"
    shutil.copytree(ROOT / "clients" / "face", package)
    for name in ("dsp", "server", "clients", "presets"):
        shutil.copytree(ROOT / name, package / name, ignore=shutil.ignore_patterns("__pycache__", "face"))
    return package


def checked(folder: Path) -> list[str]:
    """Return mypy's errors in a copy of the package, each as `path:line: text`, with the settings of `make lint`.

    What mypy keeps of its last run there spares it the modules that are as they were.
    """
    shutil.copy(ROOT / "pyproject.toml", folder)
    with suppress(FileNotFoundError):
        shutil.copytree(ROOT / ".mypy_cache", folder / ".mypy_cache")
    command = [sys.executable, "-m", "mypy", "--no-error-summary", "--no-pretty"]
    said = subprocess.run(
        [*command, "-p", "carom.dsp", "-p", "carom.server.bridge", "-p", "carom.server.net"],
        cwd=folder,
        capture_output=True,
        text=True,
    )
    assert said.returncode in (0, 1) and not said.stderr, (said.returncode, said.stderr)
    return [line.removeprefix("carom/") for line in said.stdout.splitlines() if ": error: " in line]


@pytest.mark.slow
def test_misspelt_fields_and_a_wrong_argument_are_found_where_they_stand(tmp_path):
    package, planted = copy(tmp_path), places(set(records()))
    assert len({(each.file, each.line) for each in planted}) == PLANTED
    assert len({Path(each.file).parent for each in planted}) >= 12
    for each in planted:
        lines = (package / each.file).read_bytes().splitlines(keepends=True)
        line = lines[each.line - 1]
        lines[each.line - 1] = line[: each.end] + b"_misspelt" + line[each.end :]
        (package / each.file).write_bytes(b"".join(lines))
    clock = package / "dsp" / "engine" / "memory" / "clock.py"
    with clock.open("a") as file:
        file.write("\n\n@kernel\ndef _wrong(clock: Clock) -> float:\n    return sample_at(clock.time, 0)\n")
    wrong = f"dsp/engine/memory/clock.py:{clock.read_text().count(chr(10))}"
    errors = checked(tmp_path)
    # Where a kernel returns a field, mypy says of the same line that it returns Any, too.
    assert {line.split(": ")[0] for line in errors} == {*(f"{each.file}:{each.line}" for each in planted), wrong}
    assert sum("_misspelt" in line and "[attr-defined]" in line for line in errors) == PLANTED
    assert any('has incompatible type "float"; expected "Clock"' in line for line in errors)
