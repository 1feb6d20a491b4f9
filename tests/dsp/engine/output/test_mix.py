"""The mix: each object's share of it, what the limiter does to their sum, and for whom."""

import numpy as np
import pytest

from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.runtime.engine import Engine
from tests.dsp.engine.support import HARD, RATE, bell, free, gesture, set_limiter, setting, strike

FRAMES = 100 * QUANTUM
EPSILON = np.finfo(np.float32).eps


def scene(level=2.0, limited=False):
    """Return three objects, one of them struck by another, panned, one steered, one freed while it sounds."""
    engine = Engine(RATE, limited=limited)
    a, b, c = (engine.add(bell(n), level, pan=pan) for n, pan in ((5, -1.0), (24, 0.0), (40, 0.7)))
    for n, handle in enumerate((a, b, c)):
        strike(engine, handle, (0.01, 10.0 ** (5 + n), 0.5, 1.5), 97.3 * n, 0.3)
    engine.send([gesture("impact", a, HARD, 1_000.0, by=b, velocity=1.0, by_position=0.5)])
    engine.send([setting(b, "gain", 0.2, 2_000.0), free(c, at_once=True, time=3_000.0)])
    return engine, (a, b, c)


def with_shares(engine, frames, block):
    """Return the sound in blocks, and each slot's share of it: (frames, 2) and (OBJECTS, channels, frames)."""
    engine.stems.keep(True)
    blocks, shares = [], []
    for _ in range(0, frames, block):
        blocks.append(engine.process(block))
        if engine.position // QUANTUM > len(shares):
            shares.append(engine.stems.shares().copy())
    return np.concatenate(blocks), np.concatenate(shares, axis=2)


@pytest.mark.parametrize("block", [1, 16, QUANTUM])
def test_shares_add_up_to_the_sound_at_any_block_size(block):
    engine, handles = scene()
    sound, shares = with_shares(engine, FRAMES, block)
    assert engine.stats.limited == 0
    own = shares[[handle.slot for handle in handles]]
    assert np.abs(own).max(axis=(1, 2)).min() > 1e-3 and own[2, :, -QUANTUM:].max() < 1e-6
    np.testing.assert_allclose(own.sum(axis=0).T, sound, rtol=EPSILON, atol=1e-30)


def test_a_share_is_the_sound_of_its_object_alone():
    """The two agree up to the first contact between two objects, which are computed together from there on."""
    engine, handles = scene()
    _, shares = with_shares(engine, 15 * QUANTUM, QUANTUM)
    alone = Engine(RATE)
    alone.add(bell(5), 2.0)
    handle = alone.add(bell(24), 2.0)
    strike(alone, handle, (0.01, 1e6, 0.5, 1.5), 97.3, 0.3)
    np.testing.assert_array_equal(shares[handles[1].slot].T.astype(np.float32), alone.process(15 * QUANTUM))


@pytest.mark.slow
def test_an_object_that_is_gone_leaves_no_share():
    engine, (*_, freed) = scene()
    _, shares = with_shares(engine, 2 * FRAMES, QUANTUM)
    assert engine.state["objects"][0][freed.slot]["used"] == 0
    assert shares[freed.slot, :, : 40 * QUANTUM].any() and not shares[freed.slot, :, -QUANTUM:].any()


def test_keeping_shares_changes_no_bit():
    one, other = scene()[0], scene()[0]
    np.testing.assert_array_equal(with_shares(one, FRAMES, QUANTUM)[0], other.process(FRAMES))


def test_without_the_limiter_the_sum_is_left_as_it_is():
    """A thousand times as loud is a thousand times the sound, and what is limited is none of it."""
    (loud, _), (soft, _), (limited, _) = scene(2_000.0), scene(), scene(2_000.0, limited=True)
    sound, shares = with_shares(loud, FRAMES, QUANTUM)
    assert np.abs(sound).max() > 10.0 and loud.stats.limited == 0 and loud.stats.limit_lowest == 1.0
    np.testing.assert_allclose(shares.sum(axis=0).T, sound, rtol=EPSILON, atol=1e-30)
    # Modes of the soft one come to rest sooner.
    np.testing.assert_allclose(sound, 1e3 * soft.process(FRAMES), rtol=0, atol=1e-3 * np.abs(sound).max())
    assert np.abs(limited.process(FRAMES)).max() <= 1.0 and limited.stats.limited > 0


def test_the_limiter_can_be_switched_on_and_off_again():
    engine, _ = scene(2_000.0, limited=True)
    set_limiter(engine, False)
    assert np.abs(engine.process(10 * QUANTUM)).max() > 1.0
    set_limiter(engine, True)
    engine.process(QUANTUM)  # what was let through before
    assert np.abs(engine.process(10 * QUANTUM)).max() <= 1.0
    set_limiter(engine, False)
    assert np.abs(engine.process(10 * QUANTUM)).max() > 1.0


def test_shares_are_taken_before_the_limiter():
    engine, _ = scene(2_000.0, limited=True)
    sound, shares = with_shares(engine, FRAMES, QUANTUM)
    plain = scene(2_000.0)[0].process(FRAMES)
    np.testing.assert_allclose(shares.sum(axis=0).T[QUANTUM:], plain[:-QUANTUM], rtol=EPSILON, atol=1e-30)
    assert np.abs(sound).max() <= 1.0


def test_limited_energy_is_told_by_object_and_the_loudest_has_most():
    """The sum of squares of each share over the quanta that were turned down, or for which these were."""
    engine = Engine(RATE, limited=True)
    silent, soft, loud = (engine.add(bell(8, t60=0.05), level) for level in (1.0, 1.0, 2_000.0))
    strike(engine, soft)
    strike(engine, loud, time=500.0)
    engine.stems.keep(True)
    before, expected, turned_down = 0, np.zeros(3), False
    while engine.position < 24_000:
        engine.process(QUANTUM)
        if turned_down:
            expected += (engine.stems.shares()[[silent.slot, soft.slot, loud.slot]] ** 2).sum(axis=(1, 2))
        turned_down = engine.stats.limited > before
        before = engine.stats.limited
    told = engine.limited_energy()
    assert np.argmax(told) == loud.slot and told[silent.slot] == 0.0 < told[soft.slot] < 1e-3 * told[loud.slot]
    assert told[[silent.slot, soft.slot, loud.slot]] == pytest.approx(expected, rel=1e-12)
    assert not engine.limited_energy().any()


def test_of_a_sound_that_is_not_limited_no_energy_is_told():
    engine, _ = scene(limited=True)
    engine.process(FRAMES)
    assert not engine.limited_energy().any()
