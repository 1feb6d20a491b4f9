"""The replies to /status and /version, and warnings of what went wrong."""

import math
from collections.abc import Callable, Mapping
from functools import cache
from importlib.metadata import version as installed_version

import numpy as np

from ..dsp.runtime.engine import Engine
from ..dsp.runtime.meter import SILENCE
from .audio.supervisor import Player
from .limiting import LimiterWatch
from .net.network import Network, Source
from .options import LOSSES, loss_of
from .osc.wire import Message

_COUNTERS = (
    "impacts",
    "coupled",
    "recontacts",
    "held",
    "over_budget",
    "contacts_dropped",
    "strikers_cut",
    "late",
    "limited",
    "faults",
    "underflows",
    "holes",
    "tap_lost",
    "ramps_dropped",
    "nonlinear_dropped",
)
FIRST = (
    "always 1",
    "modes that ring",
    "objects that sound",
    "objects",
    "contacts that are in progress or wait",
    "average load, % of the available time",
    "peak load, %, falling slowly",
    "nominal sampling rate, Hz",
    "sampling rate as measured, Hz",
)
"""The values that /status.reply begins with, those of scsynth's."""

FIELDS = {
    **dict.fromkeys(_COUNTERS, ""),
    "queued": "events that wait for their time",
    "channels": "number of channels",
    "gain": "level of everything, dB",
    "limiter": "limiter, on or off",
    "headroom": "present gain of headroom, dB; or `off`",
    "rolls": "bodies that roll or slide",
    "nonlinear": "plates whose modes are coupled",
    "accuracy": "setting of `/accuracy`",
    "quality": "present quality, 0 to 8",
    "bank": "setting of `/bank`",
    "budget": "setting of `/budget`: steps per sample and modes at once",
    "overruns": "",
    "ends_lost": "reports of gestures' ends that were left out because there were too many",
    "limiter_lowest": "lowest gain of the limiter since this client last asked; 1: no reduction",
    "peak": "highest amplitude in the last 0.4 s, dB of full scale; -200: silence",
    "loudness": "momentary loudness (ITU-R BS.1770), LUFS",
    "latency": "latency of the device and the limiter, s",
    "latency_requested": "setting of `--latency`, s; -1: none",
    "latency_measured": "",
    "late_last_ms": "delay of the last late event, ms",
    "late_worst_ms": "greatest delay of a late event, ms",
    "device": "name of the device",
    "reconnects": "times that a lost device was opened again",
    "scheduling": "scheduling of the audio thread: fifo or rr (real-time), other, or unknown",
    "dropped": "datagrams dropped by the server, for lack of capacity",
    "dropped_by_system": "datagrams dropped by the operating system, for lack of capacity",
    "outdated": "questions over UDP that were dropped after 2 s",
    "replies_dropped": "replies lost because clients read too slowly; for UDP, only local clients on Linux are counted",
    "connections": "TCP clients",
    "waiting": "clients whose messages wait for their turn, or for an object to be made",
    "full_scale": "pressure of a sample of 1.0 for objects of level 0 dB, Pa",
    "recording": "yes, no, or why the recording of `--record` ended",
    "logging": "yes, no, or why the log ended",
    "take": "name of `/record`'s file, `no`, or why the last recording ended",
    "midi": "open MIDI inputs, or `no`",
    "pages": "clients over web sockets",
    "reports_dropped": "reports of contacts to `/notify` that were left out because there were too many",
    "time": "time of the sound since the server's start, s",
}
"""The names that follow in /status.reply and their meanings; an empty one is that of the engine's statistics."""

_MOST_CLIENTS = 256  # whose last question is remembered
_RESTS = 0.2  # s without the limiter, after which its work is reported
_SAID_EVERY = 2.0  # s after which it is reported in any case


class LowestGain:
    """The limiter's lowest gain (amplitude, 1: it did nothing) since each client last asked."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._since_any = self._since_told = 1.0
        self._since: dict[Source, float] = {}  # who asked last comes last

    def since_last_asked(self, client: Source) -> float:
        """Return the lowest gain since this client last asked; at its first question, since any client did.

        The audio thread lowers the engine's value while this reads it and sets it back to 1: of one quantum in between
        the lowest gain may be lost, or be repeated at the next question.
        """
        self._collect()
        answer = self._since.pop(client, self._since_any)
        self._since[client] = self._since_any = 1.0
        if len(self._since) > _MOST_CLIENTS:
            del self._since[next(iter(self._since))]
        return answer

    def since_last_told(self) -> float:
        """Return the lowest gain since the last call of this, for a warning."""
        self._collect()
        answer, self._since_told = self._since_told, 1.0
        return answer

    def _collect(self) -> None:
        now = self._engine.take_limit_lowest()
        self._since = {each: min(lowest, now) for each, lowest in self._since.items()}
        self._since_any, self._since_told = min(self._since_any, now), min(self._since_told, now)


class Status:
    """Answers /status and /version, and reports what went wrong since the last look."""

    def __init__(self, engine: Engine, player: Player, names: Callable[[], Mapping[int, str]]) -> None:
        """Begin to observe an engine and its player. names: of the objects, by their places in the engine."""
        self._engine = engine
        self._player = player
        self._names = names
        self.lowest_gain = LowestGain(engine)
        self._watch = LimiterWatch(engine, names, self.lowest_gain.since_last_told)
        self._limited_from: int | None = None
        self._limited_to = 0
        self._warned = dict.fromkeys((*_COUNTERS, "ends_lost"), 0)
        self._object_faults = engine.objects["faults"].copy()

    def reply(self, client: Source, objects: int, network: Network, own: Mapping[str, float | str]) -> Message:
        """Return the /status.reply to a client, of a server with a number of objects; `own` is what the server says of
        itself.

        It begins with scsynth's nine values (1, live modes, sounding objects, objects, contacts, average and peak load
        in %, nominal and actual rate in Hz); pairs of name and value follow. Counters are since the server's start;
        `limiter_lowest` is the limiter's lowest gain since this client last asked.
        """
        stats = self._engine.stats
        load = 100 * stats.load, 100 * stats.load_peak
        rates = self._engine.rate, self._engine.measured_rate
        nine = (1, stats.live_modes, stats.sounding, objects, stats.contacts_active, *load, *rates)
        pairs = [item for name in _COUNTERS for item in (name, getattr(stats, name))]
        more: dict[str, float | str] = {
            "queued": self._engine.queued,
            "channels": self._engine.channels,
            "gain": 20.0 * math.log10(self._engine.gain),
            "limiter": "on" if self._engine.limiter else "off",
            "headroom": 20.0 * math.log10(stats.headroom) if self._engine.headroom else "off",
            "rolls": stats.rolls_active,
            "nonlinear": stats.nonlinear_active,
            "accuracy": self._engine.accuracy,
            "quality": int(self._engine.quality),
            "bank": self._engine.bank,
            "budget": " ".join(map(str, self._engine.budget)),
            "overruns": stats.overruns,
            "ends_lost": self._engine.ends_lost,
            "limiter_lowest": self.lowest_gain.since_last_asked(client),
            "peak": max(self._engine.meter.peaks()),
            "loudness": self._engine.meter.loudness,
            "latency": self._player.latency + self._engine.delay / self._engine.rate,
            "latency_requested": -1.0 if self._player.requested is None else self._player.requested,
            "latency_measured": stats.latency_measured + self._engine.delay / self._engine.rate,
            "late_last_ms": 1e3 * stats.late_last,
            "late_worst_ms": 1e3 * stats.late_worst,
            "device": self._player.name,
            "reconnects": self._player.reconnects,
            "scheduling": self._player.scheduling,
            **network.counts,
            "connections": network.connections,
            **own,
            "time": self._engine.position / self._engine.rate,
        }
        return Message("/status.reply", (*nine, *pairs, *(item for pair in more.items() for item in pair)))

    def warnings(self) -> list[str]:
        """Return a line for each thing that went wrong since the last call."""
        lines = self._limiter_warnings()
        stats = self._engine.stats
        for name in (each for each in LOSSES if each != "faults"):
            now = getattr(self._engine if name == "ends_lost" else stats, name)
            if now > self._warned[name]:
                late = f", the last by {1e3 * stats.late_last:.1f} ms: send them earlier" if name == "late" else ""
                loudest = self._engine.take_loudest_dropped() if name == "contacts_dropped" else SILENCE
                lines.append(f"{loss_of(name, now - self._warned[name], loudest)}{late}")
                self._warned[name] = now
        faults = self._engine.objects["faults"].copy()
        before = np.pad(self._object_faults, (0, len(faults) - len(self._object_faults)))
        for slot in (faults > before).nonzero()[0]:
            lines.append(f"object {self._names().get(int(slot), '(freed)')} was silenced: its sound was not finite")
        self._object_faults = faults
        return lines

    def hole(self) -> tuple[int, str] | None:
        """Return the frame before which the sound stood still since the last call, and how long; None if it did
        not."""
        stats = self._engine.stats
        count = stats.holes - self._warned["holes"]
        self._warned["holes"] = stats.holes
        more = f", and {count - 1} times before" if count > 1 else ""
        text = f"the sound was stopped for {stats.hole_last:.2f} s{more}, as the process or its device was stopped"
        return (stats.hole_at, text) if count else None

    def _limiter_warnings(self) -> list[str]:
        """Return a line about the limiter, once it has rested for a while, or has gone on for long."""
        now = self._engine.position
        if self._watch.look():
            self._limited_from = now if self._limited_from is None else self._limited_from
            self._limited_to = now
        if self._limited_from is None:
            return []
        rests = now - self._limited_to > _RESTS * self._engine.rate
        if not rests and now - self._limited_from < _SAID_EVERY * self._engine.rate:
            return []
        self._limited_from = None
        return [self._watch.take().said()]


@cache
def version() -> Message:
    """Return /version.reply: name, major, minor, patch."""
    major, minor, patch = (int(part) for part in installed_version("carom").split(".")[:3])
    return Message("/version.reply", ("carom", major, minor, patch))
