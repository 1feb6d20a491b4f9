"""The schema of presets: the keys of every kind of file, and what the value of each may be.

What computes the modes of a shape is loaded when the first object needs it.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from ..dsp import bodies, schema
from ..dsp.bodies.choices import BOARDS, EDGES, ENDS, MOST_WIRES
from ..dsp.bodies.heard import BAFFLES
from ..dsp.bodies.material import LOSSES
from ..dsp.errors import CaromError
from ..dsp.rolling.variation import MOST_VARIATION
from ..dsp.sizes import MOST_COUPLED
from ..dsp.wording import expected
from .supports import SUPPORTS
from .values import Choice, Domain, Made, Many, Name, OneOrMany, Quantity, Row, Rows, Section, Text, Unfit, Whole, shown

if TYPE_CHECKING:
    from ..dsp.bodies.added import Added
    from ..dsp.bodies.modes import Modes

Fields = Mapping[str, Domain]


class PresetError(CaromError, ValueError):
    """A preset that is unknown or does not fit: "FILE: [section] key = VALUE: expected WHAT"."""


class NoPreset(PresetError):
    """Error of a name that no preset has: its text, and which there are, looked up when it is requested."""

    def __init__(self, text: str, look_up: Callable[[], str]) -> None:
        super().__init__(text)
        self.text, self._look_up = text, look_up

    @property
    def expected(self) -> str:
        """The question whether a near name is meant, or all names."""
        return self._look_up()

    def __str__(self) -> str:
        return f"{self.text}: {self.expected}"

    def __reduce__(self) -> tuple[type[PresetError], tuple[str]]:
        """Go to other processes as its text."""
        return PresetError, (str(self),)


def check(where: str, table: Mapping[str, object], fields: Fields, required: Sequence[str]) -> dict[str, Any]:
    """Check the table's values, and return them as they are used. PresetError names a key that is wrong, unknown or
    missing."""
    checked = {}
    for key, value in table.items():
        if key not in fields:
            known = expected(key, fields) if fields else "expected no key"
            raise PresetError(f"{where}{key} = {shown(value)}: {known}")
        try:
            checked[key] = fields[key].fit(value)
        except Unfit as error:
            raise PresetError(f"{where}{key}{error}") from None
    for key in required:
        if key not in table:
            wanted = f"the name of a {key}" if isinstance(fields[key], Name) else fields[key]
            raise PresetError(f"{where}{key} is missing: expected {wanted}")
    return checked


# Contacts: strikers, and the surfaces and materials that they meet.

LAW_FIELDS: Mapping[str, Quantity] = {
    each.name: Quantity.of(each) for each in (*schema.LAW, schema.RESTITUTION, schema.RADIUS)
}
LAW = ("mass", "stiffness", "exponent")
BALL = ("material", "radius")
"""The keys of a striker that is a ball; its `mass` is given only if it is not that of a solid one."""
LOST = ("dissipation", "restitution")
"""The keys that give a striker's losses; a file has one of them."""
SOUNDS = ("click", "ringing", "snap")
"""Sections that say how a striker sounds itself."""
SLIDING = ("static", "dynamic", "stribeck", "tangential", "along", "patch", "radius", "sweep")
"""Keys of a striker's section [slide]: how it slides, where a slide does not say it."""

DESCRIPTION: Fields = {"description": Text(), "source": Text()}
LICENCE: Fields = {"licence": Text()}
"""Licence of the recordings that a preset was made of."""
STRIKER: Fields = {
    **DESCRIPTION,
    **LICENCE,
    **LAW_FIELDS,
    "area": Quantity(0, 10, "m2"),
    "material": Name(),
    **dict.fromkeys(SOUNDS, Section()),
    "slide": Section(),
}
SLIDE: Fields = {each.name: Quantity.of(each) for each in schema.SLIDE.keys if each.name in SLIDING}
"""A striker's friction, the width of its contact and the radius of its tip, and whether its contact moves."""
CLICK: Fields = {
    "shape": Choice(("sphere", "disc")),
    "radius": LAW_FIELDS["radius"],
    "thickness": Quantity(0, 10, "m"),
    "tilt": Quantity(0, 90, "degrees"),
}
"""The body that a blow moves as a whole: a sphere, or a disc whose axis is tilted against the force."""
RINGING: Fields = {
    "frequency": Many(Quantity(1, 96000, "Hz")),
    "t60": OneOrMany(Quantity(1e-4, 200, "s")),
    "modal_mass": OneOrMany(Quantity(1e-9, 1e6, "kg")),
    "radiated": OneOrMany(Quantity(0, 1)),
}
"""A striker's own modes: frequencies, decay times, modal masses where it touches, and the shares of the loss that are
sound."""
SNAP: Fields = {
    "momentum": Quantity(0, 1, "N s"),
    "exponent": Quantity(0, 10),
    "scatter": Quantity(0, 20, "dB"),
    "delay": Quantity(0, 1, "s"),
}
"""A second pulse, which alone moves these modes."""
SURFACE: Fields = {
    **DESCRIPTION,
    "roughness": Quantity(0, 0.1, "m"),
    "correlation": Quantity(1e-6, 100, "m"),
    "slope": Quantity(1.01, 5),
    "ripple": Quantity(0, 0.1, "m"),
    "wavelength": Quantity(1e-5, 100, "m"),
    "variation": Quantity(0, MOST_VARIATION, "dB"),
    "variation_length": Quantity(1e-5, 100, "m"),
    "dissipation": LAW_FIELDS["dissipation"],
}
SURFACE_REQUIRED = (*DESCRIPTION, "roughness", "correlation", "slope", "dissipation")
DAMPING: Fields = {
    "alpha": Quantity(0, 1e4, "1/s"),
    "beta": Quantity(0, 1e-3, "s"),
    "loss_factor": Quantity(0, 1),
    "loss_exponent": Quantity(0, 3),
    "losses": Choice(LOSSES),
}
"""`losses` says whether radiation is in them already ("measured") or not ("material")."""
MATERIAL: Fields = {
    "source": Text(),
    "density": Quantity(1, 3e4, "kg/m3"),
    "youngs_modulus": Quantity(1e4, 2e12, "Pa"),
    "poisson_ratio": Quantity(0, 0.4999),
    "shear": Quantity(1e3, 1e12, "Pa"),
    "across": Quantity(1e3, 1e12, "Pa"),
    "dissipation": LAW_FIELDS["dissipation"],
    **DAMPING,
}
MATERIAL_REQUIRED = ("source", "density", "youngs_modulus", "poisson_ratio", "alpha", "beta")

# Objects: shapes and their geometry.

LENGTH = Quantity(1e-3, 20, "m")
THICKNESS = Quantity(1e-5, 0.5, "m")
FRACTION = Quantity(0, 1)
ANGLE = Quantity(-360, 360, "degrees")
FREQUENCY = Quantity(1, 20000, "Hz")
POINT = Row((FRACTION, FRACTION))
PLACE = Row((Quantity(-20, 20, "m"),) * 3)
BAFFLE = Choice(BAFFLES)
ROUND: Fields = {"split": Quantity(0, 0.1), "imperfection": ANGLE}
DOUBLETS: Fields = {**ROUND, "split_seed": Whole(0, 1_000_000)}


@dataclass(frozen=True)
class Addition:
    """A class of modes that are added to a shape's, by its name in `dsp.bodies`, and what its arguments may be."""

    name: str
    fields: Fields

    @property
    def make(self) -> Callable[..., Added]:
        found: Callable[..., Added] = getattr(bodies, self.name)
        return found

    @cached_property
    def required(self) -> tuple[str, ...]:
        parameters = inspect.signature(self.make).parameters
        return tuple(key for key in self.fields if parameters[key].default is inspect.Parameter.empty)


@dataclass(frozen=True)
class Shape:
    """A function that makes modes, by its name in `dsp.bodies`, and what its arguments may be.

    A key of one `either` set excludes those of the other: two ways to give one thing.
    """

    name: str
    fields: Fields
    either: tuple[frozenset[str], frozenset[str]] = (frozenset(), frozenset())

    @property
    def make(self) -> Callable[..., Modes]:
        found: Callable[..., Modes] = getattr(bodies, self.name)
        return found

    @cached_property
    def parameters(self) -> Mapping[str, inspect.Parameter]:
        return inspect.signature(self.make).parameters

    @cached_property
    def lengths(self) -> tuple[str, ...]:
        """The keys that are lengths (m)."""
        return tuple(key for key, domain in self.fields.items() if isinstance(domain, Quantity) and domain.unit == "m")

    @property
    def has_material(self) -> bool:
        return "material" in self.parameters

    @property
    def damping(self) -> Fields:
        """The keys of its material's damping that an object may give anew."""
        return DAMPING if self.has_material else {}

    @cached_property
    def required(self) -> tuple[str, ...]:
        return tuple(key for key in self.fields if self.parameters[key].default is inspect.Parameter.empty)


SIZED: Fields = {"size": Quantity(1e-3, 1e3, "times")}
"""The key of an object that is like its preset, in another size."""

TUNING = (frozenset({"tension"}), frozenset({"fundamental"}))
_RECTANGULAR = frozenset(
    (
        "width", "thickness", "undercut", "undercut_span", "across", "tilt", "tube_diameter", "tube_gap",
        "tube_detuning", "tube_flow", "cords",
    )
)  # fmt: skip

SHAPES: Mapping[str, Shape] = {
    "bar": Shape(
        "bar",
        {
            "length": LENGTH,
            "width": THICKNESS,
            "thickness": THICKNESS,
            "undercut": Quantity(0, 0.95),
            "undercut_span": Quantity(0.1, 1),
            "across": Quantity(-1, 1),
            "tilt": Quantity(-90, 90, "degrees"),
            "diameter": THICKNESS,
            "wall": THICKNESS,
            **ROUND,
            "ends": Choice(ENDS),
            "board": Choice(BOARDS),
            "tube_diameter": Quantity(1e-3, 1, "m"),
            "tube_length": LENGTH,
            "tube_gap": Quantity(1e-3, 1, "m"),
            "tube_detuning": Quantity(-0.1, 0.1),
            "tube_flow": Quantity(0, 100, "m/s"),
            "fan": Quantity(0, 20, "1/s"),
            "fan_depth": FRACTION,
            "cords": Quantity(0, 100, "kg/s"),
        },
        (
            _RECTANGULAR,
            frozenset({"diameter", "wall", *ROUND}),
        ),
    ),
    "string": Shape(
        "string",
        {
            "length": LENGTH,
            "diameter": Quantity(1e-5, 0.02, "m"),
            "tension": Quantity(0.1, 1e5, "N"),
            "fundamental": FREQUENCY,
            "linear_density": Quantity(1e-6, 10, "kg/m"),
            "inharmonicity": Quantity(0, 0.1),
            "bending_loss": Quantity(0, 1),
            "board": Choice(BOARDS),
            "wires": Whole(1, MOST_WIRES),
            "mistuning": Quantity(0, 100, "cents"),
        },
        TUNING,
    ),
    "plate": Shape(
        "plate",
        {
            "length": LENGTH,
            "width": LENGTH,
            "thickness": THICKNESS,
            "edges": Row((Choice(EDGES),) * 4),
            "path_from": POINT,
            "path_to": POINT,
            "baffle": BAFFLE,
        },
    ),
    "disc": Shape(
        "disc",
        {
            "radius": LENGTH,
            "thickness": THICKNESS,
            "dome": Quantity(0, 1, "m"),
            "nonlinear_modes": Whole(0, MOST_COUPLED),
            "edge": Choice(EDGES),
            "felt": Quantity(0, 0.2, "m"),
            "stand": Quantity(0, 100, "kg/s"),
            **DOUBLETS,
            "baffle": BAFFLE,
        },
    ),
    "membrane": Shape(
        "membrane",
        {
            "radius": LENGTH,
            "thickness": THICKNESS,
            "tension": Quantity(1, 1e6, "N/m"),
            "fundamental": FREQUENCY,
            **DOUBLETS,
            "baffle": BAFFLE,
        },
        TUNING,
    ),
    "ring": Shape("ring", {"radius": LENGTH, "thickness": THICKNESS, "length": LENGTH, **DOUBLETS}),
    "glass": Shape(
        "glass",
        {"radius": LENGTH, "height": LENGTH, "thickness": THICKNESS, "rows": Whole(1, 3), **DOUBLETS},
    ),
    "can": Shape("can", {"radius": LENGTH, "height": LENGTH, "thickness": THICKNESS, **DOUBLETS}),
    "sphere": Shape("sphere", {"radius": LENGTH}),
    "mesh": Shape(
        "mesh",
        {
            "table": Made(lambda: bodies.Table, "a table in the preset's folder"),
            "path_from": PLACE,
            "path_to": PLACE,
            "tilt": Quantity(-90, 90, "degrees"),
        },
    ),
    "listed": Shape(
        "listed",
        {
            "frequency": Many(FREQUENCY),
            "t60": OneOrMany(Quantity(1e-3, 200, "s")),
            "modal_mass": OneOrMany(Quantity(1e-6, 1e5, "kg")),
            "mass": Quantity(1e-5, 1e6, "kg"),
            "weight": OneOrMany(Quantity(-1000, 1000, "Pa per m/s")),
            "positions": Many(FRACTION),
            "gains": Rows(Quantity(-1000, 1000)),
            "order": OneOrMany(Whole(0, 64)),
            "radius": LENGTH,
            "height": LENGTH,
        },
        (frozenset({"weight"}), frozenset({"order", "radius", "height"})),
    ),
}

# Additions to a shape's modes.

LEVEL = Quantity(-120, 60, "dB")
T60 = Quantity(1e-3, 200, "s")
MODAL_MASS = Quantity(1e-6, 1e9, "kg")
RATIO = Quantity(1e-3, 1e4)
ADDED: Mapping[str, Addition] = {
    "partials": Addition(
        "Partials",
        {
            "frequency": Many(FREQUENCY),
            "ratio": Many(RATIO),
            "t60": OneOrMany(T60),
            "level": OneOrMany(LEVEL),
            "modal_mass": OneOrMany(MODAL_MASS),
        },
    ),
    "noise": Addition(
        "Noise",
        {
            "edges": Many(FREQUENCY),
            "edge_ratio": Many(RATIO),
            "t60": OneOrMany(T60),
            "level": OneOrMany(LEVEL),
            "modes": OneOrMany(Whole(1, 512)),
            "modal_mass": OneOrMany(MODAL_MASS),
        },
    ),
    "cavity": Addition(
        "Cavity",
        {
            "volume": Quantity(1e-8, 10, "m3"),
            "area": Quantity(1e-8, 10, "m2"),
            "neck": THICKNESS,
            "level": LEVEL,
            "t60": T60,
            "length": LENGTH,
            "wall": Quantity(1e-3, 1e3, "kg/m2"),
        },
    ),
}
"""Sections of an object's preset, each with the class that it fills."""

SUITABLE = tuple(
    name for name, gesture in schema.GESTURES.items() if gesture.repeats or gesture.along or gesture.swarms
)
"""Gestures that suit some objects, each with a section that says how it goes; a strike and a press suit all."""

MESH: Fields = {
    "file": Text(),
    "box": Row((LENGTH,) * 3),
    "cylinder": Row((LENGTH,) * 2),
    "wall": THICKNESS,
    "scale": Quantity(1e-6, 1e3, "m"),
    "modes": Whole(1, 400),
    "points": Whole(50, 2000),
    "fine": Choice(("yes", "no")),
}
"""The mesh, or the solid box or cylinder, of a body of shape `mesh`, of which its table is made: in the place of a
table."""

NO_REST = "none"
"""The word in the place of a support, by which an object hangs freely."""
_MOST_FEET = 8
REST: Fields = {
    "support": Choice((*SUPPORTS, NO_REST)),
    "positions": Many(FRACTION, _MOST_FEET),
    "points": Many(PLACE, _MOST_FEET),
}
"""The section [rest]: on what an object stands by itself, and on which positions or points of its own."""

SECTIONS = ("geometry", "damping", "strike", "rest", *ADDED, *SUITABLE)
STRIKE: Fields = {"striker": Name(), "velocity": Quantity(1e-3, 100, "m/s"), "position": FRACTION}

OBJECT: Fields = {
    **DESCRIPTION,
    **LICENCE,
    "shape": Choice(tuple(SHAPES)),
    "material": Name(),
    "level": Quantity(-120, 120, "dB"),
    "glide": Quantity(0, 1e6, "1/J"),
    "stereo_width": FRACTION,
    "most_modes": Whole(1, 4096),
    "mesh": Section(),
    **dict.fromkeys(SECTIONS, Section()),
}
