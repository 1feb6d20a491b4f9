"""Whole sounds, against the same at a higher rate, at the same times, and against `exact` at the same rate.

    python -m tests.bench.waveforms [--accuracy=-50]

Presets are struck by four strikers at a time between two samples, then once more while they ring. The reference is
the engine at `exact`; of one at a higher rate every second or fourth sample is taken, without a resampler: the sound is
a function of time, whose values at a rate's times are to be the same. Sounds are compared whole, with no window but a
fade at their end, by their spectra below 12 kHz: the greatest difference of the waveforms over the greatest value.
Delays count.
"""

import argparse
import sys
from functools import cache
from itertools import product

import numpy as np

from carom.dsp.contact.accuracy import DEFAULT, LEVELS
from carom.dsp.runtime.engine import NOW, Engine
from carom.presets.library import Presets
from carom.server.osc.wire import Message
from carom.server.scene.session import Session
from tests.dsp.engine.support import set_limiter

OBJECTS = (
    "wine-glass", "plastic-cup", "frame-drum", "wood-block", "marimba-bar", "church-bell", "glass-plate", "tin-lid",
    "pot-lid", "piano-string", "steel-plate", "tom",
)  # fmt: skip
STRIKERS = ("steel", "wood", "rubber", "felt")
RATES = ((44_100, 176_400), (48_000, 192_000), (96_000, 192_000), (48_000, 48_000))
"""Hz: of a sound, and of its reference."""
TOP = 12_000.0  # Hz
LASTS = 0.4  # s
TIMES = (0.010003, 0.17001)  # s: of the strikes
SPEED = 1.0
FADE = 0.25  # of the sound, at its end
WORST, NINE_OF_TEN = -50.0, -60.0
"""dB: bounds of all sounds, and of nine of ten, against another rate, and against the same."""


@cache
def band(name: str, striker: str, rate: int, every: int, accuracy: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the spectra below TOP of a sound read every so many samples: of the whole, and up to the second strike."""
    engine = Engine(rate)
    session = Session(engine, Presets())
    session.perform([Message("/accuracy", (accuracy,)), Message("/object/new", ("a", name))], NOW)
    set_limiter(engine, False)
    for time in TIMES:
        replies = session.perform([Message("/object/a/impact", (SPEED, "striker", striker))], time * rate)
        assert not any(reply.address == "/fail" for reply in replies), replies
    sound = engine.process(int(LASTS * rate))[::every, 0].astype(float)
    rate //= every
    first = sound[: int(100 * TIMES[1]) * rate // 100]
    return _spectrum(sound, rate), _spectrum(first, rate)


def _spectrum(sound: np.ndarray, rate: int) -> np.ndarray:
    """Return the part of a spectrum below TOP, scaled so that it does not depend on the rate."""
    fade = int(FADE * len(sound))
    faded = sound.copy()
    faded[-fade:] *= 0.5 + 0.5 * np.cos(np.pi * (np.arange(fade) + 1) / fade)
    seconds = len(sound) / rate
    return np.fft.rfft(faded)[: int(TOP * seconds)] / rate


def apart(found: np.ndarray, right: np.ndarray) -> float:
    """Return the greatest difference of two waveforms over the greatest value of the second (dB), by their spectra."""
    size = 4 * len(right)
    wrong = np.abs(np.fft.irfft(found - right, size)).max()
    return float(20 * np.log10(wrong / np.abs(np.fft.irfft(right, size)).max() + 1e-15))


def main(accuracy: str) -> int:
    """Print how far (dB) each sound is from its reference, in brackets up to the second strike, and a summary.

    Return 1 where sounds break the bounds, at -60.
    """
    found: list[list[tuple[float, float]]] = []
    print(" " * 24 + "  ".join(f"{rate:6d}/{finer:6d}" for rate, finer in RATES))
    for name, striker in product(OBJECTS, STRIKERS):
        row = []
        for rate, finer in RATES:
            whole, first = zip(
                band(name, striker, rate, 1, accuracy), band(name, striker, finer, finer // rate, "exact"), strict=True
            )  # fmt: skip
            row.append((apart(*whole), apart(*first)))
        band.cache_clear()
        found.append(row)
        print(f"{name:14} {striker:8} " + "  ".join(f"{whole:5.0f} ({first:4.0f})" for whole, first in row), flush=True)
    errors = np.array(found)
    other = np.array([rate != finer for rate, finer in RATES])
    broken = False
    for kind, column in (("another rate", errors[:, other, 0]), ("the same rate", errors[:, ~other, 0])):
        shares = ", ".join(f"{np.mean(column < bound):.0%} under {bound}" for bound in (-40, -50, -60))
        print(f"against {kind}: {shares}, worst {column.max():.0f} dB, median {np.median(column):.0f}")
        broken |= bool(column.max() > WORST or np.quantile(column, 0.9) > NINE_OF_TEN)
    return int(accuracy == "-60" and broken)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--accuracy", choices=LEVELS, default=LEVELS[DEFAULT], help="of the sounds (%(default)s)")
    sys.exit(main(parser.parse_args().accuracy))
