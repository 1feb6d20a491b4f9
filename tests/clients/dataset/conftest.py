"""A small data set, which several tests read."""

import pytest

from carom.clients.dataset.recipe import read
from carom.clients.dataset.run import Workers, run
from tests.clients.dataset.support import SMALL, written


@pytest.fixture(scope="session")
def made(tmp_path_factory):
    """A recipe's file, and the folder of its data set, by one process."""
    folder = tmp_path_factory.mktemp("made")
    path = written(folder, SMALL)
    run(read(path), folder / "out", Workers(1))
    return path, folder / "out"
