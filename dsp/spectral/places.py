"""The places of modes in a spectral bank: taken, given back, and put in order again."""

import numpy as np
from numpy.typing import NDArray

from ..native.jit import kernel
from ..native.typed import View
from .basis import BINS
from .layout import PHASE_MODES, REGION, Phase, Spectral
from .simd import CHUNK, MOTION, ROWS, WEIGHTS

_SPREAD = 4  # a bin that has run full gets room for this share more chunks, and
_LEAST = 2  # so many at least
_DISORDER = 4  # a phase is put in order when this share of its chunks has moved, or holds no mode
_SMALL = 2 * BINS  # chunks: below this order saves nothing


@kernel
def has_room(phase: Phase, modes: int) -> bool:
    """True if so many modes find places, in whichever bins they are."""
    held = phase.top - phase.region
    return 2 * held + held // _SPREAD + (_LEAST + 1) * modes <= REGION and phase.modes + modes <= PHASE_MODES


@kernel
def _grown(count: int) -> int:
    """Return the room for a bin with so many chunks."""
    return count + max(_LEAST, count // _SPREAD)


@kernel
def take_place(spectral: Spectral, phase: Phase, b: int, mode: int, slots: View[int]) -> int:
    """Take a place for a mode (its number) in a bin of a phase that `has_room`; slots[mode] holds 1 + the place."""
    if phase.free[b] == 0:
        if phase.count[b] == phase.room[b]:
            # Move a bin that has run full to where it has more room.
            room = _grown(phase.count[b])
            phase.moved += phase.count[b]
            _move(spectral, phase, b, room, slots)
        # Add an empty chunk to a bin that has room for it.
        first = (phase.start[b] + phase.count[b]) * CHUNK
        phase.count[b] += 1
        for place in range(first + CHUNK - 1, first - 1, -1):
            _silence(spectral, phase.single[b], place)
            spectral.owner[place] = -phase.free[b]
            phase.free[b] = 1 + place
    place = phase.free[b] - 1
    phase.free[b] = -spectral.owner[place]
    spectral.owner[place] = 1 + mode
    slots[mode] = 1 + place
    phase.used[b] += 1
    phase.modes += 1
    spectral.modes += 1
    return place


@kernel
def give_place(spectral: Spectral, phase: Phase, b: int, mode: int, slots: View[int]) -> None:
    """Give a mode's place in a bin back."""
    place = slots[mode] - 1
    slots[mode] = 0
    _silence(spectral, phase.single[b], place)
    spectral.owner[place] = -phase.free[b]
    phase.free[b] = 1 + place
    phase.used[b] -= 1
    phase.modes -= 1
    spectral.modes -= 1
    if phase.used[b] == 0:
        # What comes next finds an empty bin as it was at first: the order of places is the order of a sum.
        phase.count[b] = phase.free[b] = 0
    if phase.modes == 0:
        _begin_anew(phase)


@kernel
def _begin_anew(phase: Phase) -> None:
    """Take the room back from all bins of a phase without modes."""
    for b in range(BINS):
        phase.count[b] = phase.room[b] = phase.used[b] = phase.free[b] = 0
    phase.modes = phase.moved = 0
    phase.top = phase.region


@kernel
def _number_at(place: int, row: int, rows: int) -> int:
    """Return the index of a place's number in one row, among chunks of so many rows."""
    return place // CHUNK * (rows * CHUNK) + row * CHUNK + place % CHUNK


@kernel
def number(spectral: Spectral, single: int, place: int, row: int) -> float:
    """Return a place's number of a row, in a bin that is kept in float32 (single: 1) or in float64."""
    if row >= MOTION:
        return float(spectral.weights[_number_at(place, row - MOTION, WEIGHTS)])
    at = _number_at(place, row, MOTION)
    return float(spectral.singles[at]) if single == 1 else spectral.chunks[at]


@kernel
def put_number(spectral: Spectral, single: int, place: int, row: int, value: float) -> None:
    """Set a place's number of a row; else as `number`."""
    if row >= MOTION:
        spectral.weights[_number_at(place, row - MOTION, WEIGHTS)] = value
    elif single == 1:
        spectral.singles[_number_at(place, row, MOTION)] = value
    else:
        spectral.chunks[_number_at(place, row, MOTION)] = value


@kernel
def _silence(spectral: Spectral, single: int, place: int) -> None:
    """Fill a place with a mode that is at rest."""
    for row in range(ROWS):
        put_number(spectral, single, place, row, 0.0)


@kernel
def _move(spectral: Spectral, phase: Phase, b: int, room: int, slots: View[int]) -> None:
    """Move a bin's modes to the phase's top, where it gets room for so many chunks, without gaps between them."""
    old, count, single = phase.start[b], phase.count[b], phase.single[b]
    phase.start[b], phase.room[b] = phase.top, room
    phase.top += room
    phase.count[b] = phase.free[b] = 0
    to = phase.start[b] * CHUNK
    for place in range(old * CHUNK, (old + count) * CHUNK):
        mode = spectral.owner[place] - 1
        if mode < 0:
            continue
        for row in range(ROWS):
            put_number(spectral, single, to, row, number(spectral, single, place, row))
        spectral.owner[to] = 1 + mode
        slots[mode] = 1 + to
        to += 1
    # The rest of the last chunk is free.
    taken = to - phase.start[b] * CHUNK
    phase.count[b] = (taken + CHUNK - 1) // CHUNK
    for place in range((phase.start[b] + phase.count[b]) * CHUNK - 1, to - 1, -1):
        _silence(spectral, single, place)
        spectral.owner[place] = -phase.free[b]
        phase.free[b] = 1 + place


@kernel
def put_in_order(spectral: Spectral, budget: int, slots: View[int]) -> None:
    """Bring what has come out of order back into it, bin by bin: about `budget` modes at a time, in one phase."""
    if spectral.moving > 0 and spectral.phases[spectral.moving - 1].modes == 0:
        spectral.moving = 0
    if spectral.moving == 0:
        # Begin with the first phase that needs it: from now on it takes its room from the spare region.
        for p in range(len(spectral.phases)):
            phase = spectral.phases[p]
            held = phase.top - phase.region
            needed = phase.modes // CHUNK + BINS
            if phase.moved * _DISORDER > needed + _SMALL or held > 2 * needed + _SMALL:
                phase.region, spectral.spare = spectral.spare, phase.region
                phase.top = phase.region
                phase.moved = 0
                spectral.moving, spectral.next_bin = 1 + p, 0
                break
    if spectral.moving == 0:
        return
    phase = spectral.phases[spectral.moving - 1]
    done = 0
    while spectral.next_bin < BINS and done < budget:
        b = spectral.next_bin
        if not phase.region <= phase.start[b] < phase.region + REGION or phase.room[b] == 0:
            done += phase.used[b]
            needed = (phase.used[b] + CHUNK - 1) // CHUNK
            _move(spectral, phase, b, _grown(needed) if needed > 0 else 0, slots)
        spectral.next_bin += 1
    if spectral.next_bin == BINS:
        spectral.moving = 0


@kernel
def empty_phase(spectral: Spectral, phase: Phase, slots: View[int]) -> None:
    """Give all places of a phase back."""
    for b in range(BINS):
        for place in range(phase.start[b] * CHUNK, (phase.start[b] + phase.count[b]) * CHUNK):
            mode = spectral.owner[place] - 1
            if mode >= 0:
                slots[mode] = 0
    spectral.modes -= phase.modes
    _begin_anew(phase)
    phase.sounds = 0


def levels_of(spectral: np.void, p: int, bins: NDArray[np.int16], places: NDArray[np.int32]) -> NDArray[np.float64]:
    """Return the squared amplitudes of modes of phase p in such bins and places, 1 + number; 0 where they have none."""
    place = np.maximum(places.astype(np.int64) - 1, 0)
    first = place // CHUNK * (MOTION * CHUNK) + place % CHUNK
    single = spectral["phases"][p]["single"][bins] == 1
    re, im = (np.where(single, spectral["singles"][at], spectral["chunks"][at]) for at in (first, first + CHUNK))
    return np.where(places > 0, re**2 + im**2, 0.0)
