"""Scores that can't be baked, and why."""

import pytest

from carom import Presets, ScoreError
from carom.clients.export.baking import bake
from carom.server.osc.score import parse
from carom.server.render import Options


def test_more_sensors_than_there_are_channels_for_are_refused():
    mounted = b"".join(b"0 /sensor/new s%d a 0.5\n" % n for n in range(63))
    score = parse(b"0 /object/new a glass-plate\n" + mounted, "x")
    with pytest.raises(ScoreError, match="an export has 64 channels: there are 2 of sound and 63 of sensors"):
        bake(score, Presets(), Options(48_000))
