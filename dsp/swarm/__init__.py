"""Swarms: many small blows as one force a sample and place, in continuous time."""
