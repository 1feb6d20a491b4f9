"""The place of a contact on an object: a position on its strike path, or the nearest point of its surface."""

from ...native.jit import kernel, noinline_kernel
from ...native.typed import View
from ..memory.capacity import FACE
from ..memory.records import Contact, ContactPoint
from ..memory.state import Object, State
from .objects import place

_TINY = 1e-30  # m^2, m^4: a flat triangle has no inside
_FAR = 1e30  # m^2


@kernel
def put(state: State, obj: Object, contact: Contact, position: float) -> None:
    """Find rows and weights of the shapes where a contact touches an object: at its point, or else at a position."""
    point = contact.point[0]
    if point.on_surface == 1 and obj.faces > 0:
        put_at(state, obj, point, contact.now.x, contact.now.y, contact.now.z)
    else:
        place(point, position, obj.rows)


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

    Between the corners of a triangle shapes are linear. A triangle whose sphere lies farther off is not looked at.
    """
    best = _FAR
    for number in range(obj.faces):
        at = obj.surface + number * FACE
        face = state.bank.shape[at : at + FACE]
        dx, dy, dz = x - face[10], y - face[11], z - face[12]
        away = dx * dx + dy * dy + dz * dz
        reach = face[13]
        # (sqrt(best) + reach)^2 is at most 2 (best + reach^2).
        if away > 2.0 * (best + reach * reach):
            continue
        p, q, distance = _nearest(face, x, y, z)
        if distance < best:
            best = distance
            point.row = int(face[0])
            point.weights[0], point.weights[1], point.weights[2], point.weights[3] = 1.0 - p - q, p, q, 0.0


@kernel
def _nearest(face: View[float], x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return the shares of the second and the third corner at the point of a triangle nearest to x, y, z (m), and the
    square of its distance (m^2)."""
    ax, ay, az = float(face[1]), float(face[2]), float(face[3])
    ux, uy, uz = face[4] - ax, face[5] - ay, face[6] - az
    vx, vy, vz = face[7] - ax, face[8] - ay, face[9] - az
    wx, wy, wz = x - ax, y - ay, z - az
    uu, uv, vv = ux * ux + uy * uy + uz * uz, ux * vx + uy * vy + uz * vz, vx * vx + vy * vy + vz * vz
    wu, wv, ww = wx * ux + wy * uy + wz * uz, wx * vx + wy * vy + wz * vz, wx * wx + wy * wy + wz * wz
    area = max(uu * vv - uv * uv, _TINY * _TINY)
    p, q = (vv * wu - uv * wv) / area, (uu * wv - uv * wu) / area
    if p < 0.0 or q < 0.0 or p + q > 1.0:
        one = min(max(wu / max(uu, _TINY), 0.0), 1.0)
        other = min(max(wv / max(vv, _TINY), 0.0), 1.0)
        third = min(max((wv - wu + uu - uv) / max(uu - 2.0 * uv + vv, _TINY), 0.0), 1.0)
        p, q = one, 0.0
        nearest = ww - one * (2.0 * wu - one * uu)
        if ww - other * (2.0 * wv - other * vv) < nearest:
            p, q = 0.0, other
            nearest = ww - other * (2.0 * wv - other * vv)
        if _squared(ww, wu, wv, uu, uv, vv, 1.0 - third, third) < nearest:
            p, q = 1.0 - third, third
    return p, q, max(_squared(ww, wu, wv, uu, uv, vv, p, q), 0.0)


@kernel
def _squared(ww: float, wu: float, wv: float, uu: float, uv: float, vv: float, p: float, q: float) -> float:
    """Return |w - p u - q v|^2 by the products of w, u and v."""
    return ww - 2.0 * (p * wu + q * wv) + p * p * uu + 2.0 * p * q * uv + q * q * vv
