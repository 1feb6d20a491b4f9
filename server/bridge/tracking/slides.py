"""Standing contacts that are heard as slides: how loud each may be; and its reports, which change only where that can
be heard.

The estimate of a slide's pressure is p = c L m v^1.5 (F/(m g))^0.5, in SI units: of a body of mass m, the lighter of
two, that slips or sweeps at v under a force F, its weight at least. L is the pressure of a blow of 1 N s on both, as
brief as one at 0.1 v. Rough ground makes a body's lowest point rise and fall by a share of v, the more often the faster
it is: so m v sqrt(v). The factor c, 0.12 for round bodies and 0.02 for faces, is fitted to be seldom too small: of
balls and boxes of all materials on plates, at 0.1 to 1 m/s, half are 3 to 22 dB fainter than it; on soft plates up to
55 dB, and one is 21 dB louder.
"""

import math

from ....dsp.native.jit import kernel, noinline_kernel
from ....dsp.numerics.constants import STANDARD_GRAVITY
from .blows import HEAVIEST, LIGHTEST, contact_radius, loudness_of, masked_at, time_of_contact
from .microphones import MicrophoneState, gain_at
from .skins import standing_curvature_of
from .state import AT, EVENTS, HEARD, LIE, LOAD, MOVE, POSITION, Pair, State
from .strips import place_on

RESTS = 0.004
"""m/s: a slower contact rests."""

_CHANGED, _AWAY = 0.05, 0.01  # shares of a speed or a force, and of a strike path, by which it must change to be sent
_LEAST = 1e-6  # m/s, N: a slide of 0 would end
_TINY = 1e-9  # m/s, m: nobody hears less; a speed or a place decays to 1e-150 in 2 s, which no export takes
_FASTEST, _HARDEST = 100.0, 1e5  # m/s, N
_ROUGH, _ROUGH_FLAT = 0.12, 0.02  # sqrt(s/m): of the estimate, for round bodies and for faces
_LOUDER = 2.0  # times as loud is what takes another's room; half as loud as what begins to be heard, a slide ends
_LIKELY = 0.3  # of the estimate: half of all slides are as faint, or fainter
_STAYS = 0.1  # s for which a slide is heard, at least; so often it is weighed
_RISING = 0.1  # share of its speed at which a body rises and falls
_FLAT = 0.002  # m: width of the contact of two faces, of which a corner carries at a time
_SEEDS = 2**31


@noinline_kernel
def pressure_of(state: State, microphones: MicrophoneState, pair: Pair) -> float:
    """Return the pressure (Pa rms) of a contact's slide at the microphone that hears it best, as an estimate.

    Of two bodies that are held it is infinite; of a pair that slides in a way of its own, it is 20 dB more.
    """
    lightness = max(state.lightness[pair.a], state.lightness[pair.b])
    if lightness == 0.0:
        return math.inf
    gain = 0.0
    for m in range(microphones.count):
        gain = max(gain, abs(gain_at(microphones, m, pair.point)))
    speed, weights = min(max(pair.now[0], pair.now[1]), _FASTEST), pair.now[2] * lightness / STANDARD_GRAVITY
    stiffness = state.law[state.material[pair.a], state.material[pair.b]][0]
    curvature, is_round = standing_curvature_of(state, pair.a, pair.b, pair.local)
    stiffness *= math.sqrt(contact_radius(curvature))
    lasting = time_of_contact(1.0 / lightness, stiffness, _RISING * speed)
    struck = loudness_of(state, pair.a, lasting) + loudness_of(state, pair.b, lasting)
    rough = _ROUGH if is_round else _ROUGH_FLAT
    rough *= 10.0 if state.slides_so[pair.a, pair.b] == 1 else 1.0
    return rough * gain * struck * speed * math.sqrt(speed * max(weights, 1.0)) / lightness


@kernel
def is_too_faint(state: State, microphones: MicrophoneState, pair: Pair) -> bool:
    """Weigh a slide, if it was not of late; true if nobody hears it any more."""
    if state.time - pair.weighed_at < _STAYS:
        return False
    pair.pressure, pair.weighed_at = pressure_of(state, microphones, pair), state.time
    return _LOUDER * pair.pressure < state.faintest


@kernel
def is_masked(state: State, pair: Pair) -> bool:
    """True if nobody is likely to hear a slide beside the blows of late; for a while, if it is as loud as estimated."""
    likely = _LIKELY if state.time - pair.moved_at < _STAYS else 1.0
    return likely * pair.pressure < masked_at(state, state.time)


@kernel
def fainter_slide(state: State, pair: Pair) -> int:
    """Return the number of the faintest pair whose slide is heard, has been for a while, and is fainter by far; else
    -1."""
    faintest, pressure = -1, pair.pressure / _LOUDER
    for i in range(state.touching):
        other = state.pairs[i]
        if other.moves == HEARD and other.pressure < pressure and state.time - other.heard_at >= _STAYS:
            faintest, pressure = i, other.pressure
    return faintest


@kernel
def is_noticed(state: State, pair: Pair) -> bool:
    """True if a speed, the force or the place has changed by so much since it was reported that it is heard."""
    for k in range(3):
        floor = RESTS if k < 2 else 1e-6
        if abs(pair.now[k] - pair.said[k]) > _CHANGED * max(abs(pair.said[k]), floor):
            return True
    return _has_moved(state, pair)


@kernel
def _has_moved(state: State, pair: Pair) -> bool:
    """True if a slide is elsewhere on the body that is slid on than it was reported."""
    body = pair.b if pair.side == 1 else pair.a
    if state.surfaced[body] == 0:
        return abs(motion_of(state, pair, POSITION) - pair.steered[POSITION]) > _AWAY
    away = 0.0
    for k in range(3):
        away = max(away, abs(motion_of(state, pair, AT + k) - pair.steered[AT + k]))
    return away > _AWAY * state.reach[body]


@kernel
def steer_slide(state: State, pair: Pair) -> None:
    """Report changes of a slide since the last report: its slip and its sweep (m/s), its force (N), its place."""
    pair.told_at = state.time
    for k in range(3):
        pair.said[k] = pair.now[k]
    for parameter in range(POSITION):
        change = abs(motion_of(state, pair, parameter) - pair.steered[parameter])
        if change > _CHANGED * max(pair.steered[parameter], RESTS):
            _steer(state, pair, parameter)
    if _has_moved(state, pair):
        if state.surfaced[pair.b if pair.side == 1 else pair.a] == 1:
            for k in range(3):
                _steer(state, pair, AT + k)
        else:
            _steer(state, pair, POSITION)


@kernel
def _steer(state: State, pair: Pair, parameter: int) -> None:
    """Report a parameter of a slide, if there is room."""
    if state.changed < EVENTS:
        pair.steered[parameter] = motion_of(state, pair, parameter)
        change = state.changes[state.changed]
        change.slide, change.gesture = pair.slide, pair.gesture
        change.parameter, change.value = parameter, pair.steered[parameter]
        state.changed += 1


@kernel
def steer_load(state: State, pair: Pair) -> None:
    """Report the load (N) of a contact that lies, if it is other than it was reported."""
    load = motion_of(state, pair, 2)
    if abs(load - pair.load) > _CHANGED * pair.load and state.changed < EVENTS:
        pair.told_at, pair.load = state.time, load
        change = state.changes[state.changed]
        change.slide, change.gesture = pair.slide, pair.gesture
        change.parameter, change.value = LOAD, load
        state.changed += 1


@kernel
def motion_of(state: State, pair: Pair, parameter: int) -> float:
    """Return a parameter of STEERED of a contact, within what a slide takes."""
    if parameter == 0:
        return min(max(pair.now[0], _LEAST), _FASTEST)
    if parameter == 1:
        sweep = pair.sweep[pair.side]  # of 0 it stays, as under a bow
        return 0.0 if sweep == 0.0 else min(max(sweep, _TINY), _FASTEST)
    if parameter == 2:
        return min(max(pair.now[2], _LEAST), _HARDEST)
    if parameter >= AT:
        at = pair.local[pair.side, parameter - AT]
        return at if abs(at) >= _TINY else 0.0
    body = pair.b if pair.side == 1 else pair.a
    return place_on(state.strip[body], state.edges[body], pair.local[pair.side])


@noinline_kernel
def find_slides(state: State) -> None:
    """Say how those contacts slide or lie that begin to."""
    for n in range(state.happened):
        event = state.events[n]
        if event.kind == MOVE or event.kind == LIE:
            a, b = event.a, event.b
            law = state.law[state.material[a], state.material[b]]
            curvature, is_round = standing_curvature_of(state, a, b, event.local)
            event.radius = contact_radius(curvature)
            event.stiffness, event.exponent = law[0] * math.sqrt(event.radius), law[2]
            if event.kind == MOVE:
                event.mass = min(max(1.0 / max(state.lightness[a], state.lightness[b]), LIGHTEST), HEAVIEST)
            event.patch = 0.0 if is_round else _FLAT
            event.seed = (state.seed + event.slide) % _SEEDS
            slides, under = (a, b) if event.side == 1 else (b, a)
            if event.kind == LIE:
                event.motion[POSITION] = place_on(state.strip[under], state.edges[under], event.local[event.side])
            event.by_place = place_on(state.strip[slides], state.edges[slides], event.local[1 - event.side])
