"""MIDI into the server: notes, a pedal and controllers become messages."""
