"""An environment of Gymnasium that hears."""

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium", reason="Gymnasium is not installed")
pytest.importorskip("mujoco", reason="MuJoCo is not installed")

from gymnasium.utils.env_checker import check_env  # noqa: E402

import carom  # noqa: E402
from carom.gymnasium import AddAudioObservation  # noqa: E402

pytestmark = pytest.mark.slow


def episode(env, steps: int):
    """The sounds of an episode of the same actions, and its blows."""
    observation, _ = env.reset(seed=1)
    assert observation in env.observation_space and not observation["audio"].any()
    generator = np.random.default_rng(1)
    sounds, hits = [], []
    for _ in range(steps):
        action = generator.uniform(-1, 1, env.action_space.shape).astype(np.float32)
        observation, _, _, _, info = env.step(action)
        sounds.append(observation["audio"])
        hits += info["hits"]
    return np.concatenate(sounds), hits


def test_an_ant_hears_its_steps_and_each_episode_alike():
    env = AddAudioObservation(gymnasium.make("Ant-v5"), microphones=[(0, 0, 1), (0, 1, 1)], rate=16_000)
    sound, hits = episode(env, 20)
    assert sound.shape == (20 * 800, 2) and len(hits) > 2 and np.abs(sound).max() > 0.01
    first = round((min(hit.time for hit in hits) + 0.004) * 16_000)
    assert not sound[: first - 100].any() and np.abs(sound[first : first + 160]).max() > 0
    assert env.bridge.world.counts.gestures == 0  # of its own accord it hears blows alone
    again, later = episode(env, 20)
    assert [hit.impulse for hit in hits] == [hit.impulse for hit in later]
    np.testing.assert_allclose(again, sound, atol=1e-4 * np.abs(sound).max())
    env.close()


@pytest.mark.filterwarnings("ignore::UserWarning")  # its advice on spaces
def test_it_is_an_environment_as_gymnasium_wants_it():
    env = AddAudioObservation(gymnasium.make("InvertedPendulum-v5", disable_env_checker=True), rate=8_000)
    check_env(env, skip_render_check=True)
    env.close()


def test_another_environment_is_an_error():
    with pytest.raises(carom.WorldError, match="expected an environment of Gymnasium with MuJoCo"):
        AddAudioObservation(gymnasium.make("CartPole-v1"))
