"""A folder of presets for tests to fill."""

import pytest


@pytest.fixture
def folder(tmp_path):
    for kind in ("objects", "strikers", "surfaces", "materials"):
        (tmp_path / kind).mkdir()
    return tmp_path
