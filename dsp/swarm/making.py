"""The values of tables of pulses, from the pulses' forms: by one kernel, so that exported engines make the same bits.

A row is a pulse with the bump about it, at a place between samples, as a Fourier series of the row's length. Its
coefficients lie on parabolas through those of the pulse's spectrum, which is summed over the nodes of its form.
"""

import math
from ctypes import c_void_p

import numpy as np

from ..native.jit import c_function, carray, kernel, noinline_kernel
from ..native.typed import View
from .grid import LEAST, STEPS
from .record import MOST_LENGTH, OCTAVES, PULSE_TABLE, PULSE_WORK, PulseTable, PulseWork
from .simd import add_rows

PITCH = 0.02
"""The pitch of angular frequencies times width in a pulse's spectrum. Lines between would err by -86 dB, and that where
the bump has its power: a row's ends let it leak to EDGE, where the filter lifts it by 40 dB."""


@noinline_kernel
def _sum_spectrum(times: View[float], impulses: View[float], nodes: int, points: int, work: PulseWork) -> None:
    """Write the even and the odd part of a form's spectrum, at multiples of PITCH."""
    for k in range(points):
        work.even[k] = 0.0
        work.odd[k] = 0.0
    for j in range(nodes):
        turn, x, y = PITCH * times[j], impulses[j], 0.0
        c, s = math.cos(turn), math.sin(turn)
        for k in range(points):
            work.even[k] += x
            work.odd[k] += y
            x, y = x * c - y * s, x * s + y * c


@kernel
def _between(known: View[float], points: int, place: float, sign: float) -> float:
    """Return a part of a spectrum on the parabola through the three points that are nearest; 0 beyond the last one.

    sign: of the part at negative frequencies.
    """
    k = int(place + 0.5)
    if k >= points - 1:
        return 0.0
    before = known[k - 1] if k > 0 else sign * known[1]
    x = place - k
    return known[k] + 0.5 * x * (known[k + 1] - before + x * (known[k + 1] - 2.0 * known[k] + before))


@kernel
def _lay_order(table: PulseTable, octave: int, order: int, work: PulseWork) -> None:
    """Write the cosine and the sine of an order at the samples of a row about its middle."""
    length, phases = table.length[octave], table.phases[octave]
    at = order * (length - table.lead[octave]) % length
    for m in range(length):
        work.order[m] = work.cosine[at * phases]
        work.order[MOST_LENGTH + m] = work.sine[at * phases]
        at = (at + order) % length


@noinline_kernel
def _make_rows(
    table: PulseTable, octave: int, width: float, values: View[float], first: int, work: PulseWork
) -> None:  # fmt: skip
    """Write the rows of a width from a value on: one for each place between samples."""
    length, phases = table.length[octave], table.phases[octave]
    for n in range((phases + 1) * length):
        values[first + n] = 0.0
    for order in range(table.orders[octave]):
        place = width * (2.0 * math.pi / PITCH) * order / length
        even = _between(work.even, table.points, place, 1.0) * table.weight[octave, order]
        odd = _between(work.odd, table.points, place, -1.0) * table.weight[octave, order]
        _lay_order(table, octave, order, work)
        for phase in range(phases + 1):
            turn = order * phase % (length * phases)
            c, s = work.cosine[turn], work.sine[turn]
            weights = even * c - odd * s, even * s + odd * c
            add_rows(values, first + phase * length, work.order, (0, MOST_LENGTH), weights, length)


@noinline_kernel
def make_values(table: PulseTable, values: View[float], work: PulseWork) -> None:
    """Write the values of a table, the first one at values[0]."""
    for kind in range(table.dissipations):
        _sum_spectrum(table.times[kind], table.impulses[kind], table.nodes, table.points, work)
        for octave in range(OCTAVES):
            length, phases = table.length[octave], table.phases[octave]
            for n in range(length * phases):
                angle = 2.0 * math.pi * n / (length * phases)
                work.cosine[n] = math.cos(angle)
                work.sine[n] = math.sin(angle)
            first = table.first[octave] - table.first[0] + kind * table.block[octave]
            for step in range(STEPS + 1):
                width = LEAST * 2.0 ** (octave + step / STEPS)
                _make_rows(table, octave, width, values, first + step * (phases + 1) * length, work)


@c_function(None, c_void_p, c_void_p, c_void_p)
def make(table: int, values: int, work: int) -> None:
    """Write the values of a table (a PULSE_TABLE), as many as it says, with memory to work in (a PULSE_WORK)."""
    told: PulseTable = carray(table, (1,), PULSE_TABLE)[0]
    memory: PulseWork = carray(work, (1,), PULSE_WORK)[0]
    make_values(told, carray(values, (told.size,), np.float32), memory)
