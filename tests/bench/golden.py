"""Ten baked scenes with the hash of their sound by the library for C, which is the same on every processor.

`python -m tests.bench.golden` plays those of `tests/measured/golden.tar.xz` and compares the hashes with those of
`tests/measured/golden.json`, which LLVM's version decides, too. `--renew` bakes SCORES anew, writes both files, and
tells which hashes changed, and whether the scenes from before sound as they did: if so, what is baked changed, else the
engine. Whoever renews them says in the commit what changed the sound, and why.
"""

import argparse
import hashlib
import io
import json
import os
import subprocess
import sys
import tarfile
import tempfile
from importlib.metadata import version
from pathlib import Path

from carom.clients.export import c
from carom.clients.export.machines import machine_of, run
from carom.clients.export.scene import bake_scene
from carom.presets import Presets
from carom.server.osc.score import parse
from carom.server.render import Options
from tests.clients.export.pages import ENGINE

SCENES = Path(__file__).parents[1] / "measured" / "golden.tar.xz"
"""Each score, NAME.txt, and the scene that it was baked into, NAME.carom."""
HASHES = SCENES.with_name("golden.json")
SCORES = {
    "impact": """0 /accuracy -50
0 /object/new ball glass-ball
0 /object/new bell church-bell
0 /object/ball/impact 1 0.3
0.1 /object/bell/impact 2 0.5 striker steel
0.3 /object/bell/impact 1 0.5 by ball by_position 0.5
0.4 /object/ball/impact 1 0.3 restitution 0.4
""",
    "bounce": """0 /accuracy -60
0 /object/new ring steel-ring
0 /object/ring/bounce 0.05 0.4 striker glass-marble seed 1
0.3 /object/ring/tune -2 over 0.2
0.3 /object/ring/damp 0.4
""",
    "roll": """0 /accuracy -80
0 /object/new block wood-block
0 /object/block/roll 0.5 0.2 striker glass-marble surface slate seed 2 id r
0.2 /gesture/r/speed 1 over 0.2
0.6 /gesture/r/stop
""",
    "press": """0 /accuracy exact
0 /object/new glass wine-glass
0 /object/glass/impact 1 0.3
0.1 /object/glass/press 2 0.5 striker fingertip id p
0.3 /object/glass/impact 1 0.3
0.4 /gesture/p/stop
0.45 /object/glass/impact 1 0.3
""",
    "spin": """0 /accuracy -40
0 /object/new bar marimba-bar
0 /object/bar/spin 0.8 0.4 seed 4 irregularity 0.5
""",
    "slide": """0 /accuracy -60
0 /object/new ring steel-ring
0 /object/ring/slide 0.2 0.5 force 0.5 surface glass seed 5 id s
0.3 /gesture/s/force 1 over 0.1
0.7 /gesture/s/stop
""",
    "rest": """0 /accuracy -80
0 /object/new fork tuning-fork
0 /object/new block wood-block
0 /object/fork/rest block load 1
0.05 /object/block/impact 1 0.3
0.3 /object/fork/impact 1 0.7
""",
    "rain": """0 /accuracy -50
0 /object/new block wood-block
0 /object/block/rain 300 0.5 seed 7 id rain
0.2 /object/block/pour 100 0.4 striker glass-marble seed 8 id pour
0.6 /gesture/rain/rate 20 over 0.1
0.7 /gesture/pour/stop
""",
    "steps": """0 /accuracy -60
0 /object/new bar marimba-bar
0 /object/new ring steel-ring
0 /object/bar/step 700 0.5 seed 9
0.2 /object/ring/crumple 0.3 0.5 seed 10 id c
0.3 /object/bar/shake 80 0.5 seed 11 id s
0.6 /gesture/c/stop
0.6 /gesture/s/stop
""",
    "shatter": """0 /accuracy exact
0 /object/new glass wine-glass
0 /object/new bell church-bell
0.1 /object/glass/shatter 2 seed 12 onto bell
0.5 /panic
0.6 /object/bell/impact 1 0.3
""",
}
"""Each gesture and each accuracy is in one of them. Their objects have few modes, so that the scenes are small."""
MODULE = __spec__.name
SECONDS = 1.0
REMEDY = f"`python -m {MODULE} --renew` bakes the scenes anew, and the commit says why"


def baked(name: str) -> tuple[bytes, str]:
    """Return a score's scene, and the hash of its sound, by an engine that has a library's room and bits."""
    text = SCORES[name]
    scene = bake_scene(parse(text.encode(), name), text, name, Presets(), Options(seconds=SECONDS), print)
    return scene.file(), hashlib.sha256(scene.baked.sound.astype("<f4").tobytes()).hexdigest()


def stored() -> dict[str, bytes]:
    """Return the files that are kept, by name."""
    with tarfile.open(SCENES) as kept:
        return {each.name: kept.extractfile(each).read() for each in kept}  # type: ignore[union-attr]


def store(files: dict[str, bytes]) -> None:
    """Keep files: the same bytes for the same files."""
    with tarfile.open(SCENES, "w:xz", preset=9) as kept:
        for name, content in files.items():
            told = tarfile.TarInfo(name)
            told.size = len(content)
            kept.addfile(told, io.BytesIO(content))


def played(scenes: dict[str, bytes]) -> dict[str, str]:
    """Return the hash of each scene's sound, as the library's example plays it, or why it does not."""
    found: dict[str, str] = {}
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        example = Path(c.__file__).parent / "c" / "example.c"
        machine = machine_of(None)
        c.write_static(folder, machine)
        run(*machine.compiler, f"-I{folder}", example, "libcarom.a", "-lm", "-o", "example", cwd=folder)
        for name, scene in scenes.items():
            (folder / name).write_bytes(scene)
            done = subprocess.run([folder / "example", name, "made.wav"], cwd=folder, capture_output=True, text=True)
            samples = b"" if done.returncode else (folder / "made.wav").read_bytes()[44:]
            found[name] = hashlib.sha256(samples).hexdigest() if any(samples) else done.stderr.strip() or "it is silent"
    return found


def played_as_stored() -> dict[str, str]:
    """Return the same of the scenes that are kept, by the scores' names."""
    files = stored()
    found = played({name: content for name, content in files.items() if name.endswith(".carom")})
    return {name.removesuffix(".carom"): each for name, each in found.items()}


def renew() -> None:
    """Bake the scores, write their scenes and hashes, and tell what changed."""
    known = json.loads(HASHES.read_text())["sounds"] if HASHES.exists() else {}
    before = played_as_stored() if SCENES.exists() else {}
    made = {name: baked(name) for name in SCORES}
    scenes = {name: scene for name, (scene, _) in made.items()}
    hashes = played(scenes)
    unlike = [name for name in SCORES if hashes[name] != made[name][1]]
    assert not unlike, f"{unlike}: the library plays otherwise than they were rendered"
    files: dict[str, bytes] = {}
    for name, score in SCORES.items():
        files |= {f"{name}.txt": score.encode(), f"{name}.carom": scenes[name]}
        changed = "as before" if hashes[name] == known.get(name) else f"{known.get(name)} becomes {hashes[name]}"
        old = before.get(name, "there was none")
        print(f"{name}: {changed}; the scene from before: {'as before' if old == known.get(name) else old}")
    store(files)
    HASHES.write_text(json.dumps({"llvmlite": version("llvmlite"), "sounds": hashes}, indent=2) + "\n")
    print(f"{SCENES.name}: {SCENES.stat().st_size} bytes")


def compare() -> int:
    """Tell which of the scenes that are kept sound otherwise; return 1 if any does."""
    known, found = json.loads(HASHES.read_text()), played_as_stored()
    wrong = [
        f"{name}: {each}; expected {known['sounds'].get(name)}"
        for name, each in found.items()
        if each != known["sounds"].get(name)
    ]
    if wrong:
        used, its = version("llvmlite"), known["llvmlite"]
        print(*wrong, f"llvmlite is {used}; the hashes are of {its}", REMEDY, sep="\n", file=sys.stderr)
    return bool(wrong)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--renew", action="store_true", help="bake the scenes, write them and their hashes")
    told = parser.parse_args()
    if dict(os.environ) != ENGINE:  # by a process that has the library's sizes and bits
        return subprocess.run([sys.executable, "-m", MODULE, *sys.argv[1:]], env=ENGINE).returncode
    if not told.renew:
        return compare()
    renew()
    return 0


if __name__ == "__main__":
    sys.exit(main())
