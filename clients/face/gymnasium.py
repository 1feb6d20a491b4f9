"""Hearing for Gymnasium's MuJoCo environments: a wrapper whose observations hold the sound of each step.

    env = carom.gymnasium.AddAudioObservation(gymnasium.make("Ant-v5"), microphones=[(0, 0, 1)])
    observation, info = env.reset()
    observation["audio"]   # float32 (frames, channels), in pascals

It needs `pip install 'carom[gymnasium,mujoco]'`.
"""

from typing import Any, cast

import gymnasium
import mujoco
import numpy as np
from gymnasium import spaces
from gymnasium.utils import RecordConstructorArgs
from numpy.typing import ArrayLike, NDArray

from .mujoco import Bridge
from .server.world.bodies import WorldError
from .server.world.hearing import Hearing
from .world import microphones_of

Observation = dict[str, Any]


class AddAudioObservation(gymnasium.Wrapper[Observation, Any, Any, Any], RecordConstructorArgs):
    """An environment that hears: its observations are {"state": the environment's own, "audio": its sound}.

    audio: float32 (frames, channels), in Pa, of the time that an action takes, a channel for each microphone; a longer
    or shorter one, of the time just before the observation, by `frames`. info["hits"]: the blows of the step. options:
    those of a Bridge. The environment is one with MuJoCo's `model` and `data`, as Gymnasium's own are.

    It hears blows alone, as slides and rolls cost most by far, unless a `hearing` says how many of these there may be.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], frames: int | None = None, **options: Any) -> None:
        RecordConstructorArgs.__init__(self, frames=frames, **options)
        gymnasium.Wrapper.__init__(self, env)
        inner = cast(Any, env.unwrapped)
        if not hasattr(inner, "_step_mujoco_simulation"):
            raise WorldError(f"{inner}: expected an environment of Gymnasium with MuJoCo")
        self._inner = inner
        if "hearing" not in options:
            places = options.pop("microphones", Hearing().microphones)
            options = {**options, "hearing": Hearing(microphones_of(places), gestures=0)}
        self._bridge = Bridge(inner.model, inner.data, **options)
        world = self._bridge.world
        self._frames = frames or round(inner.dt * world.rate)
        self._audio = np.zeros((self._frames, world.simulation.channels), np.float32)
        self._hits: list[Any] = []
        sound = spaces.Box(-np.inf, np.inf, self._audio.shape, np.float32)
        self.observation_space = spaces.Dict({"state": env.observation_space, "audio": sound})
        inner._step_mujoco_simulation = self._simulate

    @property
    def bridge(self) -> Bridge:
        """What tells the sound of this environment."""
        return self._bridge

    def _simulate(self, control: ArrayLike, steps: int) -> None:
        """The environment's own steps of MuJoCo, each of which is told."""
        model, data = self._inner.model, self._inner.data
        step, tell, simulation = mujoco.mj_step, self._bridge.tell, self._bridge.world.simulation
        data.ctrl[:] = control
        self._hits = []
        for _ in range(steps):
            step(model, data)
            tell()
            self._hits += simulation.hits
        mujoco.mj_rnePostConstraint(model, data)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset the environment; the first observation is silent."""
        state, info = self.env.reset(seed=seed, options=options)
        self._bridge.restart()
        self._audio[:] = 0.0
        return {"state": state, "audio": self._audio.copy()}, info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Take an action, and hear it."""
        state, reward, terminated, truncated, info = self.env.step(action)
        audio = self._heard(self._bridge.world.block())
        return {"state": state, "audio": audio}, reward, terminated, truncated, {**info, "hits": self._hits}

    def _heard(self, block: NDArray[np.float32]) -> NDArray[np.float32]:
        """The last frames, up to those of a block."""
        if len(block) >= self._frames:
            return block[-self._frames :]
        self._audio = np.concatenate([self._audio, block])[-self._frames :]
        return self._audio.copy()

    def close(self) -> None:
        """End the environment and its sound."""
        self._bridge.world.close()
        super().close()
