"""Compilation of kernels, and access to the machine that they need. It knows no sound."""

from time import time_ns

BEGAN = time_ns()
"""Time (ns) at which this process began to import kernels: sources that change later may not be what it runs."""
