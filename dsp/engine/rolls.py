"""How objects ring from contact to contact, driven meanwhile by the bodies that roll on them.

A roll's force is known for the whole quantum, so its modes are driven several samples at a time.
"""

import math

from ..native.jit import kernel
from ..resonator.bank import Drive, Point, inject, ring, ring_driven
from ..resonator.simd import STRETCH
from .objects import modes_of, place, shapes_of, weigh
from .state import QUANTUM


@kernel
def register_roll(state, index):
    """Put a rolling contact on the lists of the objects that it acts on, for this quantum."""
    contact = state.contacts[index]
    for side in range(2):
        point = contact.point[side]
        if point.slot >= 0:
            obj = state.objects[point.slot]
            point.next_roll = obj.rolls_head
            obj.rolls_head = 2 * index + side
            obj.live = max(obj.live, point.modes)
            obj.driven_modes = max(obj.driven_modes, point.modes)
            obj.driven_gain = max(obj.driven_gain, contact.now.gain)


@kernel
def ring_on(state, obj, voice, start, stop):
    """Let an object ring from frame `start` to `stop` into its voice."""
    scratch = state.scratch
    shape = shapes_of(state, obj)
    frame = start
    while frame < stop:
        count = driven = rung = 0
        frames = stop - frame
        if obj.rolls_head >= 0:
            count, driven = _drivers(state, obj, frame)
            frames = STRETCH if frames >= STRETCH else 1
        modes = modes_of(state, obj, 0, driven)
        if frames == STRETCH and count > 0:
            rung = driven
        else:
            for j in range(count):
                driver = scratch.drivers[j]
                where = Point(shape, obj.size, driver.row, driver.weights)
                inject(modes, where, scratch.feeds[driver.feed, frame])
        ring(modes_of(state, obj, rung, obj.live), voice, frame, frame + frames)
        if rung > 0:
            drive = Drive(scratch.drivers, count, scratch.feeds)
            ring_driven(modes, shape, obj.size, drive, scratch.work, voice, frame)
        frame += frames


@kernel
def _drivers(state, obj, frame):
    """List the rolls on an object as they are at a frame in `drivers`: how many, and how many modes they drive."""
    count = driven = 0
    entry = obj.rolls_head
    while entry >= 0:
        contact = state.contacts[entry // 2]
        point = contact.point[entry % 2]
        driver = state.scratch.drivers[count]
        driver.feed = contact.roll
        for i in range(4):
            driver.drift[i] = 0.0
        if entry % 2 == 0:
            place(point, position_of(contact, frame), obj.rows)
            if contact.travel > 0.0:
                weigh(driver.drift, position_of(contact, frame + STRETCH) * (obj.rows - 1) - point.row)
                for i in range(4):
                    driver.drift[i] = contact.now.gain * (driver.drift[i] - point.weights[i]) / STRETCH
        driver.row = point.row
        for i in range(4):
            driver.weights[i] = contact.now.gain * point.weights[i]
        count += 1
        driven = point.modes
        entry = point.next_roll
    return count, driven


@kernel
def position_of(contact, frame):
    """Where a rolling or sliding body is along the object's strike path, on which it goes to and fro."""
    position = contact.now.position
    if contact.travel > 0.0:
        position += (contact.rolls * (frame / QUANTUM) + contact.rolled) / contact.travel
    position -= 2.0 * math.floor(0.5 * position)
    return min(position, 2.0 - position)
