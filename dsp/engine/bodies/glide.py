"""The glide of an object's pitch: its tension follows its modes and its strikers, in steps of about 1.4 ms.

The laws are those of resonator/mode.py, of the energy that rings, and of bodies/tension.py, of a striker that stretches
a membrane about itself. Modes keep their energy where they are retuned, so that none is gained however often that is. A
striker that touches feels the point's motion go on without a step (contact/coupled.py).

A striker that is pressed on bends the modes for good, and that tightens the object too: by Kirchhoff's equation of a
bend at rest s (1 + s)^2 = 2 glide E, with E the energy that the bend would have at the object's own tension. What
swings about it counts by its own energy alone. Were the energy of both together followed, the swing would change the
tension in its own time, a quantum late, and the hand would feed it for ever.
"""

import math

from ...native.jit import kernel, noinline_kernel
from ...resonator.mode import energy_of
from ..memory.records import Contact
from ..memory.state import COUPLING, QUANTUM, Object, State
from .bends import find_bend, in_work, pressing_force, retune_bent, ring_tensed
from .objects import modes_of

_AUDIBLE = 2.0 ** (2.0 / 1200.0) - 1.0  # rise of the tension by which the pitch rises by a cent
_STEP = 0.5 * _AUDIBLE  # the least change of it that is carried out, where modes are over soon
_PHASE = 0.05  # rad: by which a smaller change puts the first mode out, of an object that rings longer
_HIGHEST = (
    15.0  # times its own tension that an object's tension rises at most: two octaves; no head or string bears more
)
_NEWTON_STEPS = 6
_QUANTUM_AT = 48_000.0  # Hz: at rates so high, a step is a quantum; at others as many as last as long
_SPREAD = 0.003  # s: the tension about a striker that has left spreads over the head, as its waves do


@kernel
def step_of(state: State) -> int:
    """Return the frames of a step of the tension: whole quanta, so that it lasts as long at any higher rate."""
    return QUANTUM * max(1, int(state.rate / _QUANTUM_AT + 0.5))


@kernel
def follow_tension(state: State, obj: Object) -> None:
    """Bring an object's tension to its ringing and its strikers; nothing where it does not glide, or inaudibly."""
    if obj.glide == 0.0 or (obj.live == 0 and obj.stretch == 0.0 and obj.contact < 0):
        return
    # The speed (m/s) of the fastest of the strikers that touch an object.
    fastest = 0.0
    index = obj.contact
    while index >= 0:
        contact = state.contacts[index]
        touches = contact.touching == 1 and (contact.solver != COUPLING or contact.coupled.touching == 1)
        if touches and contact.trait.lasts == 0:
            fastest = max(fastest, contact.v_in)
        index = contact.next
    stretch = max(obj.glide * energy_without_gains(state, obj), _cone_at(obj, fastest))
    # S >= 0 with s (1 + s)^2 = bend, by Newton's method from above: the function is convex.
    bend = 2.0 * obj.glide * obj.deflection
    rise: float = min(bend, bend ** (1.0 / 3.0))
    for _ in range(_NEWTON_STEPS):
        rise -= (rise * (1.0 + rise) * (1.0 + rise) - bend) / ((1.0 + rise) * (1.0 + 3.0 * rise))
    stretch = min(stretch + rise, _HIGHEST)
    if stretch < obj.stretch:
        stretch += (obj.stretch - stretch) * math.exp(-step_of(state) / (_SPREAD * state.rate))
    if not stretch >= _AUDIBLE:
        stretch = 0.0
    # A change s of the tension moves a mode's phase by s omega/(2 sigma) while it rings: smaller ones wait.
    omega, sigma = 2.0 * math.pi * state.bank.frequency[obj.first], state.bank.sigma[obj.first]
    least = min(_STEP, 2.0 * _PHASE * sigma / omega) if omega > 0.0 else _STEP
    if abs(stretch - obj.stretch) < least * (1.0 + stretch):
        return
    pressed, index = False, obj.contact  # by a blow or a press, which bends its modes
    while stretch > 0.0 and index >= 0:
        pressed |= pressing_force(state.contacts[index]) > 0.0
        index = state.contacts[index].next
    if pressed:
        retune_bent(state, obj, stretch, 1.0)
        return
    obj.stretch, obj.lent = stretch, 0.0
    if stretch == 0.0:
        obj.detuned = 0
        obj.stale_modes = obj.size
    else:
        obj.detuned = 1
        ring_tensed(state, obj, 1.0)


@kernel
def energy_without_gains(state: State, obj: Object) -> float:
    """Return the energy (J) that rings on an object, as it were if all gestures had a gain of 1: gains are heard, not
    felt. That of modes that are bent for good is in `deflection`, and not in it; of a plate that stretches it is in
    both, as stretching takes from the bend, too.

    The energy that came in a step counts with the gain of the loudest gesture in it.
    """
    weights = state.bank.weight[obj.first : obj.first + obj.live]
    modes = modes_of(state, obj, 0, obj.live)
    if find_bend(state, obj, modes) and obj.sheet < 0:
        bent = in_work(state, modes)
        for i in range(len(modes.y1)):
            bent.y1[i] = modes.y1[i] - bent.y1[i]
            bent.y2[i] = modes.y2[i] - bent.y2[i]
        modes = bent
    energy = energy_of(modes, weights, obj.felt)
    more = energy - obj.rang
    if more > 0.0 and obj.driven_gain > 0.0:
        obj.amplified = energy / (obj.rang / obj.amplified + more / (obj.driven_gain * obj.driven_gain))
    obj.rang = energy
    return energy / obj.amplified


@noinline_kernel
def tighten(state: State, contact: Contact) -> None:
    """Bring the tension of an object to that about a striker that begins to touch it, before they feel each other."""
    obj = state.objects[contact.point[0].slot]
    if obj.glide == 0.0 or contact.trait.lasts == 1 or obj.ahead > 0:
        return
    stretch = min(_cone_at(obj, contact.v_in), _HIGHEST)
    if not stretch >= _AUDIBLE or stretch - obj.stretch < _STEP * (1.0 + obj.stretch):
        return
    contact.coupled.touching = 0  # it has no force yet
    retune_bent(state, obj, stretch, contact.fraction)


@kernel
def _cone_at(obj: Object, speed: float) -> float:
    """Return the rise of an object's tension about a striker that touches it at a speed (m/s)."""
    return 0.5 * (math.sqrt(1.0 + 4.0 * obj.glide * obj.cone * speed * speed) - 1.0)
