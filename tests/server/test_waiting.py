"""Packets that wait: datagrams find room or are counted as lost, those of streams always find room."""

from contextlib import ExitStack, closing

import pytest

from carom.presets import Presets
from carom.server import waiting
from carom.server.making import Maker
from carom.server.net.network import Network
from carom.server.osc import wire
from carom.server.osc.wire import Message
from carom.server.packets import read
from carom.server.waiting import Waiting
from tests.server.net.sockets import udp
from tests.support import answer_times, serving


@pytest.mark.parametrize("name", ["", "a"])
def test_a_question_waits_for_no_object_that_it_does_not_name(name):
    with closing(Network("127.0.0.1", 0)) as network, closing(Maker(Presets(), 1e3, lambda: None, id)) as maker:
        held = Waiting(network, maker)
        new, question = wire.encode("/object/new", name, "wood-block"), wire.encode("/status")
        assert held.hold(read(new, ("127.0.0.1", 9)))
        assert not held.hold(read(question, ("127.0.0.1", 10)))


def test_however_many_clients_of_a_host_send_much_few_of_their_calls_wait_at_once(monkeypatch):
    """What is read takes 50 times the bytes that came; of a host it is some 12 MB, and of others as it was."""
    monkeypatch.setattr(waiting, "_MOST_CALLS", 1_000)
    bundle = wire.encode_bundle(1, [Message("/x")] * 400)
    with ExitStack() as stack:
        network = stack.enter_context(closing(Network("127.0.0.1", 0)))
        held = Waiting(network, stack.enter_context(closing(Maker(Presets(), 1e3, lambda: None, id))))
        clients = [udp(stack, "127.0.0.1") for _ in range(8)]
        for each in clients:
            each.sendto(bundle, network.address)
        begun = []
        while arrived := network.receive(0.1):
            begun.append(read(*arrived))
            held.put_off(begun[-1])
        assert len(begun) == 3  # with the third there are more than 1,000
        done = 0
        while packet := held.next():
            held.end(packet.source)
            done += 1
            if arrived := network.receive(0.1):
                held.put_off(read(*arrived))
        assert done == len(clients)


@pytest.mark.slow
def test_other_clients_are_answered_while_a_swarms_table_is_made(tmp_path):
    """A table of pulses takes a second; striker and exponent of the first are known from the message."""
    with serving(tmp_path, "--device", "none") as server, server.client() as rainy, server.client() as other:
        rainy.ask("/object/new", "a", "tin-lid", timeout=30.0)
        rainy.send("/object/a/rain", 100)
        rainy.send("/object/a/shake", 100, "exponent", 2.25)
        answers = answer_times(other, rainy)
        assert not rainy.errors() and max(answers) < 0.5
        assert len(answers) > 20 and sorted(answers)[len(answers) * 9 // 10] < 0.1
