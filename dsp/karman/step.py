"""The step of coupled modes: scalar auxiliary variable, by kicks between samples.

Between samples each mode rings, and answers contacts, as it does on any other object. At each sample all get a change
of velocity, of which the energy is exact. With psi = sqrt(2 V + c0) and g the gradient of psi by displacements,

    v+ = v - h g (psi+ + psi)/2,    psi+ = psi + h g (v+ + v)/2,

so that sum |z|^2/2 + psi^2/2 stays, whatever g is: an old gradient, one that is extrapolated, or one of modes of which
V knows nothing. (J. Shen, J. Xu, J. Yang, J. Comput. Phys. 353, 2018, for the variable; S. Bilbao, C. Webb, Z. Wang,
M. Ducceschi, DAFx 2023, for explicit schemes of nonlinear plates.)
"""

import math
from typing import NamedTuple

from ..native.jit import kernel, simd_kernel
from ..native.typed import View, f32
from .layout import FAINT, Sheet

_FLOOR = 0.05  # of c0: the least that psi^2 counts as, so that its gradient stays finite
_LEAST = 1e-300  # J
_HALVINGS = 30  # of an interval in which a root lies
_BEHIND = 0.06  # of the energy that a plate has or may get: by how much its V may be below the grid's


_DAMPING = math.sqrt(0.5)
_HELD = 0.02  # s in which what was heard of bending fades once modes are no longer coupled


class Heard(NamedTuple):
    """The first modes of a plate, as they ring and are heard: coefficients, and weights at the left output and, over
    that, at the right."""

    a1: View[float]
    a2: View[float]
    weight: View[float]
    balance: View[float]


@simd_kernel
def prepare(sheet: Sheet, heard: Heard, rate: float) -> None:
    """Make what reads and moves modes by their samples: from coefficients, weights and `sheet.scale`.

    With r and theta of a mode, its velocity is (r cos(theta) y1 - r^2 y2)/(r sin(theta)), of samples without weight.
    """
    velocity, before, pushed, moved = sheet.seen[0], sheet.seen[1], sheet.pushed, sheet.moved
    a1, a2, weight, left, right = heard.a1, heard.a2, heard.weight, sheet.bends[0], sheet.bends[1]
    fading, moving, bent = sheet.fades[0], sheet.fades[1], sheet.fades[2]
    for i in range(len(a1)):
        sine = math.sqrt(max(-a2[i] - 0.25 * a1[i] * a1[i], 1e-300))
        size = sine * weight[i] * sheet.scale
        omega = rate * math.atan2(sine, 0.5 * a1[i])
        rings = a2[i] != 0.0 and weight[i] != 0.0
        velocity[i] = 0.5 * a1[i] / size if rings else 0.0
        before[i] = a2[i] / size if rings else 0.0
        pushed[i] = size / a2[i] if rings else 0.0
        moved[i] = 1.0 / (omega * weight[i] * sheet.scale) if rings else 0.0
        left[i] = weight[i] * sheet.scale * sine / (rate * (1.0 - a1[i] - a2[i])) if rings else 0.0
        right[i] = left[i] * heard.balance[i]
        fading[i] = -0.5 * rate * math.log(-a2[i]) if rings else 0.0
        moving[i] = 0.5 * (-1.0 / a2[i] - 1.0) if rings else 0.0
        bent[i] = moving[i] / (weight[i] * sheet.scale) ** 2 if rings else 0.0
    theta = 2.0 * math.pi * min(sheet.highest / rate, 0.25)
    r = math.exp(-_DAMPING * theta)
    sheet.smoothing[0] = 2.0 * r * math.cos(math.sqrt(1.0 - _DAMPING * _DAMPING) * theta)
    sheet.smoothing[1] = -r * r
    sheet.smoothing[2] = 1.0 - sheet.smoothing[0] - sheet.smoothing[1]


@simd_kernel
def displace(sheet: Sheet, y1: View[float], place: View[f32]) -> None:
    """Write displacements into `place`, (3, functions): of cosines, of sines, and of cosines with the other sign; 0
    where they are FAINT."""
    n, plain = sheet.functions, sheet.plain
    cosine, sine, turned = place[:n], place[n : 2 * n], place[2 * n : 3 * n]
    moved, strained = sheet.moved, sheet.strained
    for i in range(n):
        found = y1[i] * moved[i] * strained
        found = found if abs(found) >= FAINT else 0.0
        cosine[i] = found
        turned[i] = -found
    for i in range(plain):
        sine[i] = 0.0
    for i in range(plain, n):
        found = y1[n - plain + i] * moved[n - plain + i] * strained
        sine[i] = found if abs(found) >= FAINT else 0.0


@simd_kernel
def take(sheet: Sheet, energy: float, answer: View[f32]) -> None:
    """Take the stretching energy V (J) and its gradient (2, functions), both of the plate of the tables, as looked at
    now."""
    n, plain = sheet.functions, sheet.plain
    now, last, before, earlier = sheet.gradient[0], sheet.gradient[1], sheet.gradient[2], sheet.gradient[3]
    tension = sheet.tension * sheet.share
    square = 2.0 * tension * energy + sheet.c0
    sheet.truth = math.sqrt(max(square, _FLOOR * sheet.c0, _LEAST))
    scale = tension * sheet.strained / sheet.truth
    for i in range(2 * n - plain):
        earlier[i] = before[i]
        before[i] = last[i]
    for i in range(n):
        last[i] = scale * answer[i]
    for i in range(plain, n):
        last[n - plain + i] = scale * answer[n + i]
    for i in range(2 * n - plain):
        now[i] = last[i]
    sheet.looked = min(sheet.looked + 1, 3)


@simd_kernel
def extrapolate(sheet: Sheet, ahead: float) -> None:
    """Continue the gradient as a parabola, by so many looks after the last."""
    now, last, before, earlier = sheet.gradient[0], sheet.gradient[1], sheet.gradient[2], sheet.gradient[3]
    share = ahead if sheet.looked >= 2 else 0.0
    bend = 0.5 * ahead * (ahead + 1.0) if sheet.looked >= 3 else 0.0
    for i in range(2 * sheet.functions - sheet.plain):
        change = last[i] - before[i]
        now[i] = last[i] + share * change + bend * (change - (before[i] - earlier[i]))


@simd_kernel
def kick(sheet: Sheet, y1: View[float], y2: View[float], h: float) -> None:
    """Change the modes' velocities by the force of stretching over a sample of h seconds.

    A mode is heard by omega q, which a slow force bends without a sound: pressure follows acceleration. So `sheet.bent`
    becomes what is heard of bending, up to the highest coupled mode, to be taken from the sound.

    Stretching gives back no more than it holds: where it would, it pulls at nothing. Under a hand it pulls on, as what
    holds a plate bent must not come and go.
    """
    n = 2 * sheet.functions - sheet.plain
    g, velocity, before, pushed = sheet.gradient[0], sheet.seen[0], sheet.seen[1], sheet.pushed
    square = along = 0.0
    for i in range(n):
        square += g[i] * g[i]
        along += g[i] * (velocity[i] * y1[i] + before[i] * y2[i])
    share = 0.25 * h * h * square
    after = (sheet.psi * (1.0 - share) + h * along) / (1.0 + share)
    change = -0.5 * h * (sheet.psi + after)
    if after < sheet.psi and after * after < _held(sheet) and sheet.held == 0:
        after, change = sheet.psi, 0.0
    sheet.psi = after
    left = right = 0.0
    for i in range(n):
        y2[i] += change * pushed[i] * g[i]
        left += sheet.bends[0, i] * g[i]
        right += sheet.bends[1, i] * g[i]
    _smooth(sheet, change / h * left, change / h * right)


@kernel
def _held(sheet: Sheet) -> float:
    """Return the least that psi^2 may fall to: a flat plate's V is never below 0, and none is far below the grid's."""
    least = sheet.truth * sheet.truth - 2.0 * _BEHIND * sheet.c0 / sheet.growth
    return max(least, sheet.c0) if sheet.grids[sheet.level].domed == 0 else least


@kernel
def _smooth(sheet: Sheet, left: float, right: float) -> None:
    """Go on with what is heard of bending by a sample."""
    for side in range(2):
        bent, new = sheet.bent[side], left if side == 0 else right
        smooth = sheet.smoothing[0] * bent[0] + sheet.smoothing[1] * bent[1] + sheet.smoothing[2] * new
        bent[1] = bent[0]
        bent[0] = smooth


@kernel
def straighten(sheet: Sheet, rate: float) -> None:
    """Fade what is heard of bending by a sample, of modes that are no longer coupled."""
    for side in range(2):
        sheet.bent[side, 1] = 0.0
        sheet.bent[side, 0] *= 1.0 - 1.0 / (_HELD * rate)


@simd_kernel
def give_back(sheet: Sheet, y1: View[float], y2: View[float], h: float, share: float) -> None:
    """Give psi what a sample of h seconds takes of modes that stretching holds bent: at rest they would lose nothing.

    A mode's energy is (v^2 + omega^2 q^2)/2 with v = q' + decay q, and falls by 2 decay, bent or not; V changes by
    g q' = g v - decay g q, of which the kick does g v. What is due stays owed beyond a share `given` of what modes have
    just lost. From the rest of that psi gets a share of what it lacks: under a hand it drifts, and nothing swings
    that could pay.
    """
    n = 2 * sheet.functions - sheet.plain
    g, velocity, before, moved = sheet.gradient[0], sheet.seen[0], sheet.seen[1], sheet.moved
    fading, moving, bent = sheet.fades[0], sheet.fades[1], sheet.fades[2]
    due = lost = 0.0
    for i in range(n):
        v = velocity[i] * y1[i] + before[i] * y2[i]
        due -= fading[i] * g[i] * moved[i] * y1[i]
        lost += moving[i] * v * v + bent[i] * y1[i] * y1[i]
    sheet.owed += h * sheet.truth * due
    given = min(sheet.owed, sheet.given * lost)
    sheet.owed -= given
    if share > 0.0:
        given += min(share * _missing(sheet, y1, y2, h), sheet.given * lost - given)
    sheet.psi = math.sqrt(max(sheet.psi * sheet.psi + 2.0 * given, 0.0))


@simd_kernel
def settle(sheet: Sheet, y1: View[float], y2: View[float], share: float, h: float) -> None:
    """Bring psi nearer to the grid's by a share of the difference in energy, which the coupled modes pay, or get.

    All velocities change by one factor, the less the less they are: were some modes to pay more than others, or as much
    while they turn around, those that have least would grow by it.
    """
    n = 2 * sheet.functions - sheet.plain
    velocity, before, pushed = sheet.seen[0], sheet.seen[1], sheet.pushed
    square = 0.0
    for i in range(n):
        v = velocity[i] * y1[i] + before[i] * y2[i]
        square += v * v
    if square <= _LEAST:
        return
    wanted = share * min(square / max(sheet.energy, _LEAST), 1.0) * _missing(sheet, y1, y2, h)
    paid = max(min(wanted, 0.25 * square), -0.5 * sheet.psi * sheet.psi)
    loss = 1.0 - math.sqrt(1.0 - 2.0 * paid / square)
    for i in range(n):
        y2[i] -= loss * pushed[i] * (velocity[i] * y1[i] + before[i] * y2[i])
    sheet.psi = math.sqrt(max(sheet.psi * sheet.psi + 2.0 * paid, 0.0))


@simd_kernel
def catch_up(sheet: Sheet, y1: View[float], y2: View[float], h: float) -> None:
    """Bring psi, which is far behind, to the grid's as far as modes can pay at once: the highest pay most. None gets
    anything, also where half of a kick brings psi ahead."""
    n = 2 * sheet.functions - sheet.plain
    velocity, before, pushed, drained = sheet.seen[0], sheet.seen[1], sheet.pushed, sheet.drained
    first = second = 0.0
    for i in range(n):
        v = velocity[i] * y1[i] + before[i] * y2[i]
        first += drained[i] * v * v
        second += drained[i] * drained[i] * v * v
    if second <= _LEAST:
        return
    paid = min(max(_missing(sheet, y1, y2, h), 0.0), 0.25 * first * first / second)
    loss = (first - math.sqrt(first * first - 2.0 * second * paid)) / second
    for i in range(n):
        v = velocity[i] * y1[i] + before[i] * y2[i]
        y2[i] -= loss * drained[i] * pushed[i] * v
    sheet.psi = math.sqrt(max(sheet.psi * sheet.psi + 2.0 * paid, 0.0))


@simd_kernel
def _missing(sheet: Sheet, y1: View[float], y2: View[float], h: float) -> float:
    """Return the energy (J) by which psi is behind the grid's.

    psi is that of half a sample of h seconds before the grid was looked at, as half of a kick is still to come.
    """
    g, velocity, before = sheet.gradient[0], sheet.seen[0], sheet.seen[1]
    along = 0.0
    for i in range(2 * sheet.functions - sheet.plain):
        along += g[i] * (velocity[i] * y1[i] + before[i] * y2[i])
    now = sheet.psi + 0.5 * h * along
    return 0.5 * (sheet.truth * sheet.truth - now * now)


@kernel
def is_behind(sheet: Sheet) -> bool:
    """True if psi is far behind what the grid says is stretched."""
    return sheet.truth * sheet.truth - sheet.psi * sheet.psi > 2.0 * _BEHIND * sheet.c0 / sheet.growth


@simd_kernel
def drawn_in(sheet: Sheet, y1: View[float], ringing: float) -> float:
    """Return the share s of their displacements to which modes with an energy (J) `ringing` are to be drawn in, all
    alike, for V to be what psi says, and give psi what they lose.

    V is a s^4 + b s^3, which it and its slope at 1 determine, and the modes' energy goes as s^2.
    """
    n = 2 * sheet.functions - sheet.plain
    g, moved = sheet.gradient[0], sheet.moved
    slope = 0.0
    for i in range(n):
        slope += g[i] * moved[i] * y1[i]
    slope *= sheet.truth
    stretched = 0.5 * (sheet.truth * sheet.truth - sheet.c0)
    held = 0.5 * (sheet.psi * sheet.psi - sheet.c0) + ringing
    fourth, third = slope - 3.0 * stretched, 4.0 * stretched - slope
    least, most = 0.0, 1.0
    for _ in range(_HALVINGS):
        s = 0.5 * (least + most)
        if s * s * (ringing + s * (third + s * fourth)) > held:
            most = s
        else:
            least = s
    sheet.psi = math.sqrt(max(sheet.psi * sheet.psi + 2.0 * (1.0 - least * least) * ringing, 0.0))
    return least


@kernel
def fade(sheet: Sheet, samples: int) -> None:
    """Fade the force of stretching by a sample, of so many: if it ended at once, all modes that it bends would ring.

    Energy that stretching holds falls with it. Where V is below 0, psi stays, and `settle` has the modes pay.
    """
    if sheet.left == 0:
        return
    sheet.left -= 1
    x = sheet.left / samples
    share = x * x * x * (10.0 - x * (15.0 - 6.0 * x))
    stored = sheet.psi * sheet.psi - sheet.c0
    if stored > 0.0:
        sheet.psi = math.sqrt(sheet.c0 + stored * share / sheet.share)
    sheet.share = share


@simd_kernel
def set_constant(sheet: Sheet, c0: float) -> None:
    """Change c0, which changes no energy, and no force: gradients are of psi."""
    n = 2 * sheet.functions - sheet.plain
    now, last, before, earlier = sheet.gradient[0], sheet.gradient[1], sheet.gradient[2], sheet.gradient[3]
    old, more = sheet.truth, c0 - sheet.c0
    sheet.psi = math.sqrt(max(sheet.psi * sheet.psi + more, 0.0))
    sheet.truth = math.sqrt(max(old * old + more, _FLOOR * c0, _LEAST))
    sheet.c0 = c0
    for i in range(n):
        now[i] *= old / sheet.truth
        last[i] *= old / sheet.truth
        before[i] *= old / sheet.truth
        earlier[i] *= old / sheet.truth
