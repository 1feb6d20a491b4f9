"""The parts of a sample that lasting contacts take in blocks (block.py): by how stiff they are, and how much they lose.

One part follows a soft contact, two or three follow stiffer ones, none the stiffest: those go by steps. So do stiff
ones that lose little: their phase is kept for the stiffness at rest (block_tables.py), and drifts as the force changes
it.
"""

import math

import numpy as np

from ..native.jit import kernel
from .block_sizes import MOST_PARTS
from .collocation import elastic
from .coupled_records import Coupled

STIFFEST = np.array([0.0, 0.6, 1.5, 3.0])
"""rad of a contact's swing in a sample, of body and object together, up to which so many parts of it follow."""

LOSSIEST = np.array([0.0, 0.3, 0.6, 2.0])
"""The same of what rolls or slides, for its loss: the share of its speed that the contact takes in a sample. Where it
takes all within a part, a kink of the path leaves a speed behind that nothing takes."""

IN_STEP = 20e-3
"""s: over which what rolls, slides or strikes is to stay in step, if its loss does not end a swing before."""

STAYS = 30.0
"""Fourth power of such a swing in a part, times the swing over that time, from which on one part more is worth it:
what is left of the phase (block_tables.py) grows with it."""

OUT_OF_STEP = np.array([300.0, 100.0])
"""The same of the most parts, from which on no block follows it within -50 dB, and within -60 dB; found on random rolls
and slides."""

LONGEST_PART = 25e-6
"""s: a longer sample takes one part more. On a rough path modes near its Nyquist frequency, which are heard as low as
that, feel the moments that are left out."""

STIFFEST_AT_REST = np.array([0.0, 1.6, 2.2, 3.6])
"""The same of a rest, which hardly leaves its stiffness: one part mostly follows it within -55 dB."""

LANDS = np.array([0.0, 0.7, 0.9, 1.5])
"""rad of the swing at the greatest depth up to which so many parts follow what lands harder than ever, within -50 dB by
one, and within -60 dB by two; found on bodies that are thrown up, of exponents 1.5 to 2.5."""

_HARDER = 1.2  # swing over that at rest up to which a contact hardly leaves its rest
_SOFT = 0.3  # rad of such a swing up to which one part of a sample follows a rest within -60 dB
_DRIFTS = 100.0  # fourth power of a rest's swing in a part over its loss factor, up to which it hardly gets out of step
_LONG = 0.1  # the same of a blow: it lasts for 40 samples on a wall


@kernel
def parts_for(contact: Coupled, least: int, rests: bool, stays: bool, rolls: bool) -> int:
    """Return the parts of a sample, `least` or more, that follow the contact, as stiff as it is under its weight, or
    gets with its energy; 0 if no number does. A soft rest takes one. rests: it is a rest; stays: and one that hardly
    loses anything is to stay in step for as long as it swings."""
    swing = swing_of(contact)
    if rests and swing < _SOFT:
        return 1
    loss = contact.mu * contact.rest_force * contact.period / contact.mass
    if not rests:
        return parts_along(swing, loss, contact.period, least, rolls)
    while stays and least < MOST_PARTS and (swing / least) ** 4 * swing > _DRIFTS * loss:
        least += 1
    for parts in range(least, MOST_PARTS + 1):
        if swing < STIFFEST_AT_REST[parts]:
            return parts
    return 0


@kernel
def parts_along(swing: float, loss: float, period: float, least: int, rolls: bool) -> int:
    """Return the parts of a sample (s), `least` or more, that follow what rolls, slides or strikes, by its swing and by
    its loss under its weight; 0 if no number does. A roll may push with twice that, and then loses twice as much;
    within -50 dB that does no harm."""
    if rolls and least > 1:
        loss *= 2.0
    swings = swing * min(IN_STEP / period, 1.0 / max(loss, period))
    bound: float = OUT_OF_STEP[1 if least > 1 else 0]
    least = max(least, 1)
    if period > LONGEST_PART:
        least = min(least + 1, MOST_PARTS)
    while least < MOST_PARTS and (swing / least) ** 4 * swings > STAYS:
        least += 1
    if least == MOST_PARTS and (swing / least) ** 4 * swings > bound:
        return 0
    for parts in range(least, MOST_PARTS + 1):
        if swing < STIFFEST[parts] and loss < LOSSIEST[parts]:
            return parts
    return 0


@kernel
def energy_at(contact: Coupled, swing: float) -> float:
    """Return the energy (J) that compresses a contact so far that it swings by so much (rad) in a sample, or by a
    little more than at rest."""
    if contact.a == 1.0:
        return math.inf
    rate = max(swing, _HARDER * swing_of(contact)) / contact.period
    deepest = (rate * rate * contact.mass / (contact.a * contact.k)) ** (1.0 / (contact.a - 1.0))
    energy: float = elastic(deepest, contact.k, contact.a)
    return energy


@kernel
def is_long(contact: Coupled) -> bool:
    """True if a blow lasts for so long that a block is worth its tables, and one part follows it within -60 dB."""
    return swing_of(contact) < _LONG


@kernel
def swing_of(contact: Coupled) -> float:
    """Return the swing of body and object on the contact, in rad a sample."""
    return math.sqrt(_stiffness(contact) / contact.mass) * contact.period


@kernel
def _stiffness(contact: Coupled) -> float:
    """Return the stiffness (N/m) of a contact under its weight, or as deep as its energy or its push compress it."""
    if contact.rest_force > 0.0:
        return stiffness_at_rest(contact)
    energy = elastic(contact.motion[0], contact.k, contact.a) + 0.5 * contact.m * contact.v * contact.v
    deepest = ((contact.a + 1.0) * energy / contact.k) ** (1.0 / (contact.a + 1.0))
    deepest = max(deepest, (max(contact.push, 0.0) / contact.k) ** (1.0 / contact.a))
    stiffness: float = contact.a * contact.k * deepest ** (contact.a - 1.0)
    return stiffness


@kernel
def stiffness_at_rest(contact: Coupled) -> float:
    """Return the stiffness (N/m) of a contact under its weight; 0 if it has none."""
    if contact.rest_force > 0.0:
        return contact.a * contact.rest_force / contact.rest_compression
    return 0.0
