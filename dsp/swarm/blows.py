"""The blows of a swarm: how strong each is, how long it lasts, and how the object yields to it.

A grain of mass m meets the object at v by the contact law: its pulse is that of contact/closed_form.py. Sizes between
two sieves are spread evenly by ratios, s = exp(V (2 u - 1)): mass goes as s^3, stiffness as the root of s (Hertz).
Speeds are those at which a gas of grains meets a wall, v = v_rms sqrt(-ln u), or of Weibull's distribution: with
another root than the square one. Grains that fall from h on what is uneven meet it at v = sqrt(2 g h u), as many at
each share u of their energy along its normal. Energies follow a power law E^-b between two ends, by inverse transform.

Drops have diameters of Marshall and Palmer's exponential distribution (J. Meteorology 5, 1948) above half a millimetre,
and the speeds at which they fall, v = 9.65 - 10.3 exp(-600 D) m/s (Atlas, Srivastava and Sekhon, Reviews of Geophysics
11, 1973). Those that arrive are v times as many, which makes D - D_0 the sum of one exponential or, for a share of
them, two: no draw is thrown away.

A ball of water begins to push a wall by 3 sqrt(6)/2 rho v^(5/2) D^(3/2) sqrt(t) (Philippi, Lagree and Antkowiak,
J. Fluid Mech. 795, 2016, as Gordillo, Sun and Cheng measured, 835, 2018). With sqrt(t) exp(-t/T) for the whole force,
and its momentum, T is DROP_TIME D/v, and the force greatest at half of that: 0.86 rho v^2 D^2 after 0.15 D/v. A drop
that falls is flat below: it pushes as a ball of a larger radius R does, and T goes as 1/R. The shapes that Chuang and
Beard computed (J. Atmospheric Sciences 47, 1990, table 1) are as flat over the first 0.05 radii as balls of 1.2, 1.5,
1.8, 2.2 and 2.5 times theirs, for 2 to 6 mm: that is exp((D - 0.87 mm)/5.4 mm) within 3 %, from where on it is above 1.

Drops on a wide level fall at all distances r from an ear: as many at each share of its area, so that r^2 is spread
evenly from that of the nearest. The pressure of each goes as 1/r: it moves the object as if it were that much fainter.

An object yields to a pulse by the modes that are not faster than it. With mobility M(s) = sum phi^2/(1 + (0.83 omega
s)^3), where s is the pulse's rms width, the grain's mass is as if it were m/(1 + m M). The factor on phi^2 is above the
pulse's |P|^2 at any frequency, so that the modes of an object at rest take at most m v^2/2.

Many blows move a mode together while it goes one way, for 1/omega: r blows a second of the mean mass m are r m/omega
then, and the momentum of each is less by 1/(1 + STREAM r m sum phi^2/omega), too, where r m is that of all swarms on
the object. Of drops at all distances it is less by the square of their mean share 2/(R + 1), where R is the reach.
"""

import math

from ..native.jit import kernel
from ..native.typed import View
from ..numerics.elementary import exp, log
from ..schema import DROPS, ENERGIES, FALLS
from .grid import MOST_LOSS
from .record import BATCH, FORMS, WIDTHS, Blows, PulseTable, Swarm
from .times import DISTANCE, MAGNITUDE, OTHER, PLACE, VARIETY, unit

ROLL_OFF = 0.83
"""The roll-off of a pulse's power: |P|^2 <= 1/(1 + (0.83 omega s)^3) for drops, and 1.0 for contacts of w up to 3."""
STREAM = 2.0
"""Factor on a stream's share: one mode under a force that begins at once asks for 1.3 or more."""
NARROWEST = -22.0
"""Octaves of a second: the least width for which mobilities are kept; the others follow octave by octave."""

SMALLEST_DROP = 0.5e-3
"""m."""
_LARGEST_DROP = 6e-3  # m: larger ones break up
_WATER = 1000.0 * math.pi / 6.0  # kg/m^3: mass over the diameter's cube
_FASTEST, _SLOWING, _SLOWED = 9.65, 10.3, 600.0  # m/s, m/s, 1/m
_NEARLY = _SLOWING / _FASTEST * math.exp(-_SLOWED * SMALLEST_DROP)
DROP_TIME = (math.pi / (9.0 * math.sqrt(6.0) * math.gamma(1.5))) ** (2.0 / 3.0)
"""Time scale of a ball's force, in its diameter over its speed."""
_ROUND, _FLATTER = 0.87e-3, 186.0  # m, 1/m
_SLOWEST = 1e-9  # m/s
_GAS = 2.0  # exponent of a gas's speeds at a wall
_LN2 = math.log(2.0)
_UNMOVED = 2e-3  # m M: the pulse is shorter by that over a + 1
_FLAT = 1e-9  # of 1 - b: the power law is as good as even by ratios


@kernel
def draw_blows(swarm: Swarm, table: PulseTable, blows: Blows) -> None:
    """Draw the last blows' places, speeds (m/s), masses (kg), losses w/(1 + w), and ln of their rms widths (s) at an
    object that does not yield. Loops go over whole batches, so that the same instructions make each blow."""
    first, places, begin = blows.number[0], swarm.places, swarm.random[PLACE]
    for n in range(BATCH):
        blows.place[n] = int(unit(begin, first + n) * places)
    if swarm.law == DROPS:
        # Draw drops, the speeds at which they fall, and by how much they are heard.
        scale, width = swarm.knots[0].scale, table.width[0]
        magnitude, other, variety = swarm.random[MAGNITUDE], swarm.random[OTHER], swarm.random[VARIETY]
        distance, beyond = swarm.random[DISTANCE], swarm.beyond
        for n in range(BATCH):
            i = first + n
            # The diameter (m) of a drop that arrives, of those whose mean diameter in the air is `scale` above
            # the smallest.
            u = unit(magnitude, i)
            second = unit(other, i)
            chosen = unit(variety, i)
            more = _NEARLY * _SLOWED * scale
            less = (1.0 - _NEARLY) * (1.0 + _SLOWED * scale)
            cut = scale / (1.0 + _SLOWED * scale) * log(second) if chosen * (more + less) < more else 0.0
            diameter = min(SMALLEST_DROP - scale * log(u) - cut, _LARGEST_DROP)
            v = _FASTEST - _SLOWING * exp(-_SLOWED * diameter)
            blows.v[n], blows.mass[n], blows.loss[n] = v, _WATER * diameter * diameter * diameter, 0.0
            blows.width[n] = log(DROP_TIME * diameter / v) - _FLATTER * max(diameter - _ROUND, 0.0) + width
            blows.heard[n] = 1.0 / math.sqrt(1.0 + unit(distance, i) * beyond)
        return
    # Draw the masses of grains (kg), and ln of these over their stiffnesses.
    m, k, sizes = swarm.m, swarm.k, swarm.knots[0].variety
    if sizes == 0.0:
        light = swarm.light
        for n in range(BATCH):
            blows.mass[n], blows.light[n] = m, light
    else:
        begin = swarm.random[VARIETY]
        for n in range(BATCH):
            s = exp(sizes * (2.0 * unit(begin, first + n) - 1.0))
            mass = m * s * s * s
            blows.mass[n], blows.light[n] = mass, log(mass / (k * math.sqrt(s)))
    # Draw the speeds (m/s) of grains, by the law of their swarm and no more than its store of energy has.
    begin, scale = swarm.random[MAGNITUDE], swarm.knots[0].scale
    if swarm.law == ENERGIES:
        # Draw the speeds (m/s) of grains whose energies follow a power law, by inverse transform.
        knot = swarm.knots[0]
        highest, span, rest = knot.scale, knot.span, 1.0 - knot.steepness
        if abs(rest) < _FLAT:
            for n in range(BATCH):
                energy = highest * exp(-span * unit(begin, first + n))
                blows.v[n] = max(math.sqrt(2.0 * energy / blows.mass[n]), _SLOWEST)
        else:
            # u = 1 - (E^(1-b) - lo^(1-b))/(hi^(1-b) - lo^(1-b)), of E over the highest
            low = exp(-rest * span)
            for n in range(BATCH):
                energy = highest * exp(log(low + (1.0 - low) * unit(begin, first + n)) / rest)
                blows.v[n] = max(math.sqrt(2.0 * energy / blows.mass[n]), _SLOWEST)
    elif swarm.law == FALLS:
        for n in range(BATCH):
            blows.v[n] = max(scale * math.sqrt(unit(begin, first + n)), _SLOWEST)
    else:
        # Draw the speeds (m/s) of a gas at a wall, or more even or uneven ones.
        asked: float = swarm.knots[0].steepness
        evenness = asked if asked > 0.0 else _GAS
        if evenness == _GAS:
            for n in range(BATCH):
                blows.v[n] = max(scale * math.sqrt(-log(unit(begin, first + n))), _SLOWEST)
        else:
            for n in range(BATCH):
                blows.v[n] = max(scale * exp(log(-log(unit(begin, first + n))) / evenness), _SLOWEST)
    if swarm.store != math.inf:
        for n in range(blows.count):
            most = math.sqrt(2.0 * max(swarm.store, 0.0) / blows.mass[n])
            blows.v[n] = max(min(blows.v[n], most), _SLOWEST)
            swarm.store -= 0.5 * blows.mass[n] * blows.v[n] * blows.v[n]
    for n in range(BATCH):
        blows.loss[n], blows.width[n] = pulse_of(swarm, table, blows.light[n], blows.v[n])


@kernel
def pulse_of(swarm: Swarm, table: PulseTable, light: float, v: float) -> tuple[float, float]:
    """Return the loss w/(1 + w) and ln of the rms width (s) of a grain's pulse at a speed (m/s).

    light: ln of its mass over its stiffness.
    """
    scale = (light + (1.0 - swarm.a) * log(v)) / (swarm.a + 1.0)
    w = swarm.w if swarm.w > 0.0 else swarm.mu * v
    loss = min(w / (1.0 + w), MOST_LOSS)
    return loss, scale + known_of(table.width, loss)


@kernel
def known_of(values: View[float], loss: float) -> float:
    """Return what is known of pulses at a loss, by lines between FORMS of them."""
    x = min(max(0.0, loss / MOST_LOSS), 1.0 - 1e-9) * (FORMS - 1)
    n = int(x)
    found: float = values[n] + (x - n) * (values[n + 1] - values[n])
    return found


@kernel
def mean_mass(swarm: Swarm) -> float:
    """Return the mean mass (kg) of a swarm's blows, with the drops' that break up."""
    if swarm.law == DROPS:
        scale = swarm.knots[0].scale
        slower = scale / (1.0 + _SLOWED * scale)
        less = _NEARLY * slower / scale
        return _WATER * (_mean_cube(scale) - less * _mean_cube(slower)) / (1.0 - less)
    v = 3.0 * swarm.knots[0].variety
    return swarm.m * math.sinh(v) / v if v > 0.0 else swarm.m


@kernel
def _mean_cube(scale: float) -> float:
    """Return the mean of (SMALLEST_DROP + x)^3 for an exponential x of a mean."""
    d = SMALLEST_DROP
    return d * d * d + 3.0 * scale * (d * d + 2.0 * scale * (d + scale))


@kernel
def yielding(swarm: Swarm, place: int, mass: float, width: float) -> tuple[float, float, float]:
    """Return the factor 1/(1 + m M) on a blow's mass, and m M as the rigid wall's pulse has it; between them ln of the
    blow's width (s) then. width: ln of the width as the wall has it.

    A lighter mass makes a shorter pulse, which reaches more modes: two steps of that go most of the way, and the bound
    on the energy holds after any number. A pulse that would be shorter by 0.1 % stays as it is: that is -60 dB.
    """
    asked = mass * _mobility(swarm, place, width)
    if asked < _UNMOVED:
        return 1.0 / (1.0 + asked), width, asked
    shorter = width
    ratio = 1.0 / (1.0 + asked)
    if swarm.law != DROPS:
        for _ in range(2):
            shorter = width + log(ratio) / (swarm.a + 1.0)
            ratio = 1.0 / (1.0 + mass * _mobility(swarm, place, shorter))
    return ratio, shorter, asked


@kernel
def _mobility(swarm: Swarm, place: int, width: float) -> float:
    """Return the mobility (1/kg) of a place for a pulse of a width (ln of s): that of the next narrower one that is
    known, between the two by lines where that is above it."""
    return mobility_at(swarm.mobility[place], width)


@kernel
def mobility_at(mobility: View[float], width: float) -> float:
    """Return what is known for pulses of WIDTHS at a width (ln of s), by lines between them."""
    x = min(max(0.0, width / _LN2 - NARROWEST), WIDTHS - 1.001)
    n = int(x)
    high, low = mobility[n], mobility[n + 1]
    return high + (x - n) * (low - high)
