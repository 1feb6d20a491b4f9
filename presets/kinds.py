"""Presets as objects: strikers, surfaces and objects, made from the data of a file."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from ..dsp.bodies.heard import Best
from ..dsp.bodies.material import CONTACT_RADIUS, HERTZ_EXPONENT, Material, contact_between, hertz
from ..dsp.bodies.modes import Modes, Silent
from ..dsp.bodies.striker import StrikerSound
from ..dsp.wording import expected
from .gestures import Usual
from .making import made
from .schema import (
    ADDED,
    BALL,
    DESCRIPTION,
    LAW,
    LICENCE,
    LOST,
    OBJECT,
    REST,
    SECTIONS,
    SHAPES,
    SIZED,
    SLIDE,
    SOUNDS,
    STRIKE,
    STRIKER,
    SUITABLE,
    SURFACE,
    SURFACE_REQUIRED,
    Fields,
    NoPreset,
    PresetError,
    check,
)
from .sounding import sound_of
from .stored import STORE
from .values import Computed, Many, Row, shown

if TYPE_CHECKING:
    from ..dsp.bodies.added import Added

STAND_IN = "steel"
"""The material of an object that has none, where it strikes another one or is struck by it."""

DRY = {
    "static": 0.4, "dynamic": 0.3, "stribeck": 0.1, "tangential": 0.0, "along": 0.0, "patch": 0.0, "sweep": -1.0,
    "radius": 0.01,
}  # fmt: skip
"""Sliding parameters of a striker whose preset does not say them: hard and dry, and it is only scraped."""

STEREO_WIDTH = 0.5
"""Width of an object's image, unless its preset says it: 0 is a point, 1 from the left output to the right one."""


class Library(Protocol):
    """A library, in which a preset finds the others that it names."""

    def material(self, name: str) -> Material: ...

    def striker(self, name: str) -> StrikerPreset: ...

    def path(self, kind: str, name: str) -> Path: ...


@dataclass(frozen=True)
class StrikerPreset:
    """A striker, given by its contact law or as a ball (a tip) of a material."""

    name: str
    description: str
    source: str
    mass: float
    dissipation: float = 0.0
    restitution: float | None = None
    """Restitution, in place of the dissipation."""
    stiffness: float | None = None
    exponent: float = HERTZ_EXPONENT
    material: Material | None = None
    radius: float | None = None
    area: float = 0.0
    """m^2 that it covers where it is pressed on; 0: it touches at a point."""
    sound: StrikerSound | None = None
    """Sound of the striker itself."""
    slide: Mapping[str, float] = field(default_factory=dict)
    """Values of a slide's keys, where a slide does not say them."""

    @classmethod
    def from_data(cls, name: str, where: str, data: Mapping[str, object], library: Library) -> StrikerPreset:
        """Make a striker from its file's data. `where` begins the text of a PresetError."""
        required = (*DESCRIPTION, *(BALL if "material" in data or "radius" in data else LAW))
        taken = (*required, *LICENCE, *LOST, "mass", "area", *SOUNDS, "slide")
        fields = {key: domain for key, domain in STRIKER.items() if key in taken}
        values = check(where, data, fields, required)
        values.pop("licence", None)
        if len(values.keys() & set(LOST)) != 1:
            raise PresetError(f"{where}dissipation, restitution: expected one of the two")
        if "material" in values:
            material = values["material"] = _material(values["material"], where, library)
            values.setdefault("mass", material.density * 4 / 3 * math.pi * values["radius"] ** 3)
        sections = {key: values.pop(key) for key in SOUNDS if key in values}
        values["slide"] = check(f"{where}[slide] ", values.pop("slide", {}), SLIDE, ())
        ball = None if "mass" in data else values.get("radius")
        return cls(name, **values, sound=sound_of(where, sections, values["mass"], ball))

    @property
    def sliding(self) -> dict[str, float]:
        """Sliding parameters: values of a slide's keys."""
        return {**DRY, **({"radius": self.radius} if self.radius else {}), **self.slide}

    def contact(self, material: Material | None) -> tuple[float, float, float, float]:
        """Return the mass (kg), stiffness (N/m^a), dissipation (s/m; 0 where there is a restitution) and exponent a
        against an object of `material`.

        A ball's stiffness is Hertz's with a plane of the material, a rigid one if None.
        """
        stiffness = self.stiffness
        if self.material is not None and self.radius is not None:
            stiffness = hertz(self.material, self.radius, material)
        assert stiffness is not None
        return self.mass, stiffness, self.dissipation, self.exponent


class SurfacePreset(NamedTuple):
    """A surface that bodies roll and slide on.

    It has an rms roughness (m), a correlation length (m), the slope of its power spectrum above that, the dissipation
    (s/m) of the contact of a rolling body, the amplitude (m) and wavelength (m) of a corrugation, and how far its
    roughness varies from place to place (a standard deviation, dB), and over which length (m).
    """

    name: str
    description: str
    source: str
    roughness: float
    correlation: float
    slope: float
    dissipation: float
    ripple: float = 0.0
    wavelength: float = 1.0
    variation: float = 0.0
    variation_length: float = 0.05

    @classmethod
    def from_data(cls, name: str, where: str, data: Mapping[str, object]) -> SurfacePreset:
        """Make a surface from its file's data. `where` begins the text of a PresetError."""
        return cls(name, **check(where, data, SURFACE, SURFACE_REQUIRED))

    @property
    def profile(self) -> tuple[float, ...]:
        """Roughness (m), correlation (m), slope, ripple (m), wavelength (m), variation (dB) and its length (m)."""
        shape = self.roughness, self.correlation, self.slope, self.ripple, self.wavelength
        return *shape, self.variation, self.variation_length


class Standing(NamedTuple):
    """The support on which an object rests by itself, by its weight, and its feet: positions on its strike path, or
    points of its surface (m)."""

    support: str
    positions: tuple[float, ...] = ()
    points: tuple[tuple[float, ...], ...] = ()


@dataclass(frozen=True)
class ObjectPreset:
    """An object: shape, geometry and material, and how it is struck by default."""

    name: str
    description: str
    source: str
    shape: str
    geometry: Mapping[str, Any]
    material: Material | None
    striker: str
    velocity: float
    position: float
    level: float
    gestures: Mapping[str, Usual]
    """Default values of the gestures that suit it, by name."""
    glide: float | None
    """Rise of its tension (1/J) with the energy that rings; None: by its geometry and material."""
    stereo_width: float
    most_modes: int | None
    """Most modes to keep: those that are heard best; None: all."""
    standing: Standing | None
    """The support on which it rests by itself, and where; None: it hangs freely."""
    added: tuple[Added, ...]
    written: Material | None
    """The material of the preset's file, which the decay times of what is added were given for."""
    where: str = field(repr=False)
    _data: Mapping[str, Any] = field(repr=False, compare=False)
    _library: Library = field(repr=False, compare=False)
    _of_one_size: tuple[float, Mapping[str, Any]] | None = field(default=None, repr=False)
    """The size, and the geometry of the body of size 1, where it is similar to that."""
    _replaced: frozenset[str] = field(default=frozenset(), repr=False, compare=False)
    """The keys of which it has other values than its file."""

    @classmethod
    def from_data(cls, name: str, where: str, data: dict[str, Any], library: Library) -> ObjectPreset:
        """Make an object from its file's data. `where` begins the text of a PresetError; without it, keys stand
        alone."""
        values = check(where, data, OBJECT, ("description", "source", "shape", "level"))
        shape = SHAPES[values["shape"]]
        if "mesh" in values:
            raise PresetError(f"{where}[mesh]: expected it of the shape mesh only")
        titles = {key: f"{where}[{key}] " if where else "" for key in SECTIONS}
        geometry = check(titles["geometry"], data.get("geometry", {}), shape.fields, shape.required)
        one, other = ([key for key in geometry if key in side] for side in shape.either)
        if one and other:
            raise PresetError(f"{titles['geometry']}{one[0]} and {other[0]}: expected one of the two")
        damping = check(titles["damping"], data.get("damping", {}), shape.damping, ())
        strike = check(titles["strike"], data.get("strike", {}), STRIKE, tuple(STRIKE))
        try:
            library.striker(strike["striker"])
        except PresetError as error:
            raise PresetError(f"{titles['strike']}striker = {shown(strike['striker'])}: {_reason(error)}") from None
        standing = None
        if "rest" in values:
            standing = _standing(titles["rest"], values["rest"], values["shape"])
        material = None
        if "material" in values:
            material = replace(_material(values["material"], where, library), **damping)
        elif shape.has_material:
            raise PresetError(f"{where}material is missing: expected the name of a material")
        added = tuple(_added(key, titles[key], values[key]) for key in ADDED if key in values)
        return cls(
            name=name,
            description=values["description"],
            source=values["source"],
            shape=values["shape"],
            geometry=geometry,
            material=material,
            level=values["level"],
            gestures={name: _usual(name, titles[name], values[name], library) for name in SUITABLE if name in values},
            glide=values.get("glide"),
            stereo_width=values.get("stereo_width", STEREO_WIDTH),
            most_modes=values.get("most_modes"),
            standing=standing,
            added=added,
            written=material,
            where=titles["geometry"],
            _data=data,
            _library=library,
            **strike,
        )

    def modes(self, top: float) -> Modes:
        """Return its modes up to `top` (Hz), in arrays that are read-only, as equal objects share them.

        PresetError if the geometry gives none or contradicts itself.
        """
        shape = SHAPES[self.shape]
        arguments, make, spares = dict(self.geometry), shape.make, "best" in shape.parameters
        if self._of_one_size is not None:
            from ..dsp.bodies.similar import Sized  # with all shapes

            size, arguments = self._of_one_size[0], dict(self._of_one_size[1])
            kept = not self._replaced & {"material", *shape.fields}
            make, spares = Sized(make, size, shape.lengths, STORE if kept else None), True
        if shape.has_material:
            arguments["material"] = self.material
        if self.added:
            from ..dsp.bodies.added import Complete  # with what adds

            make, spares = Complete(make, self.added, self.written), False
        try:
            best = Best(self.stereo_width, self.most_modes)
            modes = made(make, top, arguments, best, spares=spares, on_disk=not self._replaced)
        except ValueError as error:
            where = self.where or (f"{self.name}: " if isinstance(error, Silent) else "")
            raise PresetError(f"{where}{error}") from None
        return modes if self.glide is None else replace(modes, glide=self.glide)

    def struck_by(
        self, striker: ObjectPreset, radius: float = CONTACT_RADIUS, part: Material | None = None
    ) -> tuple[float, float, float]:
        """Return the stiffness (N/m^a), dissipation (s/m) and exponent a of its contact with another object.

        They come from both materials; `radius` (m) is the striker's where they touch, `part` the material of the part
        that is struck, if it is another one. See `contact_between`.
        """
        return contact_between(striker._contact_material, part or self._contact_material, radius)

    def resting_on(self, material: str, radius: float = CONTACT_RADIUS) -> tuple[float, float, float]:
        """Return the same of its contact with a ground of a material, by its preset; `radius` (m) is its own."""
        return contact_between(self._contact_material, self._library.material(material), radius)

    @cached_property
    def damping(self) -> dict[str, Any]:
        """What its file gives anew of its material's damping."""
        return check("", self._data.get("damping", {}), SHAPES[self.shape].damping, ())

    @cached_property
    def _contact_material(self) -> Material:
        return self.material or self._library.material(STAND_IN)

    @cached_property
    def _sections(self) -> dict[str, tuple[str, Fields]]:
        """Section of the file and its fields, by each key that `replace` takes ("": no section)."""
        shape = SHAPES[self.shape]
        sections = {"geometry": shape.fields, "damping": shape.damping, "strike": STRIKE}
        own = {key: (section, fields) for section, fields in sections.items() for key in fields}
        given = ("material", "level", "stereo_width", "most_modes", "glide")
        return {**own, **dict.fromkeys(given, ("", OBJECT))}

    @cached_property
    def keys(self) -> tuple[str, ...]:
        """The keys that `replace` takes."""
        return (*self._sections, "size", *(("rest",) if "rest" in self._data else ()))

    def replace(self, /, **changes: object) -> ObjectPreset:
        """Return the preset with other values of its geometry, damping, strike, material (a name), level, stereo width
        or glide.

        A list may be a list, a tuple, or a text like "free,clamped,free,clamped". A key that excludes others (tension,
        fundamental) takes their place. size: factor of all lengths that are not given. PresetError names the key.
        """
        if "size" in changes:
            size = changes.pop("size")
            return (self.replace(**changes) if changes else self).in_size(size, changes)
        sections, either = self._sections, SHAPES[self.shape].either
        data: dict[str, Any] = {
            name: dict(part) if isinstance(part, Mapping) else part for name, part in self._data.items()
        }
        if "rest" in changes and "rest" in data:
            data["rest"]["support"] = check("", {"rest": changes.pop("rest")}, {"rest": REST["support"]}, ())["rest"]
        for key, value in changes.items():
            if key not in sections:
                raise PresetError(f"{key} = {shown(value)}: {expected(key, self.keys)}")
            section, fields = sections[key]
            domain = fields[key]
            table = data.setdefault(section, {}) if section else data
            table[key] = domain.parse(value) if isinstance(domain, Row | Many) and isinstance(value, str) else value
            for side, other in (either, either[::-1]):
                if key in side:
                    for rival in other - changes.keys():
                        data["geometry"].pop(rival, None)
        made = ObjectPreset.from_data(self.name, "", data, self._library)
        return replace(made, written=self.written, _replaced=self._replaced | changes.keys())

    def in_size(self, size: object, given: Collection[str]) -> ObjectPreset:
        """Return the preset with all lengths times a size, but for those that were given. PresetError as `replace`."""
        from ..dsp.bodies.similar import has_similar  # with all shapes

        shape = SHAPES[self.shape]
        lengths = [key for key in shape.lengths if key in self.geometry]
        if self.shape == "listed" or not lengths:
            fixed = "a table's" if self.shape == "mesh" else "listed"
            raise PresetError(f"size = {shown(size)}: expected none, as the modes of {self.name} are {fixed}")
        factor = check("", {"size": size}, SIZED, ())["size"]
        scaled = {key: factor * self.geometry[key] for key in lengths if key not in given}
        where = f"size = {shown(size)}: "
        checked = check(where, {key: Computed(value) for key, value in scaled.items()}, shape.fields, ())
        geometry = {**self.geometry, **checked}
        data = {**self._data, "geometry": {**self._data["geometry"], **scaled}}
        added = self.added
        if "cavity" in data:
            from ..dsp.bodies.cavity import POWERS

            data["cavity"] = {
                key: Computed(value * factor ** POWERS[key]) if key in POWERS else value
                for key, value in data["cavity"].items()
            }
            added = tuple(
                _added(key, f"{where}[{key}] ", data[key]) if key == "cavity" else each
                for key, each in zip((key for key in ADDED if key in data), added, strict=True)
            )
        alike = factor != 1.0 and len(scaled) == len(lengths) and has_similar(shape.make, self.geometry)
        of_one_size = (factor, self.geometry) if alike else None
        return replace(
            self, geometry=geometry, added=added, where="", _data=data, _of_one_size=of_one_size,
            _replaced=self._replaced | {"size"},
        )  # fmt: skip


def _added(section: str, where: str, data: Mapping[str, object]) -> Added:
    addition = ADDED[section]
    values = check(where, data, addition.fields, addition.required)
    try:
        return addition.make(**values)
    except ValueError as error:
        raise PresetError(f"{where}{error}") from None


def _standing(where: str, data: Mapping[str, object], shape: str) -> Standing:
    """Return where an object stands by itself. PresetError if it does not say so in one way."""
    values = check(where, data, REST, ("support",))
    feet = [key for key in ("positions", "points") if key in values]
    if len(feet) != 1:
        raise PresetError(f"{where}{' and '.join(feet) or 'positions or points'}: expected one of positions and points")
    if feet == ["points"] and shape != "mesh":
        raise PresetError(f"{where}points: expected positions, as a {shape} has no surface")
    return Standing(**values)


def _usual(name: str, where: str, data: Mapping[str, object], library: Library) -> Usual:
    usual = Usual.from_data(name, where, data)
    for key, value in (("striker", usual.striker), ("surface", usual.surface)):
        try:
            if value:
                library.path(f"{key}s", value)
        except PresetError as error:
            raise PresetError(f"{where}{key} = {shown(value)}: {_reason(error)}") from None
    return usual


def _material(name: str, where: str, library: Library) -> Material:
    try:
        return library.material(name)
    except PresetError as error:
        raise PresetError(f"{where}material = {shown(name)}: {_reason(error)}") from None


def _reason(error: PresetError) -> str:
    """Say why a preset that another one names is missing, or wrong."""
    return error.expected if isinstance(error, NoPreset) else str(error)
