"""Junk by the thousand, seeded, on a real server: it stays up, quick and no larger, and plays on."""

import numpy as np
import pytest
import soundfile

from carom.dsp.engine.memory.state import TRACE, TRACED
from carom.presets.making import KEPT_BYTES
from carom.server.osc import wire
from tests.bench import crowd
from tests.bench.fuzz import KNOWN, Junk, fuzz, still_plays
from tests.support import serving


@pytest.mark.slow
def test_junk_does_no_harm(tmp_path):
    with serving(tmp_path, "--device", "none", "--record", "out.wav") as server:
        found = fuzz(server.process, server.port, 10_000, 7)
        assert found.streams > 50
        times = sorted(found.answers)
        assert found.hangs < len(times) // 100  # a batch may hold several objects to be made
        assert times[len(times) * 9 // 10] < 0.05 and times[-1] < 2.0  # others are at work on the machine, too
        if found.memory:  # modes that were made are kept; contacts are recorded once a client asks to be told of them
            assert found.memory[-1] - found.memory[1] < 30e6 + KEPT_BYTES + TRACED * TRACE.itemsize
        assert still_plays(server.port)
        assert server.quit() == (0, "")
    sound, _ = soundfile.read(tmp_path / "out.wav")
    assert np.isfinite(sound).all()  # the junk may have switched the limiter off
    assert np.abs(sound[-4800:]).max() > 1e-3


@pytest.mark.slow
def test_the_junk_is_neither_all_valid_nor_all_noise():
    packets, again = ([junk.packet() for _ in range(4000)] for junk in (Junk(1, 1.8e9), Junk(1, 1.8e9)))
    assert packets == again
    well = 0
    for packet in packets:
        try:
            well += bool(wire.parse(packet))
        except wire.BadPacket:
            continue
    assert 0.2 < well / len(packets) < 0.7
    assert set(KNOWN) & set(packets)


@pytest.mark.slow
def test_no_packet_holds_up_a_crowded_server(tmp_path):
    with serving(tmp_path, "--device", "none") as server:
        found = crowd.fuzz(server.process, server.port, 150, 3)
        assert sorted(found.answers)[-3] < crowd.LATE  # others are at work on the machine, too
        assert server.quit() == (0, "")
