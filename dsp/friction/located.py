"""A sample of friction with events: stick to slip and back, each at its time.

The motion without the force is a polynomial over the sample, and the effect of a piece's force on the rest of the
sample is one, too (contact/coupled.py). The longest piece for which the branch holds is found by regula falsi and
bisection, then the branch changes. A branch that holds for no time at all is left at once.
"""

from ..contact.power_series import BINOMIAL, POWERS, QUADRATURE, QUADRATURE_WEIGHTS, value_at
from ..native.jit import kernel
from ..native.typed import View
from ..numerics.legendre import FINE
from .law import coefficient, slip_of
from .record import MOST_PIECES, Friction
from .stick_slip import THIRD, book, fill_give, solve_piece

_MOST_FLIPS = 6  # changes of branch that take no time, in a sample
_TRIALS = 40
_SHORTEST = 1e-5  # samples: a branch that doesn't hold for this time is left
_LOCATED = 1e-9  # samples: by how much an event's time may err
_FOLD = 0.1  # share of a piece by which its end may err where it ends because the equation has no root


@kernel
def step_located(friction: Friction, observed: View[float], moments: View[float]) -> None:
    """Take the sample in as many pieces as it needs; fill `moments` (FINE, N s) with the force's on the object.

    observed: FINE Legendre coefficients of v_free, by `velocity.observe_velocity`.
    """
    for n in range(FINE):
        total = 0.0
        for k in range(n, FINE):
            total += POWERS[n, k] * observed[k]
        friction.motion[n] = total
        moments[n] = 0.0
    for n in range(FINE):
        friction.motion[min(n + 1, FINE - 1)] += friction.beside[0] * friction.held[n]
        friction.motion[min(n + 2, FINE - 1)] += friction.beside[1] * friction.rising[n]
    at = 0.0
    flips = friction.count = 0
    for piece in range(MOST_PIECES + 1):
        left = 1.0 - at
        if left <= _LOCATED:
            break
        held = piece == MOST_PIECES or flips > _MOST_FLIPS
        eta, after = left, friction.branch
        if not held:
            eta, after = _longest(friction, at, left)
            if eta == 0.0:
                friction.branch = after
                friction.events += 1
                flips += 1
                continue
        for _ in range(2):
            if held:
                # Hold the force for a piece: the branch's equation in the mean velocity, which can't give energy
                # back.
                friction.holds += 1
                drive, normal = friction.drive, friction.normal
                middle = at + 0.5 * eta
                mean = give = 0.0
                for n in range(FINE - 1, -1, -1):
                    mean = mean * eta + friction.motion[n] / (n + 1)
                    give = give * eta + friction.held[n] / (n + 2)
                give *= eta
                slip = drive[0] + (drive[1] - drive[0]) * middle - mean
                hold_mean(friction, slip, give, normal[0] + (normal[1] - normal[0]) * middle)
                after = friction.branch
            # The work on the object over a piece from now, and the driver's, in J per sample.
            f0, f1, drive = friction.start, friction.slope, friction.drive
            free = own = 0.0
            for n in range(FINE - 1, -1, -1):
                free = free * eta + friction.motion[n] * (f0 / (n + 1) + f1 * eta / (n + 2))
                term = f0 * f0 * friction.held[n] / (n + 2)
                term += f0 * f1 * eta * (friction.held[n] + friction.rising[n]) / (n + 3)
                term += f1 * f1 * eta * eta * friction.rising[n] / (n + 4)
                own = own * eta + term
            rise = drive[1] - drive[0]
            here = drive[0] + rise * at
            driven = f0 * (here + 0.5 * rise * eta) + f1 * eta * (0.5 * here + rise * eta / 3.0)
            work, driven = eta * (free + own * eta), eta * driven
            if held:
                work = min(work, driven)  # equal up to rounding where they stick
            held = not book(friction, driven, work)
            if not held:
                break
        # Go on by a piece under its force: its part of the moments, and what becomes of the sample's rest.
        f0, f1 = friction.start, friction.slope
        for k in range(FINE):
            total = 0.0
            power = 1.0
            for j in range(k, FINE):
                # int_0^eta (eta - s)^(n-k) (f0 + f1 s) ds
                given = power * eta * (f0 + f1 * eta / (j - k + 2)) / (j - k + 1)
                total += BINOMIAL[j, k] * (friction.motion[j] * power + friction.impulse[j] * given)
                power *= eta
            friction.motion[k] = total
        for q in range(len(QUADRATURE)):
            t = eta * QUADRATURE[q]
            here = eta * friction.period * QUADRATURE_WEIGHTS[q] * (f0 + f1 * t)
            x = 2.0 * (at + t) - 1.0
            before, legendre_k = 0.0, here
            for k in range(FINE):
                moments[k] += legendre_k
                before, legendre_k = legendre_k, (2 * k + 1) / (k + 1) * x * legendre_k - k / (k + 1) * before
        line = friction.piece[friction.count]
        line[0], line[1], line[2], line[3], line[4] = at, eta, friction.start, friction.slope, friction.branch
        friction.count += 1
        friction.events += after != friction.branch
        friction.branch = after
        at += eta


@kernel
def hold_mean(friction: Friction, drive: float, give: float, normal: float) -> None:
    """Find the held force by the mean slip without friction (m/s), what 1 N takes of it, and the mean normal force: it
    never gives energy."""
    ms, md, vs = friction.static, friction.dynamic, friction.stribeck
    friction.slope = 0.0
    slip = -1.0
    if friction.branch != 0.0:
        slip = slip_of(friction.branch * drive, give, normal, ms, md, vs)
    if slip < 0.0 and abs(drive) <= ms * normal * give:
        friction.branch = 0.0
        friction.start = drive / give if give > 0.0 else 0.0
        return
    if slip < 0.0:
        friction.branch = 1.0 if drive > 0.0 else -1.0
        slip = max(slip_of(abs(drive), give, normal, ms, md, vs), 0.0)
    friction.start = friction.branch * normal * coefficient(slip, ms, md, vs)[0]


@kernel
def _longest(friction: Friction, at: float, left: float) -> tuple[float, float]:
    """Return the longest piece for which the branch holds, and the branch after it; the piece's force is kept.

    0 where it holds for no time.
    """
    low = below = above = start = slope = 0.0
    high = eta = left
    bounded = False  # whether `above` is the margin at `high`
    direction = 1.0  # in which it would slip
    for trial in range(_TRIALS):
        # Fill the equation at the nodes of a piece from now.
        drive, normal = friction.drive, friction.normal
        for i in range(2):
            t = eta * (THIRD if i == 0 else 1.0)
            friction.gap[i] = drive[0] + (drive[1] - drive[0]) * (at + t) - value_at(friction.motion, t)[0]
            friction.load[i] = normal[0] + (normal[1] - normal[0]) * (at + t)
        fill_give(friction, eta)
        found, margin = solve_piece(friction, eta)
        pull = 0.75 * friction.force[0] + 0.25 * friction.force[1]
        if found and margin >= 0.0:
            low, below, start, slope = eta, margin, friction.start, friction.slope
            if low == left:
                break
        else:
            high, above, bounded = eta, margin, found
            if low == 0.0 and eta <= min(_SHORTEST, left):
                direction = 1.0 if pull > 0.0 else -1.0
                break
        if pull != 0.0:
            direction = 1.0 if pull > 0.0 else -1.0
        if low > 0.0 and (high - low <= _LOCATED or (not bounded and high - low < _FOLD * low)):
            break
        if low == 0.0:
            eta = min(_SHORTEST, left)
            continue
        share = 0.5
        if bounded and trial % 3 != 2:
            share = min(max(below / (below - above), 0.02), 0.98)
        eta = low + share * (high - low)
    friction.start, friction.slope = start, slope
    after = friction.branch
    if low == 0.0 or (low < left and bounded):
        after = direction if after == 0.0 else 0.0
    return low, after
