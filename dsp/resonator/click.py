"""A body's click (see bodies/acceleration.py) as modes of the bank.

A click whose natural frequency is at most DIRECT is one mode whose output has a phase. It is exact at each sample,
whatever the rate, as the body's modes are, and comes with them. As with these, what it has above half the rate folds
down. Of a steel ball of 13 mm that strikes steel at 1 m/s, the hardest blow of the largest click, this moves the
spectrum at 44.1 kHz by up to 1.3 dB at 12 kHz and 4 dB at 19 kHz, by where between two samples it falls; at 96 kHz by
less than 0.1 dB.

The sound of a smaller body follows the force as fast as that changes: it would be all alias, were it only sampled. So
it goes through a filter first, in continuous time: an elliptic low pass of order 6, whose answer to the click is, in
partial fractions, four modes whose outputs have phases. Each is exact at each sample, and so the sound is the same
function of time at any rate from FROM on.

Up to PASS, 20 kHz, the filter is within 0.05 dB. It delays by 29 us at low frequencies, by 37 us at 12 kHz, 50 us at
16 kHz. A part of the sound above half the rate is heard at f. At 44.1 kHz, that at rate - f is -60 dB where f is up to
13 kHz, -38 dB at 16 kHz and -18 dB at PASS. At lower rates the filter's frequencies, DIRECT and FASTEST go with the
rate. A click faster than FASTEST, of a sphere of less than 1.6 mm, is taken as one of FASTEST that is as loud at low
frequencies: it is within 0.15 dB up to PASS, and up to 5 us later.
"""

import math

from ..native.jit import kernel
from .bank import Modes
from .coefficients import set_mode
from .sizes import CLICK_MODES

FROM = 44_100.0  # Hz: of the rate
DIRECT, PASS, FASTEST = 12_000.0, 20_000.0, 49_000.0  # Hz, at rates from FROM on
# scipy.signal.ellipap(6, 0.1, 60), whose gain is made 0.05 dB higher: in units of PASS, each for a pair.
ZEROS = (5.301699241231073, 2.056659629486572, 1.5902508092970027)  # on the imaginary axis
POLES = (
    complex(-0.4829097667736507, 0.3438225255794298),
    complex(-0.28059633870655215, 0.8412207754322727),
    complex(-0.08284540267608997, 1.0458178638326978),
)
GAIN = 1e-3 * 10.0 ** (0.05 / 20.0)
_APART = 1e-5  # PASS: of the click's own pole from the filter's, at least
_MADE = -1e-3  # of a mode that answers nothing: not 0, as it has been made


@kernel
def click_mode(k: int, frequency: float, decay: float, rate: float) -> tuple[float, float, complex]:
    """Return the frequency (Hz), the decay (1/s) and the weight of mode k of a click (Hz, 1/s) of a strength of 1.

    It is heard as Im(weight z). Of a click that is sampled as it is, mode 0 is all; the others have a frequency of 0.

    Mode 0 is the click's own, whose transform is s/((s - p)(s - p*)); the others are the filter's. The weight of a pole
    q is what the product of both transforms is there without its pair, over Im q.
    """
    scale = min(1.0, rate / FROM)
    own = complex(-decay, 2.0 * math.pi * frequency)
    natural = math.sqrt(own.real * own.real + own.imag * own.imag) / (2.0 * math.pi * scale)
    if natural <= DIRECT:
        return (frequency, decay, complex(own.real / own.imag, 1.0)) if k == 0 else (0.0, 0.0, 0.0j)
    unit, slower = 2.0 * math.pi * PASS * scale, min(1.0, FASTEST / natural)
    own *= slower / unit
    for pole in POLES:
        if abs(own.real - pole.real) + abs(own.imag - pole.imag) < _APART:
            own += complex(-_APART, _APART)
    q = own
    for i in range(len(POLES)):
        if k == i + 1:
            q = POLES[i]
    above, below = q * (GAIN * slower * slower / q.imag), complex(1.0, 0.0)
    for zero in ZEROS:
        above *= q * q + zero * zero
    for i in range(len(POLES)):
        if k != i + 1:
            below *= (q - POLES[i]) * (q - POLES[i].conjugate())
    if k > 0:
        below *= (q - own) * (q - own.conjugate())
    weight = above * below.conjugate() * (1.0 / (below.real * below.real + below.imag * below.imag))
    return q.imag * unit / (2.0 * math.pi), -q.real * unit, weight


@kernel
def set_click(modes: Modes, i: int, frequency: float, decay: float, rate: float, strength: float) -> None:
    """Make modes i to i + CLICK_MODES - 1 a click: frequency (Hz) > 0, decay (1/s), strength in output per N s.

    They have been at rest; no contact feels them.
    """
    for k in range(CLICK_MODES):
        pitch, loss, weight = click_mode(k, frequency, decay, rate)
        set_mode(modes, i + k, pitch, loss, rate, strength * weight)
        if pitch == 0.0:
            modes.a2[i + k] = _MADE
