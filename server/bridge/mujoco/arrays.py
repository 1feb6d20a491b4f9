"""A step's poses and contacts, gathered from where a simulator has them: arrays in its own memory, at fixed addresses.

They are laid out as MuJoCo's: a contact is a struct, its force is in a row of the constraints' forces.
"""

import numpy as np

from ....dsp.native.jit import kernel, noinline_kernel
from ....dsp.native.pointers import load_address, load_double, load_int32
from ..tracking.state import BODIES, POINTS
from .mechanism import MECHANISM

ARRAYS = np.dtype(
    [
        ("first", np.int64),  # the number of the first body that moves; the others follow
        ("bodies", np.int64),
        # For each of them the addresses of its place and of its rotation matrix, and its rows in the arrays below.
        ("place", np.int64, BODIES),
        ("turned", np.int64, BODIES),
        ("body", np.int64, BODIES),
        ("root", np.int64, BODIES),
        ("led", np.int64, BODIES),  # 1: it is moved by its pose, and `motions` say nothing of it
        # If `motions` are of the end of a step, as with steps of Runge and Kutta, those of the step before count.
        ("late", np.int64),  # 1: they are
        ("known", np.int64),  # 1: there was a step before
        ("before", np.float64, (BODIES, 9)),  # spin, velocity, and the point that it is of
        # Addresses of arrays of float64.
        ("motions", np.int64),  # by body: spin, and the velocity of the point `abouts`
        ("abouts", np.int64),  # by root: 3
        # Contacts: where the address of the first stands, how far apart they are, and where in each its parts are.
        ("contacts", np.int64),
        ("stride", np.int64),
        ("point", np.int64),
        ("normal", np.int64),
        ("distance", np.int64),
        ("geoms", np.int64),  # two of int32
        ("row", np.int64),  # int32: of the force; below 0 it is not in force
        ("dimensions", np.int64),  # int32
        ("friction", np.int64),
        ("forces", np.int64),  # where the address of the forces stands; 0: they are not known
        ("pyramids", np.int64),  # 1: a force is the sum of two rows for each tangent
        ("numbers", np.int64),  # address of int32: the number of each geom's body, -1: it has none
        ("mechanism", MECHANISM),
    ],
    align=True,
)
"""Addresses of a simulator's poses and contacts."""

_DOUBLE, _INT = 8, 4  # bytes


@noinline_kernel
def gather(state, arrays, points, span):
    """Copy poses and so many contacts into the tracker's memory, a time (s) after the last step's."""
    for n in range(arrays.bodies):
        if arrays.led[n] == 1:
            _lead(state, arrays, n, span)
            continue
        to = arrays.first + n
        place, turn = arrays.place[n], arrays.turned[n]
        motion = arrays.motions + 6 * _DOUBLE * arrays.body[n]
        about = arrays.abouts + 3 * _DOUBLE * arrays.root[n]
        for k in range(3):
            state.position[to, k] = load_double(place + _DOUBLE * k)
            state.spin[to, k] = load_double(motion + _DOUBLE * k)
            state.velocity[to, k] = load_double(motion + _DOUBLE * (3 + k))
            state.about[to, k] = load_double(about + _DOUBLE * k)
        for k in range(9):
            state.turn[to, k] = load_double(turn + _DOUBLE * k)
        if arrays.late == 1:
            _take_before(state, arrays, n)
    arrays.known = 1
    if 0 < points <= POINTS:
        first = load_address(arrays.contacts)
        for n in range(points):
            _take_contact(state, arrays, n, first + arrays.stride * n)


@noinline_kernel
def _take_before(state, arrays, n):
    """Give a body the motion that it had a step before, and keep that of this one."""
    to = arrays.first + n
    before = arrays.before[n]
    for k in range(3):
        spin, velocity, about = state.spin[to, k], state.velocity[to, k], state.about[to, k]
        if arrays.known == 1:
            state.spin[to, k], state.velocity[to, k] = before[k], before[3 + k]
            state.about[to, k] = before[6 + k]
        before[k], before[3 + k], before[6 + k] = spin, velocity, about


@noinline_kernel
def _lead(state, arrays, n, span):
    """Copy the pose of a body that is moved by it: its motion is what has changed. One that jumps has none."""
    to = arrays.first + n
    place, turn = arrays.place[n], arrays.turned[n]
    square = 0.0
    for k in range(3):
        way = load_double(place + _DOUBLE * k) - state.position[to, k]
        square += way * way
        state.velocity[to, k] = way / span
        i, j = (k + 1) % 3, (k + 2) % 3
        state.spin[to, k] = 0.0
        for m in range(3):  # of the turn from the last axes to those now, (R R' - R'R)/2
            here_i, here_j = load_double(turn + _DOUBLE * (3 * i + m)), load_double(turn + _DOUBLE * (3 * j + m))
            before_i, before_j = state.turn[to, 3 * i + m], state.turn[to, 3 * j + m]
            state.spin[to, k] += 0.5 * (here_j * before_i - here_i * before_j) / span
    jumps = not square <= state.reach[to] * state.reach[to] or state.steps == 0
    for k in range(3):
        if jumps:
            state.velocity[to, k] = state.spin[to, k] = 0.0
        state.position[to, k] = state.about[to, k] = load_double(place + _DOUBLE * k)
    for k in range(9):
        state.turn[to, k] = load_double(turn + _DOUBLE * k)


@kernel
def _take_contact(state, arrays, n, contact):
    """Copy a contact at an address; one that is not in force is as if it did not touch."""
    row = load_int32(contact + arrays.row)
    for side in range(2):
        geom = load_int32(contact + arrays.geoms + _INT * side)
        state.pair[n, side] = load_int32(arrays.numbers + _INT * max(geom, 0))
        if geom < 0 or state.pair[n, side] < 0:
            row = -1
    if row < 0:
        state.pair[n, 0] = state.pair[n, 1] = 0
    for k in range(3):
        state.point[n, k] = load_double(contact + arrays.point + _DOUBLE * k)
        state.normal[n, k] = load_double(contact + arrays.normal + _DOUBLE * k)
    state.depth[n] = -load_double(contact + arrays.distance)
    state.friction[n] = load_double(contact + arrays.friction)
    state.force[n] = 0.0
    if row >= 0 and arrays.forces:
        forces = load_address(arrays.forces) + _DOUBLE * row
        rows = 1
        if arrays.pyramids:
            rows = max(1, 2 * (load_int32(contact + arrays.dimensions) - 1))
        for k in range(rows):
            state.force[n] += load_double(forces + _DOUBLE * k)
