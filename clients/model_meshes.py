"""Objects of the meshes of a MuJoCo model, made ahead of the simulation that hears them."""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from ..dsp.errors import CaromError
from ..dsp.mesh.model import Wanted
from ..dsp.mesh.surface import MeshError
from ..presets import Presets
from ..presets.made import copy_object, known_object, made_object
from ..server.bridge.bodies import Progress

SUFFIXES = (".xml", ".mjb")


class NoMujoco(CaromError, RuntimeError):
    """Error of a model where MuJoCo is missing."""


class MadeBody(NamedTuple):
    """A body of a model whose largest geom is a mesh: its name, its material, whether nobody named it, and its
    object's name, or why it has none."""

    name: str
    material: str
    unsaid: bool
    object: str
    reason: str


def make_all(path: Path, out: Path | None, default: str, presets: Presets, progress: Progress) -> Iterator[MadeBody]:
    """Make the objects of all bodies of a model that a Bridge hears as meshes; put them into a folder of presets, too,
    if one is given.

    default: the material where none is named. NoMujoco or MeshError say why a file is no model.
    """
    try:
        import mujoco
    except ImportError as error:
        raise NoMujoco(f"{path}: models need MuJoCo ({error}): pip install 'carom[mujoco]'") from error
    from ..server.bridge.mujoco.meshes import surface_of
    from ..server.bridge.mujoco.model import frame_of, material_of, named_apart, parts_of, written_in

    path.stat()
    try:
        load = mujoco.MjModel.from_binary_path if path.suffix == ".mjb" else mujoco.MjModel.from_xml_path
        model = load(str(path))
    except ValueError as error:
        raise MeshError(f"{path}: not a model of MuJoCo ({' '.join(str(error).split())})") from None
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    chosen = written_in(model)
    for part in named_apart(parts_of(model)):
        surface = surface_of(model, data, part, frame_of(model, data, part))
        if surface is None:
            continue
        said = material_of(model, part, chosen)
        name, reason = "", ""
        try:
            material = presets.material(said or default)
            name = known_object(presets.folders, surface, material, Wanted())
            if not name:
                with progress(part.name) as say:
                    name = made_object(surface, material, Wanted(), say)
            if out:
                copy_object(presets.path("objects", name), out)
        except MeshError as error:
            reason = str(error)
        yield MadeBody(part.name, said or default, not said, name, reason)
