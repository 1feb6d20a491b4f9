"""The sounding parts of a MuJoCo model: its bodies, their names, shapes and materials."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from ....dsp.wording import expected
from ....presets import Presets
from ..checks import WorldError
from ..shapes import Vector

_SHAPES = {
    mujoco.mjtGeom.mjGEOM_SPHERE: "sphere",
    mujoco.mjtGeom.mjGEOM_CAPSULE: "capsule",
    mujoco.mjtGeom.mjGEOM_CYLINDER: "cylinder",
    mujoco.mjtGeom.mjGEOM_BOX: "box",
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: "box",
    mujoco.mjtGeom.mjGEOM_MESH: "box",
}
_ENDLESS = (mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_HFIELD)
_GROUND = (2.0, 2.0, 0.1)  # m: of a plane, a height field or the like, as far as it rings


class Part(NamedTuple):
    """A body of the World: its name, its largest geom, the model's body that moves it (0: none does), and all its
    geoms that collide."""

    name: str
    geom: int
    body: int
    geoms: tuple[int, ...]


def parts_of(model: mujoco.MjModel) -> list[Part]:
    """Return the bodies of the World, those that move first: all geoms that collide of a body that moves are one, with
    those of bodies that are fixed to it; so are those of each body that does not, and each geom of the world's own
    body."""
    paired, welded = {*model.pair_geom1.tolist(), *model.pair_geom2.tolist()}, welded_to(model)
    geoms: dict[tuple[int, int, int], list[int]] = {}
    for geom in range(model.ngeom):
        if model.geom_contype[geom] or model.geom_conaffinity[geom] or geom in paired:
            own = int(model.geom_bodyid[geom])
            moving = int(welded[own])
            alone = own == 0 or model.geom_type[geom] in _ENDLESS
            key = (moving, 0, 0) if moving else (0, own, 1 + geom if alone else 0)
            geoms.setdefault(key, []).append(geom)
    found = []
    for (moving, fixed, _), each in geoms.items():
        largest = max(each, key=lambda geom: _extent(model, geom))
        of_geom = name_of(model, mujoco.mjtObj.mjOBJ_GEOM, largest)
        of_body = name_of(model, mujoco.mjtObj.mjOBJ_BODY, moving or fixed) if moving or fixed else ""
        if moving or len(each) > 1:
            name = of_body or of_geom or f"body{moving or fixed}"
        else:
            name = of_geom or of_body or f"geom{largest}"
        found.append(Part(name, largest, moving, tuple(each)))
    return sorted(found, key=lambda part: (part.body == 0, part.geom if part.body == 0 else 0))


def is_whole(model: mujoco.MjModel, part: Part) -> bool:
    """True if a part is as its geoms are together: none of them has half of their volume, or it moves and its largest
    is a mesh."""
    if part.body and model.geom_type[part.geom] == mujoco.mjtGeom.mjGEOM_MESH:
        return True
    return 2.0 * _extent(model, part.geom) < sum(_extent(model, geom) for geom in part.geoms)


class Frame(NamedTuple):
    """Axes in which a part is a shape: the addresses of their origin (m) and their rotation matrix, where they are now,
    and the shape with its size."""

    place: int
    turned: int
    origin: NDArray[np.float64]
    axes: NDArray[np.float64]
    shape: str
    size: tuple[float, ...]


def frame_of(model: mujoco.MjModel, data: mujoco.MjData, part: Part) -> Frame:
    """Return the axes of a part: those of its largest geom, or of its body's inertia if it is as its geoms are
    together."""
    if is_whole(model, part):
        if part.body:
            origin, axes = data.xipos[part.body], data.ximat[part.body]
        else:
            origin, axes = _whole_axes(model, data, part)
        edges = np.sqrt(12.0 * np.diag(axes.reshape(3, 3).T @ _spread(model, data, part)[1] @ axes.reshape(3, 3)))
        shape, size = "box", tuple(map(float, np.maximum(edges, 1e-6)))
    else:
        origin, axes = data.geom_xpos[part.geom], data.geom_xmat[part.geom]
        shape, size = shape_of(model, part.geom)
    return Frame(origin.ctypes.data, axes.ctypes.data, origin, axes.reshape(3, 3), shape, size)


def welded_to(model: mujoco.MjModel) -> NDArray[np.int32]:
    """Return for each body that which it is fixed to, up to one that moves; one that `mocap_pos` moves, too, which
    MuJoCo itself counts so from 3.12 on."""
    found: NDArray[np.int32] = np.arange(model.nbody, dtype=np.int32)
    for body in range(1, model.nbody):  # after its parent
        if model.body_jntnum[body] == 0 and model.body_mocapid[body] < 0:
            found[body] = found[model.body_parentid[body]]
    return found


def inertia_of(model: mujoco.MjModel, data: mujoco.MjData, part: Part, frame: Frame) -> tuple[float, Vector]:
    """Return the mass (kg) of a part that moves, with all bodies that are fixed to its own, and its moments of inertia
    about the axes of its frame through its centre of mass (kg m^2)."""
    bodies = np.flatnonzero(welded_to(model) == part.body)
    masses = model.body_mass[bodies]
    mass = float(masses.sum())
    away = data.xipos[bodies] - masses @ data.xipos[bodies] / max(mass, 1e-300)
    turns = data.ximat[bodies].reshape(-1, 3, 3)
    whole = np.einsum("nij,nj,nkj->ik", turns, model.body_inertia[bodies], turns)
    whole += np.einsum("n,nj,nj->", masses, away, away) * np.eye(3) - np.einsum("n,ni,nk->ik", masses, away, away)
    x, y, z = map(float, np.maximum(np.diag(frame.axes.T @ whole @ frame.axes), 1e-12))
    return mass, (x, y, z)


def _whole_axes(model: mujoco.MjModel, data: mujoco.MjData, part: Part) -> tuple[NDArray[np.float64], ...]:
    """Return the centre and the principal axes of a part that does not move."""
    centre, second = _spread(model, data, part)
    axes = np.linalg.eigh(second)[1]
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    return centre, np.ascontiguousarray(axes)


def _spread(model: mujoco.MjModel, data: mujoco.MjData, part: Part) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the centre of a part's geoms (m), each taken as the box around it, and their mean square about it (m^2):
    of a solid box it has the edges' squares over 12."""
    numbers = list(part.geoms)
    halves = model.geom_aabb[numbers, 3:]
    turns = data.geom_xmat[numbers].reshape(-1, 3, 3)
    centres = data.geom_xpos[numbers] + np.einsum("nij,nj->ni", turns, model.geom_aabb[numbers, :3])
    share = halves.prod(axis=1) / halves.prod(axis=1).sum()
    centre = share @ centres
    away = centres - centre
    return centre, np.einsum("n,nij,nj,nkj->ik", share, turns, halves**2 / 3, turns) + (share * away.T) @ away


def names_of(model: mujoco.MjModel, part: Part) -> list[str]:
    """Return the names by which a part is requested: its own, those of its bodies and of its geoms."""
    geoms = [name_of(model, mujoco.mjtObj.mjOBJ_GEOM, geom) for geom in part.geoms]
    bodies = {int(model.geom_bodyid[geom]) for geom in part.geoms}
    own = [name_of(model, mujoco.mjtObj.mjOBJ_BODY, body) for body in sorted(bodies) if body]
    return [part.name, *filter(None, own + geoms)]


def named_apart(parts: list[Part]) -> list[Part]:
    """Return parts of which no two have one name."""
    seen: set[str] = set()
    apart = []
    for part in parts:
        apart.append(part._replace(name=f"{part.name}_geom{part.geom}") if part.name in seen else part)
        seen.add(apart[-1].name)
    return apart


def names_in(model: mujoco.MjModel) -> set[str]:
    """Return names of geoms, bodies and materials; those without one have their number."""
    found = {f"{kind}{n}" for kind, count in (("geom", model.ngeom), ("body", model.nbody)) for n in range(count)}
    for kind, count in (
        (mujoco.mjtObj.mjOBJ_GEOM, model.ngeom), (mujoco.mjtObj.mjOBJ_BODY, model.nbody),
        (mujoco.mjtObj.mjOBJ_MATERIAL, model.nmat),
    ):  # fmt: skip
        found |= {name_of(model, kind, n) for n in range(count)}
    return found


def check_names(what: str, given: Iterable[str], known: set[str]) -> None:
    """Raise WorldError for the first name that is not known."""
    for name in given:
        if name not in known:
            raise WorldError(f"{what}: {name}: {expected(name, sorted(known - {''}))}")


def _extent(model: mujoco.MjModel, geom: int) -> float:
    return float(np.prod(model.geom_aabb[geom, 3:]))


def name_of(model: mujoco.MjModel, kind: mujoco.mjtObj, number: int) -> str:
    """Return a name as an object's may be; empty if there is none."""
    name = mujoco.mj_id2name(model, kind, number) or ""
    return "".join("_" if sign in "# *,/?[]{}" else sign for sign in name)


def shape_of(model: mujoco.MjModel, geom: int) -> tuple[str, tuple[float, ...]]:
    """Return the shape of a geom, and its size as World.body takes it."""
    kind = model.geom_type[geom]
    x, y, z = map(float, model.geom_size[geom])
    shape = _SHAPES.get(mujoco.mjtGeom(kind))
    if shape is None:
        return "box", _GROUND
    if shape == "box":
        x, y, z = map(float, model.geom_aabb[geom, 3:])
        return shape, (2 * x, 2 * y, 2 * z)
    return shape, (x,) if shape == "sphere" else (x, 2 * y)


def written_in(model: mujoco.MjModel) -> dict[str, str]:
    """Return the materials that the model's custom text `carom` says."""
    for number in range(model.ntext):
        if mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_TEXT, number) == "carom":
            first = int(model.text_adr[number])
            text = bytes(model.text_data[first : first + int(model.text_size[number])]).rstrip(b"\0").decode()
            words = text.split()
            if len(words) % 2:
                raise WorldError(f"custom text carom: {text}: expected pairs of a name and a material")
            return dict(zip(words[::2], words[1::2], strict=True))
    return {}


def material_of(model: mujoco.MjModel, part: Part, chosen: Mapping[str, str]) -> str:
    """Return the preset of a part's material; empty if nothing says it."""
    names = names_of(model, part)
    material = int(model.geom_matid[part.geom])
    if material >= 0:
        names.append(name_of(model, mujoco.mjtObj.mjOBJ_MATERIAL, material))
    for name in names:
        if name in chosen:
            return chosen[name]
    return names[-1] if material >= 0 and names[-1] in Presets().names("materials") else ""


def numbers_of(model: mujoco.MjModel, parts: list[Part], first: int) -> NDArray[np.int32]:
    """Return the number of each geom's body in the World, -1: it has none."""
    numbers = np.full(max(model.ngeom, 1), -1, np.int32)
    for n, part in enumerate(parts):
        numbers[list(part.geoms)] = first + n
    return numbers
