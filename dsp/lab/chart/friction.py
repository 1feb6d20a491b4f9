"""Figures of friction: energy that a method gives back though it never took it, and cost against accuracy."""

import math
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..bristle import METHODS
from .tables import Row, pick

_SAYS = {
    "located": ("rigid, events located", "#d62728", "s-"),
    "held": ("rigid, one force a sample", "#d98a00", "s--"),
    "elastic": ("elastic, springs that slip", "black", "D-"),
    "explicit bristle": ("bristle, explicit step", "#3b75af", "o--"),
    "iterated bristle": ("bristle, iterated", "#2a8f4f", "o-"),
}
_LEAST, _MOST = 1e-16, 1e3  # gains are drawn within


def drawings(errors: list[Row], extremes: list[Row]) -> dict[str, Callable[[], Figure]]:
    """Draw the figures, by name, of the rows of friction.csv and friction-energy.csv."""
    return {
        "friction-energy": lambda: _energy(extremes),
        "friction-cost": lambda: _cost(errors, extremes),
    }


def failed(rows: Iterable[Row]) -> float:
    """Return the share (%) of rubs in which friction gives back more than it took, or blows up."""
    return 100.0 * float(np.mean([row["fails"] for row in rows]))


def _styled(method: str) -> dict[str, Any]:
    label, color, style = _SAYS[method]
    return {"label": label, "color": color, "linestyle": style[1:], "marker": style[0], "markersize": 4}


def _energy(extremes: list[Row]) -> Figure:
    figure = Figure(figsize=(10, 4.6))
    factors = sorted({row["factor"] for row in extremes})
    axes = figure.subplots(1, 2, sharey=True)
    for ax, factor in zip(axes, (factors[0], factors[-1]), strict=True):
        for method in METHODS:
            gains = sorted(row["gain"] for row in pick(extremes, method=method, factor=factor))
            drawn = np.clip(np.nan_to_num(gains, posinf=math.inf), _LEAST, _MOST)
            label, color, style = _SAYS[method]
            ax.plot(100.0 * (np.arange(len(drawn)) + 1) / len(drawn), drawn, style[1:], color=color, label=label)
        ax.set(yscale="log", xlabel="share of random extremes (%)", title=f"at {factor} times the rate")
    axes[0].set_ylabel("most that friction gave back, over the driver's work\n(top: it blew up; bottom: nothing)")
    axes[0].legend(loc="upper left")
    figure.suptitle("Friction that gives energy it never took: modes, forces, speeds and stiffnesses at random")
    return figure


def _cost(errors: list[Row], extremes: list[Row]) -> Figure:
    figure = Figure(figsize=(10, 4.6))
    axes = figure.subplots(1, 2)
    for method in METHODS:
        rows = pick(errors, method=method)
        axes[0].plot([row["ns"] for row in rows], [row["error"] for row in rows], **_styled(method))
        _failures(axes[1], pick(extremes, method=method), method)
    axes[0].set(xscale="log", yscale="log", xlabel="cost (ns for each sample at 48 kHz)")
    axes[0].set_ylabel("rms error of the velocity, over the driver's")
    axes[1].set(xscale="log", xlabel="times the rate", ylabel="random extremes at which it fails (%)")
    factors = sorted({row["factor"] for row in extremes})
    axes[1].set_xticks(factors, [str(factor) for factor in factors])
    for ax in axes:
        ax.minorticks_off()
    axes[0].legend(loc="lower left")
    figure.suptitle("Four modes that are rubbed, at 1 to 8 times the rate; each against itself at 64 times")
    return figure


def _failures(ax: Axes, rows: list[Row], method: str) -> None:
    factors = sorted({row["factor"] for row in rows})
    ax.plot(factors, [failed(pick(rows, factor=factor)) for factor in factors], **_styled(method))
