"""A log of an engine that plays."""

import pytest

from carom.dsp.runtime.engine import NOW, Engine
from carom.presets.library import Presets
from carom.server.files.log import Log
from carom.server.osc.wire import Message
from carom.server.scene.session import Session


@pytest.fixture
def logged(tmp_path):
    """An engine, its scene and its log."""
    engine = Engine(48_000)
    scene = Session(engine, Presets())
    log = Log(engine, tmp_path / "log.txt")
    scene.on_sent = log.expect
    log.start()
    assert scene.perform([Message("/object/new", ("a", "wood-block"))], NOW)[0].address == "/done"
    yield engine, scene, log
    log.close()
