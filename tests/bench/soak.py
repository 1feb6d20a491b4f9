"""A long evening: 2,000 impacts a second and 32 rolls on a server that plays by the clock, watched from outside.

Tells every so often how much memory the server holds, what it dropped, and how long /status took to be answered; ends
with exit code 1 where memory grew by more than 10 MB after the first fifth, anything was dropped, a roll ended, or an
answer took over 50 ms.
"""

import argparse
import re
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

from carom.clients.client import Client
from carom.clients.top import values
from tests.support import serving

RATE = 2_000  # impacts a second
BUNDLE = 20  # impacts that are sent together
AHEAD = 0.2  # s that they are sent before their time
PRESETS = ("wood-block", "glockenspiel-bar", "wine-glass", "marimba-bar")
FLOORS = ("glass-plate", "wood-board", "steel-plate", "ceramic-tile")
ROLLS = 32
DROPS = ("contacts_dropped", "faults", "underflows", "tap_lost", "late", "dropped", "dropped_by_system")
MOST_GROWTH, SLOWEST = 10.0, 0.05  # MB, s


@dataclass
class Soak:
    """Observations: memory (MB), answers (s) and loads (%) in time, the furthest quality that the load asked for, what
    was dropped, strikes sent, impacts carried out with those of the rolls, and rolls that still went on at the end."""

    memory: list[float] = field(default_factory=list)
    answers: list[float] = field(default_factory=list)
    loads: list[float] = field(default_factory=list)
    quality: int = 0
    dropped: dict[str, object] = field(default_factory=dict)
    sent: int = 0
    carried_out: int = 0
    rolling: int = 0

    @property
    def growth(self) -> float:
        """MB since a fifth of the time had passed."""
        return self.memory[-1] - self.memory[len(self.memory) // 5]


def memory(pid: int) -> float:
    """Return the MB that a process holds."""
    match = re.search(r"VmRSS:\s+(\d+) kB", Path(f"/proc/{pid}/status").read_text())
    assert match
    return int(match[1]) / 1024


def soak(port: int, pid: int, seconds: float, tell: bool = False) -> Soak:
    """Play on a server at a port for so long."""
    seen = Soak()
    with Client(port=port) as player, Client(port=port) as watcher:
        for preset in PRESETS:
            player.new(preset, preset, gain=-40)
        for floor in FLOORS:
            player.new(f"floor-{floor}", floor, gain=-40)
        for n in range(ROLLS):
            keys = {"striker": "glass-marble", "surface": "wood", "id": f"roll-{n}", "seed": n}
            place = (n + 0.5) / ROLLS
            player.send(f"/object/floor-{FLOORS[n % len(FLOORS)]}/roll", 0.2 + place, place, *sum(keys.items(), ()))
        start = time.time() + AHEAD
        looked = told = time.monotonic()
        while seen.sent < seconds * RATE:
            with player.bundle(at=start + seen.sent / RATE):
                for n in range(BUNDLE):
                    player.impact(PRESETS[(seen.sent + n) % len(PRESETS)], 0.1 + n / BUNDLE)
            seen.sent += BUNDLE
            if time.monotonic() > looked + 0.25:
                looked = time.monotonic()
                status = values(watcher.status())
                seen.answers.append(time.monotonic() - looked)
                seen.memory.append(memory(pid))
                seen.loads.append(float(status["load"]))
                seen.quality = max(seen.quality, int(status["quality"]))
                seen.dropped = {name: status[name] for name in DROPS}
                if tell and looked > told + 10:
                    told = looked
                    worst = 1e3 * max(seen.answers)
                    print(
                        f"{seen.sent / RATE:7.0f} s  {seen.memory[-1]:7.1f} MB  worst answer {worst:5.1f} ms  "
                        f"load {seen.loads[-1]:4.1f} %",
                        flush=True,
                    )
            time.sleep(max(0.0, start + seen.sent / RATE - AHEAD - time.time()))
        time.sleep(2 * AHEAD)
        status = values(watcher.status())
        seen.carried_out, seen.rolling = int(status["impacts"]), int(status["contacts"])
    return seen


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=10.0)
    seconds = 60 * parser.parse_args().minutes
    with tempfile.TemporaryDirectory() as folder, serving(Path(folder), "--device", "none") as server:
        seen = soak(server.port, server.process.pid, seconds, tell=True)
        server.quit()
    ordered = sorted(seen.answers)
    print(f"memory {seen.memory[0]:.1f} MB, then {seen.growth:+.1f} MB")
    print(f"{seen.sent} strikes, {seen.carried_out} impacts with those of the rolls; {seen.rolling} rolls go on")
    print(f"load: mean {sum(seen.loads) / len(seen.loads):.1f} %, greatest {max(seen.loads):.1f} %")
    print(
        f"answers: median {1e3 * ordered[len(ordered) // 2]:.1f} ms, worst {1e3 * ordered[-1]:.1f} ms; {seen.dropped}"
    )
    complete = seen.carried_out > seen.sent and seen.rolling >= ROLLS and not any(seen.dropped.values())
    return 0 if complete and seen.growth < MOST_GROWTH and ordered[-1] < SLOWEST else 1


if __name__ == "__main__":
    sys.exit(main())
