"""Fixtures: sessions to play."""

import pytest

from carom.dsp.runtime.engine import Engine
from carom.presets.library import Presets
from carom.server.scene.session import Session
from tests.server.scene.support import say


@pytest.fixture
def session() -> Session:
    """One without objects."""
    return Session(Engine(48_000), Presets())


@pytest.fixture
def played(session: Session) -> Session:
    """One with a glass pane and a plastic cup."""
    for name, preset in (("pane", "glass-plate"), ("cup", "plastic-cup")):
        say(session, "/object/new", name, preset)
    return session
