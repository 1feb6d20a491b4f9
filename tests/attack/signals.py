"""Signals: none ends a server without its files being whole, and of each it says what it does."""

import random
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import soundfile

from carom.server.osc.score import read
from tests.support import serving

from . import Tried, kind

ENDING = ("SIGTERM", "SIGINT", "SIGHUP", "SIGQUIT", "SIGXCPU")
IGNORED = ("SIGUSR1", "SIGUSR2", "SIGALRM", "SIGVTALRM", "SIGPROF", "SIGIO")
FILES = ("--device", "none", "--record", "out.wav", "--log", "log.txt", "--recordings", "takes")
MOST_LOST = 0.2  # s that a recording may lack of the time that the server has told


@kind("signals", 1)
def run(chance: random.Random) -> Iterator[Tried]:
    """Yield what servers that play and record did of ignored signals, then of one that ends them."""
    while True:
        names = [chance.choice(IGNORED) for _ in range(chance.randrange(1, 12))]
        with TemporaryDirectory() as folder:
            faults = one(Path(folder), names, chance.choice(ENDING), chance)
        yield Tried(fine=0 if faults else len(names) + 1, faults=tuple(faults))


def one(folder: Path, names: list[str], last: str, chance: random.Random) -> list[str]:
    """Send a server signals, and one that ends it; return what is wrong then."""
    with serving(folder, *FILES) as server:
        with server.client() as client:
            client.new("a", "wood-block")
            client.ask("/record", 1, "name", "take")
            for name in names:
                server.process.send_signal(getattr(signal, name))
                client.impact("a", 0.5)
                time.sleep(chance.uniform(0.0, 0.03))
            client.ask("/sync", 1)
            told = client.status().args
        heard = float(dict(zip(told[9::2], told[10::2], strict=True))["time"])
        server.process.send_signal(getattr(signal, last))
        _, errors = server.process.communicate(timeout=30)
    said = [f"carom serve: {name} is ignored: " in errors for name in dict.fromkeys(names)]
    lines = [line for line in errors.splitlines() if "quality is now" not in line and "late events" not in line]
    wanted = len(said) + (last == "SIGQUIT")
    struck = sum(line.message.address.endswith("impact") for line in read(folder / "log.txt"))
    checks = {
        f"exit code {server.process.returncode} after {last}": server.process.returncode == 0,
        f"stderr: {lines}": all(said) and len(lines) == wanted,
        f"{struck} of {len(names)} impacts in the log": struck == len(names),
        "out.wav lacks the end": soundfile.info(folder / "out.wav").duration > heard - MOST_LOST,
        "take.wav is empty": soundfile.info(folder / "takes" / "take.wav").frames > 0,
    }
    return [fault for fault, holds in checks.items() if not holds]
