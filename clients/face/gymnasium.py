"""Hearing for Gymnasium's MuJoCo environments: wrappers whose observations hold the sound of each step.

    env = carom.gymnasium.AddAudioObservation(gymnasium.make("Ant-v5"), microphones=[(0, 0, 1)])
    observation, info = env.reset()
    observation["audio"]   # float32 (frames, channels), in pascals

    envs = carom.gymnasium.VectorAddAudioObservation(gymnasium.make_vec("Ant-v5", num_envs=32), microphones=[(0, 0, 1)])

It needs `pip install 'carom[gymnasium,mujoco]'`.
"""

from collections.abc import Callable
from typing import Any, cast

import gymnasium
import mujoco
import numpy as np
from gymnasium import spaces
from gymnasium.utils import RecordConstructorArgs
from gymnasium.vector import SyncVectorEnv, VectorEnv, VectorWrapper
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from .clients.processors import processors
from .dsp.arguments import explain_all_arguments
from .dsp.runtime.batch import Batch
from .mujoco import NO_STEPS, Bridge, bare
from .server.bridge.blows import Hits
from .server.bridge.checks import WorldError
from .server.bridge.hearing import Hearing, microphones_of
from .server.bridge.mujoco.stepping import forget, listen
from .world import Blocks

Observation = dict[str, Any]


@explain_all_arguments
class AddAudioObservation(gymnasium.Wrapper[Observation, Any, Any, Any], RecordConstructorArgs):
    """An environment that hears: its observations are {"state": the environment's own, "audio": its sound}.

    `audio` is float32 (frames, channels), in Pa. With `sensors` there is "sensors", float32 (frames, sensors), each
    in its unit. info["hits"] has the blows of the step. It hears blows alone, unless `hearing` allows slides, rolls
    and rests.

    Parameters
    ----------
    env : Env
        An environment that has MuJoCo's `model` and `data` and steps them by `mujoco.mj_step`.
    frames : int, optional
        Length of the sound. Default: the time of an action.
    **options
        Options of a Bridge.

    Raises
    ------
    WorldError
        Any other environment, or one that hears already.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], frames: int | None = None, **options: Any) -> None:
        RecordConstructorArgs.__init__(self, _disable_deepcopy=True, frames=frames, **options)
        gymnasium.Wrapper.__init__(self, env)
        self._sound = _Sound(env, frames, options)
        self.observation_space = spaces.Dict({"state": env.observation_space, **self._sound.spaces})

    @property
    def bridge(self) -> Bridge:
        """The bridge that computes this environment's sound."""
        return self._sound.bridge

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset the environment; the first observation is silent."""
        state, info = self.env.reset(seed=seed, options=options)
        return {"state": state, **self._sound.heard}, info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Take an action, and hear it."""
        self._sound.begin()
        state, reward, terminated, truncated, info = self.env.step(action)
        hits = self._sound.end()
        return {"state": state, **self._sound.heard}, reward, terminated, truncated, {**info, "hits": hits}

    def close(self) -> None:
        """End the environment and its sound."""
        self._sound.close()
        super().close()


@explain_all_arguments
class VectorAddAudioObservation(VectorWrapper, RecordConstructorArgs):
    """A SyncVectorEnv that hears; threads compute the sound of one environment while the next one acts.

    Observations are {"state": (n, ...), "audio": (n, frames, channels)}. infos["hits"] has the blows of each
    environment's step. In an AsyncVectorEnv, wrap each environment with AddAudioObservation.

    Parameters
    ----------
    env : SyncVectorEnv
        The environments.
    frames : int, optional
        As for AddAudioObservation.
    threads : int, optional
        Number of threads. Default: one for each further processor.
    **options
        Options of a Bridge, for each environment.

    Raises
    ------
    WorldError
        The environment is no SyncVectorEnv, or as for AddAudioObservation.
    """

    def __init__(
        self, env: VectorEnv[Any, Any, Any], frames: int | None = None, threads: int | None = None, **options: Any
    ) -> None:
        RecordConstructorArgs.__init__(self, _disable_deepcopy=True, frames=frames, threads=threads, **options)
        inner = env.unwrapped
        if not isinstance(inner, SyncVectorEnv):
            raise WorldError(f"{inner}: expected a SyncVectorEnv; in others, wrap each environment")
        if options.get("world") is not None:
            raise WorldError("world: expected none, as each environment has one of its own")
        count = len(inner.envs)
        further = processors() - 1 if threads is None else _whole("threads", threads, 0)
        self._batch = Batch(count, min(count - 1, further))
        self._sounds = _sounds(inner.envs, frames, options, self._batch)
        super().__init__(env)  # last, as a wrapper that has an environment closes it when it is dropped
        space = spaces.Dict({"state": env.single_observation_space, **self._sounds[0].spaces})
        self.single_observation_space = space
        self.observation_space = batch_space(space, count)

    @property
    def bridges(self) -> list[Bridge]:
        """The bridges that compute the sound of each environment."""
        return [sound.bridge for sound in self._sounds]

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset the environments; the first observations are silent."""
        state, infos = self.env.reset(seed=seed, options=options)
        return self._observed(state), infos

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Take an action in each environment, and hear them."""
        hits = np.empty(len(self._sounds), object)
        for sound in self._sounds:
            sound.begin()
        try:
            state, rewards, terminations, truncations, infos = self.env.step(actions)
        finally:
            self._batch.finish()
            for number, sound in enumerate(self._sounds):
                hits[number] = sound.end()
        if not isinstance(infos, dict):
            raise WorldError(f"{self.env}: infos = {type(infos).__name__}: expected a dictionary; wrap it around this")
        for ended in np.flatnonzero(infos.get("_final_obs", ())).tolist():
            last = {"state": infos["final_obs"][ended], **self._sounds[ended].last}
            infos["final_obs"][ended] = last
        infos |= {"hits": hits, "_hits": np.ones(len(hits), bool)}
        return self._observed(state), rewards, terminations, truncations, infos

    def _observed(self, state: Any) -> Observation:
        names = self._sounds[0].heard
        return {"state": state, **{name: np.array([sound.heard[name] for sound in self._sounds]) for name in names}}

    def close(self, **options: Any) -> None:
        """End the environments and their sound."""
        self._batch.close()
        for sound in self._sounds:
            sound.close()
        super().close(**options)


def _sounds(envs: list[Any], frames: int | None, options: dict[str, Any], batch: Batch) -> list["_Sound"]:
    """Return the sound of each environment of a vector: of all, or of none."""
    made: list[_Sound] = []
    try:
        for number, env in enumerate(envs):
            made.append(_Sound(env, frames, options, batch))
            one, other = made[0].frames, made[-1].frames
            if one != other:
                raise WorldError(f"environment {number}: {other} frames per action; expected {one}, as of the first")
    except BaseException:
        for each in made:
            each.close()
        raise
    return made


def _whole(name: str, value: Any, least: int) -> int:
    """Return a whole number; raise WorldError for anything else."""
    if not isinstance(value, int | np.integer) or value < least:
        raise WorldError(f"{name} = {value!r}: expected a whole number from {least} on")
    return int(value)


def simulated_by(env: Any) -> Any:
    """Return what has MuJoCo's model and data: an environment, its `physics` of dm_control, its `sim` of robosuite."""
    for each in (env, *(getattr(env, name, None) for name in ("physics", "sim", "env"))):
        if hasattr(each, "model") and hasattr(each, "data"):
            return each
    raise WorldError(f"{env}: expected an environment with MuJoCo's model and data")


def seconds_of(env: Any, model: mujoco.MjModel) -> float:
    """Return the time that an action takes (s), as an environment says it, or one within it."""
    inner = env.unwrapped
    for each in (inner, *vars(inner).values()):
        if isinstance(dt := getattr(each, "dt", None), int | float | np.number):
            return float(dt)
        if isinstance(steps := getattr(each, "frame_skip", None), int):
            return steps * float(model.opt.timestep)
    raise WorldError(f"{env}: the duration of an action is unknown: expected `frames`")


class _Sound:
    """The sound of an environment, to which each of its steps of MuJoCo is reported, and begins anew where it is reset.

    batch: has blocks computed; they are there after its `finish`.
    """

    def __init__(
        self, env: gymnasium.Env[Any, Any], frames: int | None, options: dict[str, Any], batch: Batch | None = None
    ) -> None:
        inner = cast(Any, env.unwrapped)
        simulated = simulated_by(inner)
        if "hearing" not in options:
            places = options.get("microphones", Hearing().microphones)
            others = {name: value for name, value in options.items() if name != "microphones"}
            options = {**others, "hearing": Hearing(microphones_of(places), gestures=0, rests=0)}
        length = None if frames is None else _whole("frames", frames, 1)
        self._inner, self._batch = inner, batch
        model, self._data = bare(simulated.model, mujoco.MjModel), bare(simulated.data, mujoco.MjData)
        self.bridge = Bridge(model, self._data, **options)
        world = self.bridge.world
        self.frames = length or round(seconds_of(env, model) * world.rate)
        self._channels = world.channels
        self._shape = self.frames, self._channels + len(world.sensed)
        self._audio = self._final = np.zeros(self._shape, np.float32)
        self.spaces = {name: spaces.Box(-np.inf, np.inf, part.shape, np.float32) for name, part in self.heard.items()}
        self._blows: list[NDArray[np.void]] = []
        self._block: Blocks | None = None
        self._anew, self._resetting = True, 0  # nothing was simulated since it began; it is being reset, within resets
        self._stepped, self._at = False, self._data.time  # since an action began; when that was
        self._before: list[tuple[Any, str, Any]] = []
        self._resets = inner.reset, env.reset
        try:
            listen(self._data, self._simulate)
        except WorldError:
            world.close()
            raise WorldError(f"{env}: expected an environment without sound; this one has it already") from None
        self._replace(inner, "reset", self._reset)
        if env is not inner:  # what a wrapper simulates as it resets is not heard either
            self._replace(env, "reset", self._reset_whole)

    @property
    def heard(self) -> dict[str, Blocks]:
        """The sound and the signals of sensors before the observation, by name."""
        return self._parts(self._audio)

    @property
    def last(self) -> dict[str, Blocks]:
        """The same just before the last reset."""
        return self._parts(self._final)

    def _parts(self, whole: Blocks) -> dict[str, Blocks]:
        if whole.shape[1] == self._channels:
            return {"audio": whole}
        return {"audio": whole[:, : self._channels], "sensors": whole[:, self._channels :]}

    def _replace(self, of: Any, name: str, method: Any) -> None:
        """Put a method in the place of another, until `close`."""
        self._before.append((of, name, vars(of).get(name)))
        setattr(of, name, method)

    def begin(self) -> None:
        """Begin an action."""
        self._blows = []
        self._stepped, self._at = False, self._data.time

    def end(self) -> Hits:
        """Hear what was simulated; the blows of the action."""
        self._hear()
        if not self._stepped and self._data.time > self._at:
            raise WorldError(f"{self._inner}: {NO_STEPS}")
        blows, self._blows = self._blows, []
        return Hits(blows, self.bridge.world.simulation.bodies)

    def close(self) -> None:
        """Leave the environment as it was, and end its World."""
        while self._before:
            of, name, method = self._before.pop()
            if method is None:
                delattr(of, name)
            else:
                setattr(of, name, method)
        forget(self._data)
        self.bridge.world.close()

    def _hear(self) -> None:
        if self._block is not None:
            block, self._block = self._block, None
            frames = self.frames
            self._audio = block if len(block) == frames else np.concatenate([self._audio, block])[-frames:]

    def _simulate(self, step: Callable[[], None], count: int) -> None:
        """Take so many steps of MuJoCo, and report each; none as the environment is reset."""
        self._anew, self._stepped = False, True
        if self._resetting:
            for _ in range(count):
                step()
            return
        self._settle()
        self.bridge.restart_if_set_back()  # an environment may reset its data within a step
        report, simulation = self.bridge.report_or_restart, self.bridge.world.simulation
        for _ in range(count):
            step()
            if report():
                self._blows.append(simulation.blows)
        self._block = self.bridge.world.whole_block(self._batch)

    def _settle(self) -> None:
        """Hear what is still being computed, before the World goes on."""
        if self._block is not None:
            if self._batch:
                self._batch.finish()
            self._hear()

    def _reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        """Reset the environment, in silence."""
        self._settle()
        self._final = self._audio
        found = self._silently(0, seed, options)
        self._begin_anew()
        return found

    def _reset_whole(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
        """Reset the environment with all that is wrapped around it."""
        found = self._silently(1, seed, options)
        if not self._anew:
            self._begin_anew()
        return found

    def _silently(self, which: int, seed: int | None, options: dict[str, Any] | None) -> Any:
        """Reset the environment, or all of it, by its own method; what it simulates meanwhile is not heard."""
        self._resetting += 1
        try:
            return self._resets[which](seed=seed, options=options)
        finally:
            self._resetting -= 1

    def _begin_anew(self) -> None:
        if bare(simulated_by(self._inner).data, mujoco.MjData) is not self._data:
            raise WorldError(f"{self._inner}: expected a reset of its data; it has made others, which nobody hears")
        self.bridge.restart()
        self._audio = np.zeros(self._shape, np.float32)
        self._anew = True
