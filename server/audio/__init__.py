"""Where the engine is heard: devices, the clock, and the supervisor that keeps one of them running."""
