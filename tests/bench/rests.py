"""Random rests between objects, and on supports: how far their energy grows. `python -m tests.bench.rests [COUNT]`."""

import numpy as np

from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.engine.memory.state import QUANTUM
from tests.bench.counted import counted
from tests.dsp.engine.contacts.test_coupling import energy
from tests.dsp.engine.contacts.test_rests import contact_of, engine_at, plain, rest, rest_energy
from tests.dsp.engine.support import steer, strike

_RATES = (22_050, 44_100, 48_000, 96_000)


def growth(seed: int) -> float:
    """Return by which share of its greatest value the energy of a random pair grows, after a strike or a load that is
    steered has ended: modes without loss, one rest or two, struck before and while they rest. What the load stores in
    a contact counts with the greatest."""
    chance = np.random.default_rng(seed)
    engine = engine_at(LEVELS[seed % len(LEVELS)], int(chance.choice(_RATES)))
    objects = []
    for _ in range(2):
        count = int(chance.integers(1, 33))
        frequency = np.sort(chance.uniform(50.0, min(0.4 * engine.rate, engine.top_frequency), count))
        shape = chance.uniform(-1.0, 1.0, (8, count)) * 10.0 ** chance.uniform(-1.0, 1.0)
        objects.append((engine.add(plain(frequency, 0.0, shape)), count))
    a = chance.uniform(1.0, 3.0)
    load = 10.0 ** chance.uniform(-1.5, 2.0)
    stiffness = 10.0 ** chance.uniform(3.0, 7.0) * 10.0 ** (3.0 * (a - 1.0))
    law = stiffness, chance.choice([0.0, 10.0 ** chance.uniform(-2.0, 1.0)]), a
    mass = 10.0 ** chance.uniform(-3.0, 0.0)
    first, second = objects[0][0], objects[1][0]
    hard = 10.0 ** chance.uniform(-4.0, -2.0), 1e8, 0.0, 1.5
    speed = 10.0 ** chance.uniform(-2.0, 0.5)
    strike(engine, first, hard, 10.0, speed, position=chance.uniform())
    engine.process(32 * QUANTUM)
    under = second if chance.uniform() < 0.6 else None
    engine.send([rest(first, law, load, mass, 7, by=under, position=chance.uniform(), by_position=chance.uniform())])
    pairs = [7]
    if chance.uniform() < 0.5:
        pairs.append(8)
        engine.send([rest(first, law, load, mass, 8, position=chance.uniform())])
    worst = _followed(engine, objects, pairs, 40)
    strike(engine, objects[int(chance.integers(2))][0], hard, float(engine.position), speed, position=chance.uniform())
    engine.process(32 * QUANTUM)
    worst = max(worst, _followed(engine, objects, pairs, 40))
    engine.send([steer(7, "load", load * 10.0 ** chance.uniform(-1.0, 1.0))])
    engine.process(int(1.5 * engine.rate) // QUANTUM * QUANTUM)
    return max(worst, _followed(engine, objects, pairs, 40))


def _followed(engine, objects, pairs, quanta):
    """Return by which share the energy grows over so many quanta."""
    engine.process(QUANTUM)
    least = greatest = None
    grown = 0.0
    for _ in range(quanta):
        now = sum(energy(engine, handle, count) for handle, count in objects)
        now += sum(rest_energy(contact_of(engine, number)) for number in pairs)
        stored = sum(_stored(contact_of(engine, number)["coupled"]) for number in pairs)
        least, greatest = min(least or now, now), max(greatest or 0.0, now + stored)
        grown = max(grown, (now - least) / max(greatest, 1e-300))
        engine.process(QUANTUM)
    return grown


def _stored(coupled):
    """Return the energy (J) that a contact stores at rest."""
    k, a, x = (float(coupled[key]) for key in ("k", "a", "rest_compression"))
    return k * x ** (a + 1.0) / (a + 1.0)


def main(count: int) -> None:
    """Print the greatest growths of so many pairs."""
    found = sorted(((growth(seed), seed) for seed in range(count)), reverse=True)
    for grown, seed in found[:10]:
        print(f"{grown:.2g} at seed {seed}, {LEVELS[seed % len(LEVELS)]}")
    print(f"{count} pairs: {sum(grown > 1e-5 for grown, _ in found)} grow by more than 1e-5")


if __name__ == "__main__":
    main(counted(__doc__, 1_000))
