"""MIDI files: rendered as the score that says the same, and refused where that cannot be."""

import subprocess
from pathlib import Path

import pytest

from tests import needs
from tests.support import CAROM

mido = needs.module("mido")

from carom.clients.streams import playing, read_score  # noqa: E402
from carom.server.osc.score import ScoreError  # noqa: E402

BEAT = 480  # ticks; at 120 a minute half a second


def song(path: Path, channel: int = 0, pedal: bool = False) -> Path:
    """Write two notes of a beat each on a channel, the second one with the sustain pedal up."""
    made = mido.MidiFile(ticks_per_beat=BEAT)
    track = mido.MidiTrack()
    made.tracks.append(track)
    if pedal:
        track.append(mido.Message("control_change", channel=channel, control=64, value=0, time=0))
    for note, velocity in ((60, 100), (67, 50)):
        track.append(mido.Message("note_on", channel=channel, note=note, velocity=velocity, time=0))
        track.append(mido.Message("note_off", channel=channel, note=note, velocity=0, time=BEAT))
    made.save(path)
    return path


def said(path: Path, *objects: str) -> list[tuple[object, ...]]:
    """Return the times, addresses and arguments of a MIDI file's score."""
    lines = read_score(str(path), playing(objects))
    return [(round(line.time, 6), line.message.address, *line.message.args) for line in lines]


def test_notes_strike_the_object_at_their_times(tmp_path):
    assert said(song(tmp_path / "song.mid"), "marimba-bar") == [
        (0.0, "/object/new", "keys", "marimba-bar"),
        (0.0, "/object/keys/note", 60, 100, "play", 1),
        (0.5, "/object/keys/note", 67, 50, "play", 1),
    ]


def test_with_a_pedal_a_key_that_is_up_damps_its_note(tmp_path):
    assert said(song(tmp_path / "song.mid", pedal=True), "marimba-bar")[2:4] == [
        (0.5, "/object/keys.60/damp", 1.0),
        (0.5, "/object/keys/note", 67, 50, "play", 1),
    ]


def test_a_channel_has_an_object_of_its_own(tmp_path):
    path = song(tmp_path / "song.mid", channel=9)
    assert said(path, "marimba-bar", "10:tom")[2:3] == [(0.0, "/object/channel-10/note", 60, 100, "play", 1)]
    with pytest.raises(ScoreError, match="no object plays any of its notes"):
        said(path, "1:tom")


@pytest.mark.parametrize("words", [("0:tom",), ("17:tom",), ("x:tom",), ("tom", "gong"), ("10:",)])
def test_wrong_objects_of_channels_are_refused_by_name(words):
    with pytest.raises(ScoreError, match=f"object = {words[-1]}: "):
        playing(words)


def test_files_that_are_none_are_refused(tmp_path):
    path = song(tmp_path / "song.mid")
    with pytest.raises(ScoreError, match=r"song\.mid: it is a MIDI file: expected --object PRESET"):
        read_score(str(path))
    for end in (5, 10, 20):
        (tmp_path / "cut.mid").write_bytes(path.read_bytes()[:end])
        with pytest.raises(ScoreError, match=r"cut\.mid: "):
            said(tmp_path / "cut.mid", "tom")
    (tmp_path / "score.txt").write_text("0 /object/new a tom\n")
    with pytest.raises(ScoreError, match=r"score\.txt: expected a MIDI file"):
        said(tmp_path / "score.txt", "tom")


@pytest.mark.slow
def test_a_song_renders_to_the_sound_of_its_score(tmp_path):
    path = song(tmp_path / "song.mid", pedal=True)
    (tmp_path / "same.txt").write_text(
        "0 /object/new keys marimba-bar\n0 /object/keys/note 60 100 play 1\n0.5 /object/keys.60/damp 1.0\n"
        "0.5 /object/keys/note 67 50 play 1\n1.0 /object/keys.67/damp 1.0\n"
    )
    subprocess.run([*CAROM, "render", path, tmp_path / "song.wav", "--object", "marimba-bar"], check=True)
    subprocess.run([*CAROM, "render", tmp_path / "same.txt", tmp_path / "same.wav"], check=True)
    assert (tmp_path / "song.wav").read_bytes() == (tmp_path / "same.wav").read_bytes()
