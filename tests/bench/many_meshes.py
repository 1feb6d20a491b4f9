"""Meshes by the hundred, broken at random or other people's: a model that second routes bear out, or a sentence.

    python -m tests.bench.many_meshes --broken 500 --log build/broken.jsonl
    python -m tests.bench.many_meshes --folder build/corpus --count 300 --log build/others.jsonl
    python -m tests.bench.many_meshes --log build/others.jsonl --tell

Each mesh is a line of the log, and a run goes on where the log ends. Most models are of half as many cells and of
degree 3: their lowest mode is held against that of degree 2 in the same cells (of a shell: of larger triangles), their
mass against the places that the surface goes round (of a sheet: wall and area), what they radiate against a piston. One
in `--whole` at random, each whose lowest modes disagree and each that cells refuse is made as `carom mesh` makes it,
and its lowest mode is held against theirs; one in `--finer` of these, and those that still disagree, of finer cells.
"""

import argparse
import hashlib
import json
import os
import re
import signal
import time
import traceback
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np

from carom.dsp.bodies.air import IMPEDANCE
from carom.dsp.mesh import cells
from carom.dsp.mesh import model as modelling
from carom.dsp.mesh.cleaning import cleaned
from carom.dsp.mesh.model import Model, Wanted, model_of
from carom.dsp.mesh.surface import MeshError, Surface, faces_of
from carom.dsp.mesh.winding import windings
from carom.dsp.numerics.blas import on_one_thread
from carom.presets.meshes import FORMATS
from tests.bench.meshes import METAL, broken, read_scaled

_QUICK, _MIDDLE = (
    {"CELLS": cells_of, "FINE": cells_of, "_TRIANGLES": triangles, "_FINE_TRIANGLES": triangles, "POINTS": 200}
    for cells_of, triangles in (((3, 24), (250, 1000)), ((4, 36), (400, 2000)))
)
"""Degree and number of cells, triangles of a shell, and points of the air."""
_COARSE = {"_TRIANGLES": (150, 500), "_FINE_TRIANGLES": (150, 500)}
_LONGEST, _MOST = 60.0, 4.0  # s of CPU, GB
_ENDLESS = 240  # s: a mesh that takes longer is given up
_ALONG = 14, 28  # places along each side of the box about a body: of a slender one more
_SHARP = 0.1  # of the volume
_SAME = 0.05  # of the mass
_ROUNDED = 0.1  # of the area of a shell
_PISTON = 12.0  # times what areas radiate for themselves; the skin's are a few
_LOWEST = 0.08  # of the lowest frequency
_FAR = 1.5  # times it: some more cells do not settle it
_OF_CELLS = re.compile(
    r"^(cells of|walls too thin|no ray|no mode|.* % of the rays|the mode of|its lowest mode|\d+,?\d* triangles)"
)


class Mesh(NamedTuple):
    """A mesh, its name in the log, and its wall (m) or None."""

    name: str
    points: np.ndarray
    faces: np.ndarray
    wall: float | None


class Tried(NamedTuple):
    """A model with the lowest frequency (Hz) by fewer unknowns, or the sentence that says why there is none."""

    model: Model | None
    coarse: float
    said: str


def tried(mesh: Mesh, fine: bool = False) -> Tried:
    """Return what becomes of a mesh; the second frequency is that of one degree less, or of larger triangles."""
    less: list[np.ndarray] = []
    solve = cells.of_points

    def of_points(inside: Any, pieces: Any, materials: Any, degree: int, *more: Any) -> Any:
        found = solve(inside, pieces, materials, degree, *more)
        if degree == modelling.CELLS[0] - 1:
            less[:] = [found.frequency]
        elif degree == _QUICK["CELLS"][0]:  # of which the product makes no coarser ones
            less[:] = [solve(inside, pieces, materials, degree - 1, 16, *more[1:]).frequency]
        return found

    wanted = Wanted(mesh.wall, modes=10, fine=fine, points=modelling.POINTS)
    with patch.object(cells, "of_points", of_points):
        try:
            model = model_of(mesh.points, mesh.faces, METAL, wanted)
        except MeshError as error:
            return Tried(None, np.nan, str(error))
    if model.method == "shells" and not fine:
        with patch.multiple(modelling, **_COARSE), suppress(MeshError):
            less[:] = [model_of(mesh.points, mesh.faces, METAL, wanted).frequency]
    for each in (model.frequency, model.shapes, model.resistance, model.points, model.normals, model.areas):
        assert np.isfinite(each).all()
    assert (model.resistance >= 0).all() and model.mass > 0 and (np.diff(model.frequency) >= 0).all()
    over = less[0][less[0] > 0.8 * model.frequency[0]] if less else []
    return Tried(model, float(over[0]) if len(over) else np.nan, "")


def disagreements(mesh: Mesh, model: Model) -> list[str]:
    """Return how a model contradicts second routes: its mass the places that its surface goes round, or its wall and
    area; what it radiates a piston's."""
    surface, _ = cleaned(mesh.points, mesh.faces, mesh.wall is not None)
    if mesh.wall is None:
        volume, within = _volume(surface)
    else:
        area = float(faces_of(surface).areas.sum())
        volume, within = mesh.wall * area, _ROUNDED * mesh.wall * area  # a shell lies on what is round
    mass, found = METAL.density * volume, []
    if abs(model.mass - mass) > _SAME * mass + METAL.density * within:
        found.append(f"{model.mass:.4g} kg: expected {mass:.4g}")
    along = np.einsum("pkn,pk->pn", model.shapes, model.normals)
    most = _PISTON * IMPEDANCE * (model.areas @ along**2 + model.shapes.max() ** 2 * 1e-6 * model.areas.sum())
    if (model.resistance > most).any():
        found.append(f"radiates {float((model.resistance / most).max()) * _PISTON:.3g} times a piston's")
    return found


def _volume(surface: Surface) -> tuple[float, float]:
    """Return the volume (m^3) that a surface goes round, and four times its standard error: of one place at random in
    each of as many boxes, those that the surface crosses are right or wrong by chance."""
    low, size = surface.points.min(axis=0), np.ptp(surface.points, axis=0)
    rng, faces, whole = np.random.default_rng(1), faces_of(surface), float(np.prod(size))
    looks = float((faces.areas @ np.abs(faces.normals) * size).sum()) / whole  # of the box's sides, which faces cover
    volume = within = 0.0
    for along in _ALONG:
        steps = np.arange(along)
        boxes = np.stack(np.meshgrid(steps, steps, steps, indexing="ij")).reshape(3, -1).T
        inside = windings(surface, low + (boxes + rng.random(boxes.shape)) / along * size) > 0.5
        crossed = min(looks * along**2 + 1, len(boxes))
        volume, within = float(inside.mean()) * whole, 4 * float(np.sqrt(crossed / 6)) / len(boxes) * whole
        if within < _SHARP * volume:
            break
    return volume, within


def _apart(one: float, other: float) -> str:
    """Return a sentence on two lowest frequencies (Hz) that contradict each other, or nothing."""
    if not abs(one / other - 1) <= _LOWEST:
        return f"{one:.4g} Hz: by a second route {other:.4g}"
    return ""


def examined(mesh: Mesh, whole: bool, finer: bool) -> dict[str, Any]:
    """Return what becomes of a mesh: at whole effort or, if that suffices, quickly; finer: by finer cells, too."""
    effort, found, low = "whole", Tried(None, np.nan, ""), np.nan
    for name, less in () if whole else (("quick", _QUICK), ("middle", _MIDDLE)):
        with patch.multiple(modelling, **less):
            found = tried(mesh)
        if found.model is None:
            effort = "whole" if _OF_CELLS.match(found.said) else name
            break
        low = found.model.frequency[0]
        if not _apart(low, found.coarse):
            effort = "whole" if disagreements(mesh, found.model) else name
            break
        if found.coarse > _FAR * low:
            break
    row: dict[str, Any] = {}
    if effort == "whole":
        begun = time.process_time()
        found = tried(mesh)
        row["took"] = round(time.process_time() - begun, 2)
        if found.model and np.isnan(found.coarse):
            found = found._replace(coarse=low)
    row |= {"effort": effort, "said": found.said, "outcome": "sentence", "apart": []}
    if not found.model:
        return row
    row |= {"outcome": "model", "mass": found.model.mass, "lowest": found.model.frequency[0], "coarse": found.coarse}
    row |= {"method": found.model.method, "notes": found.model.notes}
    row["apart"] = disagreements(mesh, found.model)
    lowest = _apart(found.model.frequency[0], found.coarse)
    if finer or lowest:
        row["effort"] = "finer"
        with_more = tried(mesh, fine=True)
        if with_more.model:
            row["fine"] = with_more.model.frequency[0]
            lowest = _apart(found.model.frequency[0], with_more.model.frequency[0])
        else:
            lowest = f"of finer cells: {with_more.said}"
    if lowest:
        row["apart"].append(lowest)
    return row


def broken_meshes(count: int, seed: int) -> Iterator[Mesh]:
    """Yield meshes that are broken at random."""
    for number in range(count):
        surface, wall = broken(np.random.default_rng([seed, number]))
        yield Mesh(f"broken {seed} {number}", *surface, wall)


def files_of(folder: Path, count: int) -> Iterator[Path]:
    """Yield so many files of meshes of a folder, by chance, each content once, the small ones first."""
    found: dict[str, Path] = {}
    for file in sorted(each for each in folder.rglob("*") if each.suffix.lower() in FORMATS and each.is_file()):
        found.setdefault(hashlib.sha256(file.read_bytes()).hexdigest(), file)
    yield from sorted((found[key] for key in sorted(found)[:count]), key=lambda file: file.stat().st_size)


def meshes_of(folder: Path, count: int, known: set[str]) -> Iterator[Mesh | tuple[str, str]]:
    """Yield the meshes of a folder, or a file's name and the sentence that says why it is not read."""
    for file in files_of(folder, count):
        name = str(file.relative_to(folder))
        if name in known:
            continue
        try:
            yield Mesh(name, *read_scaled(file), None)
        except MeshError as error:
            yield name, str(error)


def _peak(begin: bool = False) -> float:
    """Return the largest memory (GB) since the last beginning; Linux alone knows it."""
    if begin:
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    said = re.search(r"VmHWM:\s+(\d+)", Path("/proc/self/status").read_text(encoding="ascii"))
    return int(said[1]) / 1e6 if said else np.nan


def run(meshes: Iterator[Mesh | tuple[str, str]], log: Path, whole: int, finer: int) -> None:
    """Examine meshes that a log has no line of, and add one for each."""
    known = names_in(log)
    for each in meshes:
        name = each[0]
        if name in known:
            continue
        chance = int(hashlib.sha256(name.encode()).hexdigest()[:8], 16)
        row: dict[str, Any] = {"name": name}
        if not isinstance(each, Mesh):
            row |= {"outcome": "sentence", "said": each[1], "effort": "read", "apart": []}
        else:
            row |= _timed(each, chance % whole == 0, chance % (whole * finer) == 0)
            if row["outcome"] == "sentence" and each.wall is None and name.partition(" ")[0] != "broken":
                wall = 0.02 * float(np.ptp(each.points[np.unique(each.faces)], axis=0).max())
                row["sheet"] = _timed(each._replace(wall=wall), chance % whole == 0, chance % (whole * finer) == 0)
        with log.open("a", encoding="utf-8") as file:
            file.write(json.dumps(row) + "\n")
        for what in (row, row.get("sheet", {})):
            if what.get("apart") or what.get("outcome") == "fault":
                print(name, what, flush=True)


def _timed(mesh: Mesh, whole: bool, finer: bool) -> dict[str, Any]:
    begun = time.process_time()
    _peak(begin=True)
    signal.alarm(_ENDLESS)
    try:
        row = examined(mesh, whole, finer)
    except Exception:
        row = {"outcome": "fault", "said": traceback.format_exc(), "effort": "", "apart": []}
    finally:
        signal.alarm(0)
    return row | {
        "faces": len(mesh.faces), "wall": mesh.wall,
        "seconds": round(time.process_time() - begun, 2), "gb": round(_peak(), 3),
    }  # fmt: skip


def names_in(log: Path) -> set[str]:
    """Return the names of the meshes that a log has a line of."""
    return {row["name"] for row in rows_of(log)}


def rows_of(log: Path) -> list[dict[str, Any]]:
    """Return the lines of a log."""
    return [json.loads(line) for line in log.read_text(encoding="utf-8").splitlines()] if log.exists() else []


def tell(log: Path) -> None:
    """Print what became of the meshes of a log."""
    rows = rows_of(log)
    every = rows + [row["sheet"] for row in rows if "sheet" in row]
    outcomes, efforts = Counter(row["outcome"] for row in every), Counter(row["effort"] for row in every)
    apart = [row for row in every if row["apart"]]
    slow = max((row.get("took", row.get("seconds", 0.0)) for row in every), default=0.0)
    print(
        f"{len(rows)} meshes, {len(every) - len(rows)} of them as sheets, too: {dict(outcomes)}; by effort "
        f"{dict(efforts)}; {len(apart)} models that a second route contradicts; {slow:.1f} s of CPU at most, "
        f"{max((row.get('gb', 0.0) for row in every), default=0.0):.2f} GB"
    )


def _too_long(*_: object) -> None:
    raise TimeoutError(f"longer than {_ENDLESS} s")


def main(words: list[str] | None = None) -> None:
    """Read the command line, or words."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--broken", type=int, default=0, metavar="N", help="meshes that are broken at random")
    parser.add_argument("--seed", type=int, default=7, help="of what is broken in them (%(default)s)")
    parser.add_argument("--folder", type=Path, help="a folder of meshes")
    parser.add_argument("--count", type=int, default=300, help="of the folder's meshes, by chance (%(default)s)")
    parser.add_argument(
        "--whole", type=int, default=8, metavar="N", help="one in so many at whole effort (%(default)s)"
    )
    parser.add_argument("--finer", type=int, default=4, metavar="N", help="one in so many of these by finer cells, too")
    parser.add_argument("--log", type=Path, metavar="FILE", help="a line for each mesh (build/meshes-N.jsonl, anew)")
    parser.add_argument("--tell", action="store_true", help="tell what the log holds, and stop")
    options = parser.parse_args(words)
    if options.log is None:
        options.log = Path("build") / f"meshes-{os.getpid()}.jsonl"
        options.log.parent.mkdir(exist_ok=True)
    signal.signal(signal.SIGALRM, _too_long)
    with on_one_thread():
        if not options.tell and options.broken:
            run(broken_meshes(options.broken, options.seed), options.log, options.whole, options.finer)
        if not options.tell and options.folder:
            known = names_in(options.log)
            run(meshes_of(options.folder, options.count, known), options.log, options.whole, options.finer)
    tell(options.log)


if __name__ == "__main__":
    main()
