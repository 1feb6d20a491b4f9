"""Figures of contacts with objects that yield: errors, energy and counts against cost."""

from collections.abc import Callable
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..comparison import BANDS
from ..sampled import METHODS
from .style import COLOURS
from .tables import TITLES, Row

_STYLES: dict[str, dict[str, Any]] = {
    **{name: {"color": COLOURS[name], "marker": "o", "markersize": 2.5, "label": TITLES[name]} for name in METHODS},
    "coupled": {"color": "#d62728", "marker": "s", "markersize": 4, "linewidth": 2.2, "label": "coupled solver"},
    "blocks": {"color": "#9467bd", "marker": "^", "markersize": 5, "linewidth": 1.2, "label": "in blocks"},
    "closed": {"color": "black", "marker": "*", "markersize": 9, "linestyle": "", "label": "closed form with m*"},
    "engine": {
        "color": "black", "marker": "D", "markersize": 5, "markerfacecolor": "none", "linewidth": 0.8,
        "label": "the engine's choice at -50, -60, -80 dB",
    },
}  # fmt: skip

_WORST_ERROR = 20.0  # dB: worse ones are drawn there
_LEAST_GROWTH, _MOST_GROWTH = 1e-10, 1e4


def coupled(rows: list[Row]) -> Figure:
    """Draw errors of the object's velocity, energy and contact counts against cost; a column for each of BANDS."""
    figure = Figure(figsize=(11, 8.4))
    axes = figure.subplots(3, len(BANDS), sharex=True, sharey="row")
    for column, band in enumerate(BANDS):
        here = [row for row in rows if (row["sum_r_from"], row["sum_r_to"]) == band]
        for solver in _STYLES:
            some = [row for row in here if row["solver"] == solver]
            _errors(axes[0, column], some)
            _plot(axes[1, column], some, _growth)
            _plot(axes[2, column], some, lambda row: row["wrong_counts_percent"])
        chaotic = "\n(chaotic)" if band == BANDS[-1] else ""
        axes[0, column].set_title(f"m/M from {band[0]:g} to {band[1]:g}{chaotic}")
        axes[2, column].set_xlabel("cost of a contact (µs)")
    axes[0, 0].set(xscale="log", ylim=(-180, _WORST_ERROR + 5))
    axes[1, 0].set(yscale="log", ylim=(_LEAST_GROWTH / 3, _MOST_GROWTH * 3))
    for ax in axes.flat:
        ax.minorticks_off()
    axes[0, 0].set_ylabel("error of the object's velocity (dB)\nmedian, and up to nine of ten")
    axes[1, 0].set_ylabel("worst growth of energy\n(share of the contact's; below: none)")
    axes[2, 0].set_ylabel("wrong number of contacts (%)")
    handles = [Line2D([], [], **style) for style in _STYLES.values()]
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    figure.suptitle(
        "Contacts with objects that yield, by the striker's mass m over the object's M at the point\n"
        "Along a line the oversampling or the parts of a sample grow, or the tolerance falls from none (a held force) "
        "to 1e-7"
    )
    return figure


def _us(rows: list[Row]) -> list[float]:
    return [row["ns_per_contact"] / 1e3 for row in rows]


def _growth(row: Row) -> float:
    return min(max(float(row["growth"]), _LEAST_GROWTH), _MOST_GROWTH)


def _plot(ax: Axes, rows: list[Row], value: Callable[[Row], float]) -> None:
    ax.plot(_us(rows), list(map(value, rows)), **_STYLES[rows[0]["solver"]])


def _errors(ax: Axes, rows: list[Row]) -> None:
    median, ninety = ([min(row[name], _WORST_ERROR) for row in rows] for name in ("median_dB", "ninety_dB"))
    ax.vlines(_us(rows), median, ninety, color=_STYLES[rows[0]["solver"]]["color"], linewidth=1, alpha=0.5)
    _plot(ax, rows, lambda row: min(row["median_dB"], _WORST_ERROR))
