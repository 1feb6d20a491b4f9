"""The reference paper's figures, drawn anew (Papetti, Avanzini, Rocchesso 2011)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from ... import contact
from .. import wall
from ..sampled import METHODS
from ..wall import PAPER_CASES, PAPER_RATE
from .style import COLOURS, LEAST_ERROR, Draw
from .tables import TITLES, Sequences

_M, _K, _MU, _A = 1e-2, 1e9, 0.5, 1.5  # the paper's, unless it says otherwise


def drawings(sequences: Sequences) -> dict[str, Draw]:
    """Draw the paper's figures, by their names."""
    return {
        "paper-1": _paper_1,
        "paper-2": _paper_2,
        "paper-3": _paper_3,
        "paper-4": _paper_4,
        "paper-5": _paper_5,
        "paper-6": lambda: _phase_and_energy(6, "I", _METHODS),
        "paper-7": _paper_7,
        "paper-8": lambda: _phase_and_energy(8, "2", _METHODS),
        "paper-9": lambda: _phase_and_energy(9, "1", _CORRECTED),
        "paper-10": lambda: _phase_and_energy(10, "2", _CORRECTED),
        "paper-11": _paper_11,
        "paper-12": lambda: _paper_12(sequences["2"]),
    }


def _velocities(v_in: float, mu: float) -> NDArray[np.float64]:
    """Return velocities from v_in to v_out, closer to each other near both ends, where x(v) is steep."""
    v_out = float(contact.release_velocity(v_in, mu))
    return v_out + (v_in - v_out) * (0.5 + 0.5 * np.cos(np.linspace(0, math.pi, 201)))


def _paper_1() -> Figure:
    figure = Figure(figsize=(6, 4.5))
    ax = figure.subplots()
    for v_in in (1.0, 2.0, 3.0, 4.0):
        v = _velocities(v_in, _MU)
        (line,) = ax.plot(contact.compression(v, v_in, _M, _K, _MU, _A) * 1e6, v, label=f"v_in = {v_in:g} m/s")
        for speed in (v[0], v[-1]):
            ax.plot([-60, 0], [speed, speed], "--", color=line.get_color())
    ax.axhline(-1 / _MU, color="gray", linestyle=":", label="v_lim = -1/mu")
    ax.set(xlabel="compression x (um)", ylabel="v (m/s)", title="Figure 1: phase portraits; dashed: free motion")
    figure.legend(loc="outside right center")
    return figure


def _paper_2() -> Figure:
    figure = Figure(figsize=(6, 4.5))
    ax = figure.subplots()
    for v_in in (1.0, 2.0, 3.0, 4.0):
        v = _velocities(v_in, _MU)
        x = contact.compression(v, v_in, _M, _K, _MU, _A)
        ax.plot(x * 1e6, contact.force(x, v, _K, _MU, _A), label=f"v_in = {v_in:g} m/s")
    x = np.linspace(0, x.max(), 200)
    ax.plot(x * 1e6, _K * x**_A, "--", color="gray", label="k x^a")
    ax.set(xlabel="compression x (um)", ylabel="force (N)", title="Figure 2: force against compression")
    ax.legend()
    return figure


def _paper_3() -> Figure:
    figure = Figure(figsize=(6, 4.2))
    ax = figure.subplots()
    w = np.geomspace(0.05, 20, 800)
    error = 100 * np.abs(contact.paper_release_velocity(w, 1.0) / contact.release_velocity(w, 1.0) - 1)
    ax.loglog(w, error, color="black")
    for bound, colour in ((1.0, "#cfe3f7"), (0.1, "#9cc4ea")):
        ax.fill_between(w, 1e-8, 10, where=error < bound, color=colour, label=f"under {bound:g} %")
        ax.axhline(bound, color="gray", linewidth=0.6)
    ax.set(xlabel="mu v_in", ylabel="error of v^_out (%)", ylim=(1e-8, 10), xlim=(w[0], w[-1]))
    ax.set_title("Figure 3: the paper's release velocity")
    ax.legend(loc="lower center", frameon=True, facecolor="white", framealpha=1)
    return figure


def _paper_4() -> Figure:
    figure = Figure(figsize=(6, 4.2))
    ax = figure.subplots()
    v = _velocities(1.0, _MU)
    energy = contact.energy(v, 1.0, _M, _MU) * 1e3
    ax.plot(v, energy, color="black")
    for value, name in ((energy[0], "H_0"), (energy[-1], "H_tau")):
        ax.axhline(value, color="gray", linestyle="--", linewidth=0.8)
        ax.annotate(name, (0.0, value), xytext=(0, 3), textcoords="offset points")
    ax.invert_xaxis()
    ax.set(xlabel="v (m/s)", ylabel="H (mJ)", title="Figure 4: energy during a contact, v_in = 1 m/s")
    return figure


def _paper_5() -> Figure:
    k, v_in = 1e3, 0.05
    figure = Figure(figsize=(6, 4.5))
    ax = figure.subplots()
    for pressing in (0.0, 1.0, 2.0, 3.0):
        external = _M * pressing

        def motion(_: float, state: NDArray[np.float64], external: float = external) -> list[float]:
            x, v = state
            return [v, (external - float(contact.force(x, v, k, _MU, _A))) / _M]

        run = solve_ivp(motion, (0, 0.5), (0.0, v_in), "DOP853", rtol=1e-9, atol=1e-12, max_step=1e-3)
        inside = run.y[0] >= 0
        x, v = np.where(inside, run.y[0], np.nan), np.where(inside, run.y[1], np.nan)
        (line,) = ax.plot(x * 1e6, v, label=f"f_e = {external:g} N", linewidth=0.9)
        equilibrium = (external / k) ** (1 / _A)
        ax.plot(equilibrium * 1e6, 0, "o", color=line.get_color(), markersize=4)
    ax.set(xlabel="compression x (um)", ylabel="v (m/s)")
    ax.set_title(
        "Figure 5: pressed in by a constant force f_e, half a second of it\nk = 1e3, v_in = 0.05 m/s; dots: x_eq"
    )
    figure.legend(loc="outside right center")
    return figure


def _energy_of(x: NDArray[np.float64], v: NDArray[np.float64], law: wall.Law) -> NDArray[np.float64]:
    _, m, k, _, a = law
    return np.asarray(0.5 * m * v**2 + contact.potential_energy(x, k, a))


@dataclass(frozen=True)
class _Run:
    """A method with a correction, its label and its colour."""

    method: str
    correction: str
    label: str
    colour: str


_METHODS = [_Run(method, "none", TITLES[method], COLOURS[method]) for method in METHODS]
_CORRECTED = [
    _Run("heun", "none", "Heun", "#d98a00"),
    _Run("heun", "hybrid", "Heun, x = x(v)", "#3b75af"),
    _Run("heun", "both", "Heun, x = x(v) and v_out", "#b0307a"),
]
_LINE: dict[str, Any] = {"marker": "o", "markersize": 3, "linewidth": 0.6}


def _draw_phase(ax: Axes, law: wall.Law, runs: Sequence[_Run]) -> None:
    v_in, m, k, mu, a = law
    v = _velocities(v_in, mu)
    ax.plot(contact.compression(v, v_in, m, k, mu, a) * 1e6, v, color="black")
    for run in runs:
        x, v = wall.path(run.method, run.correction, law, PAPER_RATE)
        ax.plot(x * 1e6, v, color=run.colour, **_LINE)
    ax.set(xlabel="compression x (um)", ylabel="v (m/s)")


def _draw_energy(ax: Axes, law: wall.Law, runs: Sequence[_Run]) -> None:
    v_in, m, _, mu, _ = law
    v = _velocities(v_in, mu)
    ax.plot(v, contact.energy(v, v_in, m, mu) * 1e3, color="black", label="exact")
    for run in runs:
        x, v = wall.path(run.method, run.correction, law, PAPER_RATE)
        ax.plot(v, _energy_of(x, v, law) * 1e3, color=run.colour, label=run.label, **_LINE)
    ax.invert_xaxis()
    ax.set(xlabel="v (m/s)", ylabel="H (mJ)")


def _paper_7() -> Figure:
    figure = Figure(figsize=(6, 4.2))
    ax = figure.subplots()
    _draw_energy(ax, PAPER_CASES["1"], _METHODS)
    ax.set_title("Figure 7: case 1, energy")
    ax.legend()
    return figure


def _phase_and_energy(number: int, case: str, runs: Sequence[_Run]) -> Figure:
    """Draw figure 6, 8, 9 or 10: phase portrait and energy of a case."""
    figure = Figure(figsize=(11, 4.2))
    left, right = figure.subplots(1, 2)
    _draw_phase(left, PAPER_CASES[case], runs)
    _draw_energy(right, PAPER_CASES[case], runs)
    left.set_title(f"Figure {number}: case {case}, phase portrait")
    right.set_title("and energy")
    right.legend()
    return figure


def _worst_energy(correction: str, law: wall.Law) -> float:
    """Return the greatest error on H of RK4 during a contact and just after it, in % of what the contact loses."""
    v_in, m, _, mu, _ = law
    x, v = wall.path("rk4", correction, law, PAPER_RATE)
    v_out = float(contact.release_velocity(v_in, mu))
    inside = np.clip(v[:-1], v_out, v_in)
    during = float(np.abs(_energy_of(x[:-1], v[:-1], law) - contact.energy(inside, v_in, m, mu)).max())
    after = float(abs(0.5 * m * (v[-1] ** 2 - v_out**2)))
    return max(100 * max(during, after) / (0.5 * m * (v_in**2 - v_out**2)), LEAST_ERROR)


def _paper_11() -> Figure:
    figure = Figure(figsize=(11, 4.2))
    left, right = figure.subplots(1, 2, sharey=True)
    values = np.geomspace(1e-3, 1, 60)
    for ax, label, law in (
        (left, "mu (s/m), at v_in = 0.5 m/s", lambda value: (0.5, _M, _K, value, _A)),
        (right, "v_in (m/s), at mu = 0.5 s/m", lambda value: (value, _M, _K, _MU, _A)),
    ):
        for correction, colour in {
            "none": "#b0307a",
            "hybrid": "#3b75af",
            "release": "#d98a00",
            "both": "#000000",
        }.items():
            error = [_worst_energy(correction, law(float(value))) for value in values]
            ax.loglog(values, error, color=colour, label=f"RK4, {correction}")
        ax.set_xlabel(label)
    left.set_ylabel("greatest error on H, release included\n(% of the energy lost)")
    left.legend()
    figure.suptitle("Figure 11: energy with and without corrections")
    return figure


def _paper_12(found: dict[tuple[str, str], NDArray[np.float64]]) -> Figure:
    """Draw contacts in a row, which are too short to be seen: between them the mass flies up and falls back, with the
    speed it left with."""
    gravity, rebounds = 9.81, 40
    figure = Figure(figsize=(11, 4.2))
    ax = figure.subplots()
    for pair, label, style, colour in (
        (("exact", "none"), "exact", "-", "#bbbbbb"),
        (("verlet", "none"), "Verlet", "-", COLOURS["verlet"]),
        (("rk4", "none"), "RK4", "-", COLOURS["rk4"]),
        (("rk4", "both"), "RK4, corrected", "--", "#000000"),
    ):
        speed = found[pair][:rebounds, None]
        flight = 2 * speed / gravity
        t = flight * np.linspace(0, 1, 40)
        height = speed * t - gravity / 2 * t**2
        begin = np.concatenate([[0.0], np.cumsum(flight)[:-1]])[:, None]
        wide = 4 if label == "exact" else 1.0
        ax.plot((begin + t).ravel(), height.ravel() * 1e3, style, color=colour, linewidth=wide, label=label)
    ax.set(xlabel="time (s)", ylabel="height over the wall (mm)", title="Figure 12: rebounds under gravity, case 2")
    ax.legend()
    return figure
