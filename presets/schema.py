"""The schema of presets: the keys of every kind of file, and what the value of each may be."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from ..dsp import bodies as shapes
from ..dsp import schema
from ..dsp.bodies.bar import ENDS
from ..dsp.bodies.disc import EDGES as DISC_EDGES
from ..dsp.bodies.plate import EDGES as PLATE_EDGES
from .values import Choice, Domain, Many, Name, OneOrMany, Quantity, Row, Section, Text, Unfit, Whole, shown

Fields = Mapping[str, Domain]


class PresetError(ValueError):
    """A preset that is unknown or does not fit: "FILE: [section] key = VALUE: expected WHAT"."""


def check(where: str, table: Mapping[str, object], fields: Fields, required: Sequence[str]) -> dict[str, Any]:
    """The table's values as they are used. PresetError names a key that is wrong, unknown or missing."""
    checked = {}
    for key, value in table.items():
        if key not in fields:
            known = f"one of {', '.join(fields)}" if fields else "no key"
            raise PresetError(f"{where}{key} = {shown(value)}: expected {known}")
        try:
            checked[key] = fields[key].fit(value)
        except Unfit as error:
            raise PresetError(f"{where}{key}{error}") from None
    for key in required:
        if key not in table:
            raise PresetError(f"{where}{key} is missing: expected {fields[key]}")
    return checked


# Contacts: strikers, and the surfaces and materials that they meet.

LAW_FIELDS: Mapping[str, Quantity] = {
    each.name: Quantity(each.low, each.high, each.unit) for each in (*schema.LAW, schema.RADIUS)
}
LAW = ("mass", "stiffness", "dissipation", "exponent")
BALL = ("material", "radius", "dissipation")
"""The keys of a striker that is a ball; its `mass` is given only if it is not that of a solid one."""

DESCRIPTION: Fields = {"description": Text(), "source": Text()}
STRIKER: Fields = {**DESCRIPTION, **LAW_FIELDS, "material": Name()}
SURFACE: Fields = {
    **DESCRIPTION,
    "roughness": Quantity(0, 0.1, "m"),
    "correlation": Quantity(1e-6, 100, "m"),
    "slope": Quantity(1.01, 5),
    "ripple": Quantity(0, 0.1, "m"),
    "wavelength": Quantity(1e-5, 100, "m"),
    "dissipation": LAW_FIELDS["dissipation"],
}
DAMPING: Fields = {
    "alpha": Quantity(0, 1e4, "1/s"),
    "beta": Quantity(0, 1e-3, "s"),
    "loss_factor": Quantity(0, 1),
}
MATERIAL: Fields = {
    "source": Text(),
    "density": Quantity(1, 3e4, "kg/m3"),
    "youngs_modulus": Quantity(1e4, 2e12, "Pa"),
    "poisson_ratio": Quantity(0, 0.4999),
    "dissipation": LAW_FIELDS["dissipation"],
    **DAMPING,
}

# Objects: shapes and their geometry.

LENGTH = Quantity(1e-3, 20, "m")
THICKNESS = Quantity(1e-5, 0.5, "m")
FRACTION = Quantity(0, 1)
ANGLE = Quantity(-360, 360, "degrees")
FREQUENCY = Quantity(1, 20000, "Hz")
POINT = Row((FRACTION, FRACTION))
ROUND: Fields = {"split": Quantity(0, 0.1), "imperfection": ANGLE}


@dataclass(frozen=True)
class Shape:
    """A function that makes modes, what its arguments may be, and where its pickups are.

    A key of one `either` set excludes those of the other: two ways to say one thing.
    """

    make: Callable[..., shapes.Modes]
    fields: Fields
    pickup: Domain | None = None
    either: tuple[frozenset[str], frozenset[str]] = (frozenset(), frozenset())

    @cached_property
    def parameters(self) -> Mapping[str, inspect.Parameter]:
        return inspect.signature(self.make).parameters

    @property
    def has_material(self) -> bool:
        return "material" in self.parameters

    @property
    def damping(self) -> Fields:
        """What of its material's damping an object may give anew."""
        return DAMPING if self.has_material else {}

    @property
    def pickups(self) -> Fields:
        return {"left": self.pickup, "right": self.pickup} if self.pickup else {}

    @property
    def required(self) -> tuple[str, ...]:
        return tuple(key for key in self.fields if self.parameters[key].default is inspect.Parameter.empty)


TUNING = (frozenset({"tension"}), frozenset({"fundamental"}))

SHAPES: Mapping[str, Shape] = {
    "bar": Shape(
        shapes.bar,
        {
            "length": LENGTH,
            "width": THICKNESS,
            "thickness": THICKNESS,
            "undercut": Quantity(0, 0.95),
            "undercut_span": Quantity(0.1, 1),
            "diameter": THICKNESS,
            "wall": THICKNESS,
            "ends": Choice(ENDS),
        },
        FRACTION,
        (frozenset({"width", "thickness", "undercut", "undercut_span"}), frozenset({"diameter", "wall"})),
    ),
    "string": Shape(
        shapes.string,
        {
            "length": LENGTH,
            "diameter": Quantity(1e-5, 0.02, "m"),
            "tension": Quantity(0.1, 1e5, "N"),
            "fundamental": FREQUENCY,
            "linear_density": Quantity(1e-6, 10, "kg/m"),
            "inharmonicity": Quantity(0, 0.1),
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
            "edges": Row((Choice(PLATE_EDGES),) * 4),
            "path_from": POINT,
            "path_to": POINT,
        },
        POINT,
    ),
    "disc": Shape(
        shapes.disc,
        {"radius": LENGTH, "thickness": THICKNESS, "edge": Choice(DISC_EDGES), **ROUND},
        Row((FRACTION, ANGLE)),
    ),
    "membrane": Shape(
        shapes.membrane,
        {
            "radius": LENGTH,
            "thickness": THICKNESS,
            "tension": Quantity(1, 1e6, "N/m"),
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
            "t60": OneOrMany(Quantity(1e-3, 200, "s")),
            "modal_mass": OneOrMany(Quantity(1e-6, 1e5, "kg")),
            "mass": Quantity(1e-5, 1e6, "kg"),
            "weight": OneOrMany(Quantity(-100, 100)),
        },
    ),
}

STRIKE: Fields = {"striker": Name(), "velocity": Quantity(1e-3, 100, "m/s"), "position": FRACTION}
OBJECT: Fields = {
    **DESCRIPTION,
    "shape": Choice(tuple(SHAPES)),
    "material": Name(),
    "level": Quantity(-120, 120, "dB"),
    **dict.fromkeys(("geometry", "damping", "strike", "pickup"), Section()),
}
