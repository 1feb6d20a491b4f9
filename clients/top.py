"""A live view of a server's state in the terminal."""

import math
import time
from collections.abc import Iterator

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from ..server.osc.wire import Message
from .client import Client

PERIOD = 0.25  # s

_NINE = ("", "modes", "sounding", "objects", "contacts", "load", "load_peak", "rate", "rate_actual")
_ALARMING = {
    "quality",
    "contacts_dropped",
    "ramps_dropped",
    "nonlinear_dropped",
    "late",
    "limited",
    "faults",
    "underflows",
    "tap_lost",
    "reconnects",
}
_FILES = {"recording", "logging"}
_SPOKEN = {
    "time", "device", "scheduling", "latency", "latency_requested", "latency_measured", "limiter_lowest", "peak",
    "loudness",
}  # fmt: skip
_RANGE, _SILENT = 60.0, 120.0  # dB below full scale that a level's bar covers; from which on it is silence


def top(client: Client, once: bool) -> None:
    """Show the server's /status, once or until interrupted. TimeoutError or ConnectionError if it does not answer."""
    console = Console()
    first = view(client.status(), {})
    if once:
        console.print(first)
        return
    with Live(first, console=console, auto_refresh=False, screen=console.is_terminal) as live:
        for picture in _views(client):
            live.update(picture, refresh=True)


def _views(client: Client) -> Iterator[RenderableType]:
    """Yield a view every PERIOD; an error where the server does not answer."""
    before: dict[str, object] = {}
    while True:
        started = time.monotonic()
        try:
            status = client.status()
            yield view(status, before)
            before = values(status)
        except (TimeoutError, ConnectionError) as error:
            yield Text(f"no answer: {error}", style="red")
        time.sleep(max(0.0, started + PERIOD - time.monotonic()))


def values(status: Message) -> dict[str, object]:
    """Return the values of a /status.reply by name: first nine by position, then pairs of name and value."""
    args = status.args
    return {**dict(zip(_NINE[1:], args[1:9], strict=True)), **dict(zip(map(str, args[9::2]), args[10::2], strict=True))}


def view(status: Message, before: dict[str, object]) -> RenderableType:
    """Return a view of a /status.reply; counts of trouble are red where they have changed since `before`."""
    now = values(status)
    head = Text.assemble(
        ("carom", "bold"), f"  {_clock(now['time'])}  {now['device']} at {now['rate']:.0f} Hz",
        f" (measured {now['rate_actual']:.1f}), {now['scheduling']}, latency {_latency(now)}",
    )  # fmt: skip
    load = Table.grid(padding=(0, 2))
    for name, share in (("load", now["load"]), ("load peak", now["load_peak"])):
        assert isinstance(share, int | float)
        load.add_row(name, ProgressBar(total=100.0, completed=min(share, 100.0), width=50), f"{share:6.1f} %")
    for name, unit in (("peak", "dB"), ("loudness", "LUFS")):
        level = float(str(now[name]))
        bar = ProgressBar(total=_RANGE, completed=min(max(level + _RANGE, 0.0), _RANGE), width=50)
        load.add_row(name, bar, f"{level:6.1f} {unit}" if level > -_SILENT else "silence")
    lowest = now["limiter_lowest"]
    assert isinstance(lowest, int | float)
    load.add_row("limiter", "", f"{20 * math.log10(max(lowest, 1e-6)):6.1f} dB at most" if lowest < 1 else "   0 dB")
    counts = Table.grid(padding=(0, 2))
    rest = [name for name in now if name not in _SPOKEN and name not in _NINE]
    names = [*_NINE[1:5], *rest]
    for pair in zip(names[::2], [*names[1::2], *[""] * (len(names) % 2)], strict=True):
        cells = (cell for name in pair for cell in (name, _cell(name, now, before)))
        counts.add_row(*cells)
    return Group(head, "", load, "", counts)


def _cell(name: str, now: dict[str, object], before: dict[str, object]) -> Text:
    value = now.get(name, "")
    if isinstance(value, int | float):
        text = f"{value:,.0f}" if value == int(value) else f"{value:,.1f}"
    else:
        text = str(value)
    alarming = (name in _ALARMING and value) or (name in _FILES and value not in ("yes", "no"))
    style = "bold red" if alarming and value != before.get(name, value) else "yellow" if alarming else ""
    return Text(f"{text:>12}", style=style)


def _latency(now: dict[str, object]) -> str:
    told = [f"{1e3 * float(str(now['latency'])):.1f} ms"]
    requested, measured = float(str(now["latency_requested"])), float(str(now["latency_measured"]))
    if requested >= 0:
        told.append(f"requested {1e3 * requested:.1f}")
    if measured > 0:
        told.append(f"measured {1e3 * measured:.1f}")
    return ", ".join(told)


def _clock(seconds: object) -> str:
    whole = int(float(str(seconds)))
    return f"{whole // 3600}:{whole // 60 % 60:02d}:{whole % 60:02d}"
