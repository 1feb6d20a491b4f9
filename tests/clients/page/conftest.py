"""A page in Debian's Chromium, on a real server that plays nowhere and keeps a log and a recording."""

import re
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike

from carom.server.osc.score import Line, read
from tests import needs
from tests.support import Running, serving

playwright = needs.module("playwright.sync_api")

PATIENCE = 30.0  # s: twenty objects are made within 10 on an idle machine
SIZE = {"width": 1280, "height": 800}


@dataclass
class Table:
    """A page, the server behind it, its address, and its folder with `log.txt` and `out.wav`."""

    page: Any
    server: Running
    url: str
    folder: Path
    since: int
    """Lines of the log that others wrote before."""

    def lines(self, end: str = "") -> list[Line]:
        """Return the messages of the log so far whose addresses end in a text."""
        return [line for line in read(self.folder / "log.txt")[self.since :] if line.message.address.endswith(end)]

    def until(self, end: str, count: int = 1) -> list[Line]:
        """Return the same, once there are so many."""
        deadline = time.monotonic() + PATIENCE
        while len(found := self.lines(end)) < count:
            assert time.monotonic() < deadline, (end, [line.message for line in self.lines()])
            self.page.wait_for_timeout(20)
        return found

    def until_last(self, end: str, value: ArrayLike, near: float = 0.0) -> list[Line]:
        """Return the same, once the last of them has a value or several, or is so near to them."""
        deadline = time.monotonic() + PATIENCE
        values = np.atleast_1d(value)
        while not (found := self.lines(end)) or np.abs(found[-1].message.args[: len(values)] - values).max() > near:
            assert time.monotonic() < deadline, (end, [line.message for line in self.lines()])
            self.page.wait_for_timeout(20)
        return found

    def ask(self, script: str) -> Any:
        """Return the value of an expression on the page, which knows its parts as `carom`."""
        return self.page.evaluate(script)

    def settle(self, script: str) -> None:
        """Wait until an expression is true; Playwright's own wait needs what the page forbids."""
        deadline = time.monotonic() + PATIENCE
        while not self.ask(script):
            assert time.monotonic() < deadline, script
            self.page.wait_for_timeout(20)

    def drag_from(self, x: float, y: float) -> None:
        """Press the mouse at a pixel; the touch never becomes a hold, however late the first move comes."""
        self.ask("carom.touch.holdAfter = 1e6")
        self.page.mouse.move(x, y)
        self.page.mouse.down()

    def spot(self, name: str, position: float = 0.5) -> tuple[float, float]:
        """Return the pixel of a point of an object's strike path."""
        x, y = self.ask(
            f"(() => {{ const b = carom.table.stage.getBoundingClientRect();"
            f"const [x, y] = carom.table.pixel(carom.scene.objects.get('{name}'), {position});"
            "return [b.left + x, b.top + y]; })()"
        )
        return x, y


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    chromium = needs.program("chromium")
    with playwright.sync_playwright() as runner:
        browser = runner.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        yield browser
        browser.close()


@contextmanager
def served(folder: Path, port: str = "0") -> Iterator[tuple[Running, str]]:
    """Yield a server with a page on a port, and its address."""
    with serving(folder, "--device", "page", "--page", port, "--log", "log.txt", "--record", "out.wav") as server:
        assert server.process.stdout
        match = re.search(r"http://\S+", server.process.stdout.readline())
        assert match
        yield server, match[0]


@pytest.fixture(scope="module")
def shared(tmp_path_factory) -> Iterator[tuple[Running, str, Path]]:
    folder = tmp_path_factory.mktemp("page")
    with served(folder) as (server, url):
        yield server, url, folder


@contextmanager
def opened(browser: Any, server: Running, url: str, folder: Path, script: str = "", **settings: Any) -> Iterator[Table]:
    """Open the page in a fresh profile; nothing may be said on its console."""
    said: list[str] = []
    since = len(read(folder / "log.txt"))
    context = browser.new_context(**{"viewport": SIZE, **settings})
    page = context.new_page()
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    if script:
        page.add_init_script(script)
    page.goto(url)
    table = Table(page, server, url, folder, since)
    table.settle(
        "window.carom !== undefined && carom.scene.objects.size >= 6 && "
        "[...carom.scene.objects.values()].every((each) => each.modes)"
    )
    yield table
    with suppress(playwright.Error):
        context.close()
    assert said == []


@pytest.fixture
def play(browser, shared) -> Iterator[Callable[..., Table]]:
    """Opens the page, with nothing on the server before."""
    server, url, folder = shared
    with server.client() as client:
        client.send("/gesture/*/stop")
        client.ask("/sync", 1)
        while client.ask("/objects").args[1]:  # some that a page asked for may come late
            client.send("/object/*/free", 1)
            time.sleep(0.02)
    with ExitStack() as stack:
        yield lambda *script, **settings: stack.enter_context(opened(browser, server, url, folder, *script, **settings))
