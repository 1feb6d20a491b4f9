"""Write the tables that have the same bits on every machine, as this one computes them (`dsp/numerics/settled.py`).

    python -m tests.bench.settled

All sounds then change by roundings; `tests.bench.golden --renew` writes their hashes.
"""

import hashlib
import importlib
import re
from pathlib import Path

import numpy as np

from carom.dsp.numerics import settled


def main() -> None:
    settled.taken = False
    importlib.import_module("carom.dsp.runtime.callback")
    np.savez_compressed(settled.FILE, allow_pickle=False, **settled.computed)
    source, total = Path(settled.__file__), hashlib.sha256(settled.FILE.read_bytes()).hexdigest()
    source.write_text(re.sub(r'^SUM = ".*"', f'SUM = "{total}"', source.read_text(), flags=re.MULTILINE))
    print(f"{settled.FILE.name}: {len(settled.computed)} tables, {settled.FILE.stat().st_size} bytes")


if __name__ == "__main__":
    main()
