"""One force a sample: the cheap rung below stick_slip.py, of order 2 at best, and as passive.

A slip is solved in the sample's mean velocity: f v_rel >= 0 exactly. A stick is solved in the velocity at its end,
since by the mean it would alternate from sample to sample for ever. Where that would give back more than `tank`, the
mean is taken after all.
"""

from ..native.jit import kernel
from .law import coefficient, slip_of
from .record import Friction
from .stick_slip import pay


@kernel
def hold_mean(friction: Friction, drive: float, give: float, normal: float) -> None:
    """Find the held force by the mean slip without friction (m/s), what 1 N takes of it, and the mean normal force."""
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
def step_held(friction: Friction, end: float, mean: float) -> None:
    """Take the sample with one force, `start`, by the velocities that `velocity.sense` finds."""
    drive, normal = friction.drive, friction.normal
    give = friction.whole_mean
    slip = 0.5 * (drive[0] + drive[1]) - mean
    load = 0.5 * (normal[0] + normal[1])
    friction.holds += 1
    before = friction.branch
    hold_mean(friction, slip, give, load)
    by_mean = friction.start
    if friction.branch == 0.0:
        if friction.whole_held[1] > 0.0:
            friction.start = (drive[1] - end) / friction.whole_held[1]
        most = friction.static * normal[1]
        friction.start = min(max(friction.start, -most), most)
    friction.events += friction.branch != before
    if not pay(friction, mean, 0.0):
        friction.start = by_mean
        if not pay(friction, mean, 0.0):
            friction.start = 0.0
