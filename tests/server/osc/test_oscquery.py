"""OSCQuery: what it says is what messages are checked by, and no client of it is a burden."""

import http.client
import json
import re
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing
from itertools import product

import pytest

from carom.dsp.schema import STEERABLE, gestures_steered_by
from carom.server.osc.addresses import VERBS
from carom.server.osc.arguments import Number, Refused, Verb
from carom.server.osc.oscquery import OscQuery, answering, node
from tests.support import serving

NAMES = {"NAME": {"bell": None, "é %41": None}, "ID": {"g1": None}, "preset": ["tom", "bar"]}


def everything() -> dict[str, Verb]:
    """Every address there is, and its verb."""
    return {
        "/".join(parts): verb
        for address, verb in VERBS.items()
        for parts in product(*(NAMES.get(part, [part]) for part in address.split("/")))
    }


def leaves(found: dict) -> Iterator[dict]:
    for below in found.get("CONTENTS", {}).values():
        yield from leaves(below)
    if "CONTENTS" not in found:
        yield found


def test_every_verb_is_described_once_for_each_object():
    described = {leaf["FULL_PATH"]: leaf for leaf in leaves(node("/", NAMES))}
    expected = everything()
    assert described.keys() == expected.keys()
    for path, leaf in described.items():
        assert leaf["DESCRIPTION"].startswith(expected[path].help)
        assert node(path, NAMES) == leaf


def test_what_it_offers_is_taken_and_nothing_beyond():
    """Every list of arguments that it names passes the checks at its bounds, and fails beyond them."""
    checked = 0
    for leaf in leaves(node("/", NAMES)):
        verb = everything()[leaf["FULL_PATH"]]
        for kind in [leaf, *leaf.get("OVERLOADS", [])] if leaf["ACCESS"] else []:
            ranges = [bounds or {"VALS": ["x"]} for bounds in kind["RANGE"]]
            assert len(ranges) == len(kind["TYPE"]) == len(kind.get("UNIT", ranges))
            for bound in ("MIN", "MAX"):
                verb.parse(tuple(each[bound] if bound in each else each["VALS"][0] for each in ranges))
            for place, each in enumerate(ranges):
                values = [other.get("MAX", "x") for other in ranges]
                values[place] = each["MAX"] * 1.01 + 1 if "MAX" in each else 7
                with pytest.raises(Refused):
                    verb.parse(tuple(values))
                checked += 1
        if not leaf["ACCESS"]:
            assert verb.parse(()).numbers == {}
    assert checked > 20


def test_an_impact_is_one_float_or_two():
    impact = node("/object/bell/impact", NAMES)
    velocity, position = VERBS["/object/NAME/impact"].required[0], VERBS["/object/NAME/impact"].optional[0]
    assert isinstance(velocity, Number) and isinstance(position, Number)
    assert (impact["TYPE"], impact["UNIT"], impact["ACCESS"]) == ("f", ["speed.m/s"], 2)
    assert impact["RANGE"] == [{"MIN": velocity.low, "MAX": velocity.high}]
    assert [overload["TYPE"] for overload in impact["OVERLOADS"]] == ["ff"]


def test_keys_and_steerable_numbers_are_told_with_their_ranges():
    for action in ("impact", "bounce", "roll", "press"):
        description = node(f"/object/bell/{action}", NAMES)["DESCRIPTION"]
        for key in VERBS[f"/object/NAME/{action}"].keys:
            assert str(key) in description
    assert (
        "friction 0 to 10, usually 0 to 0.2, gravity 0.01 to 1000 m/s^2, "
        in node("/object/bell/roll", NAMES)["DESCRIPTION"]
    )
    steered = node("/gesture/g1", NAMES)["CONTENTS"]
    assert steered.keys() == {"stop", *STEERABLE}
    for name in STEERABLE:
        for number in gestures_steered_by(name).values():
            assert steered[name]["RANGE"] == [{"MIN": number.low, "MAX": number.high}]
        assert all(gesture in steered[name]["DESCRIPTION"] for gesture in gestures_steered_by(name))


def test_words_have_their_choices():
    assert node("/object/new", NAMES)["RANGE"] == [None, {"VALS": ["tom", "bar"]}]


def test_what_is_not_there():
    for path in ("/object/drum", "/object/NAME", "/nothing", "/object/bell/impact/x", "/object/bell/sing"):
        assert node(path, NAMES) is None
    assert node("/object", {}) == {
        "FULL_PATH": "/object", "ACCESS": 0, "CONTENTS": {"new": node("/object/new", {})}
    }  # fmt: skip


@pytest.fixture
def query() -> Iterator[OscQuery]:
    query = OscQuery("127.0.0.1", 0, 57140, lambda: NAMES)
    with answering(query):
        yield query


def get(query: OscQuery | int, path: str) -> tuple[int, dict]:
    port = query if isinstance(query, int) else query.server_port
    with closing(http.client.HTTPConnection("127.0.0.1", port, timeout=5)) as connection:
        connection.request("GET", path)
        response = connection.getresponse()
        body = response.read()
        return response.status, json.loads(body) if response.getheader("Content-Type") == "application/json" else {}


def test_addresses_and_attributes(query):
    assert get(query, "/") == (200, node("/", NAMES))
    assert get(query, "/object/") == (200, node("/object", NAMES))
    assert get(query, "/object/bell/gain") == (200, node("/object/bell/gain", NAMES))
    assert get(query, "/object/%C3%A9%20%2541") == (200, node("/object/é %41", NAMES))
    assert get(query, "/object/bell/gain?RANGE") == (200, {"RANGE": [{"MIN": -120, "MAX": 40}]})
    assert get(query, "/object/bell/gain?CONTENTS")[0] == 204
    assert get(query, "/object/bell/gain?VALUE")[0] == 204
    assert get(query, "/object/bell/gain?LOUD")[0] == 400
    assert get(query, "/object/drum")[0] == 404


def test_host_info(query):
    status, info = get(query, "/?HOST_INFO")
    assert status == 200
    assert info.pop("EXTENSIONS") == {
        "ACCESS": True, "RANGE": True, "UNIT": True, "OVERLOADS": True, "VALUE": False, "TAGS": False,
        "CLIPMODE": False, "EXTENDED_TYPE": False, "CRITICAL": False,
    }  # fmt: skip
    assert info == {"NAME": "Carom", "OSC_IP": "127.0.0.1", "OSC_PORT": 57140, "OSC_TRANSPORT": "UDP"}


JUNK = [
    b"",
    b"\r\n\r\n",
    b"\xff\xfe\0" * 100,
    b"GET //[ HTTP/1.1\r\n\r\n",
    b"GET /%ff%fe%00 HTTP/1.0\r\n\r\n",
    b"GET /" + b"a" * 70_000 + b" HTTP/1.1\r\n\r\n",
    b"GET /" + b"/" * 60_000 + b"x HTTP/1.1\r\n\r\n",
    b"GET / HTTP/9.9\r\n\r\n",
    b"GET / HTTP/1.1\r\n" + b"A: b\r\n" * 300 + b"\r\n",
    b"POST / HTTP/1.1\r\nContent-Length: 99999999999\r\n\r\n",
    b"/abc\0\0\0\0",
]


def test_junk_is_refused_and_disturbs_nothing(query, capfd):
    for junk in JUNK * 3:
        with socket.create_connection(("127.0.0.1", query.server_port), 5) as sock:
            sock.sendall(junk)
            sock.shutdown(socket.SHUT_WR)
            try:
                said = sock.recv(1 << 16)
            except ConnectionResetError:
                continue
            assert said == b"" or said.startswith((b"HTTP", b"<!DOCTYPE"))
    assert get(query, "/panic")[0] == 200
    assert capfd.readouterr() == ("", "")


@pytest.mark.slow
def test_clients_that_occupy_it_make_way(query):
    with ExitStack() as stack:
        for _ in range(24):
            sock = stack.enter_context(socket.create_connection(("127.0.0.1", query.server_port), 5))
            sock.sendall(b"GET / HTTP/1.1\r\n")  # and no more
        started = time.monotonic()
        assert get(query, "/panic")[0] == 200
        assert time.monotonic() - started < 4.0
        assert sum("process_request" in thread.name for thread in threading.enumerate()) <= 9


def test_many_questions_at_once(query):
    answers = []
    threads = [threading.Thread(target=lambda: answers.append(get(query, "/"))) for _ in range(30)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    # On a busy machine one may be slow enough to have to make way.
    assert sum(status == 200 for status, _ in answers) >= 20


@pytest.mark.slow
def test_it_knows_what_the_server_plays(tmp_path):
    with serving(tmp_path, "--device", "none", "--oscquery", "0") as server:
        assert server.process.stdout
        line = server.process.stdout.readline()
        match = re.fullmatch(r"carom describes itself at http://127.0.0.1:(\d+)/ \(OSCQuery\)\n", line)
        assert match
        port = int(match[1])
        assert get(port, "/?HOST_INFO")[1]["OSC_PORT"] == server.port
        assert get(port, "/object/a")[0] == 404
        with server.client() as client:
            client.new("a", "wood-block")
            assert get(port, "/object/a/impact")[1]["TYPE"] == "f"
            assert "wood-block" in get(port, "/object/new?RANGE")[1]["RANGE"][1]["VALS"]
            assert get(port, "/contact?RANGE")[1]["RANGE"][0]["VALS"][0] == "closed"
            client.send("/object/a/free", 1)
            client.ask("/sync", 1)
            client.new("b", "wood-block")  # what has gone is forgotten with the next message
        assert get(port, "/object")[1]["CONTENTS"].keys() == {"new", "b"}
        assert server.quit() == (0, "")


@pytest.mark.parametrize(
    ("header", "value", "status"),
    [
        ("Host", "127.0.0.1:57141", 200),
        ("Host", "localhost", 200),
        ("Host", "[::1]:57141", 200),
        ("Host", "evil.example", 403),
        ("Origin", "http://evil.example", 403),
        ("Origin", "null", 403),
        ("Origin", "http://127.0.0.1:57141", 200),
    ],
)
def test_another_sites_page_is_told_nothing(header, value, status):
    query = OscQuery("127.0.0.1", 0, 57140, lambda: NAMES)
    with answering(query), closing(http.client.HTTPConnection("127.0.0.1", query.server_port, timeout=5)) as client:
        client.request("GET", "/panic", headers={header: value})
        assert client.getresponse().status == status


def test_a_question_for_no_address_is_refused():
    query = OscQuery("127.0.0.1", 0, 57140, lambda: NAMES)
    with answering(query), closing(http.client.HTTPConnection("127.0.0.1", query.server_port, timeout=5)) as client:
        client.putrequest("GET", "*")
        client.endheaders()
        assert client.getresponse().status == 400
