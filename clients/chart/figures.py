"""What the study draws: error against cost, where methods fail, rebounds, and the reference paper's figures."""

import math
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from ...dsp import contact
from ...dsp.contact.sampled import CORRECTIONS, METHODS
from ...dsp.study import wall
from ...dsp.study.wall import PAPER_CASES, PAPER_RATE, Outcome

if TYPE_CHECKING:
    from .run import Failures, Row

Draw = Callable[[], Figure]
Sequences = dict[str, dict[tuple[str, str], NDArray[np.float64]]]

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
TITLES = {"am1": "AM1", "verlet": "Verlet", "heun": "Heun", "rk4": "RK4", "closed": "closed form"}
_LINES: dict[str, Literal["-", ":", "--"]] = {"none": "-", "hybrid": ":", "both": "--"}
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
_LEAST_ERROR = 1e-15  # %: no error is drawn below

_M, _K, _MU, _A = 1e-2, 1e9, 0.5, 1.5  # the paper's, unless it says otherwise


def save(draw: Draw, path: Path) -> None:
    """Draw a figure into path.svg and path.png."""
    with rc_context(_STYLE):
        figure = draw()
        figure.savefig(path.with_suffix(".svg"), metadata={"Date": None})
        figure.set_layout_engine("none")  # it is laid out
        figure.savefig(path.with_suffix(".png"), dpi=110)


def drawings(rows: "list[Row]", found: "Failures", sequences: Sequences) -> dict[str, Draw]:
    """Every figure by its name."""
    return {
        "error-cost": lambda: _error_cost(rows),
        "deviation-cost": lambda: _deviation_cost(rows),
        "hard": lambda: _against(rows, "hard", lambda row: row["samples"], "duration (samples)"),
        "damped": lambda: _against(rows, "damped", lambda row: row["mu"] * row["v_in"], "mu v_in"),
        "failures": lambda: _failures(found, _dissipation(found), "mu v_in"),
        "failures-exponent": lambda: _failures(found, found.laws[:, 4], "exponent a"),
        "failures-corrections": lambda: _all_failures(found),
        "accuracy": lambda: _accuracy(found),
        "rebounds": lambda: _rebounds(sequences),
        "paper-1": _paper_1,
        "paper-2": _paper_2,
        "paper-3": _paper_3,
        "paper-4": _paper_4,
        "paper-5": _paper_5,
        "paper-7": _paper_7,
        "paper-8": _paper_8,
        "paper-11": _paper_11,
        "paper-12": lambda: _paper_12(sequences["2"]),
    }


def _pick(rows: "Iterable[Row]", **wanted: Any) -> "list[Row]":
    return [row for row in rows if all(row[name] == value for name, value in wanted.items())]


def _error_percent(row: "Row") -> float:
    return max(abs(row["err_v_out"]), _LEAST_ERROR)


def _spectrum(row: "Row") -> float:
    return row["spectrum_dB"]


def _method_legend(closed: bool = True) -> list[Line2D]:
    names = [*METHODS, *(["closed"] if closed else [])]
    return [Line2D([], [], color=COLOURS[name], marker="o", markersize=4, label=TITLES[name]) for name in names]


def _correction_legend() -> list[Line2D]:
    says = {"none": "no correction", "hybrid": "x = x(v)", "both": "x = x(v) and v_out"}
    return [Line2D([], [], color="gray", linestyle=line, label=says[name]) for name, line in _LINES.items()]


def _error_cost(rows: "list[Row]") -> Figure:
    figure = Figure(figsize=(11, 7.2))
    axes = figure.subplots(2, len(PAPER_CASES), sharey="row", squeeze=False)
    for column, case in enumerate(PAPER_CASES):
        here = _pick(rows, case=case)
        above, below = axes[:, column]
        above.set(title=f"case {case}: {here[0]['samples']:.4g} samples of contact", yscale="log")
        for ax, error, closed in ((above, _error_percent, ("closed-release", "paper-release")), (below, _spectrum, ())):
            usable = [row for row in here if math.isfinite(error(row))]
            _front(ax, usable, error)
            for method in METHODS:
                for correction, line in _LINES.items():
                    some = _pick(usable, method=method, correction=correction)
                    cost = [row["ns_per_contact"] for row in some]
                    marker = "o" if correction == "none" else ""
                    ax.plot(cost, list(map(error, some)), line, color=COLOURS[method], marker=marker, markersize=2.5)
            for name, marker, label in (
                ("paper-release", "D", "the paper's v_out alone"),
                ("closed-release", "P", "exact v_out alone"),
                ("closed", "*", "closed form, whole pulse"),
            ):
                if name == "closed" or name in closed:
                    for row in _pick(here, method=name):
                        ax.plot(row["ns_per_contact"], error(row), marker, color="black", markersize=9, label=label)
            ax.set_xscale("log")
            ax.minorticks_off()
        below.set_xlabel("cost of a contact (ns)")
    axes[0, 0].set_ylabel("error of v_out (%)")
    axes[1, 0].set_ylabel(f"error of the force's spectrum,\n0 to {wall.SPECTRUM_TOP / 1e3:g} kHz (dB)")
    marks = axes[0, 0].get_legend_handles_labels()[0]
    front = Line2D([], [], color="#bbbbbb", linewidth=5, label="Pareto front")
    handles = [*_method_legend(closed=False), *_correction_legend(), *marks, front]
    figure.legend(handles=handles, loc="outside lower center", ncols=6)
    figure.suptitle("Error against cost; along a line the oversampling doubles")
    return figure


def _deviation_cost(rows: "list[Row]") -> Figure:
    """How far from the curves x(v) and H(v) the sampled methods run; the closed form is the curves."""
    figure = Figure(figsize=(11, 7.2))
    axes = figure.subplots(2, len(PAPER_CASES), sharey="row", squeeze=False)
    for column, case in enumerate(PAPER_CASES):
        here = _pick(rows, case=case)
        for ax, name in zip(axes[:, column], ("dev_x", "dev_H"), strict=True):
            for method in METHODS:
                for correction, line in _LINES.items():
                    some = _pick(here, method=method, correction=correction)
                    cost = [row["ns_per_contact"] for row in some]
                    deviation = [max(row[name], _LEAST_ERROR) for row in some]
                    marker = "o" if correction == "none" else ""
                    ax.plot(cost, deviation, line, color=COLOURS[method], marker=marker, markersize=2.5)
            ax.set(xscale="log", yscale="log")
            ax.minorticks_off()
        axes[0, column].set_title(f"case {case}: {here[0]['samples']:.4g} samples of contact")
        axes[1, column].set_xlabel("cost of a contact (ns)")
    axes[0, 0].set_ylabel("%dev(x)")
    axes[1, 0].set_ylabel("%dev(H)")
    figure.legend(handles=[*_method_legend(closed=False), *_correction_legend()], loc="outside lower center", ncols=7)
    figure.suptitle("Deviation from x(v) and H(v) against cost; along a line the oversampling doubles")
    return figure


def _front(ax: Axes, rows: "list[Row]", error: "Callable[[Row], float]") -> None:
    cost = np.array([row["ns_per_contact"] for row in rows])
    found = np.array([error(row) for row in rows])
    best = np.flatnonzero(wall.pareto(cost, found))
    best = best[np.argsort(cost[best])]
    ends = np.append(cost[best], cost.max() * 1.5)
    ax.step(ends, np.append(found[best], found[best][-1]), where="post", color="#bbbbbb", linewidth=5, zorder=0)


def _against(rows: "list[Row]", case: str, x: "Callable[[Row], float]", label: str) -> Figure:
    """Errors and cost without oversampling over one of the law's parameters; crosses: failed."""
    figure = Figure(figsize=(12, 4.2))
    left, middle, right = figure.subplots(1, 3)
    some = [row for row in _pick(rows, case=case) if row["oversampling"] == 1]
    quantities = ((left, _error_percent), (middle, _spectrum), (right, lambda row: row["ns_per_contact"]))
    for ax, quantity in quantities:
        for method in METHODS:
            for correction, line in (("none", "-"), ("both", "--")):
                mine = _pick(some, method=method, correction=correction)
                ax.plot(list(map(x, mine)), list(map(quantity, mine)), line, color=COLOURS[method])
                failed = [row for row in mine if row["outcome"] != Outcome.SOUND.name]
                ax.plot(list(map(x, failed)), list(map(quantity, failed)), "x", color=COLOURS[method], markersize=5)
        for name in ("closed", *(("closed-release",) if ax is right else ())):
            mine = _pick(some, method=name)
            style = "-o" if name == "closed" else ":o"
            ax.plot(list(map(x, mine)), list(map(quantity, mine)), style, color="black", markersize=3)
        ax.set(xscale="log", xlabel=label)
    left.set(yscale="log", ylabel="error of v_out (%)", ylim=(_LEAST_ERROR / 3, 1e6))
    middle.set(ylabel="error of the force's spectrum (dB)", ylim=(-150, 40))
    right.set(yscale="log", ylabel="cost of a contact (ns)")
    styles = [
        Line2D([], [], color="gray", label="no correction"),
        Line2D([], [], color="gray", linestyle="--", label="x = x(v) and v_out"),
        Line2D([], [], color="gray", linestyle="", marker="x", label="failed"),
        Line2D([], [], color="black", linestyle=":", marker="o", markersize=3, label="closed form, v_out alone"),
    ]
    figure.legend(handles=[*_method_legend(), *styles], loc="outside lower center", ncols=9)
    return figure


def _dissipation(found: "Failures") -> NDArray[np.float64]:
    return found.laws[:, 0] * found.laws[:, 3]


class _Bins:
    """Cells over duration (samples) and one other quantity, in the logarithm of both or (a) of duration only."""

    def __init__(self, found: "Failures", y: NDArray[np.float64]) -> None:
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
    """The colours of what goes wrong, mixed with white by its share."""
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
    figure.suptitle(f"{points} contacts over all parameters: what goes wrong, by its share")


def _failures(found: "Failures", y: NDArray[np.float64], label: str) -> Figure:
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


def _failure_shares(ax: Axes, found: "Failures") -> None:
    edges = np.geomspace(0.003, found.samples.max(), 19)
    place = np.digitize(found.samples, edges)
    for (method, correction), outcome in found.outcomes.items():
        if correction in ("none", "both"):
            share = [100 * np.mean(outcome[place == i] != Outcome.SOUND) for i in range(1, len(edges))]
            middles = np.sqrt(edges[1:] * edges[:-1])
            ax.plot(middles, share, _LINES[correction], color=COLOURS[method])
    ax.set_title("% that fail (dashed: corrected)", fontsize=9)
    ax.legend(
        handles=_method_legend(),
        fontsize=6,
        loc="lower left",
        bbox_to_anchor=(0, 0.04),
        handlelength=1,
        markerscale=0.4,
    )


def _all_failures(found: "Failures") -> Figure:
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


def _accuracy(found: "Failures") -> Figure:
    """Mean order of magnitude of the error of v_out; failures count as they come, 1000 % at most."""
    figure = Figure(figsize=(12, 3.2))
    axes = figure.subplots(1, len(METHODS) + 1, sharex=True, sharey=True)
    bins = _Bins(found, _dissipation(found))
    number = bins.total(np.ones(len(found.laws)))
    for ax, method in zip(axes, (*METHODS, "closed"), strict=True):
        error = np.nan_to_num(np.abs(found.errors[method, "none"]), nan=np.inf)
        magnitude = np.log10(np.clip(error, _LEAST_ERROR, 1e3))
        mean = np.where(number > 0, bins.total(magnitude) / np.maximum(number, 1), np.nan)
        mesh = bins.show(ax, mean, cmap="RdYlGn_r", vmin=-6, vmax=3)
        ax.set(title=TITLES[method], xlabel="duration (samples)")
    axes[0].set_ylabel("mu v_in")
    bar = figure.colorbar(mesh, ax=axes, extend="min", label="error of v_out (%)", ticks=range(-6, 4, 3))
    bar.ax.set_yticklabels([f"$10^{{{n}}}$" for n in range(-6, 4, 3)])
    return figure


def _rebounds(sequences: Sequences) -> Figure:
    figure = Figure(figsize=(11, 4.6))
    for ax, (case, found) in zip(figure.subplots(1, len(sequences), sharey=True), sequences.items(), strict=True):
        exact = found["exact", "none"]
        places = np.unique(np.geomspace(1, len(exact), 100).astype(int)) - 1
        for method in METHODS:
            for correction, line in {**_LINES, "paper-both": "-."}.items():
                speed = found[method, correction]
                reached = places[places < len(speed)]
                error = 100 * np.abs((speed[reached] / exact[reached]) ** 2 - 1)
                ax.plot(reached + 1, np.maximum(error, 1e-14), line, color=COLOURS[method])
        ax.set(xscale="log", yscale="log", xlabel="rebounds", title=f"case {case}")
    ax.figure.axes[0].set_ylabel("accumulated error on H (% of what is left)")
    paper = Line2D([], [], color="gray", linestyle="-.", label="x = x(v) and the paper's v^_out")
    handles = [*_method_legend(closed=False), *_correction_legend(), paper]
    figure.legend(handles=handles, loc="outside lower center", ncols=8)
    return figure


def _velocities(v_in: float, mu: float) -> NDArray[np.float64]:
    """From v_in to v_out, closer to each other near both ends, where x(v) is steep."""
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
    return 0.5 * m * v**2 + contact.potential_energy(x, k, a)


def _draw_energy(ax: Axes, law: wall.Law) -> None:
    v_in, m, _, mu, _ = law
    v = _velocities(v_in, mu)
    ax.plot(v, contact.energy(v, v_in, m, mu) * 1e3, color="black", label="exact")
    for method in METHODS:
        x, v = wall.path(method, "none", law, PAPER_RATE)
        ax.plot(v, _energy_of(x, v, law) * 1e3, "-o", color=COLOURS[method], markersize=3, linewidth=0.6)
        ax.lines[-1].set_label(TITLES[method])
    ax.invert_xaxis()
    ax.set(xlabel="v (m/s)", ylabel="H (mJ)")


def _paper_7() -> Figure:
    figure = Figure(figsize=(6, 4.2))
    ax = figure.subplots()
    _draw_energy(ax, PAPER_CASES["1"])
    ax.set_title("Figure 7: case 1, energy")
    ax.legend()
    return figure


def _paper_8() -> Figure:
    law = PAPER_CASES["2"]
    v_in, m, k, mu, a = law
    figure = Figure(figsize=(11, 4.2))
    left, right = figure.subplots(1, 2)
    v = _velocities(v_in, mu)
    left.plot(contact.compression(v, v_in, m, k, mu, a) * 1e6, v, color="black")
    for method in METHODS:
        x, v = wall.path(method, "none", law, PAPER_RATE)
        left.plot(x * 1e6, v, "-o", color=COLOURS[method], markersize=3, linewidth=0.6)
    left.set(xlabel="compression x (um)", ylabel="v (m/s)", title="Figure 8: case 2, phase portrait")
    _draw_energy(right, law)
    right.set_title("and energy")
    right.legend()
    return figure


def _worst_energy(correction: str, law: wall.Law) -> float:
    """Greatest error on H of RK4 during a contact and just after it, in % of what the contact loses."""
    v_in, m, _, mu, _ = law
    x, v = wall.path("rk4", correction, law, PAPER_RATE)
    v_out = float(contact.release_velocity(v_in, mu))
    inside = np.clip(v[:-1], v_out, v_in)
    during = np.abs(_energy_of(x[:-1], v[:-1], law) - contact.energy(inside, v_in, m, mu)).max()
    after = abs(0.5 * m * (v[-1] ** 2 - v_out**2))
    return max(100 * max(during, after) / (0.5 * m * (v_in**2 - v_out**2)), _LEAST_ERROR)


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
    """Contacts are too short to be seen: between them the mass flies up and falls back, with the speed it left with."""
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
