"""The force pulse of a contact over time, and its Legendre moments over each sample, as the engine computes them.

In the logarithmic velocity U = ln(1 + w u)/w the contact law reads dt = -dU/y^a (t in L/v_in, y = x/L): no
cancellation and no boundary layer is left at any w. U falls from U_in = ln(1 + w)/w through 0 (greatest
compression) to U_in - (1 + E) (release). Each of the two phases is followed from its contact end by zeta, with
|U| = span (1 - zeta^(a+1)); there y ~ zeta, so t(zeta) = span (a+1) int (zeta/y)^a dzeta has a smooth integrand,
and y is the closed form x(v): equation (9) of Papetti, Avanzini, Rocchesso 2011 (see law.py), in a variable that suits
quadrature. Twelve Gauss nodes then give the force within 2e-6 of its peak for a <= 1.5 and w <= 5, 7e-5 for a <= 1.5,
3.6e-4 for a <= 4 (the worst at w = 23), 7.5e-4 for a <= 6 (at w = 15), and the duration within 2e-9, 1e-5, 2.6e-5,
4e-5, at any w up to 1e6. pulse.py takes as many nodes as double precision needs.

A sampled force would alias and lose momentum. Modes need neither: over a sample they answer the moments
M_k = int f(t) P_k dt (N s) of the force with the Legendre polynomials P_k of that sample. The zeroth
are exact, the others as heard by a mode at 0.95 of the Nyquist frequency within 1e-5 of the contact's momentum
(-100 dB), and those from MOMENTS on weigh -98 dB there; both fall with the mode's frequency.

Eight nodes are computed at once (numerics/elementary.py): LLVM turns all loops over nodes into SIMD.
"""

import math

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from ..native.jit import kernel, simd_kernel
from ..native.typed import View
from ..numerics.elementary import exp, expm1, log
from ..numerics.legendre import FALL, MOMENTS, RISE
from ..numerics.settled import same_everywhere
from .law import potential, restitution_of, time_scale
from .pulse_record import DEGREE, NODES, ROOM, Pulse

_NODES, _WEIGHTS = map(same_everywhere, ("LONG_NODES", "LONG_WEIGHTS"), legendre.leggauss(DEGREE))
_PIECE_NODES, _PIECE_WEIGHTS = map(same_everywhere, ("PIECE_NODES", "PIECE_WEIGHTS"), legendre.leggauss(NODES))
_WIDE = 0.4  # of zeta: a piece that is as long is taken in two halves, as are contacts of some samples
_LOG_NODES = np.tile(same_everywhere("LOG_NODES", np.log(0.5 + 0.5 * _NODES)), 2)  # of both phases

_PHASE_NODES = 0.5 + 0.5 * _PIECE_NODES  # zeta, of a whole phase
_PHASE_LOGS = same_everywhere("PHASE_LOGS", np.log(_PHASE_NODES))


def _antiderivative() -> NDArray[np.float64]:
    """Return the matrix from a function's values at _NODES to the power series (in x = 2 zeta - 1) of its integral over
    zeta."""
    degrees = np.arange(DEGREE)
    # Legendre coefficients of the polynomials that are 1 at one node and 0 at the others.
    cardinal = (degrees + 0.5)[:, None] * legendre.legvander(_NODES, DEGREE - 1).T * _WEIGHTS
    integrals = legendre.legint(cardinal, lbnd=-1) / 2
    return np.column_stack([legendre.leg2poly(column) for column in integrals.T])


_ANTIDERIVATIVE = np.zeros((DEGREE, ROOM))
_ANTIDERIVATIVE[:, : DEGREE + 1] = same_everywhere("ANTIDERIVATIVE", _antiderivative().T)

_LEAST = 1e-300  # what a logarithm is taken of, at least


@kernel
def velocity_of(w: float, U: float) -> float:
    """Return (exp(w U) - 1)/w: the velocity whose logarithmic velocity is U."""
    z = w * U
    return U if z == 0.0 else math.expm1(z) / w


@kernel
def slowness_at(Z: float, span: float, w: float, a: float) -> float:
    """Return dt/dzeta of a phase, at Z = zeta^(a+1)."""
    u = velocity_of(w, span * (1.0 - Z))
    g = potential(velocity_of(w, span * Z), w * span * Z, u, w)
    rate: float = (Z / ((a + 1.0) * g)) ** (a / (a + 1.0))
    return span * (a + 1.0) * rate


@kernel
def spans_of(w: float, e: float) -> tuple[float, float]:
    """Return |U| at the beginning and at the release."""
    compressing = math.log1p(w) / w if w > 0.0 else 1.0
    return compressing, 1.0 + e - compressing


@kernel
def begin_pulse(pulse: Pulse, v_in: float, m: float, k: float, mu: float, a: float, rate: float) -> None:
    """Set up the pulse of a contact at v_in; times in samples of 1/rate s."""
    w = mu * v_in if mu * v_in > 1e-100 else 0.0
    e = restitution_of(w)
    unit = time_scale(v_in, m, k, a) * rate
    pulse.span[0], pulse.span[1] = spans_of(w, e)
    pulse.w[0] = w
    pulse.w[1] = -w
    pulse.exponent = a
    pulse.momentum = m * v_in
    pulse.restitution = e
    _find_slowness(pulse, unit)
    _integrate(pulse)
    for phase in range(2):
        pulse.phase_time[phase] = _time(pulse.time_series[phase], 1.0)
    pulse.duration = pulse.phase_time[0] + pulse.phase_time[1]
    pulse.time = 0.0
    pulse.zeta = 0.0
    pulse.u = 1.0


@simd_kernel
def _find_slowness(pulse: Pulse, unit: float) -> None:
    """Put `slowness_at` times `unit` at all nodes into `slowness`."""
    a, compressing, releasing = pulse.exponent, pulse.span[0], pulse.span[1]
    dissipation, slowness = pulse.w[0], pulse.slowness
    power, share = a + 1.0, a / (a + 1.0)
    for i in range(2 * DEGREE):
        w = dissipation if i < DEGREE else -dissipation
        span = compressing if i < DEGREE else releasing
        Z = exp(power * _LOG_NODES[i])
        along, left = w * span * Z, w * span * (1.0 - Z)
        distance = span * Z if w == 0.0 else expm1(along) / w
        u = span * (1.0 - Z) if w == 0.0 else expm1(left) / w
        g = max(potential(distance, along, u, w), _LEAST)
        slowness[i] = unit * span * power * exp(a * _LOG_NODES[i] - share * log(power * g))


@simd_kernel
def _integrate(pulse: Pulse) -> None:
    """Find the time series from the slowness."""
    for phase in range(2):
        series, slowness = pulse.time_series[phase], pulse.slowness[phase * DEGREE : (phase + 1) * DEGREE]
        for i in range(ROOM):
            series[i] = 0.0
        for j in range(DEGREE):
            for i in range(ROOM):
                series[i] += _ANTIDERIVATIVE[j, i] * slowness[j]


@simd_kernel
def _time(series: View[float], zeta: float) -> float:
    """Return samples between the phase's contact end and zeta."""
    x = 2.0 * zeta - 1.0
    t = series[12]
    t = t * x + series[11]
    t = t * x + series[10]
    t = t * x + series[9]
    t = t * x + series[8]
    t = t * x + series[7]
    t = t * x + series[6]
    t = t * x + series[5]
    t = t * x + series[4]
    t = t * x + series[3]
    t = t * x + series[2]
    t = t * x + series[1]
    return t * x + series[0]


@kernel
def _zeta(series: View[float], duration: float, t: float) -> float:
    """Invert `_time` by Newton's method from the straight line, which it is close to."""
    zeta = t / duration
    for _ in range(8):
        x = 2.0 * zeta - 1.0
        value = series[DEGREE]
        slope = 0.0
        for i in range(DEGREE - 1, -1, -1):
            slope = slope * x + value
            value = value * x + series[i]
        step = (value - t) / (2.0 * slope)
        zeta = min(max(zeta - step, 0.0), 1.0)
        if abs(step) < 1e-8:  # and so the next one below its square
            break
    return zeta


@simd_kernel
def _impulse_at(log_zeta: float, a: float, heat: float) -> float:
    """Return the force's impulse per zeta at a node, over momentum (a + 1) span; `heat` is w span."""
    return exp(heat * (1.0 - exp((a + 1.0) * log_zeta)) + a * log_zeta)


@simd_kernel
def _add_moments(pulse: Pulse, phase: int, ends: tuple[float, float], shift: float, moments: View[float]) -> None:
    """Add all moments but the zeroth between two zeta of a phase."""
    a, heat, series = pulse.exponent, pulse.w[phase] * pulse.span[phase], pulse.time_series[phase]
    middle, half = 0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0])
    scale = pulse.momentum * (a + 1.0) * pulse.span[phase] * abs(half)
    late = pulse.duration if phase == 1 else 0.0
    sign = -1.0 if phase == 1 else 1.0
    m1 = m2 = m3 = m4 = m5 = m6 = m7 = 0.0
    for j in range(NODES):
        node = max(middle + half * _PIECE_NODES[j], _LEAST)
        weight = scale * _PIECE_WEIGHTS[j] * _impulse_at(log(node), a, heat)
        x = 2.0 * (late + sign * _time(series, node) - shift) - 1.0
        p1 = weight * x
        p2 = RISE[1] * x * p1 - FALL[1] * weight
        p3 = RISE[2] * x * p2 - FALL[2] * p1
        p4 = RISE[3] * x * p3 - FALL[3] * p2
        p5 = RISE[4] * x * p4 - FALL[4] * p3
        p6 = RISE[5] * x * p5 - FALL[5] * p4
        m1 += p1
        m2 += p2
        m3 += p3
        m4 += p4
        m5 += p5
        m6 += p6
        m7 += RISE[6] * x * p6 - FALL[6] * p5
    moments[1] += m1
    moments[2] += m2
    moments[3] += m3
    moments[4] += m4
    moments[5] += m5
    moments[6] += m6
    moments[7] += m7


@kernel
def advance_pulse(pulse: Pulse, until: float, shift: float, moments: View[float]) -> None:
    """Advance the pulse to the time `until`, and write the moments (N s) of its force on the way; both ends are in the
    sample that begins at `shift`.

    Times are samples since the contact's beginning, and may be negative for `shift`. The zeroth moments of a contact
    add up to m (v_in - v_out) but for rounding.
    """
    for n in range(MOMENTS):
        moments[n] = 0.0
    turn = pulse.phase_time[0]
    for phase in range(2):
        if (phase == 0 and pulse.time >= turn) or (phase == 1 and until < turn):
            continue
        end = turn if phase == 0 else pulse.duration
        if until < end:
            since = until if phase == 0 else pulse.duration - until
            zeta = _zeta(pulse.time_series[phase], pulse.phase_time[phase], since)
            speed = velocity_of(pulse.w[phase], pulse.span[phase] * (1.0 - zeta ** (pulse.exponent + 1.0)))
            u = speed if phase == 0 else -speed
        else:
            # The phase's end, where both are known: greatest compression, or release.
            zeta = 1.0 - phase
            u = 0.0 if phase == 0 else -pulse.restitution
        # Add the moments from the pulse's state to (zeta, u) in the same phase, and move it there.
        if abs(zeta - pulse.zeta) > _WIDE:
            middle = 0.5 * (pulse.zeta + zeta)
            _add_moments(pulse, phase, (pulse.zeta, middle), shift, moments)
            _add_moments(pulse, phase, (middle, zeta), shift, moments)
        else:
            _add_moments(pulse, phase, (pulse.zeta, zeta), shift, moments)
        # Quadrature says when the momentum is given; how much there is between two velocities is known exactly.
        moments[0] += pulse.momentum * (pulse.u - u)
        pulse.zeta = zeta
        pulse.u = u
    pulse.time = until


@kernel
def state_of_pulse(pulse: Pulse, v_in: float, k: float) -> tuple[float, float, float]:
    """Return the state of a pulse: compression (m), its velocity (m/s), and the momentum (N s) given so far."""
    phase = 0 if pulse.time < pulse.phase_time[0] else 1
    a, w, span = pulse.exponent, pulse.w[phase], pulse.span[phase]
    Z = pulse.zeta ** (a + 1.0)
    g = potential(velocity_of(w, span * Z), w * span * Z, velocity_of(w, span * (1.0 - Z)), w)
    length = (pulse.momentum * v_in / k) ** (1.0 / (a + 1.0))
    x = length * ((a + 1.0) * max(g, 0.0)) ** (1.0 / (a + 1.0))
    return x, pulse.u * v_in, pulse.momentum * (1.0 - pulse.u)


@simd_kernel
def find_nodes(pulse: Pulse) -> None:
    """Put times (samples) and impulses (N s) of a pulse's Gauss nodes into `node_time` and `node_impulse`.

    The sum of impulses times exp(-s t) is the pulse's Laplace transform: for |s| tau < 4 and a <= 4 within 1e-5 of
    the momentum where w <= 1, 2e-4 where w <= 5 and 1.8e-2 at worst, at w = 50; for a <= 6 within 3e-5, 1.3e-3,
    2.5e-2.
    """
    a = pulse.exponent
    for phase in range(2):
        heat, series = pulse.w[phase] * pulse.span[phase], pulse.time_series[phase]
        times = pulse.node_time[phase * NODES : (phase + 1) * NODES]
        impulses = pulse.node_impulse[phase * NODES : (phase + 1) * NODES]
        scale = 0.5 * pulse.momentum * (a + 1.0) * pulse.span[phase]
        late = pulse.duration if phase == 1 else 0.0
        sign = -1.0 if phase == 1 else 1.0
        for j in range(NODES):
            impulses[j] = scale * _PIECE_WEIGHTS[j] * _impulse_at(_PHASE_LOGS[j], a, heat)
            times[j] = late + sign * _time(series, _PHASE_NODES[j])


# Taylor's coefficients of cos(pi x) and sin(pi x)/x: |x| is at most a half, where less than 6e-8 is left out.
_COSINE = tuple((-1) ** k * math.pi ** (2 * k) / math.factorial(2 * k) for k in range(7))
_SINE = tuple((-1) ** k * math.pi ** (2 * k + 1) / math.factorial(2 * k + 1) for k in range(6))


@simd_kernel
def find_power(pulse: Pulse, period: float, frequency: View[float], power: View[float]) -> None:
    """Put a pulse's power at every frequency (Hz), as a share of that at 0, into `power`.

    It is that of the nodes, which `find_nodes` has set. period: of a sample (s), times the object's pitch.
    """
    times, impulses = pulse.node_time, pulse.node_impulse
    total = 0.0
    for j in range(2 * NODES):
        total += impulses[j]
    share = 1.0 / total
    for i in range(len(frequency)):
        turns = period * frequency[i]
        re = im = 0.0
        for j in range(2 * NODES):
            # Cos and sin of 2 pi x to 3e-7, without a call or a division, so that loops over it become SIMD.
            x = turns * times[j]
            x -= math.floor(x + 0.5)
            s = x * x
            c = _COSINE[6] * s + _COSINE[5]
            c = c * s + _COSINE[4]
            c = c * s + _COSINE[3]
            c = c * s + _COSINE[2]
            c = c * s + _COSINE[1]
            c = c * s + _COSINE[0]
            d = _SINE[5] * s + _SINE[4]
            d = d * s + _SINE[3]
            d = d * s + _SINE[2]
            d = d * s + _SINE[1]
            d = (d * s + _SINE[0]) * x
            c, s = 1.0 - 2.0 * d * d, 2.0 * d * c
            re += impulses[j] * c
            im += impulses[j] * s
        re *= share
        im *= share
        power[i] = re * re + im * im
