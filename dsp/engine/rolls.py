"""How objects ring from contact to contact; those that bodies roll on are driven by these meanwhile.

A roll's force is known for the whole quantum, so its modes are driven several samples at a time.
"""

import math

from ..native.jit import kernel
from ..resonator.bank import LANES, RESPONSES, inject, ring, ring_driven
from ..resonator.simd import STRETCH
from .objects import place, weigh
from .state import QUANTUM


@kernel
def bring(state, index):
    """Have the objects that a rolling contact acts on know it, in this quantum."""
    contact = state.contacts[index]
    for side in range(2):
        body = contact.body[side]
        if body.slot >= 0:
            obj = state.objects[body.slot]
            body.next_rolled = obj.rolled
            obj.rolled = 2 * index + side
            obj.live = max(obj.live, body.modes)
            obj.driven = max(obj.driven, body.modes)


@kernel
def ring_on(state, obj, voice, start, stop):
    """Let an object ring from frame `start` to `stop` into its voice."""
    first = obj.first
    last = first + obj.live
    response = state.response[first // LANES * RESPONSES : last // LANES * RESPONSES]
    shape = state.shape[obj.table : obj.table + obj.rows * obj.size]
    frame = start
    while frame < stop:
        count = driven = rung = 0
        frames = stop - frame
        if obj.rolled >= 0:
            count, driven = _drivers(state, obj, frame)
            frames = STRETCH if frames >= STRETCH else 1
        middle = first + driven
        if frames == STRETCH and count > 0:
            rung = driven
        else:
            for j in range(count):
                driver = state.drivers[j]
                inject(
                    state.y1[first:middle], state.y2[first:middle], response, shape, obj.size, driver.row,
                    driver.weights, state.feeds[driver.feed, frame],
                )  # fmt: skip
        begin = first + rung
        ring(
            state.y1[begin:last], state.y2[begin:last], state.a1[begin:last], state.a2[begin:last],
            state.balance[begin:last], voice, frame, frame + frames,
        )  # fmt: skip
        if rung > 0:
            ring_driven(
                state.y1[first:middle], state.y2[first:middle], state.a1[first:middle], state.a2[first:middle],
                state.balance[first:middle], response, shape, obj.size, state.drivers, count, state.feeds, state.work,
                voice, frame,
            )  # fmt: skip
        frame += frames


@kernel
def _drivers(state, obj, frame):
    """List the rolls on an object as they are at a frame in `drivers`: how many, and how many modes they drive."""
    count = driven = 0
    entry = obj.rolled
    while entry >= 0:
        contact = state.contacts[entry // 2]
        body = contact.body[entry % 2]
        driver = state.drivers[count]
        driver.feed = contact.roll
        for i in range(4):
            driver.drift[i] = 0.0
        if entry % 2 == 0:
            place(body, _position(state, contact, frame), obj.rows)
            if contact.path > 0.0:
                weigh(driver.drift, _position(state, contact, frame + STRETCH) * (obj.rows - 1) - body.row)
                for i in range(4):
                    driver.drift[i] = contact.gain * (driver.drift[i] - body.weights[i]) / STRETCH
        driver.row = body.row
        for i in range(4):
            driver.weights[i] = contact.gain * body.weights[i]
        count += 1
        driven = body.modes
        entry = body.next_rolled
    return count, driven


@kernel
def _position(state, contact, frame):
    """Where a rolling body is along the object's strike path, on which it goes to and fro."""
    position = contact.position
    if contact.path > 0.0:
        rolled = (state.rolls[contact.roll].s - contact.rolled) * (frame / QUANTUM) + contact.rolled
        position += rolled / contact.path
    position -= 2.0 * math.floor(0.5 * position)
    return min(position, 2.0 - position)
