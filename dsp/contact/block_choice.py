"""Which lasting contacts are solved in blocks (block.py).

What counts is by how much a contact swings in a sample, with all that moves on it, and what share of its speed it loses
in one. With p terms a swing of s rad falls (p!)^2/((2 p)! (2 p + 1)!) s^(2 p + 1) rad behind in each sample, as with
Gauss's method: Hairer, Norsett, Wanner, "Solving Ordinary Differential Equations I" (1993), II.7. It is to stay in step
until its loss ends it. A kink of the path under a loss of more than all leaves an error that only shorter steps make
less. Stiffer contacts, and those that lose more, go by steps (coupled.py), if there is time for these.
"""

import math

from ..native.jit import kernel
from .block_records import TERMS
from .coupled_records import Coupled
from .law import compression_at, compression_of_energy, elastic, stiffness_at

IN_STEP = 20e-3
"""s: over which what rolls, slides or strikes is to stay in step, if its loss does not end a swing before."""

BEHIND = math.factorial(TERMS) ** 2 / (math.factorial(2 * TERMS) * math.factorial(2 * TERMS + 1))
"""That factor."""

OUT_OF_STEP = 2e-3
"""rad by which a contact may fall behind: half of it is its error in the end, and -60 dB."""

STIFFEST, STIFFEST_AT_REST = 2.2, 3.6
"""rad of a contact's swing in a sample up to which a block follows; and of a rest's, which hardly leaves its
stiffness."""

LOSSIEST = 1.0
"""The share of its speed that a contact loses in a sample, up to which one does."""

LANDS, HARDER = 1.2, 1.2
"""rad of the swing at the greatest depth up to which a block follows what lands harder than ever; or times that at
rest."""

EASED = 0.7
"""The same from which on the last term is damped (`settle_tables`)."""

SOFTEST, SMOOTHEST, CALMEST = 0.6, 0.5, 0.3
"""rad of the swing in a sample up to which three terms do to -60 dB (at 0.67 a rough roll errs by -59.8 dB); the share
of the speed lost in one, over that swing, where a path has kinks; and that share where there are none, at rest."""

LONG = 0.1
"""rad of a blow's swing up to which a block is worth its tables: it lasts for 30 samples on a wall."""


@kernel
def is_followed(contact: Coupled, rests: bool) -> bool:
    """True if a block follows a contact as stiff as it is under its weight, or gets with its energy. rests: it is a
    rest."""
    swing = swing_of(contact)
    return swing < STIFFEST_AT_REST if rests else follows(swing, loss_of(contact), contact.period)


@kernel
def follows(swing: float, loss: float, period: float) -> bool:
    """True if a block follows what rolls, slides or strikes, by its swing and loss in a sample (s)."""
    samples = min(IN_STEP / period, 1.0 / max(loss, period))
    return swing < STIFFEST and loss < LOSSIEST and BEHIND * swing ** (2.0 * TERMS + 1.0) * samples < OUT_OF_STEP


@kernel
def is_soft(contact: Coupled, rests: bool) -> bool:
    """True if three terms follow a contact. rests: it is a rest."""
    swing = swing_of(contact)
    return swing < SOFTEST and loss_of(contact) < (CALMEST if rests else SMOOTHEST * swing)


@kernel
def is_eased(contact: Coupled) -> bool:
    """True if a contact loses so much in a sample, or swings so far, that its last term is damped."""
    return loss_of(contact) > EASED or swing_of(contact) > STIFFEST_AT_REST


@kernel
def loss_of(contact: Coupled) -> float:
    """Return the share of its speed that a contact takes in a sample under its weight."""
    return contact.mu * contact.rest_force * contact.period / contact.mass


@kernel
def swing_of(contact: Coupled) -> float:
    """Return the swing of body and object on the contact, in rad a sample: under its weight, or as deep as its energy
    or its push compress it."""
    if contact.rest_force > 0.0:
        stiffness = contact.a * contact.rest_force / contact.rest_compression
    else:
        energy = elastic(contact.motion[0], contact.k, contact.a) + 0.5 * contact.m * contact.v * contact.v
        deepest = compression_of_energy(energy, contact.k, contact.a)
        deepest = max(deepest, compression_at(max(contact.push, 0.0), contact.k, contact.a))
        stiffness = stiffness_at(deepest, contact.k, contact.a)
    return math.sqrt(stiffness / contact.mass) * contact.period
