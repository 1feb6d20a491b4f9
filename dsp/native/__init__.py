"""Compilation of kernels, and access to the machine that they need. It knows no sound."""

import os
from time import time_ns

BEGAN = time_ns()
"""Time (ns) at which this process began to import kernels: sources that change later may not be what it runs."""

CHECKED = os.environ.get("CAROM_CHECKED", "") not in ("", "0")
"""True if this process compiles, and runs, kernels that check their indices (`checked.py`): CAROM_CHECKED=1."""
