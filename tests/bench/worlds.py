"""The ten scenes of MuJoCo at steps of 1, 2 and 5 ms: blows, energies, third octaves, and what their sound costs.

`python -m tests.bench.worlds [SCENE ...]` prints a line for each scene and step. Costs are shares of one process's
time: of MuJoCo's own step, of the bridge, and of the rest, which is messages and the engine.
"""

import sys
import time

import mujoco
import numpy as np

from tests.clients.face.corpus import SCENES, apart, over_seeds, prepared, run, shake

STEPS = (0.001, 0.002, 0.005)  # s
SEEDS = {"ramp": 16, "slide": 16}


def cost(name: str, step: float) -> tuple[float, float, float]:
    """Seconds of MuJoCo, of the bridge and of the sound, for each second of a scene."""
    model, data, bridge = prepared(name, step)
    lasts = SCENES[name][1]
    marks = np.zeros(3)
    for _ in range(round(lasts / step)):
        shake(name, data)
        begun = time.perf_counter()
        mujoco.mj_step(model, data)
        stepped = time.perf_counter()
        bridge.tell()
        told = time.perf_counter()
        bridge.world.block()
        marks += stepped - begun, told - stepped, time.perf_counter() - told
    return tuple(marks / lasts)


def main() -> None:
    for name in sys.argv[1:] or SCENES:
        first = None
        for step in STEPS:
            heard = run(name, step)
            bands = over_seeds(name, step, SEEDS.get(name, 1))
            first = bands if first is None else first
            model, bridge, sound = cost(name, step)
            print(
                f"{name:8} {1e3 * step:.0f} ms: {len(heard.hits):4} blows, {heard.energy:.3g} Pa^2 s, third octaves "
                f"within {apart(first, bands):.2f} dB; for a second: MuJoCo {1e3 * model:.1f} ms, "
                f"bridge and messages {1e3 * bridge:.1f} ms, engine {1e3 * sound:.1f} ms",
                flush=True,
            )


if __name__ == "__main__":
    main()
