"""Friction by one force a sample, of order 2 at best, as passive as the engine's stick_slip.py, for a comparison.

A slip is solved in the sample's mean velocity. A stick is solved in the velocity at its end, since by the mean it would
alternate from sample to sample for ever. Where that would give back more than `tank`, the mean is taken after all.
"""

from ..friction.located import hold_mean
from ..friction.record import Friction
from ..friction.stick_slip import pay
from ..native.jit import kernel


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
