"""Scores that can't be baked, and why; the channels of those that can."""

from pathlib import Path

import pytest

from carom import Presets, ScoreError
from carom.clients.export.baking import Baked, bake
from carom.clients.export.machines import machine_of
from carom.clients.export.mapping import Strikers, scene_map
from carom.clients.export.plugins import write_plugin
from carom.clients.export.scene import ExportError, Scene
from carom.dsp.engine.memory.state import STATE
from carom.dsp.runtime.engine import NOW, Engine
from carom.server.osc.score import parse
from carom.server.osc.wire import Message
from carom.server.render import Options
from carom.server.scene.session import Session


def test_more_sensors_than_there_are_channels_for_are_refused():
    mounted = b"".join(b"0 /sensor/new s%d a 0.5\n" % n for n in range(63))
    score = parse(b"0 /object/new a glass-plate\n" + mounted, "x")
    with pytest.raises(ScoreError, match="an export has 64 channels: there are 2 of sound and 63 of sensors"):
        bake(score, Presets(), Options(48_000))


def test_a_sensor_has_a_channel_of_what_is_exported_and_a_plug_in_has_none():
    """Programs and pages make room for as many channels as the engine fills."""
    engine = Engine(48_000.0, 1, sensors=1)
    baked = Baked(engine, Session(engine, Presets()), [], [], engine.process(64))
    strikers = Strikers(Presets())
    strikers.names, strikers.surfaces = [], []
    assert scene_map(baked, strikers)["channels"] == 2 == baked.sound.shape[1]
    with pytest.raises(ExportError, match="x: expected no sensor, as a plug-in has channels of sound alone"):
        write_plugin([Scene(baked, strikers, "x", {})], Path("never"), machine_of(None))


@pytest.mark.slow
def test_a_scene_takes_no_memory_for_plates_that_it_lacks():
    """The tables of plates that stretch end an engine's memory, before those of swarms."""
    engine = Engine(48_000.0, 1)
    session, strikers = Session(engine, Presets()), Strikers(Presets())
    strikers.names, strikers.surfaces = [], []
    sizes = []
    for preset in ("glass-plate", "crash-cymbal"):
        session.perform([Message("/object/new", ("a", preset))], NOW)
        session.perform([Message("/object/a/free", ())], NOW)
        baked = Baked(engine, session, [], [], engine.process(64))
        sizes.append(scene_map(baked, strikers)["size"])
    assert sizes == [STATE.fields[name][1] for name in ("curves", "pulses")]


def test_a_guitar_is_exported_with_the_pitch_of_its_string():
    """Copies that play notes are tuned by it, not by the lower modes of the body."""
    engine = Engine(48_000.0, 1)
    session, strikers = Session(engine, Presets()), Strikers(Presets())
    strikers.names, strikers.surfaces = [], []
    session.perform([Message("/object/new", ("a", "guitar-string"))], NOW)
    baked = Baked(engine, session, [], [], engine.process(64), dict(session.objects))
    told = scene_map(baked, strikers)["objects"]["a"]
    assert told["pitch"] == pytest.approx(329.6, rel=1e-3)
