"""Calls with which tests of the session speak to it."""

from typing import Any

from carom.dsp.runtime.engine import NOW
from carom.server.osc.wire import Argument, Message
from carom.server.scene.session import Session


def say(session: Session, address: str, *args: Argument, time: float = NOW, source: Any = None) -> list[Message]:
    """Send one message; return the replies."""
    return session.perform([Message(address, args)], time, source)


def refusal(session: Session, address: str, *args: Argument) -> str:
    """Return the reason for which a message is refused."""
    (reply,) = say(session, address, *args)
    assert reply.address == "/fail" and reply.args[0] == address
    return str(reply.args[1])


def seconds(session: Session, t: float) -> None:
    """Run for some seconds."""
    session.engine.process(int(t * session.engine.rate))


def ends(session: Session) -> list[tuple[str, Any]]:
    """Return the ids and sources of the gestures that have ended since the last call."""
    return [(ended.id, ended.source) for ended in session.take_ends()]
