"""Hours of sound offline: 20,000 modes that are struck, freed and made anew at random.

Fails where a witness that rings all the time has another phase or level than its modes' closed form says, by more than
-100 dB; where modes are left over; where memory grows by more than 10 MB after the first fifth, of 20 minutes at
least; or where what is there in the end costs over 1.2 times as much as the same made afresh.
"""

import argparse
import math
import re
import sys
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from carom.dsp.bodies.modes import Modes
from carom.dsp.engine.memory.commands import Command, Handle, Kind
from carom.dsp.runtime.engine import NOW, Engine
from tests.bench.ringing import BLOW, least

RATE = 48_000.0
OBJECTS, MODES = 312, 64
STRIKES, FREED = 20.0, 2.0  # per second
CHUNK = 24_000  # frames between which objects are struck and freed, at random times
WITNESS = np.geomspace(150.0, 9_000.0, 8)  # Hz
SLOW = 1e-5  # 1/s: the witness' decay
LEVEL = 1e8  # each mode is heard at some -80 dB at first
WARM = 1_200.0  # s: until every place of an engine has been taken once
HEARD = 8_192  # frames of the witness that are looked at
MOST_APART, MOST_GROWTH, MOST_COST = -100.0, 10.0, 1.2  # dB, MB, of a fresh engine's


def body(random: np.random.Generator) -> Modes:
    """Return an object that rings for a second to a minute, at its own pitches."""
    frequency = np.geomspace(100.0, 18_000.0, MODES) * random.uniform(0.8, 1.2, MODES)
    decay = 6.9 / np.exp(random.uniform(math.log(1.0), math.log(60.0), MODES))
    return Modes(frequency, decay, np.full((1, MODES), 1e-3), np.full((2, MODES), 1e-3), 1.0)


def memory() -> float:
    """Return the MB that this process holds."""
    found = re.search(r"VmRSS:\s+(\d+) kB", Path("/proc/self/status").read_text())
    assert found
    return int(found[1]) / 1024


def heard(engine: Engine) -> NDArray[np.complex128]:
    """Return the complex amplitudes of the witness' modes as of the engine's position, from what is heard of it
    next."""
    t = np.arange(HEARD) / RATE
    waves = np.exp((2j * math.pi * WITNESS - SLOW) * t[:, None])
    basis = np.concatenate([waves.real, -waves.imag], axis=1)
    found = np.linalg.lstsq(basis, np.asarray(engine.process(HEARD), np.float64)[:, 0], rcond=None)[0]
    amplitudes: NDArray[np.complex128] = found[: len(WITNESS)] + 1j * found[len(WITNESS) :]
    return amplitudes


def struck(engine: Engine, handle: Handle, when: float = NOW) -> None:
    engine.send([Command(when, "impact", handle, BLOW)])


def freed(engine: Engine, handle: Handle) -> None:
    engine.send([Command(NOW, Kind.FREE, handle, value=1.0)])
    engine.leave(handle)


def filled(seed: int, level: float) -> tuple[Engine, list[Handle], np.random.Generator]:
    """Return an engine with all objects, struck."""
    random = np.random.default_rng(seed)
    engine = Engine(RATE)
    handles = [engine.add(body(random), level) for _ in range(OBJECTS)]
    for handle in handles:
        struck(engine, handle)
    return engine, handles, random


def evening(seconds: float) -> dict[str, float]:
    """Run the objects for so long: they ring, are struck and freed. Return what is apart, has grown and costs more."""
    random = np.random.default_rng(1)
    engine = Engine(RATE)
    ones = np.ones((1, len(WITNESS)))
    witness = engine.add(Modes(WITNESS, np.full(len(WITNESS), SLOW), 1e-3 * ones, 1e-3 * np.ones((2, 8)), 1.0), 1e6)
    struck(engine, witness)
    engine.process(CHUNK)
    first, begun = heard(engine), engine.position - HEARD
    handles = [engine.add(body(random), LEVEL) for _ in range(OBJECTS)]
    held = []
    rounds = math.ceil(seconds * RATE / CHUNK)
    for _ in range(rounds):
        for _ in range(int(random.poisson(STRIKES * CHUNK / RATE))):
            struck(engine, handles[random.integers(OBJECTS)], engine.position + float(random.integers(CHUNK)))
        for _ in range(int(random.poisson(FREED * CHUNK / RATE))):
            which = int(random.integers(OBJECTS))
            freed(engine, handles[which])
            handles[which] = engine.add(body(random), LEVEL)
        engine.process(CHUNK)
        engine.ended()
        held.append(memory())
    cost = _cost(engine, handles)
    for handle in handles:
        freed(engine, handle)
    engine.process(10 * CHUNK)
    stats = engine.stats
    passed = (engine.position - begun) / RATE
    last = heard(engine)
    expected = first * np.exp((2j * math.pi * WITNESS - SLOW) * passed)
    return {
        "apart": 20 * math.log10(float(np.abs(last - expected).max() / np.abs(expected).max())),
        "left": float(stats.live_modes - len(WITNESS)),
        "growth": held[-1] - held[min(max(len(held) // 5, round(WARM * RATE / CHUNK)), len(held) - 1)],
        "cost": cost,
        "lost": float(stats.faults + stats.contacts_dropped),
    }


def _cost(engine: Engine, handles: list[Handle]) -> float:
    """Return the cost of all ringing at once, over what it costs a fresh engine with as many objects."""
    fresh, _, _ = filled(2, LEVEL)
    for handle in handles:
        struck(engine, handle)
    engine.process(100 * CHUNK // 10)
    fresh.process(100 * CHUNK // 10)
    best = {"old": math.inf, "fresh": math.inf}
    for _ in range(20):
        best |= least(best, {"old": lambda: engine.process(CHUNK), "fresh": lambda: fresh.process(CHUNK)})
    return best["old"] / best["fresh"]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hours", type=float, default=4.0)
    options = parser.parse_args()
    begun = time.perf_counter()
    found = evening(3_600.0 * options.hours)
    print(
        f"{options.hours:g} h of {OBJECTS * MODES:,} modes in {time.perf_counter() - begun:.0f} s: the witness is "
        f"{found['apart']:.1f} dB apart, {found['left']:.0f} modes are left over, memory grew by {found['growth']:.1f} "
        f"MB, the cost is {found['cost']:.3f} of a fresh engine's; {found['lost']:.0f} faults and lost contacts"
    )
    good = found["apart"] < MOST_APART and found["left"] == found["lost"] == 0
    return 0 if good and found["growth"] < MOST_GROWTH and found["cost"] < MOST_COST else 1


if __name__ == "__main__":
    sys.exit(main())
