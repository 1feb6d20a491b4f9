"""Scores on the checked build (dsp/native/checked.py): no index outside, and no bit by what nobody should read.

    python -m tests.bench.checked [--minutes 10] [--seed 0] [--pairs 0] [--seconds 1.2]

Random scores of all gestures (tests/scores.py) and preset scores at three accuracies take turns. Each is played with
two bytes in all that nobody should read; every third random one after another score, whose objects were freed. A
process of its own plays them, which a fault ends: the next one goes on. `--pairs` asks for so many more that come after
another, at first. Exit status 1 where there was a fault, a bit or a sample that is no number; the scores that had one
lie in build/checked.
"""

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np

from carom.server.osc.score import Line, read
from carom.server.osc.wire import Message
from tests.scores import Score, any_score, play

FILLERS = 255, 0x3F
"""Bytes by which floats are no numbers, and small ones."""
PRESETS = Path(__file__).parents[2] / "presets" / "scores"
FOUND = Path("build/checked")
SECONDS = 1.2
EVERY = 3  # random scores, of which one comes after another
TOLD = 50  # scores, after which a line says how far it is

_LENGTH = 30.0  # s of a preset score at most


def scores(seed: int, pairs: int) -> Iterator[str]:
    """Yield the names of what is played, without an end: `pair SEED`, then `SEED` and, as long as there are some,
    `NAME ACCURACY` of a preset score by turns."""
    yield from (f"pair {number}" for number in range(seed, seed + pairs))
    preset = ((path.stem, each) for path in sorted(PRESETS.glob("*.txt")) for each in ("", "-50", "exact"))
    while True:
        yield str(seed) if seed % EVERY else f"pair {seed}"
        yield from (f"{stem} {accuracy}" for stem, accuracy in islice(preset, 1))
        seed += 1


def score_of(name: str, seconds: float = SECONDS) -> tuple[Score, Score | None]:
    """Return the score of a name; of a pair the later one, and the one before it. seconds: of a random score."""
    kind, _, rest = name.partition(" ")
    if kind == "pair":
        return any_score(int(rest), seconds=seconds), any_score(int(rest), "before", seconds=seconds)
    if kind.isdecimal():
        return any_score(int(kind), seconds=seconds), None
    lines = [line for line in read(PRESETS / f"{kind}.txt") if line.time < _LENGTH]
    if rest:
        lines.insert(0, Line(0.0, Message("/accuracy", (rest,)), ""))
    return Score(tuple(lines), 48_000, 1_024, min(lines[-1].time + 1.0, _LENGTH)), None


def fault_of(name: str, seconds: float = SECONDS) -> str:
    """Play what has a name; return what is wrong with it, "" if nothing. seconds: of a random score."""
    score, before = score_of(name, seconds)
    wait = seconds + 0.5
    if before:
        sounds = [play(score.after(wait, each), begin=wait) for each in (None, before)]
    else:
        sounds = [play(score, filler) for filler in FILLERS]
    if not all(np.isfinite(sound).all() for sound in sounds):
        return "a sample is no number"
    differ = np.flatnonzero((sounds[0] != sounds[1]).any(axis=1))
    if not differ.size:
        return ""
    what = "what was freed before" if before else f"the byte that fills what nobody should read ({FILLERS})"
    return f"differs by {what}, from {differ[0] / score.rate:.4f} s on, by {np.abs(sounds[0] - sounds[1]).max():g}"


def work(seconds: float) -> None:
    """Play what lines of standard input name, and answer each by a line: what is wrong with it."""
    for line in sys.stdin:
        print(fault_of(line.strip(), seconds), flush=True)


class _Player:
    """A process of the checked build that plays scores, until a fault ends it."""

    def __init__(self, seconds: float) -> None:
        FOUND.mkdir(parents=True, exist_ok=True)
        self._errors = (FOUND / "stderr.txt").open("w+")
        code, pipe = f"from tests.bench.checked import work; work({seconds})", subprocess.PIPE
        self.process = subprocess.Popen(
            [sys.executable, "-c", code], env={**os.environ, "CAROM_CHECKED": "1"}, stdin=pipe, stdout=pipe,
            stderr=self._errors, text=True, bufsize=1,
        )  # fmt: skip

    def fault_of(self, name: str) -> tuple[str, bool]:
        """Return what is wrong with a score, and whether that has ended the process."""
        assert self.process.stdin and self.process.stdout
        print(name, file=self.process.stdin)
        answer = self.process.stdout.readline()
        if answer:
            return answer.strip(), False
        status = self.process.wait()
        self._errors.seek(0)
        lines = self._errors.read().splitlines()
        told = [line for line in lines if line.startswith("carom: checked build")] or lines[-1:]
        return f"{' '.join(told)} (exit status {status})", True


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=10.0, help="how long, without what compiles (%(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of the first random score (%(default)s)")
    parser.add_argument("--pairs", type=int, default=0, help="scores after others, at once (%(default)s)")
    parser.add_argument("--seconds", type=float, default=SECONDS, help="of a random score (%(default)s)")
    args = parser.parse_args()
    player, played, wrong, end = _Player(args.seconds), 0, 0, 0.0
    for name in scores(args.seed, args.pairs):
        fault, ended = player.fault_of(name)
        end = end or time.monotonic() + 60.0 * args.minutes  # from when the engine is compiled
        played += 1
        if played % TOLD == 0:
            print(f"{played} scores", flush=True)
        if fault:
            wrong += 1
            print(f"{name}: {fault}", flush=True)
            score, before = score_of(name, args.seconds)
            (FOUND / f"{name.strip().replace(' ', '_')}.txt").write_text((before.text if before else "") + score.text)
        if ended:
            player = _Player(args.seconds)
        if time.monotonic() > end:
            break
    print(f"{played} scores on the checked build, the last {name}: {wrong or 'none'} with a fault")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
