"""The bridge to simulators: bodies become objects, contacts gestures on them, as messages or as commands."""
