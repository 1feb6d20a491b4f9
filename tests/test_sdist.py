"""The packages: an sdist holds all that the repository does, but for what only its host needs; a wheel its code."""

import os
import subprocess
import sys
import sysconfig
import tarfile
import zipfile

import pytest

from tests.test_house import ROOT

ONLY_HERE = (".ci/", ".github/", ".gitignore", ".pre-commit-config.yaml")


@pytest.fixture
def tree(tmp_path):
    """A copy of the repository: a build leaves files in its tree."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if listed.returncode:
        pytest.skip("no git checkout")
    tree = tmp_path / "tree"
    for name in (name for name in listed.stdout.splitlines() if (ROOT / name).is_file()):
        (tree / name).parent.mkdir(parents=True, exist_ok=True)
        (tree / name).write_bytes((ROOT / name).read_bytes())
    return tree


@pytest.mark.slow
def test_an_sdist_holds_the_repository(tree, tmp_path):
    files = {str(path.relative_to(tree)) for path in tree.rglob("*") if path.is_file()}
    build = f"import setuptools.build_meta as build; build.build_sdist({str(tmp_path)!r})"
    subprocess.run([sys.executable, "-c", build], cwd=tree, check=True, capture_output=True)
    (archive,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as packed:
        names = {name.partition("/")[2] for name in packed.getnames()}
    assert {name for name in files - names if not name.startswith(ONLY_HERE)} == set()
    assert "CHANGELOG.md" in names and "presets/scores/demo.png" in names


@pytest.mark.slow
def test_a_wheel_brings_its_code_though_its_python_has_no_numba(tree, tmp_path):
    """pip builds apart from what is installed: it lends what a build needs by PYTHONPATH."""
    lent = os.environ | {"PYTHONPATH": sysconfig.get_path("purelib"), "CAROM_WHEEL": "machine"}
    build = f"import setuptools.build_meta as build; build.build_wheel({str(tmp_path)!r})"
    subprocess.run([sys._base_executable, "-c", build], cwd=tree, check=True, capture_output=True, env=lent)
    (archive,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(archive) as packed:
        names = packed.namelist()
    assert any("/objects/modules/carom.dsp.runtime.callback/" in name for name in names)
    assert sum("/objects/units/" in name and name.endswith(".o") for name in names) > 20
