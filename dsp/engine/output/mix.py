"""The mix: an object's voice with its gains on every channel, and its share of the sum."""

import math

from ...native.jit import kernel
from ...native.typed import View, View2D
from ..memory.capacity import STEMS
from ..memory.channels import ask_gains
from ..memory.quality import is_left_out
from ..memory.state import FADES, QUANTUM, Object, State

_GLIDE = 0.005  # s: time constant of gains
_FADED = 1e-6  # gain (-120 dB) at which an object's fade is over
_HUGE = 1e30  # above this a voice counts as not finite


@kernel
def clear_mix(state: State) -> None:
    """Begin a quantum with silence, also in the stems of objects that no longer sound."""
    output = state.output
    for channel in range(output.channels):
        for n in range(QUANTUM):
            output.mix[channel, n] = 0.0
    if output.stems_on == 0:
        return
    if output.delay > 0:
        output.turn = 1 - output.turn
    for slot in range(STEMS):
        if output.stem_sounds[output.turn, slot] == 1:
            output.stem_sounds[output.turn, slot] = 0
            for channel in range(output.channels):
                for n in range(QUANTUM):
                    output.stems[output.turn, slot, channel, n] = 0.0


@kernel
def glide_gains(state: State, obj: Object) -> None:
    """Bring an object's gains nearer to their targets."""
    ask_gains(state, obj)
    place = obj.place
    fades = obj.leaving == FADES or is_left_out(state, obj)
    unheard = not fades and obj.live == 0 and obj.fading == 0 and obj.voice < 0  # nobody would hear it glide
    for channel in range(state.output.channels):
        asked = 0.0 if fades else place.asked[channel]
        if unheard:
            place.gain[channel] = asked
        place.before[channel] = place.gain[channel]
        place.gain[channel] = _glided(state, place.gain[channel], asked)


@kernel
def _glided(state: State, gain: float, asked: float) -> float:
    """Return a gain a quantum later, on its way to the one that is requested: most are there."""
    return asked if gain == asked else asked + (gain - asked) * math.exp(-QUANTUM / (_GLIDE * state.rate))


@kernel
def glide_gain(state: State) -> None:
    """Give the mix and all stems the gain of everything: it glides where something sounded, else it is there."""
    output = state.output
    asked, before = state.choices.gain, output.gain[1]
    if output.silent == 1:
        before = asked
    output.silent = int(state.stats.sounding == 0)
    now = _glided(state, before, asked)
    output.gain[0], output.gain[1] = before, now
    if before == 1.0 and now == 1.0:
        return
    for channel in range(output.channels):
        _scale(output.mix[channel], before, now)
    if output.stems_on == 1:
        for slot in range(STEMS):
            for channel in range(output.channels if output.stem_sounds[output.turn, slot] == 1 else 0):
                _scale(output.stems[output.turn, slot, channel], before, now)


@kernel
def _scale(sound: View[float], before: float, now: float) -> None:
    """Give a quantum of sound a gain that goes from one value to another."""
    step = (now - before) / QUANTUM
    for n in range(QUANTUM):
        sound[n] *= before + (n + 1) * step


@kernel
def is_faded(state: State, obj: Object) -> bool:
    """True if an object's gains are as good as 0."""
    loudest = 0.0
    for channel in range(state.output.channels):
        loudest = max(loudest, abs(obj.place.gain[channel]))
    return loudest < _FADED


@kernel
def is_finite(state: State, voice: View2D[float]) -> bool:
    """True if a voice is made of numbers."""
    sides, finite = sides_of(state), 0
    for side in range(sides):
        for n in range(QUANTUM):
            finite += 1 if abs(voice[side, n]) < _HUGE else 0  # counted in lanes, where an `and` is not
    return finite == sides * QUANTUM


@kernel
def sides_of(state: State) -> int:
    """Return the sides of a voice that are heard: left and right of two channels, else the first."""
    return 2 if state.output.channels == 2 else 1
