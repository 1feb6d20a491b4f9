"""The engine's memory: its records, and the kernels that keep a single one of them."""
