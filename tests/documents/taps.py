"""The taps that the engine reads sounds and pulses by, fitted by least squares and written into its sources.

    python -m tests.documents.taps

They are kept there, as a fit takes longer than all else of a start, and rounds otherwise on another machine.
"""

import re
from pathlib import Path

import numpy as np

from carom.dsp.space.delay import DEGREE, TAPS
from carom.dsp.swarm.grid import EDGE, HALF, bump_spectrum

ROOT = Path(__file__).parents[2]
_HIGHEST = 2.0 * np.pi * 16_500.0 / 48_000.0  # of a delay, in radians a sample


def delay_taps() -> np.ndarray:
    """Return polynomials of each tap of a pure delay over the fraction less a half, (DEGREE + 1, TAPS)."""
    omega, fraction = np.linspace(0.0, _HIGHEST, 160), np.linspace(0.0, 1.0, 61)
    weight = (1.0 + 6.0 * np.exp(-((omega / 0.8) ** 2)))[None, :, None]
    turned = np.exp(1j * omega[None, :, None] * (np.arange(TAPS) - (TAPS // 2 - 1) - fraction[:, None, None]))
    powers = (fraction - 0.5)[:, None] ** np.arange(DEGREE + 1)
    columns = (weight * turned)[:, :, None, :] * powers[:, None, :, None]
    matrix = columns.reshape(-1, (DEGREE + 1) * TAPS)
    wanted = np.broadcast_to(weight[..., 0], turned.shape[:2]).reshape(-1)
    both = np.concatenate([matrix.real, matrix.imag])
    solved = np.linalg.lstsq(both, np.concatenate([wanted, np.zeros_like(wanted)]), rcond=None)[0]
    return np.ascontiguousarray(solved.reshape(DEGREE + 1, TAPS))


def filter_taps() -> np.ndarray:
    """Return the filter that takes a pulse's bump out, from its middle on: HALF + 1 taps."""
    frequency = EDGE * (np.arange(1000) + 0.5) / 1000
    spectrum = bump_spectrum(frequency)
    basis = np.cos(2.0 * np.pi * np.outer(frequency, np.arange(HALF + 1))) * np.where(np.arange(HALF + 1) > 0, 2.0, 1.0)
    taps: np.ndarray = np.linalg.lstsq(basis * spectrum[:, None], np.ones(1000), rcond=None)[0]
    return taps


def _row(taps: np.ndarray, indent: str) -> str:
    """Return numbers as lines of Python."""
    words, lines = [f"{tap!r}," for tap in taps.tolist()], [indent]
    for word in words:
        if len(lines[-1]) + len(word) > 118:
            lines.append(indent)
        lines[-1] += word if lines[-1] == indent else f" {word}"
    return "\n".join(lines)


def _write(path: str, name: str, rows: str) -> None:
    """Put rows in the place of those of a tuple in a source."""
    file = ROOT / path
    text, count = re.subn(rf"({name} = \(\n).*?(\n\)  # fmt: skip)", rf"\1{rows}\2", file.read_text(), flags=re.DOTALL)
    assert count == 1, f"{path} has no {name}"
    file.write_text(text)


def main() -> None:
    rows = "\n".join(f"    (\n{_row(row, ' ' * 8)}\n    )," for row in delay_taps())
    _write("dsp/space/delay.py", "_FITTED", rows)
    _write("dsp/swarm/grid.py", "_FROM_MIDDLE", _row(filter_taps(), " " * 4))


if __name__ == "__main__":
    main()
