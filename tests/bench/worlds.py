"""The ten scenes of MuJoCo at steps of 1, 2 and 5 ms, and 32 environments of Gymnasium: what is heard, and its cost.

`python -m tests.bench.worlds [SCENE ...]` prints a line for each scene and step: blows, energies, third octaves, and
costs: of MuJoCo's own step, of the bridge, which is all from its arrays to the engine's commands, and of the engine.
`--costs` prints the costs alone, of a pile of 20 bodies too; and those with blows alone. `--vector` prints the steps
per second of the environments, without sound and with it, by a wrapper of each or of all together.

A scene is run several times, and of each of its steps the least time counts: the others were disturbed.
"""

import argparse
import time

import gymnasium
import mujoco
import numpy as np

import carom
from carom.gymnasium import AddAudioObservation, VectorAddAudioObservation
from tests.clients.face.corpus import HEARING, SCENES, apart, over_seeds, prepared, run, shake

STEPS = (0.001, 0.002, 0.005)  # s
SEEDS = {"ramp": 16, "slide": 256}
ENVIRONMENTS, ACTIONS = 32, 40
TURNS = 5


def cost(name: str, step: float, gestures: int = 24) -> np.ndarray:
    """Measure seconds of MuJoCo, of the bridge and of the engine, for each second of a scene; the sound is asked for
    every 20 ms."""
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
            bridge.report()
            told = time.perf_counter()
            if n % each == each - 1:
                bridge.world.block()
            marks[n] = stepped - begun, told - stepped, time.perf_counter() - told
        bridge.world.close()
        least = marks if least is None else np.minimum(least, marks)
    return least.sum(axis=0) / SCENES[name][1]


def cost_line(name: str, step: float) -> str:
    """Say in words what a scene costs."""
    model, bridge, engine = cost(name, step)
    _, alone, blows = cost(name, step, 0)
    return (
        f"for a second: MuJoCo {1e3 * model:.1f} ms, bridge {1e3 * bridge:.1f} ms ({100 * bridge / model:.0f} %), "
        f"engine {1e3 * engine:.1f} ms; sound is {1 / (bridge + engine):.0f} times as fast as time, "
        f"{1 / (alone + blows):.0f} times with blows alone"
    )


def vector(name: str, how: str, gestures: int):
    """Return the environments in a vector, with at most so many slides at once in each; how: silent, each, or
    together."""
    hearing = carom.Hearing([carom.Microphone((0.0, 0.0, 1.0))], gestures=gestures)
    options = {"rate": 16_000, "modes": 16, "hearing": hearing}

    def make():
        env = gymnasium.make(name)
        return AddAudioObservation(env, **options) if how == "each" else env

    envs = gymnasium.vector.SyncVectorEnv([make] * ENVIRONMENTS)
    return VectorAddAudioObservation(envs, **options) if how == "together" else envs


def rates(name: str, gestures: int) -> dict[str, float]:
    """Measure steps per second of environments: silent, with sound by a wrapper of each, and by one of all together; in
    turns."""
    vectors = {how: vector(name, how, gestures) for how in ("silent", "each", "together")}
    generator = np.random.default_rng(0)
    actions = generator.uniform(-0.4, 0.4, (ACTIONS + 1, *vectors["silent"].action_space.shape)).astype(np.float32)
    taken = {how: np.full(len(actions), np.inf) for how in vectors}
    for _ in range(TURNS):
        for how, envs in vectors.items():
            envs.reset(seed=0)
            for n, action in enumerate(actions):
                begun = time.perf_counter()
                envs.step(action)
                taken[how][n] = min(taken[how][n], time.perf_counter() - begun)
    for envs in vectors.values():
        envs.close()
    return {how: ENVIRONMENTS / float(each[1:].mean()) for how, each in taken.items()}


def vectors() -> None:
    for name in ("Ant-v5", "HalfCheetah-v5"):
        for gestures in (24, 0):
            found = rates(name, gestures)
            shares = (f"{100 * found[how] / found['silent']:.0f} % {how}" for how in ("each", "together"))
            words = f"with sound and at most {gestures} slides {', '.join(shares)}"
            print(f"{name}: {found['silent']:.0f} steps per second; {words}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help=f"of {', '.join(SCENES)}; without one, all")
    parser.add_argument("--costs", action="store_true", help="only what they cost")
    parser.add_argument("--vector", action="store_true", help="only environments of Gymnasium")
    options = parser.parse_args()
    unknown = set(options.scenes) - set(SCENES)
    if unknown:
        parser.error(f"{unknown.pop()}: no such scene; expected one of {', '.join(SCENES)}")
    if options.vector:
        return vectors()
    if options.costs:
        SCENES["twenty"] = (lambda step: SCENES["pile"][0](step, 20)), 4.0
        for name in SCENES:
            for step in STEPS:
                print(f"{name:8} {1e3 * step:.0f} ms: {cost_line(name, step)}", flush=True)
        return None
    for name in options.scenes or SCENES:
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
