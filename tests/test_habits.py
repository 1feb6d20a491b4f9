"""The files around the code agree with it: versions, Pythons, commands."""

import re
import sys
from pathlib import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

import pytest

from tests import needs

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
TESTS = (ROOT / ".github" / "workflows" / "test.yml").read_text()


MARKS = re.compile(r"^@(c_function\(|elementwise$)", re.M)
"""Decorators of what is compiled ahead."""


def _is_compiled(path: Path) -> bool:
    return "lab" not in path.parts and MARKS.search(path.read_text()) is not None


def test_the_version_is_one():
    assert re.search(rf"^version: {re.escape(PROJECT['version'])}$", (ROOT / "CITATION.cff").read_text(), re.M)


def test_every_python_that_is_promised_is_tested():
    promised = [line.rsplit(" ", 1)[1] for line in PROJECT["classifiers"] if re.search(r":: 3\.\d+$", line)]
    assert promised == re.findall(r'"(3\.\d+)"', re.search(r"^        python: \[(.*)\]$", TESTS, re.M)[1])
    assert PROJECT["requires-python"] == f">={promised[0]}"


def test_the_lowest_the_highest_and_the_newest_numba_are_tested():
    (allowed,) = (each[5:] for each in PROJECT["optional-dependencies"]["compile"] if each.startswith("numba"))
    lowest, highest, newest = re.findall(r'- numba: "(.*)"', TESTS)
    assert highest == allowed and lowest.startswith(allowed.split(",")[0])
    assert newest == allowed.split(",")[0] and "may_fail: true" in TESTS


def test_a_wheel_holds_all_code_and_is_built_with_what_the_package_allows():
    compiled = re.search(r"^COMPILED = \((.*?)\)$", (ROOT / "setup.py").read_text(), re.M | re.S)[1]
    files = [path for package in ("dsp", "server") for path in (ROOT / package).rglob("*.py")]
    marked = {path.relative_to(ROOT).with_suffix("") for path in files if _is_compiled(path)}
    assert set(re.findall(r'"(.*)"', compiled)) == {".".join(("carom", *path.parts)) for path in marked}
    needed = tomllib.loads((ROOT / "pyproject.toml").read_text())["build-system"]["requires"]
    assert set(needed) <= {*PROJECT["dependencies"], *PROJECT["optional-dependencies"]["compile"], "setuptools>=77.0.3"}


@pytest.mark.parametrize("path", ["CONTRIBUTING.md", ".github/pull_request_template.md", "SECURITY.md"])
def test_the_commands_that_are_named_are_there(path):
    text = (ROOT / path).read_text()
    targets = set(re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(), re.M))
    assert set(re.findall(r"`make (\w+)`", text)) <= targets
    for command in set(re.findall(r"`carom (\w+)", text)):
        assert (ROOT / "clients" / "commands" / f"{command}.py").exists(), command
    for name in re.findall(r"`([\w./]+/[\w./]+)`", text):
        assert (ROOT / name).exists(), name


def test_every_file_that_is_published_is_in_the_tree():
    for line in (ROOT / "MANIFEST.in").read_text().splitlines():
        word, *names = line.split()
        if word in ("include", "graft"):
            assert all(any(ROOT.glob(name)) for name in names), line


def test_no_workflow_runs_what_is_not_there():
    for workflow in (ROOT / ".github" / "workflows").glob("*.yml"):
        for name in re.findall(r"presets/[\w/]+\.txt", workflow.read_text()):
            assert name in needs.tracked()
