"""Scenes for C that are changed at random, opened and played under the sanitizers of addresses and undefined behaviour.

`python -m tests.bench.mutated_scenes --count 10000 --seed 1` bakes four scenes, and changes a bit, a byte, a number, a
character of the map, some bytes or the end of one. Every second one gets the checksum of what it is then. It fails
where one without is opened, and where one crashes, sounds of what is no number, or takes a second. `--tiny` has the
engine of the tests, which compiles in seconds, in place of Carom's.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from tests.clients.export.pages import ENGINE

SCORES = {
    "struck": """0 /object/new bell church-bell gain -9
0 /object/new bar glockenspiel-bar pan 0.5
0 /object/bell/impact 1 0.3
0.02 /object/bar/bounce 0.02 0.4 seed 3
0.03 /object/bar/tune 2 over 0.1
0.05 /object/bell/roll 0.5 surface slate seed 4 id r
0.06 /object/bar/slide 0.2 force 0.5 seed 5 id s
0.1 /gesture/r/speed 1 over 0.1
0.1 /object/bar/press 1 striker fingertip id p
0.12 /object/bar/spin 0.5 seed 2
0.15 /gesture/p/stop
0.16 /object/bar/rest felt load 2
0.2 /object/bell/free
0.22 /object/new fork tuning-fork
0.22 /object/fork/impact 0.5 by bar
""",
    "spread": """0 /object/new small small-gong gain -9
0 /object/new ring wine-glass
0 /object/small/impact 4 0.2 striker felt
0.05 /object/ring/impact 1 0.3
0.1 /object/small/free at_once 1
0.15 /object/new other splash-cymbal
0.15 /object/other/impact 3 0.4
""",
    "swarmed": """0 /object/new plate ceramic-tile
0 /object/plate/rain 200 0.5 seed 1 id rain
0.05 /object/plate/shake 100 0.5 seed 2 striker glass-marble
0.1 /object/plate/pour 50 0.5 seed 3 striker wood
0.2 /gesture/rain/stop
0.2 /object/plate/shatter 2 seed 4
""",
    "game": """0 /world/body floor plate wood 1 1 0.02 held 1 most_modes 24
0 /world/body ball sphere steel 0.03 most_modes 16
0 /world/body box box glass 0.2 0.15 0.1 most_modes 16
0 /world/body ground box wood 1 1 1 held 1 rings 0
0 /object/new bell church-bell most_modes 16
""",
}
"""Scores of many kinds of commands, with objects that come and go, plates that stretch, and tables of pulses."""
SHARES = {"struck": 0.5, "spread": 0.2, "swarmed": 0.1, "game": 0.2}
"""Their shares of all changes: those with tables of pulses take longer to open."""
SECONDS = 0.3
FRAMES = 14_400
LONGEST = 1.0
"""s of CPU that one may take, beyond what the scene takes as it is."""
SANE = [
    "-std=gnu11",
    "-g",
    "-O2",
    "-fsanitize=address,undefined",
    "-fno-sanitize-recover=all",
    "-fno-omit-frame-pointer",
]
MODULE = __spec__.name
TINY = "tests.clients.export.tiny"

_LINE = re.compile(r"(\d+) ([rpn]) (\d+) ([^:]*): (.*)")


class Tried(NamedTuple):
    """A changed scene: its number, what came of it (refused, played, not finite, or how the program ended), ms of CPU,
    what was changed, and the reason of a refusal."""

    number: int
    end: str
    ms: int
    change: str
    reason: str = ""

    @property
    def mended(self) -> bool:
        """True if its checksum is that of what it is."""
        return self.number % 2 == 1

    @property
    def fault(self) -> str:
        """What is wrong with how it went; empty: nothing."""
        if self.end not in ("r", "p"):
            return self.end
        if self.end == "p" and not self.mended and "as before" not in self.change:
            return "opened with a wrong checksum"
        return f"{self.ms} ms" if self.ms > 1e3 * LONGEST else ""


def write_scenes(folder: Path) -> None:
    """Write the scenes and the library: in a process that has a page's sizes and bits."""
    from carom.clients.export import c
    from carom.clients.export.machines import machine_of
    from carom.clients.export.scene import bake_scene
    from carom.presets import Presets
    from carom.server.osc.score import parse
    from carom.server.render import Options

    for name, text in SCORES.items():
        score = parse(text.encode(), name)
        scene = bake_scene(score, text, name, Presets(), Options(seconds=SECONDS), print)
        (folder / f"{name}.carom").write_bytes(scene.file())
    c.write_library(scene, folder, machine_of(None))


def build(folder: Path, tiny: bool = False) -> Path:
    """Return the program that changes scenes, compiled in a folder with them."""
    words = [sys.executable, "-m", MODULE, "--write", str(folder), *(["--tiny"] if tiny else [])]
    subprocess.run(words, env=ENGINE, check=True, stdout=subprocess.DEVNULL)
    sources = Path(__file__).parents[2] / "clients" / "export" / "c"
    program = folder / "mutate"
    words = ["cc", *SANE, "-I", str(sources), str(Path(__file__).with_name("mutate.c")), str(folder / "libcarom.a")]
    subprocess.run([*words, "-lm", "-o", str(program)], check=True)
    return program


def tried(program: Path, name: str, seed: int, count: int) -> Iterator[Tried]:
    """Yield what comes of so many changes of a scene. A program that ends is begun anew after that."""
    first = 0
    while first < count:
        words = [str(program), str(program.with_name(f"{name}.carom")), *map(str, (seed, first, count, FRAMES))]
        made = subprocess.run(words, capture_output=True, text=True, errors="replace")
        told, said = made.stdout, made.stderr
        for line in told.splitlines():
            if found := _LINE.fullmatch(line):
                first = int(found[1]) + 1
                yield Tried(int(found[1]), found[2], int(found[3]), found[4], found[5])
        if first < count:
            where = next((line for line in said.splitlines() if "ERROR" in line or "runtime error" in line), "")
            yield Tried(first, f"ended by {made.returncode}: {where}", 0, "")
            first += 1


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--tiny", action="store_true")
    parser.add_argument("--write", type=Path)
    told = parser.parse_args()
    if told.write:
        if told.tiny:
            from tests.clients.export.make_scene import use

            use(TINY)
        write_scenes(told.write)
        return
    faults = 0
    with tempfile.TemporaryDirectory() as made:
        program = build(Path(made), told.tiny)
        for name, share in SHARES.items():
            found = list(tried(program, name, told.seed, round(share * told.count)))
            ends = Counter((each.mended, each.end if each.end in "rpn" else "ended") for each in found)
            print(f"{name}: {len(found)} changes, slowest {max(each.ms for each in found)} ms of CPU")
            for (mended, end), count in sorted(ends.items()):
                print(f"  {'mended' if mended else 'not mended'}: {end} {count}")
            for each in found:
                if each.fault:
                    faults += 1
                    print(f"  {each.number}: {each.change}: {each.fault}")
    sys.exit(faults > 0)


if __name__ == "__main__":
    os.environ.setdefault("ASAN_OPTIONS", "abort_on_error=0:detect_leaks=1:allocator_may_return_null=1")
    main()
