"""One contact: its law, its closed forms, and the solvers of contacts that are coupled to modes."""

from .closed_form import contact_time, force_nodes, force_pulse
from .law import (
    compression,
    energy,
    force,
    max_compression,
    paper_release_velocity,
    potential_energy,
    release_velocity,
    restitution,
)

__all__ = [
    "compression", "contact_time", "energy", "force", "force_nodes", "force_pulse", "max_compression",
    "paper_release_velocity", "potential_energy", "release_velocity", "restitution",
]  # fmt: skip
