"""Ten small scenes of MuJoCo, as MJCF: bodies that fall, topple, roll, slide, rattle and meet.

Their materials stand in the custom text `carom`, which the bridge reads.
"""

import math
from typing import Any

FLOOR = '<geom name="floor" type="plane" size="3 3 .1"/>'


def ball(name: str, place: str, radius: float = 0.02, joint: str = "<freejoint/>", more: str = "") -> str:
    """Return a ball of glass."""
    return (
        f'<body name="{name}" pos="{place}">{joint}<geom type="sphere" size="{radius}" density="2500" {more}/></body>'
    )


def box(name: str, place: str, size: str, more: str = "") -> str:
    """Return a box of wood; size: half edges."""
    return f'<body name="{name}" pos="{place}" {more}><freejoint/><geom type="box" size="{size}" density="700"/></body>'


def model(bodies: str, materials: str, step: float, option: str = "", floor: str = FLOOR) -> str:
    """Return a whole model; step: s; materials: pairs of a name and a preset."""
    return f"""<mujoco>
      <option timestep="{step}" cone="elliptic" {option}/>
      <custom><text name="carom" data="{materials}"/></custom>
      <worldbody>{floor}{bodies}</worldbody>
    </mujoco>"""


def drop(step: float) -> str:
    """Drop a ball on a wooden floor."""
    return model(ball("ball", "0 0 .5"), "floor wood ball glass", step)


def stack(step: float) -> str:
    """Drop three blocks on each other, one after the other."""
    blocks = "".join(box(f"block{n}", f"0 0 {0.06 + 0.14 * n}", ".06 .04 .02") for n in range(3))
    return model(blocks, "floor wood", step)


def topple(step: float) -> str:
    """Stand a tall block on its edge, from which it falls over."""
    return model(box("block", "0 0 .105", ".02 .05 .1", 'euler="0 14 0"'), "floor wood", step)


def chain(step: float) -> str:
    """Run a ball into a row of others, on a rail."""
    rail = '<joint type="slide" axis="1 0 0"/>'
    balls = "".join(ball(f"ball{n}", f"{0.08 * n} 0 .5", joint=rail) for n in range(5))
    names = " ".join(f"ball{n} steel" for n in range(5))
    keys = '<keyframe><key name="start" qvel="1 0 0 0 0"/></keyframe>'
    return model(balls, names, step, 'gravity="0 0 0"', "").replace("</mujoco>", f"{keys}</mujoco>")


def ramp(step: float) -> str:
    """Roll a ball down a board."""
    board = '<geom name="board" type="box" size=".6 .15 .01" pos="0 0 .3" euler="0 12 0"/>'
    angle = math.radians(12)
    x, z = -0.5, 0.3 + 0.5 * math.sin(angle) + 0.03 / math.cos(angle) + 0.01 * (1 / math.cos(angle) - 1)
    return model(ball("ball", f"{x} 0 {z}"), "board wood ball glass", step, floor=board)


def slide(step: float) -> str:
    """Slide a box over the floor until it rests."""
    keys = '<keyframe><key name="start" qpos="0 0 .0199 1 0 0 0" qvel="2 0 0 0 0 0"/></keyframe>'
    text = model(box("box", "0 0 .02", ".06 .04 .02"), "floor wood", step)
    return text.replace('size="3 3 .1"', 'size="3 3 .1" friction=".3 .005 .0001"').replace(
        'density="700"', 'density="700" friction=".3 .005 .0001"'
    ).replace("</mujoco>", f"{keys}</mujoco>")  # fmt: skip


def rattle(step: float) -> str:
    """Shake three balls in a box."""
    walls = "".join(
        f'<geom type="box" size="{size}" pos="{place}" mass=".2"/>'
        for size, place in (
            (".1 .1 .005", "0 0 -.1"), (".1 .1 .005", "0 0 .1"), (".005 .1 .1", "-.1 0 0"),
            (".005 .1 .1", ".1 0 0"), (".1 .005 .1", "0 -.1 0"), (".1 .005 .1", "0 .1 0"),
        )
    )  # fmt: skip
    shaken = f"""<body name="crate" mocap="true" pos="0 0 .5">{walls}</body>"""
    balls = "".join(ball(f"ball{n}", f"{0.04 * n - 0.04} 0 .44") for n in range(3))
    return model(shaken + balls, " ".join(f"ball{n} glass" for n in range(3)), step, floor="")


def domino(step: float) -> str:
    """Topple eight dominoes, one against the next."""
    first = box("domino0", "0 0 .0405", ".005 .02 .04", 'euler="0 8 0"')
    row = "".join(box(f"domino{n}", f"{0.04 * n} 0 .04", ".005 .02 .04") for n in range(1, 8))
    return model(first + row, "floor wood", step)


def juggle(step: float) -> str:
    """Bounce three balls on a steel plate, from three heights.

    Their contacts are so soft that steps of 5 ms follow them, too.
    """
    more = 'solref=".06 .12"'
    balls = "".join(ball(f"ball{n}", f"{0.1 * n - 0.1} 0 {0.3 + 0.1 * n}", more=more) for n in range(3))
    plate = '<geom name="plate" type="box" size=".2 .15 .005" solref=".06 .12"/>'
    return model(balls, "plate steel ball0 glass ball1 steel ball2 wood", step, floor=plate)


def pile(step: float, count: int = 50) -> str:
    """Drop fifty bodies, or as many as are requested, on a heap."""
    bodies = []
    for n in range(count):
        x, y = 0.05 * math.cos(2.4 * n), 0.05 * math.sin(2.4 * n)
        place = f"{x} {y} {0.1 + 0.05 * n}"
        bodies.append(ball(f"body{n}", place) if n % 2 else box(f"body{n}", place, ".04 .02 .01"))
    glass = " ".join(f"body{n} glass" for n in range(1, count, 2))
    return model("".join(bodies), f"floor wood {glass}", step)


SCENES = {
    "drop": (drop, 1.5), "stack": (stack, 2.0), "topple": (topple, 2.0), "chain": (chain, 2.0), "ramp": (ramp, 1.2),
    "slide": (slide, 1.5), "rattle": (rattle, 2.0), "domino": (domino, 1.5), "juggle": (juggle, 2.0),
    "pile": (pile, 4.0),
}  # fmt: skip
"""The scenes by name: a function of the step (s), and how long there is something to hear (s)."""


def shake(name: str, data: Any) -> None:
    """Move what moves by itself in a scene, before a step: the crate of `rattle`, to and fro for 1.3 s."""
    if name == "rattle":
        swing, time = data.time < 1.3, data.time
        x, z = 0.03 * math.sin(6 * math.pi * time), 0.05 * math.sin(8 * math.pi * time)
        data.mocap_pos[0] = swing * x, 0.0, 0.5 + swing * z
