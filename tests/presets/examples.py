"""Presets to be written into files, whole or with something wrong in them."""

from carom.presets import Presets

BAR = """
description = "a bar"
source = "none"
shape = "bar"
material = "steel"
level = -3
[geometry]
length = 0.3
width = 0.03
thickness = 0.01
[strike]
striker = "wood"
velocity = 1
position = 0.5
"""

GROUND = """
description = "d"
source = "s"
roughness = 1e-5
correlation = 0.01
slope = 2
dissipation = 0.5
"""

WALL = """description = "A body that yields to nothing"
source = "these tests"
shape = "listed"
level = 0.0  # dB

[geometry]
frequency = [440.0]  # Hz
t60 = 0.01  # s
modal_mass = 1e5  # kg
mass = 1e5  # kg

[strike]
striker = "steel"
velocity = 1.0  # m/s
position = 0.5  # 0..1 along the path
"""

LISTED = """
description = "two partials"
source = "none"
shape = "listed"
level = 0
[geometry]
frequency = [440, 881]
t60 = 2
modal_mass = [0.5, 0.7]
mass = 1
[strike]
striker = "wood"
velocity = 1
position = 0
"""


def with_object(folder, text, name="mine"):
    (folder / "objects" / f"{name}.toml").write_text(text, encoding="utf-8")
    return Presets([folder])
