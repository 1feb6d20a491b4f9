"""The rebound of a soft contact against an integration of its equation by another solver."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from carom.server.bridge.mujoco.soft import SOFT
from carom.server.bridge.mujoco.track import rebound


def left(low: float, high: float, ratio: float, pushed: float, speed: float = 1.0) -> float:
    """Return the share of its speed that is left, by DOP853."""
    time, width, power = 0.02, 0.004, 2.0
    stiffness, damping = 1 / (high * time * ratio) ** 2, 2 / (high * time)

    def impedance(depth: float) -> float:
        x = min(max(depth, 0.0) / width, 1.0)
        y = x**power / 0.5 if x <= 0.5 else 1 - (1 - x) ** power / 0.5
        return low + y * (high - low)

    def rates(_, state):
        depth, rate = state
        d = impedance(depth)
        return [rate, pushed - max(0.0, d * (damping * rate + stiffness * d * depth + pushed))]

    def over(_, state):
        return state[0] + 1e-9

    over.terminal, over.direction = True, -1
    found = solve_ivp(
        rates, (0.0, 1.0), [0.0, speed], method="DOP853", events=over, rtol=1e-9, atol=1e-12, max_step=1e-3
    )
    return max(-found.y[1].min(), 0.0) / speed


@pytest.mark.parametrize("low, high, ratio", [(0.9, 0.95, 0.15), (0.9, 0.95, 0.5), (0.5, 0.99, 0.3)])
def test_a_spring_and_a_damper_leave_what_their_equation_says(low, high, ratio):
    soft, time = np.zeros(1, SOFT), 0.02
    step = 5e-5
    spring = 1 / (high * time * ratio) ** 2, 2 / (high * time)
    soft[0] = (step, *spring, low, high, 0.004, 0.5, 2.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    assert rebound(soft.ctypes.data) == pytest.approx(left(low, high, ratio, 0.0), rel=0.02)
