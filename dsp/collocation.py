"""The scalar contact step: what is stepped through, instead of known in closed form, takes this step.

Over a step of h seconds the contact force is the quadratic through its values at three Gauss nodes, and the law
f = k x^a (1 + mu v), x > 0 (contact.py), holds at the nodes. Whatever moves linearly enters by a few numbers: the
compression that there would be without the force, and by how much the nodes' forces take it back. Along the exact flow
this is Gauss collocation of order 6; for a free mass it is the Runge-Kutta method of that name, A-stable. A contact
that sticks never pulls: where 1 + mu v < 0 the law gives 0.

Where the steps would have to become too fine, `discrete_gradient` holds the force for the step at
[V(x1) - V(x0)]/(x1 - x0) max(0, 1 + mu (x1 - x0)/h), with V = k x^(a+1)/(a+1): the work is at least the change of V, so
energy can't grow, whatever the step, and the root is unique.

`press` uses both on the simplest motion: a mass in contact under a constant force (weight, a hand, nothing).
"""

import math

import numpy as np
from numba import njit
from numpy.polynomial import legendre
from numpy.typing import NDArray

from .contact import checked
from .jit import kernel

NODES = 3

GAUSS = (legendre.leggauss(NODES)[0] + 1.0) / 2.0
"""The nodes, in [0, 1] of a step."""

CARDINAL = np.linalg.inv(
    np.vander(GAUSS, increasing=True)
)  # power series of the polynomials 1 at one node, 0 at others

WEIGHTS = np.array([CARDINAL[:, j] @ (1.0 / np.arange(1, NODES + 1)) for j in range(NODES)])
"""Integrals over the step."""

INTEGRAL = np.array([[c ** np.arange(1, 4) / np.arange(1, 4) @ CARDINAL[:, j] for j in range(NODES)] for c in GAUSS])
"""Integrals from the step's beginning up to a node (row): the Gauss method's matrix."""

_TWICE = INTEGRAL @ INTEGRAL

LAST = CARDINAL.sum(axis=0)
"""The quadratic's value at the step's end."""

_SOLVED = 1e-11  # relative change of the forces that ends Newton's method, whose error is then below its square
_NEWTON_STEPS = 16
_GRADIENT_STEPS = 200

STEP = np.dtype(
    [
        # What is given: without the force, and what the nodes' forces (N) take off.
        ("free_x", np.float64, NODES),  # m
        ("free_v", np.float64, NODES),  # m/s
        ("give_x", np.float64, (NODES, NODES)),  # m/N
        ("give_v", np.float64, (NODES, NODES)),  # m/(s N)
        # What is found; `f` also says where to start.
        ("f", np.float64, NODES),  # N
        ("x", np.float64, NODES),
        ("v", np.float64, NODES),
        ("linear", np.float64, (NODES, NODES + 1)),
    ],
    align=True,
)
"""One step: x_i = free_x_i - sum_j give_x_ij f_j, v_i = free_v_i - sum_j give_v_ij f_j."""


@kernel
def law(x, v, k, mu, a):
    """Contact force in N: (1), never negative."""
    return k * x**a * max(1.0 + mu * v, 0.0) if x > 0.0 else 0.0


@kernel
def elastic(x, k, a):
    """Elastic energy V(x) in J: (13)."""
    return k * x ** (a + 1.0) / (a + 1.0) if x > 0.0 else 0.0


@kernel
def solve(step, k, mu, a, negligible):
    """Forces at the nodes by Newton's method from `step.f`, then from 0, where the law's convexity helps it.

    Leaves the nodes' f, x, v in the step. Changes of a force below `negligible` (N) don't matter; that is needed where
    1 + mu v is down to rounding. False if it doesn't converge: the step is too long.
    """
    for _ in range(2):
        for _ in range(_NEWTON_STEPS):
            change = 0.0
            size = 0.0
            for i in range(NODES):
                x = step.free_x[i]
                v = step.free_v[i]
                for j in range(NODES):
                    x -= step.give_x[i, j] * step.f[j]
                    v -= step.give_v[i, j] * step.f[j]
                step.x[i] = x
                step.v[i] = v
                stiffness = damping = force = 0.0
                slack = 1.0 + mu * v
                if x > 0.0 and slack > 0.0:
                    power = k * x ** (a - 1.0)
                    force = power * x * slack
                    stiffness = a * power * slack
                    damping = mu * power * x
                for j in range(NODES):
                    step.linear[i, j] = stiffness * step.give_x[i, j] + damping * step.give_v[i, j]
                step.linear[i, i] += 1.0
                step.linear[i, NODES] = force - step.f[i]
            _eliminate(step.linear)
            for i in range(NODES):
                step.f[i] += step.linear[i, NODES]
                change = max(change, abs(step.linear[i, NODES]))
                size = max(size, abs(step.f[i]))
            if change <= _SOLVED * size + negligible:
                return True
        for i in range(NODES):
            step.f[i] = 0.0
    return False


@kernel
def _eliminate(linear):
    """Solve the linear equations; the solution takes the right side's place. Their diagonal is safely positive."""
    for i in range(NODES):
        reciprocal = 1.0 / linear[i, i]
        for row in range(i + 1, NODES):
            factor = linear[row, i] * reciprocal
            for j in range(i + 1, NODES + 1):
                linear[row, j] -= factor * linear[i, j]
    for i in range(NODES - 1, -1, -1):
        for j in range(i + 1, NODES):
            linear[i, NODES] -= linear[i, j] * linear[j, NODES]
        linear[i, NODES] /= linear[i, i]


@kernel
def allowance(gained, scale):
    """Energy (J) that a step may gain, in a contact of about `scale`, after `gained`: half of what is left to gain."""
    return max(0.5 * (_GROWTH * scale - gained), _LEAST_GROWTH * scale)


@kernel
def extrapolate(step, ratio):
    """Let the next step's Newton start where the last step's force leads; the next is `ratio` times as long."""
    f0, f1, f2 = step.f[0], step.f[1], step.f[2]
    for i in range(NODES):
        theta = 1.0 + ratio * GAUSS[i]
        value = 0.0
        for power in range(NODES - 1, -1, -1):
            value = value * theta + CARDINAL[power, 0] * f0 + CARDINAL[power, 1] * f1 + CARDINAL[power, 2] * f2
        step.f[i] = max(value, 0.0)


@kernel
def end_of(f):
    """The quadratic through the nodes' values at the step's end."""
    return LAST[0] * f[0] + LAST[1] * f[1] + LAST[2] * f[2]


@kernel
def mean_of(f):
    """The quadratic's mean over the step."""
    return WEIGHTS[0] * f[0] + WEIGHTS[1] * f[1] + WEIGHTS[2] * f[2]


@kernel
def discrete_gradient(x, free, give, h, k, mu, a):
    """The change of x over a step of h seconds, and the force that is held for it.

    Without the force x would change by `free` (m); a held one takes off `give` (m/N) > 0. The change that the law
    allows is the root of an increasing convex function: Newton's method comes down to it from above.
    """
    high = free
    low = free
    if x > 0.0:
        low = min(free, -x) - give * k * x**a / (a + 1.0)
    if x >= 0.0 and free > 0.0:
        # f is at least k x1^a/(a+1) where x1 > x, and takes off no more than `free`.
        high = min(high, max(((a + 1.0) * free / (give * k)) ** (1.0 / a) - x, 0.0))
    low = min(low, -abs(x))
    change = high
    for _ in range(_GRADIENT_STEPS):
        f, slope = _held(x, change, h, k, mu, a)
        residual = change - free + give * f
        if residual > 0.0:
            high = change
        else:
            low = change
        new = change - residual / (1.0 + give * slope)
        if not low < new < high:
            new = 0.5 * (low + high)
        step = abs(new - change)
        change = new
        if step <= 1e-15 * (abs(new) + abs(x)):
            break
    # The force is taken from the law, not from what is left of `free`: nothing cancels.
    return change, _held(x, change, h, k, mu, a)[0]


@kernel
def _held(x, change, h, k, mu, a):
    """[V(x + change) - V(x)]/change max(0, 1 + mu change/h), and its slope over the change."""
    slack = 1.0 + mu * change / h
    end = x + change
    if slack <= 0.0 or (x <= 0.0 and end <= 0.0):
        return 0.0, 0.0
    if min(x, end) > 0.0 and abs(change) < 1e-2 * x:
        # Nearly equal energies would cancel; their difference is the mean of k x^a.
        mean = slope = 0.0
        for j in range(NODES):
            power = (x + GAUSS[j] * change) ** (a - 1.0)
            mean += WEIGHTS[j] * k * power * (x + GAUSS[j] * change)
            slope += WEIGHTS[j] * GAUSS[j] * k * a * power
    else:
        mean = (elastic(end, k, a) - elastic(x, k, a)) / change
        slope = ((k * end**a if end > 0.0 else 0.0) - mean) / change
    return mean * slack, slope * slack + mean * mu / h


PRESSED = np.dtype(
    [
        ("step", STEP),
        ("force", np.float64, NODES),  # N, at GAUSS of the last step
        ("x", np.float64),  # compression, m
        ("v", np.float64),  # its rate, m/s
        ("m", np.float64),  # kg
        ("k", np.float64),
        ("mu", np.float64),
        ("a", np.float64),
        ("push", np.float64),  # constant force into the contact, N
        ("tolerance", np.float64),
        ("energy", np.float64),  # J: the least so far, which is not exceeded
        ("next", np.float64),  # s: the step to try
        ("steps", np.int64),
        ("gradients", np.int64),  # steps that had to be held ones
    ],
    align=True,
)
"""A mass in contact under a constant force: m dv/dt = push - f(x, v)."""

EXACT = 1e-5
"""Tolerance of `press` for release velocities and times within 3e-7 of their exact values."""

_GROWTH = 1e-8  # share of its energy that a contact may gain in all
_LEAST_GROWTH = 1e-15  # what rounding makes of it in a step
_TRIALS = 60
_FINEST = 2.0**-20  # of the step tried first: where it comes to this, the force is held
_ROUNDING = 1e-14  # share of the momentum at hand that no force is asked for
_CLOSED = 1e-13  # of a step's greatest compression: as far as rounding lets one see the release


@kernel
def begin_pressed(contact, x, v, m, k, mu, a, push, tolerance):
    """A mass m (kg) under a force of `push` (N), at compression x >= 0 (m) and its rate v (m/s)."""
    contact.m = m
    contact.k = k
    contact.mu = mu
    contact.a = a
    contact.tolerance = tolerance
    contact.steps = 0
    contact.gradients = 0
    place(contact, x, v, push)


@kernel
def place(contact, x, v, push):
    """Put the mass elsewhere, give it another velocity, or push it otherwise."""
    m, k, mu, a = contact.m, contact.k, contact.mu, contact.a
    contact.x = x
    contact.v = v
    contact.push = push
    contact.energy = _energy(contact, x, v)
    for i in range(NODES):
        contact.step.f[i] = law(x, v, k, mu, a)
    # A twentieth of the contact's natural time, or of the time in which strong dissipation slows it.
    speed = _speed(contact, x, v)
    if speed > 0.0:
        time = (m / k / speed ** (a - 1.0)) ** (1.0 / (a + 1.0))
        contact.next = 0.05 * time / max(1.0, mu * speed) ** (1.0 / (a + 1.0))
    else:
        contact.next = 0.05 * (m / k * (m / max(abs(push), 1e-300)) ** (a - 1.0)) ** (0.5 / a)


@kernel
def _speed(contact, x, v):
    """The speed that kinetic and elastic energy amount to."""
    return math.sqrt(v * v + 2.0 * elastic(x, contact.k, contact.a) / contact.m)


@kernel
def _energy(contact, x, v):
    return 0.5 * contact.m * v * v + elastic(x, contact.k, contact.a) - contact.push * x


@kernel
def captured(x, v, m, k, a, push):
    """True if the mass can never leave while it is pushed like this.

    E = m v^2/2 + k x^(a+1)/(a+1) - push x does not grow in contact, and isn't negative at x = 0.
    """
    return x > 0.0 and 0.5 * m * v * v + elastic(x, k, a) < push * x


@kernel
def press(contact, longest):
    """One step of a pressed contact; returns its length in s, at most `longest` > 0.

    The force over it is the quadratic through contact.force. When x comes to 0 the step ends there: x is 0 exactly,
    v <= 0, and the mass is free. A step is accepted where |f_end - f(x, v)| h, with f_end the quadratic's value at the
    end, is below tolerance times the momentum at hand, and the energy below the least so far, but for _GROWTH.
    """
    if contact.x <= 0.0 and (contact.v < 0.0 or (contact.v == 0.0 and contact.push <= 0.0)):
        contact.x = 0.0
        return 0.0
    contact.steps += 1
    h = min(contact.next, longest)
    finest = _FINEST * h
    closing = False
    for _ in range(_TRIALS):
        if h < finest:
            break
        solved, x, v = _collocate(contact, h)
        if not solved:
            h *= 0.25
            closing = False
            continue
        whole, closing = until_release(contact.step, x, v, h, closing)
        if whole != h and whole <= longest:
            h = whole
            continue
        ratio, sound = _judge(contact, h, x, v)
        if sound:
            if not closing:
                contact.next = max(ratio * h, contact.next if h == longest else 0.0)
            for i in range(NODES):
                contact.force[i] = contact.step.f[i]
            extrapolate(contact.step, contact.next / h)
            _move(contact, 0.0 if closing else x, v)
            return h
        h *= min(ratio, 0.7)
        closing = False
    return _hold(contact, max(h, finest))


@kernel
def _collocate(contact, h):
    """Try a step: whether it is solved, and x and v at its end."""
    step = contact.step
    push, lightness = contact.push / contact.m, h / contact.m
    for i in range(NODES):
        t = h * GAUSS[i]
        step.free_x[i] = contact.x + t * (contact.v + 0.5 * t * push)
        step.free_v[i] = contact.v + t * push
        for j in range(NODES):
            step.give_v[i, j] = lightness * INTEGRAL[i, j]
            step.give_x[i, j] = h * lightness * _TWICE[i, j]
    negligible = _ROUNDING * contact.m * _speed(contact, contact.x, contact.v) / h
    solved = solve(step, contact.k, contact.mu, contact.a, negligible)
    v = contact.v + h * push
    x = contact.x + h * (contact.v + 0.5 * h * push)
    for j in range(NODES):
        v -= lightness * WEIGHTS[j] * step.f[j]
        x -= h * lightness * WEIGHTS[j] * (1.0 - GAUSS[j]) * step.f[j]
    return solved, x, v


@kernel
def until_release(step, x, v, h, closing):
    """The length of the step that ends where x comes to 0, if it does; and whether that is what is being sought."""
    for i in range(NODES):
        if step.x[i] < 0.0:
            return h * GAUSS[i], False
    near = _CLOSED * max(step.x[0], step.x[1], step.x[2])
    if x < -near or (closing and x > near):
        return (h - x / v, True) if v < 0.0 else (h * GAUSS[NODES - 1], False)
    return h, closing or (x <= 0.0 and v <= 0.0)


@kernel
def _judge(contact, h, x, v):
    """What to multiply the step with for the tolerance, and whether it will do as it is."""
    speed = max(_speed(contact, x, v), _speed(contact, contact.x, contact.v))
    rest = abs(end_of(contact.step.f) - law(x, v, contact.k, contact.mu, contact.a)) * h
    wanted = contact.tolerance * contact.m * speed
    scale = 0.5 * contact.m * speed * speed + abs(contact.push) * max(x, contact.x)
    before = _energy(contact, contact.x, contact.v)
    gain = _energy(contact, x, v) - before
    # The rest grows with h^4 where the force is smooth, and less steeply where the contact begins.
    ratio = min(max(0.8 * (wanted / max(rest, 1e-300)) ** 0.25, 0.2), 2.0)
    return ratio, rest <= wanted and gain <= allowance(before - contact.energy, scale)


@kernel
def _hold(contact, h):
    """A step with its force held, which can't gain energy; returns its length."""
    push = contact.push / contact.m
    free = h * (contact.v + 0.5 * h * push)
    change, force = discrete_gradient(contact.x, free, 0.5 * h * h / contact.m, h, contact.k, contact.mu, contact.a)
    contact.gradients += 1
    contact.next = 2.0 * h
    for i in range(NODES):
        contact.force[i] = contact.step.f[i] = force
    v = contact.v + h * (push - force / contact.m)
    _move(contact, max(contact.x + change, 0.0), v)
    return h


@kernel
def _move(contact, x, v):
    contact.x = x
    contact.v = v
    contact.energy = min(contact.energy, _energy(contact, x, v))


@njit(error_model="numpy")
def _pressed(contact, seconds, path):
    t = 0.0
    path[0, 0], path[0, 1], path[0, 2] = t, contact.x, contact.v
    for n in range(1, len(path)):
        t += press(contact, seconds - t)
        path[n, 0], path[n, 1], path[n, 2] = t, contact.x, contact.v
        if contact.x <= 0.0 or t >= seconds:
            return n + 1
    return len(path)


def pressed(
    v_in: float, m: float, k: float, mu: float, a: float, push: float, seconds: float, tolerance: float = EXACT
) -> NDArray:
    """Motion of a mass that meets a wall at v_in under a constant force, until it leaves or for some seconds.

    v_in (m/s) >= 0, m (kg), k (N/m^a) > 0, mu (s/m) >= 0, a >= 1, push (N) into the wall. Rows of time (s),
    compression (m) and its rate (m/s), (steps + 1, 3) float64. ValueError names what is out of range.
    """
    law = [
        float(checked(name, value, low, strict=strict))
        for name, value, low, strict in (
            ("v_in", v_in, 0.0, False), ("m", m, 0.0, True), ("k", k, 0.0, True), ("mu", mu, 0.0, False),
            ("a", a, 1.0, False), ("push", push, -np.inf, True),
        )
    ]  # fmt: skip
    seconds, tolerance = float(checked("seconds", seconds, 0.0)), float(checked("tolerance", tolerance, 0.0, 1.0))
    contact = np.zeros(1, PRESSED)[0]
    _begin_pressed(contact, 0.0, *law, tolerance)
    path = np.empty((_MOST_STEPS + 1, 3))
    return path[: _pressed(contact, seconds, path)].copy()


_MOST_STEPS = 1_000_000


@njit(error_model="numpy")
def _begin_pressed(contact, x, v, m, k, mu, a, push, tolerance):
    begin_pressed(contact, x, v, m, k, mu, a, push, tolerance)
