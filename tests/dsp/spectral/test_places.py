"""Places of modes in the spectral bank: none is lost or given twice, and what lies in disorder is put in order."""

import numpy as np
import pytest

from carom.dsp.engine.memory.state import new_state
from carom.dsp.spectral.basis import BINS
from carom.dsp.spectral.layout import REGION
from carom.dsp.spectral.places import (
    empty_phase,
    give_place,
    has_room,
    levels_of,
    put_in_order,
    put_number,
    take_place,
)
from carom.dsp.spectral.simd import CHUNK, MOTION, ROWS, WEIGHTS

MODES = 30_000


@pytest.fixture
def spectral():
    """A spectral bank whose phase 1 keeps all bins in float32."""
    made = new_state(48_000.0)[0]["spectral"]
    made["phases"]["single"][1] = 1
    return made


def put(spectral, phase, b, mode, slots):
    """Give a mode a place in a bin, and write its number there."""
    place = take_place(spectral, spectral["phases"][phase], b, mode, slots)
    for row in range(ROWS):
        put_number(spectral, spectral["phases"][phase]["single"][b], place, row, mode + row / 8)


def check(spectral, phases, bins, slots):
    """Assert that every mode that has a place is in its bin, by itself, with what was written there; all else is at
    rest."""
    taken = np.flatnonzero(slots)
    places = slots[taken] - 1
    assert len(np.unique(places)) == len(taken) == spectral["modes"]
    assert (spectral["owner"][places] == taken + 1).all()
    total = 0.0
    for p, phase in enumerate(spectral["phases"]):
        mine = phases[taken] == p
        first = phase["start"][bins[taken[mine]]] * CHUNK
        assert (first <= places[mine]).all()
        assert (places[mine] < first + phase["count"][bins[taken[mine]]] * CHUNK).all()
        assert (phase["count"] <= phase["room"]).all() and phase["modes"] == mine.sum() == phase["used"].sum()
        begin = np.sort(phase["start"][phase["room"] > 0])
        end = np.sort((phase["start"] + phase["room"])[phase["room"] > 0])
        assert (end[:-1] <= begin[1:]).all()  # no bin reaches into another
        for b in range(BINS):
            for name, rows in (("singles" if phase["single"][b] else "chunks", MOTION), ("weights", WEIGHTS)):
                numbers = spectral[name][phase["start"][b] * rows * CHUNK :]
                total += numbers[: phase["count"][b] * rows * CHUNK].sum(dtype=float)
    for row in range(ROWS):
        at = places // CHUNK * (MOTION * CHUNK) + row * CHUNK + places % CHUNK
        found = np.where(phases[taken] == 1, spectral["singles"][at], spectral["chunks"][at])
        if row >= MOTION:
            found = spectral["weights"][places // CHUNK * (WEIGHTS * CHUNK) + (row - MOTION) * CHUNK + places % CHUNK]
        np.testing.assert_array_equal(found, taken + row / 8)
    assert total == pytest.approx((ROWS * taken + sum(range(ROWS)) / 8).sum(), rel=1e-9)


@pytest.mark.slow
def test_modes_come_and_go_at_random(spectral):
    random = np.random.default_rng(2)
    slots = np.zeros(MODES, np.int32)
    bins, phases = (BINS * random.random(MODES) ** 3).astype(int), random.integers(0, 2, MODES)
    moved = 0
    for turn in range(40):
        share = 0.9 if turn % 10 < 5 else 0.2  # it fills up, and empties
        for mode in random.choice(MODES, 2_000, replace=False):
            phase = spectral["phases"][phases[mode]]
            if slots[mode] == 0 and random.random() < share and has_room(phase, 1):
                put(spectral, phases[mode], bins[mode], mode, slots)
            elif slots[mode] > 0 and random.random() > share:
                give_place(spectral, phase, bins[mode], mode, slots)
        for _ in range(20):
            put_in_order(spectral, 500, slots)
            moved += spectral["moving"] > 0
        if turn % 8 == 7:
            check(spectral, phases, bins, slots)
    assert moved > 20
    for p in range(8):
        empty_phase(spectral, spectral["phases"][p], slots)
    assert not slots.any() and spectral["modes"] == 0


@pytest.mark.slow
def test_a_phase_that_was_put_in_order_lies_so(spectral):
    """Bins that grew in turn lie one after the other afterwards, with room between them."""
    slots = np.zeros(MODES, np.int32)
    bins = np.arange(MODES) % 100
    for mode in range(MODES):
        put(spectral, 0, bins[mode], mode, slots)
    phase = spectral["phases"][0]
    before = phase["top"] - phase["region"]
    while True:
        put_in_order(spectral, 1_000, slots)
        if spectral["moving"] == 0:
            break
    held = phase["top"] - phase["region"]
    assert (np.diff(phase["start"][:100]) > 0).all() and phase["moved"] == 0
    assert held < 1.4 * MODES / CHUNK < 0.5 * before
    check(spectral, np.zeros(MODES, int), bins, slots)


@pytest.mark.slow
def test_modes_lie_in_an_emptied_phase_as_in_a_new_one(spectral):
    """The order of places is the order of a sum, and so of its rounding: it does not depend on what rang before."""
    random = np.random.default_rng(3)
    bins, phase, slots = random.integers(0, 40, 3_000), spectral["phases"][0], np.zeros(MODES, np.int32)

    def lie(modes):
        for mode in modes:
            put(spectral, 0, bins[mode], mode, slots)
        return [slots[mode] - phase["region"] * CHUNK for mode in modes], phase["top"] - phase["region"]

    def leave(modes):
        for mode in modes:
            give_place(spectral, phase, bins[mode], mode, slots)

    few = random.permutation(400)
    new = lie(few)
    for order in (few, few[::-1], random.permutation(few)):
        leave(order)
        lie(range(500, 3_000))
        put_in_order(spectral, 500, slots)
        leave(random.permutation(np.arange(500, 3_000)))
        put_in_order(spectral, 500, slots)
        assert lie(few) == new and spectral["moving"] == 0


def test_a_phase_says_when_it_is_full(spectral):
    assert has_room(spectral["phases"][0], 4_096)
    spectral["phases"][0]["top"] += REGION // 2
    assert not has_room(spectral["phases"][0], 4_096)


@pytest.mark.slow
@pytest.mark.parametrize("phase", [0, 1])
def test_levels_are_squared_amplitudes(spectral, phase):
    slots, bins = np.zeros(8, np.int32), np.full(8, 7, np.int16)
    for mode in (1, 5):
        put(spectral, phase, 7, mode, slots)
    expected = [0, 1 + 1.125**2, 0, 0, 0, 25 + 5.125**2, 0, 0]
    np.testing.assert_allclose(levels_of(spectral, phase, bins, slots), expected)
