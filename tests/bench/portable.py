"""Cost of the same bits everywhere: the portable engine beside that of this processor's level, on whole scores.

`python -m tests.bench.portable` measures this alone. Either engine computes in a process of its own; what counts is its
processor's time in the engine.
"""

import json
import os
import subprocess
import sys
from time import process_time
from typing import Any

import carom
from carom.dsp.native.targets import PORTABLE, VARIABLE, processors
from carom.dsp.runtime.engine import Engine
from carom.presets.library import BUILT_IN
from tests.bench.clips import timed
from tests.bench.web import LOADS

RATE = 48_000
SCORES = {
    "the demo": (BUILT_IN / "scores" / "demo.txt").read_text(encoding="utf-8"),
    **LOADS,
    "a tam-tam": "0 /object/new gong tam-tam\n0.01 /object/gong/impact 2\n2 /panic\n",
}


def shares(rounds: int) -> dict[str, float]:
    """Return the share of a core that each score takes in this process's engine: the least of so many rounds."""
    found = {}
    for name, score in SCORES.items():
        costs = []
        for _ in range(rounds):
            with timed(Engine, "process", process_time) as taken:
                sound = carom.render(score)
            costs.append(sum(taken) * RATE / len(sound.samples))
        found[name] = min(costs)
    return found


def measure(rounds: int) -> list[dict[str, Any]]:
    """Return a row for each score: the shares of both engines, and by how much the portable one takes longer."""
    level = processors()[0]
    told = {}
    for processor in (level, PORTABLE):
        words = [sys.executable, "-m", __spec__.name, str(rounds)]
        found = subprocess.run(words, env=os.environ | {VARIABLE: processor}, check=True, stdout=subprocess.PIPE)
        told[processor] = json.loads(found.stdout)
    return [
        dict(score=name, level=level, own=own, portable=told[PORTABLE][name], ratio=told[PORTABLE][name] / own)
        for name, own in told[level].items()
    ]


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(json.dumps(shares(int(sys.argv[1]))))
    else:
        for row in measure(5):
            print(row)
