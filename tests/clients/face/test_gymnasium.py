"""An environment of Gymnasium that hears."""

import pickle

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium", reason="Gymnasium is not installed")
pytest.importorskip("mujoco", reason="MuJoCo is not installed")

from gymnasium.utils.env_checker import check_env  # noqa: E402

import carom  # noqa: E402
from carom.gymnasium import AddAudioObservation, VectorAddAudioObservation  # noqa: E402

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


def turns(envs, steps: int):
    """States and sounds of steps of a vector, from the first on; the blows of each; and the last of each episode."""
    observation, _ = envs.reset(seed=1)
    generator = np.random.default_rng(1)
    seen, hits, last = [observation], [], []
    for _ in range(steps):
        actions = generator.uniform(-1, 1, envs.action_space.shape).astype(np.float32)
        observation, _, _, _, infos = envs.step(actions)
        seen.append(observation)
        before = infos.get("final_info", {}).get("hits", [None] * envs.num_envs)
        hits.append([list(now or then or []) for now, then in zip(infos["hits"], before, strict=True)])
        last += [each for each in infos.get("final_obs", ()) if each is not None]
    envs.close()
    states, sounds = (np.array([each[name] for each in seen]) for name in ("state", "audio"))
    return states, sounds, hits, last


HEARING = {"microphones": [(0, 0, 1)], "rate": 8_000, "modes": 8}


def ants(count: int, mode: str, wrap):
    """A vector of ants whose episodes end after 5 to 8 steps."""
    makers = [lambda n=n: wrap(gymnasium.make("Ant-v5", max_episode_steps=5 + n % 4)) for n in range(count)]
    return gymnasium.vector.SyncVectorEnv(makers, autoreset_mode=mode)


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_a_vector_hears_as_each_of_its_environments_does(mode):
    alone = ants(6, mode, lambda env: AddAudioObservation(env, **HEARING))
    states, sounds, hits, last = turns(alone, 18)
    assert np.abs(sounds).max() > 0.01 and len(last) == (0 if mode == "NextStep" else 16)
    for threads in 0, 1, 3:
        envs = VectorAddAudioObservation(ants(6, mode, lambda env: env), threads=threads, **HEARING)
        assert envs.observation_space["audio"].shape == (6, 400, 1)
        also, heard, found, ended = turns(envs, 18)
        assert np.array_equal(states, also) and np.array_equal(sounds, heard) and hits == found
        for one, other in zip(last, ended, strict=True):
            assert np.array_equal(one["state"], other["state"]) and np.array_equal(one["audio"], other["audio"])


def test_a_vector_of_processes_is_an_error_that_says_what_to_do():
    with pytest.raises(carom.WorldError, match="expected a SyncVectorEnv; in others, wrap each environment"):
        VectorAddAudioObservation(
            gymnasium.make_vec("CartPole-v1", num_envs=2, vectorization_mode="vector_entry_point")
        )


def test_what_cannot_be_told_disturbs_no_other_environment():
    """An environment that diverges says so; the others' sound goes on after it is reset."""
    envs = VectorAddAudioObservation(ants(3, "NextStep", lambda env: env), **HEARING)
    envs.reset(seed=1)
    action = np.zeros(envs.action_space.shape, np.float32)
    envs.step(action)
    plain = envs.bridges[1].tell

    def diverging():
        raise carom.WorldError("body 2: position = nan")

    envs.bridges[1].tell = diverging
    with pytest.raises(carom.WorldError, match="position = nan"):
        envs.step(action)
    envs.bridges[1].tell = plain
    _, sounds, hits, _ = turns(envs, 4)
    _, expected, also, _ = turns(VectorAddAudioObservation(ants(3, "NextStep", lambda env: env), **HEARING), 4)
    assert hits == also
    np.testing.assert_allclose(sounds, expected, atol=1e-4 * np.abs(expected).max())


def test_blows_of_an_action_are_a_sequence_that_can_be_sent():
    env = AddAudioObservation(gymnasium.make("Ant-v5"), **HEARING)
    _, hits = episode(env, 12)
    env.reset(seed=1)
    env.close()
    generator, found = np.random.default_rng(1), []
    env = AddAudioObservation(gymnasium.make("Ant-v5"), **HEARING)
    env.reset(seed=1)
    for _ in range(12):
        found.append(env.step(generator.uniform(-1, 1, env.action_space.shape).astype(np.float32))[4]["hits"])
    env.close()
    assert [len(each) for each in found if each] and pickle.loads(pickle.dumps(found)) == [list(each) for each in found]
    assert [hit for each in found for hit in each] == hits and all(each == list(each) for each in found)
