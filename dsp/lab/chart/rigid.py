"""Figures of contacts with a rigid wall: errors against cost, hard and damped contacts, rebounds."""

import math
from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..sampled import METHODS
from ..spectrum import SPECTRUM_TOP
from ..wall import PAPER_CASES, Outcome, pareto
from .style import COLOURS, LEAST_ERROR, LINES, Draw, correction_legend, method_legend
from .tables import Row, Sequences, pick


def drawings(rows: list[Row], sequences: Sequences) -> dict[str, Draw]:
    """Draw the figures of rigid contacts, by their names."""
    return {
        "error-cost": lambda: _error_cost(rows),
        "deviation-cost": lambda: _deviation_cost(rows),
        "hard": lambda: _against(rows, "hard", lambda row: row["samples"], "duration (samples)"),
        "damped": lambda: _against(rows, "damped", lambda row: row["mu"] * row["v_in"], "mu v_in"),
        "rebounds": lambda: _rebounds(sequences),
    }


def _error_percent(row: Row) -> float:
    return max(abs(float(row["err_v_out"])), LEAST_ERROR)


def _spectrum(row: Row) -> float:
    return float(row["spectrum_dB"])


def _error_cost(rows: list[Row]) -> Figure:
    figure = Figure(figsize=(11, 7.2))
    axes = figure.subplots(2, len(PAPER_CASES), sharey="row", squeeze=False)
    for column, case in enumerate(PAPER_CASES):
        here = pick(rows, case=case)
        above, below = axes[:, column]
        above.set(title=f"case {case}: {here[0]['samples']:.4g} samples of contact", yscale="log")
        for ax, error, closed in ((above, _error_percent, ("closed-release", "paper-release")), (below, _spectrum, ())):
            usable = [row for row in here if math.isfinite(error(row))]
            _front(ax, usable, error)
            for method in METHODS:
                for correction, line in LINES.items():
                    some = pick(usable, method=method, correction=correction)
                    cost = [row["ns_per_contact"] for row in some]
                    marker = "o" if correction == "none" else ""
                    ax.plot(cost, list(map(error, some)), line, color=COLOURS[method], marker=marker, markersize=2.5)
            for name, marker, label in (
                ("paper-release", "D", "the paper's v_out alone"),
                ("closed-release", "P", "exact v_out alone"),
                ("closed", "*", "closed form, whole pulse"),
            ):
                if name == "closed" or name in closed:
                    for row in pick(here, method=name):
                        ax.plot(row["ns_per_contact"], error(row), marker, color="black", markersize=9, label=label)
            ax.set_xscale("log")
            ax.minorticks_off()
        below.set_xlabel("cost of a contact (ns)")
    axes[0, 0].set_ylabel("error of v_out (%)")
    axes[1, 0].set_ylabel(f"error of the force's spectrum,\n0 to {SPECTRUM_TOP / 1e3:g} kHz (dB)")
    marks = axes[0, 0].get_legend_handles_labels()[0]
    front = Line2D([], [], color="#bbbbbb", linewidth=5, label="Pareto front")
    handles = [*method_legend(closed=False), *correction_legend(), *marks, front]
    figure.legend(handles=handles, loc="outside lower center", ncols=6)
    figure.suptitle("Error against cost; along a line the oversampling doubles")
    return figure


def _deviation_cost(rows: list[Row]) -> Figure:
    """Draw how far the sampled methods stray from the curves x(v) and H(v); the closed form is the curves."""
    figure = Figure(figsize=(11, 7.2))
    axes = figure.subplots(2, len(PAPER_CASES), sharey="row", squeeze=False)
    for column, case in enumerate(PAPER_CASES):
        here = pick(rows, case=case)
        for ax, name in zip(axes[:, column], ("dev_x", "dev_H"), strict=True):
            for method in METHODS:
                for correction, line in LINES.items():
                    some = pick(here, method=method, correction=correction)
                    cost = [row["ns_per_contact"] for row in some]
                    deviation = [max(row[name], LEAST_ERROR) for row in some]
                    marker = "o" if correction == "none" else ""
                    ax.plot(cost, deviation, line, color=COLOURS[method], marker=marker, markersize=2.5)
            ax.set(xscale="log", yscale="log")
            ax.minorticks_off()
        axes[0, column].set_title(f"case {case}: {here[0]['samples']:.4g} samples of contact")
        axes[1, column].set_xlabel("cost of a contact (ns)")
    axes[0, 0].set_ylabel("%dev(x)")
    axes[1, 0].set_ylabel("%dev(H)")
    figure.legend(handles=[*method_legend(closed=False), *correction_legend()], loc="outside lower center", ncols=7)
    figure.suptitle("Deviation from x(v) and H(v) against cost; along a line the oversampling doubles")
    return figure


def _front(ax: Axes, rows: list[Row], error: Callable[[Row], float]) -> None:
    cost = np.array([row["ns_per_contact"] for row in rows])
    found = np.array([error(row) for row in rows])
    best = np.flatnonzero(pareto(cost, found))
    best = best[np.argsort(cost[best])]
    ends = np.append(cost[best], cost.max() * 1.5)
    ax.step(ends, np.append(found[best], found[best][-1]), where="post", color="#bbbbbb", linewidth=5, zorder=0)


def _against(rows: list[Row], case: str, x: Callable[[Row], float], label: str) -> Figure:
    """Draw errors and cost without oversampling over one of the law's parameters; crosses: failed."""
    figure = Figure(figsize=(12, 4.2))
    left, middle, right = figure.subplots(1, 3)
    some = [row for row in pick(rows, case=case) if row["oversampling"] == 1]
    quantities = ((left, _error_percent), (middle, _spectrum), (right, lambda row: row["ns_per_contact"]))
    for ax, quantity in quantities:
        for method in METHODS:
            for correction, line in (("none", "-"), ("both", "--")):
                mine = pick(some, method=method, correction=correction)
                ax.plot(list(map(x, mine)), list(map(quantity, mine)), line, color=COLOURS[method])
                failed = [row for row in mine if row["outcome"] != Outcome.SOUND.name]
                ax.plot(list(map(x, failed)), list(map(quantity, failed)), "x", color=COLOURS[method], markersize=5)
        for name in ("closed", *(("closed-release",) if ax is right else ())):
            mine = pick(some, method=name)
            style = "-o" if name == "closed" else ":o"
            ax.plot(list(map(x, mine)), list(map(quantity, mine)), style, color="black", markersize=3)
        ax.set(xscale="log", xlabel=label)
    left.set(yscale="log", ylabel="error of v_out (%)", ylim=(LEAST_ERROR / 3, 1e6))
    middle.set(ylabel="error of the force's spectrum (dB)", ylim=(-150, 40))
    right.set(yscale="log", ylabel="cost of a contact (ns)")
    styles = [
        Line2D([], [], color="gray", label="no correction"),
        Line2D([], [], color="gray", linestyle="--", label="x = x(v) and v_out"),
        Line2D([], [], color="gray", linestyle="", marker="x", label="failed"),
        Line2D([], [], color="black", linestyle=":", marker="o", markersize=3, label="closed form, v_out alone"),
    ]
    figure.legend(handles=[*method_legend(), *styles], loc="outside lower center", ncols=9)
    return figure


def _rebounds(sequences: Sequences) -> Figure:
    figure = Figure(figsize=(11, 4.6))
    for ax, (case, found) in zip(figure.subplots(1, len(sequences), sharey=True), sequences.items(), strict=True):
        exact = found["exact", "none"]
        places = np.unique(np.geomspace(1, len(exact), 100).astype(int)) - 1
        for method in METHODS:
            for correction, line in {**LINES, "paper-both": "-."}.items():
                speed = found[method, correction]
                reached = places[places < len(speed)]
                error = 100 * np.abs((speed[reached] / exact[reached]) ** 2 - 1)
                ax.plot(reached + 1, np.maximum(error, 1e-14), line, color=COLOURS[method])
        ax.set(xscale="log", yscale="log", xlabel="rebounds", title=f"case {case}")
    ax.figure.axes[0].set_ylabel("accumulated error on H (% of the energy left)")
    paper = Line2D([], [], color="gray", linestyle="-.", label="x = x(v) and the paper's v^_out")
    handles = [*method_legend(closed=False), *correction_legend(), paper]
    figure.legend(handles=handles, loc="outside lower center", ncols=8)
    return figure
