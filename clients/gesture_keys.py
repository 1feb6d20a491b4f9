"""The keys of gestures as types; tests/documents/typed_keys.py writes them from the table of addresses."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, SupportsFloat, TypedDict

if TYPE_CHECKING:
    from typing_extensions import Unpack


class ImpactKeys(TypedDict, total=False):
    """Keys of impact."""

    striker: str
    mass: SupportsFloat
    stiffness: SupportsFloat
    dissipation: SupportsFloat
    exponent: SupportsFloat
    restitution: SupportsFloat
    by: str
    by_position: SupportsFloat
    by_radius: SupportsFloat
    gain: SupportsFloat
    id: str


class ImpactOfNamed(Protocol):
    """The gesture impact on an object of a name, at a position 0 to 1 on its strike path."""

    def __call__(
        self,
        name: str,
        velocity: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[ImpactKeys],
    ) -> None:
        """Begin the gesture; the preset's own values stand for those that are None."""


class ImpactOfObject(Protocol):
    """The gesture impact on an object, the same way."""

    def __call__(
        self,
        velocity: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[ImpactKeys],
    ) -> None:
        """Begin the gesture; the preset's own values stand for those that are None."""


class BounceKeys(TypedDict, total=False):
    """Keys of bounce."""

    striker: str
    mass: SupportsFloat
    stiffness: SupportsFloat
    dissipation: SupportsFloat
    exponent: SupportsFloat
    restitution: SupportsFloat
    by: str
    by_position: SupportsFloat
    by_radius: SupportsFloat
    gain: SupportsFloat
    id: str
    velocity: SupportsFloat
    gravity: SupportsFloat
    irregularity: SupportsFloat
    seed: SupportsFloat
    weight: SupportsFloat


class BounceOfNamed(Protocol):
    """The gesture bounce on an object of a name, at a position 0 to 1 on its strike path."""

    def __call__(
        self,
        name: str,
        height: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[BounceKeys],
    ) -> None:
        """Begin the gesture; the preset's own values stand for those that are None."""


class BounceOfObject(Protocol):
    """The gesture bounce on an object, the same way."""

    def __call__(
        self,
        height: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[BounceKeys],
    ) -> None:
        """Begin the gesture; the preset's own values stand for those that are None."""


class RollKeys(TypedDict, total=False):
    """Keys of roll."""

    striker: str
    mass: SupportsFloat
    stiffness: SupportsFloat
    dissipation: SupportsFloat
    exponent: SupportsFloat
    restitution: SupportsFloat
    by: str
    by_position: SupportsFloat
    by_radius: SupportsFloat
    gain: SupportsFloat
    id: str
    radius: SupportsFloat
    roughness: SupportsFloat
    asymmetry: SupportsFloat
    friction: SupportsFloat
    gravity: SupportsFloat
    seed: SupportsFloat
    corners: SupportsFloat
    travel: SupportsFloat
    surface: str


class RollOfNamed(Protocol):
    """The gesture roll on an object of a name, at a position 0 to 1 on its strike path."""

    def __call__(
        self,
        name: str,
        speed: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[RollKeys],
    ) -> None:
        """Begin the gesture; the preset's own values stand for those that are None."""


class RollOfObject(Protocol):
    """The gesture roll on an object, the same way."""

    def __call__(
        self,
        speed: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[RollKeys],
    ) -> None:
        """Begin the gesture; the preset's own values stand for those that are None."""


class PressKeys(TypedDict, total=False):
    """Keys of press."""

    striker: str
    mass: SupportsFloat
    stiffness: SupportsFloat
    dissipation: SupportsFloat
    exponent: SupportsFloat
    restitution: SupportsFloat
    by: str
    by_position: SupportsFloat
    by_radius: SupportsFloat
    gain: SupportsFloat
    id: str


class PressOfNamed(Protocol):
    """The gesture press on an object of a name, at a position 0 to 1 on its strike path."""

    def __call__(
        self,
        name: str,
        force: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[PressKeys],
    ) -> None:
        """Begin the gesture; the preset's own values stand for those that are None."""


class PressOfObject(Protocol):
    """The gesture press on an object, the same way."""

    def __call__(
        self,
        force: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[PressKeys],
    ) -> None:
        """Begin the gesture; the preset's own values stand for those that are None."""


class SpinKeys(TypedDict, total=False):
    """Keys of spin."""

    striker: str
    mass: SupportsFloat
    stiffness: SupportsFloat
    dissipation: SupportsFloat
    exponent: SupportsFloat
    restitution: SupportsFloat
    by: str
    by_position: SupportsFloat
    by_radius: SupportsFloat
    gain: SupportsFloat
    id: str
    angle: SupportsFloat
    radius: SupportsFloat
    quickening: SupportsFloat
    flat: SupportsFloat
    irregularity: SupportsFloat
    gravity: SupportsFloat
    seed: SupportsFloat


class SpinOfNamed(Protocol):
    """The gesture spin on an object of a name, at a position 0 to 1 on its strike path."""

    def __call__(
        self,
        name: str,
        duration: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[SpinKeys],
    ) -> None:
        """Begin the gesture; the preset's own values stand for those that are None."""


class SpinOfObject(Protocol):
    """The gesture spin on an object, the same way."""

    def __call__(
        self,
        duration: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[SpinKeys],
    ) -> None:
        """Begin the gesture; the preset's own values stand for those that are None."""


class SlideKeys(TypedDict, total=False):
    """Keys of slide."""

    striker: str
    mass: SupportsFloat
    stiffness: SupportsFloat
    dissipation: SupportsFloat
    exponent: SupportsFloat
    restitution: SupportsFloat
    by: str
    by_position: SupportsFloat
    by_radius: SupportsFloat
    gain: SupportsFloat
    id: str
    force: SupportsFloat
    sweep: SupportsFloat
    radius: SupportsFloat
    patch: SupportsFloat
    roughness: SupportsFloat
    static: SupportsFloat
    dynamic: SupportsFloat
    stribeck: SupportsFloat
    tangential: SupportsFloat
    along: SupportsFloat
    seed: SupportsFloat
    travel: SupportsFloat
    surface: str
    press: str


class SlideOfNamed(Protocol):
    """The gesture slide on an object of a name, at a position 0 to 1 on its strike path."""

    def __call__(
        self,
        name: str,
        speed: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[SlideKeys],
    ) -> None:
        """Begin the gesture; the preset's own values stand for those that are None."""


class SlideOfObject(Protocol):
    """The gesture slide on an object, the same way."""

    def __call__(
        self,
        speed: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[SlideKeys],
    ) -> None:
        """Begin the gesture; the preset's own values stand for those that are None."""
