"""Physical constants, and the scale of the sound."""

STANDARD_GRAVITY = 9.80665
"""m/s^2: the standard acceleration of free fall, by definition (3rd CGPM, 1901)."""

AIR_DENSITY = 1.2
"""kg/m^3, of air at 20 degrees."""

SPEED_OF_SOUND = 343.0
"""m/s, in it."""

LOSS_FACTOR_AT = 1000.0
"""Hz: frequency at which a material's `loss_factor` holds."""

FULL_SCALE_PRESSURE = 4.0
"""Pa: the sound pressure that is full scale, 0 dBFS, of an object whose level is 0 dB, unless another is chosen: 106 dB
over 20 µPa. Strikes of most things, at a metre, come out at a usual loudness then."""

GRID = 256.0
"""Places between two samples where an event that is played live may fall: few enough that a score's seconds can name
each exactly."""

HARDEST_REST = 1e9
"""N per kg that the load of a rest may be: light masses on felt that were pressed a thousand times harder rang up to 43
dB too loud."""

NEUTRAL = 0.5
"""The value at which a macro changes nothing."""

HAND = 200.0
"""1/s: decay that a hand adds to all modes where it holds an object as firmly as it can."""

MACRO_NODES = 9
"""Places of a macro, from 0 to 1, at which the modes of a body are known; between two they go by equal ratios."""

RELIEF_DAMPING = 0.7
"""Damping ratio of the modes that keep slow forces from being heard (runtime/relief.py)."""
