"""Modes of bodies from shape and material. Made once, in Python."""
