"""Modes that have the same bits on every machine.

Libraries of linear algebra, numpy and C's mathematical functions round otherwise on other processors. So the numbers
of a built-in object are rounded to single precision. What comes of eigenvectors, as the
modes of bars, plates and domes do, would differ all the same: it is taken from `settled.npz`, as one machine computed
it. Shapes are kept there as portable code has them (`dsp/runtime/series.py`), 105 dB below their peaks on average.
`python -m tests.bench.settled` writes the file, and a test compares it with what is computed.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..dsp.bodies.acceleration import Click
from ..dsp.bodies.modes import Modes, Unheard
from ..dsp.numerics.settled import single
from ..dsp.runtime.series import LEAST_ROWS, coefficients_of, multiples_of, scale_of, sum_of, told_by_terms, values_of

FILE = Path(__file__).with_name("settled.npz")
NEAR = 1e-5
"""Share of the greatest value by which modes that are computed may differ from those that are kept and be the same, but
for roundings."""
INDEX = np.dtype([("pitch", np.float64), ("modes", np.int64), ("name", "U32")])
Arrays = Mapping[str, NDArray[Any]]

taken = True
"""False while modes are computed to be kept, or to be compared with what is kept."""


def settle(modes: Modes) -> Modes:
    """Return the modes of an object with the bits that they have everywhere, where some are kept that are the same but
    for roundings; as they are for any other object."""
    if not taken:
        return modes
    for name in _near(modes.pitch, modes.frequency.size):
        arrays = kept(name)
        if "decay" not in arrays and np.allclose(arrays["frequency"], modes.frequency, NEAR, 0.0):
            return rounded(modes)
        if "decay" in arrays and _same(found := unpacked(arrays, modes), modes):
            return found
    return modes


def _same(found: Modes, modes: Modes) -> bool:
    """True if modes differ by roundings and signs alone."""
    if found.strike.shape != modes.strike.shape:
        return False
    pairs = [
        (each.frequency, each.decay, *np.abs(each.pressure), np.abs(each.strike).max(axis=0)) for each in (found, modes)
    ]
    return all(np.allclose(one, other, NEAR, NEAR * other.max()) for one, other in zip(*pairs, strict=True))


def rounded(modes: Modes) -> Modes:
    """Return modes with numbers of single precision."""
    sheet, unheard = modes.sheet, modes.unheard
    if sheet is not None:
        sheet = replace(sheet, shrinking=single(sheet.shrinking), frequency=single(sheet.frequency), kept={})
    return replace(
        modes,
        frequency=single(modes.frequency),
        decay=single(modes.decay),
        pressure=single(modes.pressure),
        strike=single(modes.strike),
        clicks=_rounded(modes.clicks),
        unheard=None if unheard is None else Unheard(*map(single, unheard)),
        sheet=sheet,
    )


@cache
def _index() -> NDArray[Any]:
    """Return the pitch (Hz), the number of modes and the name of each object of which modes are kept."""
    with np.load(FILE, allow_pickle=False) as file:
        found: NDArray[Any] = file["index"]
    return found


def names() -> list[str]:
    """Return the names of the objects of which modes are kept."""
    return [str(name) for _, _, name in _index()]


def _near(pitch: float, modes: int) -> list[str]:
    """Return the names of those that have a pitch (Hz), but for roundings, and a number of modes."""
    return [str(name) for own, count, name in _index() if count == modes and abs(own - pitch) <= NEAR * pitch]


def kept(name: str) -> Arrays:
    """Return the arrays that are kept of an object, as `packed` returns them, or its frequencies alone."""
    with np.load(FILE, allow_pickle=False) as file:
        return {each.split("/")[1]: file[each] for each in file.files if each.startswith(f"{name}/")}


def packed(modes: Modes) -> dict[str, NDArray[Any]]:
    """Return the arrays to be kept of an object's modes, by their names."""
    found: dict[str, NDArray[Any]] = {
        "frequency": modes.frequency.astype(np.float32),
        "decay": modes.decay.astype(np.float32),
        "pressure": modes.pressure.astype(np.float32),
        **_packed_table("strike", modes.strike),
    }
    if modes.unheard is not None:
        found["unheard"] = np.array([modes.unheard.frequency, modes.unheard.decay], np.float32)
        found |= _packed_table("felt", modes.unheard.strike)
    if modes.sheet is not None:
        found["sheet"] = np.array([modes.sheet.shrinking, modes.sheet.frequency], np.float32)
        mixtures = np.concatenate([each.ravel() for _, each in modes.sheet.parts])
        found["mixtures"] = multiples_of(mixtures.astype(np.float32), np.ones(1)).astype(np.int32)
    return found


def unpacked(arrays: Arrays, modes: Modes) -> Modes:
    """Return modes with the arrays that are kept of them."""
    unheard, sheet = modes.unheard, modes.sheet
    if unheard is not None and "unheard" in arrays:
        frequency, decay = arrays["unheard"].astype(np.float64)
        unheard = Unheard(frequency, decay, _unpacked_table("felt", arrays))
    if sheet is not None and "sheet" in arrays:
        shrinking, frequency = arrays["sheet"].astype(np.float64)
        ends = np.cumsum([each.size for _, each in sheet.parts])
        cut = np.split(values_of(arrays["mixtures"].astype(np.int64), np.ones(1)).astype(np.float64), ends[:-1])
        parts = [(place, own.reshape(each.shape)) for (place, each), own in zip(sheet.parts, cut, strict=True)]
        sheet = replace(sheet, shrinking=shrinking, frequency=frequency, parts=parts, kept={})
    return replace(
        modes,
        frequency=arrays["frequency"].astype(np.float64),
        decay=arrays["decay"].astype(np.float64),
        pressure=arrays["pressure"].astype(np.float64),
        strike=_unpacked_table("strike", arrays),
        clicks=_rounded(modes.clicks),
        unheard=unheard,
        sheet=sheet,
    )


def _rounded(clicks: tuple[Click, ...]) -> tuple[Click, ...]:
    found = []
    for each in clicks:
        frequency, decay, strength = single(np.array(each[:3])).tolist()
        found.append(Click(frequency, decay, strength, tuple(single(np.array(each.along)).tolist())))
    return tuple(found)


def _packed_table(name: str, table: NDArray[np.float64]) -> dict[str, NDArray[Any]]:
    """Return the arrays of a table of shapes (P, n): the exponents of its columns' scales, 1 for those that polynomials
    give, their coefficients, and the steps from row to row of all others."""
    narrow = table.astype(np.float32)
    scale = scale_of(narrow)
    by_terms = told_by_terms(narrow) if len(narrow) >= LEAST_ROWS else np.zeros(scale.shape, bool)
    others = multiples_of(narrow[:, ~by_terms], scale[~by_terms])
    return {
        f"{name}.scale": np.frexp(scale)[1].astype(np.int16),
        f"{name}.by_terms": by_terms,
        f"{name}.terms": coefficients_of(narrow[:, by_terms], scale[by_terms]).astype(np.int32),
        f"{name}.steps": np.diff(others, axis=0, prepend=0).astype(np.int32),
    }


def _unpacked_table(name: str, arrays: Arrays) -> NDArray[np.float64]:
    """Return a table of shapes of its arrays."""
    scale = np.ldexp(0.5, arrays[f"{name}.scale"])
    by_terms, steps = arrays[f"{name}.by_terms"], arrays[f"{name}.steps"].astype(np.int64)
    found = np.empty((len(steps), scale.size), np.float32)
    found[:, by_terms] = sum_of(arrays[f"{name}.terms"].astype(np.int64), len(steps), scale[by_terms])
    found[:, ~by_terms] = values_of(np.cumsum(steps, axis=0), scale[~by_terms])
    return found.astype(np.float64)
