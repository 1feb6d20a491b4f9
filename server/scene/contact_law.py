"""The contact law of a gesture: its striker's, or that of two materials, with the values that are given."""

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING

from ...dsp.bodies.curved import curvatures_at, stiffness_share
from ...dsp.bodies.material import Material
from ...presets.kinds import SurfacePreset
from ..osc.arguments import Refused
from .limits import LAW, Contact
from .macros import harder, touched
from .object_call import ObjectCall
from .objects import PlayedObject

if TYPE_CHECKING:
    from ...dsp.bodies.mesh import Table


def law_of(
    to: ObjectCall,
    by: PlayedObject | None,
    changes: Mapping[str, float] | None = None,
    said: Collection[str] = LAW,
    onto: PlayedObject | None = None,
) -> Contact:
    """Return the contact law of a gesture on its object, or `onto` another: its striker's, with `changes`; given keys
    win.

    Where an object strikes, its mass does. Unless a striker is named, the rest comes from the materials of both. The
    canonical message has the values of the keys `said`: a mass in it would steer a roll that goes on. A
    restitution that is given takes the striker's dissipation's place, and the other way round. At a point of a surface
    the stiffness follows how the surface curves there.
    """
    struck_object, given = onto or to.obj, to.values.numbers
    preset, struck = struck_object.preset, struck_material(to, struck_object)
    law = to.transaction.laws.of(to.striker, struck or touched(struck_object))._asdict()
    if by:
        law["mass"] = by.mass
    if by and to.by_materials:
        law.update(zip(LAW[1:], preset.struck_by(by.preset, to.contact_radius, struck), strict=True), restitution=0.0)
        to.warn_of_stand_ins(by, to.values.words["by"])
    law["stiffness"] *= bent(to)
    law.update(changes or {})
    if "dissipation" in given and "restitution" in given:
        raise Refused(
            f"dissipation = {given['dissipation']:g}, restitution = {given['restitution']:g}: expected one of the two"
        )
    if "dissipation" in given:
        law["restitution"] = 0.0
    law.update((key, given[key]) for key in law if key in given)
    if by:
        for key in said:
            lost = "restitution" if key == "dissipation" and law["restitution"] else key
            to.say(lost, law[lost])
    if by or "what" in to.values.words:
        return Contact(**law)
    base = Contact(**law)
    if onto is None:
        to.base = base
    return harder(base, to.obj)


def struck_material(to: ObjectCall, struck: PlayedObject) -> Material | None:
    """Return the material of an object's part that a gesture touches first, where that is not the object's own."""
    table: Table | None = struck.preset.geometry.get("table")  # that of a mesh
    faces = struck.modes.faces
    if table is None or table.of is None or faces is None:
        return None
    point, place = to.values.vectors.get("point"), to.values.numbers.get("position", struck.preset.position)
    return table.material_at(faces.line[round(place * (faces.path - 1))] if point is None else point)


def bent(to: ObjectCall) -> float:
    """Return the share of its stiffness on a plane that a contact has at its point: of a ball, or of a body that
    strikes; that of another striker is as its preset says."""
    point, faces = to.values.vectors.get("point"), to.obj.modes.faces
    if point is None or faces is None:  # as most often: then nobody looks into the striker's file
        return 1.0
    by_materials = to.by_materials or "what" in to.values.words
    radius = to.contact_radius if by_materials else to.transaction.laws.ball_of(to.striker)
    return 1.0 if radius is None else stiffness_share(radius, curvatures_at(faces, point))


def law_on(to: ObjectCall, by: PlayedObject | None, surface: SurfacePreset, goes_on: bool, does: str) -> Contact:
    """Return the contact law of a body that rolls or slides on a surface."""
    restitution = to.values.numbers.get("restitution")
    if restitution is not None:
        raise Refused(f"restitution = {restitution:g}: a body that {does} has none; expected dissipation")
    lossy = {"dissipation": surface.dissipation, "restitution": 0.0}
    return law_of(to, by, lossy, LAW[1:] if goes_on else LAW)
