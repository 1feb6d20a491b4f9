"""The style of charts: colours, names and legends, and the files that they are drawn into."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..sampled import METHODS
from .tables import TITLES

Draw = Callable[[], Figure]
"""Draws one figure."""

_STYLE: dict[Any, Any] = {
    "font.size": 9.0,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "lines.linewidth": 1.3,
    "svg.hashsalt": "carom",
    "svg.fonttype": "none",
    "figure.constrained_layout.use": True,
}
COLOURS = {"am1": "#3b75af", "verlet": "#2a8f4f", "heun": "#d98a00", "rk4": "#b0307a", "closed": "#000000"}
LINES: dict[str, Literal["-", ":", "--"]] = {"none": "-", "hybrid": ":", "both": "--"}
LEAST_ERROR = 1e-15  # %: no error is drawn below


def save(draw: Draw, path: Path) -> None:
    """Draw a figure into `path` with the endings .svg and .png."""
    with rc_context(_STYLE):
        figure = draw()
        figure.savefig(path.with_suffix(".svg"), metadata={"Date": None})
        figure.set_layout_engine("none")  # the layout of the SVG is kept
        figure.savefig(path.with_suffix(".png"), dpi=110)


def method_legend(closed: bool = True) -> list[Line2D]:
    """Return the legend entries of the sampled methods and, if `closed`, the closed form."""
    names = [*METHODS, *(["closed"] if closed else [])]
    return [Line2D([], [], color=COLOURS[name], marker="o", markersize=4, label=TITLES[name]) for name in names]


def correction_legend() -> list[Line2D]:
    """Return the legend entries of the corrections."""
    says = {"none": "no correction", "hybrid": "x = x(v)", "both": "x = x(v) and v_out"}
    return [Line2D([], [], color="gray", linestyle=line, label=says[name]) for name, line in LINES.items()]
