"""Float WAV files: headers by the standard, that every reader takes, at any time and of any size."""

import errno
import os
import shutil
import struct
import subprocess
import warnings
import wave
from pathlib import Path

import numpy as np
import pytest
import scipy.io.wavfile
import soundfile

from carom.dsp.runtime.engine import Engine
from carom.presets.library import Presets
from carom.server.files.floatwav import FloatWav, header
from carom.server.files.recorder import Recorder
from carom.server.osc.score import read
from carom.server.render import Options, render

FRAMES = np.random.default_rng(1).normal(0.0, 0.1, (1_000, 2)).astype("f4")


def opened(path: Path) -> int:
    """Return the descriptor of a new file of bytes."""
    return os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0))


def written(path: Path, *parts: np.ndarray) -> Path:
    descriptor = opened(path)
    with FloatWav(descriptor, 44_100, 2) as file:
        for part in parts:
            file.write(part)
    os.close(descriptor)
    return path


def chunks(path: Path) -> dict[bytes, bytes]:
    """Return the chunks of a RIFF file by their names; the sizes must lead exactly to its end."""
    data = path.read_bytes()
    assert data[:4] == b"RIFF" and data[8:12] == b"WAVE"
    assert int.from_bytes(data[4:8], "little") == len(data) - 8
    found, at = {}, 12
    while at < len(data):
        name, size = struct.unpack_from("<4sI", data, at)
        found[name] = data[at + 8 : at + 8 + size]
        at += 8 + size + size % 2
    assert at == len(data)
    return found


def assert_header_is_whole(path: Path) -> None:
    """Assert that formats but PCM have a format chunk of 18 bytes, the last two the size of what follows, and a fact
    chunk."""
    found = chunks(path)
    assert struct.unpack("<HHIIHHH", found[b"fmt "]) == (3, 2, 44_100, 44_100 * 8, 8, 32, 0)
    assert struct.unpack("<I", found[b"fact"]) == (len(found[b"data"]) // 8,)
    assert list(found)[-1] == b"data"


def assert_readers_are_content(path: Path) -> None:
    """Assert that sox and scipy read it and warn of nothing."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rate, samples = scipy.io.wavfile.read(path)
    assert rate == 44_100 and samples.dtype == np.float32
    for command in (["sox", "--i", str(path)], ["sox", str(path), "-n"]):
        if shutil.which("sox"):
            run = subprocess.run(command, capture_output=True, text=True)
            assert (run.returncode, run.stderr) == (0, "")


def test_frames_come_back_bit_for_bit(tmp_path):
    path = written(tmp_path / "x.wav", FRAMES[:300], FRAMES[:0], FRAMES[300:])
    samples, rate = soundfile.read(path, dtype="float32")
    np.testing.assert_array_equal(samples, FRAMES)
    info = soundfile.info(path)
    assert (rate, info.format, info.subtype) == (44_100, "WAV", "FLOAT")
    assert_header_is_whole(path)
    assert_readers_are_content(path)


def test_an_empty_file_is_a_sound_file(tmp_path):
    assert soundfile.info(written(tmp_path / "x.wav")).frames == 0
    assert_header_is_whole(tmp_path / "x.wav")


def test_renders_and_recordings_have_such_headers(tmp_path):
    (tmp_path / "s.txt").write_text("0 /object/new a wood-block\n0.01 /object/a/impact 1\n")
    render(read(tmp_path / "s.txt"), tmp_path / "render.wav", Presets(), Options(rate=44_100, seconds=0.1))
    engine = Engine(44_100)
    recorder = Recorder(engine, tmp_path / "record.wav")
    recorder.start()
    engine.process(4_416)
    recorder.close()
    for name in ("render.wav", "record.wav"):
        assert_header_is_whole(tmp_path / name)
        assert_readers_are_content(tmp_path / name)
        assert soundfile.info(tmp_path / name).frames in (4_410, 4_416)


@pytest.mark.parametrize("format", ["16", "24"])
def test_pcm_renders_are_plain_wav(tmp_path, format):
    """Python's own module reads them; it knows no float."""
    (tmp_path / "s.txt").write_text("0 /object/new a wood-block\n0.01 /object/a/impact 1\n")
    out = tmp_path / "x.wav"
    render(read(tmp_path / "s.txt"), out, Presets(), Options(rate=44_100, format=format, seconds=0.1))
    with wave.open(str(out)) as file:
        assert (file.getnframes(), file.getnchannels(), 8 * file.getsampwidth()) == (4_410, 2, int(format))
    if shutil.which("sox"):
        assert subprocess.run(["sox", str(out), "-n"], capture_output=True).stderr == b""


def test_a_file_can_be_read_while_it_grows(tmp_path):
    descriptor = opened(tmp_path / "x.wav")
    file = FloatWav(descriptor, 44_100, 2)
    for count in range(3):
        assert soundfile.info(tmp_path / "x.wav").frames == 1_000 * count
        assert_header_is_whole(tmp_path / "x.wav")
        file.write(FRAMES)
    os.close(descriptor)


@pytest.mark.parametrize("frames", [(2**32 - 100) // 8, 2**29, 2**33])
def test_a_header_counts_any_number_of_frames(tmp_path, frames):
    path = tmp_path / "x.wav"
    path.write_bytes(header(48_000, frames, 2))
    os.truncate(path, path.stat().st_size + 8 * frames)  # a hole, which takes no room
    info = soundfile.info(path)
    assert (info.frames, info.samplerate, info.subtype) == (frames, 48_000, "FLOAT")
    with path.open("rb") as file:
        start = file.read(16)
    assert (start[:4], start[12:]) == ((b"RIFF", b"JUNK") if 8 * frames < 2**32 - 94 else (b"RF64", b"ds64"))


def test_a_disk_that_fills_up_leaves_the_file_whole(tmp_path, monkeypatch):
    path = tmp_path / "x.wav"
    descriptor = opened(path)
    file = FloatWav(descriptor, 44_100, 2)
    file.write(FRAMES)
    room = 3_000

    def write(descriptor: int, data: bytes) -> int:
        nonlocal room
        if room == 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        taken = real(descriptor, data[:room])
        room -= taken
        return taken

    real = os.write
    monkeypatch.setattr(os, "write", write)
    with pytest.raises(OSError, match="No space left"):
        file.write(FRAMES)
    monkeypatch.undo()
    np.testing.assert_array_equal(soundfile.read(path, dtype="float32")[0], FRAMES)
    file.write(FRAMES[:5])  # there is room again
    os.close(descriptor)
    assert soundfile.info(path).frames == 1_005
    assert_header_is_whole(path)


def test_a_header_keeps_its_size():
    for channels in (1, 2, 3, 64):
        assert len(header(48_000, 0, channels)) == len(header(48_000, 2**40, channels))


@pytest.mark.parametrize("channels", [1, 3, 8, 64])
def test_any_number_of_channels_comes_back(tmp_path, channels):
    """More than two have no places of loudspeakers, which the extensible format says."""
    frames = np.random.default_rng(channels).normal(0.0, 0.1, (500, channels)).astype("f4")
    descriptor = opened(tmp_path / "x.wav")
    with FloatWav(descriptor, 44_100, channels) as file:
        file.write(frames[:100])
        file.write(frames[100:])
    os.close(descriptor)
    heard, rate = soundfile.read(tmp_path / "x.wav", dtype="float32", always_2d=True)
    np.testing.assert_array_equal(heard, frames)
    format = chunks(tmp_path / "x.wav")[b"fmt "]
    tag, count, hertz, per_second, frame, bits, more = struct.unpack("<HHIIHHH", format[:18])
    assert (rate, hertz, count, frame, bits) == (44_100, 44_100, channels, 4 * channels, 32)
    assert per_second == 44_100 * frame and more == len(format) - 18
    if channels > 2:
        valid, places, guid = struct.unpack("<HI16s", format[18:])
        assert (tag, valid, places, guid[:2]) == (0xFFFE, 32, 0, b"\3\0")
    else:
        assert tag == 3
