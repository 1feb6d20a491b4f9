"""Cost of space: many objects that ring, without places, with them, moving, and in a room.

`python -m tests.bench.space` measures in turns, and writes the figures of [space](../../server/space.md).
"""

import datetime
import json
from time import thread_time

import numpy as np

from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.runtime.engine import NOW, Engine
from carom.presets.library import Presets
from carom.server.osc.wire import Message
from carom.server.scene.session import Session
from tests.bench.machine import machine
from tests.documents import study

RATE, OBJECTS, MODES = 48_000, 200, 32
SECONDS, ROUNDS = 1.0, 12
FILE = study.MEASURED / "space.json"
_LISTENER = Message("/listener", (0, 0, 1.6, "layout", "pan"))
_BINAURAL = Message("/listener", (0, 0, 1.6, "layout", "binaural"))
_ROOM = Message("/room", (8, 6, 3, "x", -4, "y", -3, "t60", 0.5))
CASES = {
    "no space": ([], False),
    "places, panned": ([_LISTENER], False),
    "the same, all moving": ([_LISTENER], True),
    "places, binaural": ([_BINAURAL], False),
    "places, panned, in a room": ([_LISTENER, _ROOM], False),
    "places, binaural, in a room": ([_BINAURAL, _ROOM], False),
}
"""Messages that set a space up, and whether its objects move, by name."""


class Scene:
    """Objects that ring for long, all in one engine."""

    def __init__(self, said: list[Message], moves: bool) -> None:
        self._session, self._moves = Session(Engine(RATE), Presets()), moves
        for n in range(OBJECTS):
            made = (f"o{n}", "glass-plate", "most_modes", MODES, "decay", 100.0, "tune", 0.05 * n, "gain", -40.0)
            self._say(Message("/object/new", made))
            self._say(Message(f"/object/o{n}/impact", (1.0,)))
        for message in said:
            self._say(message)
        if said:
            self._place(0.0)
        self._session.engine.process(RATE // 2 // QUANTUM * QUANTUM)

    def _say(self, message: Message) -> None:
        replies = self._session.perform([message], NOW)
        assert all(reply.address != "/fail" for reply in replies), replies

    def _place(self, turn: float) -> None:
        """Send all to places on a ring, turned by an angle (rad); they take the time of a round to go there."""
        for n in range(OBJECTS):
            angle = turn + 2.0 * np.pi * n / OBJECTS
            place = 2.5 * np.cos(angle), 2.5 * np.sin(angle), 1.0
            over = ("over", 2.0 * SECONDS) if turn else ()
            self._say(Message(f"/object/o{n}/place", (*map(float, place), *over)))

    def cost(self, turn: float) -> float:
        """Return the share of a core that a second takes."""
        if self._moves:
            self._place(turn)
            self._session.engine.process(QUANTUM)
        begun = thread_time()
        self._session.engine.process(int(SECONDS * RATE) // QUANTUM * QUANTUM)
        return (thread_time() - begun) / SECONDS


def main() -> None:
    """Measure all cases in turns, print them and write them."""
    scenes = {name: Scene(said, moves) for name, (said, moves) in CASES.items()}
    costs = dict.fromkeys(scenes, np.inf)
    for turn in range(1, ROUNDS + 1):
        for name, scene in scenes.items():
            costs[name] = min(costs[name], scene.cost(0.3 * turn))
    for name, cost in costs.items():
        print(f"{name}: {100.0 * cost:.1f} %")
    made = {"date": datetime.date.today().isoformat(), "machine": machine(), "quick": False, "costs": costs}
    FILE.write_text(json.dumps(made, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
