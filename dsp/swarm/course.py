"""The course of a step: how the force of a foot on the ground comes and goes, and how fast it changes.

A walker's weight is on the heel, then on the ball of the foot: the force rises to 1.15 of the weight at 0.22 of the
step, falls to 0.75 at the middle, rises to 1.1 at 0.78 and is gone at the end, as usual of walking (an estimate,
after Nilsson and Thorstensson, Acta Physiologica Scandinavica 136, 1989). Between these it goes by parabolas, so that
its rate of change is of lines. What lies under the foot crackles as the force changes; a tenth of the crackles come
evenly meanwhile, as it creeps (estimated).
"""

from itertools import pairwise

import numpy as np

from ..native.jit import kernel
from .record import Swarm

_TURNS = ((0.0, 0.0), (0.22, 1.15), (0.5, 0.75), (0.78, 1.1), (1.0, 0.0))
_CREEP = 0.1

CHANGE = sum(abs(after[1] - before[1]) for before, after in pairwise(_TURNS))
"""The sum of all changes of the force in a step, as a multiple of the weight."""


def _bends() -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the times at which the rate of crackles bends, and the rates there, over a whole of 1 and a time of 1."""
    times, rates = [], []
    for (begin, low), (end, high) in pairwise(_TURNS):
        times += [begin, 0.5 * (begin + end)]
        rates += [_CREEP, _CREEP + (1.0 - _CREEP) * 2.0 * abs(high - low) / (end - begin) / CHANGE]
    return (*times, 1.0), (*rates, _CREEP)


TIMES, RATES = (np.array(each) for each in _bends())
PIECES = len(TIMES) - 1
"""Lines of the rate."""
FASTEST = float(RATES.max())
"""The highest rate, as a multiple of the mean."""


@kernel
def course_at(swarm: Swarm, time: float) -> tuple[float, float]:
    """Return the rate (1/s) and its slope (1/s^2) of a step's crackles at a time (s) on its present piece, per crackle
    of a whole step."""
    p = swarm.piece
    if p >= PIECES:
        return 0.0, 0.0
    slope = (RATES[p + 1] - RATES[p]) / (TIMES[p + 1] - TIMES[p])
    per = 1.0 / swarm.duration
    return (RATES[p] + (time * per - TIMES[p]) * slope) * per, slope * per * per


@kernel
def next_bend(swarm: Swarm) -> float:
    """Return the time (s) at which a step's present piece ends."""
    bend: float = TIMES[min(swarm.piece + 1, PIECES)] * swarm.duration
    return bend
