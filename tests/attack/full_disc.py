"""A full disc: a file that cannot grow is told of at once, what was written is whole, and the sound goes on."""

import random
import re
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import soundfile

from carom.clients.actions import CommandError
from tests.support import limited, serving

from . import Tried, kind


@kind("full disc", 1)
def run(chance: random.Random) -> Iterator[Tried]:
    """Yield what servers did that record on discs that are full sooner or later."""
    while True:
        size = chance.choice([200, 4_096, 20_000, 95_000, 97_000, 400_000])
        with TemporaryDirectory() as folder:
            takes, wrong = one(Path(folder), size)
        yield Tried(fine=takes - len(wrong), faults=tuple(f"{size} bytes: {fault}" for fault in wrong))


def one(folder: Path, size: int, takes: int = 3) -> tuple[int, list[str]]:
    """Ask a server whose files can have so many bytes for takes; return how many, and what is wrong."""
    faults: list[str] = []
    with serving(folder, "--device", "none", "--recordings", "takes", carom=limited(size)) as server:
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
