"""Engine states that are brought back to what they held."""

import numpy as np
import pytest

from carom.clients.dataset.scenes import options_of
from carom.clients.performer import Performer
from carom.dsp.runtime import fresh
from carom.server.osc.wire import Message
from tests import needs

RATE = 48_000


@pytest.fixture
def played(monkeypatch):
    """A performer with an object, and its mark: the second of this process at least, as the first shares no pages, in
    a state that nobody had before."""
    monkeypatch.setattr(fresh, "_kept", [])
    for _ in range(2):
        performer = Performer(options_of(RATE, 1), (), (), stems=False, contacts=True, steers_ended=True)
    performer.perform([Message("/object/new", ("object", "wood-block"))], 0.0)
    mark = performer.mark()
    if mark is None:
        needs.written_pages()
    return performer, mark


def own(performer):
    """Return the pages of its state that are its own, and the parts of pages: what they hold, by begin and end."""
    state = performer.engine.state
    places = [(a - state.ctypes.data, b - state.ctypes.data) for a, b in fresh._pieces(fresh._own(state.ctypes.data))]
    return {(begin, end): state.view(np.uint8)[begin:end].tobytes() for begin, end in places}


def test_a_state_that_is_restored_holds_every_byte_that_it_held(played):
    performer, mark = played
    held = own(performer)
    for striker, at in (("steel", 0.001), ("drumstick", 0.002)):
        performer.perform([Message("/object/object/impact", (1.0, "striker", striker))], at)
        performer.engine.process(RATE // 4)
        assert len(performer.traced(RATE)) and own(performer) != held
        performer.rewind(mark)
        found = own(performer)
        assert len(found) > len(held)
        for place, what in found.items():
            assert what == held.get(place, fresh._clean()[slice(*place)].tobytes())
        assert len(performer.traced(RATE)) == 0
