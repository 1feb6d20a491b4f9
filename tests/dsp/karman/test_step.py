"""The step of coupled modes against the closed form of a plate with straight supported edges, and its energy."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from carom.dsp.karman.layout import SHEET, Sheet
from carom.dsp.karman.step import Heard, extrapolate, give_back, kick, prepare, take
from carom.dsp.native.jit import kernel
from carom.dsp.native.typed import View, f32

E_MODULUS, NU, DENSITY, THICKNESS, SIDES = 105e9, 0.34, 8700.0, 1e-3, (0.3, 0.2)


@kernel
def swing(
    sheet: Sheet, state: View[float], quartic: float, answer: View[f32], rate: float, every: int, heard: View[float]
) -> float:
    """Move one mode with V = quartic q^4/4 for as many samples as `heard` holds; return the most that psi and the
    linear energy together change. state: y1, y2, a1, a2, and a weight of 1."""
    y1, y2, a1, a2 = state[0:1], state[1:2], state[2:3], state[3:4]
    first = most = 0.0
    omega = 1.0 / sheet.moved[0]
    for n in range(len(heard)):
        if n % every == 0:
            q = y1[0] / omega
            answer[0] = quartic * q * q * q
            take(sheet, 0.25 * quartic * q * q * q * q, answer)
        else:
            extrapolate(sheet, (n % every) / every)
        kick(sheet, y1, y2, 1.0 / rate)
        z = (0.5 * a1[0] * y1[0] + a2[0] * y2[0]) * sheet.seen[0, 0] / (0.5 * a1[0])
        energy = 0.5 * (z * z + y1[0] * y1[0] + sheet.psi * sheet.psi)
        first = energy if n == 0 else first
        most = max(most, abs(energy - first))
        heard[n] = y1[0]
        y1[0], y2[0] = a1[0] * y1[0] + a2[0] * y2[0], y1[0]
    return most / (first - 0.5 * sheet.c0)


def swung(frequency, ratio, rate, periods=60.0, every=1, growth=2.2):
    """Return the period (s) of the lowest mode of a supported plate tuned to a frequency, by the step and exactly, and
    by how much the energy errs. ratio: amplitude over the thickness."""
    a, b = SIDES
    omega = 2 * math.pi * frequency
    rigidity = E_MODULUS * THICKNESS**3 / 12 / (1 - NU**2)
    # rho h W'' + D pi^4 (1/a^2 + 1/b^2)^2 W + E h pi^4/16 (1/a^4 + 1/b^4) W^3 = 0, scaled to the frequency.
    linear = rigidity * math.pi**4 * (1 / a**2 + 1 / b**2) ** 2
    cubic = E_MODULUS * THICKNESS * math.pi**4 / 16 * (1 / a**4 + 1 / b**4)
    quartic = omega**2 * cubic / linear  # with q = W
    amplitude = ratio * THICKNESS
    square = omega**2 + quartic * amplitude**2
    exact = 4 / math.sqrt(square) * ellipk(quartic * amplitude**2 / 2 / square)
    sheet = np.zeros(1, SHEET)
    theta = omega / rate
    sheet["functions"] = sheet["plain"] = 1
    sheet["scale"] = sheet["strained"] = sheet["tension"] = sheet["share"] = 1.0
    # It begins at rest, at a sample: half of a kick lies before it.
    state = np.array([omega * amplitude, omega * amplitude * math.cos(theta), 2 * math.cos(theta), -1.0, 1.0])
    prepare(sheet[0], Heard(state[2:3], state[3:4], state[4:5], state[4:5]), rate)
    potential = 0.25 * quartic * amplitude**4
    sheet["c0"] = growth * (0.5 * (omega * amplitude) ** 2 + potential)
    sheet["psi"] = math.sqrt(2 * potential + float(sheet["c0"][0]))
    push = 0.5 / rate * quartic * amplitude**3
    state[1] += sheet["pushed"][0, 0] * push
    heard = np.empty(int(periods * exact * rate))
    error = swing(sheet[0], state, quartic, np.zeros(8, np.float32), rate, every, heard)
    fell = np.flatnonzero((heard[:-1] < 0) & (heard[1:] >= 0))
    crossed = fell + heard[fell] / (heard[fell] - heard[fell + 1])
    return (crossed[-1] - crossed[0]) / (len(crossed) - 1) / rate, exact, error


@pytest.mark.slow
@pytest.mark.parametrize(("frequency", "cents"), [(60.0, 0.1), (300.0, 1.0), (600.0, 2.0)])
@pytest.mark.parametrize("ratio", [1.0, 2.0, 5.0])
def test_a_supported_plates_period_is_the_elliptic_integrals(frequency, cents, ratio):
    period, exact, error = swung(frequency, ratio, 96_000.0)
    assert abs(1200 * math.log2(period / exact)) < cents
    assert error < 1e-11


@pytest.mark.slow
def test_a_gradient_that_is_extrapolated_keeps_the_energy_and_the_period():
    period, exact, error = swung(300.0, 2.0, 96_000.0, every=2)
    assert abs(1200 * math.log2(period / exact)) < 2.0
    assert error < 1e-11


@kernel
def sway(
    sheet: Sheet, state: View[float], bend: View[float], answer: View[f32], rate: float, heard: View[float]
) -> None:
    """Move one mode with V = bend[0] q^3 + bend[1] q^4 and with losses for as many samples as `heard` holds: its q."""
    y1, y2, a1, a2 = state[0:1], state[1:2], state[2:3], state[3:4]
    for n in range(len(heard)):
        q = y1[0] * sheet.moved[0]
        answer[0] = 3 * bend[0] * q**2 + 4 * bend[1] * q**3
        take(sheet, bend[0] * q**3 + bend[1] * q**4, answer)
        give_back(sheet, y1, y2, 1.0 / rate, 0.0)
        kick(sheet, y1, y2, 1.0 / rate)
        heard[n] = q
        y1[0], y2[0] = a1[0] * y1[0] + a2[0] * y2[0], y1[0]


@kernel
def push(sheet: Sheet, state: View[float], rate: float, gradient: View[float], heard: View[float]) -> None:
    """Move one mode by gradients, one for each sample, and write what is heard: its output less what is bent."""
    y1, y2, a1, a2 = state[0:1], state[1:2], state[2:3], state[3:4]
    for n in range(len(heard)):
        y1[0], y2[0] = a1[0] * y1[0] + a2[0] * y2[0], y1[0]
        sheet.gradient[0, 0] = gradient[n]
        kick(sheet, y1, y2, 1.0 / rate)
        heard[n] = y1[0] - sheet.bent[0, 0]


@pytest.mark.slow
@pytest.mark.parametrize("slow", [100.0, 200.0, 400.0])
def test_a_slow_force_is_heard_as_the_acceleration_of_what_it_bends(slow):
    """A mode of 1 kHz that a sine of f bends is heard by its acceleration, (f/1 kHz)^2 of what its displacement would
    sound like, within 3 dB; and by its displacement not at all as loud."""
    rate, omega = 48_000.0, 2 * math.pi * 1000.0
    theta, r = omega / rate, math.exp(-200.0 / rate)
    sheet = np.zeros(1, SHEET)
    sheet["functions"] = sheet["plain"] = sheet["grids"]["domed"] = 1
    sheet["scale"] = sheet["strained"] = sheet["tension"] = sheet["share"] = 1.0
    sheet["highest"], sheet["growth"], sheet["c0"], sheet["psi"] = 5_000.0, 2.2, 1e9, math.sqrt(1e9)
    state = np.array([0.0, 0.0, 2 * r * math.cos(theta), -(r**2), 1.0])
    prepare(sheet[0], Heard(state[2:3], state[3:4], state[4:5], state[4:5]), rate)
    time = np.arange(int(0.3 * rate)) / rate
    force = np.sin(2 * math.pi * slow * time) * np.minimum(time / 0.1, 1.0)
    heard = np.empty(time.size)
    push(sheet[0], state, rate, force / math.sqrt(1e9), heard)
    bent = 1 / omega  # amplitude of the displacement's sound
    share = (slow / 1000.0) ** 2
    loudest = np.abs(heard[-int(rate / 20) :]).max() / bent
    assert abs(20 * math.log10(loudest * (1 - share) / share)) < 3.0


@pytest.mark.slow
@pytest.mark.parametrize("rate", [48_000.0, 96_000.0])
def test_a_mode_that_is_bent_by_stretching_loses_by_its_motion_alone(rate):
    """A dome that is pushed in stays so, and swings about there as a differential equation says: what the losses of the
    bent mode take comes back to what is stretched."""
    omega, decay, inward = 2 * math.pi * 200, 12.0, 1e-3
    # omega^2 q^2/2 + V = omega^2 q^2 (1 - q/inward)^2/2: as low pushed in as not.
    bend = np.array([-(omega**2) / inward, omega**2 / (2 * inward**2)])
    q = 1.15 * inward
    force = 3 * bend[0] * q**2 + 4 * bend[1] * q**3
    theta, r = omega / rate, math.exp(-decay / rate)
    sheet = np.zeros(1, SHEET)
    sheet["functions"] = sheet["plain"] = 1
    sheet["scale"] = sheet["strained"] = sheet["tension"] = sheet["share"] = sheet["drained"][0, 0] = 1.0
    sheet["given"], sheet["growth"], sheet["grids"]["domed"] = 0.999, 2.2, 1
    # It begins at rest, q' = 0, where v = q' + decay q: half of a kick lies before it.
    v = decay * q - 0.5 * force / rate
    y2 = (r * math.cos(theta) * omega * q - r * math.sin(theta) * (v + force / rate)) / r**2
    state = np.array([omega * q, y2, 2 * r * math.cos(theta), -(r**2), 1.0])
    prepare(sheet[0], Heard(state[2:3], state[3:4], state[4:5], state[4:5]), rate)
    energy = bend[0] * q**3 + bend[1] * q**4
    sheet["c0"] = 20 * omega**2 * q**2
    sheet["psi"] = math.sqrt(2 * energy + float(sheet["c0"][0]))
    heard = np.empty(int(0.3 * rate))
    sway(sheet[0], state, bend, np.zeros(8, np.float32), rate, heard)
    exact = solve_ivp(
        lambda _, z: (
            z[1],
            -2 * decay * z[1] - (omega**2 + decay**2) * z[0] - 3 * bend[0] * z[0] ** 2 - 4 * bend[1] * z[0] ** 3,
        ),
        (0.0, 0.3), (q, 0.0), "DOP853", np.arange(heard.size) / rate, rtol=1e-11, atol=1e-16,
    ).y[0]  # fmt: skip
    assert abs(float(sheet["psi"][0] / sheet["truth"][0]) - 1) < 2e-4
    assert np.abs(heard - exact).max() < 0.02 * np.abs(exact - exact[-1]).max()
