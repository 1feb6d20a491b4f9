"""A body that swings slowly on its contact, sample by sample.

Where the contact's swing turns by little in a sample, one step takes it there: by Stoermer's and Verlet's method, whose
swing is (omega h)^2/24 too fast and whose energy does not drift (Hairer, Lubich, Wanner 2003, Acta Numerica 12,
399-450). The compression counts by its mean over the sample, of a path that is a parabola through its begin, middle and
end; the law's dissipation, and a dashpot under the contact, by the path's rise and the mean force, for which the law is
linear. So nothing is iterated.

Two moments of the force are known: its mean, and its tilt, by how fast the path bends and the compression changes.
"""

from ..contact.law import HERTZ, raised
from ..native.jit import kernel
from .path import PIECES, Path, make_pieces
from .roll_record import Roll

_TURN = 0.2
"""rad: the swing of a contact at rest turns by no more than this in a sample. What lands harder swings faster, by
the tenth root of its energy over that at rest where the force goes with the 3/2nd power."""

_SUNK = 0.1  # the most by which a dashpot yields in a sample, over the compression at rest
_SHORTEST = 1.0 / 64_000.0  # s: of shorter samples there are more than the steps of contact_step.py
_LONGEST = 1.0 / 40_000.0  # s: in longer ones landings are blurred, third octaves of bodies that hop 4 to 6 dB wrong

Body = tuple[float, float, float]
"""A body between two steps: its height (m), its rate (m/s), the contact's force (N) before."""

Lines = tuple[float, float, float]
"""The path over a step (m): its mean height, its rise, and how far it bends: begin + end - 2 middle."""

Law = tuple[float, float, float, float, float, float, float, float]
"""A contact: its stiffness, dissipation (s/m) and exponent, the mobility under it (m/(N s)), the body's weight (N), 1/m
(1/kg) and gravity (m/s^2), and the share of the force that is heard."""


@kernel
def follows(roll: Roll, period: float) -> bool:
    """True if a step a sample, of a period (s), follows a body's contact to within what is heard; not one that is to
    stop."""
    turn = roll.swing * period * period <= _TURN * _TURN
    slow = turn and roll.mobility * roll.m * roll.swing * period <= _SUNK
    begun = roll.piece >= 0 and roll.stiffness > 0.0 and roll.path.radius == roll.target.radius and roll.a == HERTZ
    goes_on = roll.fade == 1.0 and roll.target.speed > 0.0
    heard = roll.brief > 0.0 and _SHORTEST <= period <= _LONGEST and roll.target.asymmetry == 0.0
    return slow and begun and goes_on and heard


@kernel
def pass_on(path: Path, piece: int, along: float) -> tuple[int, float, float]:
    """Return the piece of a path in which a place lies that is so far (m) along another, how far along it is there, and
    the path's height."""
    i = piece & (PIECES - 1)
    while along > path.length[i]:
        along -= path.length[i]
        piece += 1
        if piece >= path.made:
            make_pieces(path)
        i = piece & (PIECES - 1)
    return piece, along, path.level[i] + along * (path.incline[i] + 0.5 * path.curvature[i] * along)


@kernel
def lines_of(level: float, middle: float, end: float) -> Lines:
    """Return what a step needs of the path's heights at its begin, middle and end."""
    return (level + 4.0 * middle + end) * (1.0 / 6.0), end - level, level + end - 2.0 * middle


@kernel
def push(law: Law, lines: Lines, body: Body, h: float, pace: float) -> tuple[Body, float, float]:
    """Move a body by its contact for h s, pace = 1/h; return it at the end, and two moments of the force over the
    weight (N s)."""
    stiffness, mu, a, mobility, weight, lightness, g, fade = law
    mean, rise, bend = lines
    y, w, before = body
    x = mean - (y + 0.5 * h * (w + mobility * (before - weight)))
    force = tilt = 0.0
    if x > 0.0:
        rate = stiffness * raised(x, a - 1.0)
        spring = rate * x
        slack = 1.0 + mu * (rise * pace - w + 0.5 * h * g + mobility * weight)
        if slack > 0.0:
            force = spring * slack / (1.0 + spring * (mu * (0.5 * h * lightness + mobility)))
            bent = (2.0 / 3.0) * mu * spring * bend
            tilt = bent + (1.0 / 6.0) * a * rate * h * (rise - h * w)
    impulse, fall = h * lightness, h * g
    y = y + h * (w - 0.5 * fall - mobility * weight) + h * (0.5 * impulse + mobility) * force
    w = w - fall + impulse * force
    return (y, w, force), fade * h * (force - weight), fade * tilt
