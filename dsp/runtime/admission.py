"""What a file may write into the engine's memory, and what a command from a file may say.

A baked scene is words of the engine's memory, and commands. Whoever opens one without Python asks here before the
engine sees it: each number lies in its bounds, each index in its table.
"""

import numpy as np

from ..contact.accuracy import DEFAULT
from ..engine.memory.commands import COMMAND, Event
from ..engine.memory.state import CONTACT_PLACES, CONTACTS, EVENTS, FADING, QUANTUM, ROLLS, STATE, State
from ..engine.memory.striker_state import VOICES
from ..native.jit import carray, noinline_kernel
from ..native.typed import View
from ..schema import (
    GESTURES,
    TRAIT_NAMES,
)
from ..spectral.layout import PHASES, REGION
from .file_commands import wrong_field
from .file_records import wrong_record
from .file_words import WORD, word_in_use, wrong_word

_TRAITS = np.array(
    [tuple(getattr(each, name) for name in TRAIT_NAMES) for each in GESTURES.values()], STATE["traits"].base
).view(np.int64)
_TRAITS_AT: int = STATE.fields["traits"][1] // WORD  # type: ignore[index]


@noinline_kernel
def begin(state: State, wholes: View[int]) -> None:
    """Make a memory of zeros a fresh one, as `new_state` does, but for its rate and channels."""
    for n in range(len(_TRAITS)):
        wholes[_TRAITS_AT + n] = _TRAITS[n]
    output, choices, spectral = state.output, state.choices, state.spectral
    output.consumed, output.silent = QUANTUM, 1
    output.limit = state.stats.limit_lowest = choices.gain = 1.0
    output.headroom = state.stats.headroom = 1.0
    choices.limiter, choices.accuracy = 1, DEFAULT
    for side in range(2):
        output.gain[side] = 1.0
    for n in range(2 * QUANTUM):
        output.allowed[n] = 1.0
    known = state.scratch.together.known
    for n in range(len(known)):
        known[n] = -1
    state.most_contacts = CONTACTS
    for n in range(CONTACT_PLACES):
        contact = state.contacts[n]
        state.heard[n] = FADING
        contact.sound = contact.voice = -1
        contact.index = state.free_contact[n] = n
    for n in range(EVENTS):
        state.queue.heap[n] = n
    for n in range(ROLLS):
        state.free_roll[n] = n
    for n in range(VOICES):
        state.free_voice[n] = n
    spectral.spare = PHASES * REGION
    for n in range(PHASES):
        spectral.phases[n].region = spectral.phases[n].top = n * REGION


BEGIN, MAY_START, MAY_WRITE, WRONG_WORD, WRONG_RECORD = range(5)
"""What a host asks of `answer`, in C and in a page by its number."""
_STATE_WORDS, _COMMAND_WORDS = STATE.itemsize // WORD, COMMAND.itemsize // WORD


@noinline_kernel
def answer(memory: int, question: int, first: int, count: int) -> int:
    """Answer a host's question about the memory at an address, below 0 where nothing is wrong.

    BEGIN: makes zeros a fresh memory. MAY_START, MAY_WRITE: the first word, of `count` from `first` on, that is not to
    be written as a scene starts, or later. WRONG_WORD: the first of them whose value is out of its bounds.
    WRONG_RECORD: as `wrong_record`, with `first` values of pulses, and `count` 1 where there is memory for plates.
    """
    state: State = carray(memory, (1,), STATE)[0]
    wholes: View[int] = carray(memory, (_STATE_WORDS,), np.int64)
    if question == BEGIN:
        begin(state, wholes)
    elif question in (MAY_START, MAY_WRITE):
        return word_in_use(state, first, count, int(question == MAY_START))
    elif question == WRONG_WORD:
        reals: View[float] = carray(memory, (_STATE_WORDS,), np.float64)
        singles: View[np.float32] = carray(memory, (2 * _STATE_WORDS,), np.float32)
        return wrong_word(reals, wholes, singles, first, count)
    elif question == WRONG_RECORD:
        return wrong_record(state, first, count)
    return -1


@noinline_kernel
def judge_command(memory: int, command: int, tables: int) -> int:
    """Return the word by which the command at an address is none for the memory at another, -1 if that may take it.

    tables: of pulses that were made.
    """
    state: State = carray(memory, (1,), STATE)[0]
    event: Event = carray(command, (1,), COMMAND)[0]
    reals: View[float] = carray(command, (_COMMAND_WORDS,), np.float64)
    wholes: View[int] = carray(command, (_COMMAND_WORDS,), np.int64)
    return wrong_field(state, event, reals, wholes, tables)
