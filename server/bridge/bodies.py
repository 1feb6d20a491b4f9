"""Bodies of a simulation: what each is, how loud a blow on it is, and the law of a contact of two of them."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...dsp.bodies.material import Material
from ...dsp.bodies.modes import Modes, Silent
from ...dsp.mesh.blocks import Block
from ...dsp.mesh.surface import MeshError, Surface, volume_of
from ...dsp.numerics.quantities import Range
from ...dsp.schema import SETTINGS
from ...dsp.wording import expected
from ...presets import Presets
from ..new_object import NEW, NewObject
from ..osc.arguments import require_name, shown
from ..osc.wire import Argument, Message
from ..osc.world_verbs import SIZES
from .checks import WorldError, array_of
from .shapes import SHAPES, Ringing, Shape, Vector, shape_of, surface_shape
from .tracking.state import OCTAVES

_CALIBRATED = {"level": 0.0, "stereo_width": 0.0}
_RANGES = {
    "density": Range(1e-6, 1e9, "kg/m3"), "mass": Range(1e-15, 1e9, "kg"), "inertia": Range(1e-30, 1e15, "kg m2"),
    "wall": Range(1e-9, 1e3, "m"),
}  # fmt: skip
"""The ranges of a body's keys; a size follows in `shapes.py`."""
_OCTAVES = np.exp2(np.arange(1.0 - OCTAVES, 1.0))  # s


@dataclass(frozen=True)
class Body:
    """A body of a simulation. mass: kg; inertia: moments about its axes, kg m^2; keys: of its object, beside those of
    its shape and material."""

    name: str
    shape: Shape
    material: Material
    mass: float
    inertia: Vector
    held: bool
    keys: Mapping[str, Argument] = field(default_factory=dict)
    sound: NewObject | None = None
    """Object that sounds; None: the body is silent."""
    silence: str = ""
    """Reason why it is silent."""
    surfaced: bool = False
    """True if its object has a surface, in the axes of the body, so that it is touched at points."""

    @property
    def rings(self) -> bool:
        return self.sound is not None

    @property
    def modes(self) -> Modes | None:
        return self.sound.modes if self.sound else None

    def message(self) -> Message:
        """Return the message that makes its object."""
        assert self.sound
        pairs = [part for pair in self.keys.items() for part in pair]
        return Message(NEW, (self.name, self.sound.preset.name, *pairs))

    @cached_property
    def ringing(self) -> float:
        """s after a blow until all of it has fallen by 90 dB."""
        return math.log(10.0 ** (90.0 / 20.0)) / float(self.modes.decay.min(initial=math.inf)) if self.modes else 0.0

    def point(self, point: Sequence[float]) -> tuple[float, ...]:
        """Return a point (m) in its axes as that of its surface; empty where it has none."""
        return tuple(point) if self.surfaced else ()

    def position(self, point: Vector) -> float:
        """Return the position 0 to 1 on its object's strike path that is nearest to a point (m) in its axes."""
        if not self.surfaced or self.modes is None or self.modes.faces is None:
            return self.shape.place(point)
        away = np.linalg.norm(self.modes.faces.line - np.array(point), axis=1)
        return float(np.argmin(away)) / (len(away) - 1)

    def loudness(self) -> NDArray[np.float64]:
        """Return the pressure (Pa rms at 1 m, just after) of a blow of 1 N s, as an estimate, for contact times of
        octaves up to 1 s."""
        if self.modes is None:
            return np.zeros(OCTAVES)
        heard = 0.25 * (self.modes.pressure**2).sum(axis=0) * (self.modes.strike**2).max(axis=0)
        slow = 1 + (2 * self.modes.frequency * _OCTAVES[:, None]) ** 4
        power = (heard / slow).sum(axis=1)
        for click in self.modes.clicks:
            power += 0.5 * click.strength**2 / (1 + (2 * click.frequency * _OCTAVES) ** 4)
        return np.asarray(np.sqrt(power))


class NoModel(WorldError):
    """Error of a mesh of which no object can be made; the text says why."""


Progress = Callable[[str], AbstractContextManager[Callable[[str, float], object]]]
"""Shows how an object of a name is made: called with what is done, and with how much of the whole."""


ABOUT = ("density", "mass", "inertia", "held", "rings", "object", "surface")
"""Keys of a body that are no object's."""


class BodyMaker:
    """Makes bodies with modes up to `top` (Hz), from presets. progress: shows how objects of meshes are made."""

    def __init__(self, presets: Presets, top: float, progress: Progress | None = None) -> None:
        self._presets, self._top, self._progress = presets, top, progress or _unseen

    def make(self, name: str, shape: str, size: ArrayLike, material: str, **about: Argument) -> Body:
        """Make a body. about: density (kg/m^3), mass (kg), inertia (three, kg m^2), held, rings, object (a preset), and
        keys of `/object/new`. WorldError names the body and what is wrong."""
        try:
            require_name("name", name)
            return self._made(name, shape, size, material, about)
        except NoModel as error:
            raise NoModel(f"body {shown(name)}: {error}") from None
        except (ValueError, TypeError) as error:
            raise WorldError(f"body {shown(name)}: {error}") from None

    def _made(self, name: str, kind: str, size: ArrayLike, material: str, about: dict[str, Argument]) -> Body:
        if kind not in SHAPES:
            raise ValueError(f"shape = {shown(kind)}: {expected(kind, SHAPES)}")
        held, rings, preset = (about.pop(key, default) for key, default in (("held", 0), ("rings", 1), ("object", "")))
        own = about.pop("surface", 0)
        for key, value in (("held", held), ("rings", rings), ("surface", own)):
            if value not in (0, 1):
                raise ValueError(f"{key} = {shown(value)}: expected True or False")
        density, mass, inertia, wall = (about.pop(key, None) for key in ("density", "mass", "inertia", "wall"))
        made_of = self._presets.material(str(material))
        wall = None if wall is None else _positive("wall", wall)
        alone = bool(rings) and not preset
        if own and (kind not in _SOLID or held or wall is not None or not alone):
            raise ValueError(f"surface = 1: expected a solid {' or '.join(_SOLID)} that is free, and rings by itself")
        surfaced = bool(own) or (kind == "mesh" and _has_faces(size) and alone)
        if kind == "mesh" and _has_faces(size):
            shape = self._surface(name, size, made_of if alone else None, wall)
        else:
            shape = shape_of(kind, size, bool(held), wall)
        if own:
            numbers = tuple(float(each) for each in np.ravel(np.asarray(size, np.float64)))
            shape = replace(shape, ringing=Ringing(self._object(name, Block(kind, numbers), made_of, None), {}))
        weight, moments = _weighed(shape, made_of, density, mass, inertia)
        rest = *self._sounding(shape, str(material), bool(rings), str(preset), about), surfaced
        return Body(name, shape, made_of, weight, moments, bool(held), *rest)

    def _sounding(
        self, shape: Shape, material: str, rings: bool, preset: str, about: dict[str, Argument]
    ) -> tuple[dict[str, Argument], NewObject | None, str]:
        """Return the keys of the object that rings as a body does, how it sounds, and why it does not."""
        keys: dict[str, Argument] = {**_CALIBRATED, **about}
        if preset:
            return keys, self._sound(preset, keys), ""
        if not rings:
            return keys, None, "rings = 0"
        if shape.ringing is None:
            return keys, None, "no object can be so large, or so small"
        keys = {**_CALIBRATED, **shape.ringing.keys, "material": material, **about}
        try:
            return keys, self._sound(shape.ringing.preset, keys), ""
        except ValueError as error:
            silent = error.__context__
            if not isinstance(silent, Silent):
                raise
            return keys, None, f"it is held, and {silent}"  # what moves clicks all the same

    def _surface(self, name: str, size: Any, material: Material | None, wall: float | None) -> Shape:
        """Return the shape of a mesh, its vertices and faces in the axes of the body; with the object that rings as it
        does, if its material is given. It is made if it is not there yet. NoModel says why it can't be."""
        points, faces = array_of("size", size[0], SIZES["mesh"]), np.asarray(size[1])
        if not points.shape[1:] == faces.shape[1:] == (3,) or faces.dtype.kind not in "iu":
            given = f"{points.shape} and {faces.shape}, of {faces.dtype}"
            raise ValueError(f"size, of shapes {given}: expected {SIZES['mesh']}")
        mesh = Surface(points, faces.astype(np.int64))
        if material is None:
            return surface_shape(mesh.points, mesh.faces, abs(volume_of(mesh)))
        made = self._object(name, mesh, material, wall)
        table = self._presets.object(made).geometry["table"]
        shape = surface_shape(mesh.points, mesh.faces, table.mass / table.density)
        return replace(shape, ringing=Ringing(made, {}))

    def _object(self, name: str, mesh: Surface | Block, material: Material, wall: float | None) -> str:
        """Return the object that rings as a mesh, or a solid box or cylinder; it is made if it is not there yet.
        NoModel says why it can't be."""
        from ...dsp.mesh.model import Wanted
        from ...presets.made import known_object, made_object

        wanted = Wanted(wall)
        try:
            made = known_object(self._presets.folders, mesh, material, wanted)
            if not made:
                with self._progress(name) as say:
                    made = made_object(mesh, material, wanted, say)
        except MeshError as error:
            raise NoModel(str(error)) from None
        except OSError as error:
            raise NoModel(f"its table cannot be kept: {error}") from None
        return made

    def _sound(self, name: str, keys: dict[str, Argument]) -> NewObject:
        """Make its object. PresetError or ValueError say why there is none."""
        changes = {key: value for key, value in keys.items() if key not in SETTINGS}
        preset = self._presets.object(name).replace(**changes)
        return NewObject(preset, preset.modes(self._top))


@contextmanager
def _unseen(name: str) -> Iterator[Callable[[str, float], object]]:
    """Show nothing of how an object is made."""
    yield lambda doing, done: None


_SOLID = ("box", "cylinder")


def _has_faces(size: Any) -> bool:
    """True if the size of a mesh is its vertices and its faces."""
    return isinstance(size, tuple | list) and len(size) == 2 and np.ndim(size[0]) == 2


def _weighed(shape: Shape, material: Material, density: Any, mass: Any, inertia: Any) -> tuple[float, Vector]:
    """Return a body's mass (kg) and its moments of inertia (kg m^2), as they are given or by its shape."""
    if density is not None and mass is not None:
        raise ValueError(f"density = {shown(density)}, mass = {shown(mass)}: expected one of the two")
    density = material.density if density is None else _positive("density", density)
    mass = density * shape.volume if mass is None else _positive("mass", mass)
    if inertia is None:
        x, y, z = shape.inertia
        return mass, (mass * x, mass * y, mass * z)
    wanted = "three moments, kg m^2"
    moments = tuple(_positive("inertia", each) for each in np.ravel(array_of("inertia", inertia, wanted)))
    if len(moments) != 3:
        raise ValueError(f"inertia = {moments}: expected {wanted}")
    return mass, moments


def _positive(name: str, value: Argument) -> float:
    real = isinstance(value, int | float | np.integer | np.floating)
    taken = _RANGES[name].within(value) if real else None  # type: ignore[arg-type]
    if taken is None:
        raise ValueError(f"{name} = {shown(value)}: expected {_RANGES[name].expected}")
    return taken
