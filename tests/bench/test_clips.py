"""The clips that are measured are random, seeded, and of the kinds that they say."""

import numpy as np
import pytest

from carom.dsp.runtime.engine import Engine
from tests.bench import clips, many


def test_clips_are_seeded_and_their_geometries_differ():
    first, second = (list(clips.clips("geometry", 40)) for _ in range(2))
    assert first == second != list(clips.clips("geometry", 40, seed=2))
    thicknesses = [clip["keys"]["thickness"] for clip in first]
    assert len(set(thicknesses)) == 40 and not any(clip["keys"] for clip in clips.clips("preset", 5))


def test_a_clip_has_a_second_of_sound_and_its_modes():
    sound, modes = clips.make(next(clips.clips("preset", 1)))
    assert sound.duration == 1.0 and np.abs(sound.samples[480:]).max() > 0.0
    assert sound.report.contacts >= 1 and len(modes.frequencies) > 0


@pytest.mark.slow
def test_calls_are_timed_and_the_method_is_put_back():
    before = Engine.process
    with clips.timed(Engine, "process") as taken:
        rows = clips.measure_clips(1)
    assert len(taken) > 0 and Engine.process is before
    assert [row["objects"] for row in rows] == list(clips.KINDS)
    assert all(row["ms"] > row["engine_ms"] > 0.0 for row in rows)


@pytest.mark.slow
def test_items_and_worlds_are_measured_beside_the_engine(monkeypatch):
    for name, few in (("ITEMS", 2), ("WORLDS", 1), ("SECONDS", 1.0)):
        monkeypatch.setattr(many, name, few)
    monkeypatch.setattr(
        many, "given", lambda geometry: {"object": {"preset": "glass-ball"}, "impact": {"velocity": 1.0}}
    )
    rows = many.measure()
    assert len(rows) == 5 and all(row["per_second"] > 0.0 and row["over_engine"] > 1.0 for row in rows)


def test_worlds_are_struck_once_a_second_and_body(monkeypatch):
    monkeypatch.setattr(many, "WORLDS", 1)
    (world,) = many.worlds()
    with world:
        assert many.step_all([world], False) == 4
        assert world.counts.hits == 4 * many.BODIES
