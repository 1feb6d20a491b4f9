"""Cost of modes on which a body rolls: by one number a frame, as the engine drives them, and by moments."""

from functools import partial
from typing import Any

import numpy as np
from numba import njit

from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.numerics.legendre import KEPT
from carom.dsp.resonator import fed
from carom.dsp.resonator.bank import DRIVER, RESPONSES, Drive, Modes, Point, ring, ring_driven
from carom.dsp.resonator.coefficients import set_mode
from carom.dsp.resonator.simd import LANES, STRETCH
from tests.bench.rounds import minima

RATE = 48_000.0
SIZES = (64, 256, 1024)
MODE_SAMPLES = 2**21  # a measurement


@njit(error_model="numpy")
def ring_free(modes, out, quanta):
    for _ in range(quanta):
        ring(modes, out, 0, QUANTUM)


@njit(error_model="numpy")
def ring_by_samples(modes, shape, arrays, quanta):
    """Ring modes with all that the engine does for it: also samples from moments, and the force's direct path to the
    sound."""
    moments, samples, driver, work, taps, out = arrays
    n = len(modes.y1)
    point = Point(shape, n, driver.row, driver.weights)
    for _ in range(quanta):
        fed.sample_force(moments, samples[0], 2 * fed.REACH)
        for frame in range(0, QUANTUM, fed.LINE):
            fed.lay_blows(modes.response, point, driver.drift, True, 0, work, 0, n)
            fed.ring_fed(modes, work, samples, 1, True, out, frame, frame + fed.LINE)
        fed.feed_through(modes, point, work, taps)


@njit(error_model="numpy")
def ring_by_moments(modes, shape, drivers, feeds, work, out, quanta):
    for _ in range(quanta):
        for frame in range(0, QUANTUM, STRETCH):
            ring_driven(modes, shape, len(modes.y1), Drive(drivers, 1, feeds, 0), work, out, frame)


def measure(rounds: int) -> list[dict[str, Any]]:
    """Measure ns per mode-sample of modes that ring freely, and of those under a roll."""
    rows: list[dict[str, Any]] = []
    random = np.random.default_rng(1)
    for n in SIZES:
        modes = Modes(*np.zeros((5, n)), np.zeros(n // LANES * RESPONSES))
        for i, frequency in enumerate(np.linspace(100.0, 15_000.0, n)):
            set_mode(modes, i, frequency, 1.0, RATE, 1.0 + 0.0j)
        shape = random.normal(size=8 * n).astype(np.float32)
        drivers = np.zeros(1, DRIVER)
        drivers["row"], drivers["weights"], drivers["drift"] = 2, 0.25, 1e-3
        moments = 1e-3 * random.normal(size=(2 * QUANTUM, KEPT))
        work, out, samples = np.zeros(2 * n + 400), np.zeros((2, QUANTUM)), np.zeros((1, QUANTUM + 2 * fed.REACH))
        arrays = (moments, samples, drivers.view(np.recarray)[0], work, np.zeros((2, fed.REACH + 1)), out)
        quanta = MODE_SAMPLES // (n * QUANTUM)
        contenders = {
            "ring": partial(ring_free, modes, out, quanta),
            "roll": partial(ring_by_samples, modes, shape, arrays, quanta),
            "moments": partial(ring_by_moments, modes, shape, drivers, moments[None], work, out, quanta),
        }
        minima(contenders, 1)  # compiles
        ns = {name: s / (quanta * n * QUANTUM) * 1e9 for name, s in minima(contenders, rounds).items()}
        rows.append(dict(modes=n, ring_ns=ns["ring"], roll_ns=ns["roll"], moments_ns=ns["moments"]))
    return rows
