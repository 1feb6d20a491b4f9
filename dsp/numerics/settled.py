"""Tables that have the same bits on every machine.

numpy's BLAS, its vectors and the system's mathematical functions round otherwise on other processors, and tables that
kernels read are compiled into portable code. So such a table is taken from `settled.npz`, which has it as one machine
computed it. `python -m tests.bench.settled` writes the file, and a test compares its tables with those computed.
"""

import hashlib
import io
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

FILE = Path(__file__).with_name("settled.npz")
SUM = "080ecd3194d4fb203a85d3c907d5d0a5933e0ae618ebd3964bc8c0880219007f"
"""SHA-256 of the file: code that was compiled with other tables is of other sources."""
REMEDY = "`python -m tests.bench.settled` writes it anew"

computed: dict[str, NDArray[np.float64]] = {}
"""Tables as this process has computed them, by name."""
taken = True
"""False where tables are those that were computed, as while the file is written."""


@cache
def kept() -> dict[str, NDArray[np.float64]]:
    """Return the file's tables by name; RuntimeError where it is another file."""
    content = FILE.read_bytes()
    if hashlib.sha256(content).hexdigest() != SUM:
        raise RuntimeError(f"{FILE}: expected the file whose SHA-256 is {SUM}; {REMEDY}")
    with np.load(io.BytesIO(content)) as file:
        return dict(file)


def same_everywhere(name: str, values: Any) -> NDArray[np.float64]:
    """Return the table that is kept by a name, float64: that of `values`, but for roundings.

    RuntimeError where there is none of this shape.
    """
    if name in computed:
        raise RuntimeError(f"{name}: two tables have this name")
    found = computed[name] = np.array(values, np.float64)
    if not taken:
        return found
    table = kept().get(name)
    if table is None or table.shape != found.shape:
        raise RuntimeError(f"{name}: {FILE.name} has no such table of the shape {found.shape}; {REMEDY}")
    return table


def single(values: Any) -> NDArray[np.float64]:
    """Return values, float64, rounded to single precision: they then are the same where roundings of double precision
    are not."""
    return np.asarray(values, np.float32).astype(np.float64)
