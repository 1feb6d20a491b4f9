"""How objects sound: gains that glide, modes that are retuned, ring, are driven by contacts, and come to rest.

Objects that share a contact are rendered together, sample by sample; every other one for itself.
"""

import math

from ..native.jit import kernel
from ..resonator.bank import LANES, RESPONSES, set_mode, state_of
from .contacts import attend, drive, next_driven_frame
from .gestures import drop_all
from .objects import highest_of, sigma_of
from .quality import choose_newest, is_left_out, silence_of
from .rolls import ring_on
from .state import QUANTUM

_GLIDE = 0.005  # s: time constant of gain and pan
_RETUNE_BUDGET = 1024  # modes a quantum that get new coefficients in the background
_FADE = 500.0  # 1/s: decay added to a mode that was tuned above the Nyquist share
_FADED = 1e-6  # gain (-120 dB) at which an object's fade is over
_HUGE = 1e30  # above this a voice counts as not finite


@kernel
def attend_all(state):
    """Bring objects and their contacts to a new quantum."""
    for i in range(state.active):
        obj = state.objects[state.order[i]]
        obj.struck = obj.tied = obj.driven = 0
        obj.rolled = -1
        for channel in range(2):
            obj.lean_before[channel], obj.lean[channel] = obj.lean[channel], 0.0
    choose_newest(state)
    for i in range(state.active):
        attend(state, state.objects[state.order[i]])


@kernel
def render_all(state):
    """Add all voices to the mix: first the objects that share contacts, then each other one."""
    for turn in range(-1, state.active):
        state.group_size = 0
        for i in range(0 if turn < 0 else turn, state.active if turn < 0 else turn + 1):
            slot = state.order[i]
            if (state.objects[slot].tied == 1) == (turn < 0):
                state.group[state.group_size] = slot
                state.group_size += 1
        _render_group(state)


@kernel
def _render_group(state):
    """Add the voices of the objects in `group` to the mix, if any of them has one."""
    awake = False
    for g in range(state.group_size):
        obj = state.objects[state.group[g]]
        _glide(state, obj)
        awake |= obj.live > 0 or obj.struck == 1
    if not awake:
        return
    frame = 0
    while frame < QUANTUM:
        # The modes answer a force in the first frame that they ring after it.
        stop = QUANTUM
        for g in range(state.group_size):
            obj = state.objects[state.group[g]]
            if obj.contact >= 0:
                drive(state, obj, frame)
                stop = min(stop, next_driven_frame(state, obj, frame + 1))
        for g in range(state.group_size):
            ring_on(state, state.objects[state.group[g]], state.voices[g], frame, stop)
        frame = stop
    for g in range(state.group_size):
        _mix(state, state.objects[state.group[g]], state.voices[g])


@kernel
def _glide(state, obj):
    """Bring an object's gains nearer to what amplitude and pan ask for."""
    c = math.exp(-QUANTUM / (_GLIDE * state.rate))
    left, right = pan_gains(obj)
    if obj.dying == 2 or is_left_out(state, obj):
        left = right = 0.0
    elif obj.live == 0:
        obj.gain[0], obj.gain[1] = left, right  # nobody hears it glide
    obj.gain_before[0], obj.gain_before[1] = obj.gain[0], obj.gain[1]
    obj.gain[0] = left + (obj.gain[0] - left) * c
    obj.gain[1] = right + (obj.gain[1] - right) * c


@kernel
def is_faded(obj):
    """Are its gains as good as 0?"""
    return max(abs(obj.gain[0]), abs(obj.gain[1])) < _FADED


@kernel
def _mix(state, obj, voice):
    """Add an object's voice to the mix; one that is not finite is silenced."""
    left = voice[0]
    right = voice[1]
    finite = True
    for n in range(QUANTUM):
        finite &= abs(left[n]) < _HUGE and abs(right[n]) < _HUGE
    if not finite:
        state.faults += 1
        obj.faults += 1
        silence(state, obj)
        return
    from_left, from_right = obj.gain_before[0], obj.gain_before[1]
    step_left = (obj.gain[0] - from_left) / QUANTUM
    step_right = (obj.gain[1] - from_right) / QUANTUM
    lean_left, lean_right = obj.lean_before[0], obj.lean_before[1]
    more_left = (obj.lean[0] - lean_left) / QUANTUM
    more_right = (obj.lean[1] - lean_right) / QUANTUM
    for n in range(QUANTUM):
        state.mix[0, n] += (left[n] - lean_left - (n + 1) * more_left) * (from_left + (n + 1) * step_left)
        state.mix[1, n] += (right[n] - lean_right - (n + 1) * more_right) * (from_right + (n + 1) * step_right)
    state.live_modes += obj.live
    state.sounding += 1
    if obj.driven > 0:
        obj.touched = state.position
    if obj.driven == 0 and is_left_out(state, obj) and is_faded(obj):
        _hush(state, obj)  # what bounces on it goes on
    else:
        _rest(state, obj)


@kernel
def retune_all(state):
    """Give modes their coefficients: what is struck all of them now, the rest in turn, as many as the budget allows."""
    budget = _RETUNE_BUDGET
    turn = state.position // QUANTUM
    for i in range(state.active):
        obj = state.objects[state.order[(i + turn) % state.active]]
        struck = obj.struck == 1
        count = obj.stale if struck else min(obj.stale, budget)
        budget -= 0 if struck else count
        _retune(state, obj, count)


@kernel
def _retune(state, obj, count):
    """Bring the next `count` modes of an object to its tune, decay and damp."""
    first = obj.first
    last = first + obj.size
    response = state.response[first // LANES * RESPONSES : last // LANES * RESPONSES]
    highest = highest_of(state)
    for _ in range(count):
        i = obj.retuning
        frequency = state.frequency[first + i] * obj.tune
        sigma = sigma_of(state, obj, i)
        weight = state.weight[first + i]
        if frequency > highest:
            # Nothing excites it any more, and what it was ringing fades.
            frequency = highest
            sigma += _FADE
            weight = 0.0
        set_mode(
            i, frequency, sigma, state.rate, weight,
            state.y1[first:last], state.y2[first:last], state.a1[first:last], state.a2[first:last], response,
        )  # fmt: skip
        obj.retuning = (i + 1) % obj.size
    obj.stale -= count


@kernel
def _rest(state, obj):
    """Put the last groups of live modes to rest that nobody hears any more: at most two groups a quantum."""
    threshold = silence_of(state)
    for _ in range(2):
        if obj.live <= obj.driven:
            return
        first = obj.first + obj.live - LANES
        heard = False
        for i in range(first, first + LANES):
            if state.a2[i] != 0.0:
                re, im = state_of(state.y1[i], state.y2[i], state.a1[i], state.a2[i])
                weight = max(1.0, abs(state.balance[i])) * max(1.0, obj.amplitude)
                heard |= weight * weight * (re * re + im * im) > threshold * threshold
        if heard:
            return
        for i in range(first, first + LANES):
            state.y1[i] = 0.0
            state.y2[i] = 0.0
        obj.live -= LANES


@kernel
def silence(state, obj):
    """End an object's sound and all gestures on it."""
    _hush(state, obj)
    drop_all(state, obj)


@kernel
def _hush(state, obj):
    for i in range(obj.first, obj.first + obj.size):
        state.y1[i] = 0.0
        state.y2[i] = 0.0
    obj.live = 0
    for channel in range(2):
        obj.lean[channel] = obj.lean_before[channel] = 0.0


@kernel
def pan_gains(obj):
    """Left and right gain: equal power, 1 in the middle."""
    angle = 0.25 * math.pi * (obj.pan + 1.0)
    gain = obj.amplitude * math.sqrt(2.0)
    return gain * math.cos(angle), gain * math.sin(angle)
