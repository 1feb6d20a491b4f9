"""Physical constants."""

STANDARD_GRAVITY = 9.80665
"""m/s^2: the standard acceleration of free fall, by definition (3rd CGPM, 1901)."""
