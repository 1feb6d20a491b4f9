"""The choices that a shape leaves, apart from what computes it: presets are checked without loading that."""

ENDS = ("free", "cantilever")
"""The ways in which a bar is held."""

EDGES = ("free", "clamped", "supported")
"""The ways in which an edge of a plate or a disc is held."""

BOARDS = ("piano", "box", "cello", "guitar")
"""The names of what strings move (`radiation/board.py`)."""

MOST_WIRES = 3
"""Wires of a string: a piano's notes have up to so many."""
