"""The first half minute with a wheel: how soon a server answers and sounds, and a second of a score is rendered.

`python -m tests.bench.starts --json starts.json` builds a wheel, installs it in a new virtual environment and starts it
with empty caches: at each level of x86-64 that this processor can do, and for a user whose home cannot be written.
`--root` names a bare Debian (`debootstrap --variant=minbase --include=python3,libportaudio2 bookworm ROOT`), in which
it is then installed and started as well; where uvx and pipx are there, it is tried by these. It fails where the median
of the runs takes longer than LIMITS, or anything was compiled.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median
from typing import Any

from carom.clients.top import values
from carom.dsp.native.targets import LEVELS, VARIABLE, processors
from tests.bench.bench import machine
from tests.support import serving

LIMITS = {"serve answers": 0.4, "serve sounds": 0.6, "render of one second": 0.7}
"""s from the start of the process: the most that each may take."""

SCORE = "0 /object/new bell church-bell\n0 /object/bell/impact 1\n"
_ROOT = Path(__file__).parents[2]
_NOBODY = 65_534
_CHROOT = "/usr/sbin/chroot"
_INSTALLED = "opt/carom"  # in a bare Debian


@dataclass(frozen=True)
class Place:
    """A place where Carom is started: the words that begin its command line, its environment, a root folder of its own,
    and whether LIMITS hold for it: other programs may come first."""

    name: str
    words: tuple[str, ...]
    env: dict[str, str]
    root: Path = Path("/")
    has_limits: bool = True

    def run(self, *words: str, folder: Path) -> str:
        """Run a command; return its output."""
        done = subprocess.run([*self.words, *words], cwd=folder, env=self.env, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout + done.stderr


def start(place: Place, folder: Path) -> dict[str, float]:
    """Measure the time (s) that each of LIMITS takes in a place, with a folder for files that everybody can write."""
    here = Path("/") / folder.relative_to(place.root)
    (folder / "one.txt").write_text(SCORE)
    begun = time.monotonic()
    with serving(folder, "--device", "none", env=place.env, carom=place.words) as server, server.client() as client:
        client.ask("/version")
        answered = time.monotonic()
        client.send("/object/new", "bell", "church-bell")
        client.send("/object/bell/impact", 1.0)
        while not values(client.status())["sounding"]:
            time.sleep(0.001)
        sounded = time.monotonic()
        assert server.quit() == (0, "")
    rendering = time.monotonic()
    place.run("render", str(here / "one.txt"), str(here / "one.wav"), "--seconds", "1", folder=folder)
    return dict(zip(LIMITS, (answered - begun, sounded - begun, time.monotonic() - rendering), strict=True))


def measure(place: Place, processor: str, runs: int) -> Iterator[dict[str, Any]]:
    """Yield a row for each of LIMITS: the times (s) of so many runs, each with an empty home."""
    taken = []
    for _ in range(runs):
        with tempfile.TemporaryDirectory(dir=place.root / "tmp") as name:
            folder, home = Path(name), Path(name) / "home"
            home.mkdir()
            os.chmod(folder, 0o777)
            os.chmod(home, 0o555)
            inside = Path("/") / home.relative_to(place.root)
            own = {"HOME": str(inside), "XDG_CACHE_HOME": str(inside / "cache"), VARIABLE: processor}
            there = replace(place, env={**own, **place.env})
            taken.append(start(there, folder))
            assert not list(home.rglob("units/*/*")), "code was compiled"
    for what, limit in LIMITS.items():
        yield {
            "place": place.name, "processor": processor, "what": what, "seconds": [each[what] for each in taken],
            "limit": limit if place.has_limits else None,
        }  # fmt: skip


def built(folder: Path) -> Path:
    """Build a wheel of this checkout."""
    words = [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--wheel-dir", folder, _ROOT]
    subprocess.run(words, check=True)
    return next(folder.glob("*.whl"))


def installed(wheel: Path, folder: Path) -> Path:
    """Install a wheel in a new virtual environment; return its command."""
    subprocess.run([sys.executable, "-m", "venv", folder], check=True)
    subprocess.run([folder / "bin/python", "-m", "pip", "install", "-q", wheel], check=True)
    return folder / "bin/carom"


def install_in(root: Path, wheel: Path) -> None:
    """Install a wheel for the Python of a root folder, which has neither a compiler nor pip."""
    found = [name for name in ("cc", "gcc", "clang", "pip") if shutil.which(name, path=str(root / "usr/bin"))]
    assert not found, f"{root}: expected no {found[0]}"
    ask = "import sys; print('%d.%d' % sys.version_info[:2])"
    version = subprocess.check_output([_CHROOT, root, "/usr/bin/python3", "-c", ask], text=True).strip()
    target = root / _INSTALLED
    shutil.rmtree(target, ignore_errors=True)
    words = ["--target", target, "--python-version", version, "--only-binary", ":all:", wheel]
    subprocess.run([sys.executable, "-m", "pip", "install", "-q", *words], check=True)


def places(wheel: Path, folder: Path, root: Path | None) -> Iterator[Place]:
    """Yield the places where limits hold."""
    carom = str(installed(wheel, folder / "venv"))
    env = {"PATH": os.defpath}
    yield Place("virtual environment", (carom,), env)
    if os.geteuid() == 0:
        os.chmod(folder, 0o755)
        as_nobody = ("setpriv", f"--reuid={_NOBODY}", f"--regid={_NOBODY}", "--clear-groups")
        yield Place("home that cannot be written", (*as_nobody, carom), env)
    if root:
        install_in(root, wheel)
        there = {**env, "PYTHONPATH": f"/{_INSTALLED}"}
        yield Place("bare Debian", (_CHROOT, str(root), "/usr/bin/python3", "-m", "carom"), there, root)


def runners(wheel: Path, folder: Path) -> Iterator[Place]:
    """Yield the programs that install a wheel and run it, as far as they are there; they have installed it already."""
    home = folder / "runners"
    home.mkdir()
    for name, words in (("uvx", ("--from", str(wheel))), ("pipx", ("run", "--spec", str(wheel)))):
        program = shutil.which(name)
        if program:
            own = {key: str(home / key) for key in ("UV_CACHE_DIR", "UV_TOOL_DIR", "PIPX_HOME")}
            place = Place(name, (program, *words, "carom"), {**os.environ, **own}, has_limits=False)
            place.run("--version", folder=folder)
            yield place


def is_late(row: dict[str, Any]) -> bool:
    """True if a row's median is beyond its limit."""
    return row["limit"] is not None and median(row["seconds"]) > row["limit"]


def told(row: dict[str, Any]) -> str:
    """Write a row as a line of text."""
    limit = f", limit {row['limit']:g} s" if row["limit"] else ""
    times = f"median {median(row['seconds']):.3f} s, worst {max(row['seconds']):.3f} s{limit}"
    return f"{row['place']:28} {row['processor']:10} {row['what']:22} {times}{': LATE' * is_late(row)}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--wheel", type=Path, metavar="FILE.whl", help="instead of one of this checkout")
    parser.add_argument("--root", type=Path, metavar="DIR", help="a bare Debian")
    parser.add_argument("--runs", type=int, default=5, help="(%(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all times")
    arguments = parser.parse_args()
    levels = [level for level in LEVELS[1:] if level in processors()]
    rows: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        wheel = arguments.wheel.resolve() if arguments.wheel else built(folder)
        for place in (*places(wheel, folder, arguments.root), *runners(wheel, folder)):
            for level in levels if place.has_limits else levels[-1:]:
                for row in measure(place, level, arguments.runs):
                    rows.append(row)
                    print(told(row), flush=True)
    if arguments.json:
        arguments.json.write_text(json.dumps({"machine": machine(), "starts": rows}, indent=1) + "\n")
    return any(is_late(row) for row in rows)


if __name__ == "__main__":
    sys.exit(main())
