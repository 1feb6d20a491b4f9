"""Figures of a bowed string: where bowing is periodic, by Schelleng and by Guettler."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..bowing import SPEED, schelleng_limit
from .tables import Row

_LONG = 30.0  # periods: longer transients are drawn as none


def drawings(steady: list[Row], limits: list[Row], started: list[Row]) -> dict[str, Callable[[], Figure]]:
    """Draw the figures, by name, of the rows of schelleng.csv, limits.csv and guettler.csv."""
    return {"schelleng": lambda: _schelleng(steady, limits), "guettler": lambda: _guettler(started)}


def _schelleng(rows: list[Row], limits: list[Row]) -> Figure:
    figure = Figure(figsize=(7, 5))
    ax = figure.subplots()
    for periodic, color, marker in ((1, "black", "s"), (0, "#cccccc", ".")):
        some = [row for row in rows if row["periodic"] == periodic]
        label = "one slip a period" if periodic else "other motions"
        betas, forces = [row["beta"] for row in some], [row["force"] for row in some]
        ax.scatter(betas, forces, label=label, color=color, marker=marker)
    positions = np.unique([row["beta"] for row in rows])
    limit = [schelleng_limit(beta) for beta in positions]
    ax.plot(positions, limit, color="#d62728", label="Schelleng's upper limit, 2 Z v/(beta (mu_s - mu_d))")
    for name, marker, label in (("greatest", "^", "greatest"), ("least", "v", "least")):
        at, forces = [row["beta"] for row in limits], [row[name] for row in limits]
        without = f"{label} force on a string without torsion, friction falling at once"
        ax.plot(at, forces, marker, color="#d62728", markerfacecolor="none", label=without)
    ax.set(xscale="log", yscale="log", xlabel="position of the bow, share of the string", ylabel="force (N)")
    ax.legend(loc="lower left")
    figure.suptitle(f"A bowed string that began in Helmholtz motion, at {SPEED:g} m/s")
    return figure


def _guettler(rows: list[Row]) -> Figure:
    figure = Figure(figsize=(7, 5))
    ax = figure.subplots()
    shown: dict[str, Any] = {"cmap": "viridis_r", "vmin": 0.0, "vmax": _LONG}
    sung = [row for row in rows if math.isfinite(row["periods"])]
    ax.scatter([row["acceleration"] for row in rows], [row["force"] for row in rows], color="#cccccc", marker=".")
    found = ax.scatter(
        [row["acceleration"] for row in sung], [row["force"] for row in sung], c=[row["periods"] for row in sung],
        marker="s", **shown,
    )  # fmt: skip
    figure.colorbar(found, ax=ax, label="periods until it slips once in each")
    ax.set(xscale="log", yscale="log", xlabel="acceleration of the bow (m/s²)", ylabel="force (N)")
    figure.suptitle("A string at rest that is bowed at a tenth of its length")
    return figure
