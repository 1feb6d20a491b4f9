"""Meshes of things about the house, and the presets that Carom makes of them.

    python household.py FOLDER [NAME...]

Each function returns a surface in m and says where its sizes are from. Parts overlap where they are joined.
"""

import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from carom.dsp.mesh.forms import box, circle, lathe, moved, pulled, together, tube
from carom.dsp.mesh.surface import Surface

MM = 1e-3


def mug() -> Surface:
    """Return a mug of 0.33 l: 82 mm wide, 95 mm high, walls of 4 mm, a base of 5 mm and a round handle of 10 mm.

    Source: usual stoneware mugs are 80 to 85 mm by 90 to 100 mm at 0.3 to 0.35 kg; the walls are estimated from that.
    """
    cup = lathe(MM * np.array([[0, 0], [38, 0], [41, 3], [41, 95], [37, 95], [37, 7], [35, 5], [0, 5]]), 96)
    angle = np.linspace(-np.pi / 2, np.pi / 2, 33)
    path = MM * np.stack([39 + 31 * np.cos(angle), 0 * angle, 48 + 27 * np.sin(angle)], axis=1)
    return together(cup, tube(path, circle(5 * MM)))


def bottle() -> Surface:
    """Return a wine bottle of 0.75 l: 74 mm wide, 300 mm high, walls of 3.2 mm.

    Source: usual Bordeaux bottles are 74 to 76 mm by 300 mm and weigh 0.4 to 0.55 kg.
    """
    outer = [[0, 0], [33, 0], [37, 5], [37, 190], [36, 205], [30, 218], [20, 228], [15, 236], [14.5, 245], [14.3, 296],
             [14.3, 300]]  # fmt: skip
    inner = [[9.6, 300], [9.6, 250], [11, 239], [17, 230.5], [27.5, 220], [32.7, 204], [33.8, 190], [33.8, 9],
             [31, 5.5], [0, 5.5]]  # fmt: skip
    return lathe(MM * np.array(outer + inner), 96)


def tumbler() -> Surface:
    """Return a tumbler of 0.35 l: 80 mm wide, 100 mm high, walls of 2 mm, a base of 4.5 mm on a ring of 64 mm.

    Source: usual ones are 75 to 85 mm by 95 to 110 mm and weigh 0.15 to 0.25 kg; the walls are estimated from that.
    """
    profile = [[0, 1.5], [26, 1.5], [29, 0], [32, 0], [34, 2], [40, 100], [38, 100], [32.4, 10], [29, 6], [0, 6]]
    return lathe(MM * np.array(profile), 96)


def goblet() -> Surface:
    """Return a wine glass of 0.35 l with stem and foot: 80 mm wide, 200 mm high, walls of 1.5 mm, a foot of 72 mm.

    Source: usual red wine glasses are 75 to 85 mm by 190 to 220 mm, hold 0.3 to 0.4 l and weigh 0.13 to 0.18 kg.
    """
    outer = [[0, 0], [36, 0], [36, 1.6], [12, 4], [5, 8], [4, 20], [4, 82], [7, 90], [22, 98], [34, 112], [39.5, 130],
             [40, 145], [37, 175], [33, 200]]  # fmt: skip
    inner = [[31.5, 200], [35.5, 175], [38.5, 145], [38, 130.5], [32.7, 113], [21, 99.6], [10, 95], [0, 94]]
    return lathe(MM * np.array(outer + inner), 96)


def wrench() -> Surface:
    """Return a combination wrench for 13 mm nuts: 172 mm long, a shank of 11 x 5.5 mm, heads of 28 and 20 mm.

    Source: usual forged ones of size 13 are 165 to 180 mm long.
    """
    shank = moved(box(135 * MM, 11 * MM, 5.5 * MM), (0, 0, 0))
    around = np.linspace(0, 2 * np.pi, 49)[:-1]
    turned = np.stack([np.cos(around), np.sin(around)], axis=1)
    ring = lathe(MM * np.array([[6.6, -4.5], [10, -4.5], [10, 4.5], [6.6, 4.5]]), 48)
    jaw = np.concatenate([
        14 * turned[5:44],
        np.array([[12.5, -6.6], [-3, -6.6], [-5.5, -3.5], [-5.5, 3.5], [-3, 6.6], [12.5, 6.6]]),
    ])  # fmt: skip
    left = _plate(MM * jaw, 6 * MM)
    return together(
        shank, moved(ring, (MM * 74, 0, 0)), moved(left, (-MM * 76, 0, -3 * MM), np.diag([-1.0, -1.0, 1.0]))
    )


def pan() -> dict[str, Surface]:
    """Return a frying pan of 2.5 mm steel, 240 mm wide, 45 mm high, on a tang of 18 x 3 mm that is sunk into a handle
    of wood, 150 x 26 x 20 mm.

    Source: usual carbon steel pans of 24 cm have 2.5 to 3 mm walls and weigh 1.1 to 1.5 kg with their handle; handles
    of beech are 140 to 180 mm long, of 25 to 30 x 18 to 22 mm.
    """
    outer = [[0, 0], [86, 0], [92, 2], [120, 45]]
    inner = [[117.3, 45], [90, 4.4], [85, 2.5], [0, 2.5]]
    body = lathe(MM * np.array(outer + inner), 96)
    along = np.linspace(0, 1, 21)
    path = MM * np.stack([111 + 119 * along, 0 * along, 33 + 26 * np.sin(along * np.pi / 2.4)], axis=1)
    tang = tube(path, MM * np.array([[-9, -1.5], [9, -1.5], [9, 1.5], [-9, 1.5]]))
    way = path[-1] - path[-5]
    end = path[-1] + 0.092 * way / np.linalg.norm(way)
    start = end - 0.15 * way / np.linalg.norm(way)
    around = np.linspace(0, 2 * np.pi, 33)[:-1]
    oval = np.stack([13 * np.cos(around), 10 * np.sin(around)], axis=1)
    grip = tube(np.linspace(start, end, 9), MM * oval)
    return {"pan": together(body, tang), "handle": grip}


def spoon() -> Surface:
    """Return a table spoon of stainless steel: 200 mm long, a bowl of 68 x 43 mm, 2.2 mm thick.

    Source: usual table spoons are 195 to 205 mm long and 2 to 2.5 mm thick (18/10 steel), at 55 to 70 g.
    """
    along = np.r_[np.linspace(0, 68, 28), np.linspace(72, 200, 34)]
    bowl = np.sqrt(np.maximum(1 - ((along - 34) / 34.5) ** 2, 0.0))
    width = np.where(along < 66, np.maximum(21.5 * bowl, 2.5), 4.2 + 5.3 * np.clip((along - 110) / 90, 0, 1) ** 1.5)
    depth = np.where(along < 68, -9 * bowl**2, 9 * np.sin(np.clip((along - 68) / 132, 0, 1) * np.pi * 0.8))
    across = np.linspace(-1, 1, 13)
    x = np.repeat(along, 13)
    y = (width[:, None] * across).ravel()
    z = (np.where(along < 68, depth, 0)[:, None] * (1 - across**2) + np.where(along >= 68, depth, 0)[:, None]).ravel()
    top = np.stack([x, y, z + 1.1], axis=1)
    low = np.stack([x, y, z - 1.1], axis=1)
    return _skins(MM * top, MM * low, len(along), 13)


def door_panel() -> Surface:
    """Return a door leaf of 860 x 1985 mm: stiles and rails of 40 mm, with tenons and grooves, and two panels of 14 mm.

    Source: leaves of doors for dwellings by DIN 18101 are 860 x 1985 mm, and about 40 mm thick; usual frames are of
    stiles of 100 to 120 mm, with a lower rail of about 200 mm, and panels of 12 to 16 mm.
    """
    stile = box(115 * MM, 1985 * MM, 40 * MM)
    parts = [moved(stile, (side * 372.5 * MM, 0, 0)) for side in (-1, 1)]
    for middle, height in ((-892.5, 200), (57.5, 150), (935, 115)):
        parts.append(moved(box(670 * MM, height * MM, 39 * MM), (0, middle * MM, 0)))
    for low, high in ((-792.5, -17.5), (132.5, 877.5)):
        parts.append(moved(box(650 * MM, (high - low + 20) * MM, 14 * MM), (0, (low + high) / 2 * MM, 0)))
    return together(*parts)


def _plate(outline: np.ndarray, height: float) -> Surface:
    """Return a plate of any outline: the prism's ends are triangles that share its corners."""
    from scipy.spatial import Delaunay

    count = len(outline)
    made = pulled(outline, height)
    sides = made.faces[: 2 * count]
    triangles = Delaunay(outline).simplices
    middle = outline[triangles].mean(axis=1)
    inside = np.array([_inside(each, outline) for each in middle])
    a, b, c = outline[triangles].transpose(1, 0, 2)
    turned = np.cross(np.c_[b - a, 0 * a[:, 0]], np.c_[c - a, 0 * a[:, 0]])[:, 2] < 0
    triangles[turned] = triangles[turned][:, ::-1]
    ends = triangles[inside]
    return Surface(made.points[: 2 * count], np.concatenate([sides, ends[:, ::-1], ends + count]).astype(np.int64))


def _inside(place: np.ndarray, outline: np.ndarray) -> bool:
    """True if a place lies inside of an outline: a ray from it crosses the line an odd number of times."""
    (x, y), after = place, np.roll(outline, -1, axis=0)
    crosses = (outline[:, 1] > y) != (after[:, 1] > y)
    share = (y - outline[:, 1]) / np.where(crosses, after[:, 1] - outline[:, 1], 1.0)
    return bool(np.sum(crosses & (outline[:, 0] + share * (after[:, 0] - outline[:, 0]) > x)) % 2)


def _skins(top: np.ndarray, low: np.ndarray, rows: int, columns: int) -> Surface:
    """Return the body between two skins of points on a grid."""
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = (each.ravel() for each in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    skin = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    rim = np.concatenate([number[:-1, 0], number[-1, :-1], number[:0:-1, -1], number[0, :0:-1]])
    after, count = np.roll(rim, -1), rows * columns
    sides = np.concatenate([
        np.stack([rim + count, after + count, after], axis=1), np.stack([rim + count, after, rim], axis=1)
    ])  # fmt: skip
    return Surface(np.vstack([top, low]), np.concatenate([skin, skin[:, ::-1] + count, sides]).astype(np.int64))


OBJECTS: dict[str, tuple[Callable[[], Surface | dict[str, Surface]], str | dict[str, str], float | None, int]] = {
    "mug": (mug, "ceramic", None, 48),
    "bottle": (bottle, "glass", None, 64),
    "tumbler": (tumbler, "glass", None, 48),
    "goblet": (goblet, "glass", None, 48),
    "wrench": (wrench, "steel", None, 40),
    "steel-pan": (pan, {"*": "steel", "handle": "wood"}, None, 96),
    "spoon": (spoon, "steel", None, 40),
    "door-panel": (door_panel, "wood", None, 80),
}
"""Functions that make the surfaces, or parts by name, materials, walls (m) where they are sheets, how many modes."""


def main(folder: Path, names: Sequence[str]) -> None:
    """Write meshes into a folder, as .ply files or as .obj files where they have parts, and the presets that Carom
    makes of them: of all objects, or of those named."""
    import carom

    folder.mkdir(parents=True, exist_ok=True)
    for name in names or OBJECTS:
        make, material, wall, modes = OBJECTS[name]
        made = make()
        file = folder / f"{name}{'.obj' if isinstance(made, dict) else '.ply'}"
        file.write_text(_obj(made) if isinstance(made, dict) else _ply(made), encoding="ascii")
        told = carom.mesh(file, folder, name, material, wall=wall, modes=modes, points=250, fine=True)
        print(*told.files)


def _ply(surface: Surface) -> str:
    """Return a surface as a .ply file in plain text."""
    head = ["ply", "format ascii 1.0", f"element vertex {len(surface.points)}"]
    head += [f"property float {axis}" for axis in "xyz"]
    head += [f"element face {len(surface.faces)}", "property list uchar int vertex_indices", "end_header"]
    points = [" ".join(f"{x:.7g}" for x in point) for point in surface.points]
    faces = [" ".join(map(str, (3, *face))) for face in surface.faces]
    return "\n".join([*head, *points, *faces]) + "\n"


def _obj(parts: Mapping[str, Surface]) -> str:
    """Return parts as an .obj file."""
    lines, first = [], 1
    for name, surface in parts.items():
        lines.append(f"o {name}")
        lines += ["v " + " ".join(f"{x:.7g}" for x in point) for point in surface.points]
        lines += ["f " + " ".join(map(str, face + first)) for face in surface.faces]
        first += len(surface.points)
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
