"""The ten scenes of MuJoCo at steps of 1, 2 and 5 ms, and 32 environments of Gymnasium: what is heard, and its cost.

`python -m tests.bench.worlds [SCENE ...]` prints a line for each scene and step: blows, energies, third octaves, and
costs: of MuJoCo's own step, of the bridge, which is all from its arrays to the engine's commands, and of the engine.
`costs` in place of scenes prints the costs alone, of a pile of 20 bodies too; and those with blows alone. `vector`
prints the steps per second of the environments, with sound and without.

A scene is run several times, and of each of its steps the least time counts: the others were disturbed.
"""

import sys
import time

import gymnasium
import mujoco
import numpy as np

import carom
from carom.gymnasium import AddAudioObservation
from tests.clients.face.corpus import HEARING, SCENES, apart, over_seeds, prepared, run, shake

STEPS = (0.001, 0.002, 0.005)  # s
SEEDS = {"ramp": 16, "slide": 16}
ENVIRONMENTS, ACTIONS = 32, 40
TURNS = 5


def cost(name: str, step: float, gestures: int = 24) -> np.ndarray:
    """Seconds of MuJoCo, of the bridge and of the engine, for each second of a scene; the sound is asked for every 20
    ms."""
    each, hearing = round(0.02 / step), carom.Hearing(HEARING.microphones, gestures=gestures)
    least = None
    for _ in range(TURNS):
        model, data, bridge = prepared(name, step, hearing)
        marks = np.zeros((round(SCENES[name][1] / step), 3))
        for n in range(len(marks)):
            shake(name, data)
            begun = time.perf_counter()
            mujoco.mj_step(model, data)
            stepped = time.perf_counter()
            bridge.tell()
            told = time.perf_counter()
            if n % each == each - 1:
                bridge.world.block()
            marks[n] = stepped - begun, told - stepped, time.perf_counter() - told
        bridge.world.close()
        least = marks if least is None else np.minimum(least, marks)
    return least.sum(axis=0) / SCENES[name][1]


def cost_line(name: str, step: float) -> str:
    """What a scene costs, in words."""
    model, bridge, engine = cost(name, step)
    _, alone, blows = cost(name, step, 0)
    return (
        f"for a second: MuJoCo {1e3 * model:.1f} ms, bridge {1e3 * bridge:.1f} ms ({100 * bridge / model:.0f} %), "
        f"engine {1e3 * engine:.1f} ms; sound is {1 / (bridge + engine):.0f} times as fast as time, "
        f"{1 / (alone + blows):.0f} times with blows alone"
    )


def rate(name: str, gestures: int | None) -> float:
    """Steps per second of environments in a vector, with so many slides at once in each (None: without sound)."""

    def make():
        env = gymnasium.make(name)
        if gestures is None:
            return env
        hearing = carom.Hearing([carom.Microphone((0.0, 0.0, 1.0))], gestures=gestures)
        return AddAudioObservation(env, rate=16_000, modes=16, hearing=hearing)

    envs = gymnasium.vector.SyncVectorEnv([make] * ENVIRONMENTS)
    generator = np.random.default_rng(0)
    actions = generator.uniform(-0.4, 0.4, (ACTIONS + 1, *envs.action_space.shape)).astype(np.float32)
    turns = []
    for _ in range(TURNS):
        envs.reset(seed=0)
        taken = []
        for action in actions:
            begun = time.perf_counter()
            envs.step(action)
            taken.append(time.perf_counter() - begun)
        turns.append(taken)
    envs.close()
    return ENVIRONMENTS / float(np.min(turns, axis=0)[1:].mean())


def vectors() -> None:
    for name in ("Ant-v5", "HalfCheetah-v5"):
        silent = rate(name, None)
        for gestures in (24, 0):
            share = rate(name, gestures) / silent
            print(
                f"{name}: {silent:.0f} steps per second; with sound and at most {gestures} slides {100 * share:.0f} %"
            )


def main() -> None:
    if sys.argv[1:] == ["vector"]:
        return vectors()
    if sys.argv[1:] == ["costs"]:
        SCENES["twenty"] = (lambda step: SCENES["pile"][0](step, 20)), 4.0
        for name in SCENES:
            for step in STEPS:
                print(f"{name:8} {1e3 * step:.0f} ms: {cost_line(name, step)}", flush=True)
        return None
    for name in sys.argv[1:] or SCENES:
        first = None
        for step in STEPS:
            heard = run(name, step)
            bands = over_seeds(name, step, SEEDS.get(name, 1))
            first = bands if first is None else first
            print(
                f"{name:8} {1e3 * step:.0f} ms: {len(heard.hits):4} blows, {heard.energy:.3g} Pa^2 s, third octaves "
                f"within {apart(first, bands):.2f} dB; {cost_line(name, step)}",
                flush=True,
            )
    return None


if __name__ == "__main__":
    main()
