"""The basis of a ringing mode's block: a few functions of time that all modes share.

Over a block of FRAMES samples about its middle, a mode c exp(lambda n) lies near the middle of a bin of frequencies:
lambda n = i omega_b n + zeta tau, with tau from -1 to 1. Its zeta is small, and exp(zeta tau) is a polynomial of degree
TERMS - 1 in zeta, whose coefficients psi_j(tau) are the same for all modes: the one that is right at TERMS points of
the rectangle in which zeta can be (Lagrange). Between them it errs by at most -115 dB of the mode's amplitude in the
middle of the block.
"""

import math

FRAMES = 512
"""Length of a block."""
BINS = FRAMES
"""Number of bins of frequencies, from 0 to Nyquist's."""
TERMS = 8
POINT = 2 * TERMS
"""Numbers of a point of the transform."""
SIZE = 2 * BINS
"""Points of the Fourier transform."""

MOST_LOSS = math.log(1000.0) / (0.05 * 48_000.0)
"""The largest decay, in nepers a sample, of a mode in the bank: a decay time (60 dB) of 0.05 s at 48 kHz."""

HALF_WIDTH = 0.25 * math.pi * FRAMES / BINS
"""Half the range of zeta's imaginary part."""
CENTRE = -0.25 * MOST_LOSS * FRAMES
"""Centre of the real part of zeta, which is between 0 and twice that."""
RADIUS = math.hypot(HALF_WIDTH, CENTRE)
"""Zeta is kept as (zeta - CENTRE)/RADIUS, which is in the unit circle."""
