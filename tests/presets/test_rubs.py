"""Objects that are rubbed round their rims sing: the lowest pair of modes, and little else, as recorded ones do."""

import numpy as np
import pytest

import carom

WITHIN = 0.03  # of a partial's frequency: how far its power is counted
HARMONICS = -25.0  # dB under the note, at most; recorded glasses have some -37


@pytest.mark.slow
@pytest.mark.parametrize("rate", [44_100, 96_000])
@pytest.mark.parametrize(
    ("name", "before", "force", "speed"),
    [
        ("wine-glass", 2.0, None, None),
        ("wine-glass", 4.0, 0.5, 0.1),
        ("wine-glass", 2.0, 1.0, 0.2),
        ("singing-bowl", 8.0, None, None),
        ("singing-bowl", 8.0, 5.0, 0.08),
    ],
)
def test_what_is_rubbed_round_its_rim_sings_its_lowest_note(rate, name, before, force, speed):
    given = {key: value for key, value in (("force", force), ("speed", speed)) if value is not None}
    with carom.Scene(rate, limiter=False) as scene:
        body = scene.new("a", name)
        body.slide(**given)
        sound = scene.render(before + 1.0).samples[round(before * rate) :, 0].astype(float)
    lowest = float(np.mean(carom.Presets().object(name).modes(20_000).frequency[:2]))
    power = np.abs(np.fft.rfft(sound * np.hanning(len(sound)))) ** 2
    frequency = np.fft.rfftfreq(len(sound), 1 / rate)
    note, *harmonics = (power[np.abs(frequency / (n * lowest) - 1) < WITHIN].sum() for n in range(1, 6))
    assert note > 0.97 * power.sum()
    assert 10 * np.log10(max(harmonics) / note) < HARMONICS
    assert np.sqrt(np.mean(sound**2)) > 1e-3
