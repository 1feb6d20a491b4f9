"""A gripper closes on a mug, lifts it, and puts it down; a marble rolls past.

    python grasp.py grasp [OUT.wav [OUT.png]]
    python grasp.py passing [OUT.wav [OUT.png]]

A mallet strikes the mug as it stands, as it hangs in the fingers, and as it stands again; the left finger carries an
accelerometer. Sounds are in pascals at two ears; pictures need carom[plot].
"""

import sys
from collections.abc import Callable
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

import carom
from carom.mujoco import Bridge

STEP = 0.002  # s
GRIP, LOOSE, OPEN = 8.0, 1.2, -2.0  # N
CLOSES, LIFTS, LOWERS, SLIPS, OPENS, ENDS = 1.3, 1.7, 3.2, 4.1, 4.7, 6.2  # s
HIGH, ALONG, SLOWLY = 0.1, 0.02, 0.6  # m: of the lift, and of the fingers over the mug that stands; s
PASSED = 2.6  # s
_STAGES = "closes", "lifts", "lowers", "slips", "opens"
STRIKES = (0.3, 2.5, 5.2)  # s: when the mallet begins to swing
SWING = 1.2  # m/s

EARS = carom.Listener((0.0, -0.6, 0.3), yaw=90.0)
"""Ears in front of the table."""

GRASP = """<mujoco>
  <option timestep="0.002" cone="elliptic" impratio="10" integrator="implicitfast"/>
  <custom><text name="carom" data="table wood mug ceramic left aluminium right aluminium mallet plastic"/></custom>
  <default><geom solref="0.006 1"/></default>
  <worldbody>
    <geom name="table" type="box" size="0.4 0.3 0.0125" pos="0 0 -0.0125"/>
    <body name="mug" pos="0 0 0.0475">
      <freejoint/>
      <geom type="cylinder" size="0.041 0.0475" mass="0.327" conaffinity="3"/>
    </body>
    <body name="hand" pos="0 0 0.055" gravcomp="1">
      <joint name="lift" type="slide" axis="0 0 1" damping="60"/>
      <inertial pos="0 0 0" mass="0.5" diaginertia="0.001 0.001 0.001"/>
      <body name="left" pos="-0.075 0 0" gravcomp="1">
        <joint name="left" type="slide" axis="1 0 0" damping="80" range="0 0.04"/>
        <geom type="box" size="0.005 0.01 0.035" mass="0.038"/>
        <site name="fingertip" pos="-0.005 0 0.03"/>
      </body>
      <body name="right" pos="0.075 0 0" gravcomp="1">
        <joint name="right" type="slide" axis="-1 0 0" damping="80" range="0 0.04"/>
        <geom type="box" size="0.005 0.01 0.035" mass="0.038"/>
      </body>
    </body>
    <body name="arm" pos="0 -0.09 0.085" gravcomp="1">
      <joint name="arm" type="slide" axis="0 0 1" damping="60"/>
      <inertial pos="0 0 0" mass="0.5" diaginertia="0.001 0.001 0.001"/>
      <body name="mallet" gravcomp="1">
        <joint name="swing" type="slide" axis="0 1 0" damping="0.02" stiffness="3"/>
        <geom type="sphere" size="0.008" mass="0.006" contype="2" conaffinity="0"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="lift" joint="lift" kp="3000"/>
    <position name="arm" joint="arm" kp="3000"/>
    <motor name="left" joint="left"/>
    <motor name="right" joint="right"/>
  </actuator>
</mujoco>"""

PASSING = """<mujoco>
  <option timestep="0.002" cone="elliptic"/>
  <custom><text name="carom" data="floor wood marble glass"/></custom>
  <worldbody>
    <geom name="floor" type="box" size="6 0.3 0.02" pos="0 0 -0.02"/>
    <body name="marble" pos="-4 0 0.0125"><freejoint/><geom type="sphere" size="0.0125" density="2500"/></body>
  </worldbody>
  <keyframe><key name="start" qpos="-4 0 0.0125 1 0 0 0" qvel="3 0 0 0 240 0"/></keyframe>
</mujoco>"""


class Heard(NamedTuple):
    """A scene that was heard: its sound, its blows, and where what moves was in each step (m)."""

    sound: carom.Sound
    hits: list[carom.Hit]
    times: NDArray[np.float64]
    places: NDArray[np.float64]


def steer(data: mujoco.MjData) -> None:
    """Move hand, fingers and mallet as the time says, before a step."""
    up, down, along = (np.clip((data.time - begin) / SLOWLY, 0.0, 1.0) for begin in (LIFTS, LOWERS, SLIPS))
    height = HIGH * (np.sin(0.5 * np.pi * up) ** 2 - np.sin(0.5 * np.pi * down) ** 2)
    data.actuator("arm").ctrl = height
    data.actuator("lift").ctrl = height + ALONG * np.sin(0.5 * np.pi * along) ** 2
    grip = OPEN if data.time < CLOSES or data.time >= OPENS else GRIP if data.time < SLIPS else LOOSE
    data.actuator("left").ctrl = data.actuator("right").ctrl = grip
    if any(abs(data.time - strike) < 0.5 * STEP for strike in STRIKES):
        data.joint("swing").qvel[0] = SWING


def gripper(**options: Any) -> tuple[mujoco.MjData, Bridge]:
    """Return the data of the gripper, and the bridge that hears it; options: of the bridge."""
    model = mujoco.MjModel.from_xml_string(GRASP)
    data = mujoco.MjData(model)
    finger = {"site": "fingertip", "preset": "mems"}
    bridge = Bridge(model, data, bodies={"mug": {"object": "mug"}}, sensors={"finger": finger}, **options)
    for name in ("left", "right"):
        bridge.world.pair(name, "mug", support="finger")
    return data, bridge


def roller(**options: Any) -> tuple[mujoco.MjData, Bridge]:
    """Return the data of a marble that rolls from left to right, and the bridge that hears it alone; options: of the
    bridge."""
    model = mujoco.MjModel.from_xml_string(PASSING)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    return data, Bridge(model, data, bodies={"floor": {"rings": False}}, **options)


def hear(name: str, rate: int = 48_000) -> Heard:
    """Hear the gripper, or the marble."""
    options = {"rate": rate, "listener": EARS, "keep": True}
    if name == "grasp":
        return _heard(*gripper(**options), "mug", ENDS, steer)
    return _heard(*roller(**options), "marble", PASSED, lambda data: None)


def _heard(
    data: mujoco.MjData, bridge: Bridge, body: str, seconds: float, steer: Callable[[mujoco.MjData], None]
) -> Heard:
    hits, times, places = [], [], []
    for _ in range(round(seconds / STEP)):
        steer(data)
        bridge.step()
        hits += bridge.world.hits
        times.append(float(data.time))
        places.append(data.body(body).xpos.copy())
    return Heard(bridge.world.sound(), hits, np.array(times), np.array(places))


def draw(heard: Heard, path: str) -> None:
    """Draw the spectrograms of both ears, or of one and of the finger, over where the body is."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    sound, sensors = heard.sound, list(heard.sound.sensors.values())
    shown = [("left ear", sound.samples[:, 0], -160, -60)]
    if sensors:
        shown.append(("finger's accelerometer", sensors[0].samples.ravel(), -110, -20))
    else:
        shown.append(("right ear", sound.samples[:, 1], -160, -60))
    figure, axes = plt.subplots(3, 1, figsize=(9, 7), sharex=True, layout="constrained", height_ratios=(2, 2, 1))
    for each, (name, samples, low, high) in zip(axes, shown, strict=False):
        with np.errstate(divide="ignore"):  # silence has no level
            each.specgram(samples, NFFT=1024, Fs=sound.rate, noverlap=768, vmin=low, vmax=high)
        each.vlines([hit.time for hit in heard.hits], 18_000, 20_000, color="r")
        each.set(title=f"{name} (red: blows)", ylabel="Hz", ylim=(0, 20_000))
    axes[2].plot(heard.times, heard.places[:, 2] if sensors else heard.places[:, 0])
    axes[2].set(xlabel="s", ylabel="height of the mug (m)" if sensors else "x of the marble (m)")
    if sensors:
        for time, what in zip((CLOSES, LIFTS, LOWERS, SLIPS, OPENS), _STAGES, strict=True):
            axes[2].axvline(time, color="0.7")
            axes[2].text(time, 0.09, what)
    figure.savefig(path, dpi=75)


def main(name: str = "grasp", wave: str = "", picture: str = "") -> None:
    if name not in ("grasp", "passing"):
        sys.exit(f"{name}: expected grasp or passing")
    heard = hear(name)
    heard.sound.save(wave or f"{name}.wav")
    if picture:
        draw(heard, picture)
    peak = abs(heard.sound.samples).max()
    print(f"{name}: {len(heard.hits)} blows, {peak:.3g} Pa at most, carom {carom.__version__}")


if __name__ == "__main__":
    main(*sys.argv[1:])
