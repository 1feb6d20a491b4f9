"""Play exports for other machines where an emulator runs them: their sound has the bits of this machine's.

    python -m tests.bench.elsewhere [--seed SEED]

It takes random scores, makes a C library of each for Arm and for Windows, and renders it by the library's example under
qemu and under wine. What is not installed is named, and left out.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from tests.clients.export.pages import ENGINE

EMULATORS = {
    "linux-arm64": (("qemu-aarch64-static",), "qemu-user-static"),
    "windows-x86-64": (("wine64", "/usr/lib/wine/wine64"), "wine64"),
}
"""Programs that run another machine's, and Debian's packages that bring them."""

SCORES = 1


def compare(name: str, emulator: str, seed: int, folder: Path) -> bool:
    """Render a random score as another machine does; True if it has the bits of a render here."""
    from carom.clients.export import c
    from carom.clients.export.machines import machine_of, run
    from carom.presets import Presets
    from tests.clients.export.make_scene import random_scene

    machine = machine_of(name)
    # What is linked with musl needs no library of the other system.
    machine = machine._replace(compiler=[each.replace("linux-gnu.2.28", "linux-musl") for each in machine.compiler])
    _, scene = random_scene(seed, Presets())
    c.write_library(scene, folder, machine)
    run(*machine.compiler, "-O2", "example.c", "libcarom.a", "-lm", "-o", "example.exe", cwd=folder)
    words = [emulator, "example.exe", "scene.carom", "made.wav"]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, env=os.environ | {"WINEDEBUG": "-all"})
    if done.returncode:
        print(done.stderr)
    return done.returncode == 0 and (folder / "made.wav").read_bytes()[44:] == scene.baked.sound.astype("<f4").tobytes()


def main(seed: int) -> int:
    failed = 0
    for name, (programs, package) in EMULATORS.items():
        emulator = next(filter(None, map(shutil.which, programs)), None)
        if not emulator:
            print(f"{name}: left out, as {programs[0]} is not here; apt install {package}")
            continue
        for number in range(seed, seed + SCORES):
            with tempfile.TemporaryDirectory() as folder:
                same = compare(name, emulator, number, Path(folder))
            print(f"{name}, score {number}: {'the same bits' if same else 'OTHER BITS'}")
            failed += not same
    return failed


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    if any(os.environ.get(key) != value for key, value in ENGINE.items() if key.startswith("CAROM_")):
        sys.exit(subprocess.run([sys.executable, "-m", "tests.bench.elsewhere", *sys.argv[1:]], env=ENGINE).returncode)
    sys.exit(bool(main(parser.parse_args().seed)))
