"""Sensors of scenes, scores, worlds, MuJoCo, environments and data sets."""

import numpy as np
import pytest
import soundfile

import carom
from carom.clients.cli import main
from tests import needs

SCORE = """
0    /object/new bar marimba-bar
0    /sensor/new tip bar 0.9
0    /sensor/new disc bar 0.2 preset piezo-27 full 100
0.01 /object/bar/impact 1
"""


def test_a_scene_has_the_signals_of_its_sensors():
    with carom.Scene(calibrated=True) as scene:
        bar = scene.new("bar", "marimba-bar")
        bar.sensor("tip", 0.9)
        bar.impact(1.0, position=0.3)
        sound = scene.render(0.1)
        with pytest.raises(carom.CommandError, match="no such object; did you mean bar"):
            scene.sensor("other", "baa")
        with pytest.raises(carom.CommandError, match="there is such a sensor"):
            bar.sensor("tip", 0.9)
        scene.unmount("tip")
        bar.impact(1.0)
        assert not np.any(scene.render(0.1).sensors["tip"].samples[200:])
    assert sound.samples.shape == (4_800, 2)
    assert sound.sensors["tip"].unit == "m/s^2"
    assert np.abs(sound.sensors["tip"]).max() > 10.0
    assert np.array_equal(sound[100:200].sensors["tip"].samples, sound.sensors["tip"].samples[100:200])


def test_a_file_says_the_unit_of_each_channel(tmp_path):
    sound = carom.render(SCORE, seconds=0.1)
    sound.save(tmp_path / "bar.wav")
    with soundfile.SoundFile(tmp_path / "bar.wav") as file:
        assert "channel 3 (tip): 1.0 is 1 m/s^2; channel 4 (disc): 1.0 is 100 m/s^2" in file.comment
        samples = file.read(dtype="float32")
    assert np.array_equal(samples[:, 2], sound.sensors["tip"].samples)
    with pytest.raises(carom.RenderError, match="expected a WAV file of floats"):
        sound.save(tmp_path / "bar.flac")
    calibrated, normalized = (carom.render(SCORE, seconds=0.1, **each) for each in ({}, {"normalize": -1}))
    assert np.array_equal(calibrated.sensors["tip"].samples, normalized.sensors["tip"].samples)


def test_each_sensor_has_a_channel_of_its_own_after_others_were_freed(tmp_path):
    lines = [
        "0.05 /sensor/b/free", "0.05 /sensor/a/free", "0.05 /sensor/c/free", "0.06 /sensor/new a bar 0.9",
        "0.06 /object/bar/impact 1", "0.01 /object/bar/impact 1", "0.03 /sensor/new c bar 0.1 full 10",
        "0 /object/new bar marimba-bar", "0 /sensor/new b bar 0.9", "0 /sensor/new a bar 0.2 quantity velocity",
    ]  # fmt: skip
    sound = carom.render("\n".join(lines), seconds=0.1)
    sounding = {name: [each.samples[:2400].any(), each.samples[2880:].any()] for name, each in sound.sensors.items()}
    assert sounding == {"b": [True, False], "a": [True, True], "c": [True, False]}
    with soundfile.SoundFile(_rendered(tmp_path, lines)) as file:
        said, samples = file.comment, file.read(dtype="float32")
    assert "channel 3 (b): 1.0 is 1 m/s^2; channel 4 (a): 1.0 is 1 m/s, then 1 m/s^2; channel 5 (c): 1.0 is 10" in said
    np.testing.assert_array_equal(samples[:, 2:].T, [each.samples for each in sound.sensors.values()])
    fewer = ["0 /sensors 2", *lines[:2], *lines[3:6], *lines[7:]]
    with soundfile.SoundFile(_rendered(tmp_path, fewer)) as file:
        assert file.channels == 4
    with pytest.raises(carom.ScoreError, match="no channel for another sensor: expected at most 2"):
        carom.render("\n".join(["0 /sensors 2", *lines]), seconds=0.1)


def test_more_sensors_than_there_is_room_for_are_refused():
    with carom.Scene(channels=63) as scene:
        bar = scene.new("bar", "marimba-bar")
        bar.sensor("one", 0.5)
        with pytest.raises(carom.CommandError, match="no channel for another sensor: expected at most 1 beside 63"):
            bar.sensor("two", 0.5)
        bar.impact(1.0)
        assert scene.render(0.01).sensors["one"].samples.any()
    with pytest.raises(carom.RenderError, match="2 sensors: expected at most 1 beside 63 channels"):
        carom.render("0 /sensors 2\n0 /channels 63\n0 /object/new a marimba-bar", seconds=0.1)


def _rendered(folder, lines):
    (folder / "score.txt").write_text("\n".join(lines))
    assert main(["render", str(folder / "score.txt"), str(folder / "out.wav"), "--seconds", "0.1"]) == 0
    return folder / "out.wav"


def test_a_world_senses_blows_on_its_bodies():
    with carom.World(keep=True) as world:
        world.body("floor", "plate", (1, 1, 0.02), "wood", held=True)
        world.body("rod", "cylinder", (0.01, 0.2), "steel")
        world.sensor("end", "rod", place=(0.0, 0.0, 0.1), preset="accelerometer")
        world.sensor("top", "floor", 0.5, quantity="velocity")
        touch = carom.Touch("floor", "rod", (0, 0, 0.01), (0, 0, 1), approach=0.5, mass=0.1)
        world.step(0.01)
        assert not any(np.any(each) for each in world.sensed.values())
        block = world.step(0.02, [touch], {"rod": carom.Pose((0, 0, 0.11))})
        world.ring(0.05)
        assert block.shape == (480, 1)
        assert set(world.sensed) == {"end", "top"}
        assert np.abs(world.sensed["end"]).max() > 1.0
        sound, score = world.sound(), world.score()
        with pytest.raises(carom.WorldError, match="expected one of the two"):
            world.sensor("other", "rod")
    assert "/sensor/new end rod" in score
    again = carom.render(score, calibrated=True, seconds=sound.duration)
    assert np.array_equal(again.sensors["end"].samples, sound.sensors["end"].samples)


MODEL = """
<mujoco>
  <custom><text name="carom" data="floor wood rod steel"/></custom>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 .1"/>
    <body name="rod" pos="0 0 .15" euler="0 60 0"><freejoint/>
      <geom type="capsule" size=".01 .1"/><site name="tip" pos="0 0 .1"/></body>
  </worldbody>
</mujoco>"""


def test_a_site_of_a_model_is_a_place_for_a_sensor():
    mujoco = needs.module("mujoco")
    import carom.mujoco

    model = mujoco.MjModel.from_xml_string(MODEL)
    data = mujoco.MjData(model)
    sensed = []
    with carom.mujoco.Bridge(model, data, sensors={"tip": {"site": "tip", "preset": "mems"}}) as bridge:
        for _ in range(300):
            mujoco.mj_step(model, data)
            bridge.update()
            sensed.append(bridge.world.sensed["tip"])
    assert np.abs(np.concatenate(sensed)).max() > 1.0
    with pytest.raises(carom.WorldError, match="the model has no such site"):
        carom.mujoco.Bridge(model, data, sensors={"tip": {"site": "top"}})


@pytest.mark.slow
def test_an_environment_observes_its_sensors():
    gymnasium = needs.module("gymnasium")
    import carom.gymnasium

    made = gymnasium.make("InvertedPendulum-v5")
    name = made.unwrapped.model.body(1).name
    env = carom.gymnasium.AddAudioObservation(made, sensors={"wrist": {"body": name, "position": 0.5}}, rate=16_000)
    observation, _ = env.reset(seed=1)
    assert observation["sensors"].shape == (len(observation["audio"]), 1)
    observation, *_ = env.step(env.action_space.sample())
    assert env.observation_space.contains(observation)
    env.close()


RECIPE = """
count = 2
seconds = 0.1
rate = 16000
[object]
preset = "marimba-bar"
[impact]
velocity = { uniform = [0.5, 2.0] }
[sensor]
position = { uniform = [0.1, 0.9] }
preset = "piezo-27"
"""


def test_clips_of_a_data_set_have_their_sensors(tmp_path):
    from carom.clients.dataset.check import require_sound
    from carom.clients.dataset.clip import render
    from carom.clients.dataset.design import items
    from carom.clients.dataset.recipe import read
    from carom.presets import Presets

    path = tmp_path / "bars.toml"
    path.write_text(RECIPE)
    recipe = read(path)
    require_sound(recipe, Presets())
    clips = [render(recipe, item, Presets()) for item in items(recipe, range(2))]
    for clip in clips:
        assert clip.sensed.shape == (1_600, 1)
        assert np.abs(clip.sensed).max() > 10.0
        assert clip.truth["sensors"][0]["unit"] == "m/s^2"
        assert clip.truth["sensors"][0]["position"] == clip.truth["factors"]["sensor.position"]
