"""Compilation of kernels, and access to the machine that they need. It knows no sound."""
