"""Ten scores with the hash of their sound by portable code, which is the same on every processor.

`python -m tests.bench.golden` renders them and compares the hashes with `tests/measured/golden.json`; `--renew` writes
them there. Whoever renews them says in the commit what changed the sound, and why. Objects are those whose modes are
sums and products of what their presets say, to the bit, whatever numpy's BLAS is.
"""

import argparse
import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import carom
from carom.presets import stored
from tests.clients.export.pages import ENGINE

FILE = Path(__file__).parents[1] / "measured" / "golden.json"
SCORES = {
    "impact": """0 /accuracy -50
0 /object/new ball glass-ball
0 /object/new mug mug
0 /object/ball/impact 1 0.3
0.1 /object/mug/impact 2 0.5 striker steel
0.3 /object/mug/impact 1 0.5 by ball by_position 0.5
0.4 /object/ball/impact 1 0.3 restitution 0.4
""",
    "bounce": """0 /accuracy -60
0 /object/new mug mug
0 /object/mug/bounce 0.05 0.4 striker glass-marble seed 1
0.3 /object/mug/tune -2 over 0.2
0.3 /object/mug/damp 0.4
""",
    "roll": """0 /accuracy -80
0 /object/new pan steel-pan
0 /object/pan/roll 0.5 0.2 striker glass-marble surface slate seed 2 id r
0.2 /gesture/r/speed 1 over 0.2
0.6 /gesture/r/stop
""",
    "press": """0 /accuracy exact
0 /object/new bottle bottle
0 /object/bottle/impact 1 0.3
0.1 /object/bottle/press 2 0.5 striker fingertip id p
0.3 /object/bottle/impact 1 0.3
0.4 /gesture/p/stop
0.45 /object/bottle/impact 1 0.3
""",
    "spin": """0 /accuracy -40
0 /object/new panel steel-pan
0 /object/panel/spin 0.8 0.4 seed 4 irregularity 0.5
""",
    "slide": """0 /accuracy -60
0 /object/new pan steel-pan
0 /object/pan/slide 0.2 0.5 force 0.5 surface glass seed 5 id s
0.3 /gesture/s/force 1 over 0.1
0.7 /gesture/s/stop
""",
    "rest": """0 /accuracy -80
0 /object/new spoon spoon
0 /object/new pan steel-pan
0 /object/spoon/rest pan load 1
0.05 /object/pan/impact 1 0.3
0.3 /object/spoon/impact 1 0.7
""",
    "rain": """0 /accuracy -50
0 /object/new pan steel-pan
0 /object/pan/rain 300 0.5 seed 7 id rain
0.2 /object/pan/pour 100 0.4 striker glass-marble seed 8 id pour
0.6 /gesture/rain/rate 20 over 0.1
0.7 /gesture/pour/stop
""",
    "steps": """0 /accuracy -60
0 /object/new panel steel-pan
0 /object/new pan steel-pan
0 /object/panel/step 700 0.5 seed 9
0.2 /object/pan/crumple 0.3 0.5 seed 10 id c
0.3 /object/panel/shake 80 0.5 seed 11 id s
0.6 /gesture/c/stop
0.6 /gesture/s/stop
""",
    "shatter": """0 /accuracy exact
0 /object/new mug mug
0 /object/new panel steel-pan
0.1 /object/mug/shatter 2 seed 12 onto panel
0.5 /panic
0.6 /object/panel/impact 1 0.3
""",
}
"""Each gesture and each accuracy is in one of them."""
MODULE = __spec__.name
SECONDS = 1.0


def rendered(**more: str) -> dict[str, str]:
    """Return the hash of each score's sound, by an engine of portable code that has a page's room; more: variables of
    its environment."""
    words = [sys.executable, "-m", MODULE, "--print"]
    found = subprocess.run(words, env=ENGINE | more, check=True, stdout=subprocess.PIPE)
    return dict(json.loads(found.stdout))


def hashes() -> dict[str, str]:
    """Return the same, by this process's engine, whose modes no other process has made."""
    found = {}
    stored.folder = lambda: Path(os.devnull)
    for name, score in SCORES.items():
        samples = carom.render(score, seconds=SECONDS).samples
        assert samples.any(), f"{name} is silent"
        found[name] = hashlib.sha256(samples.astype("<f4").tobytes()).hexdigest()
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--renew", action="store_true", help="write the hashes")
    parser.add_argument("--print", action="store_true", help="print those of this process's engine")
    told = parser.parse_args()
    if told.print:
        print(json.dumps(hashes()))
        return
    found, known = rendered(), json.loads(FILE.read_text()) if FILE.exists() else {}
    print("\n".join(f"{name}: {'as before' if known.get(name) == each else each}" for name, each in found.items()))
    if told.renew:
        FILE.write_text(json.dumps(found, indent=2) + "\n")
    sys.exit(not told.renew and found != known)


if __name__ == "__main__":
    main()
