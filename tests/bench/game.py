"""What a game of 200 bodies costs that an exported scene plays: `python -m tests.bench.game`.

Bodies fall, bounce, slide and roll in a pit (game.c): balls, crates and slabs in many sizes, of three materials. Ends
with exit code 1 where the sound takes more than 15 % of a core, a frame takes more than 4 ms, the process more than
64 MB, or the engine refused a command.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

BODIES = """\
0 /quality 1
0 /world/body ground box granite 10 10 1 held 1 rings 0
0 /world/body ball sphere steel 0.04 most_modes 48
0 /world/body crate box wood 0.12 0.1 0.07 most_modes 48
0 /world/body slab plate glass 0.12 0.08 0.01 most_modes 48
"""
MOST = {"share": 0.15, "longest": 4.0, "megabytes": 64.0, "refused": 0}
"""Of a core; ms; MB."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bodies", type=int, default=200)
    parser.add_argument("--seconds", type=int, default=20)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        score, program = Path(folder, "game.txt"), Path(folder, "game")
        score.write_text(BODIES)
        exported = [sys.executable, "-m", "carom", "export", "--to", "c", str(score), folder]
        subprocess.run(exported, check=True)
        source = Path(__file__).with_name("game.c")
        words = [
            "-std=gnu11",
            "-O2",
            "-Wall",
            "-I",
            folder,
            str(source),
            f"{folder}/libcarom.a",
            "-lm",
            "-o",
            str(program),
        ]
        subprocess.run(["cc", *words], check=True)
        played = [str(program), f"{folder}/scene.carom", str(given.bodies), str(given.seconds)]
        done = subprocess.run(played, stdout=subprocess.PIPE, text=True)  # it says what is wrong
        if done.returncode:
            return done.returncode
        told = json.loads(done.stdout)
    for name, value in told.items():
        print(f"{name:>18} {value:g}" + (f"  (at most {MOST[name]:g})" if name in MOST else ""))
    return int(any(told[name] > most for name, most in MOST.items()))


if __name__ == "__main__":
    sys.exit(main())
