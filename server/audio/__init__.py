"""The output of sound: devices, the clock, and the supervisor that keeps one of them running."""
