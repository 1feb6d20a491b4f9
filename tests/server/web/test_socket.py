"""Web sockets: OSC both ways, OSCQuery's notifications, and clients that send too much, or never read."""

import asyncio
import json
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from itertools import pairwise
from pathlib import Path

import aiohttp
import numpy as np
import pytest

from carom.dsp.engine.memory.state import QUANTUM
from carom.server.options import Options
from carom.server.osc.wire import Message, encode, parse
from carom.server.server import Server
from carom.server.start import serving
from tests.server.web.conftest import ask, run

pytestmark = pytest.mark.slow


@pytest.fixture
def server(tmp_path) -> Iterator[Server]:
    """A server with a page, in this process, whose messages a thread carries out."""
    import threading

    page = tmp_path / "page"
    page.mkdir()
    (page / "index.html").write_text("<title>Carom</title>")
    with serving(Options(port=0, device="none", web=0, page=page, record=tmp_path / "out.wav")) as server:
        thread = threading.Thread(target=server.run)
        thread.start()
        yield server
        server.stop()
        thread.join()


class Page:
    """A page's end of a web socket."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self.socket = socket
        self.heard: list[Message] = []
        self.told: list[tuple[str, object]] = []

    async def send(self, address: str, *args: object) -> None:
        await self.socket.send_bytes(encode(address, *args, real="d"))

    async def command(self, command: str, data: object) -> None:
        await self.socket.send_str(json.dumps({"COMMAND": command, "DATA": data}))

    async def listen(self) -> None:
        async for frame in self.socket:
            if frame.type == aiohttp.WSMsgType.TEXT:
                given = json.loads(frame.data)
                self.told.append((given["COMMAND"], given["DATA"]))
            else:
                self.heard += [message for bundle in parse(frame.data) for message in bundle.messages]

    def of(self, address: str) -> list[tuple]:
        return [message.args for message in self.heard if message.address == address]

    async def until(self, address: str, count: int = 1) -> list[tuple]:
        deadline = time.monotonic() + 5.0
        while len(self.of(address)) < count:
            assert time.monotonic() < deadline, (address, self.heard[-5:])
            await asyncio.sleep(0.005)
        return self.of(address)


@asynccontextmanager
async def page_of(server: Server, **headers: str) -> AsyncIterator[Page]:
    assert server.web
    async with (
        aiohttp.ClientSession() as session,
        session.ws_connect(server.web.address, headers=headers) as socket,
    ):
        page = Page(socket)
        listening = asyncio.ensure_future(page.listen())
        try:
            yield page
        finally:
            listening.cancel()


def test_a_page_plays_and_is_told_of_contacts_where_and_how_they_were(server):
    async def play() -> None:
        async with page_of(server) as page:
            await page.send("/notify", 3)
            await page.send("/object/new", "bar", "steel-plate")
            await page.until("/done", 2)
            await page.send("/object/bar/impact", 1.5, 0.25, "id", "mine")
            ((name, id, sample, position, speed, impulse, seconds, velocity),) = await page.until("/hit")
            assert (name, id, position, speed, velocity) == ("bar", "mine", 0.25, 1.5, 1.5)
            # A ball of m = 4.11 g loses its momentum, and gets back some of it.
            assert 0.00411 * 1.5 < impulse < 2 * 0.00411 * 1.5 and 0.0 < seconds < 0.01 and sample > 0
            ((struck, span, *force),) = await page.until("/force")
            assert struck == "bar" and sum(force) * span / len(force) == pytest.approx(impulse, rel=1e-5)
            levels = await page.until("/modes", 2)
            assert levels[0][0] == "bar" and len(levels[0]) > 4
            assert (await page.until("/object.added"))[0] == ("bar", "steel-plate")

    run(play())


def test_a_bounce_is_told_contact_by_contact_and_its_momenta_say_when_it_is_back(server):
    async def play() -> None:
        async with page_of(server) as page:
            await page.send("/notify", 2)
            await page.send("/object/new", "board", "wood-board")
            await page.send("/object/board/bounce", 0.1, 0.4, "striker", "steel", "id", "ball")
            hits = await page.until("/hit", 4)
            assert {id for _, id, *_ in hits} == {"ball"}
            mass = server._session.presets.striker("steel").mass
            for (*_, sample, _, _, impulse, seconds, velocity), later in pairwise(hits[:4]):
                up = impulse / mass - velocity
                back = (later[2] - sample) / server.engine.rate - seconds
                assert back == pytest.approx(2 * up / 9.80665, rel=0.03)

    run(play())


def test_a_striker_that_a_yielding_object_catches_up_with_is_told_twice(server):
    async def play() -> None:
        async with page_of(server) as page:
            await page.send("/notify", 2)
            await page.send("/object/new", "sheet", "polycarbonate-sheet")
            await page.send("/object/sheet/impact", 1.5, 0.583, "striker", "plastic", "mass", 0.0123, "id", "mallet")
            one, other = await page.until("/hit", 2)
            assert one[:2] == other[:2] == ("sheet", "mallet") and 0.0014 < (other[2] - one[2]) / 48_000 < 0.0016
            assert other[7] == pytest.approx(1.5 - one[5] / 0.0123, abs=1e-4) and 0.0 < other[7] < other[4] < 0.2

    run(play())


def test_a_page_that_goes_takes_its_gestures_with_it_and_no_others(server):
    async def play() -> None:
        async with page_of(server) as stays:
            await stays.send("/object/new", "a", "wood-board")
            await stays.send("/object/a/roll", 0.5, 0.5, "striker", "glass-marble", "id", "theirs")
            async with page_of(server) as goes:
                await goes.send("/object/a/roll", 0.5, 0.2, "striker", "glass-marble", "id", "rolls")
                await goes.send("/object/a/press", 2.0, 0.4, "striker", "hand", "id", "hand")
                await stays.send("/gestures")
                while sorted((await stays.until("/gestures.reply"))[-1][2::2]) != ["hand", "rolls", "theirs"]:
                    await asyncio.sleep(0.02)
                    await stays.send("/gestures")
            deadline = time.monotonic() + 3.0
            while (await stays.until("/gestures.reply"))[-1][2::2] != ("theirs",):
                assert time.monotonic() < deadline
                await asyncio.sleep(0.02)
                await stays.send("/gestures")

    run(play())


def test_a_page_can_not_end_the_server(server):
    async def play() -> None:
        async with page_of(server) as page:
            await page.send("/quit")
            assert await page.until("/fail") == [("/quit", "a page can't end the server")]
            await page.send("/version")
            await page.until("/version.reply")

    run(play())


def test_text_that_is_no_command_is_told_what_is(server):
    async def play() -> None:
        async with page_of(server) as page:
            texts = ["/object/bell/impact 1", "[1]", "7", json.dumps({"COMMAND": "HELLO", "DATA": 1}), "[" * 9_000]
            for text in texts:
                await page.socket.send_str(text)
            await page.send("/version")
            await page.until("/version.reply")
            told = [data for command, data in page.told if command == "FAIL"]
            assert len(told) == len(texts) and max(map(len, told)) < 200
            for text, said in zip(texts, told, strict=True):
                assert said.startswith(text[:60]) and 'expected OSC in binary frames, or as text {"COMMAND":' in said

    run(play())


def test_oscquery_tells_what_comes_goes_and_changes(server):
    async def play() -> None:
        async with page_of(server) as page, page_of(server) as other:
            await page.command("LISTEN", "/object/a/gain")
            await page.command("LISTEN", "/" + 256 * "x")  # is kept nowhere
            await page.send("/object/new", "a", "wood-block")
            await page.until("/object/a/gain")
            assert server.web and [each.listens for each in server.web.site.clients if each.listens] == [
                {"/object/a/gain"}
            ]
            await other.send("/object/a/gain", -6)
            assert (await page.until("/object/a/gain", 2))[1] == (-6.0,)
            await page.command("IGNORE", "/object/a/gain")
            await page.send("/sync", 1)
            await page.until("/synced")
            await other.send("/object/a/gain", -9)
            await other.send("/object/a/free", 1)
            await asyncio.sleep(0.3)
            assert ("PATH_ADDED", "/object/a") in page.told and ("PATH_REMOVED", "/object/a") in page.told
            assert not any(value == (-9.0,) for value in page.of("/object/a/gain"))

    run(play())


def test_the_sound_comes_bit_by_bit(server, tmp_path):
    """A page hears what is recorded, from the sample on that it says."""

    async def play() -> list[tuple]:
        async with page_of(server) as page:
            await page.command("SOUND", True)
            await page.send("/object/new", "bell", "church-bell")
            await page.send("/object/bell/impact", 1.0)
            await asyncio.sleep(0.6)
            return page.of("/sound")

    blocks = run(play())
    server.stop()
    time.sleep(0.5)
    raw = (tmp_path / "out.wav").read_bytes()
    recorded = np.frombuffer(raw[raw.index(b"data") + 8 :][: (len(raw) - 200) // 8 * 8], "<f4").reshape(-1, 2)
    loud = 0.0
    for position, rate, channels, samples in blocks:
        sound = np.frombuffer(samples, "<f4").reshape(-1, channels)
        assert rate == 48_000
        if position + len(sound) <= len(recorded):
            assert np.array_equal(sound, recorded[position : position + len(sound)])
            loud = max(loud, float(np.abs(sound).max()))
    assert loud > 0.01 and all(a[0] + len(a[3]) // 8 == b[0] for a, b in pairwise(blocks))


def test_other_sites_and_large_frames_are_refused(server):
    async def play() -> None:
        with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
            async with page_of(server, Origin="http://evil.example"):
                pass
        assert refused.value.status == 403
        async with page_of(server) as page:
            await page.socket.send_bytes(bytes(1 << 17))
            deadline = time.monotonic() + 5.0
            while not page.socket.closed:
                assert time.monotonic() < deadline
                await asyncio.sleep(0.01)
            assert page.socket.close_code == aiohttp.WSCloseCode.MESSAGE_TOO_BIG
        async with page_of(server) as page:  # and the others go on
            await page.socket.send_bytes(b"junk")
            await page.command("LISTEN", {"not": "a path"})
            await page.socket.send_str("[" * 50_000)
            await page.until("/fail")

    run(play())


def test_a_client_that_sends_too_much_is_slowed_down_and_disturbs_nobody(server):
    async def flood(page: Page, stop: asyncio.Event) -> int:
        sent = 0
        while not stop.is_set():
            await page.send("/object/a/gain", -3)
            sent += 1
            if sent % 100 == 0:
                await asyncio.sleep(0)
        return sent

    async def play() -> None:
        async with page_of(server) as other, page_of(server) as floods:
            await other.send("/object/new", "a", "wood-block")
            await other.until("/done")
            stop = asyncio.Event()
            flooding = asyncio.ensure_future(flood(floods, stop))
            times, began = [], time.perf_counter()
            for n in range(40):
                start = time.perf_counter()
                await other.send("/sync", n)
                await other.until("/synced", n + 1)
                times.append(time.perf_counter() - start)
                await asyncio.sleep(0.05)
            stop.set()
            before, lasted = server.engine.sent, time.perf_counter() - began
            flooding.cancel()
            assert floods.socket._response.connection
            floods.socket._response.connection.transport.abort()  # it would take leave behind all that it has sent
            assert before < 2 * 1_000 + lasted * 1_000 + 500, "a burst, and 1,000 per second"
            assert sorted(times)[len(times) // 2] < 0.1
            assert server.engine.stats.underflows == 0

    run(play())


def test_for_a_client_that_never_reads_nothing_piles_up(server):
    async def play() -> None:
        assert server.web
        reader, writer = await asyncio.open_connection("127.0.0.1", server.web.port, limit=1024)
        head = "GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        writer.write(f"{head}Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {'A' * 22}==\r\n\r\n".encode())
        await reader.readuntil(b"\r\n\r\n")
        while not server.web.site.clients:
            await asyncio.sleep(0.01)
        (client,) = server.web.site.clients
        client.sound_on = True  # and so much sound that no system's buffers hold it
        for _ in range(400):
            client._loop.call_soon_threadsafe(client.play, bytes(1 << 16), 0.01)
            client.send(bytes(1 << 15))
        await asyncio.sleep(0.3)
        assert client._size <= 1 << 18 and len(client._sound) <= 52
        writer.close()

    run(play())


def test_a_score_is_played_as_if_the_page_had_sent_it(server, tmp_path):
    assert server.web
    port = server.web.port

    async def play() -> None:
        async with page_of(server) as page:
            await page.send("/version")
            await page.until("/version.reply")
            (name,) = (data for command, data in page.told if command == "CLIENT")
            post = lambda text: asyncio.to_thread(ask, port, f"/page/score?client={name}", "POST", text)  # noqa: E731
            status, _, said = await post(b"0 /object/new bell church-bell\n0.2 /object/bell/impact 1\n")
            assert status == 200 and json.loads(said) == {"messages": 2, "seconds": 0.2}
            await page.until("/done")
            assert (await post(b"0 /object/new bell\nx /object/bell/impact 1\n"))[::2] == (
                400, b"score:2: time 'x': expected seconds from 0 to 2678400\n",
            )  # fmt: skip
            assert (await post(b"0 /quit\n"))[::2] == (400, b"score:1: /quit: a page can't end the server\n")
            assert (await post(b"#" * (2 << 20)))[0] == 413
            assert (await asyncio.to_thread(ask, port, "/page/score?client=x", "POST", b""))[0] == 409
            await asyncio.sleep(0.5)

    run(play())
    text = ask(port, "/page/session.txt")[2].decode()
    made, struck = (float(line.split()[0]) for line in text.splitlines() if "bell" in line)
    assert struck - made == pytest.approx(0.2, abs=QUANTUM / 48_000)
    assert Path(tmp_path / "out.wav").exists()


def test_scores_that_are_played_have_so_many_bytes_and_no_more(server, monkeypatch):
    assert server.web
    monkeypatch.setattr("carom.server.web.site.MOST_SCORES", 100)
    port = server.web.port
    score = b"0 /sync 1\n60 /sync 2" + b" " * 40

    async def play() -> None:
        async with page_of(server) as page, page_of(server) as other:
            for each in (page, other):
                await each.send("/version")
                await each.until("/version.reply")
            names = [dict(each.told)["CLIENT"] for each in (page, other)]
            post = lambda name: asyncio.to_thread(ask, port, f"/page/score?client={name}", "POST", score)  # noqa: E731
            assert [(await post(names[n]))[0] for n in (0, 0, 1)] == [200, 200, 503]
            assert (await asyncio.to_thread(ask, port, f"/page/score?client={names[0]}", "POST", b""))[0] == 200
            assert (await post(names[1]))[0] == 200

    run(play())


def test_ten_pages_at_a_hundred_messages_a_second(server):
    async def drag(page: Page, n: int) -> None:
        for k in range(200):
            await page.send("/object/a/gain", -3 - (k % 5))
            await page.send("/object/a/impact", 0.2, (n + 1) / 12, "striker", "wood") if k % 10 == 0 else None
            await asyncio.sleep(0.01)

    async def play() -> None:
        async with page_of(server) as first:
            await first.send("/object/new", "a", "wood-block")
            await first.until("/done")
            server.engine.state["stats"]["overruns"] = 0
            others = [page_of(server) for _ in range(9)]
            pages = [first, *[await each.__aenter__() for each in others]]
            for page in pages:
                await page.send("/notify", 3)
            await asyncio.gather(*(drag(page, n) for n, page in enumerate(pages)))
            for each in others:
                await each.__aexit__(None, None, None)

    run(play())
    assert server.engine.stats.underflows == 0 and server.engine.stats.late == 0
    assert server.engine.stats.impacts >= 200
