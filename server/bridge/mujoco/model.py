"""The sounding parts of a MuJoCo model: its bodies, their names, shapes and materials."""

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from ....dsp.wording import expected
from ....presets import Presets
from ..bodies import WorldError

_SHAPES = {
    mujoco.mjtGeom.mjGEOM_SPHERE: "sphere",
    mujoco.mjtGeom.mjGEOM_CAPSULE: "capsule",
    mujoco.mjtGeom.mjGEOM_CYLINDER: "cylinder",
    mujoco.mjtGeom.mjGEOM_BOX: "box",
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: "box",
    mujoco.mjtGeom.mjGEOM_MESH: "box",
}
_GROUND = (2.0, 2.0, 0.1)  # m: of a plane, a height field or the like, as far as it rings


class Part(NamedTuple):
    """A body of the World: its name, its geom, and the model's body that moves it (0: none does)."""

    name: str
    geom: int
    body: int


def parts_of(model: mujoco.MjModel) -> Iterator[Part]:
    """Yield the bodies of the World. Of the geoms that collide: the largest of each body that moves, and all that do
    not."""
    largest: dict[int, int] = {}
    paired = {*model.pair_geom1.tolist(), *model.pair_geom2.tolist()}
    for geom in range(model.ngeom):
        if not (model.geom_contype[geom] or model.geom_conaffinity[geom] or geom in paired):
            continue
        body = int(model.body_weldid[model.geom_bodyid[geom]])
        if body == 0:
            yield Part(name_of(model, mujoco.mjtObj.mjOBJ_GEOM, geom) or f"geom{geom}", geom, 0)
        elif body not in largest or _extent(model, geom) > _extent(model, largest[body]):
            largest[body] = geom
    for body, geom in largest.items():
        name = name_of(model, mujoco.mjtObj.mjOBJ_BODY, body) or name_of(model, mujoco.mjtObj.mjOBJ_GEOM, geom)
        yield Part(name or f"body{body}", geom, body)


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
    names = [part.name, name_of(model, mujoco.mjtObj.mjOBJ_GEOM, part.geom)]
    names.append(name_of(model, mujoco.mjtObj.mjOBJ_BODY, int(model.geom_bodyid[part.geom])))
    material = int(model.geom_matid[part.geom])
    if material >= 0:
        names.append(name_of(model, mujoco.mjtObj.mjOBJ_MATERIAL, material))
    for name in names:
        if name in chosen:
            return chosen[name]
    return names[-1] if material >= 0 and names[-1] in Presets().names("materials") else ""


def numbers_of(model: mujoco.MjModel, parts: list[Part], first: int) -> NDArray[np.int32]:
    """Return the number of each geom's body in the World, -1: it has none."""
    of_body = {part.body: first + n for n, part in enumerate(parts) if part.body}
    of_geom = {part.geom: first + n for n, part in enumerate(parts)}
    numbers = np.zeros(max(model.ngeom, 1), np.int32)
    for geom in range(model.ngeom):
        body = int(model.body_weldid[model.geom_bodyid[geom]])
        numbers[geom] = of_body.get(body, of_geom.get(geom, -1))
    return numbers
