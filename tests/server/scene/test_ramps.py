"""Changes that take their time, as messages say them: in a session, a score, a log, and from Python."""

import numpy as np
import pytest

import carom
from carom.dsp.schema import SETTINGS, STEERABLE
from carom.server.files.log import Log
from carom.server.osc.score import parse
from carom.server.scene.session import Session
from tests.server.scene.support import refusal, say, seconds
from tests.support import render_lines

SCORE = """
0.0 /object/new pane glass-plate
0.0 /object/pane/roll 0.4 striker glass-marble surface glass id marble seed 3
0.1 /gesture/marble/speed 1.2 over 0.3 curve 2
0.1 /object/pane/pan [-1, 1] over [0.1 0.2]
0.2 /gain -12 over 0.2
0.35 /object/pane/gain -6,0 over 0.05
"""


def targets(session: Session, name: str) -> list[float]:
    contacts = session.engine.state["contacts"][0]
    return [float(each) for each in contacts["target"][name][contacts["gesture"] > 0]]


def test_a_value_is_reached_in_its_time(played):
    say(played, "/object/pane/roll", 0.4, "striker", "glass-marble", "id", "marble")
    assert say(played, "/gesture/marble/speed", 1.0, "over", 0.2) == []
    seconds(played, 0.1)
    assert targets(played, "speed")[0] == pytest.approx(0.7, abs=0.005)
    seconds(played, 0.15)
    assert targets(played, "speed") == [1.0]


@pytest.mark.parametrize("given", [([0.5, 0.8], [0.1, 0.2]), ("0.5,0.8", "0.1,0.2"), ((0.5, 0.8), 0.15)])
def test_points_may_be_lists_or_texts_and_a_time_may_be_that_of_each(played, given):
    values, times = (tuple(each) if isinstance(each, list) else each for each in given)
    assert say(played, "/object/p*/damp", values, "over", times) == []
    assert played.objects["pane"].settings["damp"] == 0.8  # as it was last told, for those that ask
    seconds(played, 0.4)
    assert played.engine.objects["settings"]["damp"][played.objects["pane"].handle.slot] == 0.8


@pytest.mark.parametrize("address", [f"/object/pane/{name}" for name in SETTINGS] + ["/gain"])
def test_all_that_can_be_set_takes_its_time(played, address):
    assert say(played, address, 0.5, "over", 1.0, "curve", -2.0) == []
    seconds(played, 0.1)
    assert played.engine.state["ramps"]["count"] == 1


@pytest.mark.parametrize("name", STEERABLE)
def test_all_that_is_steered_takes_its_time(played, name):
    gesture = {"force": "press", "gravity": "bounce", "irregularity": "bounce", "flat": "spin"}.get(name, "slide")
    gesture = "roll" if name in ("mass", "asymmetry", "friction", "stiffness", "dissipation", "exponent") else gesture
    gesture = {"rate": "shake", "variety": "shake", "evenness": "shake", "size": "rain"}.get(name, gesture)
    gesture = {"height": "pour", "crackles": "step"}.get(name, gesture)
    crackles = ("density", "energy", "steepness", "decades", "excitation", "memory")
    gesture = "crumple" if name in crackles else gesture
    begins = (gesture, 0.3, "striker", "glass-marble")
    begins = ("rest", "cup", 0.3) if name in ("load", "by_position") else begins
    begins = ("rest", "mug", 0.3) if name in ("by_x", "by_y", "by_z") else begins
    if name in ("x", "y", "z", "by_x", "by_y", "by_z"):
        say(played, "/object/new", "mug", "mug")
    said = say(played, f"/object/{'mug' if name in ('x', 'y', 'z') else 'pane'}/{begins[0]}", *begins[1:], "id", "x")
    values = {"size": 1e-3, "density": 100.0, "decades": 2.0, "evenness": 1.0, "stiffness": 1e6, "exponent": 1.4}
    value = values.get(name, 0.02)
    assert said == [] and say(played, f"/gesture/x/{name}", value, "over", 1.0) == []
    seconds(played, 0.1)
    assert played.engine.state["ramps"]["count"] == 1


@pytest.mark.parametrize(
    ("args", "reason"),
    [
        ((0.5, "over"), "over: its value is missing"),
        ((0.5, "over", 1, "over", 2), "over = 2: given twice"),
        ((0.5, "ever", 1), "ever: no such key; did you mean over?"),
        (((0.1, 0.2),), "pan = [0.1 0.2]: over is missing: expected the time of each value, s"),
        (
            ((0.1, 0.2), "over", (1, 2, 3)),
            "over = [1 2 3]: expected one number, or as many as there are values: 2",
        ),
        (((0.1, 9.0), "over", 1), "pan = 9: expected a number from -1 to 1"),
        (("0.1,x", "over", 1), "pan = x: expected a number from -1 to 1"),
        (((),), "pan = []: expected a number from -1 to 1"),
        (((0.0,) * 65, "over", 1), "pan: 65 values: expected at most 64"),
        ((), "pan is missing: expected /object/NAME/pan pan [key value ...], with pan -1 to 1"),
    ],
)
def test_wrong_ramp_is_named_and_changes_nothing(played, args, reason):
    assert refusal(played, "/object/pane/pan", *args) == reason
    assert played.objects["pane"].settings["pan"] == 0.0


def test_a_log_holds_the_ramp_that_was_asked_for_and_renders_to_the_same_bits(tmp_path, session):
    log = Log(session.engine, tmp_path / "log.txt")
    session.on_sent = log.expect
    log.start()
    sound = []
    for line in parse(SCORE.encode(), "score"):
        sound.append(session.engine.process(max(0, int(line.time * 48_000) - session.engine.position)))
        assert [
            each for each in say(session, line.message.address, *line.message.args) if each.address == "/fail"
        ] == []
    sound.append(session.engine.process(24_000))
    log.close()
    lines = parse((tmp_path / "log.txt").read_bytes(), "log")
    assert [line.message.address for line in lines].count("/object/pane/pan") == 1
    heard = np.concatenate(sound)
    np.testing.assert_array_equal(render_lines(lines, seconds=len(heard) / 48_000), heard)


def test_scenes_objects_and_scores_say_the_same():
    with carom.Scene() as scene:
        pane = scene.new("pane", "glass-plate")
        pane.roll(0.4, striker="glass-marble", surface="glass", id="marble", seed=3)
        scene.steer("marble", speed=1.2, over=0.3, curve=2, at=0.1)
        pane.pan(np.array([-1, 1]), over=[0.1, 0.2], at=0.1)
        scene.main_gain(-12, over=0.2, at=0.2)
        pane.gain([-6, 0], over=0.05, at=0.35)
        heard = scene.render(0.6).samples
    assert heard.any()
    np.testing.assert_array_equal(carom.render(SCORE, seconds=0.6).samples, heard)


def ramped(rate, speed, roughness, radius):
    """Return the sound of a ball on a board from when its radius begins to go from 20 mm to another (m)."""
    score = f"""
    0 /object/new board wood-board
    0 /object/board/roll {speed} radius 0.02 roughness {roughness} seed 3 id ball
    0.1 /gesture/ball/radius {radius} over 0.3
    """
    sound = render_lines(parse(score.encode(), "score"), rate=rate, limiter=False, seconds=0.4)
    return sound[rate // 10 :, 0].astype(float)


@pytest.mark.slow
@pytest.mark.parametrize("rate", [48_000, 96_000, 192_000])
def test_a_ramp_of_the_radius_neither_moves_nor_throws_what_rolls(rate):
    """One by next to nothing is hardly heard, and none throws a ball up that falls back later."""
    even = ramped(rate, 0.1, 1.0, 0.02)
    assert np.abs(ramped(rate, 0.1, 1.0, 0.02000001) - even).max() < 0.01 * np.abs(even).max()
    assert np.abs(ramped(rate, 0.5, 2.0, 0.032)).max() < 2.0 * np.abs(ramped(rate, 0.5, 2.0, 0.02)).max()
