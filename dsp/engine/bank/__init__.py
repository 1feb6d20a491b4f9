"""The spectral bank in the engine: objects that nothing touches go into it, come back, and leave their tails."""
