"""What is packed: an sdist holds all that the repository does, but for what only its host needs."""

import subprocess
import sys
import tarfile

import pytest

from tests.test_house import ROOT

ONLY_HERE = (".ci/", ".github/", ".gitignore", ".pre-commit-config.yaml")


@pytest.mark.slow
def test_an_sdist_holds_the_repository(tmp_path):
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if listed.returncode:
        pytest.skip("no git checkout")
    files = {name for name in listed.stdout.splitlines() if (ROOT / name).is_file()}
    tree = tmp_path / "tree"
    for name in files:  # a build leaves files in its tree
        (tree / name).parent.mkdir(parents=True, exist_ok=True)
        (tree / name).write_bytes((ROOT / name).read_bytes())
    build = f"import setuptools.build_meta as build; build.build_sdist({str(tmp_path)!r})"
    subprocess.run([sys.executable, "-c", build], cwd=tree, check=True, capture_output=True)
    (archive,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as packed:
        names = {name.partition("/")[2] for name in packed.getnames()}
    assert {name for name in files - names if not name.startswith(ONLY_HERE)} == set()
    assert "CHANGELOG.md" in names and "presets/scores/demo.png" in names
