"""Blows that are known by their impulse: the force's sum over the contact is what was asked for."""

import numpy as np
import pytest

from carom.dsp.runtime.engine import Engine
from carom.presets.library import Presets
from carom.server.scene.session import Session
from tests.presets.examples import WALL
from tests.server.scene.support import refusal, say

RATE = 48_000
LAW = ("mass", 0.005, "stiffness", 5e7, "exponent", 1.5)


@pytest.fixture
def session(tmp_path) -> Session:
    """A session with a wall, and with objects that yield."""
    (tmp_path / "objects").mkdir()
    (tmp_path / "objects" / "wall.toml").write_text(WALL)
    session = Session(Engine(RATE), Presets([tmp_path]))
    session.engine.trace(True)
    for name in ("wall", "cymbal", "tin-lid", "wrench"):
        assert say(session, "/object/new", name, name)[0].address == "/done"
    return session


def impulse_of(session: Session, *message: str | float) -> float:
    """Return the impulse (N s) that a message to an object gives within 0.1 s."""
    assert say(session, *message) == []
    traced = []
    for _ in range(RATE // 640):
        session.engine.process(64)
        traced.append(session.engine.traced())
    return float(np.concatenate(traced)["impulse"].sum())


@pytest.mark.parametrize("lost", [(), ("restitution", 0.3), ("dissipation", 0.0), ("dissipation", 5.0)])
@pytest.mark.parametrize("impulse", [1e-6, 0.003, 0.3])
def test_a_wall_gets_the_impulse_that_was_asked_for(session, lost, impulse):
    got = impulse_of(session, "/object/wall/impact", "impulse", impulse, *LAW, *lost)
    assert got == pytest.approx(impulse, rel=1e-4)


@pytest.mark.parametrize(("name", "striker"), [("cymbal", "steel"), ("tin-lid", "wood"), ("tin-lid", "hammer")])
@pytest.mark.parametrize("impulse", [1e-4, 0.01])
def test_yielding_objects_get_the_impulse_within_3_db(session, name, striker, impulse):
    got = impulse_of(session, f"/object/{name}/impact", "impulse", impulse, "striker", striker)
    assert 0.7 < got / impulse < 1.42


def test_an_object_that_strikes_gives_it(session):
    got = impulse_of(session, "/object/cymbal/impact", "impulse", 0.1, "by", "wrench")
    assert 0.07 < got < 0.142


def test_a_blow_of_the_impulse_that_a_velocity_gives_sounds_as_it(session):
    message = ("/object/wall/impact", *LAW, "restitution", 0.6)
    by_speed = impulse_of(session, message[0], 2.0, *message[1:])
    assert by_speed == pytest.approx(0.005 * 2.0 * 1.6, rel=1e-4)
    assert impulse_of(session, message[0], "impulse", 0.005 * 2.0 * 1.6, *message[1:]) == pytest.approx(by_speed)


def test_no_impulse_is_no_blow(session):
    assert impulse_of(session, "/object/wall/impact", "impulse", 0.0) == 0.0


def test_an_impulse_is_refused_where_it_cannot_be(session):
    both = refusal(session, "/object/wall/impact", 1.0, "impulse", 0.3)
    assert both == "velocity = 1, impulse = 0.3: expected one of the two"
    fast = refusal(session, "/object/wall/impact", "impulse", 6.0, *LAW)
    assert fast == "impulse = 6: expected at most 5 N s of a striker of 0.005 kg"
    assert "the contact would last" in refusal(
        session, "/object/wall/impact", "impulse", 1e-9, "mass", 1.0, "stiffness", 1.0, "exponent", 1.5
    )
    assert "no such key" in refusal(session, "/object/wall/bounce", 1.0, "impulse", 0.3)
