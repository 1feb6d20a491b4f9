"""The place of a contact on an object: a position on its strike path, or the nearest point of its surface."""

import numpy as np

from ...native.jit import kernel, noinline_kernel
from ...native.records import field
from ...native.typed import View
from ...numerics.triangle import nearest_on
from ...schema import STEERABLE
from ..memory.capacity import DIRECTED, FACE
from ..memory.records import Contact, ContactPoint
from ..memory.state import Object, State
from .objects import place

_FAR = 1e30  # m^2
PLACES = "position", "x", "y", "z", "by_position", "by_x", "by_y", "by_z"
_PLACES = np.array([STEERABLE.index(name) for name in PLACES])
THERE = 1e-6
"""The distance (of a path, or m) from its target within which a place is as good as there."""


@kernel
def put(state: State, obj: Object, contact: Contact, position: float) -> None:
    """Find rows and weights of the shapes where a contact touches an object: at its point, or else at a position; of
    one that does not move along, also in its direction."""
    point = contact.point[0]
    point.directed = 0
    if point.on_surface == 1 and obj.faces > 0:
        put_at(state, obj, point, contact.now.x, contact.now.y, contact.now.z)
        if contact.trait.along == 0:
            direct(state, obj, contact, 0)
    else:
        place(point, position, obj)


@kernel
def put_other(state: State, contact: Contact) -> None:
    """Find rows and weights of the shapes where a contact touches its other object, if it has one."""
    other, now = contact.point[1], contact.now
    if other.slot < 0:
        return
    obj = state.objects[other.slot]
    if other.on_surface == 1 and obj.faces > 0:
        put_at(state, obj, other, now.by_x, now.by_y, now.by_z)
    else:
        place(other, now.by_position, obj)


@noinline_kernel
def direct(state: State, obj: Object, contact: Contact, side: int) -> None:
    """Find the shapes in the direction of a contact that was put at a point of a surface, if it has one.

    side: 0 of the object that is touched, 1 of the one that touches it. Clicks are moved alike by a force in any
    direction.
    """
    point, way, row = contact.point[side], contact.direction[side], 2 * contact.index + side
    if (way[0] == 0.0 and way[1] == 0.0 and way[2] == 0.0) or obj.block == 0 or obj.size > DIRECTED:
        return
    shape, here = state.bank.shape, row * DIRECTED
    for i in range(obj.size):
        phi = 0.0
        at = obj.table + point.row * obj.size + i
        is_click = obj.bent <= i < obj.unheard
        for k in range(1 if is_click else 3):
            share = 1.0 if is_click else way[k]
            if not is_click:
                at += obj.block * obj.size
            for n in range(3):
                phi += share * point.weights[n] * shape[at + n * obj.size]
        state.directed[here + i] = phi
    point.directed = 1 + row
    point.weights[0], point.weights[1], point.weights[2], point.weights[3] = 1.0, 0.0, 0.0, 0.0


@kernel
def glides(contact: Contact) -> bool:
    """True if a contact is still on its way to where it was last sent."""
    found = False
    for i in range(len(_PLACES)):
        found |= abs(field(contact.now, _PLACES[i]) - field(contact.target, _PLACES[i])) > THERE
    return found


@kernel
def put_behind(state: State, contact: Contact, share: float, anew: bool) -> None:
    """Do what `put` and `put_other` do for a contact that is behind its place: by a share of what is left from there to
    its target. anew: at a surface, too, where that takes long."""
    for side in range(2):
        point, first = contact.point[side], 4 * side
        if point.slot < 0:
            continue
        obj = state.objects[point.slot]
        if point.on_surface == 0 or obj.faces == 0:
            place(point, _behind(contact, first, share), obj)
        elif anew:
            x, y = _behind(contact, first + 1, share), _behind(contact, first + 2, share)
            put_at(state, obj, point, x, y, _behind(contact, first + 3, share))
            if side == 0:
                point.directed = 0
                direct(state, obj, contact, 0)


@kernel
def _behind(contact: Contact, which: int, share: float) -> float:
    """Return one of _PLACES, as far behind as `put_behind` says."""
    now: float = field(contact.now, _PLACES[which])
    return now + share * (now - field(contact.target, _PLACES[which]))


@kernel
def has_moved(contact: Contact, spot: View[float]) -> bool:
    """True if a contact on a surface is no longer at a point (m)."""
    now = contact.now
    moved = now.x != spot[0] or now.y != spot[1] or now.z != spot[2]
    return contact.point[0].on_surface == 1 and moved


@kernel
def keep_spot(contact: Contact, spot: View[float]) -> None:
    """Keep the point (m) at which a contact is."""
    spot[0], spot[1], spot[2] = contact.now.x, contact.now.y, contact.now.z


@noinline_kernel
def put_at(state: State, obj: Object, point: ContactPoint, x: float, y: float, z: float) -> None:
    """Find rows and weights of the shapes at the point of an object's surface nearest to x, y, z (m).

    Between the corners of a triangle shapes are linear. A triangle whose sphere lies farther off is not looked at. No
    row that a table names lies beyond the shapes.
    """
    best = _FAR
    last = (obj.surface - obj.table) // max(obj.size, 1) - 3 - 3 * obj.block
    for number in range(obj.faces):
        at = obj.surface + number * FACE
        face = state.bank.shape[at : at + FACE]
        dx, dy, dz = x - face[10], y - face[11], z - face[12]
        away = dx * dx + dy * dy + dz * dz
        reach = face[13]
        # (sqrt(best) + reach)^2 is at most 2 (best + reach^2).
        if away > 2.0 * (best + reach * reach):
            continue
        p, q, distance = nearest_on(face[1:10], x, y, z)
        if distance < best:
            best = distance
            point.row = max(min(int(face[0]), last), 0)
            point.weights[0], point.weights[1], point.weights[2], point.weights[3] = 1.0 - p - q, p, q, 0.0
    for n in range(3):
        point.weights[n] *= obj.amplitude
