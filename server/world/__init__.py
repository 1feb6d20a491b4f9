"""A simulation heard: its bodies become objects, its contacts gestures on them, as messages."""
