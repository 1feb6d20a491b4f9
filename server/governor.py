"""Chooses the quality by the load: it steps down before the sound breaks up, and up again when there is time.

With little load it takes a step upwards in 4 s, with very little one each second. At a load in between, a step upwards
is tried now and then. Each try that has to be taken back doubles the wait for the next. Steps upwards that may double
the load are not tried.

Each choice goes to the session as /quality, so that a log renders to the same sound.
"""

import math
from collections import deque

from ..dsp.engine.memory.state import Quality
from ..dsp.runtime.engine import Engine
from .osc.wire import Message

_TOO_MUCH = 0.8  # load, averaged over a tenth of a second
_LITTLE = 0.4  # load, averaged over a second
_BETWEEN = 0.2  # s from step to step downwards: as long as it takes to see the effect of one
_SOON = 0.05  # s, after a step upwards
_CALM = 4.0  # s of little load before a step upwards
_ROOM = 0.2  # load, averaged over a second: with so little a step upwards that doubles it leaves it little
_SPARE = 1.0  # s of so little load before a step upwards
_BEARABLE = 0.75  # load, averaged over a second, at which a step upwards is tried
_PATIENCE = 10.0  # s of bearable load before the first try; twice as long after each that failed
_LONGEST_PATIENCE = 160.0  # s
_FURTHEST_TRY = Quality.QUIET  # from beyond it, a step upwards may double the load: only little load will do
_IN_A_ROW = 0.2  # s: so soon after another a late block is a burst's
_OFTEN = 4  # late blocks within _LATELY that are those of bursts, too
_LATELY = 3.0  # s
_LAST_FOR_BURSTS = Quality.QUIET


class Governor:
    """Decides on the quality by the load of the engine's callback."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._stepped = 0.0
        self._calm_since = self._bearable_since = self._spare_since = 0.0
        self._patience, self._tried = _PATIENCE, -math.inf
        self._overruns = 0
        self._late = deque([-math.inf] * _OFTEN, _OFTEN)
        self._best = Quality.FULL

    def note_request(self, message: Message) -> None:
        """Remember the quality that a message asks for: the governor does not go beyond it from now on."""
        if message.address == "/quality":
            self._best = next((quality for quality in Quality if (quality,) == message.args), self._best)

    def decide(self, now: float) -> Quality | None:
        """Return the quality to change to, None to stay; to be called every few hundredths of a second with the time
        (s)."""
        quality, stats = self._engine.quality, self._engine.stats
        load, overruns = stats.load, stats.overruns
        burst = self._note_overruns(now, overruns) and load > _LITTLE and quality < _LAST_FOR_BURSTS
        if load > _ROOM:
            self._spare_since = now
        if load > _LITTLE:
            self._calm_since = now
        if load > _BEARABLE or quality > _FURTHEST_TRY:
            self._bearable_since = now
        if burst or stats.load_now > _TOO_MUCH:
            tried = now - self._tried < max(_PATIENCE, self._patience)
            if quality < max(Quality) and now - self._stepped >= (_SOON if tried else _BETWEEN):
                if tried:
                    self._patience, self._tried = min(2.0 * self._patience, _LONGEST_PATIENCE), -math.inf
                self._stepped = now
                return Quality(quality + 1)
        elif quality > self._best:
            calm = now - max(self._calm_since, self._stepped) >= _CALM
            calm = calm or now - max(self._spare_since, self._stepped) >= _SPARE
            bearable = now - max(self._bearable_since, self._stepped) >= self._patience
            if calm or (bearable and stats.load_now <= _BEARABLE):
                self._patience, self._tried = (_PATIENCE if calm else self._patience), now
                self._stepped = now
                return Quality(quality - 1)
        return None

    def _note_overruns(self, now: float, overruns: int) -> bool:
        """Note how many blocks were late; whether those of late are a burst's. One alone is the system's doing."""
        new, self._overruns = overruns - self._overruns, overruns
        self._late.extend([now] * new)
        return new > 0 and (self._late[-1] - self._late[-2] <= _IN_A_ROW or now - self._late[0] <= _LATELY)
