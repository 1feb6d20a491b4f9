"""The report of a fit: a page on which the recording and the fitted object are heard and seen beside each other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..dsp.fitting.blow import earliest
from ..dsp.fitting.distance import distance
from ..dsp.fitting.strongest import Strongest, strongest
from .comparison import Compared, rows, write_page
from .fitting import Made


def compared(made: Made) -> list[Compared]:
    """Compare each recording with its fit, and the first with the default strike as the engine plays it."""
    fit, early = made.fit, earliest(made.fit.rate)
    pairs: list[Compared] = []
    for number, take in enumerate(made.takes):
        recorded, name = fit.takes[number][early:], take.recording.path.name
        if number == 0:
            pairs.append((distance(recorded, made.sound, fit.rate), (name, "the preset, played")))
        pairs.append((distance(recorded, fit.sound(number)[early:], fit.rate), (name, "modes and noise, fitted")))
    return pairs


def write_report(made: Made, name: str, out: Path) -> Path:
    """Write the page NAME.html into a folder; return it."""
    fit = made.fit
    left = ", ".join(f"{each:.1f}" for each in fit.residual)
    blows = ", ".join(f"{1e3 * each.duration:.2g}" for each in fit.blows)
    lines = [
        f"{len(fit.frequency)} modes, which leave {left} dB of the recording; {len(fit.noise.rms)} bands of noise; "
        f"blows of {blows} ms.",
        "Presets have modes of one phase or the opposite one, so their waves differ from the recording's where their "
        "spectra agree: a played preset is judged by its log-spectral distance.",
        *made.notes,
    ]
    table = _table(strongest(fit))
    return write_page(out / f"{name}.html", f"{name}: recording and preset", compared(made), lines, table)


def _table(modes: Sequence[Strongest]) -> str:
    """Return the strongest modes, as HTML."""
    loudest = max(each.amplitude for each in modes)
    figures = [
        [
            f"{each.frequency:.1f}",
            f"{'≥ ' * each.at_least}{each.t60:.3g}",
            f"{100 * each.spread:.1g} %",
            f"{20 * np.log10(each.amplitude / loudest):.1f}",
            f"{100 * each.share:.2g} %",
        ]
        for each in modes
    ]
    head = ("Hz", "T60 (s)", "within", "at the onset (dB)", "of the energy")
    return f"<h2>The strongest modes</h2>{rows(head, figures)}"
