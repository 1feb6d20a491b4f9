"""The options of a server."""

from dataclasses import dataclass
from ipaddress import IPv4Network, IPv6Network, ip_network
from pathlib import Path

from ..dsp.engine.memory.capacity import MODES, OBJECTS, USUAL_MODES, USUAL_OBJECTS
from ..dsp.engine.memory.commands import Command, Kind
from ..dsp.engine.memory.mounted import SENSORS
from ..dsp.errors import CaromError
from ..dsp.numerics.constants import FULL_SCALE_PRESSURE
from ..dsp.runtime.engine import NOW, Engine
from ..dsp.runtime.meter import SILENCE
from ..dsp.schema import CHANNELS, FORMS, FULL_SCALE, MAIN_GAIN
from ..dsp.wording import expected
from .osc.arguments import shown
from .osc.wire import DEFAULT_PORT, MOST_PORT, Message
from .render import HIGHEST_RATE, LOWEST_RATE
from .scene.scale import Scale
from .scene.sensing import last_of_sensors

BUDGET = (16, 8_192)
"""Budget at a server's start (/budget): steps per sample of a coupled contact, and modes coupled at once."""
LOSSES = {
    "contacts_dropped": "left out {} contact{s}{more}: play fewer at once, or set a larger /budget",
    "over_budget": "/budget was too small {} time{s}: a force was held for a sample, or a contact not coupled to modes",
    "strikers_cut": "cut {} striker{s} short: too many sounded at once",
    "late": "{} message{s} came late",
    "ramps_dropped": "{} change{s} took effect immediately: too many were in progress",
    "nonlinear_dropped": "{} blow{s} did not make a plate swell: too many plates swell at once",
    "tap_lost": "the recording lacks {} frame{s}: the disk is too slow",
    "underflows": "the device had {} dropout{s}: set a larger --latency",
    "ends_lost": "did not report the end of {} gesture{s}: too many ended at once",
    "faults": "silenced objects {} time{s}: their sound was not finite",
}
"""Sentences about counts of the engine, by name."""
_LONGEST_LATENCY = 2.0  # s


def loss_of(name: str, count: int, loudest: float = SILENCE) -> str:
    """Return a sentence about a count of LOSSES; of contacts, with the loudness (LUFS) of the loudest."""
    more = f", of at most {loudest:.0f} LUFS" if loudest > SILENCE else ""
    return LOSSES[name].format(count, s="" if count == 1 else "s", more=more)


class ServeError(CaromError, ValueError):
    """A server can't start. The text names the option, its value and what was expected."""


@dataclass(frozen=True)
class Options:
    """Options of a server: port (0: any free one) and address, networks whose hosts are trusted to be who they say,
    device (None: the default), latency to ask it for in s (None: its lowest), rate in Hz, block in frames (0: the
    device's), files to record the sound and to log the events to, folders of presets, a port for HTTP
    (None: none, 0: any free one), the folder of the page that is there beside OSCQuery (None: no page), whether it goes
    over TLS, with the certificate of which file (None: one that is made), channels, and those for sensors, the main
    gain in dB, whether the limiter and the automatic level ahead of it are on, room for modes and objects, the form in
    which the spectral bank keeps its modes, a folder for what clients record, with the most bytes that all files in it
    may have, the MIDI inputs that play, by index or part of a name, and the pressure (Pa) of full scale, of an object
    of level 0."""

    port: int = DEFAULT_PORT
    bind: str = "127.0.0.1"
    trust: tuple[str, ...] = ()
    device: str | None = None
    latency: float | None = None
    rate: int = 48_000
    block: int = 0
    record: Path | None = None
    log: Path | None = None
    presets: tuple[Path, ...] = ()
    web: int | None = None
    page: Path | None = None
    tls: bool = False
    certificate: Path | None = None
    channels: int = 2
    sensors: int = 0
    gain: float = 0.0
    limiter: bool = True
    headroom: bool = True
    modes: int = USUAL_MODES
    objects: int = USUAL_OBJECTS
    bank: str = FORMS[0]
    recordings: Path | None = None
    quota: int = 10**10
    midi: tuple[str, ...] = ()
    full_scale: float = FULL_SCALE_PRESSURE

    def __post_init__(self) -> None:
        for name, value, low, high in (
            ("port", self.port, 0, MOST_PORT),
            ("rate", self.rate, LOWEST_RATE, HIGHEST_RATE),
            ("block", self.block, 0, 65_536),
            ("page" if self.page else "oscquery", self.web or 0, 0, MOST_PORT),
            ("channels", self.channels, CHANNELS.low, CHANNELS.high),
            ("sensors", self.sensors, 0, min(SENSORS, CHANNELS.high - self.channels)),
            ("gain", self.gain, MAIN_GAIN.low, MAIN_GAIN.high),
            ("full_scale", self.full_scale, FULL_SCALE.low, FULL_SCALE.high),
            ("modes", self.modes, 1, MODES),
            ("objects", self.objects, 1, OBJECTS),
            ("quota", self.quota, 0, 2**63),
        ):
            if not low <= value <= high:
                raise ServeError(f"{name} = {shown(value)}: expected {low:g} to {high:g}")
        if self.latency is not None and not 0 <= self.latency <= _LONGEST_LATENCY:
            raise ServeError(f"latency = {shown(self.latency)}: expected 0 to {_LONGEST_LATENCY:g} s")
        _ = self.trusted
        if self.bank not in FORMS:
            raise ServeError(f"bank = {self.bank}: {expected(self.bank, FORMS)}")

    @property
    def trusted(self) -> list[IPv4Network | IPv6Network]:
        """The networks that are trusted; ServeError names one that is none."""
        return [_network(each) for each in self.trust]

    def engine(self) -> Engine:
        """Make an engine that begins with them."""
        engine = Engine(self.rate, self.channels, self.modes, self.objects, limited=True, sensors=self.sensors)
        gain = Command(NOW, Kind.GAIN, value=MAIN_GAIN.in_engine(self.gain))
        steps, modes = BUDGET
        budget = Command(NOW, Kind.BUDGET, values={"steps": steps, "modes": modes})
        bank = Command(NOW, Kind.BANK, value=FORMS.index(self.bank))
        headroom = Command(NOW, Kind.HEADROOM, value=self.headroom)
        engine.send([gain, Command(NOW, Kind.LIMITER, value=self.limiter), headroom, budget, bank])
        return engine

    @property
    def scale(self) -> Scale:
        """The scale of the samples."""
        return Scale(full_scale=self.full_scale)

    @property
    def said(self) -> str:
        """Meaning of its channels, for the metadata of recordings."""
        if self.sensors == 0:
            return self.scale.said
        return f"{self.scale.said}; {last_of_sensors(self.sensors)}"

    @property
    def head(self) -> list[Message]:
        """The messages that a log begins with."""
        limiter, headroom = ("on" if each else "off" for each in (self.limiter, self.headroom))
        return [
            Message("/channels", (self.channels,)),
            *([Message("/sensors", (self.sensors,))] if self.sensors else []),
            Message("/full_scale", (self.full_scale,)),
            Message("/limiter", (limiter,)), Message("/headroom", (headroom,)), Message("/gain", (self.gain,)),
            Message("/budget", BUDGET), Message("/bank", (self.bank,)),
        ]  # fmt: skip


def _network(text: str) -> IPv4Network | IPv6Network:
    try:
        return ip_network(text)
    except ValueError as error:
        raise ServeError(f"trust = {text}: {error}: expected a network such as 192.168.1.0/24, or a host") from None
