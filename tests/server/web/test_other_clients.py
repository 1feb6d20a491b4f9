"""An OSCQuery client of another make lists an object's settings, and sets them by the ranges that it is told.

It takes no address that has no value: gestures it plays without having listed them.
"""

import re
import socket
import time

import pytest

from tests import needs
from tests.server.support import counted
from tests.support import serving

pytestmark = pytest.mark.slow

client_module = needs.module("pythonoscquery.osc_query_client")


def test_python_oscquery_lists_and_plays(tmp_path):
    from pythonosc.udp_client import SimpleUDPClient
    from pythonoscquery.shared.oscquery_spec import OSCQueryAttribute
    from zeroconf import ServiceInfo

    with serving(tmp_path, "--device", "none", "--oscquery", "0") as server, server.client() as own:
        assert server.process.stdout
        match = re.search(r":(\d+)/", server.process.stdout.readline())
        assert match
        own.new("bell", "church-bell")
        kind = "_oscjson._tcp.local."
        there = ServiceInfo(kind, f"Carom.{kind}", int(match[1]), addresses=[socket.inet_aton("127.0.0.1")])
        other = client_module.OSCQueryClient(there)
        host = other.get_host_info()
        assert (host.name, host.osc_ip, host.osc_port) == ("Carom", "127.0.0.1", server.port)
        found = {}
        for action in ("gain", "tune", "decay"):
            leaf = other.query_node(f"/object/bell/{action}")
            found[leaf.attributes[OSCQueryAttribute.FULL_PATH]] = other.last_json["RANGE"][0]
        # Values that a fader of its own would send: its two ends and its middle.
        plays = SimpleUDPClient(host.osc_ip, host.osc_port)
        for path, bounds in found.items():
            for share in (0.0, 0.5, 1.0):
                plays.send_message(path, bounds["MIN"] + share * (bounds["MAX"] - bounds["MIN"]))
                plays.send_message("/object/bell/impact", 1.0)
        plays._sock.close()
        deadline = time.monotonic() + 3.0
        while counted(own.ask("/status"))["impacts"] < 9:
            assert time.monotonic() < deadline
        assert other.query_node("/object/bell/tune") and other.last_json["VALUE"] == [24.0]
        assert own.errors() == []
