"""Space as messages have told of it: how the listener hears, and where objects are."""

from dataclasses import dataclass, field


@dataclass
class SpaceTable:
    """The layout in which directions are told, and the places (m) of objects that have one, by serial."""

    layout: str = "pan"
    places: dict[int, tuple[float, float, float]] = field(default_factory=dict)
