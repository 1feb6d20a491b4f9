"""A body's click (see bodies/acceleration.py) as modes of the bank.

A click whose natural frequency is at most DIRECT, or SHARE of the rate where that is less, is one mode whose output has
a phase. It is exact at each sample, whatever the rate, as the body's modes are, and comes with them. As with these,
what it has above half the rate folds down. Of a steel ball of 13 mm that strikes steel at 1 m/s, the hardest blow of
the largest click, this moves the spectrum at 44.1 kHz by up to 1.3 dB at 12 kHz and 4 dB at 19 kHz, by where between
two samples it falls; at 96 kHz by less than 0.1 dB.

The sound of a smaller body follows the force as fast as that changes: it would be all alias, were it only sampled. So
the air's answer is smoothed first, exactly, in continuous time, by B + 0.15 B' + 0.05 B'', where B is the cubic
B-spline of four samples. A filter of two pairs of poles makes up for the treble that this takes. An impulse is then
answered by a sequence that rings as one mode from its sixth sample on:

    N(z)/(D_0(z) D_1(z) D_2(z)), with N of six taps, D_0 of the click's poles, D_1 and D_2 of the filter's,

in partial fractions three modes of two taps each, as the bank has them.

The click comes 1.26 samples late (1.4 at 0.3 of the rate) and is within 0.1 dB up to 0.43 of the rate, but for what
folds down. A part of the sound above half the rate is heard at f. Of the sound at rate - f it is -40 dB where f is a
quarter of the rate, -22 dB at 0.36 and -16 dB at 0.4; of that at rate + f it is -47, -35 and -31 dB. Less of the sound
higher up is heard, and a softer blow has less sound there. With B alone, the part from rate - f would be 2 dB greater,
that from rate + f 8 to 12 dB smaller, and the click would come 1.5 samples late.
"""

import math

from numpy.polynomial import legendre

from ..native.jit import kernel
from ..numerics.legendre import FINE
from .bank import RESPONSES, Modes
from .coefficients import set_mode
from .simd import LANES

CLICK_MODES = 3
"""Modes of the bank that a click takes, one after the other: together they make one sound."""

TAPS = 6
FIRST, SECOND = 0.15, 0.05  # samples, samples^2: of the B-spline's derivatives
# The poles of the filter, which make sinc^4 (1 + FIRST j w - SECOND w^2) flattest up to 0.43 of the rate, by
# Nelder-Mead.
NEAR = 0.4781 * complex(math.cos(3.1117), math.sin(3.1117))
FAR = 0.188 * complex(math.cos(1.2404), math.sin(1.2404))
GAIN = abs((1.0 - NEAR) * (1.0 - FAR)) ** 2
DIRECT, SHARE = 12_000.0, 0.27  # Hz, and of the rate
LEAST, WIDEST = 0.03, 0.97 * math.pi  # of a pole: faster clicks are over with the six taps
_SMALL = 1.0  # |x| up to which exp(x) is summed as a series
_TERMS = 18
_NODES, _WEIGHTS = (each.copy() for each in legendre.leggauss(16))


@kernel
def is_direct(frequency: float, decay: float, rate: float) -> bool:
    """True if a click (Hz, 1/s) is sampled as it is at a rate (Hz)."""
    omega = 2.0 * math.pi * frequency
    return math.sqrt(omega * omega + decay * decay) <= 2.0 * math.pi * min(DIRECT, SHARE * rate)


@kernel
def set_click(modes: Modes, i: int, frequency: float, decay: float, rate: float, strength: float) -> None:
    """Make modes i to i + CLICK_MODES - 1 a click: frequency (Hz) > 0, decay (1/s), strength in output per N s.

    They have been at rest; no contact feels them.
    """
    if is_direct(frequency, decay, rate):
        set_mode(modes, i, frequency, decay, rate, strength * complex(-decay / (2.0 * math.pi * frequency), 1.0))
        _set_idle(modes, i + 1)
        _set_idle(modes, i + 2)
        return
    s = complex(-decay / rate, 2.0 * math.pi * frequency / rate)
    own = _polar(max(math.exp(s.real), LEAST), min(s.imag, WIDEST))
    weight = strength * complex(s.real / s.imag, 1.0)
    _set_section(modes, i, own, NEAR, FAR, own, s, weight)
    _set_section(modes, i + 1, NEAR, own, FAR, own, s, weight)
    _set_section(modes, i + 2, FAR, own, NEAR, own, s, weight)


@kernel
def _set_idle(modes: Modes, i: int) -> None:
    """Make mode i one that answers nothing."""
    set_mode(modes, i, 0.0, 0.0, 1.0, 0.0j)
    modes.a2[i] = -LEAST * LEAST  # it is made


@kernel
def _set_section(
    modes: Modes, i: int, pole: complex, second: complex, third: complex, own: complex, s: complex, weight: complex
) -> None:
    """Make mode i the partial fraction of one pair of poles, the other two being `second` and `third`.

    At z = pole its two taps are n0 + n1/pole = N/(D D), D those of the other poles.
    """
    response = modes.response
    base = (i // LANES) * RESPONSES + i % LANES
    a1, a2 = 2.0 * pole.real, -(pole.real * pole.real + pole.imag * pole.imag)
    modes.a1[i], modes.a2[i] = a1, a2
    for k in range(RESPONSES // LANES):
        response[base + k * LANES] = 0.0
    x = _reciprocal(pole)
    gain = GAIN * _reciprocal(_denominator(second, x) * _denominator(third, x))
    for q in range(len(_NODES)):
        value = gain * _numerator(0.5 * (1.0 - _NODES[q]), x, own, s, weight)
        n1 = value.imag / x.imag
        n0 = value.real - n1 * x.real
        # b beside the last sample and c beside the last but one become a1 b + a2 c, then a2 b, in the recursion.
        b = n1 / a2
        c = (n0 - a1 * b) / a2
        before, here = 0.0, 0.5 * _WEIGHTS[q]
        for k in range(FINE):
            response[base + 2 * k * LANES] += (2 * k + 1) * here * b
            response[base + (2 * k + 1) * LANES] += (2 * k + 1) * here * c
            before, here = here, ((2 * k + 1) * _NODES[q] * here - k * before) / (k + 1)


@kernel
def _numerator(since: float, x: complex, own: complex, s: complex, weight: complex) -> complex:
    """Return N at x = 1/z for an impulse that came a share `since` of a sample before the first tap.

    Tap j of the click is the fourth difference of `_integral`; D_0 leaves of it what is not its own ringing.
    """
    a1, a2 = 2.0 * own.real, -(own.real * own.real + own.imag * own.imag)
    g1 = g2 = g3 = g4 = u1 = u2 = 0.0
    power = 1.0 + 0.0j
    total = 0.0j
    for j in range(TAPS):
        g = _integral(since + j, s, weight)
        u = g - 4.0 * g1 + 6.0 * g2 - 4.0 * g3 + g4
        total += (u - a1 * u1 - a2 * u2) * power
        power *= x
        g4, g3, g2, g1 = g3, g2, g1, g
        u2, u1 = u1, u
    return total


@kernel
def _integral(t: float, s: complex, weight: complex) -> float:
    """Integrate Im(weight exp(s t)) from 0 to t four times, FIRST of it three times and SECOND twice; t in samples.

    The fourth integral is t^4 (exp(x) - 1 - x - x^2/2 - x^3/6)/x^4 at x = s t, the third t^3/6 and s times the fourth,
    the second t^2/2 and s times the third.
    """
    x = s * t
    if abs(x.real) + abs(x.imag) < _SMALL:
        term = complex(1.0 / 24.0, 0.0)
        rest = term
        for k in range(5, 5 + _TERMS):
            term *= x * (1.0 / k)
            rest += term
    else:
        square = x * x
        rest = _polar(math.exp(x.real), x.imag) - 1.0 - x - 0.5 * square - square * x * (1.0 / 6.0)
        rest *= _reciprocal(square * square)
    square_of_t = t * t
    fourth = rest * (square_of_t * square_of_t)
    third = s * fourth + square_of_t * t * (1.0 / 6.0)
    second = s * third + 0.5 * square_of_t
    return (weight * (fourth + FIRST * third + SECOND * second)).imag


@kernel
def _denominator(pole: complex, x: complex) -> complex:
    """Return (1 - p x)(1 - p* x)."""
    return 1.0 - 2.0 * pole.real * x + (pole.real * pole.real + pole.imag * pole.imag) * x * x


@kernel
def _polar(radius: float, angle: float) -> complex:
    return complex(radius * math.cos(angle), radius * math.sin(angle))


@kernel
def _reciprocal(z: complex) -> complex:
    """Return 1/z by the conjugate: numba's complex division can raise."""
    return z.conjugate() * (1.0 / (z.real * z.real + z.imag * z.imag))
