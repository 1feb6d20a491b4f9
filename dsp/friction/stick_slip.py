"""Dry friction between a driver and a point of ringing modes, over one sample without an event.

The driver moves at v_d along the surface, the point at v = v_free + int h(t - s) f(s) ds, with h the point's velocity
after a unit impulse. f (N) is the force on the object. Two branches: they stick, v = v_d and |f| <= mu_s N, or they
slip, f = mu(w) N along the slip w (law.py). Over a piece of time the force is linear, given at the two Radau nodes
(after a third, and at the end), where the branch's equation holds: order 3. A branch holds for a piece where both nodes
keep the bound (stick), or the slip at the end isn't negative.

A piece's loss, int f (v_d - v) dt, is found exactly. It may be negative only as far as losses before it, `tank`, pay
for it; else the force is held, with the mean velocity in the equation, which can't give energy back. So friction never
gives energy that it has not taken.

Times are in samples, velocities in m/s, forces in N.
"""

from ..contact.power_series import POWERS
from ..native.jit import kernel
from ..native.typed import View
from ..numerics.legendre import FINE
from .law import coefficient, slip_of
from .record import SPRINGS, Friction

THIRD = 1.0 / 3.0
_NEWTON_STEPS = 12
_SOLVED = 1e-11  # share of the velocities at hand by which an equation may fail
_FASTEST = 1e7  # m/s: Newton's method is lost beyond


@kernel
def begin_friction(friction: Friction, rate: float) -> None:
    """Begin to rub, slipping, at a rate in Hz; `respond_along` must follow."""
    friction.period = 1.0 / rate
    friction.branch = 1.0
    friction.tank = friction.lost = friction.driven = 0.0
    friction.events = friction.holds = friction.count = 0
    friction.tangential = friction.stored = friction.beside[0] = friction.beside[1] = 0.0
    for i in range(SPRINGS):
        friction.pull[i] = 0.0


@kernel
def respond_along(friction: Friction, response: View[float]) -> None:
    """Set how a point answers the driver, by its `velocity_response` (FINE): at the beginning, and when modes are
    retuned."""
    for n in range(FINE):
        total = 0.0
        for k in range(n, FINE):
            total += POWERS[n, k] * response[k]
        friction.impulse[n] = total * friction.period
        friction.held[n] = friction.impulse[n] / (n + 1)
        friction.rising[n] = friction.held[n] / (n + 2)
    fill_give(friction, 1.0)
    square = product = ramp = friction.whole_moment = 0.0
    for n in range(FINE):
        square += friction.held[n] / (n + 2)
        friction.whole_moment += friction.held[n] / (n + 3)
        product += friction.held[n] / (n + 3) + friction.rising[n] / (n + 3)
        ramp += friction.rising[n] / (n + 4)
    friction.form[0], friction.form[1], friction.form[2] = square, product, ramp
    friction.whole_mean = square
    for i in range(2):
        friction.whole_held[i] = friction.guess[i]
        for j in range(2):
            friction.whole[i, j] = friction.give[i, j]


@kernel
def fill_give(friction: Friction, eta: float) -> None:
    """Put the velocities at the nodes of a piece of `eta` samples for forces there into `give` and `guess`."""
    for i in range(2):
        t = eta * (THIRD if i == 0 else 1.0)
        held = rising = 0.0
        for n in range(FINE - 1, -1, -1):
            held = held * t + friction.held[n]
            rising = rising * t + friction.rising[n]
        held *= t
        rising *= t * t
        # f = f1 (3/2 - 3 t/(2 eta)) + f2 (3 t/(2 eta) - 1/2)
        friction.guess[i] = held
        friction.give[i, 0] = 1.5 * held - 1.5 / eta * rising
        friction.give[i, 1] = -0.5 * held + 1.5 / eta * rising


@kernel
def solve_piece(friction: Friction, eta: float) -> tuple[bool, float]:
    """Solve the branch's equation for a piece: whether it could be solved, and how well the branch holds (>= 0).

    The line of force is left in `start` and `slope`; `gap`, `load`, `give` and `guess` must be filled.
    """
    found = False
    margin = -1.0
    f = friction.force
    if friction.branch == 0.0:
        g, d = friction.give, friction.gap
        det = g[0, 0] * g[1, 1] - g[0, 1] * g[1, 0]
        f[0] = d[0] * g[1, 1] - g[0, 1] * d[1]
        f[1] = g[0, 0] * d[1] - g[1, 0] * d[0]
        if det > 0.0:
            f[0] /= det
            f[1] /= det
            found = True
            margin = friction.static * friction.load[0] - abs(f[0])
            margin = min(margin, friction.static * friction.load[1] - abs(f[1]))
    else:
        # Solve for the slip at both nodes: Newton's method on the branch that goes on from fast slips.
        sign, g = friction.branch, friction.give
        ms, md, vs = friction.static, friction.dynamic, friction.stribeck
        n1, n2 = friction.load[0], friction.load[1]
        d1, d2 = sign * friction.gap[0], sign * friction.gap[1]
        w1 = max(slip_of(d1, friction.guess[0], n1, ms, md, vs), 0.0)
        w2 = max(slip_of(d2, friction.guess[1], n2, ms, md, vs), 0.0)
        scale = abs(d1) + abs(d2) + 1e-3 * vs
        found = False
        f1 = f2 = det = 0.0
        for _ in range(_NEWTON_STEPS):
            mu1, slope1 = coefficient(w1, ms, md, vs)
            mu2, slope2 = coefficient(w2, ms, md, vs)
            f1, f2 = n1 * mu1, n2 * mu2
            rest1 = d1 - g[0, 0] * f1 - g[0, 1] * f2 - w1
            rest2 = d2 - g[1, 0] * f1 - g[1, 1] * f2 - w2
            a11, a12 = 1.0 + g[0, 0] * n1 * slope1, g[0, 1] * n2 * slope2
            a21, a22 = g[1, 0] * n1 * slope1, 1.0 + g[1, 1] * n2 * slope2
            det = a11 * a22 - a12 * a21
            if abs(rest1) + abs(rest2) < _SOLVED * scale:
                found = det > 0.0  # else it is the other side of the fold
                break
            if det == 0.0:
                break
            w1 += (rest1 * a22 - a12 * rest2) / det
            w2 += (a11 * rest2 - a21 * rest1) / det
            if not abs(w1) + abs(w2) < _FASTEST:
                break
        friction.force[0], friction.force[1] = sign * f1, sign * f2
        margin = w2
    friction.slope = 1.5 * (f[1] - f[0]) / eta
    friction.start = f[1] - friction.slope * eta
    return found, margin


@kernel
def move_beside(
    friction: Friction, third: float, end: float, mean: float, moment: float
) -> tuple[float, float, float, float]:
    """Return what `velocity.sense` found, with what the force beside friction does to it over the sample."""
    whole, start, slope = friction.whole, friction.beside[0], friction.beside[1]
    first, last, middle = start + THIRD * slope, start + slope, start + 0.5 * slope
    third += whole[0, 0] * first + whole[0, 1] * last
    end += whole[1, 0] * first + whole[1, 1] * last
    return third, end, mean + friction.whole_mean * middle, moment + friction.whole_moment * middle


@kernel
def step_whole(friction: Friction, third: float, end: float, mean: float, moment: float) -> bool:
    """Take the sample in one piece, if it has no event and its loss is right: whether it did.

    The arguments are what `velocity.sense` finds. The force is start + slope t.
    """
    drive, normal = friction.drive, friction.normal
    friction.gap[0] = drive[0] + (drive[1] - drive[0]) * THIRD - third
    friction.gap[1] = drive[1] - end
    friction.load[0] = normal[0] + (normal[1] - normal[0]) * THIRD
    friction.load[1] = normal[1]
    for i in range(2):
        friction.guess[i] = friction.whole_held[i]
        for j in range(2):
            friction.give[i, j] = friction.whole[i, j]
    found, margin = solve_piece(friction, 1.0)
    if not found or margin < 0.0:
        return False
    return pay(friction, mean, moment)


@kernel
def pay(friction: Friction, mean: float, moment: float) -> bool:
    """Book the whole sample's work and loss under the force start + slope t; false, and nothing, if it may not be."""
    f0, f1, drive, form = friction.start, friction.slope, friction.drive, friction.form
    work = f0 * mean + f1 * moment + f0 * f0 * form[0] + f0 * f1 * form[1] + f1 * f1 * form[2]
    driven = f0 * 0.5 * (drive[0] + drive[1]) + f1 * (drive[0] / 6.0 + drive[1] * THIRD)
    return book(friction, driven, work)


@kernel
def book(friction: Friction, driven: float, work: float) -> bool:
    """Book a piece's work (J a sample) of the driver, and on the object; false, and nothing, if the tank can't pay."""
    driven *= friction.period
    loss = driven - work * friction.period
    if loss + friction.tank < 0.0:
        return False
    friction.tank += loss
    friction.lost += loss
    friction.driven += driven
    return True
