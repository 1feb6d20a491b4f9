"""A full disc: a file that cannot grow is told of at once, what was written is whole, and the sound goes on."""

import random
import re
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import soundfile

from carom.clients.actions import CommandError
from tests.support import serving

LIMITED = (
    "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, ({size}, {size})); "
    "from carom.clients import cli; sys.exit(cli.main(sys.argv[1:]))"
)
"""A server none of whose files may be larger: writing more fails as on a full disc, for any user."""


def run(seed: int, seconds: float) -> tuple[int, list[str]]:
    """Have servers record on discs that are full sooner or later; return how many recordings were asked for, and
    faults."""
    chance = random.Random(seed)
    tried, faults = 0, []
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        size = chance.choice([200, 4_096, 20_000, 95_000, 97_000, 400_000])
        with TemporaryDirectory() as folder:
            more, wrong = one(Path(folder), size)
        tried += more
        faults += [f"{seed}: {size} bytes: {fault}" for fault in wrong]
    return tried, faults


def one(folder: Path, size: int, takes: int = 3) -> tuple[int, list[str]]:
    """Ask a server whose files can have so many bytes for takes; return how many, and what is wrong."""
    import sys

    faults = []
    carom = (sys.executable, "-c", LIMITED.format(size=size))
    with serving(folder, "--device", "none", "--recordings", "takes", carom=carom) as server:
        with server.client() as client:
            client.new("a", "wood-block")
            for n in range(takes):
                file = folder / "takes" / f"{n}.wav"
                try:
                    client.ask("/record", 1, "name", str(n))
                except CommandError as error:
                    if not re.search(rf"{n}\.wav: File too large", str(error)):
                        faults.append(f"refused so: {error}")
                    if file.exists():
                        faults.append(f"{file.name} was refused, and is there")
                    continue
                deadline = time.monotonic() + 10.0
                while client.ask("/status") and (take := _take(client)) == file.name and time.monotonic() < deadline:
                    time.sleep(0.05)
                if "File too large" not in take:
                    faults.append(f"{file.name}: ended so: {take}")
                if file.stat().st_size > size or soundfile.info(file).frames == 0:
                    faults.append(f"{file.name}: {soundfile.info(file).frames} frames")
            client.impact("a", 0.5)
            if float(_told(client)["impacts"]) < 1:
                faults.append("the sound has ended")
        code, errors = server.quit()
    if code or "Traceback" in errors:
        faults.append(f"exit code {code}, stderr: {errors[-300:]}")
    return takes, faults


def _told(client) -> dict[str, object]:
    client.ask("/sync", 1)
    args = client.status().args
    return dict(zip(args[9::2], args[10::2], strict=True))


def _take(client) -> str:
    return str(_told(client)["take"])
