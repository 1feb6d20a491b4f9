"""The web server's answers: OSCQuery and the page's files; and that no client of it is a burden."""

import http.client
import re
import socket
import threading
import time
from contextlib import ExitStack, closing

import pytest

from carom.server.osc.oscquery import node
from carom.server.web import bounded
from tests.server.web.conftest import NAMES, Known, ask, get
from tests.support import serving


def test_addresses_and_attributes(web):
    value = Known().value
    assert get(web.port, "/") == (200, node("/", NAMES, value))
    assert get(web.port, "/object/") == (200, node("/object", NAMES, value))
    assert get(web.port, "/object/bell/gain") == (200, node("/object/bell/gain", NAMES, value))
    assert get(web.port, "/object/%C3%A9%20%2541") == (200, node("/object/é %41", NAMES))
    assert get(web.port, "/object/bell/gain?RANGE") == (200, {"RANGE": [{"MIN": -40, "MAX": 12}]})
    assert get(web.port, "/object/bell/gain?VALUE") == (200, {"VALUE": [-3.0]})
    assert get(web.port, "/object/bell/gain?CONTENTS")[0] == 204
    assert get(web.port, "/object/bell/pan?VALUE")[0] == 204
    assert get(web.port, "/object/bell/gain?LOUD")[0] == 400
    assert get(web.port, "/object/drum")[0] == 404


def test_host_info(web):
    status, info = get(web.port, "/?HOST_INFO")
    assert status == 200
    extensions = info.pop("EXTENSIONS")
    assert {name for name, given in extensions.items() if given} == {
        "ACCESS", "VALUE", "RANGE", "CLIPMODE", "UNIT", "OVERLOADS", "LISTEN", "IGNORE", "PATH_ADDED", "PATH_REMOVED",
    }  # fmt: skip
    assert info == {"NAME": "Carom", "OSC_PORT": 57140, "OSC_TRANSPORT": "UDP"}


def test_a_browser_gets_the_page_and_a_program_the_addresses(web):
    assert ask(web.port, "/", Accept="text/html,*/*") == (200, "text/html", b"<title>Carom</title>")
    assert ask(web.port, "/", Accept="*/*")[1] == "application/json"
    assert ask(web.port, "/page/main.js") == (200, "text/javascript", b"1;")
    assert get(web.port, "/page/object/bell") == (200, {"name": "bell"})
    assert get(web.port, "/page/object/nothing")[0] == 404
    assert ask(web.port, "/page/session.txt")[2] == b"0.0 /panic\n"


def test_without_a_page_there_is_oscquery_alone(make):
    port = make(page=None).port
    assert ask(port, "/", Accept="text/html")[1] == "application/json"
    assert ask(port, "/page/main.js")[0] == 404


@pytest.mark.parametrize(
    "path", ["../secret.js", "%2e%2e/secret.js", "..%2fsecret.js", "/etc/passwd", "key.pem", "", ".", "main.js/"]
)
def test_no_other_file_is_read(web, path):
    with closing(http.client.HTTPConnection("127.0.0.1", web.port, timeout=5)) as client:
        client.putrequest("GET", f"/page/{path}")
        client.endheaders()
        response = client.getresponse()
        assert response.status == 404 and b"secret" not in response.read()


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
    b"GET / HTTP/1.1\r\nHost: [\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: localhost\r\nOrigin: http://[\r\n\r\n",
    b"POST / HTTP/1.1\r\nContent-Length: 99999999999\r\n\r\n",
    b"POST /page/score HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\nffffffff\r\n",
    b"GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\r\n",
    b"/abc\0\0\0\0",
]


def test_junk_is_refused_and_disturbs_nothing(web, capfd, caplog):
    for junk in JUNK * 3:
        with socket.create_connection(("127.0.0.1", web.port), 5) as sock:
            try:
                sock.sendall(junk)
                sock.shutdown(socket.SHUT_WR)
                said = sock.recv(1 << 16)
            except (ConnectionResetError, BrokenPipeError):
                continue
            assert said == b"" or said.startswith(b"HTTP")
            assert not said.startswith(b"HTTP/1.1 5")
    assert get(web.port, "/panic")[0] == 200
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Host": "127.0.0.1:57141"}, 200),
        ({"Host": "localhost"}, 200),
        ({"Host": "[::1]:57141"}, 200),
        ({"Host": "evil.example"}, 403),
        ({"Host": "evil.example", "Origin": "http://evil.example"}, 403),
        ({"Origin": "http://evil.example"}, 403),
        ({"Origin": "null"}, 403),
        ({"Host": "127.0.0.1:57141", "Origin": "http://127.0.0.1:57141"}, 200),
        ({"Host": "127.0.0.1:57141", "Origin": "http://127.0.0.1:8080"}, 403),
    ],
)
def test_another_sites_page_is_told_nothing(web, headers, status):
    assert ask(web.port, "/panic", **headers)[0] == status


def test_a_token_is_asked_for(make):
    port = make(token="right").port
    for path in ("/", "/panic", "/page/main.js", "/?token=wrong"):
        assert ask(port, path)[0] == 403
    assert ask(port, "/panic?token=right")[0] == 200
    assert ask(port, "/page/main.js", Cookie="carom-token=right")[0] == 200
    assert ask(port, "/page/main.js", Cookie="carom-token=wrong")[0] == 403
    with closing(http.client.HTTPConnection("127.0.0.1", port, timeout=5)) as client:
        client.request("GET", "/?token=right", headers={"Accept": "text/html"})
        kept = client.getresponse().getheader("Set-Cookie", "")
    assert "carom-token=right" in kept and "HttpOnly" in kept and "SameSite=Strict" in kept


def test_a_question_for_no_address_is_refused(web):
    with closing(http.client.HTTPConnection("127.0.0.1", web.port, timeout=5)) as client:
        client.putrequest("GET", "*")
        client.endheaders()
        assert client.getresponse().status == 400
    assert ask(web.port, "/panic", "DELETE")[0] == 405


def test_connections_that_ask_for_nothing_make_way_at_once(make, monkeypatch):
    monkeypatch.setattr(bounded, "MOST_CONNECTIONS", 16)
    port = make().port
    with ExitStack() as stack:
        for _ in range(40):
            sock = stack.enter_context(socket.create_connection(("127.0.0.1", port), 5))
            sock.sendall(b"GET / HTTP/1.1\r\n")  # and no more
        begun = time.monotonic()
        for _ in range(20):
            assert get(port, "/panic")[0] == 200
        assert time.monotonic() - begun < 2.0


def host_of(port: int, host: bytes, path: bytes = b"/") -> int:
    """Return the status of an answer to a request of a host."""
    with socket.create_connection(("127.0.0.1", port), 5) as sock:
        sock.sendall(b"GET " + path + b" HTTP/1.1\r\nHost: " + host + b"\r\nConnection: close\r\n\r\n")
        return int(sock.makefile("rb").readline().split()[1])


@pytest.mark.parametrize(
    "host", [b"evil.local", b"[", b"[::1", b"a:b:c", b"\xff\xfe", b"localhost.evil.org", b"x" * 4_000, b""]
)
def test_a_host_that_is_not_this_machine_is_refused_without_a_traceback(web, caplog, host):
    assert host_of(web.port, host) in (400, 403)
    assert not caplog.records


def test_this_machines_names_are_known(web):
    name = socket.gethostname().partition(".")[0].encode()
    for host in (b"localhost", b"127.0.0.1:80", b"[::1]", name, name.upper() + b".local"):
        assert host_of(web.port, host) == 200


def test_a_token_of_bytes_that_are_no_text_is_wrong(make, caplog):
    assert host_of(make(token="secret").port, b"localhost", b"/?token=\xed\xa0\x80") in (400, 403)
    assert not caplog.records


@pytest.mark.parametrize("others", ["a/b=1", "a@b=1;c", '{"a": 1}=2', "(", 'x="\\777'])
def test_cookies_that_others_have_left_on_this_host_change_nothing(make, caplog, others):
    port = make(token="right").port
    assert ask(port, "/panic", Cookie=f"{others}; carom-token=right; {others}")[0] == 200
    assert ask(port, "/panic", Cookie=f"{others}; carom-token=wrong")[0] == 403
    assert ask(port, "/panic", Cookie=f"{others}-carom-token=right")[0] == 403
    assert not caplog.records


def test_many_questions_at_once(web):
    answers = []
    threads = [threading.Thread(target=lambda: answers.append(get(web.port, "/"))) for _ in range(30)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [status for status, _ in answers] == [200] * 30


@pytest.mark.slow
def test_oscquery_knows_the_objects_of_the_server(tmp_path):
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
            client.send("/object/a/free", 1)
            client.ask("/sync", 1)
            client.new("b", "wood-block")  # what has gone is forgotten with the next message
        assert get(port, "/object")[1]["CONTENTS"].keys() == {"new", "b"}
        assert server.quit() == (0, "")
