"""Hear two hundred marbles that fall into a bowl, as grains: python grains.py [OUT.wav]."""

import math
import sys
from typing import Any

import mujoco

import carom
from carom.mujoco import Bridge

STEP = 0.002  # s
MARBLES, RADIUS = 200, 0.005  # m
_STAVES, _FLAT = 16, 0.045  # how many a bowl has; m: its bottom


def model(marbles: int = MARBLES) -> mujoco.MjModel:
    """Return a bowl of staves, and marbles in a column above it."""
    wall = "".join(
        f'<geom type="box" size=".045 .018 .003" pos="{_x(n, 0.062):.4f} {_y(n, 0.062):.4f} .035" '
        f'zaxis="{-_x(n, 1.0):.4f} {-_y(n, 1.0):.4f} .7"/>'
        for n in range(_STAVES)
    )
    bowl = f'<geom type="cylinder" size="{_FLAT} .003"/>{wall}'
    column = "".join(
        f'<body name="marble{n}" pos="{_x(5 * n, 0.012 * (n % 3)):.4f} {_y(5 * n, 0.012 * (n % 3)):.4f} '
        f'{0.1 + 0.004 * n:.4f}"><freejoint/><geom type="sphere" size="{RADIUS}" density="2500"/></body>'
        for n in range(marbles)
    )
    return mujoco.MjModel.from_xml_string(f"""<mujoco>
      <option timestep="{STEP}" cone="elliptic"/>
      <default><geom solref="-40000 -60" friction=".3"/></default>
      <worldbody><body name="bowl">{bowl}</body>{column}</worldbody>
    </mujoco>""")


def _x(n: int, far: float) -> float:
    return far * math.cos(2.0 * math.pi * n / _STAVES)


def _y(n: int, far: float) -> float:
    return far * math.sin(2.0 * math.pi * n / _STAVES)


def bridge_of(model: mujoco.MjModel, data: mujoco.MjData, together: bool = True, **options: Any) -> Bridge:
    """Return a bridge in which the marbles are grains, or bodies each by itself."""
    names = [f"marble{n}" for n in range(model.nbody - 2)]
    return Bridge(
        model, data, microphones=[(0, -0.5, 0.3)], materials=dict.fromkeys(names, "glass"),
        bodies={"bowl": {"object": "ceramic-bowl", "material": "ceramic"}},
        grains={"marbles": "marble*"} if together else None, **options,
    )  # fmt: skip


if __name__ == "__main__":
    scene = model()
    data = mujoco.MjData(scene)
    bridge = bridge_of(scene, data, keep=True)
    for _ in range(round(1.5 / STEP)):
        bridge.step()
    bridge.world.sound().save(sys.argv[1] if len(sys.argv) > 1 else "grains.wav")
    print(carom.__version__, bridge.world.counts)
