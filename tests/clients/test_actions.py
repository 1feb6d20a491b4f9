"""The methods that a client and a scene share."""

import inspect
import subprocess
import sys

import numpy as np
import pytest

import carom
from carom.clients.actions import Actions, CommandError
from carom.dsp.schema import GESTURES
from carom.server.osc.addresses import VERBS
from carom.server.osc.wire import Message

SENSORS = {"sensor", "unmount"}
SHARED = sorted(name for name in vars(Actions) if not name.startswith("_"))


class Kept(Actions):
    """Keeps what is sent together, and when."""

    def __init__(self):
        self.sent = []

    def _send(self, messages, at):
        self.sent.append((at, *messages))


@pytest.mark.parametrize("name", SHARED)
def test_a_client_and_a_scene_take_the_same_and_say_the_same(name):
    shared, client, scene = (getattr(each, name) for each in (Actions, carom.Client, carom.Scene))
    assert client is shared
    assert inspect.signature(scene) == inspect.signature(shared)
    assert inspect.getdoc(scene).partition("\n\nOther Parameters")[0] == inspect.getdoc(shared)


def test_every_address_of_a_score_is_shared_but_those_that_only_begin_it():
    """The gain of everything, and sensors, have other names than an object and its; a simulation is told to World."""
    others = "/gesture/", "/world/", "/sensor/", "/object/NAME/macro/"
    said = {verb.action for verb in VERBS.values() if verb.scored and not verb.address.startswith(others)}
    begin, more = (
        {"new", "channels", "sensors", "full_scale", "end"},
        {"main_gain", "send", "steer", "stop", "macro", *SENSORS},
    )
    assert set(SHARED) == said - begin | more | {"contact"}  # which only says where it went


def test_the_keys_are_listed_for_a_scene_alone():
    taking = {verb.action for verb in VERBS.values() if verb.keys} & set(SHARED)
    changing = {"gain", "pan", "distance", "tune", "decay", "damp", "morph"}
    space = {"place", "listener", "floor", "room"}
    assert taking == {*GESTURES, "note", *changing, *space}
    for name in SHARED:
        assert ("\n\nOther Parameters\n---" in inspect.getdoc(getattr(carom.Scene, name))) == (name in taking)
        assert inspect.getdoc(getattr(carom.Scene, name)).count("Other Parameters") <= 1
        assert "Other Parameters" not in inspect.getdoc(getattr(carom.Client, name))
    assert "energy" not in inspect.getdoc(carom.Scene.pour)  # which /world/pour has
    assert "\npoint : x, y, z, each -1000 to 1000 m\n    Point" in inspect.getdoc(carom.Scene.slide)
    assert "\ngravity : 0.01 to 1000 m/s^2, default 9.80665\n    Gravity.\n" in inspect.getdoc(carom.Scene.roll)


def test_arguments_go_before_keys_and_become_plain():
    kept = Kept()
    kept.impact("a", np.float32(0.5), at=np.float64(2.0), edges=np.array(["free", "clamped"]), at_rest=[1, (2,)])
    kept.press("a", 1, 0.25)
    kept.gains("a", 0.5, np.float64(1.0), at=2.0)
    kept.gains("a", np.array([0.5, 1.0]))
    kept.gains("a")
    kept.main_gain(np.float32(-6))
    kept.limiter(False)
    kept.play(True)
    kept.headroom(True)
    kept.free("a", at=1.0)
    kept.free("a", at_once=True)
    assert kept.sent == [
        (2.0, Message("/object/a/impact", (0.5, "edges", ("free", "clamped"), "at_rest", (1, (2,))))),
        (None, Message("/object/a/press", (1, 0.25))),
        (2.0, Message("/object/a/gains", (0.5, 1.0))),
        (None, Message("/object/a/gains", ((0.5, 1.0),))),
        (None, Message("/object/a/gains")),
        (None, Message("/gain", (-6.0,))),
        (None, Message("/limiter", ("off",))),
        (None, Message("/play", ("on",))),
        (None, Message("/headroom", ("on",))),
        (1.0, Message("/object/a/free")),
        (None, Message("/object/a/free", (1,))),
    ]
    assert all(type(arg).__module__ == "builtins" for _, message in kept.sent for arg in message.args)


def test_values_are_steered_together():
    kept = Kept()
    kept.steer("ball", at=1.0, gain=-6, gravity=np.float64(1.62))
    assert kept.sent == [(1.0, Message("/gesture/ball/gain", (-6,)), Message("/gesture/ball/gravity", (1.62,)))]
    with pytest.raises(CommandError, match="/gesture/ball: expected a value to steer"):
        kept.steer("ball")
    assert len(kept.sent) == 1


def test_a_client_loads_neither_numpy_nor_the_engine():
    script = (
        "import sys, carom.clients.client; print(*{'numpy', 'numba', 'scipy', 'carom.dsp.engine'} & sys.modules.keys())"
    )
    assert subprocess.check_output([sys.executable, "-c", script], text=True).strip() == ""
