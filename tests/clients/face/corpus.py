"""The ten scenes of clients/examples/mujoco, run and heard; what MuJoCo itself knows of their blows."""

import importlib.util
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import mujoco
import numpy as np

import carom
from carom.mujoco import Bridge

EXAMPLES = Path(__file__).parents[3] / "clients" / "examples" / "mujoco"
HEARING = carom.Hearing([carom.Microphone((0.0, -0.5, 0.6))])


def module(name: str):
    """Import a file of the examples."""
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


SCENES = module("scenes").SCENES
shake = module("scenes").shake


class Run(NamedTuple):
    """A scene that was heard: its blows, sound and counts, and for each step the forces of pairs that touched."""

    hits: list[carom.Hit]
    sound: np.ndarray
    counts: object
    forces: list[dict[tuple[str, str], float]]
    speeds: np.ndarray
    """(steps, nv): MuJoCo's velocities before each step."""
    score: str = ""
    """The score, if it was kept."""

    @property
    def energy(self) -> float:
        return float((self.sound.astype(np.float64) ** 2).sum() / 48_000)


def prepared(name: str, step: float, hearing: carom.Hearing = HEARING, keep: bool = False):
    """Return a scene at a step (s) before its start: MuJoCo's model and data, and what hears them."""
    make, _ = SCENES[name]
    model = mujoco.MjModel.from_xml_string(make(step))
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    return model, data, Bridge(model, data, hearing=hearing, keep=keep)


def run(
    name: str,
    step: float,
    seconds: float | None = None,
    hearing: carom.Hearing = HEARING,
    keep: bool = False,
    tells_forces: bool = False,
) -> Run:
    """Run a scene at a step (s), and hear it; tells_forces: MuJoCo is asked for them at each step, which takes long."""
    model, data, bridge = prepared(name, step, hearing, keep)
    hits, blocks, forces, speeds = [], [], [], []
    for _ in range(round((seconds or SCENES[name][1]) / step)):
        shake(name, data)
        speeds.append(data.qvel.copy())
        blocks.append(bridge.step())
        hits += bridge.world.hits
        if tells_forces:
            forces.append(_forces(model, data))
    score = bridge.world.score() if keep else ""
    return Run(hits, np.concatenate(blocks), bridge.world.counts, forces, np.array(speeds), score)


def _forces(model, data) -> dict[tuple[str, str], float]:
    """Return the normal force between each pair of bodies, by MuJoCo's own function."""
    found: dict[tuple[str, str], float] = {}
    force = np.empty(6)
    for number in range(data.ncon):
        mujoco.mj_contactForce(model, data, number, force)
        ends = []
        for geom in data.contact[number].geom:
            body = model.geom_bodyid[geom]
            named = model.body(body).name if model.body_dofnum[body] else model.geom(geom).name
            ends.append(named or f"geom{geom}")
        pair = tuple(sorted(ends))
        if force[0] > 0:
            found[pair] = found.get(pair, 0.0) + force[0]
    return found


def episodes(forces, pair, apart: int = 3) -> list[tuple[int, int]]:
    """Return the runs of steps in which a pair pushes, first and last; those fewer than `apart` steps apart are one."""
    steps = [n for n, each in enumerate(forces) if pair in each]
    found: list[tuple[int, int]] = []
    for n in steps:
        if found and n - found[-1][1] < apart:
            found[-1] = (found[-1][0], n)
        else:
            found.append((n, n))
    return found


def thirds(sound: np.ndarray) -> np.ndarray:
    """Return the energy in third octaves from 100 Hz to 16 kHz, of the first channel."""
    power = np.abs(np.fft.rfft(sound[:, 0].astype(np.float64))) ** 2
    frequency = np.fft.rfftfreq(len(sound), 1 / 48_000)
    edges = 1000 * 2 ** ((np.arange(-10, 14) - 0.5) / 3)
    bands = pairwise(edges)
    return np.array([power[(frequency >= low) & (frequency < high)].sum() for low, high in bands])


def apart(one: np.ndarray, other: np.ndarray, least: float = -20.0) -> float:
    """Return the greatest difference (dB) between two sounds' third octaves, of those within `least` dB of the
    loudest."""
    loud = one > one.max() * 10 ** (least / 10)
    return float(np.abs(10 * np.log10(other[loud] / one[loud])).max())


def over_seeds(name: str, step: float, seeds: int) -> np.ndarray:
    """Return the third octaves of a scene over surfaces of several seeds."""
    hearings = [carom.Hearing(HEARING.microphones, seed=seed) for seed in range(seeds)]
    return np.mean([thirds(run(name, step, hearing=hearing).sound) for hearing in hearings], axis=0)


def separation(run: Run, first: int, last: int, rate) -> tuple[float, float]:
    """Return the speeds before and after an episode; rate: of approach, for a row of MuJoCo's velocities."""
    speeds = [rate(row) for row in run.speeds[first : last + 2]]
    return speeds[0], -min(speeds)


class Ramp(NamedTuple):
    """A brick that slid down a ramp: its blows, the share of the time that it is heard as a slide, the level (dB)."""

    hits: list[carom.Hit]
    share: float
    level: float


def brick_on_ramp(step: float, solref: str, cone: str, above: float = 0.0, seconds: float = 0.5) -> Ramp:
    """Return what is heard of a brick on a ramp of 30 degrees, from a height above it (m)."""
    place = f"{-1 + (0.08 + above) / 2} 0 {3**-0.5 + 0.75**0.5 * (0.08 + above)}"
    text = f"""<mujoco><option timestep="{step}" cone="{cone}"/>
    <default><geom solref="{solref}" friction=".3"/></default>
    <custom><text name="carom" data="ramp wood brick ceramic"/></custom>
    <worldbody><body euler="0 30 0"><geom name="ramp" type="box" size="3 .3 .05"/></body>
    <body name="brick" pos="{place}" euler="0 30 0"><freejoint/>
    <geom type="box" size=".1 .05 .03" density="2000"/></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    bridge = Bridge(model, data, hearing=HEARING)
    hits, blocks, heard = [], [], []
    while data.time < seconds:
        blocks.append(bridge.step())
        hits += bridge.world.hits
        if np.linalg.norm(data.qvel[:3]) > 0.05 and data.time > 0.05:
            memory = bridge.world.memory
            heard.append(bool((memory["pairs"]["moves"][0, : memory["touching"][0]] == 2).any()))
    power = np.mean(np.concatenate(blocks).astype(np.float64) ** 2)
    return Ramp(hits, float(np.mean(heard)), float(10 * np.log10(power)))
