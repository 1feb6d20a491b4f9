"""Pictures of sounds show every channel, and say which."""

from pathlib import Path

import numpy as np
import pytest
import soundfile

from carom.clients.plot import PlotError, plotter
from tests import needs

RATE = 48_000


@pytest.fixture
def drawn(monkeypatch):
    """Draw samples and return the axes."""
    Figure = needs.module("matplotlib.figure").Figure
    saved, save = [], Figure.savefig

    def kept(figure, *args, **keys):
        saved.append(figure)
        save(figure, *args, **keys)

    monkeypatch.setattr(Figure, "savefig", kept)

    def draw(samples: np.ndarray, folder: Path):
        soundfile.write(folder / "x.wav", samples, RATE, subtype="FLOAT")
        plotter(folder / "x.png")(folder / "x.wav")
        assert (folder / "x.png").read_bytes().startswith(b"\x89PNG")
        return saved[-1].axes

    return draw


@pytest.mark.slow
def test_each_channel_has_its_wave_and_its_spectrogram(drawn, tmp_path):
    """440 Hz left and 3 kHz right; opposite phases do not cancel."""
    time = np.arange(RATE // 2) / RATE
    both = np.stack([0.5 * np.sin(2 * np.pi * 440 * time), 0.25 * np.sin(2 * np.pi * 3_000 * time)], axis=1)
    axes = drawn(both, tmp_path)
    labels = [ax.get_ylabel().split("\n") for ax in axes[:4]]
    assert labels == [
        ["left", "amplitude"],
        ["right", "amplitude"],
        ["left", "frequency (Hz)"],
        ["right", "frequency (Hz)"],
    ]
    for channel, frequency, level in ((0, 440, -6.0), (1, 3_000, -12.0)):
        np.testing.assert_allclose(axes[channel].lines[0].get_ydata(), both[:, channel], atol=1e-7)
        (mesh,) = axes[2 + channel].collections
        levels = np.asarray(mesh.get_array())
        row, _ = np.unravel_index(levels.argmax(), levels.shape)
        assert row * RATE / 4_096 == pytest.approx(frequency, abs=RATE / 4_096)
        assert levels.max() == pytest.approx(level, abs=1.5)


@pytest.mark.slow
@pytest.mark.parametrize(("channels", "names"), [(1, ["mono"]), (3, ["channel 1", "channel 2", "channel 3"])])
def test_other_numbers_of_channels_are_named(drawn, tmp_path, channels, names):
    axes = drawn(np.zeros((5_000, channels)), tmp_path)
    assert [ax.get_ylabel().split("\n")[0] for ax in axes[: 2 * channels]] == 2 * names


def test_wrong_file_of_a_picture_is_refused_beforehand(tmp_path):
    with pytest.raises(PlotError, match=r"expected a name that ends in \.png, \.svg or \.pdf"):
        plotter(tmp_path / "x.bmp")
    with pytest.raises(PlotError, match="there is no folder"):
        plotter(tmp_path / "no" / "x.png")
