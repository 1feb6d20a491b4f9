"""Blocks that JACK's dummy device loses while Python threads hold the GIL.

In blocks of 64 frames at 48 kHz, one after the other on one jackd: a Carom server that plays, and nothing else (what
the machine itself loses); the same with hogs in its own process; a Python callback with the same hogs. The recording of
the hogged server is then compared with the render of its log.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import soundfile

from carom.dsp.runtime.engine import Engine
from carom.presets.library import Presets
from carom.server.osc.score import read
from carom.server.render import Options, blocks

RATE, FRAMES = 48_000, 64
WORST = 0.02  # share of the blocks that hogs may cost: exit code 1 beyond it

CLIENT = """
import gc, os, sys, threading, time
from pathlib import Path
import numpy as np
import sounddevice as sd
from carom.clients.client import Client
from carom.server.options import Options
from carom.server.start import serving

kind, hogged, seconds = sys.argv[1], sys.argv[2] == "hogged", float(sys.argv[3])

def loop():
    while True:
        sum(i * i for i in range(1000))

def sort():
    numbers = list(np.random.default_rng(1).permutation(300_000))
    while True:
        sorted(numbers)

def collect():
    garbage = [[i] for i in range(200_000)]
    while True:
        gc.collect()

def measure(count):
    if hogged:
        for hog in (loop, sort, collect):
            threading.Thread(target=hog, daemon=True).start()
    time.sleep(1)
    before, start = count(), time.monotonic()
    time.sleep(seconds)
    print((count() - before) / ((time.monotonic() - start) * 48000 / 64), flush=True)

def strike(port):
    with Client(port=port) as client:
        client.new("a", "glockenspiel-bar")
        start = time.time() + 1
        for n in range(int(20 * seconds)):
            with client.bundle(start + 0.05 * n):
                client.impact("a", 1.0)
        client.ask("/sync", 1)

if kind == "python":
    blocks = 0

    def callback(outdata, frames, times, status):
        global blocks
        blocks += 1
        outdata[:] = 0

    with sd.OutputStream(48000, 64, "system", 2, "float32", latency="low", callback=callback):
        measure(lambda: blocks)
        os._exit(0)
files = Path("out.wav"), Path("log.txt")
with serving(Options(port=0, device="system", block=64, record=files[0], log=files[1])) as server:
    listening = threading.Thread(target=server.run)
    listening.start()
    strike(server.address[1])
    measure(lambda: server.engine.stats.callbacks)
    server.stop()
    listening.join()
os._exit(0)
"""


def compare(folder: Path) -> None:
    """Assert that what was recorded is what the log renders to, bit for bit."""
    recorded, _ = soundfile.read(folder / "out.wav", dtype="float32")
    options = Options(seconds=len(recorded) / RATE)
    rendered = np.concatenate(list(blocks(read(folder / "log.txt"), Engine(RATE), Presets(), options)))
    assert recorded.any()
    np.testing.assert_array_equal(rendered, recorded)


def shares(seconds: float, folder: Path) -> dict[str, float]:
    """Return the share of its blocks that each client lost: alone, hogged, python; `folder` is for its files."""
    name = f"carom-gil-{os.getpid()}"
    env = os.environ | {"JACK_DEFAULT_SERVER": name, "JACK_NO_START_SERVER": "1"}
    words = ["jackd", "-R", "-n", name, "-d", "dummy", "-r", str(RATE), "-p", str(FRAMES)]
    jackd = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        time.sleep(2.0)
        lost = {}
        for what, kind, load in (
            ("alone", "carom", "silent"),
            ("hogged", "carom", "hogged"),
            ("python", "python", "hogged"),
        ):
            (folder / "client.py").write_text(CLIENT)
            words = [sys.executable, "client.py", kind, load, str(seconds)]
            run = subprocess.run(words, cwd=folder, env=env, stdout=subprocess.PIPE, text=True, check=True)
            lost[what] = 1.0 - float(run.stdout.split()[-1])
            if what == "hogged":
                compare(folder)
        return lost
    finally:
        jackd.terminate()
        jackd.wait(timeout=10)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=60.0)
    with tempfile.TemporaryDirectory() as name:
        lost = shares(parser.parse_args().seconds, Path(name))
    for who, share in lost.items():
        print(f"{who:8s} {100 * share:7.2f} % of the blocks lost")
    sys.exit(lost["hogged"] - lost["alone"] > WORST)
