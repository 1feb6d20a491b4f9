"""How the macros change the modes of an object, by its preset: the changes of each at NODES places."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from ..dsp.bodies.macros import LAWS, Change, apart, between, morphed, of_material, places, share_of, sized
from ..dsp.bodies.material import Material
from ..dsp.bodies.modes import Modes
from ..dsp.kept import Kept
from ..dsp.macros import MORPH, NEUTRAL, SHAPING
from .kinds import STAND_IN, ObjectPreset
from .schema import PresetError

LINE = ("plastic", "wood", "rosewood", "ceramic", "glass", "bell-bronze", "aluminium", "steel")
"""Materials from one end of the macro `material` to the other. An object's own one stands for that most like it."""

Axes = tuple[tuple[Change, ...], ...]
"""The changes by setting of SHAPING and place."""

_ANEW = ("bar", "string")
"""Shapes that are made anew of each material: shear bends bars, and tension tunes strings. Others go by ratios."""

Key = tuple[int, str, str, bool, float]

_kept: Kept[Key, tuple[Modes, ObjectPreset, Axes]] = Kept(
    16_000_000, lambda kept: sum(change.modes.nbytes for changes in kept[2] for change in changes)
)


class Wanted(NamedTuple):
    """An object whose changes are wanted: its preset, its modes, up to which frequency (Hz) they reach, whether it
    changes its material, and the preset that it morphs to."""

    preset: ObjectPreset
    modes: Modes
    top: float
    of_material: bool
    other: ObjectPreset | None = None

    @property
    def key(self) -> Key:
        """What is the same for equal ones, as long as the modes are there."""
        return id(self.modes), self.preset.name, self.other.name if self.other else "", self.of_material, self.top


def known_axes(wanted: Wanted) -> Axes | None:
    """Return what `axes_of` made of the same before, if that is kept."""
    kept = _kept.get(wanted.key)
    return kept[2] if kept else None


def axes_of(wanted: Wanted) -> Axes:
    """Return the changes of an object's modes by setting and place. It can take a second; any thread may ask.
    PresetError says why there is no other object."""
    preset, modes, top, is_of_material, other = wanted
    by_law = {name: tuple(law(modes, preset.material, value) for value in places()) for name, law in LAWS.items()}
    whole = none = sized(modes, None, NEUTRAL)
    if other is not None:
        whole = morphed(modes, preset.position, other.modes(top), other.position)
    by_law["material"] = tuple(_of_material(preset, modes, top, none)) if is_of_material else (none,) * len(places())
    by_law[MORPH.name] = tuple(share_of(whole, value) for value in places())
    axes = tuple(by_law[each.name] for each in SHAPING)
    _kept.put(wanted.key, (modes, preset, axes))
    return axes


def _of_material(preset: ObjectPreset, modes: Modes, top: float, none: Change) -> list[Change]:
    """Return the changes to the materials at all places: `none` in the middle, where the object's own is."""
    own, found = material_at(preset, NEUTRAL), []
    for value in places():
        other = material_at(preset, value)
        if other is own:
            found.append(none)
            continue
        anew = _anew(preset, top, other)
        found.append(of_material(modes, own, other, anew, preset.shape == "membrane"))
    return found


def material_at(preset: ObjectPreset, value: float) -> Material:
    """Return the material of an object at a value of its macro: its own in the middle, and elsewhere that of the line
    with the damping that its file gives anew."""
    line = [replace(preset._library.material(name), **preset.damping) for name in LINE]
    own = preset.material or preset._library.material(STAND_IN)
    nearest = min(range(len(line)), key=lambda n: apart(own, line[n]))
    line[nearest] = own
    end = len(line) - 1 if value > NEUTRAL else 0
    place = nearest + abs(value - NEUTRAL) / NEUTRAL * (end - nearest)
    first = min(int(place), len(line) - 2)
    return between(line[first], line[first + 1], place - first)


def _anew(preset: ObjectPreset, top: float, material: Material) -> Modes | None:
    """Return an object's modes of another material; None where that goes by ratios, or it has none then."""
    if preset.shape not in _ANEW:
        return None
    try:
        return replace(preset, material=material, _replaced=preset._replaced | {"material"}).modes(top)
    except PresetError:
        return None


def require_family(name: str, preset: ObjectPreset, other: ObjectPreset) -> None:
    """Raise PresetError if an object cannot morph to another one, as it is of another family: of another shape, or a
    list of modes that says other things of its body."""
    if preset.shape != other.shape:
        raise PresetError(
            f"preset = {other.name}: it is of the shape {other.shape}; expected one of the shape {preset.shape}, as "
            f"{name} is"
        )
    if preset.shape == "listed" and preset.geometry.keys() != other.geometry.keys():
        raise PresetError(
            f"preset = {other.name}: its modes are another kind of list; expected {', '.join(preset.geometry)}"
        )
