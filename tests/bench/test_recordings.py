"""The comparison with recordings: its measures on sounds whose answers are known, its reader on a file made here."""

import struct

import numpy as np
import pytest

from .recordings import RATE, Measures, about_means, centroid, difference, of_folder
from .soundfont import Recording, SoundFont

NOISE = np.random.default_rng(1).standard_normal(RATE)


def tilted(slope: float) -> Recording:
    """Return the noise, its spectrum tilted by some dB per octave."""
    frequency = np.fft.rfftfreq(len(NOISE), 1 / RATE)
    frequency[0] = frequency[1]
    return Recording("", np.fft.irfft(np.fft.rfft(NOISE) * (frequency / 1000) ** (slope / (20 * np.log10(2)))), RATE)


def test_a_gain_makes_no_difference():
    centers, slope, gap = difference(tilted(0), Recording("", 0.01 * NOISE, RATE))
    assert centers[0] == pytest.approx(125) and centers[-1] == 16_000
    assert abs(slope) < 1e-9 and gap < 1e-9


@pytest.mark.parametrize("slope", [-3.0, 5.0])
def test_a_tilt_is_the_slope(slope):
    centers, found, gap = difference(tilted(slope), tilted(0))
    octaves = np.log2(centers)
    assert found == pytest.approx(slope, abs=0.1)
    assert gap == pytest.approx(abs(slope) * np.abs(octaves - octaves.mean()).mean(), abs=0.3)


def bell(rate: int) -> Recording:
    """Return two partials that ring out, after a soft beginning."""
    time = np.arange(rate) / rate
    partials = sum(np.sin(2 * np.pi * f * time) * np.exp(-5 * time) for f in (440, 2500))
    return Recording("", partials * np.minimum(1, time / 0.01) ** 2, rate)


def test_a_sound_at_another_rate_is_the_same():
    assert difference(bell(32_000), bell(RATE))[2] < 0.1
    assert centroid(bell(32_000)) == pytest.approx(centroid(bell(RATE)), rel=0.01)
    assert centroid(bell(RATE)) == pytest.approx((440 + 2500) / 2, rel=0.05)


def test_slopes_of_one_preset_are_about_their_mean():
    """A preset that is 4 dB an octave too bright of all its recordings does not make them differ."""
    slopes = (-5.0, -3.0, -4.0), (1.0, 2.0)
    rows = [
        Measures("", preset, 1.0, 1.0, 0.0, slope, 0.0, 1, None)
        for preset, found in zip(("gong", "bell"), slopes, strict=True)
        for slope in found
    ]
    assert about_means(rows) == pytest.approx([-1.0, 1.0, 0.0, -0.5, 0.5])


def chunk(name: bytes, data: bytes) -> bytes:
    return name + struct.pack("<I", len(data)) + data + b"\0" * (len(data) % 2)


def test_a_soundfont_is_read(tmp_path):
    wave = np.array([0, 100, -200, 50, 7, 8, 9, 0], "<i2")
    header = struct.Struct("<20s5I2BhH")
    headers = [header.pack(b"Bell C4(L)", 1, 4, 0, 0, 32_000, 60, 0, 0, 4), header.pack(b"EOS", *[0] * 9)]
    lists = chunk(b"LIST", b"INFO" + chunk(b"INAM", b"odd")) + chunk(b"LIST", b"sdta" + chunk(b"smpl", wave.tobytes()))
    lists += chunk(b"LIST", b"pdta" + chunk(b"shdr", b"".join(headers)))
    path = tmp_path / "a.sf2"
    path.write_bytes(chunk(b"RIFF", b"sfbk" + lists))
    font = SoundFont(path)
    assert font.names() == ["Bell C4(L)", "EOS"]
    assert font.recording("Bell C4").rate == 32_000
    assert font.recording("Bell C4").samples == pytest.approx([0.5, -1.0, 0.25])
    with pytest.raises(ValueError, match="sample = 'Gong'"):
        font.recording("Gong")
    path.write_bytes(b"RIFF____WAVE")
    with pytest.raises(ValueError, match="expected a SoundFont 2"):
        SoundFont(path)


def test_a_recording_that_no_preset_names_is_named(tmp_path):
    (tmp_path / "zither.wav").touch()
    with pytest.raises(SystemExit, match=r"zither\.wav"):
        of_folder(tmp_path)
