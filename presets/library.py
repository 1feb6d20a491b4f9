"""Presets: materials, strikers and objects from TOML files, checked against one schema, made into modes."""

from __future__ import annotations

import copy
import difflib
import inspect
import math
import os
import re
import reprlib
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from ..dsp.bodies import shapes
from ..dsp.bodies.material import Material, hertz

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

BUILT_IN = Path(__file__).resolve().parent
KINDS = ("materials", "strikers", "surfaces", "objects")
NAME = re.compile(r"[A-Za-z0-9_-]{1,64}")


class PresetError(ValueError):
    """A preset that is unknown or does not fit: "FILE: [section] key = VALUE: expected WHAT"."""


# What a value may be. `fit` gives it as it is used, or None.


@dataclass(frozen=True)
class Number:
    low: float
    high: float
    unit: str = ""

    def __str__(self) -> str:
        return f"a number from {self.low:g} to {self.high:g} {self.unit}".rstrip()

    def fit(self, value: object) -> float | None:
        if isinstance(value, bool) or not isinstance(value, int | float) or not self.low <= value <= self.high:
            return None
        return float(value)


@dataclass(frozen=True)
class Whole(Number):
    def __str__(self) -> str:
        return f"a whole number from {self.low:g} to {self.high:g}"

    def fit(self, value: object) -> int | None:
        number = super().fit(value)
        return int(number) if number is not None and number.is_integer() else None


@dataclass(frozen=True)
class Text:
    def __str__(self) -> str:
        return "a text"

    def fit(self, value: object) -> str | None:
        return value if isinstance(value, str) else None


@dataclass(frozen=True)
class Name(Text):
    def __str__(self) -> str:
        return "a name of up to 64 letters, digits, _ and -"

    def fit(self, value: object) -> str | None:
        return value if isinstance(value, str) and NAME.fullmatch(value) else None


@dataclass(frozen=True)
class Choice:
    options: tuple[str, ...]

    def __str__(self) -> str:
        return f"one of {', '.join(self.options)}"

    def fit(self, value: object) -> str | None:
        return value if isinstance(value, str) and value in self.options else None


@dataclass(frozen=True)
class Row:
    """A list whose values fit one kind each, in order."""

    kinds: tuple[Number | Choice, ...]

    def __str__(self) -> str:
        return f"a list of {', '.join(map(str, self.kinds))}"

    def fit(self, value: object) -> tuple[Any, ...] | None:
        if not isinstance(value, list) or len(value) != len(self.kinds):
            return None
        fitted = tuple(kind.fit(item) for kind, item in zip(self.kinds, value, strict=True))
        return None if None in fitted else fitted


@dataclass(frozen=True)
class Many:
    """A list of 1 to 1024 values of one kind."""

    kind: Number

    def __str__(self) -> str:
        return f"a list, each {self.kind}"

    def fit(self, value: object) -> tuple[float, ...] | None:
        if not isinstance(value, list) or not 0 < len(value) <= 1024:
            return None
        fitted = tuple(self.kind.fit(item) for item in value)
        return None if None in fitted else fitted  # type: ignore[return-value]


@dataclass(frozen=True)
class Section:
    def __str__(self) -> str:
        return "a section of keys"

    def fit(self, value: object) -> dict[str, Any] | None:
        return value if isinstance(value, dict) else None


@dataclass(frozen=True)
class OneOrMany(Many):
    def __str__(self) -> str:
        return f"{self.kind}, or a list of such"

    def fit(self, value: object) -> Any:
        return super().fit(value) if isinstance(value, list) else self.kind.fit(value)


Kind = Number | Text | Choice | Row | Many | Section
Fields = Mapping[str, Kind]


@dataclass(frozen=True)
class Shape:
    """A function that makes modes, what its arguments may be, and where its pickups are.

    A key of one `either` set excludes those of the other: two ways to say one thing.
    """

    make: Callable[..., shapes.Modes]
    fields: Fields
    pickup: Kind | None = None
    either: tuple[frozenset[str], frozenset[str]] = (frozenset(), frozenset())

    @property
    def parameters(self) -> Mapping[str, inspect.Parameter]:
        return inspect.signature(self.make).parameters

    @property
    def required(self) -> tuple[str, ...]:
        return tuple(key for key in self.fields if self.parameters[key].default is inspect.Parameter.empty)


LENGTH = Number(1e-3, 20, "m")
THICKNESS = Number(1e-5, 0.5, "m")
FRACTION = Number(0, 1)
ANGLE = Number(-360, 360, "degrees")
FREQUENCY = Number(1, 20000, "Hz")
POINT = Row((FRACTION, FRACTION))
ROUND = {"split": Number(0, 0.1), "imperfection": ANGLE}
TUNING = (frozenset({"tension"}), frozenset({"fundamental"}))

SHAPES: Mapping[str, Shape] = {
    "bar": Shape(
        shapes.bar,
        {
            "length": LENGTH,
            "width": THICKNESS,
            "thickness": THICKNESS,
            "undercut": Number(0, 0.95),
            "undercut_span": Number(0.1, 1),
            "diameter": THICKNESS,
            "wall": THICKNESS,
            "ends": Choice(("free", "cantilever")),
        },
        FRACTION,
        (frozenset({"width", "thickness", "undercut", "undercut_span"}), frozenset({"diameter", "wall"})),
    ),
    "string": Shape(
        shapes.string,
        {
            "length": LENGTH,
            "diameter": Number(1e-5, 0.02, "m"),
            "tension": Number(0.1, 1e5, "N"),
            "fundamental": FREQUENCY,
            "linear_density": Number(1e-6, 10, "kg/m"),
            "inharmonicity": Number(0, 0.1),
        },
        FRACTION,
        TUNING,
    ),
    "plate": Shape(
        shapes.plate,
        {
            "length": LENGTH,
            "width": LENGTH,
            "thickness": THICKNESS,
            "edges": Row((Choice(("free", "clamped", "supported")),) * 4),
            "path_from": POINT,
            "path_to": POINT,
        },
        POINT,
    ),
    "disc": Shape(
        shapes.disc,
        {"radius": LENGTH, "thickness": THICKNESS, "edge": Choice(("free", "clamped", "supported")), **ROUND},
        Row((FRACTION, ANGLE)),
    ),
    "membrane": Shape(
        shapes.membrane,
        {
            "radius": LENGTH,
            "thickness": THICKNESS,
            "tension": Number(1, 1e6, "N/m"),
            "fundamental": FREQUENCY,
            **ROUND,
        },
        Row((FRACTION, ANGLE)),
        TUNING,
    ),
    "ring": Shape(shapes.ring, {"radius": LENGTH, "thickness": THICKNESS, "length": LENGTH, **ROUND}, ANGLE),
    "glass": Shape(
        shapes.glass,
        {"radius": LENGTH, "height": LENGTH, "thickness": THICKNESS, "rows": Whole(1, 3), **ROUND},
        ANGLE,
    ),
    "listed": Shape(
        shapes.listed,
        {
            "frequency": Many(FREQUENCY),
            "t60": OneOrMany(Number(1e-3, 200, "s")),
            "modal_mass": OneOrMany(Number(1e-6, 1e5, "kg")),
            "mass": Number(1e-5, 1e6, "kg"),
            "weight": OneOrMany(Number(-100, 100)),
        },
    ),
}

DAMPING: Fields = {
    "alpha": Number(0, 1e4, "1/s"),
    "beta": Number(0, 1e-3, "s"),
    "loss_factor": Number(0, 1),
}
MATERIAL: Fields = {
    "source": Text(),
    "density": Number(1, 3e4, "kg/m3"),
    "youngs_modulus": Number(1e4, 2e12, "Pa"),
    "poisson_ratio": Number(0, 0.4999),
    **DAMPING,
}
DESCRIPTION: Fields = {"description": Text(), "source": Text()}
CONTACT: Fields = {
    "mass": Number(1e-6, 1e3, "kg"),
    "stiffness": Number(1, 1e16, "N/m^exponent"),
    "dissipation": Number(0, 1e3, "s/m"),
    "exponent": Number(1, 5),
    "material": Name(),
    "radius": Number(1e-4, 1, "m"),
}
SURFACE: Fields = {
    "roughness": Number(0, 0.1, "m"),
    "correlation": Number(1e-6, 100, "m"),
    "slope": Number(1.01, 5),
    "ripple": Number(0, 0.1, "m"),
    "wavelength": Number(1e-5, 100, "m"),
    "dissipation": Number(0, 1e3, "s/m"),
}
LAW = ("mass", "stiffness", "dissipation", "exponent")
BALL = ("material", "radius", "dissipation")  # and its mass, if it is not that of a solid ball
STRIKE: Fields = {"striker": Name(), "velocity": Number(1e-3, 100, "m/s"), "position": FRACTION}
LEVEL = Number(-120, 120, "dB")
TABLE: Mapping[str, Kind] = {
    **DESCRIPTION,
    "shape": Choice(tuple(SHAPES)),
    "material": Name(),
    "level": LEVEL,
    **dict.fromkeys(("geometry", "damping", "strike", "pickup"), Section()),
}


def _shown(value: object) -> str:
    """A value as an error names it."""
    return reprlib.repr(value)


def _check(where: str, table: Mapping[str, object], fields: Fields, required: Sequence[str]) -> dict[str, Any]:
    """The table's values as they are used. PresetError names a key that is wrong, unknown or missing."""
    checked = {}
    for key, value in table.items():
        if key not in fields:
            raise PresetError(f"{where}{key} = {_shown(value)}: expected one of {', '.join(fields) or 'no key'}")
        checked[key] = fields[key].fit(value)
        if checked[key] is None:
            raise PresetError(f"{where}{key} = {_shown(value)}: expected {fields[key]}")
    for key in required:
        if key not in table:
            raise PresetError(f"{where}{key} is missing: expected {fields[key]}")
    return checked


@dataclass(frozen=True)
class StrikerPreset:
    """A striker, given by its contact law or as a ball (a tip) of a material."""

    name: str
    description: str
    source: str
    dissipation: float
    mass: float
    stiffness: float | None = None
    exponent: float = 1.5
    material: Material | None = None
    radius: float | None = None

    def contact(self, material: Material | None) -> tuple[float, float, float, float]:
        """Mass (kg), stiffness (N/m^a), dissipation (s/m) and exponent a against an object of `material`.

        A ball's stiffness is Hertz's with a plane of the material, a rigid one if None.
        """
        stiffness = self.stiffness
        if self.material is not None and self.radius is not None:
            stiffness = hertz(self.material, self.radius, material)
        assert stiffness is not None
        return self.mass, stiffness, self.dissipation, self.exponent


@dataclass(frozen=True)
class SurfacePreset:
    """What a body rolls on: rms roughness (m), correlation length (m), slope of the power spectrum above it, the
    dissipation (s/m) of what rolls on it, and the amplitude (m) and wavelength (m) of a corrugation."""

    name: str
    description: str
    source: str
    roughness: float
    correlation: float
    slope: float
    dissipation: float
    ripple: float = 0.0
    wavelength: float = 1.0

    @property
    def profile(self) -> tuple[float, float, float, float, float]:
        return self.roughness, self.correlation, self.slope, self.ripple, self.wavelength


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
    pickups: tuple[Any, Any] | None
    where: str = field(repr=False)
    _data: Mapping[str, Any] = field(repr=False, compare=False)
    _presets: Presets = field(repr=False, compare=False)

    def modes(self, top: float) -> shapes.Modes:
        """Its modes up to `top` (Hz). PresetError if the geometry gives none or contradicts itself."""
        shape = SHAPES[self.shape]
        arguments = dict(self.geometry)
        if self.pickups:
            arguments["pickups"] = self.pickups
        if "material" in shape.parameters:
            arguments["material"] = self.material
        import scipy.linalg  # noqa: F401 - slow to load, and its BLAS must be there to be limited

        try:
            # On machines of few cores BLAS's waiting threads cost tens of times the work, and disturb the audio.
            with threadpool_limits(limits=1, user_api="blas"):
                return shape.make(top=top, **arguments)
        except ValueError as error:
            raise PresetError(f"{self.where}{error}") from None

    def replace(self, /, **changes: object) -> ObjectPreset:
        """The preset with other values of its geometry, damping, strike, material (a name) or level.

        PresetError names the key. A key that excludes others (tension, fundamental) takes their place.
        """
        shape = SHAPES[self.shape]
        places = {"geometry": shape.fields, "damping": DAMPING, "strike": STRIKE}
        home = {key: section for section, fields in places.items() for key in fields}
        data: dict[str, Any] = copy.deepcopy(dict(self._data))
        for key, value in changes.items():
            section = home.get(key)
            if section is None and key not in ("material", "level"):
                known = ", ".join([*home, "material", "level"])
                raise PresetError(f"{key} = {_shown(value)}: expected one of {known}")
            (data.setdefault(section, {}) if section else data)[key] = value
            for side, other in (shape.either, shape.either[::-1]):
                if key in side:
                    for rival in other - changes.keys():
                        data["geometry"].pop(rival, None)
        return _object(self.name, "", data, self._presets)


class Presets:
    """Presets by name, first from the user's folders (each with objects/, strikers/, materials/).

    Files are read when asked for, so an edited one counts from then on.
    """

    def __init__(self, folders: Sequence[Path] = ()) -> None:
        for folder in folders:
            if not Path(folder).is_dir():
                raise PresetError(f"{folder}: expected a folder with {', '.join(KINDS)}")
        self._folders = (*map(Path, folders), BUILT_IN)

    def names(self, kind: str) -> list[str]:
        """All names of a kind: materials, strikers, surfaces or objects."""
        if kind not in KINDS:
            raise ValueError(f"kind = {kind!r}: expected one of {', '.join(KINDS)}")
        files = (path for folder in self._folders for path in (folder / kind).glob("*.toml"))
        return sorted({path.stem for path in files if NAME.fullmatch(path.stem)})

    def material(self, name: str) -> Material:
        """The material of that name. PresetError if there is none, or its file is wrong."""
        where, data = self._read("materials", name)
        required = ("source", "density", "youngs_modulus", "poisson_ratio", "alpha", "beta")
        values = _check(where, data, MATERIAL, required)
        values.pop("source")
        return Material(name, **values)

    def striker(self, name: str) -> StrikerPreset:
        """The striker of that name. PresetError if there is none, or its file is wrong."""
        where, data = self._read("strikers", name)
        required = (*DESCRIPTION, *(BALL if "material" in data or "radius" in data else LAW))
        fields = {key: kind for key, kind in {**DESCRIPTION, **CONTACT}.items() if key in (*required, "mass")}
        values = _check(where, data, fields, required)
        if "material" in values:
            material = values["material"] = self._named("material", values["material"], where)
            values.setdefault("mass", material.density * 4 / 3 * math.pi * values["radius"] ** 3)
        return StrikerPreset(name, **values)

    def surface(self, name: str) -> SurfacePreset:
        """The surface of that name. PresetError if there is none, or its file is wrong."""
        where, data = self._read("surfaces", name)
        values = _check(
            where, data, {**DESCRIPTION, **SURFACE}, (*DESCRIPTION, "roughness", "correlation", "slope", "dissipation")
        )
        return SurfacePreset(name, **values)

    def object(self, name: str) -> ObjectPreset:
        """The object of that name. PresetError if there is none, or its file is wrong."""
        where, data = self._read("objects", name)
        return _object(name, where, data, self)

    def _named(self, key: str, name: str, where: str) -> Material:
        try:
            return self.material(name)
        except PresetError as error:
            raise PresetError(f"{where}{key} = {_shown(name)}: {error}") from None

    def _read(self, kind: str, name: str) -> tuple[str, dict[str, Any]]:
        path = self.path(kind, name)
        try:
            return f"{path}: ", tomllib.loads(path.read_text(encoding="utf-8"))
        except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
            raise PresetError(f"{path}: not TOML: {error}") from None
        except OSError as error:
            raise PresetError(f"{path}: {error.strerror}") from None

    def description(self, kind: str, name: str) -> str:
        """What a preset says of itself, or its source."""
        data = self._read(kind, name)[1]
        return str(data.get("description", data.get("source", "")))

    def path(self, kind: str, name: str) -> Path:
        """The file of a preset. PresetError if there is none."""
        singular = kind.removesuffix("s")
        if not NAME.fullmatch(name):
            raise PresetError(f"{singular} {_shown(name)}: expected {Name()}")
        for folder in self._folders:
            # Not as a Path before it is one of ours: pathlib keeps the parts of all it ever made.
            path = f"{folder / kind}/{name}.toml"
            if os.path.isfile(path):
                return Path(path)
        known = self.names(kind)
        close = difflib.get_close_matches(name, known)
        hint = f"did you mean {' or '.join(close)}?" if close else f"expected one of {', '.join(known)}"
        raise PresetError(f"no {singular} {name!r}: {hint}")


def _object(name: str, where: str, data: dict[str, Any], presets: Presets) -> ObjectPreset:
    """An object from its file's data; `where` begins the text of every error (empty: keys alone)."""

    def section(title: str, fields: Fields, required: Sequence[str] = ()) -> dict[str, Any]:
        return _check(f"{where}[{title}] " if where else "", data.get(title, {}), fields, required)

    values = _check(where, data, TABLE, ("description", "source", "shape", "level"))
    shape = SHAPES[values["shape"]]
    geometry = section("geometry", shape.fields, shape.required)
    one, other = ([key for key in geometry if key in side] for side in shape.either)
    if one and other:
        label = f"{where}[geometry] " if where else ""
        raise PresetError(f"{label}{one[0]} and {other[0]}: expected one of the two")
    damping = section("damping", DAMPING if "material" in shape.parameters else {})
    strike = section("strike", STRIKE, tuple(STRIKE))
    try:
        presets.striker(strike["striker"])
    except PresetError as error:
        title = f"{where}[strike] " if where else ""
        raise PresetError(f"{title}striker = {_shown(strike['striker'])}: {error}") from None
    pickup = section("pickup", {"left": shape.pickup, "right": shape.pickup} if shape.pickup else {})
    if len(pickup) == 1:
        raise PresetError(f"{where}[pickup] {next(iter(pickup))}: expected left and right")

    material = None
    if "material" in values:
        material = replace(presets._named("material", values["material"], where), **damping)
    elif "material" in shape.parameters:
        raise PresetError(f"{where}material is missing: expected {TABLE['material']}")
    return ObjectPreset(
        name=name,
        description=values["description"],
        source=values["source"],
        shape=values["shape"],
        geometry=geometry,
        material=material,
        level=values["level"],
        pickups=(pickup["left"], pickup["right"]) if pickup else None,
        where=f"{where}[geometry] " if where else "",
        _data=data,
        _presets=presets,
        **strike,
    )
