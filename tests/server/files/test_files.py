"""Recordings and logs: older ones are left until new ones begin, and what is written is whole."""

import os

import pytest
import soundfile

from carom.dsp.runtime.engine import Engine
from carom.server.files.log import Log
from carom.server.files.outfile import OutFile
from carom.server.files.recorder import Recorder


@pytest.mark.parametrize("kind", [Log, Recorder])
def test_an_older_file_is_left_until_a_new_one_begins(tmp_path, kind):
    older = tmp_path / "older"
    older.write_bytes(b"~" * 9_999)
    kind(Engine(48_000), older).close()
    kind(Engine(48_000), tmp_path / "newer").close()
    assert older.read_bytes() == b"~" * 9_999 and not (tmp_path / "newer").exists()
    for path in (older, tmp_path / "newer"):
        keeper = kind(Engine(48_000), path)
        keeper.start()
        keeper.close()
        assert b"~" not in path.read_bytes() and 0 < path.stat().st_size < 1_000


def test_a_recording_has_every_sample_and_room_to_grow_beyond_4_gib(tmp_path):
    engine = Engine(48_000)
    recorder = Recorder(engine, tmp_path / "out.wav")
    engine.process(100)
    recorder.start()
    engine.process(6_300)
    recorder.close()
    info = soundfile.info(tmp_path / "out.wav")
    assert (info.frames, info.samplerate, info.format, info.subtype) == (6_400, 48_000, "WAV", "FLOAT")
    assert b"JUNK" in (tmp_path / "out.wav").read_bytes()[:40]  # where RF64 has its sizes
    with pytest.raises(OSError):
        os.fstat(recorder._out.descriptor)


def test_bytes_that_the_system_takes_in_pieces_are_written_whole(tmp_path, monkeypatch):
    write = os.write
    monkeypatch.setattr(os, "write", lambda descriptor, data: write(descriptor, data[:3]))
    file = OutFile(tmp_path / "out")
    file.begin()
    file.write(b"0123456789")
    file.close()
    assert (tmp_path / "out").read_bytes() == b"0123456789"


@pytest.mark.parametrize("kind", [Log, Recorder])
def test_a_link_that_leads_nowhere_is_kept(tmp_path, kind):
    link = tmp_path / "link"
    link.symlink_to(tmp_path / "target")
    kind(Engine(48_000), link).close()
    assert link.is_symlink() and not (tmp_path / "target").exists()


def test_a_file_that_is_removed_is_written_no_more(tmp_path):
    engine = Engine(48_000)
    log, recorder = Log(engine, tmp_path / "log"), Recorder(engine, tmp_path / "out.wav")
    for keeper, name in ((log, "log"), (recorder, "out.wav")):
        keeper.start()
        (tmp_path / name).unlink()
    log.write()
    engine.process(64)
    recorder.close()
    assert log.error and recorder.error and "removed" in log.error and "removed" in recorder.error
    log.close()


@pytest.mark.parametrize("kind", [Log, Recorder])
def test_a_file_that_is_closed_twice_leaves_others_open(tmp_path, kind):
    keeper = kind(Engine(48_000), tmp_path / "out")
    keeper.start()
    keeper.close()
    kept = (tmp_path / "out").read_bytes()
    other = os.open(
        tmp_path / "other", os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0)
    )  # gets the number that has become free
    keeper.close()
    os.fstat(other)
    os.close(other)
    assert not keeper.error and (tmp_path / "out").read_bytes() == kept
