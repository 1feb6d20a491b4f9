"""Ten swarms beside 64 other gestures, live on jackd's dummy driver: load, quality, and blocks that came too late.

    python -m tests.bench.live_swarms [--seconds 8] [--block 256]

The other gestures are 24 rolls, dashpots at this number, 8 bounces and 32 rings, of blows on small objects once a
second each. Four scenes, each by its own server: nothing (the control), the gestures, the swarms, and both.
"""

import argparse
import os
import subprocess
import tempfile
import time
from pathlib import Path

from carom.clients.client import Client
from carom.clients.top import values
from tests.support import serving

ROLLS, BOUNCES, RINGS, SWARMS = 24, 8, 32, 10
ACCURACY = "-50"


def swarms(client: Client) -> None:
    """Begin ten swarms, of 300 to 3000 blows a second."""
    for n in range(SWARMS):
        name = f"struck-{n}"
        client.new(name, ("tin-lid", "ceramic-bowl", "wood-board", "drinks-can", "plastic-cup")[n % 5], gain=-30)
        client.send(f"/object/{name}/shake", 300 * (n + 1), "striker", ("rice", "gravel")[n % 2], "id", f"swarm-{n}")


def others(client: Client) -> None:
    """Begin the other gestures that last, and bounces."""
    for n in range(ROLLS):
        client.new(f"floor-{n}", "wood-board", gain=-30)
        client.roll(f"floor-{n}", 0.3, striker="glass-marble", surface="steel", id=f"roll-{n}", seed=n)
    for n in range(BOUNCES):
        client.new(f"under-{n}", "marimba-bar", gain=-30)
    for n in range(RINGS):
        client.new(f"bar-{n}", "xylophone-bar", gain=-30)


def measure(port: int, scene: str, seconds: float) -> dict[str, float]:
    """Play a scene; return what its server says of the last seconds."""
    with Client(port=port) as client:
        client.send("/accuracy", ACCURACY)
        if "gestures" in scene:
            others(client)
        if "swarms" in scene:
            swarms(client)
        client.ask("/sync", 1, timeout=60.0)
        time.sleep(3.0)  # while tables and the first blocks are made
        before = values(client.status())
        loads = []
        for second in range(round(seconds)):
            if "gestures" in scene:
                with client.bundle(time.time() + 0.1):
                    for n in range(RINGS):
                        client.impact(f"bar-{n}", 1.0)
                    for n in range(BOUNCES if second % 2 == 0 else 0):
                        client.bounce(f"under-{n}", 0.1, striker="ping-pong")
            time.sleep(1.0)
            loads.append(float(values(client.status())["load"]))
        after = values(client.status())
    told = {name: float(after[name]) - float(before[name]) for name in ("underflows", "overruns", "late")}
    return {"load": max(loads), "quality": float(after["quality"]), **told}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=8.0, help="for each scene")
    parser.add_argument("--block", type=int, default=256, help="frames")
    given = parser.parse_args()
    name = f"carom-swarms-{os.getpid()}"
    env = os.environ | {"JACK_DEFAULT_SERVER": name, "JACK_NO_START_SERVER": "1"}
    words = ["jackd", "-R", "-n", name, "-d", "dummy", "-r", "48000", "-p", str(given.block)]
    jackd = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        time.sleep(1.0)
        for scene in ("control", "gestures", "swarms", "swarms and gestures"):
            options = ("--device", "system", "--block", given.block)
            with tempfile.TemporaryDirectory() as folder, serving(Path(folder), *options, env=env) as server:
                print(f"{scene:20s}", measure(server.port, scene, given.seconds), flush=True)
    finally:
        jackd.terminate()
        jackd.wait(timeout=10)


if __name__ == "__main__":
    main()
