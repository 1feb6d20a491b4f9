"""Loudness at a device: whatever a stranger sends, no sample is beyond full scale, nor no number."""

import random
from collections.abc import Iterator, Sequence

import numpy as np

from carom.dsp.runtime.engine import Engine
from carom.presets import Presets
from carom.server.options import BUDGET
from carom.server.osc.wire import Message
from carom.server.scene.session import Session
from tests.attack import Tried, kind
from tests.attack.arguments import message
from tests.attack.children import Child, Died
from tests.attack.combinations import gesture

_PRESETS = Presets()
_SECONDS = 0.1
_GAINS = (0.0, 60.0, 200.0, 1000.0, -1000.0)
_LIMITER = "/limiter"  # which a stranger can't turn off: tests/server/test_strangers.py


@kind("loudness", 12)
def loudness(chance: random.Random) -> Iterator[Tried]:
    """Two objects as loud as can be, gestures on them, and any messages."""
    names = _PRESETS.names("objects")
    with Child() as child:
        while True:
            rate, channels = chance.choice((8_000, 22_050, 48_000, 96_000)), chance.choice((1, 2, 5))
            said = [
                Message("/object/new", (name, chance.choice(names), "gain", chance.choice(_GAINS))) for name in "ab"
            ]
            said += [gesture(chance, name) for name in "ab"] + [message(chance) for _ in range(12)]
            said += [Message("/full_scale", (chance.choice((1e-6, 1.0, 1e6)),))]
            said += [Message("/gain", (chance.choice(_GAINS), "over", chance.choice((0.0, 0.01))))]
            try:
                refused, loudest = child.run(loudest_of, said, rate, channels, cpu=30)
            except Died as died:
                yield Tried(faults=(f"{died}: {said}",))
                continue
            faults = () if loudest <= 1.0 else (f"a sample of {loudest:g} at {rate} Hz, {channels} channels: {said}",)
            yield Tried(refused, len(said) - refused, faults)


def loudest_of(said: Sequence[Message], rate: int, channels: int) -> tuple[int, float]:
    """Return how many messages are refused, and the loudest sample after them; inf: one is no number."""
    session = Session(Engine(rate, channels, 65_536, 64, limited=True, sensors=1), _PRESETS)
    session.perform([Message("/budget", BUDGET)], 0.0)
    kept = [each for each in said if not each.address.startswith(_LIMITER)]
    refused = sum(reply.address == "/fail" for each in kept for reply in session.perform([each], 0.0))
    sound = session.engine.process(round(_SECONDS * rate))[:, : session.engine.channels]
    return refused, float(np.abs(sound).max()) if np.isfinite(sound).all() else np.inf
