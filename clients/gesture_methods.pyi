"""The methods of gestures and objects, with their keys; `make documents` writes this."""

from collections.abc import Callable, Sequence
from typing import Any, SupportsFloat, TypedDict, TypeVar

from numpy.typing import ArrayLike
from typing_extensions import Unpack

Value = Any

_Class = TypeVar("_Class", bound=type)

def with_gestures(cls: _Class) -> _Class: ...
def with_shared_help(cls: _Class) -> _Class: ...
def with_methods_of(scene: type) -> Callable[[_Class], _Class]: ...

class Keys(TypedDict, total=False):
    """Keys of all gestures."""

    mass: SupportsFloat
    stiffness: SupportsFloat
    dissipation: SupportsFloat
    exponent: SupportsFloat
    point: Sequence[SupportsFloat]
    by_position: SupportsFloat
    by_point: Sequence[SupportsFloat]
    by_radius: SupportsFloat
    id: str

class ImpactKeys(Keys, total=False):
    """Keys of impact."""

    striker: str
    restitution: SupportsFloat
    by: str
    gain: SupportsFloat
    play: SupportsFloat
    impulse: SupportsFloat
    direction: Sequence[SupportsFloat]
    by_direction: Sequence[SupportsFloat]

class BounceKeys(Keys, total=False):
    """Keys of bounce."""

    striker: str
    restitution: SupportsFloat
    by: str
    gain: SupportsFloat
    play: SupportsFloat
    velocity: SupportsFloat
    gravity: SupportsFloat
    irregularity: SupportsFloat
    seed: SupportsFloat
    weight: SupportsFloat

class RollKeys(Keys, total=False):
    """Keys of roll."""

    striker: str
    restitution: SupportsFloat
    by: str
    gain: SupportsFloat
    play: SupportsFloat
    radius: SupportsFloat
    roughness: SupportsFloat
    asymmetry: SupportsFloat
    friction: SupportsFloat
    gravity: SupportsFloat
    seed: SupportsFloat
    corners: SupportsFloat
    travel: SupportsFloat
    surface: str

class PressKeys(Keys, total=False):
    """Keys of press."""

    striker: str
    restitution: SupportsFloat
    by: str
    gain: SupportsFloat
    play: SupportsFloat

class SpinKeys(Keys, total=False):
    """Keys of spin."""

    striker: str
    restitution: SupportsFloat
    by: str
    gain: SupportsFloat
    play: SupportsFloat
    angle: SupportsFloat
    radius: SupportsFloat
    quickening: SupportsFloat
    flat: SupportsFloat
    irregularity: SupportsFloat
    gravity: SupportsFloat
    seed: SupportsFloat

class SlideKeys(Keys, total=False):
    """Keys of slide."""

    striker: str
    restitution: SupportsFloat
    by: str
    gain: SupportsFloat
    play: SupportsFloat
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
    direction: Sequence[SupportsFloat]

class RestKeys(Keys, total=False):
    """Keys of rest."""

    resistance: SupportsFloat
    load: SupportsFloat

class RainKeys(Keys, total=False):
    """Keys of rain."""

    striker: str
    restitution: SupportsFloat
    by: str
    gain: SupportsFloat
    play: SupportsFloat
    size: SupportsFloat
    reach: SupportsFloat
    spread: SupportsFloat
    seed: SupportsFloat

class ShakeKeys(Keys, total=False):
    """Keys of shake."""

    striker: str
    restitution: SupportsFloat
    by: str
    gain: SupportsFloat
    play: SupportsFloat
    speed: SupportsFloat
    evenness: SupportsFloat
    excitation: SupportsFloat
    memory: SupportsFloat
    variety: SupportsFloat
    spread: SupportsFloat
    seed: SupportsFloat

class CrumpleKeys(Keys, total=False):
    """Keys of crumple."""

    striker: str
    restitution: SupportsFloat
    by: str
    gain: SupportsFloat
    play: SupportsFloat
    density: SupportsFloat
    energy: SupportsFloat
    steepness: SupportsFloat
    decades: SupportsFloat
    excitation: SupportsFloat
    memory: SupportsFloat
    variety: SupportsFloat
    spread: SupportsFloat
    seed: SupportsFloat

class PourKeys(Keys, total=False):
    """Keys of pour."""

    striker: str
    restitution: SupportsFloat
    by: str
    gain: SupportsFloat
    play: SupportsFloat
    height: SupportsFloat
    variety: SupportsFloat
    spread: SupportsFloat
    seed: SupportsFloat

class StepKeys(Keys, total=False):
    """Keys of step."""

    striker: str
    restitution: SupportsFloat
    by: str
    gain: SupportsFloat
    play: SupportsFloat
    crackles: SupportsFloat
    duration: SupportsFloat
    energy: SupportsFloat
    steepness: SupportsFloat
    decades: SupportsFloat
    variety: SupportsFloat
    spread: SupportsFloat
    seed: SupportsFloat

class ShatterKeys(Keys, total=False):
    """Keys of shatter."""

    striker: str
    restitution: SupportsFloat
    by: str
    gain: SupportsFloat
    play: SupportsFloat
    pieces: SupportsFloat
    height: SupportsFloat
    steepness: SupportsFloat
    wall_mass: SupportsFloat
    thick_mass: SupportsFloat
    thick_ratio: SupportsFloat
    thick_parts: SupportsFloat
    spread: SupportsFloat
    seed: SupportsFloat
    onto: str

class RampKeys(TypedDict, total=False):
    """Keys of `/object/NAME/gain`."""

    over: SupportsFloat
    curve: SupportsFloat

class PlaceKeys(TypedDict, total=False):
    """Keys of `/object/NAME/place`."""

    over: SupportsFloat

class NoteKeys(TypedDict, total=False):
    """Keys of `/object/NAME/note`."""

    striker: str
    play: SupportsFloat

class SensorKeys(TypedDict, total=False):
    """Keys of `/sensor/new`."""

    preset: str
    quantity: str
    resonance: SupportsFloat
    damping: SupportsFloat
    full: SupportsFloat
    point: Sequence[SupportsFloat]
    direction: Sequence[SupportsFloat]

class ListenerKeys(TypedDict, total=False):
    """Keys of `/listener`."""

    yaw: SupportsFloat
    pitch: SupportsFloat
    roll: SupportsFloat
    over: SupportsFloat
    layout: str
    head: SupportsFloat
    temperature: SupportsFloat
    humidity: SupportsFloat
    air: SupportsFloat

class FloorKeys(TypedDict, total=False):
    """Keys of `/floor`."""

    absorption: SupportsFloat

class RoomKeys(TypedDict, total=False):
    """Keys of `/room`."""

    x: SupportsFloat
    y: SupportsFloat
    z: SupportsFloat
    absorption: SupportsFloat
    t60: SupportsFloat
    t60_high: SupportsFloat
    late: SupportsFloat

class PairKeys(TypedDict, total=False):
    """Keys of `/world/pair`."""

    surface: str
    support: str
    patch: SupportsFloat
    roughness: SupportsFloat
    static: SupportsFloat
    dynamic: SupportsFloat
    stribeck: SupportsFloat
    tangential: SupportsFloat
    along: SupportsFloat
    restitution: SupportsFloat

class ObjectKeys(TypedDict, total=False):
    """Keys of objects and bodies, and of presets of all shapes."""

    striker: str
    velocity: SupportsFloat
    position: SupportsFloat
    rest: str
    length: SupportsFloat
    width: SupportsFloat
    thickness: SupportsFloat
    undercut: SupportsFloat
    undercut_span: SupportsFloat
    across: SupportsFloat
    tilt: SupportsFloat
    diameter: SupportsFloat
    wall: SupportsFloat
    split: SupportsFloat
    imperfection: SupportsFloat
    ends: str
    board: str
    tube_diameter: SupportsFloat
    tube_length: SupportsFloat
    tube_gap: SupportsFloat
    tube_detuning: SupportsFloat
    tube_flow: SupportsFloat
    fan: SupportsFloat
    fan_depth: SupportsFloat
    cords: SupportsFloat
    alpha: SupportsFloat
    beta: SupportsFloat
    loss_factor: SupportsFloat
    loss_exponent: SupportsFloat
    losses: str
    tension: SupportsFloat
    fundamental: SupportsFloat
    linear_density: SupportsFloat
    inharmonicity: SupportsFloat
    bending_loss: SupportsFloat
    wires: SupportsFloat
    mistuning: SupportsFloat
    edges: str | ArrayLike
    path_from: str | ArrayLike
    path_to: str | ArrayLike
    baffle: str
    radius: SupportsFloat
    dome: SupportsFloat
    nonlinear_modes: SupportsFloat
    edge: str
    felt: SupportsFloat
    stand: SupportsFloat
    split_seed: SupportsFloat
    height: SupportsFloat
    rows: SupportsFloat
    frequency: str | ArrayLike
    t60: str | ArrayLike
    modal_mass: str | ArrayLike
    mass: SupportsFloat
    weight: str | ArrayLike
    positions: str | ArrayLike
    gains: ArrayLike
    order: str | ArrayLike
    level: SupportsFloat
    stereo_width: SupportsFloat
    most_modes: SupportsFloat
    glide: SupportsFloat
    gain: SupportsFloat
    pan: SupportsFloat
    distance: SupportsFloat
    tune: SupportsFloat
    decay: SupportsFloat
    damp: SupportsFloat
    note: str | SupportsFloat
    pitch: SupportsFloat

class NewKeys(ObjectKeys, total=False):
    """Keys of objects."""

    size: SupportsFloat
    material: str

class BodyKeys(ObjectKeys, total=False):
    """Keys of bodies."""

    density: SupportsFloat
    held: SupportsFloat
    rings: SupportsFloat
    object: str
    inertia: ArrayLike
    surface: bool

class SteerKeys(TypedDict, total=False):
    """What a gesture may be steered by."""

    position: SupportsFloat
    gain: SupportsFloat
    x: SupportsFloat
    y: SupportsFloat
    z: SupportsFloat
    gravity: SupportsFloat
    irregularity: SupportsFloat
    speed: SupportsFloat
    mass: SupportsFloat
    stiffness: SupportsFloat
    dissipation: SupportsFloat
    exponent: SupportsFloat
    radius: SupportsFloat
    roughness: SupportsFloat
    asymmetry: SupportsFloat
    friction: SupportsFloat
    force: SupportsFloat
    flat: SupportsFloat
    sweep: SupportsFloat
    patch: SupportsFloat
    static: SupportsFloat
    dynamic: SupportsFloat
    stribeck: SupportsFloat
    tangential: SupportsFloat
    along: SupportsFloat
    load: SupportsFloat
    by_x: SupportsFloat
    by_y: SupportsFloat
    by_z: SupportsFloat
    by_position: SupportsFloat
    rate: SupportsFloat
    size: SupportsFloat
    evenness: SupportsFloat
    excitation: SupportsFloat
    memory: SupportsFloat
    variety: SupportsFloat
    density: SupportsFloat
    energy: SupportsFloat
    steepness: SupportsFloat
    decades: SupportsFloat
    height: SupportsFloat
    crackles: SupportsFloat
    point: Sequence[SupportsFloat]
    by_point: Sequence[SupportsFloat]

class MacroKeys(TypedDict, total=False):
    """The macros of an object."""

    size: SupportsFloat | Sequence[SupportsFloat]
    material: SupportsFloat | Sequence[SupportsFloat]
    brightness: SupportsFloat | Sequence[SupportsFloat]
    damping: SupportsFloat | Sequence[SupportsFloat]
    hardness: SupportsFloat | Sequence[SupportsFloat]
    force: SupportsFloat | Sequence[SupportsFloat]
    place: SupportsFloat | Sequence[SupportsFloat]
    roughness: SupportsFloat | Sequence[SupportsFloat]

class Gestures:
    """Gestures on objects by name: methods of what has `_gesture(gesture, name, value, position, at, keys)`."""

    def impact(
        self,
        name: str,
        velocity: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[ImpactKeys],
    ) -> None:
        """Begin a gesture that strikes the object once; the key `by` lets another object strike, and both ring."""

    def bounce(
        self,
        name: str,
        height: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[BounceKeys],
    ) -> None:
        """Begin a gesture that drops or throws the striker onto the object; it bounces until it lies still."""

    def roll(
        self,
        name: str,
        speed: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[RollKeys],
    ) -> None:
        """Begin a gesture that rolls the striker over the object until the speed is 0. A message whose `id`
        (default: NAME) is a running roll steers that."""

    def press(
        self,
        name: str,
        force: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[PressKeys],
    ) -> None:
        """Begin a gesture that presses the striker, such as a hand, against the object until `/stop`."""

    def spin(
        self,
        name: str,
        duration: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[SpinKeys],
    ) -> None:
        """Begin a gesture that lets a coin, a lid or a ring spin down on the object, rattling ever faster and
        fainter."""

    def slide(
        self,
        name: str,
        speed: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[SlideKeys],
    ) -> None:
        """Begin a gesture that drags the striker over the object until the speed is 0. A message whose `id`
        (default: NAME) is a running slide steers that."""

    def rest(
        self,
        name: str,
        what: str,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[RestKeys],
    ) -> None:
        """Begin a gesture that lays the object on another object or a support until `/stop`; objects in contact
        ring for less time."""

    def rain(
        self,
        name: str,
        rate: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[RainKeys],
    ) -> None:
        """Begin a gesture that lets drops fall on the object until `/stop`."""

    def shake(
        self,
        name: str,
        rate: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[ShakeKeys],
    ) -> None:
        """Begin a gesture that lets many copies of the striker, such as dice, hit the object at random times until
        `/stop`."""

    def crumple(
        self,
        name: str,
        speed: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[CrumpleKeys],
    ) -> None:
        """Begin a gesture that crushes the object, which crackles by blows of the striker, until `/stop`."""

    def pour(
        self,
        name: str,
        rate: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[PourKeys],
    ) -> None:
        """Begin a gesture that pours many copies of the striker, such as rice, onto the object until `/stop`."""

    def step(
        self,
        name: str,
        force: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[StepKeys],
    ) -> None:
        """Begin a gesture that treads on the object once, from heel to toe; it crackles by blows of the striker."""

    def shatter(
        self,
        name: str,
        velocity: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[ShatterKeys],
    ) -> None:
        """Begin a gesture that breaks the object into pieces that bounce until they lie still; `striker` is the
        preset of a piece."""

class ObjectMethods:
    """Methods on an object: those of its scene on objects, without the name."""

    def impact(
        self,
        velocity: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[ImpactKeys],
    ) -> None:
        """Begin a gesture that strikes the object once; the key `by` lets another object strike, and both ring."""

    def bounce(
        self,
        height: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[BounceKeys],
    ) -> None:
        """Begin a gesture that drops or throws the striker onto the object; it bounces until it lies still."""

    def roll(
        self,
        speed: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[RollKeys],
    ) -> None:
        """Begin a gesture that rolls the striker over the object until the speed is 0. A message whose `id`
        (default: NAME) is a running roll steers that."""

    def press(
        self,
        force: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[PressKeys],
    ) -> None:
        """Begin a gesture that presses the striker, such as a hand, against the object until `/stop`."""

    def spin(
        self,
        duration: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[SpinKeys],
    ) -> None:
        """Begin a gesture that lets a coin, a lid or a ring spin down on the object, rattling ever faster and
        fainter."""

    def slide(
        self,
        speed: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[SlideKeys],
    ) -> None:
        """Begin a gesture that drags the striker over the object until the speed is 0. A message whose `id`
        (default: NAME) is a running slide steers that."""

    def rest(
        self,
        what: str,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[RestKeys],
    ) -> None:
        """Begin a gesture that lays the object on another object or a support until `/stop`; objects in contact
        ring for less time."""

    def rain(
        self,
        rate: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[RainKeys],
    ) -> None:
        """Begin a gesture that lets drops fall on the object until `/stop`."""

    def shake(
        self,
        rate: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[ShakeKeys],
    ) -> None:
        """Begin a gesture that lets many copies of the striker, such as dice, hit the object at random times until
        `/stop`."""

    def crumple(
        self,
        speed: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[CrumpleKeys],
    ) -> None:
        """Begin a gesture that crushes the object, which crackles by blows of the striker, until `/stop`."""

    def pour(
        self,
        rate: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[PourKeys],
    ) -> None:
        """Begin a gesture that pours many copies of the striker, such as rice, onto the object until `/stop`."""

    def step(
        self,
        force: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[StepKeys],
    ) -> None:
        """Begin a gesture that treads on the object once, from heel to toe; it crackles by blows of the striker."""

    def shatter(
        self,
        velocity: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[ShatterKeys],
    ) -> None:
        """Begin a gesture that breaks the object into pieces that bounce until they lie still; `striker` is the
        preset of a piece."""

    def note(
        self,
        note: Value,
        velocity: SupportsFloat,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[NoteKeys],
    ) -> None:
        """Strike a copy of an object that is tuned to a note. It is named NAME.NOTE."""

    def damp(self, amount: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]) -> None:
        """Damp an object, as a hand on it does."""

    def gain(self, level: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]) -> None:
        """Set an object's level."""

    def pan(self, place: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]) -> None:
        """Place an object between left and right."""

    def gains(self, *gains: Value, at: SupportsFloat | None = None) -> None:
        """Set a factor for each channel, in place of the pan. Without factors, restore the pan."""

    def distance(self, metres: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]) -> None:
        """Set the distance from an object to the listener."""

    def tune(self, semitones: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]) -> None:
        """Shift all frequencies of an object."""

    def decay(self, ratio: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]) -> None:
        """Multiply all decay times of an object."""

    def free(self, at_once: bool = False, at: SupportsFloat | None = None) -> None:
        """Remove an object and the copies for its notes, once they are silent. Its name is free immediately."""

    def macro(
        self, at: SupportsFloat | None = None, over: Value = None, curve: Value = None, **values: Unpack[MacroKeys]
    ) -> None:
        """Turn macros of an object, all of them together: `macro("bell", size=0.7, brightness=0.2)`."""

    def dice(self, seed: int | None = None, at: SupportsFloat | None = None) -> None:
        """Set all macros of an object at random, in ranges that sound good."""

    def undo(self, at: SupportsFloat | None = None) -> None:
        """Take back the last throw of the dice of an object."""

    def morph(self, preset: str, share: Value, at: SupportsFloat | None = None, **keys: Unpack[RampKeys]) -> None:
        """Move an object part of the way to another preset of the same shape."""

    def place(self, *place: Value, at: SupportsFloat | None = None, **keys: Unpack[PlaceKeys]) -> None:
        """Place an object in space, or move it. Without a place, restore its pan."""
