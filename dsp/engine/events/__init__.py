"""Events: commands wait until they are due, and then begin, steer and end gestures."""
