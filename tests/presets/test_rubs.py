"""Objects that are rubbed round their rims sing: the lowest pair of modes, and little else, as recorded ones do."""

import numpy as np
import pytest

import carom

WITHIN = 0.03  # of a partial's frequency: how far its power is counted
HARMONICS = -37.0  # dB over the note, at most: a recorded glass has -37, -47 and -54 dB
RATE = 48_000


@pytest.mark.slow
@pytest.mark.parametrize("rate", [44_100, 96_000])
@pytest.mark.parametrize(
    ("name", "before", "given"),
    [
        ("wine-glass", 2.0, {}),
        ("wine-glass", 4.0, {"force": 0.5, "speed": 0.1}),
        ("wine-glass", 2.0, {"force": 1.0, "speed": 0.2, "travel": 0.0}),
        ("singing-bowl", 8.0, {}),
        ("singing-bowl", 8.0, {"force": 5.0, "speed": 0.08}),
    ],
)
def test_rubbed_rims_sing_their_lowest_note(rate, name, before, given):
    with carom.Scene(rate, limiter=False) as scene:
        body = scene.new("a", name)
        body.slide(**given)
        sound = scene.render(before + 1.0).samples[round(before * rate) :, 0].astype(float)
    lowest = note_of(name)
    power = np.abs(np.fft.rfft(sound * np.hanning(len(sound)))) ** 2
    frequency = np.fft.rfftfreq(len(sound), 1 / rate)
    note, *harmonics = (power[np.abs(frequency / (n * lowest) - 1) < WITHIN].sum() for n in range(1, 6))
    assert note > 0.97 * power.sum()
    assert 10 * np.log10(max(harmonics) / note) < HARMONICS
    assert np.sqrt(np.mean(sound**2)) > 1e-3


def note_of(name: str) -> float:
    """Return the mean frequency (Hz) of an object's lowest pair of modes."""
    return float(np.mean(carom.Presets().object(name).modes(20_000).frequency[:2]))


def amplitude(seconds: float, split: float | None = None, **given: float) -> np.ndarray:
    """Return the amplitude of a rubbed wine glass's note on both sides, (samples, 2)."""
    with carom.Scene(RATE, limiter=False) as scene:
        scene.new("a", "wine-glass", **({} if split is None else {"split": split})).slide(seed=1, **given)
        sound = scene.render(seconds).samples.astype(float)
    far = np.abs(np.fft.fftfreq(len(sound), 1 / RATE) - note_of("wine-glass")) > 60.0
    spectrum = np.fft.fft(sound, axis=0)
    spectrum[far] = 0.0
    return np.abs(np.fft.ifft(spectrum, axis=0))


def envelope(seconds: float, last: float, split: float | None = None, **given: float) -> np.ndarray:
    """Return the amplitude on the left over the last seconds, over its mean."""
    course = amplitude(seconds, split, **given)[-round((last + 0.1) * RATE) : -round(0.1 * RATE), 0]
    return course / course.mean()


@pytest.mark.slow
@pytest.mark.parametrize("speed", [0.22, 0.3])
def test_a_glass_grows_half_as_fast_under_a_finger_that_passes_its_pattern(speed):
    """Both waves grow by g/2 - sigma where g/2 < 2 w, with g = N |mu'(v)| (along phi)^2/2: rigid friction, a round
    glass."""
    force, half_rim = 2.0, np.pi * 0.035
    modes, striker = carom.Presets().object("wine-glass").modes(20_000), carom.Presets().striker("wet-finger").sliding
    phi = striker["along"] * np.hypot(*modes.along[0, :2])
    fall = (striker["static"] - striker["dynamic"]) / striker["stribeck"] / (1.0 + speed / striker["stribeck"]) ** 2
    growth = force * fall * phi**2 / 2.0
    assert growth / 2.0 < 2.0 * speed / 0.035
    sound = amplitude(3.0, split=0.0, tangential=0.0, speed=speed, force=force, travel=half_rim)
    level = np.log(np.hypot(*sound.T))[round(0.5 * RATE) :]
    first, last = (int(np.argmax(level > level.max() - below)) for below in (4.5, 1.5))
    found = np.polyfit(np.arange(first, last) / RATE, level[first:last], 1)[0]
    assert found == pytest.approx(growth / 2.0 - modes.decay[:2].mean(), rel=0.05)


@pytest.mark.slow
def test_a_glass_pulsates_as_the_finger_goes_round_it():
    goes, stays = (np.percentile(envelope(5.0, 2.0, **keys), [5.0, 95.0]) for keys in ({}, {"travel": 0.0}))
    assert goes[1] > 4.0 * goes[0]
    assert stays[1] < 1.1 * stays[0]


@pytest.mark.slow
@pytest.mark.parametrize("speed", [0.05, 0.08])
def test_the_pattern_of_a_round_glass_turns_with_a_slow_finger(speed):
    """The lowest modes are cos 2 theta and sin 2 theta. Rubbed at theta = w t they follow it where they grow fast: the
    eigenvalues of their waves round the rim, seen from the finger, are g/2 +- sqrt(g^2/4 - (2 w)^2). Then the sound on
    one side comes and goes four times a turn."""
    course = envelope(8.0, 6.0, split=0.0, tangential=0.0, speed=speed, travel=np.pi * 0.035)
    size = 1 << 20
    spectrum = np.abs(np.fft.rfft((course - 1.0) * np.hanning(len(course)), size))
    beats = spectrum[: round(10.0 * size / RATE)].argmax() * RATE / size
    assert beats == pytest.approx(4.0 * speed / (2.0 * np.pi * 0.035), abs=0.1)
