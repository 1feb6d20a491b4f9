"""Coupled contacts from anywhere in the ranges Carom accepts: what no contact may ever do.

    python -m tests.bench.extremes [COUNT]

Prints, for each tolerance of the coupled solver, the worst growth of energy over COUNT random contacts (100,000), the
most steps, and how many were not finite.
"""

import sys

import numpy as np

from carom.dsp.contact.accuracy import TOLERANCE
from carom.dsp.contact.coupled_step import HELD
from carom.dsp.lab.coupled import extreme_case, simulate


def main(count: int) -> int:
    bad = 0
    for tolerance in (HELD, *sorted(set(TOLERANCE.tolist()), reverse=True)):
        random = np.random.default_rng(1)
        growth = most = infinite = 0.0
        for _ in range(count):
            case = extreme_case(random)
            run = simulate(case, tolerance)
            infinite += not (np.isfinite(run.energy).all() and np.isfinite(run.velocity).all())
            growth = max(growth, run.growth(case))
            most = max(most, run.steps / case.samples)
        print(
            f"tolerance {tolerance:g}: growth {growth:.2g}, at most {most:.0f} steps a sample, {infinite:.0f} infinite"
        )
        bad += growth > 1e-8 or infinite > 0
    return bad


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 100_000))
