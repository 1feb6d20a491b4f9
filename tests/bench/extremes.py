"""Coupled contacts from anywhere in the ranges Carom accepts: what no contact may ever do.

    python -m tests.bench.extremes [COUNT]

Prints, for each tolerance of the coupled solver and for blocks, the worst growth of
energy over COUNT random contacts (100,000), the most steps, and how many were not finite.
"""

import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from carom.dsp.contact.accuracy import TOLERANCE
from carom.dsp.contact.coupled_step import HELD
from carom.dsp.lab.blocks import simulate_blocks
from carom.dsp.lab.coupled import Case, Run, extreme_case, simulate
from tests.bench.counted import counted

GROWTH, GROWTH_IN_BLOCKS = 1e-8, 4e-6
"""Shares of a contact's greatest energy by which it may grow."""


def solvers() -> dict[str, tuple[Callable[[Case], Run], float]]:
    """Return each solver with the growth that it may have."""
    found: dict[str, tuple[Callable[[Case], Run], float]] = {}
    for tolerance in (HELD, *sorted(set(TOLERANCE.tolist()), reverse=True)):
        found[f"tolerance {tolerance:g}"] = partial(simulate, tolerance=tolerance), GROWTH
    found["blocks"] = _in_blocks, GROWTH_IN_BLOCKS
    return found


def _in_blocks(case: Case) -> Run:
    """Simulate a case in blocks, from the beginning of a sample on."""
    return simulate_blocks(replace(case, fraction=0.0))


def main(count: int) -> int:
    bad = 0
    for name, (run_of, bound) in solvers().items():
        random = np.random.default_rng(1)
        growth = most = infinite = 0.0
        for _ in range(count):
            case = extreme_case(random)
            run = run_of(case)
            infinite += not (np.isfinite(run.energy).all() and np.isfinite(run.velocity).all())
            growth = max(growth, run.growth(case))
            most = max(most, run.steps / case.samples)
        print(f"{name}: growth {growth:.2g}, at most {most:.0f} steps a sample, {infinite:.0f} infinite")
        bad += growth > bound or infinite > 0
    return bad


if __name__ == "__main__":
    sys.exit(main(counted(__doc__, 100_000)))
