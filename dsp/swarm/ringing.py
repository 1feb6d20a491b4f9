"""The own modes of what strikes: how much of a blow's energy they take.

A body of mass m' where it touches bends as well, and touches again and again while it does (Stoianovici and Hurmuzlu,
J. Applied Mechanics 63, 1996). With A = m' sum 1/m_i of its modes below a pulse's roll-off, these take
g^2 A/(1 + 2 g^2 A) of the energy m' v^2/2, where g is the blow's momentum in m' v: what one pulse gives if that is
little, and half at most, as if the body shared it with them evenly. A disc with its modes, computed step by step, does
so as it touches the floor several times. Rigid, it would give them up to 25 times what it has.
"""

import math

from ..native.jit import kernel
from ..native.typed import View
from ..numerics.elementary import exp, log
from .blows import ROLL_OFF, mobility_at
from .record import Swarm


@kernel
def bent_by(frequencies: View[float], count: int, mass_ratio: float, width: float) -> float:
    """Return m' M of a blow of a width (ln of s), where M is the mobility of modes of frequencies (Hz).

    mass_ratio: m' over the modal mass of each.
    """
    turns, total = 2.0 * math.pi * ROLL_OFF * exp(width), 0.0
    for i in range(count):
        turned = turns * frequencies[i]
        total += 1.0 / (1.0 + turned * turned * turned)
    return mass_ratio * total


@kernel
def kept_by(
    frequencies: View[float],
    count: int,
    mass_ratio: tuple[float, float],
    width: tuple[float, float],
    given: float,
    exponent: float,
) -> tuple[float, float, float]:
    """Return the share that is left of the energy which a rigid body's blow would give its modes, by how much ln of the
    blow's width is less as they yield, and m' M then.

    mass_ratio, width: as `bent_by` has them, of the body, and of one like it that it meets, whose ratio is 0 if it does
    not ring; given: the momentum in m' v; exponent: the contact law's.
    """
    bent = shorter = 0.0
    for step in range(3):  # what yields has a shorter pulse, which reaches more modes
        shorter = log(1.0 + bent) / (exponent + 1.0) if step > 0 else 0.0
        bent = bent_by(frequencies, count, mass_ratio[0], width[0] - shorter)
        if mass_ratio[1] > 0.0:
            bent += bent_by(frequencies, count, mass_ratio[1], width[1] - shorter)
    return 1.0 / (1.0 + 2.0 * given * given * bent), shorter, bent


@kernel
def kept_of(swarm: Swarm, mass_ratio: float, width: float, given: float) -> tuple[float, float]:
    """Return the share and the change of the width as `kept_by` has them, of a swarm's grain.

    mass_ratio: its mass over that of what rings as it.
    """
    shorter = log(1.0 + mass_ratio * mobility_at(swarm.bent, width)) / (swarm.a + 1.0)
    return 1.0 / (1.0 + 2.0 * given * given * mass_ratio * mobility_at(swarm.bent, width - shorter)), shorter


@kernel
def left_by(given: float, ratio: float) -> float:
    """Return the share of a blow's energy m v^2/2 that an object leaves, which yields as if the mass were less by a
    ratio 1/(1 + m M): its modes take (g r)^2 m M.

    given: the momentum in m v, if the object did not yield.
    """
    return max(1.0 - given * given * ratio * (1.0 - ratio), 0.0)


@kernel
def clicks_apart(swarm: Swarm) -> bool:
    """True if a swarm's grains have voices for their clicks beside those of their modes, which have less of a blow."""
    return swarm.pieces > 0 or (swarm.bends > 0 and swarm.cracked == 0)
