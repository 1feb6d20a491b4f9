"""An object as contacts see it: where it is touched, how its modes decay, how far it can swing."""

from ..native.jit import kernel
from ..resonator.bank import NYQUIST_SHARE, RESPONSES, Modes, Point, reach
from ..resonator.simd import LANES

_HAND = 200.0  # 1/s: decay that a hand adds at damp = 1
_HEAVIEST = 10.0  # of a mode's decay a sample, in nepers: it is gone in one, and more only costs digits


@kernel
def place(point, position, rows):
    """Rows and weights of the cubic through the mode shapes at a position in [0, 1]."""
    x = position * (rows - 1)
    row = min(max(int(x) - 1, 0), rows - 4)
    point.row = row
    weigh(point.weights, x - row)


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
    return min(
        state.bank.sigma[obj.first + i] / obj.settings.decay + _HAND * obj.settings.damp * obj.settings.damp,
        _HEAVIEST * state.rate,
    )


@kernel
def highest_of(state):
    """Frequency (Hz) above which modes are silent."""
    return NYQUIST_SHARE * 0.5 * state.rate


@kernel
def modes_of(state, obj, begin, end):
    """An object's modes from number `begin` up to `end`, both multiples of LANES."""
    bank = state.bank
    first, last = obj.first + begin, obj.first + end
    return Modes(
        bank.y1[first:last], bank.y2[first:last], bank.a1[first:last], bank.a2[first:last], bank.balance[first:last],
        bank.response[first // LANES * RESPONSES : last // LANES * RESPONSES],
    )  # fmt: skip


@kernel
def shapes_of(state, obj):
    """An object's table of mode shapes, flat."""
    return state.bank.shape[obj.table : obj.table + obj.rows * obj.size]


@kernel
def point_of(state, obj, point):
    """The point of an object that a record of POINT says."""
    return Point(shapes_of(state, obj), obj.size, point.row, point.weights)


@kernel
def reach_of(state, obj, point):
    """Bounds of the object's motion where it is touched: displacement (m) and velocity (m/s)."""
    return reach(modes_of(state, obj, 0, obj.live), point_of(state, obj, point), state.scratch.work)


@kernel
def shape_at(state, obj, point, i):
    """Mass-normalised shape of the object's mode i where the contact is, kg^-1/2."""
    at = obj.table + point.row * obj.size + i
    phi = 0.0
    for n in range(4):
        phi += point.weights[n] * state.bank.shape[at + n * obj.size]
    return phi
