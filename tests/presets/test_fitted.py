"""The presets that fits become: played, struck elsewhere, faster and by others, they stay plausible."""

import numpy as np
import pytest

import carom
from carom.clients.fitting import Wanted, make

RATE = 32_000
FREQUENCY = np.array([311.0, 857.0, 1680.0, 2777.0, 4149.0, 5796.0, 7718.0])
T60 = np.array([1.2, 0.9, 0.6, 0.45, 0.3, 0.2, 0.15])
POSITIONS = (0.1, 0.3, 0.5)


def gains(position: float) -> np.ndarray:
    """Return the gains of the modes of a supported bar, as loud as each other."""
    return np.sin(np.pi * np.arange(1, 8) * position) * 0.1


def recording(path, gain: np.ndarray, seed: int = 1) -> None:
    import soundfile

    t = np.arange(round(1.0 * RATE)) / RATE
    tones = np.exp(np.outer(t, -np.log(1000) / T60)) * np.cos(2 * np.pi * np.outer(t, FREQUENCY))
    sound = np.concatenate([np.zeros(RATE // 10), tones @ gain])
    sound += 1e-5 * np.random.default_rng(seed).standard_normal(len(sound))
    soundfile.write(path, sound, RATE, subtype="FLOAT")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder of presets: `bar`, fitted to three recordings at three positions, and its striker."""
    folder = tmp_path_factory.mktemp("fitted")
    for number, position in enumerate(POSITIONS):
        recording(folder / f"{number}.wav", gains(position), number)
    wanted = Wanted("bar", modes=10, positions=POSITIONS, source="made here", licence='CC0 "quoted"')
    make([folder / f"{number}.wav" for number in range(3)], folder / "presets", wanted)
    return folder / "presets"


def played(folder, velocity=1.0, **keys) -> np.ndarray:
    with carom.Scene(RATE, presets=folder, limiter=False) as scene:
        scene.new("a", "bar", stereo_width=0).impact(velocity, **keys)
        return scene.render(1.0).samples[:, 0].astype(float)


def levels(sound: np.ndarray) -> np.ndarray:
    """Return the amplitudes of the bar's modes in a sound."""
    t = np.arange(len(sound)) / RATE
    basis = np.exp(-np.outer(t, np.log(1000) / T60)) * np.exp(-2j * np.pi * np.outer(t, FREQUENCY))
    return np.abs(sound[200:] @ basis[200:]) / np.sum(np.abs(basis[200:]) ** 2, axis=0)


def centroid(sound: np.ndarray) -> float:
    power = np.abs(np.fft.rfft(sound)) ** 2
    return float(power @ np.fft.rfftfreq(len(sound), 1 / RATE) / power.sum())


@pytest.mark.slow
def test_the_preset_says_where_it_is_from(folder):
    text = (folder / "objects" / "bar.toml").read_text()
    assert 'licence = "CC0 \\"quoted\\""' in text and "made here" in text and "0.wav" in text
    assert sorted(path.name for path in folder.rglob("*")) == ["bar-striker.toml", "bar.toml", "objects", "strikers"]


@pytest.mark.slow
def test_modes_are_those_of_the_recordings(folder):
    modes = carom.Presets(folder).object("bar").modes(15_000)
    for frequency, t60 in zip(FREQUENCY, T60, strict=True):
        near = np.abs(modes.frequency - frequency) < 2
        loud = np.argmax(np.where(near, np.abs(modes.pressure[0] * modes.strike).max(axis=0), 0))
        assert modes.frequency[loud] == pytest.approx(frequency, abs=0.02)
        assert np.log(1000) / modes.decay[loud] == pytest.approx(t60, rel=0.02)
    assert np.all(modes.decay > 0) and np.all(np.isfinite(modes.strike)) and modes.mass > 0
    # No mode radiates more power than it loses: R = 4 pi G^2/(rho c) <= 2 sigma.
    assert np.all(4 * np.pi * modes.pressure[0] ** 2 / 411.6 <= 4 * modes.decay * 1.001)


@pytest.mark.slow
def test_each_position_sounds_as_it_was_recorded(folder):
    for position in POSITIONS:
        found, expected = levels(played(folder, position=position)), np.abs(gains(position))
        found = found / found.max() * expected.max()
        heard = expected > 0.1 * expected.max()
        assert 20 * np.log10(found[heard] / expected[heard]) == pytest.approx(np.zeros(heard.sum()), abs=1.5)
        assert np.all(found[~heard] < 0.15 * expected.max())


@pytest.mark.slow
def test_other_strikers_and_speeds_change_it_as_they_should(folder):
    soft, own, hard = (played(folder, position=0.1, striker=by) for by in ("felt", "bar-striker", "steel"))
    assert centroid(soft) < centroid(own) and centroid(soft) < centroid(hard)
    slow, fast = played(folder, 0.5, position=0.1, striker="yarn"), played(folder, 1.0, position=0.1, striker="yarn")
    assert centroid(fast) > centroid(slow) and np.sum(fast**2) > 2 * np.sum(slow**2)
    for sound in (soft, own, hard, slow, fast):
        blocks = np.sum(sound[: len(sound) // 3200 * 3200].reshape(-1, 3200) ** 2, axis=1)[1:]
        assert np.all(np.isfinite(sound)) and np.all(np.diff(blocks) <= 0.02 * blocks[0])  # nothing grows


@pytest.mark.slow
def test_a_striker_gives_no_more_energy_than_it_brings(folder):
    presets = carom.Presets(folder)
    modes = presets.object("bar").modes(15_000)
    for name in ("bar-striker", "steel", "felt"):
        with carom.Scene(RATE, presets=folder, limiter=False, contacts=True) as scene:
            scene.new("a", "bar").impact(2.0, position=0.1, striker=name)
            contacts = scene.render(0.5).contacts
        mass = presets.striker(name).mass
        impulse = sum(contact.impulse for contact in contacts)
        assert 0 < impulse <= 2 * mass * 2.0 * 1.001
        assert 0.5 * impulse**2 / mass <= 4 * 0.5 * mass * 2.0**2 * 1.001
    assert modes.frequency.size > 7
