"""Space as messages have set it: how the listener hears, and where objects are."""

from dataclasses import dataclass, field


@dataclass
class SpaceTable:
    """The layout of directions, and the places (m) of objects that have one, by serial."""

    layout: str = "pan"
    places: dict[int, tuple[float, float, float]] = field(default_factory=dict)
