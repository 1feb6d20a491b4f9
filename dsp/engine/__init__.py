"""The compiled engine: commands in, gestures, contacts and modes, sound out."""
