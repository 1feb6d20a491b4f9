"""One contact: its law, its closed forms, and the solvers of contacts that are coupled to modes."""

from typing import TYPE_CHECKING

from ..lazy import lazily

if TYPE_CHECKING:
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

_MODULES = {
    ".law": "compression contact_time_bound energy force max_compression paper_release_velocity potential_energy "
    "release_velocity restitution",
    ".pulse": "contact_time force_nodes force_pulse",
}
__getattr__, __dir__ = lazily(__name__, _MODULES)
