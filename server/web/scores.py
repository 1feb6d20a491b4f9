"""Scores that a page drops on the table: read by the server, and played as if the page had sent each message."""

import asyncio
import time

from ..net.network import Network
from ..net.remote import Remote
from ..osc.score import Line, ScoreError, parse
from ..osc.wire import encode_bundle, time_tag

LARGEST_SCORE = 1 << 20  # bytes: what aiohttp takes of a body
MOST_SCORES = 4 << 20  # bytes of all scores that are being played: in memory each takes up to some hundred times that
_LEAD = 0.2  # s until the first message
_AHEAD = 1.0  # s that a message is handed in before its time
_MOST_WAITING = 256  # of the client's messages, before another is handed in


def read_score(data: bytes) -> list[Line]:
    """Return the lines of a score in the order of their times. ScoreError says what is wrong with it."""
    lines = sorted(parse(data, "score"), key=lambda line: line.time)
    if refused := [line for line in lines if line.message.address == "/quit"]:
        raise ScoreError(f"{refused[0].where}: /quit: a page can't end the server")
    return lines


async def play_score(lines: list[Line], client: Remote, network: Network) -> None:
    """Hand in a score's messages, each a second before its time; replies go to the client."""
    start = time.time() + _LEAD
    for line in lines:
        while (wait := start + line.time - time.time() - _AHEAD) > 0:
            await asyncio.sleep(min(wait, _AHEAD))
        while len(client.arrived) > _MOST_WAITING:
            await asyncio.sleep(0.01)
        network.doorway.hand_in(client, encode_bundle(time_tag(start + line.time), [line.message], real="d"))
