"""The bodies of a scene: what `/world/body` makes in its score, as an export's tracker (touching.py) takes them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from ...dsp.bodies.material import CONTACT_RADIUS, Material, contact_between
from ...dsp.engine.memory.commands import COMMAND, write
from ...dsp.schema import SETTINGS, Parameter
from ...presets.kinds import ObjectPreset
from ...server.bridge.gestures import template
from ...server.bridge.simulation import Simulation
from ...server.bridge.touching import body_row
from ...server.osc.arguments import Verb, Word
from ...server.scene.session import Session

SIZE = Parameter("size", 0.05, 20.0, "", "size, in times that of the other", default=1.0)
LIKE = Verb(
    "/object/new",
    "makes an object, and its body, similar to another one",
    (Word("name", "name of the object"), Word("like", "object that it is similar to")),
    keys=(SIZE, Word("material", "material, one of the scene's"), *SETTINGS.values()),
)
"""The message by which an export makes objects while it plays."""


def materials_of(presets: Iterable[ObjectPreset], simulation: Simulation | None) -> list[Material]:
    """Return the materials of a scene, those of bodies first, by the numbers that the tracker has for them."""
    found = list(simulation.materials) if simulation else []
    for preset in presets:
        if preset.material is not None and preset.material not in found:
            found.append(preset.material)
    return found


def said_of_materials(materials: Sequence[Material]) -> dict[str, list[float]]:
    """Return what objects of other materials go by: Young's modulus, density, and the four numbers of losses."""
    return {
        each.name: [
            each.youngs_modulus, each.density, each.alpha, each.beta, each.loss_factor, each.loss_exponent,
        ]
        for each in materials
    }  # fmt: skip


def said_of_bodies(
    session: Session, simulation: Simulation, presets: Iterable[ObjectPreset], put: Callable[[bytes], int]
) -> dict[str, Any]:
    """Return the entries of bodies: their rows by name, laws and surfaces of each two materials, and slides.

    put: keeps bytes in the scene's data, and says where.
    """
    for each in materials_of(presets, simulation):  # a body may be made of any of them
        simulation.number_of_material(each)
    record = simulation.state[0]
    numbers = range(len(simulation.materials))
    laws = [
        [*contact_between(simulation.materials[a], simulation.materials[b], 1.0), float(record["surface"][a, b])]
        for a in numbers
        for b in numbers
    ]
    rows = {body.name: body_row(record, n).tolist() for n, body in enumerate(simulation.bodies)}
    return {"bodies": rows, "laws": laws, "slides": list(_slides(session, simulation, put))}


def _slides(session: Session, simulation: Simulation, put: Callable[[bytes], int]) -> Iterable[tuple[float, int]]:
    """Yield the least radius (m) on each surface, and where the command of a slide on it is."""
    ringing = next((body for body in simulation.bodies if body.rings and body.name in session.objects), None)
    for surface in simulation.surfaces if ringing else ():
        assert ringing
        made, least = np.zeros(1, COMMAND), session.least_radius(surface)
        slide = template(ringing, surface, max(least, CONTACT_RADIUS))
        write(made[0], 0, session.command_of(slide.message))
        yield least, put(made.tobytes())
