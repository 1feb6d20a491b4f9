"""Blows of one step on the same bodies: each takes a part of what the body brings along.

The impulses J_i solve sum_j W_ij J_j = (1 + e_i) v_i, none of them negative, with W_ij how fast a unit impulse at blow
j opens blow i: the sum over the bodies that both have, with a sign by their sides, of n_i n_j/M + (r_i x n_i) I^-1 (r_j
x n_j). W_ii is 1/m of the effective mass. On the seam of two tiles, a ball leaves half of its momentum on each.
"""

from ....dsp.native.jit import kernel, noinline_kernel
from .blows import left_of
from .state import TOGETHER, Blow, State

_RIGID = 1e-3
"""Share by which a blow's mass may differ from that of rigid bodies; else it is taken alone, as one that is given by
its impulse is: that is its part."""
_ROUNDS = 60  # for each blow
_LEAST = 1e-6  # of its mass alone: what has less of a part is no blow, the others push it open


@noinline_kernel
def share_blows(state: State) -> None:
    """Give the blows of a step, TOGETHER at most, that are on the same bodies the masses of their parts; forget those
    that have none."""
    count = state.struck
    if count < 2 or count > TOGETHER or not _set_equations(state, count):
        return
    for i in range(count):
        state.part[i] = 0.0
    for _ in range(_ROUNDS * count):
        for i in range(count):
            missing = state.rate[i]
            for j in range(count):
                missing -= state.opens[i, j] * state.part[j]
            state.missing[i] = missing
        for i in range(count):
            state.part[i] = max(state.part[i] + state.missing[i] / (state.opens[i, i] * count), 0.0)
    state.struck = 0
    for i in range(count):
        mass = state.part[i] / state.rate[i]
        if mass > _LEAST * state.blows[i].mass:
            state.blows[state.struck] = state.blows[i]
            state.blows[state.struck].mass = mass
            state.struck += 1


@kernel
def _set_equations(state: State, count: int) -> bool:
    """Write down W and (1 + e) v; true if any two blows are on the same body."""
    shared = False
    for i in range(count):
        blow = state.blows[i]
        state.rate[i] = (1.0 + left_of(state, blow)) * blow.speed
        for j in range(count):
            state.opens[i, j] = _opens(state, blow, state.blows[j])
    for i in range(count):
        mass = state.blows[i].mass
        rigid = abs(state.opens[i, i] * mass - 1.0) < _RIGID and state.blows[i].impulse == 0.0
        for j in range(count):
            if i != j and not rigid:
                state.opens[i, j] = state.opens[j, i] = 0.0
        state.opens[i, i] = 1.0 / mass
    for i in range(count):
        for j in range(count):
            shared |= i != j and state.opens[i, j] != 0.0
    return shared


@kernel
def _opens(state: State, one: Blow, other: Blow) -> float:
    """Return the speed at which a unit impulse at another blow opens one, as rigid bodies (1/kg)."""
    total = 0.0
    for side in range(2):
        body = one.b if side == 1 else one.a
        for other_side in range(2):
            if body == (other.b if other_side == 1 else other.a) and state.lightness[body] > 0.0:
                total += (1.0 if side == other_side else -1.0) * _moves(state, body, one, other)
    return total


@kernel
def _moves(state: State, body: int, one: Blow, other: Blow) -> float:
    """Return n n'/M + (r x n) I^-1 (r' x n') of a body (1/kg), at the points of two blows."""
    total = 0.0
    for k in range(3):
        total += state.lightness[body] * one.normal[k] * other.normal[k]
        total += state.yielding[body, k] * _turns(state, body, one, k) * _turns(state, body, other, k)
    return total


@kernel
def _turns(state: State, body: int, blow: Blow, axis: int) -> float:
    """Return r x n of a blow (m), about an axis of a body."""
    total = 0.0
    for i in range(3):
        j, m = (i + 1) % 3, (i + 2) % 3
        arm_j, arm_m = blow.point[j] - state.position[body, j], blow.point[m] - state.position[body, m]
        total += state.turn[body, 3 * i + axis] * (arm_j * blow.normal[m] - arm_m * blow.normal[j])
    return total
