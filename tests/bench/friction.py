"""Promises of friction, at length: energy on random extremes, and where bowing is periodic at three rates.

    python -m tests.bench.friction [COUNT]

Prints for each way to solve friction the worst balance of COUNT random rubs (100,000), damping's loss integrated by
itself, and the most that friction gave back; the slopes of a bowed string's greatest and least force over the bow's
position; and how many cells of the map over both differ between rates.
"""

import sys
from dataclasses import replace

import numpy as np

from carom.dsp.lab.bowing import BETAS, FORCES, SHARP, force_limit, schelleng, schelleng_limit
from carom.dsp.lab.rubbed import extreme_rub
from carom.dsp.lab.slide import BOWED, rub_modes
from tests.bench.counted import counted

BALANCE, GIVEN_BACK = 1e-9, 1e-12
SLOPE = 0.15
DIFFERENT = 0.03
RATES = (44_100.0, 48_000.0, 192_000.0)
POSITIONS = np.geomspace(0.0203, 0.15, 16)
LOW_POSITIONS = POSITIONS[:7]  # where the least force is within reach of `force_limit`


def balance(name: str, count: int) -> bool:
    """True if energy is kept by "located", "held" or "elastic" friction."""
    random = np.random.default_rng(18)
    worst = given = 0.0
    for _ in range(count):
        rub = extreme_rub(random)
        if name == "elastic":
            rub = replace(rub, tangential=float(np.exp(random.uniform(np.log(10.0), np.log(1e10)))))
        course = rub_modes(rub, name == "held")
        worst = max(worst, course.balance)
        work = float(np.abs(course.driven).max())
        given = max(given, -float(course.lost.min()) / work if work > 0.0 else 0.0)
    print(f"{name}: balance within {worst:.2g} of the work, friction gives back at most {given:.2g} of it", flush=True)
    return worst < BALANCE and given <= GIVEN_BACK


def slope(raised: bool, law: tuple[float, float, float] = SHARP, torsion: int = 0) -> float:
    """Return the exponent of a limit over the position."""
    positions = POSITIONS if raised else LOW_POSITIONS
    forces = [force_limit(float(beta), raised, law=law, torsion=torsion) for beta in positions]
    return float(np.polyfit(np.log(positions), np.log(forces), 1)[0])


def limits() -> bool:
    """True if the limits of force fall as theory says."""
    greatest, least = slope(True), slope(False)
    shares = [force_limit(float(beta)) / schelleng_limit(float(beta)) for beta in POSITIONS]
    print(f"greatest force: position^{greatest:.2f}, {min(shares):.2f} to {max(shares):.2f} of Schelleng's")
    print(f"least force: position^{least:.2f}")
    print(f"greatest force with torsion: position^{slope(True, torsion=26):.2f}")
    print(f"and with rosin's law: position^{slope(True, BOWED, 26):.2f}")
    return abs(greatest + 1.0) < SLOPE and least < greatest


def maps() -> bool:
    """True if the maps at three rates are alike."""
    cells = {rate: np.array([row["periodic"] for row in schelleng(rate)]) for rate in RATES}
    fine = cells[RATES[-1]]
    off = {rate: float(np.mean(cells[rate] != fine)) for rate in RATES[:-1]}
    off[0.0] = float(np.mean(cells[RATES[0]] != cells[RATES[1]]))
    for rate, share in off.items():
        pair = f"{rate:g} and {RATES[-1]:g} Hz" if rate else f"{RATES[0]:g} and {RATES[1]:g} Hz"
        print(f"maps of {len(BETAS) * len(FORCES)} cells at {pair} differ in {100 * share:.1f} %", flush=True)
    return max(off.values()) <= DIFFERENT


def main(count: int) -> int:
    kept = [balance(name, count) for name in ("located", "held", "elastic")]
    return [*kept, limits(), maps()].count(False)


if __name__ == "__main__":
    sys.exit(main(counted(__doc__, 100_000)))
