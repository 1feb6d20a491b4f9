"""One file takes from numba what its documents don't have, and the numba that is installed has that."""

import ast
import re
from collections.abc import Iterator
from ctypes import c_double, c_int64
from pathlib import Path

import llvmlite.binding as llvm
import numba
import numpy as np
import platformdirs
import pytest

import carom.dsp.native
from carom.dsp.native.jit import c_function, kernel, noinline_kernel

NATIVE = Path(carom.dsp.native.__file__).parent
ROOT = Path(__file__).parents[3]
INTERNALS = NATIVE / "numba_internals.py"
DOCUMENTED = {"numba", "numba.extending", "numba.types", "llvmlite", "llvmlite.ir", "llvmlite.binding"}
"""Modules that numba's and llvmlite's documents have."""

_PRIVATE = re.compile(r"(?:numba|llvmlite)[\w.]*\._[a-z]\w*")


def undocumented(text: str) -> list[str]:
    """Return what a file takes of numba or llvmlite that their documents don't have."""
    return [each for node in ast.walk(ast.parse(text)) for each in _taken(node)] + _PRIVATE.findall(text)


def _taken(node: ast.AST) -> Iterator[str]:
    """Yield what a node takes by a name that isn't documented."""
    if isinstance(node, ast.Import):
        modules = [each.name for each in node.names]
    elif isinstance(node, ast.ImportFrom) and not node.level:
        modules = [node.module or ""]
        private = [each.name for each in node.names if each.name.startswith("_")]
        yield from (f"{node.module}.{each}" for each in private if _is_foreign(node.module or ""))
    elif isinstance(node, ast.Constant) and isinstance(node.value, str) and re.fullmatch(r"[\w.]+", node.value):
        modules = [node.value]  # imported by its name
    else:
        modules = []
    yield from (each for each in modules if _is_foreign(each) and each not in DOCUMENTED)


def _is_foreign(module: str) -> bool:
    return module.partition(".")[0] in {"numba", "llvmlite"}


def files() -> list[Path]:
    folders = ("dsp", "server", "clients", "presets", "tests")
    found = [path for folder in folders for path in sorted((ROOT / folder).rglob("*.py"))]
    return [each for each in (*found, ROOT / "setup.py") if each.name not in (INTERNALS.name, Path(__file__).name)]


@pytest.mark.slow
def test_undocumented_parts_of_numba_are_taken_by_one_file_alone():
    found = {path.relative_to(ROOT).as_posix(): undocumented(path.read_text()) for path in files()}
    assert {name: taken for name, taken in found.items() if taken} == {}
    assert len(undocumented(INTERNALS.read_text())) > 10


@pytest.mark.parametrize(
    "text",
    [
        "import numba.core.types",
        "from numba.core import cgutils",
        "from numba import _dynfunc",
        "from llvmlite.binding import ffi_private, _x",
        "from llvmlite.binding.ffi import ret_string",
        "kind = Later('numba.core.types')",
        "numba.njit._private()",
    ],
)
def test_such_names_are_found(text):
    assert undocumented(text)


def test_names_of_others_are_not_found():
    assert not undocumented("from numba import njit\nimport numpy._core\nself._numba_type_ = 'numba is a compiler.'")


@pytest.mark.parametrize("path", sorted(NATIVE.glob("*.py")), ids=lambda path: path.name)
def test_private_attributes_are_ours(path):
    """An attribute that begins with an underscore is one that the same file has defined."""
    text = path.read_text()
    if path.name == INTERNALS.name:
        return
    tree = ast.parse(text)
    of_others = [
        ast.unparse(node)
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute)
        and re.match(r"_[a-z]\w*$", node.attr)
        and node.attr not in {"_fields", "_field_defaults", "_asdict"}  # documented, of named tuples
        and not (isinstance(node.value, ast.Name) and node.value.id in {"self", "cls"})
    ]
    assert of_others == []


@kernel
def within(x):
    total = 0.0
    for i in range(4):
        total += max(x, 1.0 * i)
    return total


@noinline_kernel
def apart(x, more=1.0):
    return within(x) + more


@c_function(c_double, c_double)
def everything(x):
    return apart(x) + apart(x, more=2.0)


def test_the_numba_that_is_installed_has_all_that_is_taken(tmp_path, monkeypatch):
    monkeypatch.setattr(platformdirs, "user_cache_path", lambda name: tmp_path / name)
    try:
        from carom.dsp.native.translation import translate_units

        units = translate_units([everything], lambda unit: unit.source(), lambda: None)
    except (AttributeError, ImportError, TypeError) as error:
        pytest.fail(f"numba {numba.__version__} has moved what numba_internals.py takes: {error!r}")
    assert len(units) == 3  # `apart` for each way to call it
    assert within(2.0) == 2.0 + 2.0 + 2.0 + 3.0  # as a function of its own


TABLE = np.array([1.0, 2.0, 4.0])


@c_function(c_double, c_int64)
def value_of(n):
    return TABLE[n]


def test_an_index_counts_from_the_beginning(tmp_path, monkeypatch):
    """Code that looks whether it is negative took 8 % of the time of rolls."""
    monkeypatch.setattr(platformdirs, "user_cache_path", lambda name: tmp_path / name)
    from carom.dsp.native.translation import translate_units

    found = []
    translate_units([value_of], lambda unit: found.append(unit.source()), lambda: None)
    code = str(llvm.parse_bitcode(found[0]))
    assert "getelementptr" in code and "icmp slt" not in code
