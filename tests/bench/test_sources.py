"""Further sampled instruments: what is not there is left out, and each pair is one that can be made."""

import carom

from . import sources
from .sources import SOURCES, further


def test_what_is_not_there_is_left_out(tmp_path, monkeypatch):
    monkeypatch.setattr(sources, "ROOT", tmp_path)
    assert list(further()) == []


def test_each_pair_names_a_preset_and_keys_that_it_has():
    presets = carom.Presets()
    for source in SOURCES:
        assert source.licence and source.pairs
        for _, preset, changes in source.pairs:
            presets.changed(preset, [each for each in changes.items() if each[0] != "tune"])
