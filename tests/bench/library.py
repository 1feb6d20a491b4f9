"""Random messages to a scene's library for C, whose host side is compiled with sanitizers.

`python -m tests.bench.library` exports a random score of all gestures, and sends messages: five of nine are gestures,
settings and steering as sessions take them, others play notes, free objects and begin anew, the rest is damaged. After
each it computes a few frames. It fails where the program crashes, where the sanitizer of addresses or of undefined
behaviour speaks, and where a message gets no answer.
"""

import argparse
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from carom.server.osc.score import format_line
from tests.clients.export.asking import asking
from tests.clients.export.make_scene import OBJECTS, messages
from tests.clients.export.pages import ENGINE

SANE = ["-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer"]
WORDS = [
    "id",
    "[",
    "]",
    '"',
    "'",
    "nan",
    "1e400",
    "-1",
    "over",
    "[1 2 3]",
    "over [1 2]",
    "by",
    "x" * 300,
    "#",
    "1e-320",
]
NAMES = [preset.replace("-", "_") for preset in OBJECTS]
SPELLED = "/[]\"'#.,-+e0123456789 objectgsurNAMEid\\\t"


def lines(count: int, seed: int) -> list[str]:
    """Return so many messages."""
    chance = random.Random(seed)
    fair = messages(chance, NAMES)
    return [line(chance, format_line(0.0, next(fair)).partition(" ")[2]) for _ in range(count)]


def line(chance: random.Random, whole: str) -> str:
    """Return a message as it is, or damaged."""
    kind = chance.randrange(9)
    words = whole.split(" ")
    if kind == 0:
        words[chance.randrange(len(words))] = chance.choice(WORDS)
    elif kind == 1:
        del words[chance.randrange(len(words)) :]
    elif kind == 2:
        return "".join(chance.choices(SPELLED, k=chance.choice([1, 10, 100, 5000])))
    elif kind == 3:
        name = chance.choice(NAMES)
        rare = [f"/object/{name}/free {chance.randrange(2)}", "load 1", "load 0", "/panic"]
        return chance.choice(rare) if chance.random() < 0.1 else f"/object/{name}/note {chance.randrange(128)} 64"
    return " ".join(words)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--frames", type=int, default=8, help="computed after each message (%(default)s)")
    parser.add_argument("--seed", type=int, default=46)
    parser.add_argument("--engine", default=[], nargs=1, help="a module whose callback stands in for the engine's")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        made = [sys.executable, "-m", "tests.clients.export.make_scene", folder, str(args.seed), *args.engine]
        subprocess.run(made, env=ENGINE, check=True)
        program = [f"{folder}/ask", f"{folder}/scene.carom", str(args.frames)]
        subprocess.run(["cc", *SANE, *asking(Path(folder)), "-o", program[0]], check=True)
        sent = lines(args.count, args.seed)
        begun = time.monotonic()
        done = subprocess.run(program, input="\n".join(sent), capture_output=True, text=True)
    told = done.stdout.splitlines()
    refused = sum(each.startswith("!") for each in told)
    print(f"{len(told)} of {len(sent)} messages answered, {refused} of them refused, {time.monotonic() - begun:.0f} s")
    print(done.stderr[:4000], end="")
    return int(done.returncode != 0 or len(told) != len(sent) or bool(done.stderr))


if __name__ == "__main__":
    sys.exit(main())
