"""Times that can be compared: the least of interleaved rounds, so that what else the machine does cancels out."""

import math
from collections.abc import Callable
from time import perf_counter

Contenders = dict[str, Callable[[], object]]


def minima(contenders: Contenders, rounds: int) -> dict[str, float]:
    """Return the least seconds that each contender took, over interleaved rounds."""
    best = dict.fromkeys(contenders, math.inf)
    for _ in range(rounds):
        for name, run in contenders.items():
            start = perf_counter()
            run()
            best[name] = min(best[name], perf_counter() - start)
    return best
