"""Models that others wrote, as they are heard: `python -m tests.bench.simulators`.

Counts of bodies that ring, click and are silent, and which are silent and why, for all environments of Gymnasium's
MuJoCo set and, where it is installed (`pip install gymnasium-robotics`), of gymnasium-robotics, at two rates; where an
environment cannot be made, its model is read. Where nothing is heard it says why not. Then a brick on a ramp, over
steps, stiffnesses and cones, and what is loud: a door that slams, and a foot that lands.
"""

import logging
import traceback
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
    """Return how many bodies ring and click, and which are silent, and why."""
    found, silent = Counter[str](), []
    for body in bridge.world.simulation.bodies:
        if not body.rings:
            silent.append(f"{body.name} silent ({body.silence})")
        else:
            found["ring" if body.modes and body.modes.frequency.size else "click"] += 1
    return (
        ", ".join([f"{count} {what}" for what, count in sorted(found.items())] + silent) or "no body can touch another"
    )


class Heard:
    """The sound of a model, step by step: its blows and peak (Pa), and how many points touched at most."""

    def __init__(self, bridge: Bridge, data: mujoco.MjData) -> None:
        self._bridge, self._data = bridge, data
        self._peak, self._hits, self._touched = 0.0, 0, 0

    def add(self, block: np.ndarray, hits: int) -> None:
        """Take the sound of a step, or of an action, and the number of its blows."""
        self._peak = max(self._peak, float(np.abs(block).max(initial=0.0)))
        self._hits += hits
        self._touched = max(self._touched, int(self._data.ncon))

    def __str__(self) -> str:
        counts = self._bridge.world.counts
        told = f"{self._hits} blows, {counts.gestures} slides and rolls, {self._peak:.2g} Pa"
        if self._peak > 0.0:
            return told
        if self._touched == 0:
            return f"{told}: nothing touched"
        faint = counts.faint + counts.over_budget + counts.crowded
        return f"{told}: {self._touched} points touched, " + (f"{faint} too faint" if faint else "all at rest")


def hear_environment(name: str, rate: int) -> str:
    """Return what is heard of an environment that acts at random."""
    env = AddAudioObservation(gymnasium.make(name), microphones=[(0, 0, 1)], rate=rate)
    env.reset(seed=1)
    env.action_space.seed(1)
    heard = Heard(env.bridge, env.unwrapped.data)
    for _ in range(ACTIONS):
        observation, *_, info = env.step(env.action_space.sample())
        heard.add(observation["audio"], len(info["hits"]))
    told = f"{census(env.bridge)}; {heard}"
    env.close()
    return told


def hear_model(path: Path, rate: int) -> str:
    """Return what is heard of a model on which nothing acts but its controls, at random."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    bridge = Bridge(model, data, rate=rate, microphones=[(0, 0, 1)])
    generator, heard = np.random.default_rng(1), Heard(bridge, data)
    low, high = model.actuator_ctrlrange.T if model.nu else (0.0, 0.0)
    while data.time < SECONDS:
        if model.nu and round(data.time / model.opt.timestep) % 50 == 0:
            data.ctrl[:] = generator.uniform(low, high)
        heard.add(bridge.step(), len(bridge.world.hits))
    return f"{census(bridge)}; {heard}"


DOOR = """
<mujoco>
  <custom><text name="carom" data="door wood post {post}"/></custom>
  <worldbody>
    <geom name="post" type="box" size=".05 .05 1" pos=".95 .08 1"/>
    <body name="door" pos="0 0 1">
      <joint type="hinge" axis="0 0 1"/>
      <geom name="door" type="box" size=".45 .02 .98" pos=".5 0 0" mass="20"/>
    </body>
  </worldbody>
</mujoco>"""
"""A solid wooden door, 0.9 m wide, beside its post."""

FOOT = """
<mujoco>
  <custom><text name="carom" data="floor wood foot {foot}"/></custom>
  <worldbody>
    <geom name="floor" type="box" size="2 2 .02" pos="0 0 -.02"/>
    <body name="foot" pos="0 0 .04">
      <freejoint/>
      <geom name="foot" type="capsule" size=".04 .1" euler="0 90 0" mass="3"/>
    </body>
  </worldbody>
</mujoco>"""
"""A foot of 3 kg that comes down on boards."""

AIR = 1.2 * 343.0  # Pa s/m


def loud(name: str, text: str, speed: float, microphone: tuple[float, float, float], away: float) -> None:
    """Print how loud a body is that comes at a speed (rad/s, m/s) and meets another: the peak, the level of the loudest
    35 ms, and which share of its energy goes into the air if it sounds alike in all directions."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qvel[0 if model.nv == 1 else 2] = speed
    data.qpos[0] = -0.6 if model.nv == 1 else data.qpos[0]
    mujoco.mj_forward(model, data)
    mujoco.mj_energyVel(model, data)
    energy = float(data.energy[1])
    bridge, blocks, hits = Bridge(model, data, microphones=[microphone], keep=True), [], []
    while data.time < SECONDS:
        blocks.append(bridge.step())
        hits += bridge.world.hits
    sound = np.concatenate(blocks)[:, 0].astype(np.float64)
    width = round(0.035 * 48_000)
    loudest = np.sqrt(np.convolve(sound**2, np.full(width, 1 / width)).max())
    radiated = 4 * np.pi * away**2 / AIR * (sound**2).sum() / 48_000
    peak = float(np.abs(sound).max())
    print(
        f"{name}: {hits[0].speed:.2g} m/s, {hits[0].impulse:.2g} N s, {energy:.3g} J; peak {peak:.2g} Pa "
        f"({20 * np.log10(peak / 2e-5):.0f} dB), {20 * np.log10(loudest / 2e-5):.0f} dB over 35 ms, "
        f"{100 * radiated / energy:.2g} % of the energy into the air",
        flush=True,
    )


def all_loud() -> None:
    """Print doors that slam, and feet that land."""
    for post in ("wood", "rubber"):
        for speed in (1.0, 3.0):
            loud(f"door at {speed:g} rad/s on {post}, 1.3 m away", DOOR.format(post=post), speed, (0.5, -1.3, 1.0), 1.3)
    for foot in ("wood", "rubber"):
        loud(f"foot of {foot} on wood, 0.9 m away", FOOT.format(foot=foot), -1.0, (0.0, 0.0, 0.9), 0.9)


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
                where = traceback.extract_tb(error.__traceback__)[-1]
                place = f"{Path(where.filename).name}, line {where.lineno}: {where.line}"
                print(f"{name}: cannot be made: {type(error).__name__} in {place}", flush=True)
        for path in models():
            try:
                print(f"{path.parent.name}/{path.name}, {rate} Hz: {hear_model(path, rate)}", flush=True)
            except ValueError as error:
                kind = "REFUSED: " if isinstance(error, carom.WorldError) else "is no model alone: "
                print(f"{path.parent.name}/{path.name}: {kind}{str(error).splitlines()[0]}", flush=True)
    brick()
    all_loud()


if __name__ == "__main__":
    main()
