"""Contact laws of strikers, and the limits of a gesture: how long a contact lasts, whether a bounce ever rests."""

import math
from typing import NamedTuple

from ...dsp.bodies.material import Material
from ...dsp.bodies.striker import StrikerSound
from ...dsp.contact.estimate import LONGEST_CONTACT, longest_estimate
from ...dsp.contact.law import speed_of_impulse
from ...dsp.rolling.lattice import CREST
from ...dsp.schema import VELOCITY
from ...presets import Presets, SurfacePreset
from ..osc.arguments import Refused

LONGEST_BOUNCE = 3_600.0
"""s: a bounce that would go on for longer on a rigid floor is refused."""

_WATER = 1000.0  # kg/m^3
_SMOOTH = 10.0  # times the surface's height that a body's radius has at least: its circle is taken for a parabola


class Contact(NamedTuple):
    """A contact law; a restitution above 0 takes the place of the dissipation."""

    mass: float
    """kg"""
    stiffness: float
    """N/m^a"""
    dissipation: float
    """s/m"""
    exponent: float
    restitution: float = 0.0

    def loss(self, velocity: float) -> float:
        """Return an upper bound of mu v_in at a velocity (m/s)."""
        return 1.5 * (1 - self.restitution) / self.restitution if self.restitution else self.dissipation * velocity

    def __str__(self) -> str:
        without = "dissipation" if self.restitution else "restitution"
        return ", ".join(f"{name} = {value:g}" for name, value in self._asdict().items() if name != without)


LAW = ("mass", "stiffness", "dissipation", "exponent")


class ContactLaws:
    """The contact laws of strikers on materials. A striker's file is read when it is first requested."""

    def __init__(self, presets: Presets) -> None:
        self._presets = presets
        self._laws: dict[tuple[str, Material | None], Contact] = {}
        self._sounds: dict[tuple[str, bool], StrikerSound | None] = {}
        self._radii: dict[str, float | None] = {}
        self._areas: dict[str, float] = {}
        self._sliding: dict[str, dict[str, float]] = {}
        self._surfaces: dict[str, SurfacePreset] = {}

    def of(self, striker: str, material: Material | None) -> Contact:
        """Return the law of a striker on an object of a material. PresetError if there is no such striker."""
        if (striker, material) not in self._laws:
            preset = self._presets.striker(striker)
            self._laws[striker, material] = Contact(*preset.contact(material), preset.restitution or 0.0)
        return self._laws[striker, material]

    def sound_of(self, striker: str, held: bool = False) -> StrikerSound | None:
        """Return a striker's own sound; one that is held, as it slides, does not ring. PresetError if there is none."""
        if (striker, held) not in self._sounds:
            sound = self._presets.striker(striker).sound
            self._sounds[striker, held] = sound._replace(ringing=None, snap=None) if sound and held else sound
        return self._sounds[striker, held]

    def radius_of(self, striker: str) -> float | None:
        """Return a striker's radius (m), if it has one. PresetError if there is no such striker."""
        if striker not in self._radii:
            self._radii[striker] = self._presets.striker(striker).radius
        return self._radii[striker]

    def area_of(self, striker: str) -> float:
        """Return the area (m^2) that a striker covers where it is pressed on; 0: it touches at a point."""
        if striker not in self._areas:
            self._areas[striker] = self._presets.striker(striker).area
        return self._areas[striker]

    def ball_of(self, striker: str) -> float | None:
        """Return the radius (m) of a striker whose stiffness follows from it; else None."""
        radius, preset = self.radius_of(striker), self._presets.striker(striker)
        return radius if preset.stiffness is None else None

    def modulus_of(self, striker: str) -> float:
        """Return the modulus (Pa) of a striker whose stiffness follows from the material that it meets; else 0."""
        preset = self._presets.striker(striker)
        return preset.material.dented_modulus if preset.material is not None and preset.radius is not None else 0.0

    def sliding_of(self, striker: str) -> dict[str, float]:
        """Return a striker's parameters of sliding; raise PresetError if there is no such striker."""
        if striker not in self._sliding:
            self._sliding[striker] = self._presets.striker(striker).sliding
        return self._sliding[striker]

    def surface(self, name: str) -> SurfacePreset:
        """Return the surface of a name. PresetError if there is none."""
        if name not in self._surfaces:
            self._surfaces[name] = self._presets.surface(name)
        return self._surfaces[name]

    def forget(self) -> None:
        """Read the files again from now on."""
        self._laws.clear()
        self._radii.clear()
        self._areas.clear()
        self._sliding.clear()
        self._surfaces.clear()
        self._sounds.clear()


def longest(velocity: float, contact: Contact) -> float:
    """Return an upper estimate (s) of a contact's duration."""
    w = contact.loss(velocity)
    return float(longest_estimate.py_func(velocity, contact.mass, contact.stiffness, contact.exponent, w))


def require_short(velocity: float, contact: Contact) -> None:
    """Refuse a contact that may last for more than LONGEST_CONTACT."""
    duration = longest(velocity, contact)
    if duration > LONGEST_CONTACT:
        raise Refused(f"{contact}: the contact would last {duration:.3g} s; expected under {LONGEST_CONTACT:g} s")


def speed_by(impulse: float, contact: Contact) -> float:
    """Return the speed (m/s) of a striker whose blow on a rigid wall has an impulse (N s); Refused if it is too fast
    for a blow: it takes half of J/m, and with a great dissipation all of it."""
    mass, _, dissipation, _, restitution = contact
    most = VELOCITY.high * mass
    if impulse > most:
        raise Refused(f"impulse = {impulse:g}: expected at most {most:g} N s of a striker of {mass:g} kg")
    return float(speed_of_impulse.py_func(impulse, mass, dissipation, restitution))


def fall(height: float, velocity: float, gravity: float) -> tuple[float, float]:
    """Return the velocity (m/s) and time (s) at the end of a fall from a height (m), thrown downwards at a velocity
    (m/s)."""
    v_in = math.sqrt(velocity**2 + 2 * gravity * height)
    # (v_in - velocity)/gravity, without cancelling where the throw is fast
    return v_in, 2 * height / (v_in + velocity) if velocity > 0 else (v_in - velocity) / gravity


def rim_speed(flat: float, radius: float, angle: float, gravity: float) -> float:
    """Return the velocity (m/s) at which a spinning disc's flat first hits; angle in degrees. See
    `dsp/engine/contacts/spins.py`."""
    return 2 * flat * math.sqrt(gravity * radius * math.sin(math.radians(angle)))


def require_rest(velocity: float, contact: Contact, gravity: float) -> None:
    """Refuse a bounce that does not rest within LONGEST_BOUNCE on a rigid floor.

    From contact to contact v falls by (2/3) mu v^2 and 2 v/g goes by: 3/(mu g) ln(v_in/v_rest) in all. With a
    restitution e it is 2 e v/(g (1 - e)).
    """
    mass, stiffness, dissipation, a, e = contact
    if e > 0.0:
        if e == 1.0:
            raise Refused("restitution = 1: the bounce would never end; expected below 1")
        _require_end(f"restitution = {e:g}", 2 * e * velocity / (gravity * (1 - e)))
        return
    if dissipation == 0.0:
        raise Refused("dissipation = 0: the bounce would never end; expected above 0")
    v_e = math.sqrt(gravity * (mass * gravity / stiffness) ** (1 / a))
    v_rest = 2.5 * math.sqrt(dissipation * v_e) * v_e
    duration = 3 / (dissipation * gravity) * math.log1p(velocity / v_rest) if v_rest else math.inf
    _require_end(f"dissipation = {dissipation:g}", duration)


def _require_end(culprit: str, duration: float) -> None:
    if duration > LONGEST_BOUNCE:
        raise Refused(f"{culprit}: the bounce might last {duration:.3g} s; expected under {LONGEST_BOUNCE:g} s")


def require_rollable(radius: float, surface: SurfacePreset, roughness: float) -> None:
    """Refuse a body that is too small for a surface: it would go up and down, not over it."""
    least = least_radius(surface, roughness)
    if radius < least:
        heights = f"heights of up to {least / _SMOOTH:.3g} m"
        raise Refused(f"radius = {radius:g}: expected at least {least:.3g} m, as {surface.name} has {heights}")


def most_rough(radius: float, surface: SurfacePreset) -> float:
    """Return how many times the height of a surface a body of a radius (m) can roll on."""
    once = least_radius(surface, 1.0)
    return radius / once if once else math.inf


def radius_of(mass: float) -> float:
    """Return the radius (m) of a ball of a mass (kg) that is as dense as water: of what is no ball, and yet rolls."""
    return float((0.75 * mass / (math.pi * _WATER)) ** (1.0 / 3.0))


def least_radius(surface: SurfacePreset, roughness: float) -> float:
    """Return the least radius (m) of a body that rolls on a surface of which so many times the height is felt."""
    return _SMOOTH * roughness * (CREST * surface.roughness + surface.ripple)
