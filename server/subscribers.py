"""The clients that requested /notify."""

import time
from collections import Counter
from collections.abc import Callable, Iterator

from .net.network import LONGEST_SILENCE, Network, Source, host_of
from .osc.arguments import Refused
from .osc.wire import Message

_MOST = 32
_LONGEST_TRUST = 60.0  # s of silence after which a client of another host gets no more: it may have been forged


class Subscribers:
    """Clients that are notified of what no message caused; one that has long been silent makes room for a new one."""

    def __init__(self, network: Network, reply: Callable[[Message, Source], object]) -> None:
        self._network = network
        self._reply = reply
        self._heard: dict[Source, float] = {}  # when each last sent something
        self._levels: dict[Source, int] = {}
        self._ports: dict[Source, int] = {}  # of datagrams to those that want them elsewhere

    def __iter__(self) -> Iterator[Source]:
        return iter(tuple(self._heard))

    def of(self, level: int) -> list[Source]:
        """Return those that requested a level or a higher one."""
        return [source for source in self if self._levels[source] >= level]

    def receiver(self, source: Source) -> Source:
        """Return where answers to a source go."""
        if isinstance(source, tuple) and source in self._ports:
            return source[0], self._ports[source]
        return source

    def add(self, source: Source, level: int = 1, port: int = 0) -> None:
        """Add a client, or hear from one again; `port`: where its answers go, if not to where it sends from.

        Whoever is answered there already is the same client, that sends from another port now. Refused where there is
        no room.
        """
        if port and not isinstance(source, tuple):
            raise Refused(f"port = {port}: a stream gets its answers itself; expected none")
        answered = (source[0], port) if port and isinstance(source, tuple) else self.receiver(source)
        for each in self:
            if not self._network.reaches(each) or (each != source and self.receiver(each) == answered):
                self.remove(each)
        if source not in self._heard and len(self._heard) >= _MOST:
            self._make_room(host_of(source))
        self._heard[source] = time.monotonic()
        self._levels[source] = level
        if port:
            self._ports[source] = port

    def _make_room(self, host: str) -> None:
        """Forget who has long been silent, else who was silent for longest of a host that has two places more than the
        newcomer's: no host takes them all. Refused where there is none such."""
        silent = min(self._heard, key=self._heard.__getitem__)
        if time.monotonic() - self._heard[silent] <= LONGEST_SILENCE:
            hosts = Counter(map(host_of, self._heard))
            largest = max(hosts, key=hosts.__getitem__)
            if hosts[largest] < hosts[host] + 2:
                raise Refused(f"{_MOST} clients are notified already; expected one to send /notify 0 first")
            silent = min((each for each in self._heard if host_of(each) == largest), key=self._heard.__getitem__)
        text = "another client took your place: send /notify 1 to be notified again"
        self._reply(Message("/warning", (text,)), silent)
        self.remove(silent)

    def remove(self, source: Source) -> None:
        """Forget a client, if it is one."""
        self._heard.pop(source, None)
        self._levels.pop(source, None)
        self._ports.pop(source, None)

    def lapse(self) -> None:
        """Forget the clients elsewhere that have long been silent."""
        late = time.monotonic() - _LONGEST_TRUST
        for source in [each for each, heard in self._heard.items() if heard < late and self._network.forgets(each)]:
            self.remove(source)

    def hear(self, source: Source) -> None:
        """Remember that a client has sent something."""
        if source in self._heard:
            self._heard[source] = time.monotonic()
