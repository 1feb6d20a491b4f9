"""The point of a triangle that is nearest to another."""

from ..native.jit import kernel
from ..native.typed import View

_TINY = 1e-30  # m^2, m^4: a flat triangle has no inside


@kernel
def nearest_on(corners: View[float], x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return the shares of the second and the third corner at the point of a triangle nearest to x, y, z (m), and the
    square of its distance (m^2). corners: nine numbers."""
    ax, ay, az = float(corners[0]), float(corners[1]), float(corners[2])
    ux, uy, uz = corners[3] - ax, corners[4] - ay, corners[5] - az
    vx, vy, vz = corners[6] - ax, corners[7] - ay, corners[8] - az
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
