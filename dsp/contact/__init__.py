"""One contact: its law, its closed forms, and the solvers of contacts that are coupled to modes."""

from .law import (
    compression,
    contact_time_bound,
    energy,
    force,
    max_compression,
    paper_release_velocity,
    potential_energy,
    release_velocity,
    restitution,
)
from .pulse import contact_time, force_nodes, force_pulse

__all__ = [
    "compression",
    "contact_time",
    "contact_time_bound",
    "energy",
    "force",
    "force_nodes",
    "force_pulse",
    "max_compression",
    "paper_release_velocity",
    "potential_energy",
    "release_velocity",
    "restitution",
]
