"""Write the tables and the modes that have the same bits on every machine, as this one computes them
(`dsp/numerics/settled.py`, `presets/settled.py`).

    python -m tests.bench.settled [tables | modes]

All sounds then change by roundings; `tests.bench.golden --renew` writes their hashes.
"""

import argparse
import hashlib
import importlib
import re
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from carom.dsp.numerics import settled as tables
from carom.dsp.resonator.bank import top_of
from carom.presets import Presets
from carom.presets import settled as modes

SOLVED = ("bar", "plate")
"""Shapes whose modes come of eigenvectors; so do those of discs that are domes."""
RATE = 48_000.0  # Hz: modes are the same from 42.2 kHz on


def write_tables() -> None:
    tables.taken = False
    importlib.import_module("carom.dsp.runtime.callback")
    np.savez_compressed(tables.FILE, allow_pickle=False, **tables.computed)
    source, total = Path(tables.__file__), hashlib.sha256(tables.FILE.read_bytes()).hexdigest()
    source.write_text(re.sub(r'^SUM = ".*"', f'SUM = "{total}"', source.read_text(), flags=re.MULTILINE))
    print(f"{tables.FILE.name}: {len(tables.computed)} tables, {tables.FILE.stat().st_size} bytes")


def write_modes() -> None:
    presets, count, index, modes.taken = Presets(), 0, [], False
    with zipfile.ZipFile(modes.FILE, "w", zipfile.ZIP_LZMA) as file:

        def add(key: str, values: NDArray[Any]) -> None:
            member = zipfile.ZipInfo(f"{key}.npy")  # of no time: the same bytes for the same modes
            member.compress_type = zipfile.ZIP_LZMA
            with file.open(member, "w") as into:
                np.lib.format.write_array(into, np.ascontiguousarray(values), allow_pickle=False)

        for name in presets.names("objects"):
            preset = presets.object(name)
            found = preset.modes(top_of(RATE))
            index.append((found.pitch, found.frequency.size, name))
            arrays = {"frequency": np.float32(found.frequency)}
            if preset.shape in SOLVED or (found.sheet is not None and found.sheet.parts):
                count, arrays = count + 1, modes.packed(found)
            for key, values in arrays.items():
                add(f"{name}/{key}", values)
        add("index", np.array(index, modes.INDEX))
    print(f"{modes.FILE.name}: modes of {count} objects, {modes.FILE.stat().st_size} bytes")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("which", nargs="?", choices=("tables", "modes"), help="what to write; both if it is not given")
    which = parser.parse_args().which
    if which != "modes":
        write_tables()
    if which != "tables":
        write_modes()


if __name__ == "__main__":
    main()
