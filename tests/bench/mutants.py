"""The teeth of the tests: `python -m tests.bench.mutants` breaks the engine one line at a time, and counts how many of
the broken engines some test notices.

A line is drawn from all lines of kernels, and one thing on it is changed: an operator, a comparison, a number, or an
assignment, which is left out. A copy of the tree with that line compiles what has changed, and runs tests until one
fails: those of the broken module first, then the quick ones of its folder, then all quick ones of the engine. What no
test notices is printed, to be looked at: some of it makes no difference to any sound. `--tests` names the tests, in
words for pytest; `--only` takes some of the lines that were drawn, by their numbers. A line takes ten seconds of CPU or
more, and two minutes if no test notices it.
"""

import argparse
import ast
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from carom.dsp.native.store import user_cache
from carom.dsp.runtime.engine import prepare

ROOT = Path(__file__).parents[2]
FOLDERS = ("contact", "engine", "friction", "karman", "resonator", "rolling", "space", "spectral", "swarm")
QUICK = ["-m", "not slow"]
LONGEST = 120
"""s of CPU: a broken engine that goes on for so long has been noticed. All quick tests take a third of it."""
NOT_COMPILED = 99

RUN = f"""
import resource, sys
resource.setrlimit(resource.RLIMIT_CPU, ({LONGEST}, {LONGEST}))
import pytest
from carom.dsp.runtime.engine import prepare
try:
    prepare()
except Exception as error:
    print(error)
    sys.exit({NOT_COMPILED})
sys.exit(pytest.main(sys.argv[1:]))
"""

SWAPPED = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Lt: ast.GtE, ast.GtE: ast.Lt,
    ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip


class Mutant(NamedTuple):
    """A change of one line: a file under dsp, the line, what was changed, and the file's text with it."""

    file: Path
    line: int
    change: str
    text: str


def kernels(tree: ast.Module) -> Iterator[ast.FunctionDef]:
    """Yield the kernels of a module."""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and any("kernel" in ast.unparse(each) for each in node.decorator_list):
            yield node


def places(tree: ast.Module) -> list[ast.AST]:
    """Return what can be changed in the kernels of a module, in the order of `ast.walk`."""
    found: list[ast.AST] = []
    for kernel in kernels(tree):
        for statement in kernel.body:
            for node in ast.walk(statement):
                plain = isinstance(node, ast.Assign | ast.AugAssign) and not isinstance(_target(node), ast.Name)
                number = isinstance(node, ast.Constant) and type(node.value) in (int, float)
                operator = isinstance(node, ast.BinOp | ast.BoolOp | ast.Compare) and _operator(node) in SWAPPED
                if plain or number or operator:
                    found.append(node)
    return found


def _target(node: ast.Assign | ast.AugAssign) -> ast.expr:
    return node.targets[0] if isinstance(node, ast.Assign) else node.target


def _operator(node: ast.BinOp | ast.BoolOp | ast.Compare) -> type[ast.AST]:
    return type(node.ops[0] if isinstance(node, ast.Compare) else node.op)


def change(node: ast.AST) -> str:
    """Change a place in its tree; return what was done, in words."""
    before = ast.unparse(node)
    if isinstance(node, ast.Constant):
        node.value = node.value + 1 if isinstance(node.value, int) else 1.01 * node.value or 0.01  # type: ignore[operator]
    elif isinstance(node, ast.Compare):
        node.ops[0] = SWAPPED[type(node.ops[0])]()
    elif isinstance(node, ast.BinOp | ast.BoolOp):
        node.op = SWAPPED[type(node.op)]()  # type: ignore[assignment]
    elif isinstance(node, ast.Assign | ast.AugAssign):
        node.__class__ = ast.Pass  # type: ignore[assignment]
        return f"{before}  left out"
    return f"{before}  ->  {ast.unparse(node)}"


def draw(count: int, seed: int) -> list[Mutant]:
    """Return broken modules: lines of kernels drawn at random, and on each of them one place."""
    lines = []
    for folder in FOLDERS:
        for file in sorted((ROOT / "dsp" / folder).rglob("*.py")):
            numbers: dict[int, list[int]] = {}
            for number, node in enumerate(places(ast.parse(file.read_text("utf-8")))):
                numbers.setdefault(node.lineno, []).append(number)  # type: ignore[attr-defined]
            lines += [(file, line, found) for line, found in numbers.items()]
    random_ = random.Random(seed)
    drawn = []
    for file, line, found in random_.sample(lines, count):
        tree = ast.parse(file.read_text("utf-8"))
        said = change(places(tree)[random_.choice(found)])
        drawn.append(Mutant(file.relative_to(ROOT), line, said, ast.unparse(tree)))
    return drawn


def copied(folder: Path) -> None:
    """Copy the tree, as the package that is imported, its tests, and a cache with the code of this tree's engine."""
    ignored = shutil.ignore_patterns("__pycache__", "face")
    shutil.copytree(ROOT / "clients" / "face", folder / "carom")
    for name in ("dsp", "server", "clients", "presets"):
        shutil.copytree(ROOT / name, folder / "carom" / name, ignore=ignored)
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(ROOT / "tests", folder / "tests", ignore=ignored)
    for name in ("pyproject.toml", "setup.py"):
        shutil.copy(ROOT / name, folder)
    (folder / "cache" / "carom").mkdir(parents=True)
    with suppress(shutil.Error):  # of files that another process prunes meanwhile
        shutil.copytree(user_cache(), folder / "cache" / "carom" / "code")


def nearest(file: Path) -> list[list[str]]:
    """Return the tests that may notice a broken module, in words for pytest: all of its own, then the quick ones of its
    folder, then of all folders."""
    folder = Path("tests", file.parent)
    own = [[str(each)] for each in (folder / f"test_{file.stem}.py",) if (ROOT / each).exists()]
    return [*own, [str(folder), *QUICK], ["tests/dsp", "tests/server/scene", *QUICK]]


def noticed(folder: Path, mutant: Mutant, stages: list[list[str]]) -> str | None:
    """Return the first test that fails with a broken module: "" where none does, None where it does not compile."""
    file = folder / "carom" / mutant.file
    before = file.read_text("utf-8")
    file.write_text(mutant.text, "utf-8")
    try:
        for words in stages:
            if (by := failed(folder, words)) != "":
                return by
    finally:
        file.write_text(before, "utf-8")
    return ""


def failed(folder: Path, tests: list[str]) -> str | None:
    """Run tests in a copy of the tree; return as `noticed`."""
    env = os.environ | {
        "PYTHONPATH": str(folder), "XDG_CACHE_HOME": str(folder / "cache"), "OPENBLAS_NUM_THREADS": "1",
    }  # fmt: skip
    words = [sys.executable, "-c", RUN, "-x", "-q", "--tb=no", "-rfE", "--reruns=0", *tests]
    run = subprocess.run(words, cwd=folder, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if run.returncode == NOT_COMPILED:
        return None
    if run.returncode in (0, 5):  # 5: no test was there
        return ""
    named = [line for line in run.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return named[0].split(" ")[1] if named else f"(exit code {run.returncode})"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--count", type=int, default=100, help="lines that are broken")
    parser.add_argument("--seed", type=int, default=1, help="of what is drawn")
    parser.add_argument("--only", type=int, nargs="+", help="of these lines, by their numbers")
    parser.add_argument("--tests", nargs=argparse.REMAINDER, help="words for pytest, at the end")
    options = parser.parse_args()
    prepare()
    drawn = draw(options.count, options.seed)
    chosen = options.only or range(1, len(drawn) + 1)
    caught, compiled, noticing = 0, 0, set()
    with tempfile.TemporaryDirectory(prefix="carom-mutants-") as name:
        folder = Path(name)
        copied(folder)
        for number in chosen:
            mutant = drawn[number - 1]
            by = noticed(folder, mutant, [options.tests] if options.tests else nearest(mutant.file))
            caught, compiled = caught + bool(by), compiled + (by is not None)
            said = "(does not compile)" if by is None else by or "NOT NOTICED"
            print(f"{number:4} {said}\n     {mutant.file}:{mutant.line}: {mutant.change}", flush=True)
            noticing |= {by} if by and by[0] != "(" else set()
        if sound := noticing and failed(folder, sorted(noticing)):
            sys.exit(f"{sound} fails with nothing broken, too")
    print(f"{caught} of {compiled} noticed; {len(chosen) - compiled} more did not compile")


if __name__ == "__main__":
    main()
