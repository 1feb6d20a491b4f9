"""A log of what is played with make-up renders to what was heard."""

import random

from carom.server.options import Options as Serving
from carom.server.osc.wire import Message
from tests.server.files.test_log import replay


def test_what_is_played_with_make_up_and_headroom(tmp_path):
    """A server's headroom works, as it is too loud, and gestures have make-up, that of a roll as it is steered."""
    rng = random.Random(5)
    made = [Message("/object/new", ("bell", "church-bell")), Message("/object/new", ("floor", "wooden-floor"))]
    rolls = [
        Message("/object/floor/roll", (0.1, "id", "r", "seed", 2)),
        Message("/gesture/r/speed", (1.0, "over", 0.1)),
    ]
    told = iter([[Message("/gain", (20.0,)), Message("/play", ("on",)), *made], rolls])

    def messages() -> list[Message]:
        velocity = rng.choice((0.1, 1.0, 4.0))
        struck = Message("/object/bell/impact", (velocity, "striker", rng.choice(("fingertip", "hammer"))))
        return next(told, [struck, Message("/object/bell/note", (60, 100, "play", 1))])

    lines = replay(tmp_path, rng, messages, 30, Serving())
    struck = [line.message for line in lines if line.message.address.endswith(("/impact", "/roll"))]
    assert struck and all("play" in message.args for message in struck)
