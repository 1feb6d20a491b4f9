"""The forces at a collocation step's nodes between a path and one free mass on a dashpot.

With the matrix P of integrals up to the nodes (INTEGRAL), a step of h s and the mass m, forces f take q = (h/m) P f +
f/Z off the rates of compression, and h P q off the compressions, with 1/Z the dashpot's mobility. Newton's method takes
each node's own slopes, and three equations are solved by their determinants. What an iteration leaves is the law's
curvature over its change: where that is bounded well enough, as mostly after the first, another one is spared.
"""

from ..contact.collocation import INTEGRAL
from ..contact.law import law_with_slopes
from ..contact.step_record import Step
from ..native.jit import kernel, noinline_kernel
from ..numerics.settled import same_everywhere

_ITERATIONS = 16
_SOLVED = 1e-11  # share of the forces by which they may err
_NEAR = 10.0  # a node is deeper by this factor than it moves, where the law is bounded over its change

Three = tuple[float, float, float]

_TWICE = same_everywhere("TWICE", INTEGRAL @ INTEGRAL)
_P: tuple[Three, ...] = tuple((float(a), float(b), float(c)) for a, b, c in INTEGRAL)
_PP: tuple[Three, ...] = tuple((float(a), float(b), float(c)) for a, b, c in _TWICE)
_MOST_ONCE = float(abs(INTEGRAL).sum(axis=1).max())  # P times numbers, over the greatest of these
_MOST_TWICE = float(abs(_TWICE).sum(axis=1).max())


@kernel
def _times(matrix: tuple[Three, ...], f: Three) -> Three:
    """Multiply a matrix of 3 x 3 numbers by a vector."""
    return (
        matrix[0][0] * f[0] + matrix[0][1] * f[1] + matrix[0][2] * f[2],
        matrix[1][0] * f[0] + matrix[1][1] * f[1] + matrix[1][2] * f[2],
        matrix[2][0] * f[0] + matrix[2][1] * f[1] + matrix[2][2] * f[2],
    )


@kernel
def _row(p: Three, pp: Three, once: float, twice: float) -> Three:
    """Return the sum of two rows by their weights."""
    return once * p[0] + twice * pp[0], once * p[1] + twice * pp[1], once * p[2] + twice * pp[2]


@kernel
def _cross(a: Three, b: Three) -> Three:
    """Return the cross product of two vectors."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@noinline_kernel
def solve_free_mass(
    step: Step, h: float, lightness: float, mobility: float, law: tuple[float, float, float], negligible: float
) -> bool:
    """Solve for the forces at the nodes, from `step.f` on, then from 0, where the law's convexity helps, within
    `negligible` (N); return False if the step is too long to find them.

    lightness: h over the mass, s/kg; law: k, mu, a. step.free_x, step.free_v: compressions and rates without the force.
    """
    a, f = law[2], (step.f[0], step.f[1], step.f[2])
    moved = h * (lightness * _MOST_TWICE + mobility * _MOST_ONCE)  # m: the most by which 1 N moves a node
    sped = lightness * _MOST_ONCE + mobility
    for _ in range(2):
        before = 0.0
        for n in range(_ITERATIONS):
            # The compressions and their rates under forces at the nodes.
            p, pp = _times(_P, f), _times(_PP, f)
            heavy, light = h * lightness, h * mobility
            x = (
                step.free_x[0] - (heavy * pp[0] + light * p[0]),
                step.free_x[1] - (heavy * pp[1] + light * p[1]),
                step.free_x[2] - (heavy * pp[2] + light * p[2]),
            )
            v = (
                step.free_v[0] - (lightness * p[0] + mobility * f[0]),
                step.free_v[1] - (lightness * p[1] + mobility * f[1]),
                step.free_v[2] - (lightness * p[2] + mobility * f[2]),
            )
            r0, s0, d0 = law_with_slopes(x[0], v[0], law)
            r1, s1, d1 = law_with_slopes(x[1], v[1], law)
            r2, s2, d2 = law_with_slopes(x[2], v[2], law)
            # Newton's change of the forces, by the nodes' slopes and by how far the forces are from the law.
            r = r0 - f[0], r1 - f[1], r2 - f[2]
            one = _row(_P[0], _PP[0], s0 * light + d0 * lightness, s0 * heavy)
            two = _row(_P[1], _PP[1], s1 * light + d1 * lightness, s1 * heavy)
            three = _row(_P[2], _PP[2], s2 * light + d2 * lightness, s2 * heavy)
            one = one[0] + (1.0 + d0 * mobility), one[1], one[2]
            two = two[0], two[1] + (1.0 + d1 * mobility), two[2]
            three = three[0], three[1], three[2] + (1.0 + d2 * mobility)
            p, q, s = _cross(two, three), _cross(three, one), _cross(one, two)
            share = 1.0 / (one[0] * p[0] + one[1] * p[1] + one[2] * p[2])
            d = (
                share * (r[0] * p[0] + r[1] * q[0] + r[2] * s[0]),
                share * (r[0] * p[1] + r[1] * q[1] + r[2] * s[1]),
                share * (r[0] * p[2] + r[1] * q[2] + r[2] * s[2]),
            )
            f = f[0] + d[0], f[1] + d[1], f[2] + d[2]
            change = max(abs(d[0]), abs(d[1]), abs(d[2]))
            enough = _SOLVED * max(abs(f[0]), abs(f[1]), abs(f[2])) + negligible
            # The law's second derivatives: f''/f' are (a - 1)/x, and a/x over both x and v.
            least, by = min(x[0], x[1], x[2]), moved * change
            curved = by * (0.5 * (a - 1.0) * max(s0, s1, s2) * by + a * max(d0, d1, d2) * sped * change)
            bounded = min(s0, s1, s2) > 0.0 and _NEAR * by <= least and curved <= enough * least
            if bounded or change <= enough or (n > 0 and change * change <= enough * before):
                step.f[0], step.f[1], step.f[2] = f
                return True
            before = change
        f = 0.0, 0.0, 0.0
    return False
