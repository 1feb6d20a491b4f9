"""What is left out when there is too little time, by the quality that is asked for (state.Quality).

Gestures that last have time stand still for them where only the newest may go on: those sent or steered last.
"""

from ..native.jit import kernel
from .state import COUPLED_MODES, Command, Quality

COARSER = 4.0
"""Times the shortest wavelength that rolls feel else: about as loud, at 60 % of the cost."""

_ROLL, _PRESS = int(Command.ROLL), int(Command.PRESS)
_HELD, _QUIET, _COARSE, _RECENT, _NEWEST = (
    int(Quality.HELD), int(Quality.QUIET), int(Quality.COARSE), int(Quality.RECENT), int(Quality.NEWEST_32),
)  # fmt: skip

_SILENCE = 1e-6  # output amplitude (-120 dB) below which a mode is put to rest
_LOUDER_SILENCE = 1e-4  # the same (-80 dB) from QUIET on
_FEW = 256  # modes of an object, the longest ringing, that what lasts acts on from COARSE on; a multiple of LANES
_RECENTLY = 0.5  # s
_VOICES = 32  # gestures that go on at NEWEST_32; each further step halves them


@kernel
def holds_steps(state):
    """Do coupled contacts take one step a sample, and the closed form where that is within -40 dB?"""
    return state.quality >= _HELD


@kernel
def silence_of(state):
    """Output amplitude below which a mode is put to rest."""
    return _LOUDER_SILENCE if state.quality >= _QUIET else _SILENCE


@kernel
def coarseness_of(state):
    """Factor on the shortest wavelength that rolls feel."""
    return COARSER if state.quality >= _COARSE else 1.0


@kernel
def modes_for(state, obj, kind):
    """How many of an object's modes a gesture of this kind acts on."""
    lasts = kind in (_ROLL, _PRESS)
    return min(obj.size, _FEW) if lasts and state.quality >= _COARSE else obj.size


@kernel
def is_left_out(state, obj):
    """Is there time only for objects that were touched more recently?"""
    return state.quality >= _RECENT and obj.struck == 0 and state.position - obj.touched > _RECENTLY * state.rate


@kernel
def room_for_coupling(state):
    """Modes that may be coupled to contacts at once."""
    return COUPLED_MODES >> max(state.quality - _NEWEST + 1, 0)


@kernel
def choose_newest(state):
    """Find who may go on in this quantum: the arrival that the oldest of them must have."""
    state.admitted = 0
    if state.quality < _NEWEST:
        return
    voices = _VOICES >> (state.quality - _NEWEST)
    enough, low = state.arrivals + 1, 0  # fewer than `voices` gestures came at `enough` or later
    while enough - low > 1:
        middle = (enough + low) // 2
        count = 0
        for i in range(len(state.called)):
            count += state.called[i] >= middle
        if count > voices:
            low = middle
        else:
            enough = middle
    state.admitted = enough


@kernel
def must_wait(state, index):
    """Is there time only for gestures that were sent or steered more recently than this contact's?"""
    return 0 < state.called[index] < state.admitted
