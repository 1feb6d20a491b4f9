"""carom.Scene: a score's addresses as methods, in this process."""

import copy
import math
import pickle
import threading

import numpy as np
import pytest

import carom
from carom.presets.library import BUILT_IN
from carom.server.osc.addresses import VERBS
from carom.server.osc.score import read

SCORES = BUILT_IN / "scores"

SCORE = """
0     /object/new a steel-plate gain -6 pan 0.3 thickness 0.002
0     /object/new b wood-block
0     /accuracy exact
0.01  /object/a/impact 1.0 0.3 striker wood id hit
0.02  /object/a/bounce 0.05 0.2 striker ping-pong irregularity 0.3
0.03  /object/b/roll 0.3 0.4 striker glass-marble surface wood id ball
0.05  /object/a/press 2 0.6 striker hand id palm
0.1   /gesture/ball/speed 0.6
0.1   /gesture/ball/friction 0.05
0.12  /object/a/impact 1 by b by_position 0.2
0.13  /object/a/damp 0.2
0.14  /object/b/gain -3
0.15  /object/b/pan -0.5
0.16  /object/a/tune 2.5
0.17  /object/a/decay 0.5
0.18  /gesture/palm/stop
0.19  /quality 1
0.19  /bank float32
0.21  /object/*/impact 0.5
0.25  /object/b/free 1
0.3   /panic
0.31  /object/a/impact 0.2
"""


def play(scene):
    """Play the events of SCORE, those of one time in its order."""
    a = scene.new("a", "steel-plate", gain=np.int64(-6), pan=0.3, thickness=np.float64(0.002))
    b = scene.new("b", "wood-block")
    scene.accuracy("exact")
    a.impact(1.0, 0.3, at=0.01, striker="wood", id="hit")
    a.bounce(0.05, 0.2, at=0.02, striker="ping-pong", irregularity=0.3)
    b.roll(0.3, 0.4, at=0.03, striker="glass-marble", surface="wood", id="ball")
    a.press(2, 0.6, at=0.05, striker="hand", id="palm")
    scene.steer("ball", at=0.1, speed=0.6, friction=0.05)
    a.impact(1, at=0.12, by="b", by_position=0.2)
    a.damp(0.2, at=0.13)
    b.gain(-3, at=0.14)
    b.pan(-0.5, at=0.15)
    a.tune(np.array(2.5), at=0.16)
    a.decay(0.5, at=0.17)
    scene.stop("palm", at=0.18)
    scene.quality(1, at=0.19)
    scene.bank("float32", at=0.19)
    scene.impact("*", 0.5, at=0.21)
    b.free(True, at=0.25)
    scene.panic(at=np.float64(0.3))
    scene.send("/object/a/impact", 0.2, at=0.31)


@pytest.mark.slow
def test_a_scene_makes_the_bits_of_the_score_that_says_the_same():
    expected = carom.render(SCORE, seconds=0.4)
    with carom.Scene() as scene:
        play(scene)
        sound = scene.render(0.4)
    assert np.abs(expected.samples).max() > 0.01
    np.testing.assert_array_equal(sound.samples, expected.samples)
    assert sound.report == expected.report


def test_an_object_stands_for_its_name():
    with carom.Scene() as first, carom.Scene() as second:
        sounds = []
        for scene, named in ((first, False), (second, True)):
            one, other = scene.new("one", "wine-glass"), scene.new("other", "glass-plate")
            a, b = ("one", "other") if named else (one, other)
            scene.rest(a, b, 0.5, by_position=0.3)
            scene.impact(b, 1.0, by=a, at=0.01)
            scene.sensor("tip", a)
            sounds.append(scene.render(0.1))
        assert sounds[0].samples.any() and sounds[0].sensors["tip"].samples.any()
        np.testing.assert_array_equal(sounds[0].samples, sounds[1].samples)
        with pytest.raises(carom.CommandError, match=r"<carom\.Object other>: expected an object of this scene"):
            first.rest("one", other)


def test_every_address_of_a_score_is_a_method():
    """World has those of a simulation."""
    for address, verb in VERBS.items():
        others = "/gesture/", "/channels", "/sensors", "/full_scale", "/world/", "/end"
        if verb.scored and not address.startswith(others):
            assert callable(getattr(carom.Scene, address.split("/")[-2 if "/macro/" in address else -1]))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["demo", "marbles", "pencil"])
def test_scores_sent_line_by_line_make_the_bits_that_they_render_to(name):
    seconds = 4.0
    lines = [line for line in read(SCORES / f"{name}.txt") if line.time < seconds]
    with carom.Scene(44_100) as scene:
        for line in lines:
            scene.send(line.message.address, *line.message.args, at=line.time)
        sound = scene.render(seconds)
    np.testing.assert_array_equal(sound.samples, carom.render(lines, 44_100, seconds=seconds).samples)


@pytest.mark.slow
def test_sound_goes_on_from_render_to_render():
    lengths = [1, 63, 100, 1000, 64, 7, 2048, 301]
    with carom.Scene() as whole, carom.Scene() as cut:
        play(whole), play(cut)
        expected = whole.render(frames=sum(lengths))
        sounds = [cut.render(frames=np.int64(length)) for length in lengths]
        assert cut.time == whole.time == pytest.approx((-(-sum(lengths) // 64) + 1) * 64 / 48_000)
    np.testing.assert_array_equal(np.concatenate(sounds), expected)
    assert [len(sound) for sound in sounds] == lengths
    assert [round(sound.start * 48_000) for sound in sounds] == [sum(lengths[:n]) for n in range(len(lengths))]
    assert sum(sound.report.contacts for sound in sounds) == expected.report.contacts > 0


def test_events_between_renders_fall_where_they_should():
    """Steps of a simulation: what is asked for at the scene's time, or after it, is played there."""
    times = [0.0]
    with carom.Scene() as scene:
        block = scene.new("a", "wood-block")
        block.impact(1.0)
        sounds = []
        for n in range(5):
            sounds.append(scene.render(frames=1000))
            times.append(scene.time + 0.3 / 48_000 * n)
            block.impact(1.0, at=times[-1] if n else None)
        sounds.append(scene.render(frames=1000))
    score = [(0, "/object/new", "a", "wood-block"), *((time, "/object/a/impact", 1.0) for time in times)]
    np.testing.assert_array_equal(np.concatenate(sounds), carom.render(score, seconds=6000 / 48_000).samples)


@pytest.mark.slow
def test_scenes_play_in_threads_at_once():
    expected = carom.render(SCORE, seconds=0.4).samples
    sounds = {}

    def work(number):
        with carom.Scene() as scene:
            play(scene)
            sounds[number] = np.concatenate([scene.render(0.1) for _ in range(4)])

    threads = [threading.Thread(target=work, args=(number,)) for number in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for number in range(3):
        np.testing.assert_array_equal(sounds[number], expected)


@pytest.fixture(scope="module")
def scene():
    with carom.Scene() as scene:
        scene.new("a", "steel-plate")
        scene.render(frames=100)
        yield scene


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda s: s.impact("b", 1), "/object/b/impact: b: no such object; there is a"),
        (lambda s: s.impact("a", "hard"), "/object/a/impact: velocity = hard: expected a number from 0 to 1000 m/s"),
        (lambda s: s.impact("a", float("nan")), "velocity = nan"),
        (lambda s: s.impact("a", 1, colour=3), "colour: no such key; expected one of striker"),
        (lambda s: s.impact("a", 1, striker="x"), "no striker 'x'"),
        (lambda s: s.impact("a", 1, at=0.0), r"/object/a/impact: at = 0.0: expected seconds from 0.004,"),
        (lambda s: s.impact("a", 1, at=-1), "at = -1: expected seconds"),
        (lambda s: s.impact("a", 1, at=float("nan")), "at = nan: expected seconds"),
        (lambda s: s.impact("a", 1, at=float("inf")), "at = inf: expected seconds"),
        (lambda s: s.impact("a", 1, at="now"), "at = 'now': expected seconds"),
        (lambda s: s.new("a", "wood-block"), "name = a: there is such an object already"),
        (lambda s: s.new("c", "wood-blok"), "did you mean wood-block"),
        (lambda s: s.new("c", "wood-block", hue=1), "hue = 1: wood-block, of the shape plate, has no such key"),
        (lambda s: s.steer("x", speed=1), "/gesture/x/speed: x: no such gesture"),
        (lambda s: s.steer("x"), "/gesture/x: expected a value to steer"),
        (lambda s: s.steer("x", colour=1, speed=2), "/gesture/x/colour: .*; /gesture/x/speed: "),
        (lambda s: s.send("/status"), "/status: server-only message"),
        (lambda s: s.quality(9), "quality = 9: expected a number from 0 to 8"),
    ],
)
def test_errors_of_a_call_name_the_culprit(scene, call, text):
    with pytest.raises(carom.CommandError, match=text):
        call(scene)


@pytest.mark.parametrize(
    ("lengths", "text"),
    [
        ({}, "seconds = None, frames = None: expected one of the two"),
        ({"seconds": 1, "frames": 1}, "seconds = 1, frames = 1: expected one of the two"),
        ({"seconds": 0}, "seconds = 0: expected at least a frame"),
        ({"seconds": float("nan")}, "seconds = nan"),
        ({"frames": 0}, "frames = 0: expected a whole number from 1"),
        ({"frames": 1.5}, "frames = 1.5: expected a whole number"),
    ],
)
def test_wrong_length_of_a_render_is_refused_and_no_time_passes(scene, lengths, text):
    before = scene.time
    with pytest.raises(ValueError, match=text):
        scene.render(**lengths)
    assert scene.time == before


def test_a_closed_scene_says_so():
    with carom.Scene() as scene:
        block = scene.new("a", "wood-block")
    for call in (lambda: block.impact(1), lambda: scene.render(1), lambda: scene.time):
        with pytest.raises(carom.CommandError, match="the scene is closed"):
            call()
    with pytest.raises(carom.RenderError, match="rate = 100: expected 8000"):
        carom.Scene(100)


def test_keys_may_be_lists_and_arrays():
    edges = ["clamped"] * 4
    with carom.Scene() as scene:
        plates = [scene.new(f"p{n}", "steel-plate", edges=each) for n, each in enumerate((edges, np.array(edges)))]
        assert plates[0].modes().frequencies[0] == plates[1].modes().frequencies[0]
        assert plates[0].modes().frequencies[0] > 1.5 * scene.new("free", "steel-plate").modes().frequencies[0]


@pytest.mark.slow
def test_a_scene_that_is_full_says_so_and_goes_on():
    with carom.Scene() as scene:
        block = scene.new("a", "wood-block")
        with pytest.raises(carom.CommandError, match="no capacity for 1 events ahead of their time"):
            for n in range(10_000):
                block.impact(0.1, at=1.0 if n < 8 else 1000.0)
        scene.render(1.5)
        block.impact(0.1, at=2.0)


def test_the_gestures_that_ended_are_told():
    with carom.Scene() as scene:
        block = scene.new("a", "wood-block")
        block.impact(1.0, at=0.01, id="hit")
        block.press(1.0, striker="hand", id="palm")
        scene.stop("palm", at=0.2)
        assert scene.ended() == []
        scene.render(0.1)
        assert scene.ended() == ["hit"]
        scene.render(1.0)
        assert scene.ended() == ["palm"] and scene.ended() == []


@pytest.mark.slow
def test_a_contact_that_crosses_renders_is_whole():
    """The force of three sounds is that of one."""
    forces = []
    for lengths in ([72_000], [24_000] * 3):
        with carom.Scene(contacts=True) as scene:
            scene.new("a", "wood-board")
            scene.press("a", 5.0, striker="hand", at=0.01)
            force = np.zeros(72_000)
            for n, frames in enumerate(lengths):
                for contact in scene.render(frames=frames).contacts:
                    start = n * frames + contact.first
                    assert contact.first >= 0 and contact.first + len(contact.force) <= frames
                    force[start : start + len(contact.force)] += contact.force
            forces.append(force)
    np.testing.assert_array_equal(*forces)
    assert forces[0][-1] > 0.0


def test_a_scene_is_not_copied():
    with carom.Scene() as scene:
        for duplicate in (copy.copy, copy.deepcopy, pickle.dumps):
            with pytest.raises(TypeError, match="a Scene is an engine at work"):
                duplicate(scene)


@pytest.mark.parametrize("lengths", [{"frames": math.inf}, {"frames": math.nan}, {"frames": [5]}, {"seconds": "1"}])
def test_lengths_that_are_none_are_named(scene, lengths):
    with pytest.raises(ValueError, match=rf"{next(iter(lengths))} = .*: expected"):
        scene.render(**lengths)


def test_warnings_are_in_the_report(tmp_path):
    preset = (carom.Presets().path("objects", "church-bell")).read_text()
    (tmp_path / "objects").mkdir()
    (tmp_path / "objects" / "plain.toml").write_text(preset.replace('material = "bell-bronze"\n', ""))
    with carom.Scene(presets=tmp_path) as scene:
        scene.new("board", "wood-board")
        scene.new("bell", "plain")
        scene.impact("board", 1.0, by="bell", gain=-60)
        assert any("bell has no material" in text for text in scene.render(0.1).report.warnings)
        assert scene.render(0.1).report.warnings == ()


def test_a_blow_may_be_known_by_its_impulse():
    """As a score has it; a velocity beside it is refused."""
    with carom.Scene() as scene:
        scene.new("plate", "steel-plate", at=0)
        scene.impact("plate", impulse=0.01, position=0.3, at=0)
        sound = scene.render(0.1).samples
        with pytest.raises(carom.CaromError, match=r"velocity = 1, impulse = 0\.01: expected one of the two"):
            scene.impact("plate", 1.0, impulse=0.01, at=0.2)
    score = [
        (0.0, "/object/new", "plate", "steel-plate"),
        (0.0, "/object/plate/impact", "impulse", 0.01, "position", 0.3),
    ]
    assert sound.any() and (carom.render(score, seconds=0.1).samples == sound).all()
