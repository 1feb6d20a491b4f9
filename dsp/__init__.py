"""Carom's signal processing, for use without a server: contacts, rolls, bodies, experiments.

Names load when they are first used; `import carom.dsp` alone loads nothing. Each is documented where it stands:

- `carom.dsp.contact`: one contact of a mass with a rigid wall, in closed form.
- `carom.dsp.bodies`: modes of bars, plates, discs, rings, glasses, strings and membranes from their materials.
- `carom.dsp.rolling`: rough surfaces, and the path of a body over them.
- `carom.dsp.lab`: rolls and coupled contacts as data, and comparisons of methods.
"""

from typing import TYPE_CHECKING

from .lazy import lazily

if TYPE_CHECKING:
    from .bodies import Material, Modes, bar, disc, glass, hertz, listed, membrane, plate, ring, string
    from .contact import (
        compression,
        contact_time,
        contact_time_bound,
        energy,
        force,
        force_nodes,
        force_pulse,
        max_compression,
        potential_energy,
        release_velocity,
        restitution,
    )
    from .lab import Case, make_roll, micro_impacts, roll_contacts, roll_force, roll_moments, simulate
    from .lab.rolling_path import path_pieces
    from .rolling.surface import heights, make_surface

__all__ = [
    "Case", "Material", "Modes", "bar", "compression", "contact_time", "contact_time_bound", "disc", "energy", "force",
    "force_nodes", "force_pulse", "glass", "heights", "hertz", "listed", "make_roll", "make_surface", "max_compression",
    "membrane", "micro_impacts", "path_pieces", "plate", "potential_energy", "release_velocity", "restitution", "ring",
    "roll_contacts", "roll_force", "roll_moments", "simulate", "string",
]  # fmt: skip

_MODULES = {
    ".bodies": "Material Modes bar disc glass hertz listed membrane plate ring string",
    ".contact": "compression contact_time contact_time_bound energy force force_nodes force_pulse max_compression "
    "potential_energy release_velocity restitution",
    ".rolling.surface": "heights make_surface",
    ".lab": "Case make_roll micro_impacts roll_contacts roll_force roll_moments simulate",
    ".lab.rolling_path": "path_pieces",
}
__getattr__, __dir__ = lazily(__name__, _MODULES)
