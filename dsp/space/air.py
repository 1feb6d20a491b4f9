"""The absorption of sound by air: ISO 9613-1:1993, pure tones."""

import math


def absorption(frequency: float, temperature: float = 20.0, humidity: float = 50.0, pressure: float = 101.325) -> float:
    """Return the absorption (dB/m) at a frequency (Hz), a temperature (degrees Celsius), a relative humidity (%) and a
    pressure (kPa)."""
    kelvin, ratio = temperature + 273.15, pressure / 101.325
    warm = kelvin / 293.15
    saturated = 10.0 ** (-6.8346 * (273.16 / kelvin) ** 1.261 + 4.6151)
    h = humidity * saturated / ratio
    oxygen = ratio * (24.0 + 4.04e4 * h * (0.02 + h) / (0.391 + h))
    nitrogen = ratio * warm**-0.5 * (9.0 + 280.0 * h * math.exp(-4.170 * (warm ** (-1.0 / 3.0) - 1.0)))
    f2 = frequency * frequency
    relaxed = 0.01275 * math.exp(-2239.1 / kelvin) / (oxygen + f2 / oxygen)
    relaxed += 0.1068 * math.exp(-3352.0 / kelvin) / (nitrogen + f2 / nitrogen)
    lost: float = 8.686 * f2 * (1.84e-11 / ratio * warm**0.5 + warm**-2.5 * relaxed)
    return lost


def speed_of_sound(temperature: float = 20.0) -> float:
    """Return the speed of sound (m/s) in dry air at a temperature (degrees Celsius), by ISO 9613-1."""
    return 343.2 * math.sqrt((temperature + 273.15) / 293.15)
