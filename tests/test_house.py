"""The house rules that a test can hold: packages, sizes, contents of the wheel."""

import ast
import sys
from pathlib import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

import pytest

from tests import needs

ROOT = Path(__file__).parents[1]
CODE = ("dsp", "server", "clients", "presets", "tests")
LONGEST_FILE, LONGEST_FUNCTION, MOST_PARAMETERS, MOST_IN_DSP = 500, 120, 12, 12

EXCEPTIONS = {
    "face/mujoco.py:__init__": "a face: keywords with defaults",
    "bodies/bar.py:bar": "a face: its keywords are a preset's keys",
    "bodies/disc.py:disc": "a face: its keywords are a preset's keys",
    "bodies/string.py:string": "a face: its keywords are a preset's keys",
    "lab/roll.py:make_roll": "a face: keywords with defaults",
    "karman/simd.py:put_products": "an intrinsic: its typing context, and arrays one by one",
}
"""Functions that are longer, or take more, each with the reason."""


def sources() -> list[Path]:
    return [path for folder in CODE for path in sorted((ROOT / folder).rglob("*.py"))]


def named(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def test_files_are_short():
    """But for the docstrings of classes and functions, which list parameters line by line."""
    lengths = {path: path.read_text().count("\n") for path in sources()}
    long = [path for path, length in lengths.items() if length > LONGEST_FILE]
    assert {named(path): lengths[path] for path in long if lengths[path] - documented(path) > LONGEST_FILE} == {}


def documented(path: Path) -> int:
    """Return the number of lines of the docstrings of a file's classes and functions."""
    kinds = ast.ClassDef, ast.FunctionDef
    nodes = [each for each in ast.walk(ast.parse(path.read_text())) if isinstance(each, kinds)]
    return sum(node.body[0].end_lineno - node.body[0].lineno for node in nodes if ast.get_docstring(node))


@pytest.mark.slow
def test_functions_are_short_and_take_few_parameters():
    found = {}
    for path in sources():
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.FunctionDef):
                length = node.end_lineno - node.lineno + 1
                given = node.args
                count = len(given.args) + len(given.kwonlyargs) + len(given.posonlyargs)
                if length > LONGEST_FUNCTION or count > MOST_PARAMETERS:
                    found[f"{path.parent.name}/{path.name}:{node.name}"] = (length, count)
    assert set(found) == set(EXCEPTIONS), found


def test_dsp_is_made_of_packages():
    assert len(list((ROOT / "dsp").glob("*.py"))) <= MOST_IN_DSP
    assert all((each / "__init__.py").exists() for each in (ROOT / "dsp").iterdir() if any(each.glob("*.py")))


def test_a_skip_says_how_to_get_what_it_lacks():
    """By the words of `needs` alone: programs and modules have the commands that bring them there."""
    own = {Path(__file__), ROOT / "tests" / "needs.py"}
    for path in sorted(set((ROOT / "tests").rglob("*.py")) - own):
        text = path.read_text(encoding="utf-8")
        assert "pytest.skip(" not in text and "importorskip" not in text, f"{named(path)}: expected a call of needs"


@pytest.mark.slow
def test_no_command_is_read_by_position():
    for path in sources():
        if path != Path(__file__):
            for node in ast.walk(ast.parse(path.read_text())):
                if isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name | ast.Attribute):
                    name = node.value.id if isinstance(node.value, ast.Name) else node.value.attr
                    index = node.slice
                    positional = isinstance(index, ast.Constant) and isinstance(index.value, int)
                    assert not (name == "values" and positional), f"{named(path)}:{node.lineno}"


def test_every_folder_is_packed():
    """The list of packages in pyproject.toml is the tree's."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    folders = {ROOT / place: name for name, place in settings["package-dir"].items()}
    found = set()
    for name in needs.tracked():
        parent = (ROOT / name).parent
        for folder in (parent, *parent.parents):
            if folder in folders and parent.name not in ("charts", "sounds"):
                parts = parent.relative_to(folder).parts
                found.add(".".join((folders[folder], *parts)))
                break
    assert found == set(settings["packages"])


UNTYPED = {"njit"}
"""Decorators of functions without hints: loops that numba compiles itself, in the laboratory alone."""


@pytest.mark.slow
def test_all_functions_have_hints():
    """mypy is told to forgive functions without hints where LLVM's instructions are written: this finds the others
    there."""
    found = []
    for path in (path for path in sources() if path.parts[-2] != "tests" and "tests" not in path.parts):
        module = ast.parse(path.read_text())
        functions = [each for each in ast.walk(module) if isinstance(each, ast.FunctionDef)]
        inner = {each for outer in functions for each in ast.walk(outer) if each is not outer}
        for node in functions:
            names = [each.id for part in node.decorator_list for each in ast.walk(part) if isinstance(each, ast.Name)]
            given = [each for each in (*node.args.args, *node.args.kwonlyargs) if each.arg != "self"]
            hinted = node.returns is not None or (given and all(each.annotation for each in given))
            if node not in inner and not hinted and not UNTYPED.intersection(names):
                found.append(f"{named(path)}:{node.lineno} {node.name}")
    assert found == []


def kinds_compared(tree):
    """Yield the lines in which the kind of a contact's gesture is compared with anything but another one's."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare):
            sides = [node.left, *node.comparators]
            of_gestures = [each for each in sides if isinstance(each, ast.Attribute) and is_kind(each)]
            if of_gestures and len(of_gestures) < len(sides):
                yield node.lineno


def is_kind(node):
    return node.attr == "what" or (node.attr == "kind" and "contact" in ast.unparse(node.value))


@pytest.mark.parametrize("code", ["contact.kind == 2", "event.what in (3, 1)", "state.contacts[i].kind != ROLL"])
def test_a_comparison_of_a_gestures_kind_is_found(code):
    assert list(kinds_compared(ast.parse(code))) == [1]


@pytest.mark.slow
def test_kernels_ask_traits_of_gestures_and_never_kinds():
    """The one table by gesture, `gesture_kernels.py`, compares none: it is data."""
    found = [
        f"{path}:{line}"
        for path in (ROOT / "dsp").rglob("*.py")
        for line in kinds_compared(ast.parse(path.read_text()))
    ]
    assert not found
