"""Figures of failures: contacts scattered over all parameters."""

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from ..sampled import CORRECTIONS, METHODS
from ..wall import Outcome
from .style import COLOURS, LEAST_ERROR, LINES, Draw, method_legend
from .tables import TITLES, Failures

_FAILURES = {
    Outcome.NOT_FINITE: "#222222",
    Outcome.STICKS: "#8c4fc4",
    Outcome.MISSED: "#2f6fd0",
    Outcome.FASTER: "#d62728",
    Outcome.GAINS: "#ff9d2e",
}
_SAYS = {
    Outcome.SOUND: "sound",
    Outcome.NOT_FINITE: "not finite",
    Outcome.STICKS: "sticks",
    Outcome.MISSED: "missed: goes on into the wall",
    Outcome.FASTER: "leaves faster than it came",
    Outcome.GAINS: "gains energy on the way",
}


def drawings(found: Failures) -> dict[str, Draw]:
    """Draw the figures of failures, by their names."""
    return {
        "failures": lambda: _failures(found, _dissipation(found), "mu v_in"),
        "failures-exponent": lambda: _failures(found, found.laws[:, 4], "exponent a"),
        "failures-corrections": lambda: _all_failures(found),
        "accuracy": lambda: _accuracy(found),
    }


def _dissipation(found: Failures) -> NDArray[np.float64]:
    return found.laws[:, 0] * found.laws[:, 3]


class _Bins:
    """Cells over duration (samples) and one other quantity, in the logarithm of both or (a) of duration only."""

    def __init__(self, found: Failures, y: NDArray[np.float64]) -> None:
        per_side = min(48, int(math.sqrt(len(y) / 12)))
        self.logarithmic = y.max() > 100
        low = 1e-4 if self.logarithmic else y.min()
        self.x_edges = np.geomspace(0.003, found.samples.max(), per_side + 1)
        self.y_edges = (np.geomspace if self.logarithmic else np.linspace)(low, y.max(), 3 * per_side // 4 + 1)
        self.x, self.y = (np.clip(q, e[0], e[-1]) for q, e in ((found.samples, self.x_edges), (y, self.y_edges)))

    def total(self, weights: NDArray[Any]) -> NDArray[np.float64]:
        return np.histogram2d(self.y, self.x, (self.y_edges, self.x_edges), weights=weights)[0]

    def show(self, ax: Axes, colours: NDArray[np.float64], **options: Any) -> Any:
        mesh = ax.pcolormesh(self.x_edges, self.y_edges, colours, rasterized=True, **options)
        ax.set(xscale="log", yscale="log" if self.logarithmic else "linear")
        ax.minorticks_off()
        ax.grid(False)
        return mesh


def _show_failures(ax: Axes, bins: _Bins, outcome: NDArray[np.int64]) -> None:
    """Draw the colours of the kinds of failures, mixed with white by their share."""
    number = bins.total(np.ones(len(outcome)))
    colours = np.ones((*number.shape, 3))
    for kind, colour in _FAILURES.items():
        share = bins.total(outcome == kind) / np.maximum(number, 1)
        colours -= share[..., None] * (1 - np.array(to_rgb(colour)))
    colours[number == 0] = 0.85
    bins.show(ax, np.clip(colours, 0, 1))


def _failed_title(name: str, outcome: NDArray[np.int64]) -> str:
    return f"{name}: {100 * (outcome != Outcome.SOUND).mean():.3g} % fail"


def _failure_legend(figure: Figure, points: int) -> None:
    handles = [Line2D([], [], linestyle="", marker="s", color=c, label=_SAYS[kind]) for kind, c in _FAILURES.items()]
    for colour, label in (("white", _SAYS[Outcome.SOUND]), ("#d9d9d9", "no contact")):
        handles.insert(0, Line2D([], [], linestyle="", marker="s", color=colour, markeredgecolor="gray", label=label))
    figure.legend(handles=handles, loc="outside lower center", ncols=7)
    figure.suptitle(f"{points} contacts over all parameters: share of each failure")


def _failures(found: Failures, y: NDArray[np.float64], label: str) -> Figure:
    figure = Figure(figsize=(12, 5.4))
    axes = figure.subplots(2, len(METHODS) + 1, sharex=True)
    bins = _Bins(found, y)
    for row, correction in enumerate(("none", "both")):
        for column, method in enumerate(METHODS):
            outcome = found.outcomes[method, correction]
            _show_failures(axes[row, column], bins, outcome)
            corrected = ", corrected" if correction == "both" else ""
            axes[row, column].set_title(_failed_title(TITLES[method] + corrected, outcome), fontsize=9)
            axes[row, column].tick_params(labelleft=column == 0)
        axes[row, 0].set_ylabel(label)
    closed = found.outcomes["closed", "none"]
    _show_failures(axes[0, -1], bins, closed)
    axes[0, -1].tick_params(labelleft=False)
    axes[0, -1].set_title(_failed_title(TITLES["closed"], closed), fontsize=9)
    _failure_shares(axes[1, -1], found)
    for ax in axes[1]:
        ax.set_xlabel("duration (samples)")
    _failure_legend(figure, len(closed))
    return figure


def _failure_shares(ax: Axes, found: Failures) -> None:
    edges = np.geomspace(0.003, found.samples.max(), 19)
    place = np.digitize(found.samples, edges)
    for (method, correction), outcome in found.outcomes.items():
        if correction in ("none", "both"):
            share = [100 * np.mean(outcome[place == i] != Outcome.SOUND) for i in range(1, len(edges))]
            middles = np.sqrt(edges[1:] * edges[:-1])
            ax.plot(middles, share, LINES[correction], color=COLOURS[method])
    ax.set_title("% that fail (dashed: corrected)", fontsize=9)
    ax.legend(
        handles=method_legend(),
        fontsize=6,
        loc="lower left",
        bbox_to_anchor=(0, 0.04),
        handlelength=1,
        markerscale=0.4,
    )


def _all_failures(found: Failures) -> Figure:
    figure = Figure(figsize=(12.5, 13))
    axes = figure.subplots(len(CORRECTIONS), len(METHODS), sharex=True, sharey=True)
    bins = _Bins(found, _dissipation(found))
    for row, correction in enumerate(CORRECTIONS):
        for column, method in enumerate(METHODS):
            outcome = found.outcomes[method, correction]
            _show_failures(axes[row, column], bins, outcome)
            axes[row, column].set_title(_failed_title(f"{TITLES[method]}, {correction}", outcome), fontsize=9)
        axes[row, 0].set_ylabel("mu v_in")
    for ax in axes[-1]:
        ax.set_xlabel("duration (samples)")
    _failure_legend(figure, len(found.laws))
    return figure


def _accuracy(found: Failures) -> Figure:
    """Return the mean order of magnitude of the error of v_out; failures count as they come, 1000 % at most."""
    figure = Figure(figsize=(12, 3.2))
    axes = figure.subplots(1, len(METHODS) + 1, sharex=True, sharey=True)
    bins = _Bins(found, _dissipation(found))
    number = bins.total(np.ones(len(found.laws)))
    for ax, method in zip(axes, (*METHODS, "closed"), strict=True):
        error = np.nan_to_num(np.abs(found.errors[method, "none"]), nan=np.inf)
        magnitude = np.log10(np.clip(error, LEAST_ERROR, 1e3))
        mean = np.where(number > 0, bins.total(magnitude) / np.maximum(number, 1), np.nan)
        mesh = bins.show(ax, mean, cmap="RdYlGn_r", vmin=-6, vmax=3)
        ax.set(title=TITLES[method], xlabel="duration (samples)")
    axes[0].set_ylabel("mu v_in")
    bar = figure.colorbar(mesh, ax=axes, extend="min", label="error of v_out (%)", ticks=range(-6, 4, 3))
    bar.ax.set_yticklabels([f"$10^{{{n}}}$" for n in range(-6, 4, 3)])
    return figure
