"""A body that swings slowly on its contact, sample by sample.

Where the contact's swing turns by little in a sample, one step takes it there: by Stoermer's and Verlet's method, whose
swing is (omega h)^2/24 too fast and whose energy does not drift (Hairer, Lubich, Wanner 2003, Acta Numerica 12,
399-450). The compression counts by its mean over the sample, of a path that is a parabola through its begin, middle and
end; the law's dissipation, and a dashpot under the contact, by the path's rise and the mean force, for which the law is
linear. So nothing is iterated.

Two moments of the force are known: its mean, and its tilt, by how fast the path bends and the compression changes.
"""

from ..contact.collocation import raised
from ..native.jit import kernel
from .path import PIECES, make_pieces
from .roll_record import Roll

_TURN = 0.2
"""rad: the swing of a contact at rest turns by no more than this in a sample. What lands harder swings faster, by
the tenth root of its energy over that at rest where the force goes with the 3/2nd power."""

_SUNK = 0.1  # the most by which a dashpot gives way in a sample, over the compression at rest
_SHORTEST = 1.0 / 64_000.0  # s: of shorter samples there are more than the steps of contact_step.py
_LONGEST = 1.0 / 40_000.0  # s: in longer ones landings are blurred, third octaves of bodies that hop 4 to 6 dB wrong

State = tuple[float, float, float, float]
"""A body between two steps: the path's height (m), its own, its rate (m/s), the contact's force (N) before."""


@kernel
def follows(roll: Roll, period: float) -> bool:
    """True if a step a sample, of a period (s), follows a body's contact to within what is heard."""
    turn = roll.swing * period * period <= _TURN * _TURN
    slow = turn and roll.mobility * roll.m * roll.swing * period <= _SUNK
    begun = roll.piece >= 0 and roll.stiffness > 0.0 and roll.path.radius == roll.target.radius
    return slow and begun and roll.brief > 0.0 and _SHORTEST <= period <= _LONGEST and roll.target.asymmetry == 0.0


@kernel
def _walk(roll: Roll, way: float) -> float:
    """Bring a body a way (m) along its path; return the path's height there."""
    path = roll.path
    i = roll.piece & (PIECES - 1)
    along = roll.along + way
    while along > path.length[i]:
        along -= path.length[i]
        roll.piece += 1
        if roll.piece >= path.made:
            make_pieces(path)
        i = roll.piece & (PIECES - 1)
    roll.along = along
    return path.level[i] + along * (path.incline[i] + 0.5 * path.curvature[i] * along)


@kernel
def step_sample(roll: Roll, state: State, h: float, pace: float) -> tuple[State, float, float]:
    """Take a step of h s, pace = 1/h; return the state at its end, and two moments of the force over the weight
    (N s)."""
    level, y, w, before = state
    way = 0.5 * h * roll.modulated_speed
    middle = _walk(roll, way)
    end = _walk(roll, way)
    weight, rise = roll.m * roll.g, end - level
    x = (level + 4.0 * middle + end) * (1.0 / 6.0) - (y + 0.5 * h * (w + roll.mobility * (before - weight)))
    force = tilt = 0.0
    if x > 0.0:
        rate = roll.stiffness * raised(x, roll.a - 1.0)
        spring = rate * x
        slack = 1.0 + roll.mu * (rise * pace - w + 0.5 * h * roll.g + roll.mobility * weight)
        if slack > 0.0:
            force = spring * slack / (1.0 + spring * (roll.mu * (0.5 * h * roll.lightness + roll.mobility)))
            bent = (2.0 / 3.0) * roll.mu * spring * (level + end - 2.0 * middle)
            tilt = bent + (1.0 / 6.0) * roll.a * rate * h * (rise - h * w)
    push, fall = h * roll.lightness, h * roll.g
    y = y + h * (w - 0.5 * fall - roll.mobility * weight) + h * (0.5 * push + roll.mobility) * force
    w = w - fall + push * force
    return (end, y, w, force), roll.fade * h * (force - weight), roll.fade * tilt
