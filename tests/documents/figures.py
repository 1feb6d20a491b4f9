"""Tables of figures: promises as the tests hold them, measurements from the files that the measuring scripts wrote."""

import csv
import json
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from carom.dsp.lab.chart import report
from carom.dsp.lab.chart.tables import Row
from tests.accuracy import GROWTH, PROMISES
from tests.bench import bursts, extremes, friction, fuzz, gil, hours, overload, queries, soak, waveforms
from tests.bench import fits as fitted
from tests.documents import study
from tests.documents.markdown import table

BENCH = study.MEASURED / "bench.json"
SPACE = study.MEASURED / "space.json"
WEB = study.MEASURED / "web.json"
HELD = study.MEASURED / "held.json"
MESHES = study.MEASURED / "meshes.json"
COMPILING = study.MEASURED / "compiling.json"


def accuracy() -> str:
    """Return the bounds that the tests hold."""
    rows = [(each.quantity, each.reference, each, f"[{each.test}]({each.test})") for each in PROMISES]
    return table(("quantity", "compared with", "error below", "test"), rows)


def failures() -> str:
    return f"{_made()}\n\n{_reported(report.failure_table, 'failures.csv')}"


def rebounds() -> str:
    return _reported(report.rebound_table, "rebounds.csv")


def yielding() -> str:
    return _reported(report.yielding_table, "coupled.csv")


def choices() -> str:
    """Return the closed form beside the cheapest sampled runs."""
    rows = [
        (
            _number(row["samples"]), _number(row["mu_v"]), f"{row['closed_dB']:.0f} dB", _number(row["closed_us"]),
            row["enough"], _number(row["enough_us"]), row["equal"], _number(row["equal_us"]),
        )
        for row in study.read(study.MEASURED / "choices.csv")
    ]  # fmt: skip
    enough = f"cheapest sampled run within {study.ENOUGH:g} dB"
    head = ("samples", "mu v_in", "closed form", "µs", enough, "µs", "cheapest one as exact as the closed form", "µs")
    return table(
        head, [[cell or "none" if place in (4, 6) else cell for place, cell in enumerate(row)] for row in rows]
    )


def endurance() -> str:
    """Return the bounds beyond which the scripts of `make study` fail."""
    rows = [
        ("extremes", "100,000 extreme contacts at each tolerance, and in blocks",
            f"energy grows by {GROWTH.bound:g} of a contact's, in blocks by {extremes.GROWTH_IN_BLOCKS:g}"),
        (
            "extreme_groups", "100,000 times one to four extreme strikers at once on an object, in the engine",
            f"energy grows by {GROWTH.bound:g} of all that there is, in blocks by {extremes.GROWTH_IN_BLOCKS:g}",
        ),
        (
            "waveforms", "whole sounds of 12 presets and 4 strikers at -60, struck twice, against `exact`",
            f"{waveforms.WORST:g} dB below 12 kHz, nine of ten {waveforms.NINE_OF_TEN:g} dB",
        ),
        (
            "friction", "100,000 random rubs in each way to solve friction; a bow's limits, and its map at three rates",
            f"{friction.BALANCE:g} of the work, {friction.SLOPE:g} of an exponent, "
            f"{100 * friction.DIFFERENT:g} % of a map",
        ),
        (
            "soak", f"ten minutes of {soak.RATE:,} impacts per second and {soak.ROLLS} rolls, none dropped, none late",
            f"{1e3 * soak.SLOWEST:.0f} ms per answer, {soak.MOST_GROWTH:g} MB of memory",
        ),
        (
            "hours", f"four hours offline of {hours.OBJECTS * hours.MODES:,} modes that are struck and freed at random",
            f"{hours.MOST_APART:g} dB of a mode that rings throughout, {hours.MOST_GROWTH:g} MB of memory, "
            f"{hours.MOST_COST:g} of a fresh engine's cost",
        ),
        (
            "overload", "rolls and presses that need several times the time there is, after ten seconds",
            f"{overload.MOST:g} % load, {1e3 * overload.LAG:.0f} ms behind",
        ),
        (
            "bursts", f"10,000 bursts of up to {bursts.MOST:,} blows in a frame, over 120 dB, against room for all",
            f"{bursts.APART:g} dB of momentary loudness; a blow that is neither heard nor reported",
        ),
        (
            "fuzz", "a million mutated and random packets, over UDP and TCP: no crash, and the next strike sounds",
            f"{1e3 * fuzz.HANG:.0f} ms of the server's time per {fuzz.BATCH} packets",
        ),
        (
            "queries", f"{queries.CLIENTS} programs that ask for all addresses over OSCQuery without end, 512 objects",
            f"{1e3 * queries.LATE:.0f} ms per answer by OSC",
        ),
        (
            "gil", f"{gil.FRAMES} frames per block on JACK while Python threads hog it, to a render's bits",
            f"{100 * gil.WORST:g} % more blocks lost than without them",
        ),
    ]  # fmt: skip
    return table(("script", "load", "fails beyond"), [(f"[{row[0]}](bench/{row[0]}.py)", *row[1:]) for row in rows])


def fits() -> str:
    """Return recordings, fitted: a row for each, with columns for each number of modes; and which can't be fitted
    better."""
    with (study.MEASURED / "fits.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    few, many = ([row for row in rows if int(row["modes"]) == count] for count in (40, 80))
    lines = []
    for a, b in zip(few, many, strict=True):
        cells = a["residual"], a["bound"], a["distance"], b["residual"], b["distance"]
        lines.append((a["sample"], *(f"{float(cell):.1f}" for cell in cells)))
    aim = fitted.BOUNDS["bar"][40][0]
    out = [row["sample"] for row in few if row["sample"] in fitted.BARS and float(row["bound"]) > aim]
    head = ("dB", "40 modes leave", "at least", "distance", "80 modes leave", "distance")
    return f"{table(head, lines)}\n\nNo sum of 40 damped sinusoids leaves less than {aim:g} dB of {' or '.join(out)}."


def held() -> str:
    """Return how far presets are from recordings that none was made with: a row for each family, and the tilts of
    all."""
    families = json.loads(HELD.read_text(encoding="utf-8"))
    rows = [
        (
            f"`{name}`",
            row["recordings"],
            f"{row['gap']:.1f}",
            f"{row['slope']:+.1f}".replace("-0.0", "+0.0") + f" ± {row['spread']:.1f}" * (row["recordings"] > 1),
            f"{row['within']:.0f} % of {row['partials']}",
            "-" if row["alike"] is None else f"{row['alike']:.0f} %",
        )
        for name, row in families.items()
    ]
    head = ("", "recordings", "third octaves (dB)", "tilt (dB/octave)", "T60 within 25 %", "recordings to each other")
    counts = np.array([row["recordings"] for row in families.values()])
    slopes, spreads = (np.array([row[each] for row in families.values()]) for each in ("slope", "spread"))
    about, means = (np.sqrt(counts @ each**2 / counts.sum()) for each in (spreads, slopes))
    whole = f"{np.hypot(about, means):.1f} dB/octave (rms)"
    said = f"Of all {counts.sum()} recordings the tilt is {whole}, {about:.1f} about their presets' means."
    return f"{table(head, rows)}\n\n{said}"


def _made() -> str:
    return (study.MEASURED / study.MADE).read_text(encoding="utf-8").strip()


def _reported(made: Callable[[list[Row]], report.Table], name: str) -> str:
    """Return a table as `carom chart` writes it, with its note."""
    found = made(study.read(study.MEASURED / name))
    return f"{found.note}\n\n{table(found.head, found.rows)}"


def space() -> str:
    """Return what objects in space cost."""
    if not SPACE.exists():
        return "Not measured yet: `python -m tests.bench.space` writes this table."
    measured = json.loads(SPACE.read_text(encoding="utf-8"))
    rows = [(name, f"{100 * cost:.1f}") for name, cost in measured["costs"].items()]
    head = "200 objects of 32 modes that ring, 48 kHz, two channels", "% of a core"
    return f"{_machine(measured)}\n\n{table(head, rows)}"


def meshes() -> str:
    """Return how far models of meshes are from an independent solution."""
    if not MESHES.exists():
        return "Not measured yet: `python -m tests.bench.meshes --only accuracy --json FILE` writes this table."
    found = json.loads(MESHES.read_text(encoding="utf-8"))
    rows = []
    for name, each in found["default"].items():
        kinds = [kind for kind in (each, found["fine"].get(name)) if kind]
        cells = [f"{100 * kind[key]:.2f}" for kind in kinds for key in ("most", "median")]
        cells += [""] * (4 - len(cells))
        held = ", ".join(f"{100 * kind['held']:.0f} %" for kind in kinds)
        spent = ", ".join(f"{kind['seconds']:.0f}" for kind in kinds)
        rows.append((name, *cells, held, spent, f"{100 * each['change']:.2f}"))
    head = ("body, mm", "at most, %", "median, %", "`--fine`: at most", "median", "within the error that is said",
            "CPU, s", "the solution's change, %")  # fmt: skip
    return f"{_machine(found | {'quick': False})}\n\n{table(head, rows)}"


def web() -> str:
    """Return the sizes and times of exported pages."""
    if not WEB.exists():
        return "Not measured yet: `python -m tests.bench.web` writes this table."
    found = json.loads(WEB.read_text(encoding="utf-8"))
    rows = [
        ("the demo's files that a first visit loads, kB", f"{found['kB at a first visit']:.0f}"),
        ("of these the engine", f"{found['kB']['carom.wasm.lzma']:.0f}"),
        ("of these the scene", f"{found['kB']['scene.carom.lzma']:.0f}"),
        ("memory, MB", f"{found['MB']:.0f}"),
        ("from the click to the first sound, nothing cached, s", f"{found['first sound ms, cold'] / 1e3:.2f}"),
        ("the same, all cached", f"{found['first sound ms, warm'] / 1e3:.2f}"),
        *((f"share of the worklet's time: {name}, %", f"{100 * load:.0f}") for name, load in found["loads"].items()),
    ]
    count, wrong = found["random scores"], len({each.split()[0] for each in found["that differ"]})
    told = f"{count - wrong} of {count} random scores of all gestures sound as their render, to the bit, in both"
    told += f"; the demo {'does not' if found.get('the demo differs') else 'does, too'}."
    return f"{_machine(found | {'quick': False})}\n\n{table(('', ''), rows)}\n\n{told}"


def speed() -> str:
    """Return the benchmark's figures."""
    if not BENCH.exists():
        return "Not measured yet: `make bench` writes these tables."
    bench = json.loads(BENCH.read_text(encoding="utf-8"))
    parts = [
        _machine(bench),
        _kernels(bench["kernels"], bench["klank"]),
        _impacts(bench["impacts"], bench["long_contacts"]),
        _ringing(bench["ringing"]),
        _struck(bench.get("struck", [])),
        _driven(bench.get("driven", [])),
        _rolled(bench.get("rolled", [])),
        _lasting(bench.get("lasting", [])),
        _gestures(bench["gestures"]),
        _friction(bench.get("friction", []), bench.get("slides", [])),
        _portable(bench.get("portable", [])),
        _starts(bench),
    ]
    return "\n\n".join(part for part in parts if part)


def compiling() -> str:
    """Say in a sentence how long the engine takes to be compiled."""
    found = json.loads(COMPILING.read_text(encoding="utf-8"))
    if "ratios" not in found:
        return _UNMEASURED
    cores, seconds = found["machine"]["cores"], found["seconds"]
    own = f"compiling the engine for this machine takes about {_round(seconds['an empty cache'])} s"
    wheel = f", for all levels of a wheel {_round(seconds['a wheel'])} s" if "a wheel" in seconds else ""
    return f"On {cores} cores ({found['machine']['cpu']}), {own}{wheel}."


def edits() -> str:
    """Return the time from an edit to a sound, by what was edited."""
    found = json.loads(COMPILING.read_text(encoding="utf-8"))
    if "ratios" not in found:
        return _UNMEASURED
    lines = [
        (name, f"{seconds:.1f}" if seconds < 10 else f"{seconds:.0f}", _number(found["ratios"][name]))
        for name, seconds in found["seconds"].items()
    ]
    head = ("edited, or begun with", "s to a sound", "as a ratio")
    note = (
        f"Ratios are to {found['fixed']:.2f} s, in which numba compiles one fixed function ten times\n"
        "([bench/compiling.py](tests/bench/compiling.py))."
    )
    return f"{_machine(found | {'quick': False})}\n\n{table(head, lines)}\n\n{note}"


_UNMEASURED = "Not measured yet: `python -m tests.bench.compiling` does."


def _round(seconds: float) -> int:
    """Round seconds up to the next ten."""
    return 10 * math.ceil(seconds / 10)


def _machine(bench: dict[str, Any]) -> str:
    on = bench["machine"]
    rough = " Fewer rounds than usual, and rougher figures." if bench["quick"] else ""
    busy = f" Load of the machine before: {on['load_before']:.1f}." if on.get("load_before") else ""
    return (
        f"{bench['date']}, {on['cpu']}, {on['cores']} cores, {on['system'].partition('-')[0]}, Python {on['python']}, "
        f"numba {on['numba']}, numpy {on['numpy']}.{rough}{busy}"
    )


def _kernels(rows: list[dict[str, Any]], klank: dict[str, Any] | None) -> str:
    sizes = list(dict.fromkeys((row["objects"], row["modes"]) for row in rows))
    says = {"ring": "ringing", "drive": "driven by a contact in every sample"}
    lines = []
    for kernel, name in says.items():
        found = {(row["objects"], row["modes"]): row for row in rows if row["kernel"] == kernel}
        lines.append((name, *(_number(found[size]["ns"]) for size in sizes)))
        if found[sizes[0]]["c_ns"]:
            lines.append(
                ("the same in C, `-O3 -march=native -ffast-math`", *(_number(found[size]["c_ns"]) for size in sizes))
            )
    head = [f"{modes} modes" if objects == 1 else f"{objects} x {modes}" for objects, modes in sizes]
    made = f"## Modes\n\n{table(('ns per mode and sample, stereo', *head), lines)}"
    if klank:
        made += (
            f"\n\nscsynth's Klank, in mono, takes {klank['ring_ratio']:.3g} times as long for {klank['modes']} modes."
        )
    return made


def _ringing(rows: list[dict[str, Any]]) -> str:
    """Return the cost of whole objects that ring; nothing where a bench has not measured it so."""
    if "mean" not in rows[0]:
        return ""
    lines = [
        (
            f"{row['objects']:,} x {row['modes']:,}", _number(row["kernel_ns"]), form, _number(row[cost]),
            _number(row[f"{of}ratio"]), f"{row[f'{of}mean']:.2%}", f"{row[f'{of}most']:.2%}",
        )
        for row in rows
        for form, cost, of in (("float64", "process_ns", ""), ("float32", "single_ns", "single_"))
        if cost in row
    ]  # fmt: skip
    head = (
        "objects x modes", "ns per mode and sample, of the kernel, sample by sample", "kept in", "in the engine",
        "times as fast", "of a core, mean", "99.9 % of callbacks of 64 frames",
    )  # fmt: skip
    return f"## Objects that ring\n\n{table(head, lines)}"


def _struck(rows: list[dict[str, Any]]) -> str:
    """Return the time that callbacks take in which a million modes ring and some are struck."""
    if not rows:
        return ""
    lines = [
        (
            row["kept_in"],
            f"{row['modes']:,}",
            f"{row['strikes']:,}",
            *(f"{row[name]:.1%}" for name in ("mean", "most", "worst")),
        )
        for row in rows
    ]
    head = (
        "modes kept in",
        "modes",
        "strikes, 200 per second",
        "of a callback of 64 frames, mean",
        "99.9 %",
        "the longest",
    )
    return f"Called in turns with an engine that does nothing:\n\n{table(head, lines)}"


def _impacts(rows: list[dict[str, Any]], long: list[dict[str, Any]]) -> str:
    says = {
        "wall": "closed form, the object as good as a wall",
        "m*": "closed form, effective mass",
        "coupled -60": "coupled, `-60`",
        "coupled -80": "coupled, `-80`",
        "coupled exact": "coupled, `exact`",
    }
    samples = list(dict.fromkeys(row["contact_samples"] for row in rows))
    modes = list(dict.fromkeys(row["modes"] for row in rows))
    us = {(row["solver"], row["contact_samples"], row["modes"]): row["us"] for row in rows}
    lines = [
        (name, *(" / ".join(_number(us[solver, length, n]) for n in modes) for length in samples))
        for solver, name in says.items()
    ]
    name = f"µs per impact with the ringing that it starts, {' / '.join(map(str, modes))} modes"
    head = (name, *(f"{length:g} samples" for length in samples))
    costs = ("us_per_sample", "us_of_two")
    held = [(says[row["solver"]], row["modes"], *(_number(row[name]) for name in costs)) for row in long]
    lasting = table(("contact that lasts", "modes", "µs per sample", "of two on one object"), held)
    return f"## Contacts\n\n{table(head, lines)}\n\n{lasting}"


def _driven(rows: list[dict[str, Any]]) -> str:
    if not rows:
        return ""
    lines = [(row["modes"], *(_number(row[f"{name}_ns"]) for name in ("ring", "roll", "moments"))) for row in rows]
    head = ("modes", "ns per mode-sample, free", "on which a body rolls", "the same by moments")
    return f"## Rolls\n\n{table(head, lines)}"


def _rolled(rows: list[dict[str, Any]]) -> str:
    """Return the cost of rolls that feel the modes; nothing where a bench has not measured it."""
    if not rows:
        return ""
    lines = [
        (row["modes"], row["surface"], f"`{row['accuracy']}`", f"{100 * row['load']:.3g} %", _number(row["of_dashpot"]))
        for row in rows
    ]
    head = ("modes", "surface", "accuracy", "load of one core", "over that on a dashpot")
    return f"## A body that rolls and feels the modes\n\n{table(head, lines)}"


def _lasting(rows: list[dict[str, Any]]) -> str:
    """Return the cost of many contacts that last; nothing where a bench has not measured it."""
    if not rows:
        return ""
    lines = [(row["contacts"], f"`{row['accuracy']}`", f"{100 * row['load']:.3g} %") for row in rows]
    return table(("at once", "accuracy", "load of one core"), lines)


def _gestures(rows: list[dict[str, Any]]) -> str:
    lines = [
        (
            row["rolls"], row["bounces"], f"`{row['accuracy']}`", f"{100 * row['load']:.3g} %",
            f"{100 * row['worst_block']:.3g} %", f"{row['impacts_per_second']:,.0f}",
        )
        for row in rows
    ]  # fmt: skip
    head = ("rolls", "bounces", "accuracy", "load of one core", "of the worst block", "impacts per second")
    return f"## Gestures on 32 objects of 64 modes\n\n{table(head, lines)}"


def _friction(contacts: list[dict[str, Any]], slides: list[dict[str, Any]]) -> str:
    """Return the cost of friction; nothing where a bench has not measured it."""
    if not contacts:
        return ""
    lines = [
        (row["contact"], row["modes"], f"{row['events_per_second']:,.0f}", f"{row['us_per_sample']:.2f}")
        for row in contacts
    ]
    made = table(("friction by itself", "modes", "events per second", "µs per sample, events included"), lines)
    bowed = [(row["slides"], f"{100 * row['load']:.3g} %", f"{100 * row['worst_block']:.3g} %") for row in slides]
    head = ("strings that are bowed", "load of one core", "of the worst block")
    return f"## Friction\n\n{made}\n\n{table(head, bowed)}"


_CLIPS = {"preset": "objects as their presets are", "geometry": "each object of a new geometry"}


def _portable(rows: list[dict[str, Any]]) -> str:
    """Return what the engine costs whose bits are the same everywhere, if it was measured."""
    if not rows:
        return ""
    lines = [
        (row["score"], f"{100 * row['own']:.2g}", f"{100 * row['portable']:.2g}", f"{row['ratio']:.2f}") for row in rows
    ]
    head = ("% of a core", f"code for {rows[0]['level']}", "portable code", "ratio")
    return f"## The same bits everywhere\n\n{table(head, lines)}"


def _starts(bench: dict[str, Any]) -> str:
    lines = [
        (f"start with a {row['cache']} code cache, to the first block", f"{row['all']:.3g} s")
        for row in bench["startup"]
    ]
    lines += [
        (f"a clip of one second with labels, {_CLIPS[row['objects']]}", f"{row['ms']:.3g} ms") for row in bench["clips"]
    ]
    lines.append(("an empty `Scene`", f"{bench['empty_scene']['ms']:.3g} ms"))
    return f"## Starts and clips\n\n{table(('', 'takes'), lines)}{_many(bench)}"


def _many(bench: dict[str, Any]) -> str:
    """Return the table of what is computed one after the other, if it was measured."""
    lines = [(row["what"], f"{row['per_second']:.3g}", f"{row['over_engine']:.2g}") for row in bench.get("many", ())]
    return f"\n\n{table(('1 s and 32 modes each', 'per second and core', 'times the engine'), lines)}" if lines else ""


def _number(value: float) -> str:
    """Write two digits, or three from 100 on."""
    if math.isnan(value):
        return ""
    return f"{value:.2g}" if abs(value) < 100 else f"{value:.0f}"
