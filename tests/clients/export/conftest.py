"""The files of a scene, exported once for all tests of exports that one process runs."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.clients.export.pages import ENGINE

SEED = 46
TINY = "tests.clients.export.tiny"


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The files of a random scene, for pages and for C, and what messages to it shall do."""
    made = tmp_path_factory.mktemp("scene")
    words = [sys.executable, "-m", "tests.clients.export.make_scene", str(made), str(SEED), TINY]
    subprocess.run(words, env=ENGINE, check=True)
    return made


@pytest.fixture(scope="session")
def game(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The files of a scene with bodies."""
    made = tmp_path_factory.mktemp("game")
    words = [sys.executable, "-m", "tests.clients.export.make_game", str(made), TINY]
    subprocess.run(words, env=ENGINE, check=True)
    return made
