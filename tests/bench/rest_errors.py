"""Rests at all accuracies beside `exact`: how far the sounds of objects that lie on something are apart, and their
levels. `python -m tests.bench.rest_errors`."""

import numpy as np
from numpy.typing import NDArray

import carom

_OBJECTS = ("glass-plate", "steel-plate", "ceramic-tile", "marimba-bar", "wood-board", "polycarbonate-sheet",
            "glockenspiel-bar", "tin-lid")  # fmt: skip
_UNDER = ("other", "table", "felt", "foam", "finger", "palm")
_SPEEDS = 0.001, 0.1  # m/s: of the blows; the faster ones let some lift off
_LEVELS = ("-50", "-60", "-80")


def sound(name: str, under: str, accuracy: str, speed: float) -> NDArray[np.float64]:
    """Return 0.25 s of an object that lies on something, or on another of its kind, and is struck."""
    score = (
        f"0 /accuracy {accuracy}\n0 /object/new a {name}\n0 /object/new other {name} tune 0.3\n"
        f"0 /object/a/rest {under}\n0.002 /object/a/impact {speed} 0.3\n"
    )
    return carom.render(score, seconds=0.25, limiter=False).samples.astype(float)


def main() -> None:
    print(f"{'':32}" + "".join(f"{level:>7} {'level':>6}" for level in _LEVELS))
    for speed in _SPEEDS:
        for under in _UNDER:
            for name in _OBJECTS:
                exact = sound(name, under, "exact", speed)
                told = ""
                for level in _LEVELS:
                    other = sound(name, under, level, speed)
                    apart, loud = (np.linalg.norm(each) / np.linalg.norm(exact) for each in (other - exact, other))
                    told += f"{20 * np.log10(apart):7.1f} {20 * np.log10(loud):6.2f}"
                print(f"{speed:5} {under:6} {name:20}{told}", flush=True)


if __name__ == "__main__":
    main()
