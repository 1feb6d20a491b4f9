"""The page's delays: from a click to its message, to its sample, and to its sound in the browser.

`python -m tests.bench.page --minutes 10` starts a server with `--device page` and Debian's Chromium, clicks, and then
listens. It fails where a median is over LIMITS, where the slowest hundredth takes twice that, where the stream had more
gaps than one a minute, or where more of it waited than STREAM.
"""

import argparse
import os
import re
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from tests.support import CAROM, Running, serving

LIMITS = {"click to OSC": 5.0, "click to sample": 15.0, "click to sound": 50.0}
"""ms in the median, less the device's own; the slowest hundredth may take twice that."""
AGAIN = 5_000
"""Samples in which a body that is clicked on may be hit again."""
STREAM = 0.04
"""s of the engine's sound that wait in the page."""
ROOT = Path(__file__).resolve().parents[2]
HERE = (sys.executable, "-m", "tests.bench.page", "timed")

_CLICKS = """(() => { window.clicks = []; window.addEventListener("pointerdown", (event) =>
    clicks.push(1e6 * (performance.timeOrigin + event.timeStamp)), true); })()"""


def timed(words: list[str]) -> int:
    """Make a Carom that writes into arrivals.txt when strikes of a page arrive, and which sample is computed then."""
    from carom.clients.cli import main as carom
    from carom.dsp.runtime.engine import Engine, clock_ns
    from carom.server.web.socket import SocketClient

    engines: list[Engine] = []
    make, take = Engine.__init__, SocketClient._take
    out = Path("arrivals.txt")

    def made(self: Engine, *args: Any, **keys: Any) -> None:
        make(self, *args, **keys)
        engines.append(self)

    async def arrived(self: SocketClient, packet: bytes) -> None:
        if b"/impact\0" in packet:
            now, latency = time.time_ns(), float(engines[0]._record["clock"]["latency"])
            sample = float(engines[0].stamp(clock_ns())) + latency  # the one that is computed now
            with out.open("a") as lines:
                lines.write(f"{now} {sample} {engines[0].measured_rate}\n")
        await take(self, packet)

    Engine.__init__, SocketClient._take = made, arrived  # type: ignore[method-assign]
    return carom(words)


@contextmanager
def page(folder: Path, carom: tuple[str, ...] = CAROM) -> Iterator[tuple[Running, Any]]:
    """Yield a server whose sound a browser plays, and its page, which has been opened in a fresh profile."""
    from playwright.sync_api import sync_playwright

    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    words = ("--device", "page", "--page", "0")
    with serving(folder, *words, carom=carom, env=env) as server, sync_playwright() as runner:
        assert server.process.stdout
        match = re.search(r"http://\S+", server.process.stdout.readline())
        assert match
        browser = runner.chromium.launch(executable_path="/usr/bin/chromium", args=["--no-sandbox"])
        view = browser.new_context(viewport={"width": 1280, "height": 800}).new_page()
        view.goto(match[0])
        while not view.evaluate(
            "window.carom !== undefined && carom.scene.objects.size >= 6 &&"
            "[...carom.scene.objects.values()].every((each) => each.modes)"
        ):
            time.sleep(0.05)
        yield server, view
        browser.close()


def clicks(folder: Path, count: int) -> dict[str, np.ndarray]:
    """Return the delays (ms) of clicks on an object, a quarter of a second apart on average."""
    first: list[int] = []  # sample of a click's first contact: a light body may be hit again
    heard = []
    random = np.random.default_rng(1)
    with page(folder, HERE) as (server, view), server.client() as listener:
        view.evaluate(_CLICKS)
        listener.send("/notify", 2)
        name = view.evaluate("[...carom.scene.objects.keys()][0]")
        x, y = view.evaluate(
            "(() => { const b = carom.table.stage.getBoundingClientRect();"
            f"const [x, y] = carom.table.pixel(carom.scene.objects.get('{name}'), 0.5);"
            "return [b.left + x, b.top + y]; })()"
        )
        for _ in range(count):
            view.mouse.click(x, y)
            view.wait_for_timeout(random.uniform(150, 350))
            for told in listener.replies(0.0):
                if told.address == "/hit" and (not first or told.args[2] > first[-1] + AGAIN):
                    first.append(told.args[2])
            heard += view.evaluate("carom.delay.measured.splice(0)")
        clicked = np.array(view.evaluate("clicks"))
        server.quit()
    arrived, samples = np.loadtxt(folder / "arrivals.txt"), np.array(first)
    assert len(arrived) == len(clicked) == len(samples) == count, (len(arrived), len(clicked), len(samples))
    to_osc = 1e-6 * (arrived[:, 0] - clicked)
    to_sample = to_osc + 1e3 * (samples - arrived[:, 1]) / arrived[:, 2]
    return {"click to OSC": to_osc, "click to sample": to_sample, "click to sound": np.array(heard)}


def stream(folder: Path, minutes: float) -> list[dict[str, float]]:
    """Return, twice per second, the sound (s) that waits in the page, and the gaps so far; objects ring."""
    told = []
    with page(folder) as (server, view), server.client() as client:
        view.mouse.click(640, 400)
        end = time.monotonic() + 60 * minutes
        while time.monotonic() < end:
            client.send("/object/*/impact", 0.5)
            view.wait_for_timeout(500)
            told.append(view.evaluate("carom.sound.state"))
        server.quit()
    return told


def main() -> int:
    if sys.argv[1:2] == ["timed"]:
        return timed(sys.argv[2:])
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--clicks", type=int, default=400)
    parser.add_argument("--minutes", type=float, default=10.0)
    args = parser.parse_args()
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        for name, delays in clicks(Path(folder), args.clicks).items():
            middle, slow = np.median(delays), np.quantile(delays, 0.99)
            failed |= bool(middle > LIMITS[name] or slow > 2 * LIMITS[name])
            print(f"{name}: median {middle:.1f} ms, 99 % under {slow:.1f} ms, the slowest {delays.max():.1f} ms")
    with tempfile.TemporaryDirectory() as folder:
        told = stream(Path(folder), args.minutes)
    waits = np.quantile([each["waits"] for each in told[4:]], 0.99)
    gaps = told[-1]["gaps"]
    print(f"stream of {args.minutes:g} minutes: {gaps} gaps, 99 % of the time under {1e3 * waits:.0f} ms of it wait")
    return int(failed or gaps > args.minutes or waits > STREAM)


if __name__ == "__main__":
    sys.exit(main())
