"""One to four extreme strikers at once on one light object, in the engine: energy that no contact may ever gain.

    python -m tests.bench.extreme_groups [COUNT]

COUNT times (100,000) strikers from anywhere in the ranges Carom accepts meet modes that have any shape at 16 places,
at 8 to 192 kHz and any accuracy. At the end of each quantum the energy of strikers, contacts and modes is added up. It
prints by accuracy how far it rose at most, over the greatest that it was, and fails beyond the bound in accuracy.py, at
accuracies that take long blows in blocks beyond that of blocks in extremes.py.
"""

import math
import sys
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from carom.dsp.bodies import Modes, listed
from carom.dsp.contact.accuracy import IN_BLOCKS, LEVELS
from carom.dsp.contact.law import elastic
from carom.dsp.engine.memory.commands import Command, Handle, Kind
from carom.dsp.engine.memory.state import QUANTUM, Solver
from carom.dsp.runtime.engine import NOW, Engine
from tests.accuracy import GROWTH
from tests.bench.counted import counted
from tests.bench.extremes import GROWTH_IN_BLOCKS
from tests.dsp.engine.contacts.test_coupling import energy, felt
from tests.dsp.engine.support import free, impact

RATES = (8_000.0, 22_050.0, 48_000.0, 96_000.0, 192_000.0)
QUANTA = 12
"""Length of a case; the strikers come within the first two."""
_LEVEL = 1e6  # so loud that no mode is put to rest as nobody would hear it
_ROWS = 16


class Striker(NamedTuple):
    """A contact law (kg, N/m^a, s/m, a), a speed (m/s), when it comes (samples), and where."""

    law: tuple[float, float, float, float]
    velocity: float
    time: float
    position: float


class Case(NamedTuple):
    """Modes, and what strikes them."""

    modes: Modes
    strikers: list[Striker]


def random_case(random: np.random.Generator, rate: float) -> Case:
    """Return 1 to 64 modes, k to 1e16, mu to 1e3, a 1 to 4, sum m phi^2 of all strikers to 100; a third without any
    loss."""
    n = int(2.0 ** random.uniform(0.0, 6.0))
    frequency = np.sort(np.exp(random.uniform(math.log(20.0), math.log(0.475 * rate), n)))
    lossless = random.uniform() < 1 / 3
    t60 = np.full(n, 1e12) if lossless else 10.0 ** random.uniform(-2.0, 3.0, n)
    shapes = random.normal(size=(4, n)) / math.sqrt(n)
    rows = np.stack([np.interp(np.linspace(0, 3, _ROWS), range(4), column) for column in shapes.T], axis=1)
    modes = listed(frequency=frequency, t60=t60, modal_mass=1.0, mass=1.0, top=0.5 * rate)
    count = int(random.integers(1, 5))
    strikers = []
    for _ in range(count):
        law = (
            10.0 ** random.uniform(-4.0, 2.0) / count,
            10.0 ** random.uniform(3.0, 16.0),
            0.0 if lossless else 10.0 ** random.uniform(-4.0, 3.0) * (random.uniform() < 0.8),
            float(random.choice([1.0, 1.5, 2.5, random.uniform(1.0, 4.0)])),
        )
        time = 10.0 ** random.uniform(-2.0, math.log10(2.0 * QUANTUM))
        strikers.append(Striker(law, 10.0 ** random.uniform(-3.0, 2.0), time, random.uniform()))
    return Case(replace(modes, strike=rows), strikers)


class Energies:
    """The energy (J) of an object's modes and of the strikers that were sent to it, quantum by quantum."""

    def __init__(self, engine: Engine, handle: Handle, strikers: list[Striker]) -> None:
        self._modal = partial(energy, engine, handle, felt(engine, handle))
        self._contacts = engine.state["contacts"][0]
        self.uncoupled = False
        self._strikers = np.array([0.5 * striker.law[0] * striker.velocity**2 for striker in strikers])

    def now(self) -> float:
        """Return all of it; a striker that has not come yet, or has left for good, has the energy that it had
        before."""
        for index in np.flatnonzero(self._contacts["gesture"]):
            contact = self._contacts[index]
            if contact["touching"]:
                self.uncoupled |= bool(contact["solver"] != Solver.COUPLED or contact["pulse"]["time"] > 0.0)
                self._strikers[contact["gesture"] - 1] = _energy(contact["coupled"])
        return float(self._strikers.sum()) + self._modal()


def _energy(coupled: Any) -> float:
    """Return the energy of a striker and of its contact, J."""
    stored = elastic(max(coupled["motion"][0], 0.0), coupled["k"], coupled["a"])
    return float(0.5 * coupled["m"] * coupled["v"] ** 2 + stored)


def growth(engine: Engine, case: Case) -> float | None:
    """Return the greatest rise of the energy over the greatest that it was; None if a contact was not coupled."""
    handle = engine.add(case.modes, _LEVEL)
    engine.process(QUANTUM)
    first, coupled, impacts = float(engine.position), engine.stats.coupled, engine.stats.impacts
    engine.send(
        [
            impact(handle, each.law, first + each.time, each.velocity, position=each.position)._replace(gesture=n)
            for n, each in enumerate(case.strikers, 1)
        ]
    )
    energies = Energies(engine, handle, case.strikers)
    course = [energies.now()]
    for _ in range(QUANTA):
        engine.process(QUANTUM)
        course.append(energies.now())
    engine.send([free(handle, at_once=True)])
    while engine.stats.contacts_active or engine.objects["used"].any():
        engine.process(QUANTUM)
    engine.release(handle)
    found = np.array(course)
    rise = float((found - np.minimum.accumulate(found)).max() / found.max())
    all_coupled = engine.stats.coupled - coupled == engine.stats.impacts - impacts and not energies.uncoupled
    return None if not all_coupled else rise if math.isfinite(rise) else math.inf


def main(count: int) -> int:
    random = np.random.default_rng(1)
    bad = 0
    for level, name in enumerate(LEVELS):
        worst, uncoupled, infinite = (0.0, ""), 0, 0
        for rate in RATES:
            engine = Engine(rate)
            engine.stems.keep(True)  # so that the modes stay out of the spectral bank, and can be looked at
            engine.send([Command(NOW, Kind.ACCURACY, value=level), Command(NOW, Kind.LIMITER, value=0.0)])
            for _ in range(count // (len(RATES) * len(LEVELS))):
                case = random_case(random, rate)
                rise = growth(engine, case)
                if rise is None:
                    uncoupled += 1
                    continue
                worst = max(worst, (rise, f"{rate:g} Hz, {len(case.modes.frequency)} modes, {case.strikers}"))
            infinite += engine.stats.faults
        print(f"{name}: growth {worst[0]:.2g}, {uncoupled} not coupled, {infinite} infinite; the worst {worst[1]}")
        bad += worst[0] > (GROWTH_IN_BLOCKS if IN_BLOCKS[level] else GROWTH.bound) or infinite > 0
    return bad


if __name__ == "__main__":
    sys.exit(main(counted(__doc__, 100_000)))
