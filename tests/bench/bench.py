"""Benchmark of Carom's speed: its kernels beside plain C and scsynth's Klank, its impacts, its start-up.

Ratios are taken in one run, from minima over interleaved rounds, so that what else the machine does cancels out.
"""

import argparse
import ctypes
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from datetime import date
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from numba import njit

from carom.dsp.engine.memory.state import QUANTUM, new_state
from carom.dsp.native.jit import kernel as compiled
from carom.dsp.resonator.bank import RESPONSES, Modes, Point, inject, ring
from carom.dsp.resonator.coefficients import set_mode
from carom.dsp.resonator.simd import LANES
from tests.bench import (
    clips,
    contacts,
    driven,
    gestures,
    klank,
    lasting,
    many,
    portable,
    ringing,
    rolled,
    slides,
    struck,
    swarms,
    swelling,
)
from tests.bench.machine import machine
from tests.bench.rounds import Contenders, minima

RATE = 48_000.0
BANKS = [(1, 16), (1, 64), (1, 256), (1, 1024), (1, 4096), (16, 64), (64, 16)]  # objects, modes of each
MODE_SAMPLES = 2**22  # a measurement of a kernel
KLANK_MODES = 1024
KLANK_SECONDS = (1, 9)  # two renderings, whose difference has no start-up in it

TITLES = {
    "Objects that ring: ns per mode-sample, of the kernel by itself; share of a core": "ringing",
    "Modes that ring while objects are struck 200 times per second: share of callbacks of 64 frames": "struck",
    "Modes on which a body rolls: ns per mode-sample, free and by its moments beside": "driven",
    "A body that rolls and feels the modes: share of a core, and over that on a dashpot": "rolled",
    "Many contacts that last: share of a core": "lasting",
    "Impacts in the engine: µs each": "impacts",
    "Long contacts": "long_contacts",
    "Contacts by themselves: µs, and over what a prototype took": "solvers",
    "Gestures: share of real time on one core": "gestures",
    "Friction by itself: µs a sample, events included": "friction",
    "A tam-tam whose modes are coupled, and asleep: share of a core": "swelling",
    "Strings that are bowed: share of real time on one core": "slides",
    "Swarms: share of a core, in blocks of 64 frames": "swarms",
    "The same bits everywhere: share of a core in the engine, and over that of this processor's own code": "portable",
    "Clips: an impact of one second in a fresh scene, with labels": "clips",
    "Many: items of recipes, and worlds, per second of one core, and over the engine's own time": "many",
    "Start-up: s": "startup",
}
"""Titles of the tables that are shown after the kernels'."""

STARTUP = """
from time import perf_counter
start = perf_counter()
from carom.dsp.runtime.engine import Engine
imported = perf_counter()
engine = Engine(48000.0)
made = perf_counter()
engine.process(64)
print(imported - start, made - imported, perf_counter() - made)
"""


@njit(error_model="numpy")
def ring_quanta(objects, n, quanta, arrays):
    for _ in range(quanta):
        for i in range(0, objects * n, n):
            ring(modes_from(arrays, i, i + n), arrays[5], 0, QUANTUM)


@njit(error_model="numpy")
def drive_quanta(objects, n, quanta, arrays):
    out, shape, weights, moments = arrays[5], arrays[7], arrays[8], arrays[9]
    for _ in range(quanta):
        for i in range(0, objects * n, n):
            modes, point = modes_from(arrays, i, i + n), Point(shape[4 * i : 4 * (i + n)], n, 0, weights)
            for t in range(QUANTUM):
                inject(modes, point, moments)
                ring(modes, out, t, t + 1)


@compiled
def modes_from(arrays, i, j):
    y1, y2, a1, a2, balance, _, response = arrays[:7]
    tables = response[i // LANES * RESPONSES : j // LANES * RESPONSES]
    return Modes(y1[i:j], y2[i:j], a1[i:j], a2[i:j], balance[i:j], tables)


def bank(modes: int) -> tuple[np.ndarray, ...]:
    """Return the arrays of modes that all but ring for ever, in the order in which the C kernels take them."""
    state = new_state(RATE)[0]
    record = state["bank"]
    made = Modes(*(record[name] for name in Modes._fields))
    for i, frequency in enumerate(np.linspace(100.0, 15_000.0, modes)):
        set_mode(made, i, frequency, 1e-3, RATE, 1.0)
    record["y1"][:modes] = 1.0
    record["balance"][:modes] = 0.5
    record["shape"] = 0.1
    arrays = [record[name] for name in ("y1", "y2", "a1", "a2", "balance")]
    more = (record["response"], record["shape"], np.full(4, 0.25), 0.01 * 0.5 ** np.arange(8))
    return (*arrays, state["scratch"]["voices"][0], *more)


def compile_reference() -> ctypes.CDLL | None:
    """Compile the kernels in C, or return None without a compiler."""
    compiler = shutil.which(os.environ.get("CC", "cc"))
    if not compiler:
        return None
    source = Path(__file__).with_name("reference.c")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        library = Path(folder, "reference.so")
        code = Path(folder, "reference.o")
        # In two steps: linked with -ffast-math, a library flushes the subnormals of whoever loads it.
        flags = ["-O3", "-march=native", "-ffast-math", "-fPIC"]
        subprocess.run([compiler, *flags, "-c", "-o", code, source], check=True)
        subprocess.run([compiler, "-shared", "-o", library, code], check=True)
        return ctypes.CDLL(str(library))


def pointers(arrays: tuple[np.ndarray, ...]) -> list[ctypes.c_void_p]:
    return [ctypes.c_void_p(array.ctypes.data) for array in arrays]


def check(reference: ctypes.CDLL) -> None:
    """Assert that the reference computes the same."""
    counts = (2, 24, 2)
    longs = [ctypes.c_long(n) for n in counts]
    ours, theirs = bank(48), bank(48)
    drive_quanta(*counts, ours)
    reference.drive_quanta(*longs, *pointers(theirs))
    np.testing.assert_allclose(theirs[5], ours[5], rtol=1e-9)
    ring_quanta(*counts, ours)
    reference.ring_quanta(*longs, *pointers(theirs[:6]))
    np.testing.assert_allclose(theirs[5], ours[5], rtol=1e-9)


def kernels(objects: int, modes: int, reference: ctypes.CDLL | None) -> tuple[Contenders, int]:
    """Yield both kernels, also in C where there is a compiler, and the mode-samples that each run takes."""
    quanta = max(1, MODE_SAMPLES // (objects * modes * QUANTUM))
    counts = (objects, modes, quanta)
    arguments = bank(objects * modes)
    contenders: Contenders = {
        "ring": partial(ring_quanta, *counts, arguments),
        "drive": partial(drive_quanta, *counts, arguments),
    }
    if reference:
        longs = [ctypes.c_long(n) for n in counts]
        contenders["ring C"] = partial(reference.ring_quanta, *longs, *pointers(arguments[:6]))
        contenders["drive C"] = partial(reference.drive_quanta, *longs, *pointers(arguments))
    minima(contenders, 1)  # compiles
    return contenders, math.prod(counts) * QUANTUM


def measure_kernels(reference: ctypes.CDLL | None, rounds: int) -> list[dict[str, Any]]:
    """Measure ns per mode-sample of each kernel for each of BANKS."""
    rows: list[dict[str, Any]] = []
    for objects, modes in BANKS:
        contenders, samples = kernels(objects, modes, reference)
        ns = {name: seconds / samples * 1e9 for name, seconds in minima(contenders, rounds).items()}
        for kernel in ("ring", "drive"):
            c = ns.get(f"{kernel} C")
            of_c = c / ns[kernel] if c else None
            rows.append(dict(kernel=kernel, objects=objects, modes=modes, ns=ns[kernel], c_ns=c, of_c=of_c))
    return rows


def measure_klank(rounds: int) -> dict[str, float] | None:
    """Measure ns per mode-sample of scsynth's mono Klank, and how many times faster our stereo kernels are."""
    if not klank.SCSYNTH:
        return None
    contenders, samples = kernels(1, KLANK_MODES, None)
    with tempfile.TemporaryDirectory() as folder:
        for seconds in KLANK_SECONDS:
            contenders[f"{seconds} s"] = partial(klank.render, Path(folder), KLANK_MODES, seconds, int(RATE))
        best = minima(contenders, rounds)
    short, long = KLANK_SECONDS
    ns = (best[f"{long} s"] - best[f"{short} s"]) / ((long - short) * RATE * KLANK_MODES) * 1e9
    ratios = {f"{kernel}_ratio": ns / (best[kernel] / samples * 1e9) for kernel in ("ring", "drive")}
    return {"modes": KLANK_MODES, "klank_ns": ns, **ratios}


def fresh(code: str, cache: str) -> tuple[float, list[float]]:
    """Run code in a new interpreter with its own cache folder: seconds in all, and what it prints."""
    environment = os.environ | {"XDG_CACHE_HOME": cache}
    start = perf_counter()
    printed = subprocess.check_output([sys.executable, "-c", code], env=environment, text=True)
    return perf_counter() - start, [float(word) for word in printed.split()]


def measure_startup(rounds: int) -> list[dict[str, Any]]:
    """Measure seconds from nothing to the first block, with the interpreter: with an empty cache and with a full
    one."""
    with tempfile.TemporaryDirectory() as cache:
        cold = fresh(STARTUP, cache)
        warm = min(fresh(STARTUP, cache) for _ in range(rounds))
    return [
        dict(cache=name, all=total, imports=imports, engine=engine, first_block=block)
        for name, (total, (imports, engine, block)) in (("cold", cold), ("warm", warm))
    ]


def aims(results: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the aims, set mostly before the engine was written, for effective mass and two contacts later; `met` is
    None where what to measure against is missing."""
    large = [r["of_c"] for r in results["kernels"] if r["modes"] >= 1024]
    of_c = min(large) if None not in large else None
    rings = min(row["ratio"] for row in results["ringing"] if row["objects"] * row["modes"] > 50_000)
    ratio = results["klank"]["ring_ratio"] if results["klank"] else None
    mean, most = (results["struck"][-2][name] for name in ("mean", "most"))
    cold, warm = (run["all"] for run in results["startup"])
    clip = max(row["ms"] for row in results["clips"])
    empty, resident = results["empty_scene"]["ms"], results["empty_scene"]["resident_mb"]
    million = "a million modes in float32, some of them struck, under 0.35 of real time"
    return [
        dict(aim="at least 0.8 of C's speed on 1024 modes and more", measured=of_c, met=of_c and of_c >= 0.8),
        dict(aim="50,000 modes and more at least 20 times as fast as by the kernel", measured=rings, met=rings >= 20.0),
        dict(aim=million, measured=mean, met=mean < 0.35),
        dict(aim="99.9 % of their callbacks of 64 frames under 0.6", measured=most, met=most < 0.6),
        dict(aim="at least 10 x scsynth's Klank", measured=ratio, met=ratio and ratio >= 10.0),
        *_contacts_aims(results),
        *swarms.aims(results["swarms"]),
        *swelling.aims(results["swelling"]),
        dict(aim="a clip of one second, with labels, under 20 ms", measured=clip, met=clip < 20.0),
        dict(aim="an empty scene under 5 ms", measured=empty, met=empty < 5.0),
        dict(aim="an empty scene under 5 MB", measured=resident, met=resident and resident < 5.0),
        dict(aim="start-up under 1 s warm", measured=warm, met=warm < 1.0),
        dict(aim="start-up under 15 s cold", measured=cold, met=cold < 15.0),
    ]


def _contacts_aims(results: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the aims for contacts."""
    impact = max(
        row["us"]
        for row in results["impacts"]
        if row["solver"] in contacts.CLOSED and row["modes"] == 24 and row["contact_samples"] <= 6
    )
    six = [row for row in results["impacts"] if row["modes"] == 24 and row["contact_samples"] == 6]
    us = {row["solver"]: row["us"] for row in six}
    wall, yielding = (us[name] for name in contacts.CLOSED)
    soft, coupled = yielding / wall, us["coupled -60"] / wall
    pair = max(row["us_of_two"] / row["us_per_sample"] for row in results["long_contacts"])
    prototype = max(row["of_prototype"] for row in results["solvers"] if row["of_prototype"])
    load = max(row["load"] for row in results["gestures"] if row["accuracy"] == "-60")
    friction = max(row["us_per_sample"] for row in results["friction"])
    bowed = results["slides"][-1]["load"]
    return [
        dict(aim="an impact on 24 modes, contact up to 6 samples, under 5 µs", measured=impact, met=impact < 5.0),
        dict(aim="an impact of 6 samples with effective mass under 1.2 times a wall's", measured=soft, met=soft < 1.2),
        dict(aim="an impact of 6 samples at -60 at most 1.5 times a wall's", measured=coupled, met=coupled <= 1.5),
        dict(aim="two contacts on one object under 3 times one", measured=pair, met=pair < 3.0),
        dict(aim="contacts within 2 x of the prototype's cost", measured=prototype, met=prototype < 2.0),
        dict(aim="64 rolls and 64 bounces in real time on one core", measured=load, met=load < 1.0),
        dict(aim="friction on 64 modes, events included, under 0.5 µs a sample", measured=friction, met=friction < 0.5),
        dict(aim="20 slides under 0.7 of a core", measured=bowed, met=bowed < 0.7),
        *rolled.aims(results["rolled"]),
        *lasting.aims(results["lasting"]),
    ]


def show(title: str, rows: list[dict[str, Any]]) -> None:
    """Print a table of rows alike."""
    cells = [[f"{v:.3g}" if isinstance(v, float) else str(v) for v in row.values()] for row in rows]
    table = [list(rows[0]), *cells]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    print(f"\n{title}")
    for row in table:
        print("  ".join(f"{cell:{width}}" for cell, width in zip(row, widths, strict=True)).rstrip())


def parts_of(reference: ctypes.CDLL | None, quick: bool) -> dict[str, Callable[[], Any]]:
    """Return the parts of the benchmark; reference: the kernels in C, if there are; quick: fewer rounds."""
    rounds, few = (7, 2) if quick else (20, 5)
    return {
        "kernels": lambda: measure_kernels(reference, rounds),
        "klank": lambda: measure_klank(few),
        "ringing": lambda: ringing.measure(rounds),
        "struck": lambda: struck.measure(struck.CALLBACKS // (5 if quick else 1)),
        "driven": lambda: driven.measure(rounds),
        "rolled": lambda: rolled.measure(rounds),
        "lasting": lambda: list(lasting.measure()),
        "impacts": lambda: contacts.measure_impacts(rounds),
        "long_contacts": lambda: contacts.measure_long_contacts(rounds),
        "solvers": lambda: contacts.measure_solvers(rounds),
        "gestures": lambda: gestures.measure(few),
        "friction": slides.measure_contacts,
        "slides": lambda: slides.measure(few),
        "swarms": lambda: swarms.measure(rounds),
        "swelling": lambda: swelling.measure(rounds),
        "empty_scene": clips.measure_empty,
        "clips": lambda: clips.measure_clips(clips.CLIPS // (3 if quick else 1)),
        "many": many.measure,
        "portable": lambda: portable.measure(few),
        "startup": lambda: measure_startup(few),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=Path, help="write the results to this file")
    parser.add_argument("--quick", action="store_true", help="fewer rounds, rougher figures")
    options = parser.parse_args()
    reference = compile_reference()
    if reference:
        check(reference)
    else:
        print("no C compiler: kernels are not compared with C")
    if not klank.SCSYNTH:
        print("no scsynth: kernels are not compared with its Klank")
    parts = parts_of(reference, options.quick)
    results: dict[str, Any] = {"date": date.today().isoformat(), "quick": options.quick, "machine": machine()}
    for name, measure in parts.items():
        begun = perf_counter()
        results[name] = measure()
        print(f"{name}: measured in {perf_counter() - begun:.0f} s")
    results["aims"] = aims(results)
    show("Machine", [results["machine"]])
    show("Kernels: ns per mode-sample", results["kernels"])
    if results["klank"]:
        show("scsynth's Klank: ns per mode-sample, ratio to ours", [results["klank"]])
    for title, name in TITLES.items():
        show(title, results[name])
    show("An empty scene", [results["empty_scene"]])
    show("Aims", results["aims"])
    if options.json:
        options.json.write_text(json.dumps(results, indent=2) + "\n")


if __name__ == "__main__":
    main()
