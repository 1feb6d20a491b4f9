"""Models that others wrote, as they are heard: `python -m tests.bench.simulators`.

Counts of bodies that ring, click and are silent, for all environments of Gymnasium's MuJoCo set and, where it is
installed (`pip install gymnasium-robotics`), of gymnasium-robotics, at two rates; where an environment cannot be made,
its model is read. Then a brick on a ramp, over steps, stiffnesses and cones.
"""

import logging
import re
import warnings
from collections import Counter
from collections.abc import Iterator
from importlib.util import find_spec
from itertools import product
from pathlib import Path

import gymnasium
import mujoco
import numpy as np

import carom
from carom.gymnasium import AddAudioObservation
from carom.mujoco import Bridge
from tests.clients.face.corpus import brick_on_ramp

RATES = 16_000, 48_000  # Hz
ACTIONS, SECONDS = 20, 1.0  # in which an environment, and a model without one, has to sound
RAMPS = tuple(product((0.0005, 0.001, 0.002, 0.004, 0.005), (".02 1", ".002 1"), ("elliptic", "pyramidal")))


def environments() -> Iterator[str]:
    """Yield the names of environments, one for each kind."""
    if find_spec("gymnasium_robotics"):
        import gymnasium_robotics

        gymnasium.register_envs(gymnasium_robotics)
    seen = set()
    for name, spec in gymnasium.registry.items():
        entry = str(spec.entry_point)
        own = "envs.mujoco" in entry and name.endswith("-v5")
        if (own or "gymnasium_robotics" in entry) and entry not in seen:
            seen.add(entry)
            yield name


def models() -> Iterator[Path]:
    """Yield the models of gymnasium-robotics."""
    spec = find_spec("gymnasium_robotics")
    if spec and spec.origin:
        folder = Path(spec.origin).parent / "envs" / "assets"
        yield from sorted(path for path in folder.glob("**/*.xml") if "<worldbody" in path.read_text())


def census(bridge: Bridge) -> str:
    """Return how many bodies ring, click and are silent, and why."""
    found = Counter[str]()
    for body in bridge.world.simulation.bodies:
        if not body.rings:
            found[f"silent ({re.sub(r'[0-9.]+ Hz', 'f', body.silence)})"] += 1
        else:
            found["ring" if body.modes and body.modes.frequency.size else "click"] += 1
    return ", ".join(f"{count} {what}" for what, count in sorted(found.items()))


def hear_environment(name: str, rate: int) -> str:
    """Return what is heard of an environment that acts at random."""
    env = AddAudioObservation(gymnasium.make(name), microphones=[(0, 0, 1)], rate=rate)
    env.reset(seed=1)
    env.action_space.seed(1)
    peak, hits = 0.0, 0
    for _ in range(ACTIONS):
        observation, *_, info = env.step(env.action_space.sample())
        peak, hits = max(peak, float(np.abs(observation["audio"]).max())), hits + len(info["hits"])
    told = f"{census(env.bridge)}; {hits} blows, {peak:.2g} Pa"
    env.close()
    return told


def hear_model(path: Path, rate: int) -> str:
    """Return what is heard of a model on which nothing acts but its controls, at random."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    bridge = Bridge(model, data, rate=rate, microphones=[(0, 0, 1)])
    generator, hits, peak = np.random.default_rng(1), 0, 0.0
    low, high = model.actuator_ctrlrange.T if model.nu else (0.0, 0.0)
    while data.time < SECONDS:
        if model.nu and round(data.time / model.opt.timestep) % 50 == 0:
            data.ctrl[:] = generator.uniform(low, high)
        peak = max(peak, float(np.abs(bridge.step()).max(initial=0.0)))
        hits += len(bridge.world.hits)
    return f"{census(bridge)}; {hits} blows, {bridge.world.counts.gestures} gestures, {peak:.2g} Pa"


def brick() -> None:
    """Print how a brick on a ramp is heard."""
    levels = []
    for way in RAMPS:
        run = brick_on_ramp(*way, above=-1e-4, seconds=0.8)
        levels.append(run.level)
        print(f"brick, step {way[0]} s, solref {way[1]}, {way[2]}: ", end="")
        print(f"{100 * run.share:.0f} % as a slide, {run.level:.1f} dB, {len(run.hits)} blows")
    print(f"brick: from {min(levels):.1f} to {max(levels):.1f} dB")


def main() -> None:
    """Print all of it."""
    warnings.simplefilter("ignore")
    logging.disable(logging.WARNING)
    for rate in RATES:
        for name in environments():
            try:
                print(f"{name}, {rate} Hz: {hear_environment(name, rate)}", flush=True)
            except carom.WorldError as error:
                print(f"{name}, {rate} Hz: REFUSED: {error}", flush=True)
            except gymnasium.error.DependencyNotInstalled:  # mujoco_py, which is no more
                continue
            except Exception as error:
                print(f"{name}: cannot be made: {type(error).__name__}", flush=True)
        for path in models():
            try:
                print(f"{path.parent.name}/{path.name}, {rate} Hz: {hear_model(path, rate)}", flush=True)
            except ValueError as error:
                kind = "REFUSED: " if isinstance(error, carom.WorldError) else "is no model alone: "
                print(f"{path.parent.name}/{path.name}: {kind}{str(error).splitlines()[0]}", flush=True)
    brick()


if __name__ == "__main__":
    main()
