"""What the server says of itself."""

from importlib.metadata import version as installed_version

from ..dsp.contact.accuracy import LEVELS
from ..dsp.runtime.engine import Engine
from .audio.supervisor import Player
from .net.network import Network
from .osc.wire import Message

_COUNTERS = (
    "impacts",
    "coupled",
    "recontacts",
    "held",
    "contacts_dropped",
    "late",
    "limited",
    "faults",
    "underflows",
    "tap_lost",
)


class Status:
    """Answers /status and /version, and tells what went wrong since it was last asked."""

    def __init__(self, engine: Engine, player: Player) -> None:
        self._engine = engine
        self._player = player
        self._told = dict.fromkeys(_COUNTERS, 0)
        self._object_faults = engine.state["objects"]["faults"].copy()

    def reply(self, objects: int, network: Network, keeping: dict[str, str]) -> Message:
        """/status.reply: the nine values of scsynth's (1, live modes, sounding objects, objects, contacts, average and
        peak load in %, nominal and actual rate in Hz), then pairs of name and value; `keeping` says what becomes of the
        files that are written."""
        count = self._engine.counter
        load = 100 * count("load"), 100 * count("load_peak")
        rates = self._engine.rate, self._engine.measured_rate
        nine = (1, count("live_modes"), count("sounding"), objects, count("contacts_active"), *load, *rates)
        pairs = [item for name in _COUNTERS for item in (name, count(name))]
        more = {
            "queued": count("queued"),
            "rolls": count("rolls_active"),
            "accuracy": LEVELS[count("accuracy")],
            "quality": count("quality"),
            "overruns": count("overruns"),
            "limiter_lowest": count("limit_lowest"),
            "latency": self._player.latency,
            "latency_requested": -1.0 if self._player.requested is None else self._player.requested,
            "latency_measured": count("latency_measured"),
            "late_last_ms": 1e3 * count("late_last"),
            "late_worst_ms": 1e3 * count("late_worst"),
            "device": self._player.name,
            "reconnects": self._player.reconnects,
            "scheduling": self._player.scheduling,
            **network.counts,
            "connections": network.connections,
            **keeping,
            "time": self._engine.position / self._engine.rate,
        }
        return Message("/status.reply", (*nine, *pairs, *(item for pair in more.items() for item in pair)))

    def warnings(self, names: dict[int, str]) -> list[str]:
        """What went wrong since the last call, a line each; `names` are the objects' by slot."""
        lines = []
        for name, text in (
            ("contacts_dropped", "{} contacts left out: too many at once"),
            ("late", "{} events came too late for their time and were played at once, the last by {late_last:.1f} ms"),
            ("tap_lost", "{} frames are missing in the recording: the disk is too slow"),
            ("underflows", "{} times the device was not served in time"),
        ):
            now = self._engine.counter(name)
            if now > self._told[name]:
                late_last = 1e3 * self._engine.counter("late_last")
                lines.append(text.format(now - self._told[name], late_last=late_last))
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
