"""Packets that wait: datagrams find room or are counted as lost, those of streams always find room."""

from contextlib import closing

import pytest

from carom.presets import Presets
from carom.server.making import Maker
from carom.server.net.network import Network
from carom.server.osc import wire
from carom.server.packets import read
from carom.server.waiting import Waiting
from tests.support import answer_times, serving


@pytest.mark.parametrize("name", ["", "a"])
def test_a_question_waits_for_no_object_that_it_does_not_name(name):
    with closing(Network("127.0.0.1", 0)) as network, closing(Maker(Presets(), 1e3, lambda: None, id)) as maker:
        waiting = Waiting(network, maker)
        new, question = wire.encode("/object/new", name, "wood-block"), wire.encode("/status")
        assert waiting.hold(read(new, ("127.0.0.1", 9)))
        assert not waiting.hold(read(question, ("127.0.0.1", 10)))


@pytest.mark.slow
def test_others_are_answered_while_a_swarms_table_is_made(tmp_path):
    """A table of pulses takes a second; striker and exponent of the first are known from the message."""
    with serving(tmp_path, "--device", "none") as server, server.client() as rainy, server.client() as other:
        rainy.ask("/object/new", "a", "tin-lid", timeout=30.0)
        rainy.send("/object/a/rain", 100)
        rainy.send("/object/a/shake", 100, "exponent", 2.25)
        answers = answer_times(other, rainy)
        assert not rainy.errors() and max(answers) < 0.5
        assert len(answers) > 20 and sorted(answers)[len(answers) * 9 // 10] < 0.1
