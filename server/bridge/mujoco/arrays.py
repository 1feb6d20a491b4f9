"""A step's poses and contacts, gathered from where a simulator has them: arrays in its own memory, at fixed addresses.

They are laid out as MuJoCo's: a contact is a struct, its force is in a row of the constraints' forces.
"""

from typing import Annotated

from ....dsp.native.jit import kernel, noinline_kernel
from ....dsp.native.pointers import load_address, load_double, load_int32
from ....dsp.native.typed import Record, View, View2D, dtype_of
from ..tracking.state import BODIES, POINTS, State
from .soft import LEAST_IMPEDANCE, MOST_IMPEDANCE, Soft, elasticity_of


class Mechanism(Record):
    """Addresses of MuJoCo's data that decide over a blow."""

    jacobian: int  # addresses of mj_jac, 0: nothing is known; and of mj_solveM
    solve: int
    model: int  # of the model and its data
    data: int
    velocities: int  # how many the model has
    smooth: int  # where the address of their accelerations stands that are due to other forces
    step: int  # of the model's step (s)
    own: int  # 1: the restitution is its contact's
    reference: int  # where in a contact its solref and solimp are,
    impedance: int
    margin: int  # and the distance below which it pushes
    # Addresses of room for a point, for J's rows, for J and for M^-1 J'.
    point: int
    slope: int
    along: int
    answer: int
    soft: Soft


class Arrays(Record):
    """Addresses of a simulator's poses and contacts."""

    first: int  # the number of the first body that moves; the others follow
    bodies: int
    # For each of them the addresses of its place and of its rotation matrix, and its rows in the arrays below.
    place: Annotated[View[int], BODIES]
    turned: Annotated[View[int], BODIES]
    body: Annotated[View[int], BODIES]
    root: Annotated[View[int], BODIES]
    led: Annotated[View[int], BODIES]  # 1: it is moved by its pose, and `motions` say nothing of it
    # If `motions` are of the end of a step, as with steps of Runge and Kutta, those of the step before count.
    late: int  # 1: they are
    known: int  # 1: there was a step before
    before: Annotated[View2D[float], BODIES, 9]  # spin, velocity, and the point that it is of
    # Addresses of arrays of float64.
    motions: int  # by body: spin, and the velocity of the point `abouts`
    abouts: int  # by root: 3
    # Contacts: where the address of the first stands, how far apart they are, and where in each its parts are.
    contacts: int
    stride: int
    point: int
    normal: int
    distance: int
    geoms: int  # two of int32
    row: int  # int32: of the force; below 0 it is not in force
    dimensions: int  # int32
    friction: int
    forces: int  # where the address of the forces stands; 0: they are not known
    pyramids: int  # 1: a force is the sum of two rows for each tangent
    numbers: int  # address of int32: the number of each geom's body, -1: it has none
    mechanism: Mechanism


ARRAYS = dtype_of(Arrays)

_DOUBLE, _INT = 8, 4  # bytes


@noinline_kernel
def gather(state: State, arrays: Arrays, points: int, span: float) -> None:
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
def _take_before(state: State, arrays: Arrays, n: int) -> None:
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
def _lead(state: State, arrays: Arrays, n: int, span: float) -> None:
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
def _take_contact(state: State, arrays: Arrays, n: int, contact: int) -> None:
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
    state.force[n] = state.elastic[n] = 0.0
    if row >= 0 and arrays.mechanism.own == 1:
        find_soft(arrays.mechanism, contact)
        state.elastic[n] = elasticity_of(arrays.mechanism.soft)
    if row >= 0 and arrays.forces:
        forces = load_address(arrays.forces) + _DOUBLE * row
        rows = 1
        if arrays.pyramids:
            rows = max(1, 2 * (load_int32(contact + arrays.dimensions) - 1))
        for k in range(rows):
            state.force[n] += load_double(forces + _DOUBLE * k)


@kernel
def find_soft(mechanism: Mechanism, contact: int) -> None:
    """Find the spring and the damper of a contact at an address, as MuJoCo's options say them."""
    soft = mechanism.soft
    impedance, reference = contact + mechanism.impedance, contact + mechanism.reference
    soft.step = load_double(mechanism.step)
    soft.low, soft.high = load_double(impedance), load_double(impedance + _DOUBLE)
    soft.width, soft.middle = load_double(impedance + 2 * _DOUBLE), load_double(impedance + 3 * _DOUBLE)
    soft.power = load_double(impedance + 4 * _DOUBLE)
    most = min(max(soft.high, LEAST_IMPEDANCE), MOST_IMPEDANCE)
    first, second = load_double(reference), load_double(reference + _DOUBLE)
    if first > 0.0:
        time = max(first, 2.0 * soft.step)
        root = most * time * second
        soft.stiffness, soft.damping = 1.0 / (root * root), 2.0 / (most * time)
    else:
        soft.stiffness, soft.damping = -first / (most * most), -second / most
