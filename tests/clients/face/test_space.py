"""Space by messages: places, listeners and rooms of scenes and worlds."""

import numpy as np
import pytest

import carom


def onset(sound: np.ndarray) -> int:
    """Return the first sample that is louder than a thousandth of the peak."""
    loud = np.abs(sound)
    return int(np.argmax(loud > 1e-3 * loud.max()))


def test_a_place_is_heard_by_its_distance_and_gains_win():
    with carom.Scene(calibrated=True) as scene:
        bar = scene.new("bar", "marimba-bar")
        scene.listener(0, 0, 0)
        bar.place(34.32, 0, 0)
        bar.impact(1.0)
        far = scene.render(0.5).samples
        bar.gains(1.0, 1.0)
        bar.impact(1.0)
        near = scene.render(0.5).samples
    assert onset(far[:, 0]) == pytest.approx(4_800, abs=40)
    assert onset(near[:, 0]) < 200
    assert np.abs(near).max() > 20 * np.abs(far).max()


def test_a_score_says_the_same_as_a_scene_and_refuses_what_cannot_be():
    score = """
    0 /object/new bar marimba-bar
    0 /listener 0 0 1.5 layout binaural yaw 30
    0 /room 6 5 3 t60 0.4
    0 /object/bar/place [2 2 1]
    0 /object/bar/place 2 2 1
    0 /object/bar/impact 1.0
    0.1 /object/bar/place 4 2 1 over 0.5
    """
    with pytest.raises(carom.ScoreError, match="place"):
        carom.render(score, seconds=0.3)
    sound = carom.render(score.replace("0 /object/bar/place [2 2 1]\n", "\n"), seconds=0.3)
    with carom.Scene() as scene:
        bar = scene.new("bar", "marimba-bar", at=0.0)
        scene.listener([0, 0, 1.5], layout="binaural", yaw=30, at=0.0)
        scene.room(6, 5, 3, t60=0.4, at=0.0)
        bar.place(2, 2, 1, at=0.0)
        bar.impact(1.0, at=0.0)
        bar.place(4, 2, 1, over=0.5, at=0.1)
        assert np.array_equal(scene.render(0.3).samples, sound.samples)
        with pytest.raises(carom.CommandError, match="expected 4, 9 or 16 channels, and there are 2"):
            scene.listener(0, 0, 0, layout="ambisonics")
        with pytest.raises(carom.CommandError, match="expected x, y and z"):
            bar.place(1, 2)


def test_a_note_comes_from_where_its_object_is():
    with carom.Scene() as scene:
        bar = scene.new("bar", "marimba-bar")
        scene.listener(0, 0, 0)
        bar.place(34.32, 0, 0)
        bar.note(60, 100)
        assert onset(scene.render(0.5).samples[:, 0]) == pytest.approx(4_800, abs=40)
        bar.place()
        bar.note(62, 100)
        assert onset(scene.render(0.5).samples[:, 0]) < 200


def test_an_object_out_of_space_is_placed_by_its_pan():
    with carom.Scene() as scene:
        bar = scene.new("bar", "marimba-bar", pan=-1)
        scene.listener(0, 0, 0)
        bar.place(0, -2, 0)  # on the right
        bar.impact(1.0)
        right = scene.render(0.2).samples
        bar.place()
        scene.render(0.5)
        bar.impact(1.0)
        left = scene.render(0.2).samples
    assert np.abs(right[:, 1]).max() > 100 * np.abs(right[:, 0]).max()
    assert np.abs(left[:, 0]).max() > 100 * np.abs(left[:, 1]).max()


@pytest.mark.parametrize("late", [0.0, 1.0])
def test_stems_have_all_of_a_room_but_its_late_part(late):
    """The sum of the stems is the sound, with its reflections, up to what all objects share."""
    with carom.Scene(calibrated=True, stems=True) as scene:
        scene.listener(0, 0, 1.5)
        scene.room(6, 5, 3, t60=0.3, late=late)
        for name, side in (("bar", 1), ("bell", -1)):
            each = scene.new(name, "marimba-bar" if side > 0 else "church-bell")
            each.place(1, side, 1)
            each.impact(1.0)
        sound = scene.render(0.4)
    assert sound.stems
    missing = np.abs(sound.samples - sum(sound.stems.values())).max() / np.abs(sound.samples).max()
    assert (missing < 1e-6) == (late == 0.0)


def world_of_a_ball(listener, keep=False, moves=0.0):
    """Return the sound of a ball that is struck at 5 m, with a body `head` that moves away."""
    world = carom.World(listener=listener, keep=keep)
    world.body("wall", "plate", (1, 1, 0.02), "steel", carom.Pose((5, 0, 1.5)), held=True)
    world.body("ball", "sphere", 0.02, "steel", carom.Pose((5, 0, 1.6)))
    world.body("head", "sphere", 0.1, "rubber", carom.Pose((0, 0, 1.5)), rings=False)
    touch = carom.Touch("wall", "ball", (5, 0, 1.51), (0, 0, 1), approach=1.0)
    blocks = []
    for n in range(1, 201):
        poses = {"head": carom.Pose((moves * n / 1_000, 0, 1.5))}
        blocks.append(world.step(n / 1_000, [touch] if n == 10 else [], poses))
    return world, np.concatenate(blocks)


def test_a_world_has_a_listener_in_space():
    world, sound = world_of_a_ball(carom.Listener((0, 0, 1.5), layout="binaural"), keep=True)
    assert sound.shape == (9_600, 2)
    assert onset(sound[:, 0]) == pytest.approx(0.01 * 48_000 + 64 + 5 / 343.2 * 48_000, abs=60)
    again = carom.render(world.score(), calibrated=True, seconds=0.2)
    assert np.array_equal(again.samples, sound)
    world.close()


def test_a_listener_rides_on_a_body():
    still, first = world_of_a_ball(carom.Listener((0, 0, 0), layout="ambisonics", on="head"))
    moved, second = world_of_a_ball(carom.Listener((0, 0, 0), layout="ambisonics", on="head"), moves=20.0)
    assert first.shape == (9_600, 4)
    assert np.abs(first).max() > 0.0
    assert onset(second[:, 0]) < onset(first[:, 0])  # it has come nearer
    still.close()
    moved.close()


def test_a_microphone_rides_on_a_body():
    levels = []
    for moves in (0.0, 4.0):
        world = carom.World(microphones=[carom.Microphone((0, 0, 0), on="head")])
        world.body("wall", "plate", (1, 1, 0.02), "steel", carom.Pose((5, 0, 1.5)), held=True)
        world.body("ball", "sphere", 0.02, "steel", carom.Pose((5, 0, 1.6)))
        world.body("head", "sphere", 0.1, "rubber", carom.Pose((0, 0, 1.5)), rings=False)
        for n in range(1, 11):
            world.step(n / 10, [], {"head": carom.Pose((moves * n / 10, 0, 1.5))})
        touch = carom.Touch("wall", "ball", (5, 0, 1.51), (0, 0, 1), approach=1.0)
        heard = np.concatenate([world.step(1.1, [touch]), world.ring(0.1)])
        levels.append(float(np.sqrt((heard**2).sum())))
        world.close()
    assert levels[1] / levels[0] == pytest.approx(5.0, rel=0.05)  # 1 m away, not 5
