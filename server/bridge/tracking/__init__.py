"""Contacts of a simulation, step by step: which begin, which stay, how fast they slip and sweep."""
