"""Packets that wait: datagrams find room or are counted as lost, those of streams always find room."""

from contextlib import closing

import pytest

from carom.presets import Presets
from carom.server.making import Maker
from carom.server.net.network import Network
from carom.server.net.remote import Remote
from carom.server.osc import wire
from carom.server.packets import read
from carom.server.waiting import MOST_BYTES, Waiting
from tests.support import answer_times, serving


def test_a_streams_packet_finds_room_where_a_datagram_does_not():
    packet, flood, page = bytes(1 << 16), ("127.0.0.1", 9), Remote(lambda packet: True)
    with closing(Network("127.0.0.1", 0)) as network, closing(Maker(Presets(), 1e3, lambda: None, id)) as maker:
        waiting = Waiting(network, maker)
        sent = 0
        while not waiting.is_full:
            waiting.put_last(packet, flood)
            sent += 1
        assert network.counts["dropped"] == 0 and sent * len(packet) <= MOST_BYTES
        for _ in range(sent):
            waiting.put_last(packet, flood)
        lost = network.counts["dropped"]
        waiting.put_last(packet, page)
        assert 0 < lost < sent and network.counts["dropped"] == lost
        found = []
        while waiting.in_a_hurry:
            found += waiting.ready()
    assert found.count((packet, page)) == 1 and found.count((packet, flood)) == 2 * sent - lost


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
