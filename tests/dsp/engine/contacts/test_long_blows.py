"""Blows that last for hundreds of samples are solved in blocks: against DOP853, and the same bits in any blocks."""

import numpy as np
import pytest

from carom.dsp.engine.memory.state import QUANTUM
from tests.dsp.contact.coupled_reference import Blow
from tests.dsp.engine.contacts.test_presses import in_blocks
from tests.dsp.engine.contacts.test_touches import (
    LIGHT,
    RATE,
    SLIPS,
    STIFF,
    YIELDING,
    check,
    expected,
    started,
    told,
    traced,
)
from tests.dsp.engine.support import gesture

BLOWS = {
    "light": (LIGHT, Blow(3.25 / RATE, 1.0, 0.004, 2e4, 0.2, 1.5)),
    "yielding": (YIELDING, Blow(3.25 / RATE, 0.8, 0.012, 8e4, 0.2, 1.5)),
    "stiff": (STIFF, Blow(3.25 / RATE, 2.0, 0.004, 2e4, 0.4, 2.0)),
}
SECONDS = 0.03


def struck(name, accuracy="-60"):
    modal_mass, blow = BLOWS[name]
    engine, handle = started(modal_mass, accuracy)
    engine.send([gesture("impact", handle, blow[2:6], 3.25, 3, velocity=blow.v_in)])
    return engine, handle


@pytest.mark.slow
@pytest.mark.parametrize("accuracy", ["-50", "-60"])
@pytest.mark.parametrize("name", BLOWS)
def test_a_long_blow_is_that_of_dop853(name, accuracy):
    modal_mass, blow = BLOWS[name]
    engine, handle = struck(name, accuracy)
    within = []
    entries = []
    for _ in range(int(SECONDS * RATE / QUANTUM)):
        entries.append(traced(engine, 1))
        within.append(in_blocks(engine, handle))
    assert sum(within) > 2 and not within[0]
    right = expected(modal_mass, blow, SECONDS, 2e-6)
    check(told(struck(name, accuracy)[0], SECONDS), right, blow, *SLIPS[accuracy])
    force = np.concatenate(entries)
    assert len(np.unique(force["sample"])) == len(force)  # each sample is told once


def test_a_long_blow_has_the_same_bits_in_blocks_of_any_size():
    def told_in(block):
        return told(struck("yielding")[0], 0.01, block)

    assert told_in(QUANTUM) == told_in(1) == told_in(480)
