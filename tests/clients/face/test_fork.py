"""Scene.fork: two futures of one moment."""

import gc
import random
import threading
import weakref
from contextlib import suppress
from pathlib import Path
from subprocess import run
from sys import executable

import numpy as np
import pytest
import soundfile

import carom
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.native import pages
from carom.dsp.runtime import fresh
from tests.scores import any_score

SECONDS = 1.0


def scene_of(score):
    """Return an empty scene for a score."""
    return carom.Scene(min(score.rate, 48_000), channels=score.channels, limiter=score.limited, contacts=True)


def play(scene, lines, block, until):
    """Send lines as their time comes, without those that are refused, and render up to a frame; return the sound."""
    sounds = []
    while scene._frames < until:
        frames = min(block, until - scene._frames)
        while lines and lines[0].time * scene.rate < scene._frames + frames + 3 * QUANTUM:
            line = lines.pop(0)
            with suppress(carom.CommandError):
                scene.send(line.message.address, *line.message.args, at=max(line.time, scene.time))
        sounds.append(scene.render(frames=frames))
    samples = np.concatenate([each.samples for each in sounds])
    contacts = [(repr(contact), contact.force.tobytes()) for each in sounds for contact in each.contacts]
    return samples, contacts, scene.ended()


def assert_same(one, other):
    np.testing.assert_array_equal(one[0], other[0])
    assert one[1:] == other[1:]


def check_futures(seed, cut, blocks):
    """Two futures of a moment, one of them forked twice, are whole renders of scores with the same beginning."""
    score, other = any_score(seed, seconds=SECONDS), any_score(seed + 1_000, "p", seconds=SECONDS)
    first, second, third = blocks
    at, end = (round(seconds * min(score.rate, 48_000)) for seconds in (cut, SECONDS + 0.1))
    later = [line._replace(time=line.time + cut) for line in other.lines]
    scene, left = scene_of(score), list(score.lines)
    play(scene, left, first, at)
    fork = scene.fork()
    of_fork = fork.fork()
    changed, kept = play(fork, list(later), second, end), play(scene, list(left), second, end)
    fork.close()
    assert_same(play(of_fork, list(left), second, end), kept)
    for future, lines in ((changed, later), (kept, left)):
        whole, begin = scene_of(score), list(score.lines)
        play(whole, begin, first, at)
        assert_same(play(whole, list(lines), second, end), future)
    whole, begin = scene_of(score), list(score.lines)
    early = play(whole, begin, third, at)[0]
    np.testing.assert_array_equal(play(whole, begin, third, end)[0], kept[0])
    return early, kept[0], changed[0]


SEEDS = (1, 2, 3, 10, 13, 15)


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS)
def test_both_futures_of_random_scores_are_whole_renders(seed):
    """Gestures and what steers them, objects that come and go, panics, forms of the bank, channels, the limiter."""
    chance = random.Random(seed)
    early, kept, changed = check_futures(seed, chance.uniform(0.1, 0.9), [chance.randint(1, 2_000) for _ in range(3)])
    assert kept.any() and changed.any() and early.any()


def furnish(scene):
    """Have a scene hold all that random scores have not."""
    scene.room(4.0, 5.0, 3.0)
    scene.new("glass", "wine-glass")
    scene.new("gong", "small-gong")
    scene.new("bar", "marimba-bar")
    scene.place("glass", 1.0, 1.0, 1.0)
    scene.sensor("mic", "glass", 0.5)
    scene.play(True)
    scene.dice("glass", 3)
    scene.macro("glass", at=0.3, size=0.7)
    scene.morph("bar", "vibraphone-bar", 0.3)
    scene.impact("gong", 3.0, at=0.05)
    scene.note("bar", "C4", 90, at=0.1)
    scene.rest("bar", "felt", id="lies")
    scene.rain("gong", 300.0, at=0.15)  # of a seed that no call chose
    scene.impact("glass", 1.0, at=0.4)  # waits, and gets the macro's values
    scene.bounce("glass", 0.05, at=0.02, id="ball")


def go_on(scene):
    """Call what depends on what came before; return the sound."""
    scene.undo("glass")
    scene.dice("bar")
    scene.macro("glass", at=0.35, size=0.2)
    scene.roll("gong", 0.3)
    scene.note("bar", "C4", 60)
    scene.note("bar", "E4", 60, at=0.5)
    scene.steer("ball", mass=0.01)
    scene.unmount("mic", at=0.45)
    scene.stop("lies", at=0.4)
    return scene.render(seconds=0.4)


@pytest.mark.slow
def test_all_that_a_scene_holds_goes_on_in_both():
    scene, whole = (carom.Scene(stems=True) for _ in range(2))
    for each in (scene, whole):
        furnish(each)
        each.render(seconds=0.25)
    fork = scene.fork()
    fork.free("*", at_once=True)
    fork.new("glass", "church-bell")  # in the other's place
    fork.impact("glass", 2.0)
    assert fork.render(seconds=0.2).samples.any()
    sounds = [go_on(each) for each in (scene.fork(), whole, scene)]
    for each in sounds[1:]:
        np.testing.assert_array_equal(each.samples, sounds[0].samples)
        assert each.stems.keys() == sounds[0].stems.keys() and each.report == sounds[0].report
        for name, stem in each.stems.items():
            np.testing.assert_array_equal(stem, sounds[0].stems[name])
        np.testing.assert_array_equal(each.sensors["mic"].samples, sounds[0].sensors["mic"].samples)
    assert scene.ended() == whole.ended()


def struck():
    """Return a scene in which a bell was struck, and rings."""
    scene = carom.Scene()
    scene.new("bell", "church-bell")
    scene.impact("bell", 1.0)
    scene.render(seconds=0.05)
    return scene


@pytest.mark.slow
@pytest.mark.parametrize("lacks", ["scan", "page map"])
def test_systems_that_do_not_report_what_is_written_fork_alike(monkeypatch, lacks):
    def fails(*_arguments):
        raise OSError

    scene = struck()
    expected = scene.fork().render(seconds=0.1).samples
    if lacks == "scan":
        monkeypatch.setattr(pages, "written_pages", fails)
    else:
        monkeypatch.setattr(fresh, "taken_pages", fails)
    np.testing.assert_array_equal(scene.fork().render(seconds=0.1).samples, expected)


@pytest.mark.slow
def test_many_objects_that_strike_each_other_are_no_limit():
    scene = carom.Scene()
    for n in range(400):
        scene.new(f"o{n}", "triangle")
    for n in range(399):
        scene.impact(f"o{n}", 1.0, by=f"o{n + 1}", at=0.5)
    assert scene.fork().render(frames=1_000).samples.shape == (1_000, 2)


def test_what_is_closed_gives_its_memory_back_at_once():
    scene = struck()
    gc.collect()
    gc.disable()
    try:
        fork = scene.fork()
        state = weakref.ref(fork._open.engine.state)
        fork.close()
        assert state() is None
    finally:
        gc.enable()
    assert scene.render(seconds=0.1).samples.any()


def test_a_fork_goes_on_without_the_scene_it_came_from():
    scene = struck()
    fork, expected = scene.fork(), scene.fork().render(seconds=0.1).samples
    scene.close()
    del scene
    gc.collect()
    np.testing.assert_array_equal(fork.render(seconds=0.1).samples, expected)
    assert repr(fork) == f"<carom.Scene 48000 Hz, channels 2, at {fork.time:g} s, objects 1>"


def test_what_cannot_be_forked_is_named():
    scene = struck()
    bell = carom.Scene().new("bell", "church-bell")
    with pytest.raises(carom.CommandError, match="expected an object of this scene"):
        scene.fork().send("/object/bell/impact", 1.0, "by", bell)
    scene._open.held = threading.Lock()
    with pytest.raises(carom.CommandError, match=r"fork: the scene holds what cannot be copied: .*lock"):
        scene.fork()
    scene.close()
    with pytest.raises(carom.CommandError, match="the scene is closed"):
        scene.fork()
    scene = carom.Scene()
    scene.send("/world/body", "floor", "plate", "wood", 0.3, 0.2, 0.01, "held", 1)
    with pytest.raises(carom.CommandError, match="fork: the scene holds a simulation"):
        scene.fork()


@pytest.mark.slow
def test_the_example_renders_two_futures(tmp_path):
    path = Path(__file__).parents[3] / "clients" / "examples" / "python" / "futures.py"
    run([executable, str(path)], check=True, cwd=tmp_path, timeout=60)
    free, held = (soundfile.read(tmp_path / name)[0] for name in ("struck.wav", "held.wav"))
    hand, late = int(0.3 * 48_000) - 2 * QUANTUM, int(1.5 * 48_000)
    np.testing.assert_array_equal(free[:hand], held[:hand])
    assert np.abs(free[late:]).max() > 10 * np.abs(held[late:]).max()
