"""Contact laws of strikers, and the limits of a gesture: how long a contact lasts, whether a bounce ever rests."""

import math

from ...dsp.bodies.material import Material
from ...dsp.contact.law import ELASTIC_TIME
from ...dsp.rolling.surface import CREST
from ...presets import Presets, SurfacePreset
from ..osc.arguments import Refused

LONGEST_CONTACT = 1.0
"""s: a striker so soft or heavy that it would stay longer is refused."""

LONGEST_BOUNCE = 3_600.0
"""s: a bounce that would go on for longer on a rigid floor is refused."""

_SMOOTH = 10.0  # times the surface's height that a body's radius has at least: its circle is taken for a parabola

Contact = tuple[float, float, float, float]
"""Mass (kg), stiffness (N/m^a), dissipation (s/m), exponent."""

LAW = ("mass", "stiffness", "dissipation", "exponent")


class ContactLaws:
    """The contact laws of strikers on materials. A striker's file is read when it is first asked for."""

    def __init__(self, presets: Presets) -> None:
        self._presets = presets
        self._laws: dict[tuple[str, Material | None], Contact] = {}

    def of(self, striker: str, material: Material | None) -> Contact:
        """The law of a striker on an object of a material. PresetError if there is no such striker."""
        if (striker, material) not in self._laws:
            self._laws[striker, material] = self._presets.striker(striker).contact(material)
        return self._laws[striker, material]

    def forget(self) -> None:
        """Read the files again from now on."""
        self._laws.clear()


def require_short(velocity: float, contact: Contact) -> None:
    """Refuse a contact of more than LONGEST_CONTACT, by an upper estimate of its duration.

    It is that of `contact_time_bound`, with an upper estimate of the depth, so that nothing is compiled for it.
    """
    mass, stiffness, dissipation, a = contact
    w = dissipation * velocity
    length = (mass * velocity**2 / stiffness) ** (1 / (a + 1))
    deepest = ((a + 1) * min(0.5, 1 / w if w else math.inf)) ** (1 / (a + 1))
    duration = length / velocity * (ELASTIC_TIME + w * deepest)
    if duration > LONGEST_CONTACT:
        culprits = ", ".join(f"{name} = {value:g}" for name, value in zip(LAW, contact, strict=True))
        raise Refused(f"{culprits}: the contact would last {duration:.3g} s; expected under {LONGEST_CONTACT:g} s")


def fall(height: float, velocity: float, gravity: float) -> tuple[float, float]:
    """Velocity (m/s) and time (s) at the end of a fall from a height (m), thrown downwards at a velocity (m/s)."""
    v_in = math.sqrt(velocity**2 + 2 * gravity * height)
    # (v_in - velocity)/gravity, without cancelling where the throw is fast
    return v_in, 2 * height / (v_in + velocity) if velocity > 0 else (v_in - velocity) / gravity


def require_rest(velocity: float, contact: Contact, gravity: float) -> None:
    """Refuse a bounce that does not rest within LONGEST_BOUNCE on a rigid floor.

    From contact to contact v falls by (2/3) mu v^2 and 2 v/g goes by: 3/(mu g) ln(v_in/v_rest) in all.
    """
    mass, stiffness, dissipation, a = contact
    if dissipation == 0.0:
        raise Refused("dissipation = 0: the bounce would never end; expected above 0")
    v_e = math.sqrt(gravity * (mass * gravity / stiffness) ** (1 / a))
    v_rest = 2.5 * math.sqrt(dissipation * v_e) * v_e
    duration = 3 / (dissipation * gravity) * math.log1p(velocity / v_rest) if v_rest else math.inf
    if duration > LONGEST_BOUNCE:
        raise Refused(
            f"dissipation = {dissipation:g}: the bounce might last {duration:.3g} s; "
            f"expected under {LONGEST_BOUNCE:g} s"
        )


def require_rollable(radius: float, surface: SurfacePreset, roughness: float) -> None:
    """Refuse a body that is too small for a surface: it would go up and down, not over it."""
    heights = roughness * (CREST * surface.roughness + surface.ripple)
    if heights > radius / _SMOOTH:
        raise Refused(
            f"radius = {radius:g}: expected at least {_SMOOTH * heights:.3g} m on a surface of {heights:.3g} m"
        )
