"""An environment of Gymnasium that hears."""

import pickle

import numpy as np
import pytest

from tests import needs

gymnasium = needs.module("gymnasium")
mujoco = needs.module("mujoco")

from gymnasium.utils.env_checker import check_env  # noqa: E402

import carom  # noqa: E402
from carom.gymnasium import AddAudioObservation, VectorAddAudioObservation  # noqa: E402

pytestmark = pytest.mark.slow


def episode(env, steps: int):
    """Return the sounds of an episode of the same actions, and its blows."""
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
def test_hearing_environment_passes_the_check_of_gymnasium():
    env = AddAudioObservation(gymnasium.make("InvertedPendulum-v5", disable_env_checker=True), rate=8_000)
    check_env(env, skip_render_check=True)
    env.close()


def test_another_environment_is_an_error():
    with pytest.raises(carom.WorldError, match="expected an environment with MuJoCo's model and data"):
        AddAudioObservation(gymnasium.make("CartPole-v1"))


class Simulated(gymnasium.Env):
    """A ball that falls, by any way of taking steps; a reset lets it fall for a while."""

    observation_space = action_space = gymnasium.spaces.Box(-1, 1, (1,))
    dt = 0.02

    def __init__(self, stepping):
        text = """<mujoco><worldbody><geom name="floor" type="plane" size="1 1 .1"/>
        <body name="ball" pos="0 0 .07"><freejoint/><geom size=".02"/></body></worldbody></mujoco>"""
        self.model = mujoco.MjModel.from_xml_string(text)
        self.data = mujoco.MjData(self.model)
        self._stepping = stepping

    def reset(self, *, seed=None, options=None):
        mujoco.mj_resetData(self.model, self.data)
        mujoco.mj_step(self.model, self.data, nstep=3)
        return np.zeros(1, np.float32), {}

    def step(self, action):
        self._stepping(self.model, self.data)
        return np.zeros(1, np.float32), 0.0, False, False, {}


def halves(model, data):
    for _ in range(10):
        mujoco.mj_step1(model, data)
        mujoco.mj_step2(model, data)


own_step = mujoco.mj_step


def test_sound_of_an_environment_is_the_same_however_that_takes_its_steps():
    """A ball falls by 5 cm in 0.101 s, and is heard in the sixth action: by one call, by many, by halves of steps."""
    ways = (
        lambda model, data: mujoco.mj_step(model, data, 10),
        lambda model, data: [mujoco.mj_step(m=model, d=data) for _ in range(10)],
        halves,
    )
    sounds = []
    for way in ways:
        env = AddAudioObservation(Simulated(way), **HEARING)
        sound, hits = episode(env, 8)
        (hit,) = hits
        assert hit.time == pytest.approx((2 * 0.05 / 9.81) ** 0.5 - 0.001, abs=1e-4)  # by half a step, as Euler falls
        sounds.append(sound)
        env.close()
    assert mujoco.mj_step is own_step
    assert np.abs(sounds[0]).max() > 0.01
    for sound in sounds[1:]:
        np.testing.assert_array_equal(sounds[0], sound)


@pytest.mark.parametrize("unstable", [False, True])
@pytest.mark.parametrize("vector", [False, True])
def test_an_environment_that_resets_its_data_in_a_step_is_heard_again(vector, unstable, tmp_path, monkeypatch):
    """A ball falls and lands in 8 actions, twice; its data is reset by the environment, or by MuJoCo as it is
    unstable."""
    monkeypatch.chdir(tmp_path)  # of MuJoCo's log
    taken = []

    def fall(model, data):
        mujoco.mj_step(model, data, 10)
        taken.append(data.time)
        if len(taken) == 8 and unstable:
            data.qvel[0] = 1e11
        elif len(taken) == 8:
            mujoco.mj_resetData(model, data)

    env = Simulated(fall)
    if vector:
        env = VectorAddAudioObservation(gymnasium.vector.SyncVectorEnv([lambda inner=env: inner]), **HEARING)
    else:
        env = AddAudioObservation(env, **HEARING)
    env.reset()
    taken.clear()
    hits = [env.step(np.zeros((1, 1) if vector else 1))[-1]["hits"] for _ in range(17)]
    assert [n for n, found in enumerate(hits) if len(found[0] if vector else found)] == [4, 13]
    env.close()


def test_steps_that_cannot_be_heard_are_an_error():
    env = AddAudioObservation(Simulated(lambda model, data: own_step(model, data, 10)), **HEARING)
    env.reset()
    with pytest.raises(carom.WorldError, match="goes on without mujoco"):
        env.step(np.zeros(1))
    env.close()


def turns(envs, steps: int):
    """Return the states and sounds of steps of a vector, from the first on; the blows of each; and the last of each
    episode."""
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
    """Return a vector of ants whose episodes end after 5 to 8 steps."""
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


def test_diverging_environment_disturbs_no_other():
    """An environment that diverges says so; the others' sound goes on after it is reset."""
    envs = VectorAddAudioObservation(ants(3, "NextStep", lambda env: env), **HEARING)
    envs.reset(seed=1)
    action = np.zeros(envs.action_space.shape, np.float32)
    envs.step(action)
    plain = envs.bridges[1].report

    def diverging():
        raise carom.WorldError("body 2: position = nan")

    envs.bridges[1].report = diverging
    with pytest.raises(carom.WorldError, match="position = nan"):
        envs.step(action)
    envs.bridges[1].report = plain
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


class Settling(gymnasium.Wrapper):
    """An environment whose body falls for a while as it resets."""

    def reset(self, **options):
        found = self.env.reset(**options)
        self.unwrapped.do_simulation(np.zeros(self.action_space.shape), 100)
        return found


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_steps_that_a_wrapper_simulates_as_it_resets_are_not_heard(mode):
    alone = ants(2, mode, lambda env: AddAudioObservation(Settling(env), frames=900, **HEARING))
    together = VectorAddAudioObservation(ants(2, mode, Settling), frames=900, **HEARING)
    one, other = turns(alone, 9), turns(together, 9)
    assert not one[1][0].any() and one[1].any()
    assert np.array_equal(one[0], other[0]) and np.array_equal(one[1], other[1]) and one[2] == other[2]


def test_blows_that_were_returned_stay_as_they_are():
    env = AddAudioObservation(gymnasium.make("Ant-v5"), **HEARING)
    env.reset(seed=1)
    hits, action = [], np.zeros(env.action_space.shape, np.float32)
    while not hits:
        hits = env.step(action)[4]["hits"]
    count = len(hits)
    for _ in range(20):
        env.unwrapped.step(action)
    assert len(hits) == len(list(hits)) == count and hits + hits == list(hits) + hits == 2 * list(hits) and hits != ""
    env.close()


def test_a_reset_of_some_after_an_error_leaves_the_sound_of_the_others():
    heard = []
    for wrap in (lambda env: AddAudioObservation(env, **HEARING), None):
        envs = ants(3, "Disabled", wrap or (lambda env: env))
        envs = envs if wrap else VectorAddAudioObservation(envs, **HEARING)
        envs.reset(seed=1)
        action = np.zeros(envs.action_space.shape, np.float32)
        for _ in range(4):
            envs.step(action)
        inner = envs.unwrapped.envs[2].unwrapped
        plain, inner._step_mujoco_simulation = inner._step_mujoco_simulation, None
        with pytest.raises(TypeError):
            envs.step(action)
        inner._step_mujoco_simulation = plain
        observation, _ = envs.reset(options={"reset_mask": np.array([False, False, True])})
        heard.append(observation["audio"] if wrap is None else [each["audio"] for each in envs._env_obs])
    assert np.array_equal(heard[0][2], heard[1][2]) and not heard[1][2].any() and heard[1][:2].any()


def plain(env) -> bool:
    """True if nothing of an environment was replaced."""
    return not {"_step_mujoco_simulation", "reset"} & (set(vars(env)) | set(vars(env.unwrapped)))


def test_bad_input_is_told_and_leaves_the_environments_as_they_were():
    envs = ants(3, "NextStep", lambda env: env)
    for options, words in (
        ({"threads": "2"}, "threads = '2': expected a whole number from 0 on"),
        ({"threads": -1}, "threads = -1: expected a whole number from 0 on"),
        ({"frames": 0}, "frames = 0: expected a whole number from 1 on"),
        ({"microphones": 3}, r"microphones = 3: expected Microphones or places \(m\)"),
        ({"world": carom.World()}, "world: expected none, as each environment has one of its own"),
    ):
        with pytest.raises(carom.WorldError, match=words):
            VectorAddAudioObservation(envs, **options)
    assert all(plain(env) for env in envs.envs)
    envs.envs[2].unwrapped.frame_skip = 10
    with pytest.raises(carom.WorldError, match="environment 2: 4800 frames per action; expected 2400, as of the first"):
        VectorAddAudioObservation(envs)
    assert all(plain(env) for env in envs.envs)
    first = AddAudioObservation(envs.envs[0])
    with pytest.raises(carom.WorldError, match="expected an environment without sound; this one has it already"):
        VectorAddAudioObservation(envs)
    with pytest.raises(carom.WorldError, match="expected an environment without sound; this one has it already"):
        AddAudioObservation(first)
    first.close()
    first.close()
    assert all(plain(env) for env in envs.envs)
