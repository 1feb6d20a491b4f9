"""Objects and gestures by name: messages become the engine's commands."""
