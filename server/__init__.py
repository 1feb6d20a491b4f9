"""Carom's server: OSC and scores in, sound out to a device or a file."""
