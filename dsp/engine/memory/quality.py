"""The work that is left out when time is short, by the quality requested (state.Quality).

Where only the newest gestures may go on, time stands still for the others: the newest are those that began or were
steered last. Events count in the order in which they are carried out, which a log holds, not in that of their arrival.
"""

from ...native.jit import kernel
from .records import Contact
from .state import ROLLING, Object, Quality, State

COARSER = 4.0
"""Factor on the shortest wavelength that rolls feel from COARSE on: about as loud, at 60 to 75 % of the cost."""

BY_ITSELF = 32
"""Modes that cost as much as a coupled contact does by itself."""

_HELD, _QUIET, _COARSE = int(Quality.HELD), int(Quality.QUIET), int(Quality.COARSE)
_RECENT, _NEWEST = int(Quality.RECENT), int(Quality.NEWEST_32)

_SILENCE = 1e-6  # output amplitude (-120 dB) below which a mode is put to rest
_LOUDER_SILENCE = 1e-4  # the same (-80 dB) from QUIET on
_FEW = 256  # modes of an object, the longest ringing, that rolls and presses act on from COARSE on; a multiple of LANES
_SELDOM = 3  # samples from one look at a plate's grid to the next from HELD on, at least
_RECENTLY = 0.5  # s
_VOICES = 32  # gestures that go on at NEWEST_32; each further step halves them


@kernel
def holds_steps(state: State) -> bool:
    """True where coupled contacts take one step per sample, but in blocks, and the closed form serves within -50 dB."""
    return state.choices.quality >= _HELD


@kernel
def keeps_strikers(state: State) -> bool:
    """True where strikers that have left are kept for a while, as others may throw the object after them.

    Not where steps are counted: each blow has all that are kept looked at.
    """
    return state.choices.budget.steps == 0 and not holds_steps(state)


@kernel
def looks_every(state: State, usual: int) -> int:
    """Return the samples from one look at a coupled plate's grid to the next."""
    return max(usual + 1, _SELDOM) if state.choices.quality >= _HELD else usual


@kernel
def couples_half(state: State) -> bool:
    """True where half as many modes of a plate are coupled."""
    return state.choices.quality >= _QUIET


@kernel
def couples_none(state: State) -> bool:
    """True where no modes of plates are coupled."""
    return state.choices.quality >= _COARSE


@kernel
def silence_of(state: State) -> float:
    """Return the output amplitude below which a mode is put to rest."""
    return _LOUDER_SILENCE if state.choices.quality >= _QUIET else _SILENCE


@kernel
def coarseness_of(state: State) -> float:
    """Return the factor on the shortest wavelength that rolls feel."""
    return COARSER if state.choices.quality >= _COARSE else 1.0


@kernel
def modes_for(state: State, obj: Object, contact: Contact) -> int:
    """Return how many of an object's modes a contact acts on; rolls and slides that feel none act on those that are
    heard."""
    modes = obj.unheard if contact.solver == ROLLING else obj.size
    return min(modes, _FEW) if contact.trait.lasts == 1 and state.choices.quality >= _COARSE else modes


@kernel
def is_left_out(state: State, obj: Object) -> bool:
    """True if there is time only for objects that were touched more recently."""
    long_ago = state.position - obj.last_driven_at > _RECENTLY * state.rate
    return state.choices.quality >= _RECENT and obj.has_contact == 0 and long_ago


@kernel
def room_for_coupling(state: State) -> int:
    """Return the modes that may be coupled to contacts at once; 0: any number."""
    room = state.choices.budget.modes
    return max(room >> max(state.choices.quality - _NEWEST + 1, 0), 1) if room > 0 else 0


@kernel
def find_oldest_running(state: State) -> None:
    """Find the gestures that may go on in this quantum: the least number of their last events."""
    state.oldest_running = 0
    if state.choices.quality < _NEWEST:
        return
    running = _VOICES >> (state.choices.quality - _NEWEST)
    enough, low = state.queue.carried_out + 1, 0  # of fewer than `running` gestures came an event at `enough` or later
    while enough - low > 1:
        middle = (enough + low) // 2
        count = 0
        for i in range(len(state.last_command)):
            count += state.last_command[i] >= middle
        if count > running:
            low = middle
        else:
            enough = middle
    state.oldest_running = enough


@kernel
def must_wait(state: State, index: int) -> bool:
    """True if there is time only for gestures that began or were steered more recently than this contact's."""
    return 0 < state.last_command[index] < state.oldest_running
