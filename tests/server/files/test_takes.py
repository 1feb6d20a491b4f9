"""/record: new files in one folder alone, of frames that the log names, within a quota."""

import re
import threading
import time

import numpy as np
import pytest
import soundfile

from carom.clients.actions import CommandError
from carom.dsp.runtime.engine import Engine
from carom.server.audio.tap import Part, Tap
from carom.server.files.floatwav import header
from carom.server.files.takes import Takes
from carom.server.osc.arguments import Refused
from tests.attack import full_disc
from tests.dsp.engine.support import bell, strike
from tests.server.support import counted
from tests.support import serving

HEADER = len(header(48_000, 0, 2))


def until(ready, seconds=10.0):
    """Return what `ready` gives, once it gives something."""
    deadline = time.monotonic() + seconds
    while not (there := ready()):
        assert time.monotonic() < deadline
        time.sleep(0.005)
    return there


@pytest.fixture
def playing():
    """An engine that plays, its tap, and all that it has played."""
    engine = Engine(48_000)
    handle = engine.add(bell(), 1e-3)
    tap = Tap(engine)
    sound = []

    def play(frames):
        strike(engine, handle)
        sound.append(engine.process(frames))

    yield engine, tap, sound, play
    tap.close()


def recorded(path):
    return soundfile.read(path, dtype="float32", always_2d=True)[0]


def test_a_take_has_the_frames_that_it_says(tmp_path, playing):
    engine, tap, sound, play = playing
    takes = Takes(engine, tap, tmp_path / "new" / "takes", 10**9)
    play(6_400)
    first = takes.start("one")
    assert first.file == takes.state == "one.wav" and first.first == engine.position
    for _ in range(5):
        play(3_200)
        time.sleep(0.015)
    end = takes.stop()
    assert end.end == engine.position
    play(6_400)
    take, reason = until(takes.look)
    assert reason == "" and take == end and takes.state == "no"
    expected = np.concatenate(sound)[take.first : take.end]
    np.testing.assert_array_equal(recorded(tmp_path / "new" / "takes" / "one.wav"), expected)


def test_frames_that_the_tap_lost_are_silent(playing):
    engine, tap, _, _ = playing
    part = Part(engine, tap, 10**6)
    first = part.first
    part(first, np.ones((64, 2), np.float32))
    part(first + 192, np.ones((64, 2), np.float32))
    assert part.take()[:, 0].tolist() == [1.0] * 64 + [0.0] * 128 + [1.0] * 64


def test_parts_that_begin_and_end_while_another_thread_plays_miss_nothing(playing):
    engine, tap, sound, play = playing
    over = threading.Event()

    def go():
        while not over.is_set():
            play(64)
            time.sleep(0.0005)

    thread = threading.Thread(target=go)
    thread.start()
    parts = []
    for _ in range(40):
        part = Part(engine, tap, 10**6)
        time.sleep(0.003)
        end = part.stop()
        until(lambda part=part: part.is_whole)
        parts.append((part.first, end, part.take()))
        part.close()
    over.set()
    thread.join()
    whole = np.concatenate(sound)
    for first, end, kept in parts:
        np.testing.assert_array_equal(kept, whole[first:end])
    assert sum(len(kept) for _, _, kept in parts) > 0 and not tap._sinks


def test_a_take_ends_where_the_quota_does(tmp_path, playing):
    engine, tap, _, play = playing
    (tmp_path / "old.wav").write_bytes(bytes(10_000))
    (tmp_path / "tiny").write_bytes(b"1")  # counts as a page
    takes = Takes(engine, tap, tmp_path, 10_000 + 4_096 + HEADER + 8 * 1_000 + 7)
    takes.start("one")
    play(6_400)
    take, reason = until(takes.look)
    assert take.end - take.first == 1_000 == len(recorded(tmp_path / "one.wav")) and "quota" in reason
    assert takes.state == reason and takes.look() is None
    with pytest.raises(Refused, match=r"quota: \d+ bytes are used up"):
        takes.start("two")
    assert not (tmp_path / "two.wav").exists()


@pytest.mark.parametrize(
    "name", ["../up", "/tmp/elsewhere", "a/b", "a\\b", ".hidden", "..", "x\0y", "x\n", "C:x", "", " x", "x.", "y" * 101]
)
def test_no_name_leads_elsewhere(tmp_path, playing, name):
    engine, tap, _, _ = playing
    takes = Takes(engine, tap, tmp_path / "takes", 10**9)
    if name:
        with pytest.raises(Refused, match="name = "):
            takes.start(name)
    else:
        assert re.fullmatch(r"carom-\d{8}-\d{6}\.wav", takes.start(name).file)
        takes.close()
        assert takes.start(name).file
        takes.close()
    assert list(tmp_path.iterdir()) == [tmp_path / "takes"]
    assert len(list((tmp_path / "takes").iterdir())) == (0 if name else 2)


def test_recordings_overwrite_no_file_and_follow_no_link(tmp_path, playing):
    engine, tap, _, _ = playing
    takes = Takes(engine, tap, tmp_path, 10**9)
    (tmp_path / "old.wav").write_bytes(b"kept")
    (tmp_path / "link.wav").symlink_to(tmp_path / "target.wav")
    for name in ("old", "old.wav", "link"):
        with pytest.raises(Refused, match="there is such a file already"):
            takes.start(name)
    assert (tmp_path / "old.wav").read_bytes() == b"kept" and not (tmp_path / "target.wav").exists()
    takes.start("Tag-1 é.wav")
    with pytest.raises(Refused, match="is being recorded"):
        takes.start("other")
    takes.stop()
    with pytest.raises(Refused, match="nothing is being recorded"):
        takes.stop()
    takes.close()
    assert not tap._sinks and (tmp_path / "Tag-1 é.wav").exists()


@pytest.mark.slow
def test_a_server_records_what_clients_ask_for(tmp_path):
    options = ("--device", "none", "--recordings", "takes", "--record", "all.wav", "--log", "log.txt")
    with serving(tmp_path, *options) as server:
        with server.client() as client:
            client.new("bell", "church-bell")
            client.impact("bell", 1.0)
            began = client.ask("/record", 1, "name", "one").args
            assert counted(client.status())["take"] == "one.wav"
            time.sleep(0.2)
            ended = client.ask("/record", 0).args
            with pytest.raises(CommandError, match="there is such a file"):
                client.ask("/record", 1, "name", "one")
            last = client.ask("/record", 1).args
        assert server.quit() == (0, "")
    assert began == ("/record", "one.wav", ended[2]) and ended[1] == "one.wav"
    whole = recorded(tmp_path / "all.wav")
    np.testing.assert_array_equal(recorded(tmp_path / "takes" / "one.wav"), whole[ended[2] : ended[3]])
    np.testing.assert_array_equal(recorded(tmp_path / "takes" / last[1]), whole[last[2] :])  # up to the end
    remarks = re.findall(r"^# (\S+) (/record \d): (\S+) .* at frame (\d+)$", (tmp_path / "log.txt").read_text(), re.M)
    assert [(what, name, int(frame)) for _, what, name, frame in remarks[:2]] == [
        ("/record 1", "one.wav", ended[2]), ("/record 0", "one.wav", ended[3]),
    ]  # fmt: skip
    assert all(float(seconds) == int(frame) / 48_000 for seconds, _, _, frame in remarks)


@pytest.mark.slow
def test_a_server_without_a_folder_records_nothing(tmp_path):
    with (
        serving(tmp_path, "--device", "none") as server,
        server.client() as client,
        pytest.raises(CommandError, match="expected it to be started with --recordings"),
    ):
        client.ask("/record", 1)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_a_take_on_a_full_disc_is_refused(tmp_path):
    """Where a header fits still, and nothing else; what has room for a while is kept as far as it came."""
    for size in (200, 20_000, 400_000):
        folder = tmp_path / str(size)
        folder.mkdir()
        assert full_disc.one(folder, size, 2) == (2, [])
