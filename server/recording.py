"""The handling of /record, and who is notified of it."""

from collections.abc import Callable, Iterator

from ..dsp.runtime.engine import Engine
from .files.log import Log
from .files.takes import Takes
from .net.network import Source
from .osc.arguments import Refused, Values
from .osc.wire import Message
from .scene.session import fail

RECORD = "/record"


class Recording:
    """Carries out /record, where `takes` says in which folder."""

    def __init__(
        self,
        engine: Engine,
        log: Log | None,
        reply: Callable[[Message, Source], object],
        warn: Callable[[str], None],
    ) -> None:
        self.takes: Takes | None = None
        self._engine = engine
        self._log, self._reply, self._warn = log, reply, warn
        self._asked: Source = ("", 0)  # for the take that goes on

    @property
    def state(self) -> str:
        """The file that is written, no, or why the last one ended."""
        return self.takes.state if self.takes else "no"

    def asked(self, values: Values, source: Source) -> Iterator[Message]:
        """Begin or end a take; its beginning is answered at once, its end by `look`. Refused says why not."""
        if not self.takes:
            raise Refused("this server has no folder for recordings: expected it to be started with --recordings")
        name = values.words.get("name", "")
        if values.numbers["on"]:
            take = self.takes.start(name)
            self._remark(take.first, f"{RECORD} 1: {take.file} begins")
            yield Message("/done", (RECORD, take.file, take.first))
        elif name:
            raise Refused(f"name = {name}: expected none at the end of a recording")
        else:
            self.takes.stop()
        self._asked = source

    def look(self) -> None:
        """Report a take that has ended."""
        if not self.takes or not (ended := self.takes.look()):
            return
        take, reason = ended
        self._remark(take.end, f"{RECORD} 0: {take.file} ends")
        if reason:
            self._reply(fail(RECORD, f"{take.file}: {reason}"), self._asked)
            self._warn(f"the recording {take.file} ended: {reason}")
        else:
            self._reply(Message("/done", (RECORD, take.file, take.first, take.end)), self._asked)

    def tell_hole(self, frame: int, text: str) -> str:
        """Remark in the log that the sound stood still before a frame; return the text with its places in the sound,
        which a recording by `--record` shares, and in the take that goes on."""
        self._remark(frame, text)
        rate = self._engine.rate
        take = self.takes.now if self.takes else None
        place = f", {(frame - take.first) / rate:.3f} s in {take.file}" if take and take.first <= frame else ""
        return f"{text}: {frame / rate:.3f} s in the sound{place}"

    def _remark(self, frame: int, text: str) -> None:
        if self._log:
            self._log.remark(frame, text)
