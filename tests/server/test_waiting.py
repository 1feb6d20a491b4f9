"""Packets that wait: datagrams find room or are counted as lost, those of streams always find room."""

from contextlib import closing

from carom.presets import Presets
from carom.server.making import Maker
from carom.server.net.network import Network
from carom.server.net.remote import Remote
from carom.server.waiting import MOST_BYTES, Waiting


def test_a_streams_packet_finds_room_where_a_datagram_does_not():
    packet, flood, page = bytes(1 << 16), ("127.0.0.1", 9), Remote(lambda packet: True)
    with closing(Network("127.0.0.1", 0)) as network, closing(Maker(Presets(), 1e3, lambda: None)) as maker:
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
