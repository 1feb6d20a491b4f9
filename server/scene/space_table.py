"""Space as messages have told of it: how the listener hears, and which objects have a place."""

from dataclasses import dataclass, field


@dataclass
class SpaceTable:
    """The layout in which directions are told, and the serials of objects with a place."""

    layout: str = "pan"
    placed: set[int] = field(default_factory=set)
