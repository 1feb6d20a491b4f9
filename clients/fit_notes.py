"""The notes on a fit: what its recordings leave open."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..dsp.fitting.fit import Fit
from ..dsp.fitting.hits import Hit
from ..presets.fitted import MASS

_LOUD_NOISE = -40.0  # dB of a recording's peak: fainter noise hides nothing that counts
_MOST_NAMED = 8
_HEARD = 0.1  # dB


def notes(found: Fit, hits: Sequence[Hit]) -> list[str]:
    """Return notes on steady tones, on decays that are longer than the recordings, and on noise."""
    said = []
    if found.tones.size:
        said.append(f"left out, as they do not decay with the strike: {_named(found.tones)}")
    if found.at_least.any():
        longest = max(len(hit.samples) / hit.rate for hit in hits)
        t60 = np.log(1000) / found.decay[found.at_least].max()
        said.append(
            f"{_named(found.frequency[found.at_least])}: in {longest:.2g} s this hardly falls; its T60 is taken to be "
            f"{t60:.2g} s and may be longer: expected a longer recording"
        )
    noisiest = max(hits, key=lambda hit: hit.floor / hit.peak)
    level = 20 * np.log10(noisiest.floor / noisiest.peak + 1e-30)
    if level > _LOUD_NOISE:
        least, most = 100 * found.spread.min(), 100 * found.spread.max()
        said.append(
            f"noise at {level:.0f} dB of the peak hides faint modes; the decays of the others are known within "
            f"{least:.1g} to {most:.0f} %: expected noise below {_LOUD_NOISE:.0f} dB"
        )
    return said


def too_loud(louder: float, mass: float | None, velocity: float) -> list[str]:
    """Return a note if a strike in pascals is so much quieter (dB) than was given."""
    if louder < _HEARD:
        return []
    return [
        f"no mode of a body of {mass or MASS:g} kg can be so loud after a strike at {velocity:g} m/s: `level` adds "
        f"{louder:.1f} dB, which calibrated sound lacks: expected a higher --velocity, or a heavier striker"
    ]


def too_peaked(quieter: float) -> list[str]:
    """Return a note if the default strike is so much quieter (dB) than the recording, as its peaks are higher."""
    if quieter < _HEARD:
        return []
    return [
        f"the default strike is {quieter:.1f} dB quieter than the recording: equally loud, its peaks would be above "
        f"full scale"
    ]


def _named(frequencies: np.ndarray) -> str:
    names = ", ".join(f"{each:.0f}" for each in frequencies[:_MOST_NAMED])
    return f"{names} Hz" + (f" and {len(frequencies) - _MOST_NAMED} more" if len(frequencies) > _MOST_NAMED else "")
