"""Exported scenes in Debian's Chromium: sizes, times until the first sound, memory, load, the bits of random scores.

`python -m tests.bench.web` exports the demo and serves it as plain files, without special headers. It clicks in fresh
profiles (nothing is cached) and again (all is), in a real AudioContext, and listens for the first sample that is not 0.
It has the demo and scenes of many modes rendered in a worklet. Then it renders random scores of all gestures in
worklets, and by programs in C. It fails where a bit differs from the render. The figures go into
[exports](../../clients/export.md).
"""

import argparse
import datetime
import hashlib
import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tests.bench.machine import machine
from tests.clients.export.pages import ENGINE, RENDER, served
from tests.documents import study

FILE = study.MEASURED / "web.json"

_OBJECTS = "".join(
    f"0 /object/new o{n} glass-plate most_modes 32 decay 100 gain -40 tune {0.05 * n:.2f}\n" for n in range(64)
)
_RING = "".join(f"0.01 /object/o{n}/impact 1\n" for n in range(0, 64, 2))
_MOVE = "0.05 /object/o1/roll 0.5\n0.05 /object/o3/slide 0.3\n"
LOADS = {
    "64 objects of 32 modes, half of them ringing": f"{_OBJECTS}{_RING}4 /panic\n",
    "the same, with a roll and a slide": f"{_OBJECTS}{_RING}{_MOVE}4 /panic\n",
}
"""Scores whose load is measured."""

HEADER = 44
"""Bytes of a WAV file before its samples."""
DIGEST = 64
"""Digits of a digest."""

FIRST = """async () => {
  const begun = performance.now();
  const { Carom } = await import("./carom.js");
  const files = await Carom.fetch();
  const context = new AudioContext({ sampleRate: files.map.rate, latencyHint: "interactive" });
  const carom = await Carom.open(context, { files });
  const listener = new AnalyserNode(context, { fftSize: 2048 });
  carom.node.connect(listener);
  await context.resume();
  carom.send(`/object/${Object.keys(carom.objects)[0]}/impact`);
  const heard = new Float32Array(listener.fftSize);
  while (!heard.some((x) => x !== 0)) {
    await new Promise((done) => setTimeout(done, 1));
    listener.getFloatTimeDomainData(heard);
    if (performance.now() - begun > 20000) throw new Error("nothing is heard");
  }
  const ms = performance.now() - begun;
  await context.close();
  return ms;
}"""


def digest_in_c(folder: Path, seed: int) -> str:
    """Return the digest of the sound that the example in C renders of a scene."""
    subprocess.run([folder / "c/example", folder / f"{seed}/scene.carom", folder / "made.wav"], check=True)
    return hashlib.sha256((folder / "made.wav").read_bytes()[HEADER:]).hexdigest()


def digest_of_the_demo() -> str:
    """Return the digest of the demo's sound, as `carom render` writes it."""
    with tempfile.TemporaryDirectory() as made:
        subprocess.run([sys.executable, "-m", "carom", "render", "demo", f"{made}/demo.wav"], env=ENGINE, check=True)
        _, _, sound = (Path(made) / "demo.wav").read_bytes().partition(b"data")
        return hashlib.sha256(sound[4:]).hexdigest()  # after their size


def differing(page: Any, count: int) -> Iterator[str]:
    """Yield the random scores, and where each is played, whose sound differs from the render by a bit."""
    with tempfile.TemporaryDirectory() as made, served(Path(made)) as address:
        folder, words = Path(made), [sys.executable, "-m", "tests.bench.exported", made, str(count)]
        with subprocess.Popen(words, env=ENGINE, stdout=subprocess.PIPE, text=True) as maker:
            assert maker.stdout is not None
            for seed, wanted in enumerate(line.strip() for line in maker.stdout if len(line.strip()) == DIGEST):
                if not seed:
                    cc = ["cc", "example.c", "libcarom.a", "-lm", "-o", "example"]
                    subprocess.run(cc, cwd=folder / "c", check=True)
                page.goto(f"{address}{seed}/carom.d.ts")
                found = {"browser": page.evaluate(RENDER)["digest"], "C": digest_in_c(folder, seed)}
                differ = [where for where, digest in found.items() if digest != wanted]
                print(f"score {seed} of {count}: {'differs' if differ else 'equal'}", file=sys.stderr)
                yield from (f"{seed} {where}" for where in differ)
        if maker.returncode:
            raise RuntimeError(f"{' '.join(words)}: has failed")


def load_of(page: Any, score: str) -> float:
    """Return the share of real time that a worklet takes to render a score."""
    with tempfile.TemporaryDirectory() as made:
        text = Path(made) / "score.txt"
        text.write_text(score)
        subprocess.run([sys.executable, "-m", "carom", "export", str(text), f"{made}/out"], check=True)
        with served(Path(made) / "out") as address:
            page.goto(f"{address}carom.d.ts")
            return min(float(page.evaluate(RENDER)["load"]) for _ in range(3))


def measured(count: int, times: int) -> dict[str, Any]:
    """Return all figures; count: of random scores; times: of clicks with nothing cached, and with all."""
    from playwright.sync_api import sync_playwright

    found: dict[str, Any] = {"date": datetime.date.today().isoformat(), "machine": machine()}
    with sync_playwright() as runner, tempfile.TemporaryDirectory() as made:
        browser = runner.chromium.launch(
            executable_path="/usr/bin/chromium", args=["--no-sandbox", "--autoplay-policy=no-user-gesture-required"]
        )
        folder = Path(made)
        begun = time.monotonic()
        subprocess.run([sys.executable, "-m", "carom", "export", "demo", made], check=True)
        found["export s"] = time.monotonic() - begun
        found["kB"] = {file.name: file.stat().st_size / 1e3 for file in sorted(folder.iterdir())}
        found["kB at a first visit"] = sum(size for name, size in found["kB"].items() if not name.endswith(".d.ts"))
        with served(folder) as address:
            cold, warm = [], []
            for _ in range(times):
                context = browser.new_context()
                page = context.new_page()
                page.goto(f"{address}carom.d.ts")
                cold.append(page.evaluate(FIRST))
                page.goto("about:blank")
                page.wait_for_timeout(1000)  # until the page has gone
                page.goto(f"{address}carom.d.ts")
                warm.append(page.evaluate(FIRST))
                context.close()
            found["first sound ms, cold"], found["first sound ms, warm"] = map(statistics.median, (cold, warm))
            page = browser.new_page()
            page.goto(f"{address}carom.d.ts")
            told = page.evaluate(RENDER)
            found["MB"], found["loads"] = told["megabytes"], {"the demo": told["load"]}
            found["the demo differs"] = told["digest"] != digest_of_the_demo()
        found["loads"] |= {name: load_of(page, score) for name, score in LOADS.items()}
        found["random scores"], found["that differ"] = count, list(differing(page, count))
        browser.close()
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scores", type=int, default=50)
    parser.add_argument("--times", type=int, default=7)
    parser.add_argument("--json", type=Path, default=FILE, help="file for the figures (%(default)s)")
    args = parser.parse_args()
    found = measured(args.scores, args.times)
    print(json.dumps(found, indent=1))
    args.json.write_text(json.dumps(found, indent=1) + "\n")
    return 1 if found["the demo differs"] or found["that differ"] else 0


if __name__ == "__main__":
    sys.exit(main())
