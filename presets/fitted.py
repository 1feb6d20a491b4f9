"""Presets of bodies that were fitted to recordings: the text of their files."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..dsp.bodies.air import IMPEDANCE
from ..dsp.bodies.listed import listed
from ..dsp.fitting.fit import Fit
from ..dsp.fitting.strikers import Striker

MASS = 1.0
"""kg: of a body of which nothing is known."""

_YIELDS = 4.0  # over the body's mass: the sum of all inverse modal masses, as of one mode at a free bar's end
_FAINTEST = -90.0  # dB: a band that is as faint against the loudest mode is not heard
_MOST_IN_BAND, _LEAST_IN_BAND = 16, 3  # modes
_DENSE = 0.5  # modes of a band, over its width times its decay time
_SHORTEST, _LONGEST = 1e-3, 200.0  # s: decay times
_HIGHEST = 20_000.0  # Hz
_HEAVIEST = 1000.0  # Pa per m/s: the highest weight that a preset may have

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Facts:
    """Facts of a fit for a preset, beside its figures.

    source, licence: of the recordings. striker: the preset of the default striker; velocity in m/s. position: where it
    strikes. positions: of the takes, where they differ. mass: of the body, in kg. measured: comments.
    """

    description: str
    source: str
    licence: str
    striker: str
    velocity: float
    position: float = 0.0
    positions: tuple[float, ...] = ()
    mass: float = MASS
    measured: Sequence[str] = field(default=())


def object_text(fit: Fit, facts: Facts, louder: float = 0.0) -> str:
    """Write the file of an object of listed modes and bands of noise, so much louder (dB) than the loudest possible.

    All modes together yield to a force as a body of the mass does at its end. Their weights stand to each other as the
    modes do in the recording. Where no mode radiates more than it loses they are as loud as is requested; the key
    `level` adds what is missing.
    """
    geometry = geometry_of(fit, facts, min(louder, 0.0))
    head = {
        "description": facts.description,
        "source": facts.source,
        "licence": facts.licence,
        "shape": "listed",
    }
    lines = [*(f"# {line}" for line in facts.measured), *_keys(head), f"level = {max(louder, 0.0):.1f}  # dB", ""]
    units = {"frequency": "Hz", "t60": "s", "modal_mass": "kg", "mass": "kg", "weight": "Pa per m/s"}
    lines += ["[geometry]", *_keys(geometry, units), ""]
    if noise := noise_of(fit, geometry):
        lines += ["[noise]", *_keys(noise, {"edges": "Hz", "t60": "s", "level": "dB"}), ""]
    strike = {"striker": facts.striker, "velocity": facts.velocity, "position": facts.position}
    lines += ["[strike]", *_keys(strike, {"velocity": "m/s"})]
    return "\n".join(lines) + "\n"


def geometry_of(fit: Fit, facts: Facts, louder: float = 0.0) -> dict[str, object]:
    """Return the keys of the shape `listed`, so much louder (dB) than the loudest possible."""
    keep = (fit.frequency <= _HIGHEST) & (np.abs(fit.gains).max(axis=0) > 0)
    gains, decay = fit.gains[:, keep], fit.decay[keep]
    rows = _by_position(gains, facts.positions)
    highest = np.abs(rows).max(axis=0)
    first = np.where(rows[np.argmax(np.abs(rows), axis=0), np.arange(rows.shape[1])] < 0, -1.0, 1.0)
    modal_mass = facts.mass * rows.shape[1] / _YIELDS
    # A mode radiates 4 pi G^2/(rho c), G = weight/sqrt(modal mass), and loses 2 sigma.
    most = np.sqrt(2 * decay * IMPEDANCE * modal_mass / (4 * np.pi))
    loudest = min(np.min(most / highest), _HEAVIEST / highest.max())
    weight = first * highest * loudest * 10 ** (louder / 20)
    geometry: dict[str, object] = {
        "frequency": _rounded(fit.frequency[keep], 7),
        "t60": _rounded(np.clip(np.log(1000) / decay, _SHORTEST, _LONGEST), 4),
        "modal_mass": _rounded(modal_mass, 4),
        "mass": facts.mass,
        "weight": _rounded(weight, 4),
    }
    if facts.positions:
        geometry["positions"] = sorted(set(facts.positions))
        geometry["gains"] = [_rounded(row, 3) for row in (rows / (first * highest)).T]
    return geometry


def noise_of(fit: Fit, geometry: Mapping[str, object]) -> dict[str, object]:
    """Return the keys of the section [noise]; none where no band is heard."""
    own = listed(**geometry, top=_HIGHEST)  # type: ignore[arg-type]
    loudest = float(np.sqrt(np.mean(own.strike**2, axis=0) * np.mean(own.pressure**2, axis=0)).max())
    heaviest = np.argmax(np.abs(fit.gains).max(axis=0))
    loudness = np.abs(np.atleast_1d(np.asarray(geometry["weight"]))).max() / float(str(geometry["modal_mass"]))
    scale = loudness / np.abs(fit.gains).max(axis=0)[heaviest]
    level = 20 * np.log10(np.sqrt(2) * fit.noise.rms * scale / loudest + 1e-30)
    heard = np.flatnonzero(level > _FAINTEST)
    if not heard.size:
        return {}
    bands = slice(heard[0], heard[-1] + 1)
    edges = fit.noise.edges[heard[0] : heard[-1] + 2]
    t60 = np.clip(np.log(1000) / fit.noise.decay[bands], _SHORTEST, _LONGEST)
    count = np.clip(np.ceil(_DENSE * np.diff(edges) * t60), _LEAST_IN_BAND, _MOST_IN_BAND)
    return {
        "edges": _rounded(edges, 5),
        "t60": _rounded(t60, 3),
        "level": [round(float(each), 1) for each in np.clip(level[bands], -120, 60)],
        "modes": [int(each) for each in np.where(level[bands] > _FAINTEST, count, 1)],
    }


def striker_text(striker: Striker, facts: Facts) -> str:
    """Write the file of a striker."""
    head = {"description": facts.description, "source": facts.source, "licence": facts.licence}
    law = {
        "mass": striker.mass,
        "stiffness": _rounded(striker.stiffness, 5),
        "dissipation": striker.dissipation,
        "exponent": striker.exponent,
    }
    units = {"mass": "kg", "stiffness": "N/m^exponent", "dissipation": "s/m"}
    contact = f"# contact with a rigid wall at {striker.velocity:g} m/s: {1e3 * striker.duration:.2g} ms"
    return "\n".join([*_keys(head), "", *_keys(law, units), contact]) + "\n"


def _by_position(gains: Array, positions: Sequence[float]) -> Array:
    """Return the gains (P, n) at each position, ascending: of takes at the same one, the rms with the first one's
    sign."""
    if not positions:
        return _joined(gains)[None]
    at = np.asarray(positions)
    return np.array([_joined(gains[at == each]) for each in sorted(set(positions))])


def _joined(gains: Array) -> Array:
    joined: Array = np.where(gains[0] < 0, -1.0, 1.0) * np.sqrt(np.mean(gains**2, axis=0))
    return joined


def _rounded(figures: Array | float, digits: int) -> list[float] | float:
    """Round numbers to some significant digits, as a float or a list."""
    rounded = [float(f"{each:.{digits}g}") for each in np.ravel(figures)]
    return rounded if np.ndim(figures) else rounded[0]


def _keys(table: Mapping[str, object], units: Mapping[str, str] | None = None) -> list[str]:
    return [
        f"{key} = {_toml(value)}" + (f"  # {units[key]}" if units and key in units else "")
        for key, value in table.items()
    ]


def _toml(value: object) -> str:
    """Write a text, a number or a list as TOML does."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", " ")
