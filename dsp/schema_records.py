"""Records of the numbers that the schema declares, as the engine holds them."""

import dataclasses

import numpy as np

from .schema import STEERABLE, Stats


def record_of(*names: str) -> np.dtype[np.void]:
    """Return a record of float64 fields of these names."""
    return np.dtype([(name, np.float64) for name in names], align=True)


STATS = np.dtype(
    [(field.name, np.int64 if field.type in (int, "int") else np.float64) for field in dataclasses.fields(Stats)],
    align=True,
)
"""The counters as the engine holds them."""

STEERED = record_of(*STEERABLE)
"""A value for each steerable parameter."""
