"""The report of an object that was made of a mesh: its picture, its loudest modes, and a table of all."""

from __future__ import annotations

import base64
import io
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..dsp.bodies.air import IMPEDANCE
from ..dsp.bodies.material import Material
from ..dsp.bodies.mesh import Table, decay_times, usual_path
from ..dsp.mesh.refining import refined
from .comparison import player, rows, write_page
from .fitting import played
from .meshes import Asked, MadeMesh
from .plot import PlotError, require_matplotlib

_DRAWN = 5  # modes
_RATE = 48_000
_LIGHT = np.array([0.4, -0.5, 0.77])
_FACES, _MOST_FACES = 1200, 40_000  # in a picture
_HIGHEST = 16_000.0  # Hz: of a mode that is drawn
_FULL = 0.97  # of the points: their motion is at most that of full colour


def write_mesh_report(made: MadeMesh, asked: Asked, material: Material, out: Path) -> Path:
    """Write the page NAME.html into a folder of presets; return it."""
    table = made.table
    x, y, z = 1e3 * np.ptp(table.points, axis=0)
    known = table.error[np.isfinite(table.error)]
    lines = [
        f"{x:.3g} x {y:.3g} x {z:.3g} mm of {asked.material}, {table.mass:.4g} kg; {len(table.frequency)} modes from "
        f"{table.frequency[0]:.1f} to {table.frequency[-1]:.0f} Hz at {len(table.points)} points.",
        *(f"Mended or assumed: {note}." for note in made.notes),
        f"A second resolution differs by {100 * np.median(known):.2g} % (median), {100 * known.max():.2g} % (most)."
        if len(known)
        else "The errors of frequencies were not computed: add --errors.",
        "The body is free. Its loudness is that at 1 m, the mean over directions.",
    ]
    sound = played(asked.name, out, _RATE).mean(axis=1)
    peak = max(float(np.abs(sound).max()), 1e-9)
    more = f"<p>A strike with the preset's striker:</p>{player(sound / peak, _RATE)}{_pictures(made, material)}"
    return write_page(
        out / f"{asked.name}.html", f"{asked.name}: from a mesh", [], lines, more + _table(table, material)
    )


def _loudest(table: Table, material: Material) -> NDArray[np.intp]:
    """Return the numbers of the modes that are heard best, where each moves most."""
    most = (table.shapes**2).sum(axis=1).max(axis=0)
    heard = table.resistance * most * decay_times(table, material) * (table.frequency <= _HIGHEST)
    return np.sort(np.argsort(-heard)[:_DRAWN])


def _pictures(made: MadeMesh, material: Material) -> str:
    try:
        require_matplotlib()
    except PlotError as error:
        return f"<p>{escape(str(error))}</p>"
    memory = io.BytesIO()
    _draw(made, _loudest(made.table, material), memory)
    data = base64.b64encode(memory.getvalue()).decode()
    return f'<figure><img alt="The object, and its loudest modes" src="data:image/png;base64,{data}"></figure>'


def _draw(made: MadeMesh, modes: NDArray[np.intp], file: io.BytesIO) -> None:
    from matplotlib.figure import Figure

    table = made.table
    figure = Figure(figsize=(11, 7), layout="constrained")
    axes = figure.subplots(2, 3, subplot_kw={"projection": "3d"}).ravel()
    drawn = refined(made.surface, _FACES)
    faces = drawn.faces
    if len(faces) > _MOST_FACES:
        faces = faces[np.linspace(0, len(faces) - 1, _MOST_FACES).astype(int)]
    corners = drawn.points[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    light = 0.35 + 0.6 * np.abs(normals @ _LIGHT)
    near = _nearest(table, corners.mean(axis=1), normals)
    plain = np.repeat(light[:, None], 3, axis=1) * np.array([0.75, 0.8, 0.9])
    _surface(axes[0], corners, plain, "the mesh, and the path of strikes")
    start, end = usual_path(table)
    share = np.linspace(0, 1, 30)[:, None]
    axes[0].plot(*table.near((1 - share) * start + share * end)[0].T, color="#d06020", linewidth=2)
    for ax, mode in zip(axes[1:], modes, strict=False):
        along = np.einsum("pc,pc->p", table.shapes[:, :, mode], table.normals)
        share = (along / np.quantile(np.abs(along), _FULL))[near]
        _surface(ax, corners, _coloured(share, light), f"{table.frequency[mode]:.0f} Hz")
    for ax in axes[1 + len(modes) :]:
        ax.set_axis_off()
    figure.savefig(file, dpi=100, format="png")


def _surface(ax: Any, corners: NDArray[np.float64], colours: NDArray[np.float64], title: str) -> None:
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    ax.add_collection3d(Poly3DCollection(corners, facecolors=np.clip(colours, 0, 1), edgecolors="none"))
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    middle, half = (low + high) / 2, float((high - low).max()) / 2
    ax.set(
        xlim=(middle[0] - half, middle[0] + half),
        ylim=(middle[1] - half, middle[1] + half),
        zlim=(middle[2] - half, middle[2] + half),
        title=title,
        box_aspect=(1, 1, 1),
    )
    ax.set_axis_off()


def _coloured(share: NDArray[np.float64], light: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return colours (m, 3): red outward, blue inward, white at rest."""
    out, into = np.clip(share, 0, 1)[:, None], np.clip(-share, 0, 1)[:, None]
    colour = 1 - out * np.array([0.1, 0.75, 0.85]) - into * np.array([0.85, 0.6, 0.1])
    return np.asarray(colour * light[:, None])


def _nearest(table: Table, places: NDArray[np.float64], normals: NDArray[np.float64]) -> NDArray[np.intp]:
    """Return the numbers of the table's points nearest to places (n, 3), on the same skin."""
    from scipy.spatial import cKDTree

    across = float(np.sqrt(np.median(table.areas)))  # points of one skin lie that far apart
    tree = cKDTree(np.hstack([table.points, across * table.normals]))
    found: NDArray[np.intp] = tree.query(np.hstack([places, across * normals]))[1]
    return found


def _table(table: Table, material: Material) -> str:
    """Return all modes, as HTML."""
    decay = decay_times(table, material)
    pressure = np.sqrt(IMPEDANCE * table.resistance / (4 * np.pi))
    most = np.sqrt((table.shapes**2).sum(axis=1).max(axis=0))
    loudest = float((pressure * most).max())
    body = [
        [
            f"{table.frequency[i]:.1f}",
            "-" if np.isnan(table.error[i]) else f"{100 * table.error[i]:.2g} %",
            f"{decay[i]:.3g}",
            f"{1 / most[i] ** 2:.3g}",
            f"{pressure[i]:.3g}",
            f"{20 * np.log10(pressure[i] * most[i] / loudest):.1f}",
        ]
        for i in range(len(decay))
    ]
    head = (
        "Hz",
        "within",
        "T60 (s)",
        "least modal mass (kg)",
        "Pa per unit velocity",
        "struck where it moves most (dB)",
    )
    return f"<h2>All modes</h2>{rows(head, body)}"
