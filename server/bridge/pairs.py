"""Facts about pairs of bodies: their surface, their friction, their restitution, what softens their rests."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from ...dsp.bodies.material import Material
from ...dsp.wording import expected
from ...presets import Presets
from ...presets.supports import SUPPORTS
from ..osc.arguments import check_number, shown
from ..osc.wire import Argument
from ..osc.world_verbs import PAIRED
from .checks import WorldError

SURFACES = {
    "aluminium": "steel", "bell-bronze": "steel", "brass": "steel", "ceramic": "tile", "glass": "glass",
    "iron": "steel", "piano-wire": "steel", "plastic": "polished-wood", "polycarbonate": "glass", "rosewood":
    "polished-wood", "rubber": "wood", "spring-steel": "steel", "steel": "steel", "tin": "steel", "wood": "wood",
}  # fmt: skip
"""The surface of a body of a material, where its pair does not say another; of another material it is `wood`."""

_NUMBERS = {key.name: key for key in PAIRED}
SOFT = tuple(name for name, each in SUPPORTS.items() if not each.material)
"""Supports with a law of their own."""
KEYS = ("surface", "support", *_NUMBERS)
"""The keys of a pair."""


@dataclass(frozen=True)
class Pair:
    """Two bodies, as far as their contacts differ from those of their materials."""

    surface: str = ""
    restitution: float = math.nan
    slide: Mapping[str, float] = field(default_factory=dict)
    """Keys of a slide."""
    support: str = ""
    """Support whose law blows and rests have, in place of that of both materials."""


def law_of(support: str) -> tuple[float, float, float]:
    """Return stiffness, dissipation and exponent of a support."""
    law = SUPPORTS[support]
    return law.stiffness, law.dissipation, law.exponent


def pair_of(presets: Presets, a: str, b: str, keys: Mapping[str, Argument]) -> Pair:
    """Make a pair with keys. WorldError names the pair and the key that is wrong."""
    surface, support, numbers = "", "", {}
    try:
        for key, value in keys.items():
            if key == "surface":
                surface = presets.surface(str(value)).name
            elif key == "support":
                support = str(value)
                if support not in SOFT:
                    raise ValueError(f"support = {shown(value)}: {expected(support, SOFT)}")
            elif key in _NUMBERS:
                numbers[key] = check_number(_NUMBERS[key], value)
            else:
                raise ValueError(f"{key} = {shown(value)}: {expected(key, KEYS)}")
    except ValueError as error:
        raise WorldError(f"pair {a}, {b}: {error}") from None
    restitution = numbers.pop("restitution", math.nan)
    return Pair(surface, restitution, numbers, support)


class Surfaces:
    """The surface on which two bodies slide or roll."""

    def __init__(self, presets: Presets) -> None:
        self._presets = presets
        self._rougher: dict[tuple[str, str], str] = {}

    def between(self, a: Material, b: Material) -> str:
        """Return the rougher one of two materials."""
        key = a.name, b.name
        if key not in self._rougher:
            names = [SURFACES.get(name, "wood") for name in key]
            self._rougher[key] = max(names, key=lambda name: self._presets.surface(name).roughness)
        return self._rougher[key]
