"""Sampled instruments, fitted: how little the modes leave, how near the spectrum comes, how long it takes.

`python -m tests.bench.fits` takes the samples of Debian's fluid-soundfont-gm up to where their loops begin. It prints
the residual of the modes alone and the log-spectral distance with the noise (dB), at 40 and at 80 modes, and the
processor's seconds. Beside 40 modes it prints what no sum of 40 damped sinusoids gets below (sinusoids.py). It fails
beyond the bounds below. `--csv FILE` keeps the figures.
"""

import argparse
import csv
import time
from dataclasses import astuple, dataclass, fields
from pathlib import Path

import numpy as np

from carom.dsp.fitting.blow import earliest, pulse
from carom.dsp.fitting.distance import log_spectral
from carom.dsp.fitting.fit import MODES, Fit, fit
from carom.dsp.fitting.hits import clearest, hits

from .recordings import SOUNDFONT
from .sinusoids import least_left
from .soundfont import SoundFont

BARS = (
    "Marimba C 5", "Glocken C8", "Glocken C9", "Xylophone C 6", "Xylophone C 7", "Vibraphone A4", "Tubular Bells C7",
)  # fmt: skip
BLOCKS = ("Low Woodblock", "High Woodblock")
BOUNDS = {"bar": {40: (-25.0, 4.5), 80: (-23.5, 3.0)}, "block": {40: (-16.0, 7.0), 80: (-20.0, 5.0)}}
"""Residual and log-spectral distance (dB) beyond which the study fails."""
NEAR = 2.5
"""dB: a residual so near to what any damped sinusoids leave does not fail."""
DRAWS = 10
"""Draws of the noise, over which the distance is averaged."""
SLOWEST = 3.0  # s of the processor's time at 40 modes


@dataclass(frozen=True)
class Row:
    """A recording, how many modes it was fitted with, their residual, its lower bound (dB; None where it was not
    sought), the log-spectral distance (dB), the processor's time (s)."""

    sample: str
    modes: int
    residual: float
    bound: float | None
    distance: float
    seconds: float

    def fails(self, residual: float, distance: float) -> bool:
        """True if it lies beyond these bounds (dB), or took too long."""
        poor = self.residual > residual and (self.bound is None or self.residual > self.bound + NEAR)
        return poor or self.distance > distance or (self.modes == MODES and self.seconds > SLOWEST)

    def __str__(self) -> str:
        bound = "" if self.bound is None else f"{self.bound:.1f}"
        return (
            f"{self.sample:18} {self.modes:5d} {self.residual:9.1f} {bound:>6} {self.distance:9.2f} {self.seconds:6.2f}"
        )


def measured(name: str, samples: np.ndarray, rate: float, count: int) -> Row:
    """Fit a recording (n,) at a rate (Hz) with so many modes, and measure the result."""
    begun = time.process_time()
    found = fit([clearest(hits(samples, rate))], [None], count)
    took = time.process_time() - begun
    bound = lowest_residual(found, count) if count == MODES else None
    return Row(name, count, float(found.residual[0]), bound, distance(found), took)


def distance(found: Fit) -> float:
    """Return the log-spectral distance (dB) of a fit with noise, on average over draws: single ones scatter by 0.1
    dB."""
    early = earliest(found.rate)
    take, modes = found.takes[0][early:], found.modes[0][early:]
    noises = [found.heard_noise.sound(len(take), found.rate, seed) for seed in range(1, DRAWS + 1)]
    return float(np.mean([log_spectral(take, modes + noise, found.rate) for noise in noises]))


def lowest_residual(found: Fit, count: int) -> float:
    """Return the least rest (dB) that `count` modes can leave of a fitted take: after the blow, where modes are damped
    sinusoids."""
    (take,), (blow,) = found.takes, found.blows
    ringing = take[earliest(found.rate) + int(np.ceil(blow.times[-1] * found.rate)) + 1 :]
    return float(10 * np.log10(least_left(ringing, count) / np.sum(take**2)))


def keep(rows: list[Row], path: Path) -> None:
    """Write rows into a CSV file."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(field.name for field in fields(Row))
        writer.writerows([f"{cell:.2f}" if isinstance(cell, float) else cell for cell in astuple(row)] for row in rows)


def main() -> None:
    parser = argparse.ArgumentParser(description="Sampled instruments, fitted.")
    parser.add_argument("--csv", type=Path, help="keep the figures in this file")
    options = parser.parse_args()
    font, rows, failed = SoundFont(SOUNDFONT), [], []
    pulse(1e-3)  # compiles what takes no part in the times
    print(f"{'sample':18} {'modes':>5} {'residual':>9} {'bound':>6} {'distance':>9} {'s':>6}")
    for kind, names in (("bar", BARS), ("block", BLOCKS)):
        for name in names:
            recording = font.recording(name)
            for count, limits in BOUNDS[kind].items():
                rows.append(measured(name, recording.unlooped, recording.rate, count))
                bad = rows[-1].fails(*limits)
                print(f"{rows[-1]}{' FAILED' * bad}", flush=True)
                failed += [name] * bad
    if options.csv:
        keep(rows, options.csv)
    if failed:
        raise SystemExit(f"beyond the bounds: {', '.join(failed)}")


if __name__ == "__main__":
    main()
