"""Further sampled instruments: what is not there is left out, and each pair is one that can be made."""

import numpy as np
import soundfile

import carom

from . import sources
from .held import CELLO, HELD
from .recordings import strike
from .sources import SOURCES, Folder, further


def test_missing_sources_are_left_out(tmp_path, monkeypatch):
    monkeypatch.setattr(sources, "ROOT", tmp_path)
    assert list(further()) == []


def test_each_pair_names_a_preset_and_keys_that_it_has():
    presets = carom.Presets()
    for source in (*SOURCES, *HELD, CELLO):
        assert source.licence and source.pairs
        for _, preset, changes in source.pairs:
            presets.changed(preset, [each for each in changes.items() if each[0] not in ("tune", "velocity")])


def test_a_pair_may_say_how_fast_it_is_struck():
    soft, hard = (strike("wood-block", {"velocity": speed}, 0.2).samples for speed in (0.5, 2.0))
    assert 3 * abs(soft).max() < abs(hard).max()


def test_a_folder_s_sounds_are_as_high_as_1_and_end_in_time(tmp_path):
    soundfile.write(tmp_path / "a.wav", np.full((8_000, 2), 0.25), 1_000)
    found = Folder(tmp_path).recording("a.wav")
    assert found.rate == 1_000 and len(found.samples) == 1_000 * Folder.LONGEST and found.samples.max() == 1.0
