"""Contacts from their beginning to their end: which solver finds the force, and what flies, spins, rolls and slides."""
