"""Bodies that slide on each other, as in a pile of pebbles: `python -m tests.bench.piles`.

For 1 to 12 slides over light blocks of wood, each on the next one or all on one, and for budgets of steps: the level
against that without a bound, the seconds of a processor for each second of sound, and how many forces were held. With
one step per sample the blocks are dashpots. Times are of the machine; levels are not.
"""

import time

import numpy as np

import carom

COUNTS = 1, 2, 4, 6, 8, 12
BUDGETS = "0 0", "16 8192", "1 8192"  # without a bound; a server's; too few steps for modes to be felt
_BLOCK = "triangle length 0.04 width 0.03 thickness 0.02 ends free material wood most_modes 64"
_LAW = "mass 0.015 stiffness 7.8e8 exponent 1.5 surface wood force 1 sweep 0.1"
_SECONDS, _BEGUN = 0.4, 0.1  # s


def heard(count: int, on_one: bool, budget: str, accuracy: str = "-60") -> tuple[float, float, int]:
    """Return the level (dB) of so many slides, the processor's seconds for one of sound, and forces that were held."""
    lines = ["0 /limiter off", f"0 /accuracy {accuracy}", f"0 /budget {budget}"]
    lines += [f"0 /object/new b{n} {_BLOCK}" for n in range(count + 1)]
    for n in range(count):
        under, by = (0, "striker steel") if on_one else (n, f"by b{n + 1} by_position 0.5")
        lines.append(f"0 /object/b{under}/slide 0.2 0.5 {by} {_LAW} id s{n} seed {n}")
    begun = time.process_time()
    sound = carom.render("\n".join(lines), seconds=_SECONDS)
    seconds = time.process_time() - begun
    lasting = sound.samples[round(_BEGUN * sound.rate) :].astype(float)
    return 10 * float(np.log10(np.mean(lasting**2))), seconds / _SECONDS, sound.report.steps_held


def main() -> None:
    """Print a line for each count."""
    heard(1, True, BUDGETS[0])  # loads the engine
    for on_one in (False, True):
        for count in COUNTS:
            each = [heard(count, on_one, budget) for budget in BUDGETS]
            told = (
                f"/budget {budget}: {level - each[0][0]:+.1f} dB, {cost:.2f} s per s, {held} held"
                for budget, (level, cost, held) in zip(BUDGETS, each, strict=True)
            )
            print(f"{count} slides {'on one' if on_one else 'on each other'}: {'; '.join(told)}", flush=True)


if __name__ == "__main__":
    main()
