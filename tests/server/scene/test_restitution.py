"""A restitution in place of a dissipation: the same at every speed, for strikes, bounces and presets of strikers."""

import math

import numpy as np
import pytest

from carom.dsp.numerics.constants import STANDARD_GRAVITY
from carom.dsp.runtime.engine import Engine
from carom.presets.library import Presets
from carom.server.scene.session import Session
from tests.presets.examples import WALL
from tests.server.scene.support import refusal, say

RATE = 48_000
LAW = ("mass", 0.005, "stiffness", 5e7, "exponent", 1.5)
STRIKER = """description = "A ball of a restitution"
source = "these tests"

mass = 0.005  # kg
stiffness = 5e7  # N/m^exponent
exponent = 1.5
restitution = 0.6
"""


@pytest.fixture
def wall(tmp_path) -> Session:
    """A session with a wall."""
    for kind, name, text in (("objects", "wall", WALL), ("strikers", "ball", STRIKER)):
        (tmp_path / kind).mkdir()
        (tmp_path / kind / f"{name}.toml").write_text(text)
    session = Session(Engine(RATE), Presets([tmp_path]))
    session.engine.trace(True)
    assert say(session, "/object/new", "wall", "wall")[0].address == "/done"
    return session


def followed(session: Session, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Return times (s) of the contacts that come to pass, each at the middle of its impulse, and their impulses (N
    s)."""
    entries = []
    for _ in range(math.ceil(seconds * RATE / 64)):
        session.engine.process(64)
        entries.append(session.engine.traced())
    trace = np.concatenate(entries)
    trace = trace[trace["impulse"] != 0]
    contact = np.cumsum(np.diff(trace["sample"], prepend=trace["sample"][0]) > 0.002 * RATE)
    impulse = np.bincount(contact, trace["impulse"])
    return np.bincount(contact, trace["impulse"] * (trace["sample"] + 0.5)) / impulse / RATE, impulse


@pytest.mark.parametrize("restitution", [0.2, 0.6, 0.945, 1.0])
@pytest.mark.parametrize("velocity", [0.01, 0.3, 10.0])
def test_a_blow_leaves_its_share_of_the_speed_at_any_speed(wall, restitution, velocity):
    assert say(wall, "/object/wall/impact", velocity, *LAW, "restitution", restitution) == []
    _, impulse = followed(wall, 0.05)
    assert impulse == pytest.approx([0.005 * velocity * (1 + restitution)], rel=1e-4)


def test_a_dissipation_leaves_more_of_a_slower_one(wall):
    left = []
    for velocity in (0.01, 10.0):
        say(wall, "/object/wall/impact", velocity, *LAW, "dissipation", 0.3)
        left.append(followed(wall, 0.05)[1][0] / (0.005 * velocity) - 1)
    assert left[0] > 0.99 and left[1] < 0.4


@pytest.mark.parametrize("restitution", [0.5, 0.9])
def test_bounces_follow_it(wall, restitution):
    """Each flight lasts for its share of the one before."""
    say(wall, "/object/wall/bounce", 0.5, *LAW, "restitution", restitution)
    times, impulses = followed(wall, 3.0)
    flights = np.diff(times)
    assert flights[0] == pytest.approx(2 * restitution * math.sqrt(2 * 0.5 / STANDARD_GRAVITY), rel=2e-3)
    long = np.arange(
        np.argmax(np.append(flights, 0.0) < 0.06)
    )  # the contact's own time, which the flights hold, is 0.2 ms
    assert len(long) >= 3
    assert flights[long[1:]] / flights[long[:-1]] == pytest.approx(restitution, rel=4e-3)
    assert impulses[long[1:]] / impulses[long[:-1]] == pytest.approx(restitution, rel=1e-3)


def left_by(session: Session, *keys) -> float:
    """Return the share of 1 m/s that a blow leaves."""
    assert say(session, "/object/wall/impact", 1.0, *keys) == []
    return followed(session, 0.05)[1][0] / 0.005 - 1


def test_a_striker_has_one_and_a_key_takes_its_place(wall):
    assert left_by(wall, "striker", "ball") == pytest.approx(0.6, rel=1e-3)
    assert left_by(wall, "striker", "ball", "restitution", 0.8) == pytest.approx(0.8, rel=1e-3)
    assert left_by(wall, "striker", "ball", "dissipation", 0.0) == pytest.approx(1.0, rel=1e-3)
    assert left_by(wall, *LAW, "dissipation", 0.3) == pytest.approx(left_by(wall, *LAW, "dissipation", 0.3))


@pytest.mark.parametrize("gesture", [("impact", 1.0), ("bounce", 0.1), ("press", 1.0), ("spin", 1.0)])
def test_both_at_once_are_refused_by_name(wall, gesture):
    verb, value = gesture
    reason = refusal(wall, f"/object/wall/{verb}", value, "dissipation", 0.3, "restitution", 0.5)
    assert reason == "dissipation = 0.3, restitution = 0.5: expected one of the two"


def test_wrong_restitutions_are_refused_by_name(wall):
    for value in (0.0, 1.5, -0.1, math.nan):
        assert refusal(wall, "/object/wall/impact", 1.0, "restitution", value).startswith("restitution = ")
    assert "expected dissipation" in refusal(wall, "/object/wall/roll", 0.3, "restitution", 0.5)
    say(wall, "/object/wall/bounce", 0.5, *LAW, "restitution", 0.9, "id", "ball")
    assert "unknown action 'restitution'" in refusal(wall, "/gesture/ball/restitution", 0.5)  # it is not steered


def test_a_preset_with_both_or_none_is_refused(wall, tmp_path):
    for text in (STRIKER + "dissipation = 0.1\n", STRIKER.replace("restitution = 0.6\n", "")):
        (tmp_path / "strikers" / "wrong.toml").write_text(text)
        reason = refusal(wall, "/object/wall/impact", 1.0, "striker", "wrong")
        assert "wrong.toml" in reason and reason.endswith("dissipation, restitution: expected one of the two")


# Who sounds


def heard(session: Session, *keys) -> float:
    """Return the loudest of what a blow at 1 m/s makes on the wall, which makes next to nothing."""
    session.engine.process(RATE // 10)
    assert say(session, "/object/wall/impact", 1.0, *keys) == []
    return float(np.abs(session.engine.process(4800)).max())


def test_a_mass_and_a_stiffness_sound_of_nothing(wall):
    """The sound is no striker's, least of all the one's that the object is usually struck with."""
    usual, silent = heard(wall), heard(wall, "mass", 0.0041, "stiffness", 1e10)
    assert silent < 1e-3 * usual
    assert heard(wall, "mass", 0.0041, "stiffness", 1e10, "striker", "steel") > 0.5 * usual
    assert heard(wall, "mass", 0.0041) > 0.5 * usual  # the usual one, said to be heavier
