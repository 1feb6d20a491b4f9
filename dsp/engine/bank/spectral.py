"""Objects in the spectral bank: they go there when they ring freely, and come back when something is done to them.

A phase of the bank begins a block of FRAMES in every eighth quantum, with the objects that are in it then. Their modes
go from here to there and back exactly, at a quantum's beginning. All this depends on the frames' numbers and on
commands alone, and so do the bits.
"""

from ...native.jit import kernel, noinline_kernel
from ...spectral.layout import PHASES
from ...spectral.places import empty_phase, has_room, put_in_order
from ...spectral.synthesis import sum_bins, synthesize
from ..bodies.sheets import is_bent
from ..memory.channels import ask_gains
from ..memory.order import wake
from ..memory.quality import is_left_out
from ..memory.state import FADES, QUANTUM, Object, State
from ..output.fade import fade_length, left_of
from ..output.mix import sides_of
from .spectral_modes import come_back, go, look, take_form
from .tails import ring_tails

_WORTH = 640  # modes that must ring freely for the bank to be used: below, one sample at a time is as cheap
_UNWORTHY = 256  # modes in the bank below which all come back
_UNEVEN = 32  # a phase takes no more objects when it has this share of the mean more modes than that
_FULL = 65_536  # modes in a phase: more, and they are shared among twice as many phases
_CALM = 512  # frames that an object must have been left alone
_BUDGET = 2_048  # modes that go, that come back and that change their form in a quantum, unless they are touched
_SETTLED = 1e-7  # of a gain: a glide is over
_INAUDIBLE = 1e-9  # gain: the same


@noinline_kernel
def recall_objects(state: State) -> None:
    """Bring modes back that are touched in this quantum, and those that are to change, as many as the budget allows."""
    left = 0 if state.spectral.modes >= _UNWORTHY else _UNWORTHY
    while left > 0 and state.ringer_count > 0 and state.spectral.fading == 0:
        slot = state.ringers[state.ringer_count - 1]
        wake(state, slot)
        come_back(state, state.objects[slot])
    budget = _BUDGET
    for i in range(state.active):
        obj = state.objects[state.order[i]]
        if obj.has_contact == 1:
            # Bring the modes of those objects back that strike an object which is touched.
            index = obj.contact
            while index >= 0:
                slot = state.contacts[index].point[1].slot
                if slot >= 0 and state.objects[slot].spectral > 0:
                    come_back(state, state.objects[slot])
                index = state.contacts[index].next
        if obj.spectral == 0:
            continue
        if obj.has_contact == 1 or obj.sensors > 0 or obj.line > 0:
            come_back(state, obj)
        elif budget > 0 and (obj.returns == 1 or obj.stale_modes > 0 or obj.leaving == FADES):
            budget -= obj.live
            come_back(state, obj)


@noinline_kernel
def ring_bank(state: State) -> None:
    """Begin the block of the phase whose turn it is, with the objects that ring freely now."""
    spectral = state.spectral
    turn = state.position // QUANTUM % PHASES
    phase = spectral.phases[turn]
    if spectral.fading == 0:
        take_form(state, _BUDGET)
        _go(state, turn)
        look(state)
        put_in_order(spectral, _BUDGET, state.bank.place)
    if phase.modes == 0:
        if phase.sounds == 1:  # else its memory is left alone: it lies apart from all that a small scene touches
            phase.sounds = 0
        return
    chunks, singles, weights = spectral.chunks, spectral.singles, spectral.weights
    sum_bins(chunks, singles, weights, phase.single, phase.start, phase.count, spectral.sums)
    synthesize(spectral.sums, spectral.points[0], spectral.points[1], phase.out)
    phase.begin, phase.sounds = state.position, 1


@noinline_kernel
def mix_bank(state: State) -> None:
    """Add the bank's sound to the mix, without what has left it."""
    spectral, output = state.spectral, state.output
    sounds = state.tails.count > 0
    for p in range(PHASES):
        sounds |= spectral.phases[p].sounds == 1
    if sounds:
        # Add what the phases have laid out for this quantum to the mix.
        out = state.scratch.bank
        for side in range(2):
            for n in range(QUANTUM):
                out[side, n] = 0.0
        for p in range(PHASES):
            phase = spectral.phases[p]
            if phase.sounds == 1:
                first = state.position - phase.begin
                for side in range(2):
                    for n in range(QUANTUM):
                        out[side, n] += phase.out[side, first + n]
        ring_tails(state, out)
        for side in range(sides_of(state)):
            for n in range(QUANTUM):
                left = left_of(state.rate, spectral.faded + n + 1) if spectral.fading == 1 else 1.0
                output.mix[side, n] += left * out[side, n]
        state.stats.live_modes += spectral.modes
        state.stats.sounding += max(state.ringer_count, spectral.fading)
    if spectral.fading == 1:
        # End a fade that is over.
        spectral.faded += QUANTUM
        if spectral.faded < fade_length(state.rate):
            return
        for p in range(PHASES):
            empty_phase(spectral, spectral.phases[p], state.bank.place)
        state.tails.count = 0
        spectral.fading = spectral.moving = 0


@kernel
def _go(state: State, turn: int) -> None:
    """Take the objects into a phase that ring freely, if they are worth it: as many as the budget allows."""
    if state.output.channels > 2 or state.output.stems_on == 1:
        return
    free = live = 0
    for i in range(state.active):
        live += state.objects[state.order[i]].live
    if live + state.spectral.modes < _WORTH:
        return
    for i in range(state.active):
        obj = state.objects[state.order[i]]
        free += obj.live if _rings_freely(state, obj) else 0
    total = free + state.spectral.modes
    # The number of phases that so many modes are shared among: each has a transform of its own, and a callback's work.
    phases = 1
    while phases < PHASES and total > phases * _FULL:
        phases *= 2
    if free == 0 or total < _WORTH or turn % (PHASES // phases) != 0:
        return
    phase = state.spectral.phases[turn]
    share = total // phases
    budget = _BUDGET
    for i in range(state.active):
        obj = state.objects[state.order[i]]
        if (
            budget > 0
            and phase.modes <= share + share // _UNEVEN
            and _rings_freely(state, obj)
            and has_room(phase, obj.live)
        ):
            budget -= obj.live
            go(state, state.order[i], turn)


@kernel
def _rings_freely(state: State, obj: Object) -> bool:
    """True if nothing but its own modes moves an object, and nothing has for a while."""
    if obj.live == 0 or obj.spectral > 0 or obj.has_contact == 1 or obj.voice >= 0 or obj.fading > 0:
        return False
    if obj.sensors > 0 or obj.line > 0 or is_bent(state, obj):
        return False
    if obj.stale_modes > 0 or obj.leaving == FADES or obj.stretch != 0.0 or obj.driven_modes > 0:
        return False
    since = max(obj.last_driven_at, obj.returned_at)
    if state.position - since < _CALM or is_left_out(state, obj):
        return False
    for side in range(2):
        if obj.static[side] != 0.0 or obj.static_before[side] != 0.0:
            return False
    ask_gains(state, obj)
    for side in range(sides_of(state)):
        asked = obj.place.asked[side]
        if abs(obj.place.gain[side] - asked) > _SETTLED * abs(asked) + _INAUDIBLE:
            return False
    return True
