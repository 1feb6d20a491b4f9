"""Blows: how hard each is, by which law, and whether it is heard.

A blow of an impulse J is heard as the pressure that J leaves in the modes of both bodies, at the microphone that hears
them best. Blows that are too faint to hear, or masked by those of late, are left out; of more than the most at once the
loudest are taken.
"""

import math

from ....dsp.bodies.material import CONTACT_RADIUS
from ....dsp.contact.estimate import LONGEST_CONTACT, longest_estimate
from ....dsp.contact.law import restitution_of
from ....dsp.native.jit import kernel, noinline_kernel
from ....dsp.native.typed import View2D
from ....dsp.schema import MASS
from .grains import is_of_grains, pile_up
from .microphones import MicrophoneState
from .points import along
from .skins import curvature_of
from .state import EVENTS, HIT, OCTAVES, Blow, State
from .strips import corner_of, place_on

_IN = 0.05  # s: the time over which blows are counted
_RECENT = 0.1  # s: what was louder so lately hides what is fainter
_DULLEST = 0.02  # restitution: with less, a blow would hardly end
_FASTEST = 1e3  # m/s
LIGHTEST, HEAVIEST = MASS.low, MASS.high  # kg
_SHARPEST, _FLATTEST = 1e-4, 10.0  # m: radii of contacts


@noinline_kernel
def judge_blows(state: State) -> int:
    """Weigh the blows of a step, the loudest first, and say which are heard: how many."""
    count = state.struck
    for n in range(count):
        state.order[n] = n
        k = n
        while k > 0 and state.blows[state.order[k - 1]].pressure < state.blows[n].pressure:
            state.order[k] = state.order[k - 1]
            k -= 1
        state.order[k] = n
    while state.heard_blows > 0 and state.heard_at[state.oldest] < state.time - _IN:
        state.oldest = (state.oldest + 1) % EVENTS
        state.heard_blows -= 1
    room = min(state.most_blows, EVENTS) - state.heard_blows
    found = 0
    for n in range(count):
        blow = state.blows[state.order[n]]
        state.hits += 1
        blow.heard = 0
        if is_of_grains(state, blow.a, blow.b):
            pile_up(state, blow)
        elif blow.rings == 0 or not _is_heard(state, blow.pressure, blow.time):
            state.faint += 1
        elif room <= 0:
            state.over_budget += 1
            state.loudest_unheard = max(state.loudest_unheard, blow.pressure)
        else:
            room -= 1
            found += 1
            blow.heard = 1
            state.heard_at[(state.oldest + state.heard_blows) % EVENTS] = blow.time
            state.heard_blows += 1
    return found


@kernel
def _is_heard(state: State, pressure: float, time: float) -> bool:
    """True if a contact of a pressure (Pa rms at a microphone) is heard at a time (s), after those asked of."""
    if pressure < max(state.faintest, masked_at(state, time)):
        return False
    if pressure >= state.loudest or not _is_recent(state, time):
        state.loudest, state.loudest_at = pressure, time
    return True


@kernel
def masked_at(state: State, time: float) -> float:
    """Return the pressure (Pa rms) below which nothing is heard at a time (s) beside what was heard of late."""
    return state.loudest * state.masked if _is_recent(state, time) else 0.0


@kernel
def _is_recent(state: State, time: float) -> bool:
    return time - state.loudest_at < _RECENT


@noinline_kernel
def find_blows(state: State) -> None:
    """Make blows of a step's hits."""
    state.struck = 0
    for n in range(state.happened):
        event = state.events[n]
        if event.kind == HIT:
            blow = state.blows[state.struck]
            blow.a, blow.b, blow.side, blow.contact, blow.time = event.a, event.b, event.side, event.contact, event.time
            blow.speed, blow.mass, blow.restitution = event.speed, event.mass, event.restitution
            blow.impulse = event.impulse
            for k in range(3):
                blow.point[k], blow.normal[k] = event.point[k], event.normal[k]
                blow.local[0, k], blow.local[1, k] = event.local[0, k], event.local[1, k]
            for k in range(3):
                blow.facing[0, k] = along(state, blow.a, blow.normal, k)
                blow.facing[1, k] = 0.0 - along(state, blow.b, blow.normal, k)
            _find_law(state, blow, event.local)
            for side in range(2):
                body = event.b if side == 1 else event.a
                blow.place[side] = place_on(state.strip[body], state.edges[body], event.local[side])
            state.struck += 1


@kernel
def _find_law(state: State, blow: Blow, local: View2D[float]) -> None:
    """Find the law of a contact of two bodies at points in their axes: Hertz's, or that of their support."""
    support = state.support[blow.a, blow.b] - 1
    if support >= 0:
        soft = state.supports[support]
        blow.stiffness, blow.dissipation, blow.exponent = soft[0], soft[1], soft[2]
        return
    law = state.law[state.material[blow.a], state.material[blow.b]]
    corner = min(corner_of(state.edges[blow.a]), corner_of(state.edges[blow.b]))
    blow.stiffness = law[0] * math.sqrt(contact_radius(curvature_of(state, blow.a, blow.b, local), corner))
    blow.dissipation, blow.exponent = law[1], law[2]


@noinline_kernel
def weigh_blow(state: State, microphones: MicrophoneState, blow: Blow) -> None:
    """Find a blow's impulse and its pressure, from its speed, mass and restitution."""
    share, told = left_of(state, blow), not math.isnan(blow.restitution)
    speed, mass = blow.speed, blow.mass
    blow.restitution = share
    place = state.place[blow.a, blow.b] - 1
    if place >= 0:
        state.pairs[place].left = share * speed
    blow.impulse = mass * speed * (1.0 + share)
    lasting = time_of_contact(mass, blow.stiffness, speed)
    blow.pressure = 0.0
    for side in range(2):
        body = blow.b if side == 1 else blow.a
        blow.pressure += blow.impulse * loudness_of(state, body, lasting) * microphones.loudest[body]
    blow.met, blow.left = min(speed, _FASTEST), 0.0
    lost = blow.dissipation * blow.met
    if told:
        blow.dissipation, blow.left = 0.0, max(share, _DULLEST)
        lost = 1.5 * (1.0 - blow.left) / blow.left
    struck = blow.b if blow.side == 1 else blow.a
    blow.rings = 0
    if state.rings[struck] == 1 and LIGHTEST <= mass <= HEAVIEST:
        longest = longest_estimate(blow.met, mass, blow.stiffness, blow.exponent, lost)
        blow.rings = 1 if longest <= LONGEST_CONTACT else 0
    if blow.rings == 0:
        blow.pressure = 0.0


@kernel
def left_of(state: State, blow: Blow) -> float:
    """Return the share of its speed that a blow leaves: of the pair, as it was reported, or by its law."""
    own = state.bounce[blow.a, blow.b]
    if own > 0.0:
        blow.restitution = own - 1.0
    if math.isnan(blow.restitution):
        return restitution_of(blow.dissipation * blow.speed)
    return min(max(blow.restitution, 0.0), 1.0)


@kernel
def time_of_contact(mass: float, stiffness: float, speed: float) -> float:
    """Return the time (s) of a blow, by Hertz, without dissipation."""
    time: float = 3.218 * (mass * mass / (stiffness * stiffness * speed)) ** 0.2
    return time


@kernel
def loudness_of(state: State, body: int, lasting: float) -> float:
    """Return the pressure (Pa rms at 1 m) of a blow of 1 N s on a body, that lasts so long (s), as an estimate."""
    octave = min(max(math.log2(lasting) + (OCTAVES - 1), 0.0), OCTAVES - 1.001)
    low = int(octave)
    here = state.loudness[body, low]
    return here + (octave - low) * (state.loudness[body, low + 1] - here)


@kernel
def contact_radius(curvature: float, flat: float = CONTACT_RADIUS) -> float:
    """Return the radius (m) of a contact, within bounds. flat: of two faces; those that meet in a blow touch first by a
    corner of one."""
    return min(max(1.0 / curvature if curvature > 0.0 else flat, _SHARPEST), _FLATTEST)
