"""Random traffic of all verbs, with time tags and every quality, at a server: does its log render to its recording?

`python -m tests.bench.logs --runs 30` starts a server for each run, and fails where one sample differs.
"""

import argparse
import random
import sys
import tempfile
import time
from pathlib import Path

import soundfile

from carom.clients.client import Client
from carom.server.osc.addresses import VERBS
from carom.server.osc.score import read
from carom.server.osc.wire import Message
from tests.bench.declared import declared
from tests.support import render_lines, serving


def _takes_time(rng: random.Random) -> tuple[str | float, ...]:
    """Return keys of a change that takes its time, or none."""
    return rng.choice(((), ("over", rng.uniform(0.0, 0.3)), ("over", 0.1, "curve", rng.uniform(-6.0, 6.0))))


def random_message(rng: random.Random) -> Message:
    name = rng.choice("abcd")
    match rng.randrange(16):
        case 0 | 1:
            return Message(
                "/object/new", (name, rng.choice(("wood-block", "glockenspiel-bar", "triangle")), "gain", -6)
            )
        case 2:
            return Message(f"/object/{rng.choice((name, '*'))}/free", (rng.randrange(2),))
        case 3:
            return Message("/panic")
        case 4:
            return Message("/quality", rng.choice(((0,), (1,), (9,))))
        case 5:
            action = rng.choice(("damp", "pan", "gain", "decay", "tune"))
            return Message(
                f"/object/{rng.choice((name, '[a-c]'))}/{action}", (rng.uniform(0.01, 0.9), *_takes_time(rng))
            )
        case 6:
            height = rng.choice((0.0, 0.001, 0.02))
            return Message(f"/object/{name}/bounce", (height, "irregularity", 0.5, *rng.choice(((), ("id", "x")))))
        case 7:
            speed = rng.choice((0.0, 0.3, 1.0))
            return Message(f"/object/{name}/roll", (speed, "striker", "steel", *rng.choice(((), ("id", "x")))))
        case 8:
            if rng.random() < 0.5:
                return Message(f"/object/{name}/spin", (rng.choice((0.0, 0.05, 1.0)), "irregularity", 0.4))
            return Message(f"/object/{name}/press", (0.5, "striker", "felt", *rng.choice(((), ("id", "y")))))
        case 9:
            what = rng.choice(
                (("stop",), ("gain", -6.0), ("speed", 0.5), ("gravity", 5.0), ("force", 1.0), ("flat", 0.4))
            )
            return Message(
                f"/gesture/{rng.choice(('x', '*', 'y', '[a-c]*'))}/{what[0]}",
                (*what[1:], *(_takes_time(rng) if what[1:] else ())),
            )
        case 10:
            by = ("by", rng.choice("abcd"), *rng.choice(((), ("by_position", 0.2), ("mass", 0.05))))
            return Message(f"/object/{name}/{rng.choice(('impact', 'bounce'))}", (0.02, *by))
        case _:
            args = (rng.uniform(0.1, 2.0), rng.choice((0.3, 0.5)))
            return Message(f"/object/{rng.choice((name, '*', '{a,b}'))}/impact", args)


def random_swarm(rng: random.Random, name: str, id: str) -> Message:
    """Return a swarm, or a change of one."""
    rate, striker = 10.0 ** rng.uniform(0.0, 4.5), ("striker", rng.choice(("rice", "gravel", "coins", "glass-shards")))
    match rng.randrange(9):
        case 0:
            return Message(f"/object/{name}/rain", (rate, "id", id))
        case 1 | 2:
            return Message(
                f"/object/{name}/{rng.choice(('shake', 'pour'))}", (rate, *striker, "variety", 0.3, "id", id)
            )
        case 3:
            return Message(f"/object/{name}/crumple", (rng.uniform(0.01, 0.5), *striker, "id", id))
        case 4:
            return Message(f"/object/{name}/step", (700.0, *striker, "id", id))
        case 5:
            onto = () if rng.random() < 0.5 else ("onto", "c" if name != "c" else "a")
            return Message(f"/object/{name}/shatter", (rng.uniform(0.2, 3.0), *striker, *onto, "id", id))
        case 6:
            return Message(f"/gesture/{id}/stop")
        case _:
            return Message(f"/gesture/{id}/rate", (rate, *_takes_time(rng)))


def random_gesture(rng: random.Random, ids: int) -> Message:
    """Return a gesture that lasts, a change of one, or a quality; of so many ids."""
    name, id = rng.choice("abc"), f"g{rng.randrange(ids)}"
    if rng.random() < 0.25:
        return random_swarm(rng, name, id)
    match rng.randrange(8):
        case 0 | 1 | 2:
            return Message(f"/object/{name}/roll", (rng.uniform(0.2, 1.0), "striker", "steel", "id", id))
        case 3:
            return Message(f"/object/{name}/bounce", (0.02, "id", id))
        case 4:
            return Message(f"/object/{name}/press", (0.5, "striker", "felt", "id", id))
        case 5:
            return Message(f"/gesture/{id}/gain", (rng.uniform(-6.0, 0.0), *_takes_time(rng)))
        case 6:
            return Message(f"/gesture/{id}/stop")
        case _:
            return Message("/quality", (rng.randrange(9),))


_SCORED = frozenset(address for address, verb in VERBS.items() if verb.scored)
_SMALL = ("wood-block", "glockenspiel-bar", "triangle", "wine-glass", "tin-lid", "wood-board", "plastic-cup", "mug")
_REST = frozenset(("/object/new", "/world/body", "/panic"))


def any_message(rng: random.Random) -> Message:
    """Return a message to any address of a score, its arguments within their ranges; one in three makes or strikes an
    object."""
    kind, name = rng.random(), rng.choice("abcdefgh")
    if kind < 0.12:
        return Message("/object/new", (name, rng.choice(_SMALL)))
    if kind < 0.35:
        return Message(f"/object/{name}/impact", (rng.uniform(0.0, 2.0),))
    while True:
        message = declared(rng)
        _, container, *rest = message.address.split("/")
        target = {"object": "NAME", "gesture": "ID"}.get(container)
        address = f"/{container}/{target}/{rest[1]}" if target and len(rest) == 2 else message.address
        if address in _SCORED - _REST:
            return message


HEAVY = ("cymbal", "gong", "tom")
"""Presets on which some dozen gestures are more than a processor can do: the server steps down by itself."""


def play(client: Client, rng: random.Random, seconds: float) -> int:
    """Send random traffic for so long; return how many steps of quality the server took by itself."""
    client.send("/notify", 1)
    for name, preset in zip("abc", HEAVY, strict=True):
        client.send("/object/new", name, preset, "gain", -20)
    client.ask("/sync", 1, timeout=30.0)
    asks = rng.random() < 0.5  # else the qualities are the server's own choice
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        messages = [random_gesture(rng, 60)] if rng.random() < 0.7 else [random_message(rng) for _ in range(2)]
        messages = [message for message in messages if asks or message.address != "/quality"]
        with client.bundle(at=rng.choice((None, None, time.time() + rng.uniform(-0.05, 0.6)))):
            for message in messages:
                client.send(message.address, *message.args)
        time.sleep(rng.uniform(0.0, 0.02))
    client.ask("/sync", 2, timeout=30.0)  # the table of a new contact law takes its time
    return sum(text.startswith("quality is now") for text in client.warnings())


def differing(folder: Path) -> int:
    """Count the values of a recording to which its log does not render."""
    recorded, rate = soundfile.read(folder / "out.wav", dtype="float32")
    sound = render_lines(read(folder / "log.txt"), seconds=len(recorded) / rate)
    return int((sound != recorded).sum())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=30, help="(%(default)s)")
    parser.add_argument("--seconds", type=float, default=6.0, help="of each run (%(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of the first run (%(default)s)")
    arguments = parser.parse_args()
    wrong = 0
    for seed in range(arguments.seed, arguments.seed + arguments.runs):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            with serving(folder, "--device", "none", "--record", "out.wav", "--log", "log.txt") as server:
                with server.client() as client:
                    own = play(client, random.Random(seed), arguments.seconds)
                _, said = server.quit()
            lines = read(folder / "log.txt")
            steps = sum(line.message.address == "/quality" for line in lines)
            wrong += (values := differing(folder)) > 0 or bool(said)
            print(f"seed {seed}: {len(lines)} lines, {steps} /quality, {own} of its own; {values} values differ {said}")
    print(f"{arguments.runs - wrong} of {arguments.runs} logs render to the recording's bits")
    return wrong > 0


if __name__ == "__main__":
    sys.exit(main())
