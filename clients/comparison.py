"""Two sounds beside each other: figures, a picture, and a page with players."""

from __future__ import annotations

import base64
import io
import json
import math
from collections.abc import Sequence
from html import escape
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import soundfile
from numpy.typing import NDArray

from ..dsp.errors import CaromError
from ..dsp.fitting.distance import Distance, distance
from ..dsp.fitting.errors import RecordingError
from ..dsp.fitting.hits import check
from ..dsp.fitting.kinds import Excess, excess
from .plot import PlotError, require_matplotlib, require_picture
from .recordings import Recording, read
from .recordings import found as files_of

_LOWEST = 40.0  # Hz
_DYNAMIC = 80.0  # dB of a spectrogram
_WINDOW = 2048
_COLUMNS, _ROWS = 450, 200  # of a spectrogram

_STYLE = """
:root { color-scheme: light dark; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 64rem; margin: 2rem auto; padding: 0 1rem; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; margin: 0.5rem 1rem 0.5rem 0; }
th, td { padding: 0.1rem 0.8rem; text-align: right; border-bottom: 1px solid #8884; }
figure { margin: 1rem 0; }
img { max-width: 100%; height: auto; background: white; }
.players { display: flex; flex-wrap: wrap; gap: 1rem 2rem; }
.tables { display: flex; flex-wrap: wrap; align-items: flex-start; }
""".strip()

Compared = tuple[Distance, tuple[str, str]]
"""A distance, and the names of A and B."""


class PageError(CaromError, RuntimeError):
    """The page cannot be made; the text says why."""


def compare(a: Path, b: Path) -> tuple[Distance, list[str]]:
    """Return the distance of two sound files, and notes on how they were read.

    RecordingError or OSError where one cannot be read or holds no sound.
    """
    first, second = _read(a), _read(b)
    return distance(first.samples, second.samples, first.rate, second.rate), [*first.notes, *second.notes]


def beside(a: Path, b: Path, kind: Path) -> Excess:
    """Return how far B is from A and the other recordings of its kind in a folder, beside how far these are apart.

    Files of the same bytes are one recording. RecordingError or OSError where one cannot be read, or where there is
    none but A.
    """
    known = {a.read_bytes(): a, **{each.read_bytes(): each for each in files_of([kind])}}
    others = [each for data, each in known.items() if data != a.read_bytes()]
    if not others or not kind.is_dir():
        raise RecordingError(f"{kind}: expected a folder with other recordings of the kind of {a.name}")
    sound, *recordings = ((each.samples, each.rate) for each in map(_read, (b, a, *others)))
    return excess(sound, recordings)


def _read(path: Path) -> Recording:
    recording = read(path, mixed=True)
    try:
        check(recording.samples, recording.rate)
    except RecordingError as error:
        if "clipped" not in str(error):
            raise RecordingError(f"{path}: {error}") from None
    return recording


def kind_table(found: Excess) -> str:
    """Return what was found beside recordings of one kind as text."""
    return "\n".join(
        (
            f"beside {found.recordings} recordings    B to them  to each other",
            f"third octaves             {found.gap:6.1f} dB      {found.real_gap:6.1f} dB",
            f"T60                  {found.decay:6.2f} octaves {found.real_decay:6.2f} octaves",
        )
    )


def table(found: Distance) -> str:
    """Return all figures as text."""
    lines = [
        f"residual               {found.residual:7.1f} dB",
        f"log-spectral distance  {found.spectral:7.2f} dB",
        f"gain, shift of B       {found.gain:7.1f} dB, {1e3 * found.shift:.2f} ms",
        "",
        "third octave      A      B  B - A",
    ]
    lines += [f"{middle:9.0f} Hz {a:6.1f} {b:6.1f} {b - a:+6.1f}" for middle, a, b in _heard(found)]
    lines += ["", "octave        T60 A   T60 B"]
    lines += [f"{middle:7.0f} Hz {_seconds(a)} {_seconds(b)}" for middle, a, b in found.decays]
    return "\n".join(lines)


_ABOVE, _BELOW = 2_000.0, 1_000.0
"""Hz: the bands whose levels say which sound is brighter."""
_ALIKE, _ALIKE_LENGTH = 1.0, 1.1
"""dB, and a ratio of T60, up to which two sounds are alike to a player."""


def verdict(found: Distance) -> str:
    """Return in a sentence how B sounds beside A: brighter or duller, longer or shorter."""
    heard = np.array(_heard(found))
    words = []
    if len(heard) and (heard[:, 0] > _ABOVE).any() and (heard[:, 0] < _BELOW).any():
        differ = heard[:, 2] - heard[:, 1]
        tilt = float(differ[heard[:, 0] > _ABOVE].mean() - differ[heard[:, 0] < _BELOW].mean())
        if abs(tilt) > _ALIKE:
            words.append(f"is {abs(tilt):.0f} dB {'brighter' if tilt > 0 else 'duller'}")
    known = found.decays[np.isfinite(found.decays).all(axis=1)]
    if len(known):
        ratio = float(np.exp(np.median(np.log(known[:, 2] / known[:, 1]))))
        if max(ratio, 1.0 / ratio) > _ALIKE_LENGTH:
            words.append(f"rings {ratio:.1f} times as long")
    return f"B {' and '.join(words or ['is as bright as A', 'rings as long'])}."


def as_json(found: Distance, kind: Excess | None = None) -> str:
    """Return all figures as JSON; a decay that there is none of is null. kind: what was found beside recordings."""
    data: dict[str, Any] = {
        "residual_db": found.residual,
        "log_spectral_distance_db": found.spectral,
        "gain_db": found.gain,
        "shift_s": found.shift,
        "third_octaves": [dict(zip(("hz", "a_db", "b_db"), row, strict=True)) for row in found.thirds.tolist()],
        "decays": [{"hz": middle, "a_s": _known(a), "b_s": _known(b)} for middle, a, b in found.decays.tolist()],
    }
    if kind:
        data["kind"] = {
            "recordings": kind.recordings,
            "third_octaves_db": kind.gap, "third_octaves_real_db": kind.real_gap,
            "decays_octaves": _known(kind.decay), "decays_real_octaves": _known(kind.real_decay),
        }  # fmt: skip
    return json.dumps(data, indent=2)


def _known(value: float) -> float | None:
    return None if math.isnan(value) else value


def draw(found: Distance, picture: Path | io.BytesIO, names: tuple[str, str]) -> None:
    """Draw both spectrograms, the third octaves and the decays. PlotError if matplotlib or the folder is missing."""
    if isinstance(picture, Path):
        require_picture(picture)
    else:
        require_matplotlib()
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 7))
    axes = figure.subplots(2, 2, height_ratios=(1.5, 1))
    figure.subplots_adjust(0.06, 0.07, 0.98, 0.96, wspace=0.15, hspace=0.25)
    grids = [_spectrogram(samples, found.rate) for samples in (found.a, found.b)]
    highest = max(level.max() for _, _, level in grids)
    for ax, name, (time, frequency, level) in zip(axes[0], names, grids, strict=True):
        image = ax.pcolormesh(time, frequency, level - highest, vmin=-_DYNAMIC, vmax=0, cmap="magma", rasterized=True)
        ax.set(title=name, yscale="log", ylim=(_LOWEST, found.rate / 2), xlabel="time (s)", ylabel="frequency (Hz)")
    figure.colorbar(image, ax=axes[0], label="dB")
    colours = ("#204060", "#d06020")
    for column, (what, rows) in enumerate((("third octaves (dB)", np.array(_heard(found))), ("T60 (s)", found.decays))):
        ax = axes[1, column]
        for number, (name, colour) in enumerate(zip(names, colours, strict=True), 1):
            ax.plot(rows[:, 0], rows[:, number], "o-", color=colour, label=name, markersize=3, linewidth=1)
        ax.set(xscale="log", xlabel="frequency (Hz)", ylabel=what)
        ax.grid(alpha=0.3)
        ax.legend()
    axes[1, 1].set(yscale="log")
    figure.savefig(picture, dpi=110, format=picture.suffix[1:].lower() if isinstance(picture, Path) else "png")


def require_page(page: Path) -> None:
    """Raise PageError if a page cannot have this name or folder."""
    if page.suffix.lower() not in (".html", ".htm"):
        raise PageError(f"{page}: expected a name that ends in .html")
    if not page.parent.is_dir():
        raise PageError(f"{page}: there is no folder {page.parent}")


def write_page(page: Path, title: str, compared: Sequence[Compared], lines: Sequence[str] = (), more: str = "") -> Path:
    """Write a page that holds players, figures and pictures of each pair in itself, and more HTML after all lines.

    Without matplotlib it has no pictures. PageError if the page cannot be there.
    """
    require_page(page)
    parts = [
        "<!DOCTYPE html>",
        '<html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{escape(title)}</title><style>{_STYLE}</style></head><body>",
        f"<h1>{escape(title)}</h1>",
        *(f"<p>{escape(line)}</p>" for line in lines),
        more,
        *(_section(*each) for each in compared),
        "</body></html>",
    ]
    page.write_text("\n".join(parts) + "\n", encoding="utf-8")
    return page


def _section(found: Distance, names: tuple[str, str]) -> str:
    peak = max(float(np.abs(found.a).max()), float(np.abs(found.b).max()), 1e-9)
    players = [
        f"<div><p>{mark}: {escape(name)}</p>{player(samples / peak, found.rate)}</div>"
        for mark, name, samples in zip("AB", names, (found.a, found.b), strict=True)
    ]
    figures = (
        f"residual {found.residual:.1f} dB, log-spectral distance {found.spectral:.2f} dB; B was changed by "
        f"{found.gain:.1f} dB and {1e3 * found.shift:.2f} ms"
    )
    thirds = rows(
        ("Hz", "A (dB)", "B (dB)"), [[f"{row[0]:.0f}", *(f"{x:.1f}" for x in row[1:])] for row in _heard(found)]
    )
    decays = rows(
        ("Hz", "T60 A (s)", "T60 B (s)"), [[f"{row[0]:.0f}", *map(_seconds, row[1:])] for row in found.decays]
    )
    return (
        f"<h2>{escape(names[0])}</h2><p>{escape(names[1])}: {figures}</p>"
        f'<div class="players">{"".join(players)}</div>{_figure(found, names)}'
        f'<details><summary>Third octaves and decays</summary><div class="tables">{thirds}{decays}</div></details>'
    )


def _figure(found: Distance, names: tuple[str, str]) -> str:
    memory = io.BytesIO()
    try:
        draw(found, memory, names)
    except PlotError as error:
        return f"<p>{escape(str(error))}</p>"
    data = base64.b64encode(memory.getvalue()).decode()
    return f'<figure><img alt="Spectrograms, third octaves and decays" src="data:image/png;base64,{data}"></figure>'


def player(samples: NDArray[np.float64], rate: float) -> str:
    """Return a player that holds a sound, as HTML."""
    memory = io.BytesIO()
    soundfile.write(memory, samples, int(rate), format="FLAC", subtype="PCM_16")
    data = base64.b64encode(memory.getvalue()).decode()
    return f'<audio controls src="data:audio/flac;base64,{data}"></audio>'


def rows(head: Sequence[str], body: Sequence[Sequence[str]]) -> str:
    """Return a table, as HTML."""

    def row(cells: Sequence[str], tag: str) -> str:
        return "<tr>" + "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells) + "</tr>"

    return f"<table>{row(head, 'th')}{''.join(row(each, 'td') for each in body)}</table>"


def _heard(found: Distance) -> list[list[float]]:
    """Return the third octaves that are less than 80 dB below the loudest in one of the two."""
    rows: list[list[float]] = found.thirds[found.thirds[:, 1:].max(axis=1) > -_DYNAMIC].tolist()
    return rows


def _seconds(value: float) -> str:
    return "      -" if math.isnan(value) else f"{value:7.3f}"


def _spectrogram(samples: NDArray[np.float64], rate: float) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return times (s), frequencies (Hz), alike far apart for the ear, and levels (dB): of each the highest near it."""
    padded = np.pad(samples, _WINDOW // 2)
    hop = max(_WINDOW // 16, len(samples) // _COLUMNS)
    frames = np.lib.stride_tricks.sliding_window_view(padded, _WINDOW)[::hop]
    power = np.abs(np.fft.rfft(frames * np.hanning(_WINDOW))).T ** 2
    edges = np.geomspace(_LOWEST, rate / 2, _ROWS + 1)
    lines = np.clip(np.round(edges * _WINDOW / rate).astype(int), 0, len(power) - 1)
    highest = np.array([power[low : max(high, low + 1)].max(axis=0) for low, high in pairwise(lines)])
    return np.arange(len(frames)) * hop / rate, np.sqrt(edges[:-1] * edges[1:]), 10 * np.log10(highest + 1e-24)
