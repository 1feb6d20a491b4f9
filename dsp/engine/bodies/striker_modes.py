"""The modes of a striker that sounds: its click, and its ringing."""

import math

from ...native.jit import kernel
from ...numerics.constants import AIR_DENSITY, SPEED_OF_SOUND
from ...numerics.elementary import exp, log
from ...resonator.bank import Modes, top_of
from ...resonator.click import set_click
from ...resonator.coefficients import set_mode
from ...swarm.record import SIZES, Swarm
from ...swarm.ringing import clicks_apart
from ...swarm.times import FORM, uniform
from ..memory.records import Contact
from ..memory.state import State
from ..memory.striker_state import STRIKER_MODES, Striker, Voice

IRREGULAR = 0.12
"""Share of their frequencies by which the modes of pieces are off those of a regular shape, at most (estimated)."""
TOUCHED = 30.0
"""1/s: the decay rate that other pieces and the floor add to a piece's modes (estimated)."""
_IMPEDANCE = AIR_DENSITY * SPEED_OF_SOUND
AIR = 2.5
"""Power of the frequency as which small sheets radiate: so do Carom's free plates of 15 to 180 mm of glass of 1.2 to
4 mm, within 2 dB down to a quarter of the usual piece's frequency, and 5 dB to a ninth."""
SQUARE = 13.49
"""omega a^2 sqrt(rho h/D) of a free square sheet's first mode (Leissa, Vibration of Plates, 1969)."""


@kernel
def modes_of_voice(voice: Voice) -> Modes:
    """Return the modes of a voice."""
    n = voice.size
    return Modes(voice.y1[:n], voice.y2[:n], voice.a1[:n], voice.a2[:n], voice.balance[:n], voice.response)


@kernel
def rescale(state: State, voice: Voice, contact: Contact, size: int, ratio: float) -> None:
    """Retune a new voice to a grain, number `size` of its swarm's, that is larger than the striker by a ratio.

    A grain of the same form has frequencies and decays as the ratio's inverse, and is heard by a force as the ratio. A
    piece of what breaks is a sheet as thick as the others: its area goes as its mass, the ratio's third power, and the
    frequencies of its bending as the inverse of that. A larger one radiates less by them. No piece is a square or a
    disc: its modes are apart by up to IRREGULAR of what these have, and others that it touches damp it, too. The click
    of what rings is a voice of its own, from number SIZES on: all of a blow moves that, but not the modes.
    """
    striker, modes, swarm = state.strikers[contact.sound], modes_of_voice(voice), state.swarms[contact.swarm]
    breaks, apart, clicks = contact.trait.breaks == 1, clicks_apart(swarm), size >= SIZES
    area = ratio * ratio * (ratio if breaks else 1.0)
    edge = math.sqrt(area)
    for i in range(striker.size):
        lower, more, louder = edge, 0.0, 1.0
        if breaks and i >= striker.clicks:
            uneven = 2.0 * uniform(swarm, size * STRIKER_MODES + i, FORM) - 1.0
            lower = area * (1.0 + IRREGULAR * uneven)
            more, louder = in_air(striker, swarm, i, lower)
            more += TOUCHED
        frequency, sigma = striker.frequency[i] / lower, striker.sigma[i] / lower + more
        weight = striker.weight[i] * area / lower * louder
        if i < striker.clicks:
            if i == 0:
                set_click(modes, i, frequency, sigma, state.rate, weight if clicks or not apart else 0.0)
        elif 0.0 < frequency < top_of(state.rate) and not clicks:
            turned = complex(-sigma / (2.0 * math.pi * frequency), 1.0)
            set_mode(modes, i, frequency, sigma, state.rate, weight * turned)
        else:
            set_mode(modes, i, 0.0, 0.0, state.rate, 0.0j)


@kernel
def in_air(striker: Striker, swarm: Swarm, i: int, lower: float) -> tuple[float, float]:
    """Return by how much more (1/s) a piece's mode decays, which is lower by a ratio than the usual piece's, than in
    that ratio, and the factor on how loud it is: by what it radiates.

    The usual piece's first mode is that of a free square plate, which gives its coincidence. A mode radiates no more
    than it loses, even where a gesture says another mass than the striker's.
    """
    radiates = 2.0 * math.pi * striker.weight[i] * striker.weight[i] / (_IMPEDANCE * swarm.bending * swarm.usual)
    usual = min(radiates, striker.sigma[i])
    if usual == 0.0:
        return 0.0, 1.0
    square, turned = math.pi * swarm.wide * swarm.wide * swarm.usual, SPEED_OF_SOUND / (2.0 * math.pi)
    coincidence = SQUARE * turned * turned / (striker.frequency[striker.clicks] * square)
    radiated = radiated_by(usual, _IMPEDANCE * square / swarm.usual, coincidence / striker.frequency[i], lower)
    return radiated - usual / lower, math.sqrt(radiated * lower / usual)


@kernel
def radiated_by(usual: float, most: float, coincidence: float, lower: float) -> float:
    """Return the decay rate (1/s) by what a sheet's mode radiates, which is lower by a ratio than one of `usual`.

    most: rho c over the mass per area, where each side pushes the air in front of it. Below its coincidence (in the
    usual mode's frequency) the air flows from side to side, and the rate goes as the frequency to the power AIR.
    """
    radiated: float = most / (1.0 + max(most / usual - 1.0, exp(AIR * log(coincidence))) * exp(AIR * log(lower)))
    return radiated


@kernel
def prepare(striker: Striker, rate: float) -> None:
    """Compute the coefficients of a kind of striker, before a contact with it begins.

    Its modes sound in the phase of their velocity: a slow bend by the force is not heard. Where there is a second pulse
    it alone moves them, and they begin at 0.
    """
    n = striker.size
    snaps = striker.momentum > 0.0
    modes = Modes(
        striker.struck[:n], striker.struck[:n], striker.a1[:n], striker.a2[:n], striker.struck[:n], striker.response
    )
    for i in range(n):
        striker.a2[i] = 0.0
    for i in range(n):
        frequency, sigma, weight = striker.frequency[i], striker.sigma[i], striker.weight[i]
        if i < striker.clicks:
            if i == 0:
                set_click(modes, i, frequency, sigma, rate, weight)
        elif frequency == 0.0:
            set_mode(modes, i, 0.0, 0.0, rate, 0.0j)
        elif snaps:
            set_mode(modes, i, frequency, sigma, rate, complex(weight, 0.0))
        else:
            set_mode(modes, i, frequency, sigma, rate, weight * complex(-sigma / (2.0 * math.pi * frequency), 1.0))
    for i in range(n):
        striker.snapped[i] = 1.0 if i >= striker.clicks and snaps else 0.0
        striker.struck[i] = 1.0 - striker.snapped[i]
    striker.prepared = 1
