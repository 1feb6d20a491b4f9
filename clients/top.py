"""A live view of a server's state in the terminal."""

import math
import os
import sys
import time
from collections.abc import Iterator

from ..server.osc.wire import Message
from .client import Client
from .terminal import ALARM, BOLD, RED, YELLOW, bar, clock, moves, screen, styled

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
    "holes",
    "tap_lost",
    "reconnects",
}
_FILES = {"recording", "logging"}
_SPOKEN = {
    "time", "device", "scheduling", "latency", "latency_requested", "latency_measured", "limiter_lowest", "peak",
    "loudness",
}  # fmt: skip
_RANGE, _SILENT = 60.0, 120.0  # dB below full scale that a level's bar covers; from which on it is silence
_WIDTH = 50  # characters of a bar


def top(client: Client, once: bool) -> None:
    """Show the server's /status, once or until interrupted. TimeoutError or ConnectionError if it does not answer."""
    is_terminal = moves(sys.stdout)
    coloured = is_terminal and "NO_COLOR" not in os.environ
    first = view(client.status(), {}, coloured)
    if once:
        print(*first, sep="\n")
    elif is_terminal:
        with screen(sys.stdout) as show:
            show(first)
            for picture in _views(client, coloured):
                show(picture)
    else:
        for picture in _views(client, coloured):
            print(*picture, "", sep="\n", flush=True)


def _views(client: Client, coloured: bool) -> Iterator[list[str]]:
    """Yield a view every PERIOD; an error where the server does not answer."""
    before: dict[str, object] = {}
    while True:
        started = time.monotonic()
        try:
            status = client.status()
            yield view(status, before, coloured)
            before = values(status)
        except (TimeoutError, ConnectionError) as error:
            yield [styled(f"no answer: {error}", RED if coloured else "")]
        time.sleep(max(0.0, started + PERIOD - time.monotonic()))


def values(status: Message) -> dict[str, object]:
    """Return the values of a /status.reply by name: first nine by position, then pairs of name and value."""
    args = status.args
    return {**dict(zip(_NINE[1:], args[1:9], strict=True)), **dict(zip(map(str, args[9::2]), args[10::2], strict=True))}


def view(status: Message, before: dict[str, object], coloured: bool = True) -> list[str]:
    """Return a view of a /status.reply, by lines; counts of trouble are red where they have changed since `before`."""
    now = values(status)
    head = (
        f"{styled('carom', BOLD if coloured else '')}  {clock(_number(now, 'time'))}  {now['device']} at"
        f" {now['rate']:.0f} Hz (measured {now['rate_actual']:.1f}), {now['scheduling']}, latency {_latency(now)}"
    )
    loads = [
        ("load", _number(now, "load") / 100.0, f"{now['load']:6.1f} %"),
        ("load peak", _number(now, "load_peak") / 100.0, f"{now['load_peak']:6.1f} %"),
    ]
    for name, unit in (("peak", "dB"), ("loudness", "LUFS")):
        level = _number(now, name)
        loads.append((name, level / _RANGE + 1.0, f"{level:6.1f} {unit}" if level > -_SILENT else "silence"))
    lowest = _number(now, "limiter_lowest")
    limited = f"{20 * math.log10(max(lowest, 1e-6)):6.1f} dB at most" if lowest < 1 else "   0 dB"
    bars = [f"{name:9}  {bar(share, _WIDTH)}  {said}" for name, share, said in loads]
    rest = [name for name in now if name not in _SPOKEN and name not in _NINE]
    names = [*_NINE[1:5], *rest]
    columns = names[::2], [*names[1::2], *[""] * (len(names) % 2)]
    first, second = (max(map(len, column)) for column in columns)
    counts = [
        f"{one:{first}}  {_cell(one, now, before, coloured)}  {two:{second}}  {_cell(two, now, before, coloured)}"
        for one, two in zip(*columns, strict=True)
    ]
    return [head, "", *bars, f"{'limiter':9}  {'':{_WIDTH}}  {limited}", "", *counts, "", verdict(now)]


def verdict(now: dict[str, object]) -> str:
    """Return in a sentence how the server fares, by the first trouble that a player can do something about."""
    troubles = (
        ("faults", "Some object was silenced, as its sound was not finite: free it."),
        ("underflows", "The device had {} dropout{s}: start with a larger --latency."),
        ("holes", "The process was stopped {} time{s}, and the sound with it."),
        ("contacts_dropped", "{} contact{s} left out: play fewer at once."),
        ("late", "{} message{s} came late: send them earlier."),
    )
    if _number(now, "load") > 100.0:
        return "The machine is too slow for what plays: stop some gestures, or raise /quality."
    for name, text in troubles:
        if count := int(_number(now, name)) if name in now else 0:
            return text.format(f"{count:,}", s="" if count == 1 else "s")
    if "quality" in now and _number(now, "quality") > 0:
        return f"The machine is busy: it plays at quality {_number(now, 'quality'):.0f}."
    if _number(now, "limiter_lowest") < 1:
        return "Too loud: lower /gain."
    return f"All is well: {_number(now, 'sounding'):.0f} of {_number(now, 'objects'):.0f} objects sound."


def _number(now: dict[str, object], name: str) -> float:
    return float(str(now[name]))


def _cell(name: str, now: dict[str, object], before: dict[str, object], coloured: bool) -> str:
    value = now.get(name, "")
    if isinstance(value, int | float):
        text = f"{value:,.0f}" if value == int(value) else f"{value:,.1f}"
    else:
        text = str(value)
    alarming = (name in _ALARMING and value) or (name in _FILES and value not in ("yes", "no"))
    style = ALARM if alarming and value != before.get(name, value) else YELLOW if alarming else ""
    return styled(f"{text:>12}", style if coloured else "")


def _latency(now: dict[str, object]) -> str:
    told = [f"{1e3 * float(str(now['latency'])):.1f} ms"]
    requested, measured = float(str(now["latency_requested"])), float(str(now["latency_measured"]))
    if requested >= 0:
        told.append(f"requested {1e3 * requested:.1f}")
    if measured > 0:
        told.append(f"measured {1e3 * measured:.1f}")
    return ", ".join(told)
