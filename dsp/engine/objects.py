"""An object as contacts see it: where it is touched, how its modes decay, how far it can swing."""

from ..native.jit import kernel
from ..resonator.bank import LANES, NYQUIST_SHARE, RESPONSES, reach

_HAND = 200.0  # 1/s: decay that a hand adds at damp = 1
_HEAVIEST = 10.0  # of a mode's decay a sample, in nepers: it is gone in one, and more only costs digits


@kernel
def place(body, position, rows):
    """Rows and weights of the cubic through the mode shapes at a position in [0, 1]."""
    x = position * (rows - 1)
    row = min(max(int(x) - 1, 0), rows - 4)
    body.row = row
    weigh(body.weights, x - row)


@kernel
def weigh(weights, x):
    """Weights of the cubic through four rows at x in rows from the first."""
    weights[0] = -(x - 1.0) * (x - 2.0) * (x - 3.0) / 6.0
    weights[1] = 0.5 * x * (x - 2.0) * (x - 3.0)
    weights[2] = -0.5 * x * (x - 1.0) * (x - 3.0)
    weights[3] = x * (x - 1.0) * (x - 2.0) / 6.0


@kernel
def sigma_of(state, obj, i):
    """Decay (1/s) of an object's mode i as it is now, with a hand on it."""
    return min(state.sigma[obj.first + i] / obj.decay + _HAND * obj.damp * obj.damp, _HEAVIEST * state.rate)


@kernel
def highest_of(state):
    """Frequency (Hz) above which modes are silent."""
    return NYQUIST_SHARE * 0.5 * state.rate


@kernel
def reach_of(state, obj, body):
    """What the object's ringing can't exceed where it is touched: displacement (m) and velocity (m/s)."""
    first = obj.first
    last = first + obj.live
    return reach(
        state.y1[first:last], state.y2[first:last], state.a1[first:last], state.a2[first:last],
        state.response[first // LANES * RESPONSES : last // LANES * RESPONSES],
        state.shape[obj.table : obj.table + obj.rows * obj.size], obj.size, body.row, body.weights, state.work,
    )  # fmt: skip


@kernel
def shape_at(state, obj, body, i):
    """Mass-normalised shape of the object's mode i where the contact is, kg^-1/2."""
    at = obj.table + body.row * obj.size + i
    phi = 0.0
    for n in range(4):
        phi += body.weights[n] * state.shape[at + n * obj.size]
    return phi
