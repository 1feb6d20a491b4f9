"""Keeps the sound whole when there is too little time: quality steps down before it breaks up, and up again after.

What it decides goes to the scene as /quality, so that a log of it renders to the same sound.
"""

from ..dsp.engine.state import Quality
from ..dsp.runtime.engine import Engine
from .osc.wire import Message

_TOO_MUCH = 0.8  # of the time there is, on average over a tenth of a second
_LITTLE = 0.4  # on average over a second
_BETWEEN = 0.2  # s from step to step downwards: as long as it takes to see what one brings
_CALM = 4.0  # s of little load before a step upwards
_LAST_FOR_BURSTS = Quality.QUIET


class Governor:
    """Decides on the quality by the load of the engine's callback."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._stepped = 0.0
        self._calm_since = 0.0
        self._overruns = 0
        self._best = Quality.FULL

    def heed(self, message: Message) -> None:
        """Don't go beyond the quality that a message asks for, if it does."""
        if message.address == "/quality":
            self._best = next((quality for quality in Quality if (quality,) == message.args), self._best)

    def decide(self, now: float) -> Quality | None:
        """The quality from now (s) on, if it is to be another one; to be called regularly."""
        quality = Quality(self._engine.counter("quality"))
        load = self._engine.counter("load")
        overruns = self._engine.counter("overruns")
        # With little load on average it was the system that took the time; with more it was a burst of contacts.
        burst = overruns > self._overruns and load > _LITTLE and quality < _LAST_FOR_BURSTS
        self._overruns = overruns
        if load > _LITTLE:
            self._calm_since = now
        if burst or self._engine.counter("load_now") > _TOO_MUCH:
            if quality < max(Quality) and now - self._stepped >= _BETWEEN:
                self._stepped = now
                return Quality(quality + 1)
        elif quality > self._best and now - max(self._calm_since, self._stepped) >= _CALM:
            self._stepped = now
            return Quality(quality - 1)
        return None
