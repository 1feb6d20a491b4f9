"""A gripper closes on a mug, lifts it, and puts it down: python grasp.py [OUT.wav [OUT.png]].

A mallet strikes the mug as it stands, as it hangs in the fingers, and as it stands again. The left finger carries an
accelerometer. A marble rolls past in `marble`. Sounds are in pascals at two ears; pictures need carom[plot].
"""

import sys
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

import carom
from carom.mujoco import Bridge

STEP = 0.002  # s
GRIP = 8.0  # N
STRUCK = (0.3, 2.6, 4.6)  # s: when the mallet begins to swing
CLOSES, LIFTS, LOWERS, OPENS, ENDS = 1.3, 1.8, 3.3, 4.1, 5.4  # s

MODEL = """<mujoco>
  <option timestep="0.002" cone="elliptic" impratio="10" integrator="implicitfast"/>
  <custom><text name="carom" data="table wood mug ceramic left aluminium right aluminium mallet plastic"/></custom>
  <default><geom solref="0.006 1" friction="1 0.005 0.0001"/></default>
  <worldbody>
    <geom name="table" type="box" size="0.4 0.3 0.0125" pos="0 0 -0.0125"/>
    <body name="mug" pos="0 0 0.0475"><freejoint/><geom type="cylinder" size="0.041 0.0475" mass="0.327"/></body>
    <body name="hand" pos="0 0 0.055">
      <joint name="lift" type="slide" axis="0 0 1" damping="40"/>
      <inertial pos="0 0 0" mass="0.5" diaginertia="0.001 0.001 0.001"/>
      <body name="left" pos="-0.07 0 0">
        <joint name="left" type="slide" axis="1 0 0" damping="8"/>
        <geom type="box" size="0.005 0.01 0.035" mass="0.038"/>
        <site name="fingertip" pos="-0.005 0 0.03"/>
      </body>
      <body name="right" pos="0.07 0 0">
        <joint name="right" type="slide" axis="-1 0 0" damping="8"/>
        <geom type="box" size="0.005 0.01 0.035" mass="0.038"/>
      </body>
    </body>
    <body name="mallet" pos="0 -0.09 0.085">
      <joint name="swing" type="slide" axis="0 1 0" damping="0.02" stiffness="4"/>
      <geom type="sphere" size="0.008" mass="0.006" contype="2" conaffinity="0"/>
    </body>
  </worldbody>
  <actuator>
    <position name="lift" joint="lift" kp="3000"/>
    <motor name="left" joint="left"/>
    <motor name="right" joint="right"/>
  </actuator>
</mujoco>"""
