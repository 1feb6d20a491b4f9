"""What the server says of itself."""

import time
from collections import deque
from importlib.metadata import version as installed_version

from ..dsp.host import Engine
from .network import Network
from .osc import Message

_COUNTERS = ("impacts", "contacts_dropped", "late", "limited", "faults", "underflows", "tap_lost")


class Status:
    """Answers /status and /version, and tells what went wrong since it was last asked."""

    def __init__(self, engine: Engine, latency: float) -> None:
        self._engine = engine
        self._latency = latency
        self._positions: deque[tuple[float, int]] = deque(maxlen=250)
        self._told = dict.fromkeys(_COUNTERS, 0)
        self._object_faults = engine.state["objects"]["faults"].copy()

    def tick(self) -> None:
        """Note how far the engine is; to be called regularly."""
        self._positions.append((time.monotonic(), self._engine.position))

    def actual_rate(self) -> float:
        """Hz, measured over the last seconds."""
        if len(self._positions) < 2:
            return self._engine.rate
        (t0, p0), (t1, p1) = self._positions[0], self._positions[-1]
        return (p1 - p0) / (t1 - t0)

    def reply(self, objects: int, network: Network) -> Message:
        """/status.reply: the nine values of scsynth's (1, live modes, sounding objects, objects, contacts, average and
        peak load in %, nominal and actual rate in Hz), then pairs of name and value."""
        count = self._engine.counter
        nine = (1, count("live_modes"), count("sounding"), objects, count("contacts_active"),
                100 * count("load"), 100 * count("load_peak"), self._engine.rate, self.actual_rate())  # fmt: skip
        pairs = [item for name in _COUNTERS for item in (name, count(name))]
        more = ("queued", count("queued"), "limiter_lowest", count("limit_lowest"), "latency", self._latency)
        heard = [item for pair in network.counts.items() for item in pair]
        return Message("/status.reply", (*nine, *pairs, *more, *heard, "connections", network.connections))

    def warnings(self, names: dict[int, str]) -> list[str]:
        """What went wrong since the last call, a line each; `names` are the objects' by slot."""
        lines = []
        for name, text in (
            ("contacts_dropped", "{} contacts left out: too many at once"),
            ("late", "{} events came too late for their time and were played at once"),
            ("tap_lost", "{} frames are missing in the recording: the disk is too slow"),
            ("underflows", "{} times the device was not served in time"),
        ):
            now = self._engine.counter(name)
            if now > self._told[name]:
                lines.append(text.format(now - self._told[name]))
                self._told[name] = now
        faults = self._engine.state["objects"]["faults"][0]
        for slot in (faults > self._object_faults[0]).nonzero()[0]:
            lines.append(f"object {names.get(int(slot), '(freed)')} was silenced: its sound was not finite")
        self._object_faults[0] = faults
        return lines


def version() -> Message:
    """/version.reply: name, major, minor, patch."""
    major, minor, patch = (int(part) for part in installed_version("carom").split(".")[:3])
    return Message("/version.reply", ("carom", major, minor, patch))
