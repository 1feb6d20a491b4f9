"""The arithmetic of one part of a sample, as block.py describes it, for a contact by itself and for each of several in
lanes (block_lanes.py): numbers in, numbers out, and no branch, so that loops over lanes become vectors."""

from ..native.jit import kernel

AS_HARD = 2.0
"""Times the greatest V so far, up to which a body that lands does so no harder: it hops on a rough path."""


@kernel
def free_at(
    at: float, side: float, body: tuple[float, float, float], path: tuple[float, float],
    point: tuple[float, float, float],
) -> tuple[float, float]:  # fmt: skip
    """Return compression and rate at a node without a force, at a time in [0, 1] of the sample.

    side: -1 at a part's first node, 1 at its second. Of the body: position, way by its speed and by twice what pushes
    it; of the path: height and slope; of the object's point: place, and of its rate over the part the mean and tilt.
    """
    position, moved, pushed = body
    height, slope = path
    place, mean, tilt = point
    x = position + at * (moved + 0.5 * at * pushed) + height - place
    return x, moved + at * pushed + slope - (mean + side * tilt)


@kernel
def less(free: float, first: float, second: float, forces: tuple[float, float]) -> float:
    """Return a motion less what two forces give of it."""
    return free - first * forces[0] - second * forces[1]


@kernel
def correct(
    forces: tuple[float, float],
    first: tuple[float, float, float],
    second: tuple[float, float, float],
    give: tuple[float, float, float, float],
    rates: tuple[float, float, float, float],
) -> tuple[float, float, float]:
    """Return by how much a step of Newton's method changes the two forces of a part, and how much is left to find.

    first, second: the law's force at both nodes, its derivatives over compression and over the rate per sample. give,
    rates: what each force takes off both compressions, then off both rates.
    """
    f, s, d = first
    g, t, e = second
    m00, m10 = 1.0 + s * give[0] + d * rates[0], t * give[1] + e * rates[1]
    m01, m11 = s * give[2] + d * rates[2], 1.0 + t * give[3] + e * rates[3]
    r0, r1 = f - forces[0], g - forces[1]
    whole = 1.0 / (m00 * m11 - m01 * m10)
    c0, c1 = (r0 * m11 - r1 * m01) * whole, (r1 * m00 - r0 * m10) * whole
    # What the law changes by, as it is linear, where both nodes touch: what is left is about its square.
    near, far = abs(r0 - c0) + abs(r1 - c1), abs(c0) + abs(c1)
    return c0, c1, near if min(f, g) > 0.0 else far


@kernel
def is_gentle(most: float, energy: float, landing: float, scale: float) -> bool:
    """True if a contact pushes with no more energy (J) than its parts of a sample follow, with a force (N) at most:
    what is thrown up may land far harder than it rests."""
    return (most <= 0.0) | (energy <= max(landing, AS_HARD * scale))


@kernel
def gone_on(
    body: tuple[float, float], period: float, push: tuple[float, float], rise: float, moments: tuple[float, float]
) -> tuple[float, float]:
    """Return a body's position and speed at a sample's end; push: by how much faster (m/s) it gets by the constant
    force, and 1/m; moments (N s): of the force."""
    position, v = body
    pushed, lightness = push
    position += period * (v + 0.5 * pushed) + rise
    position -= 0.5 * period * lightness * (moments[0] - moments[1])
    return position, v + (pushed - lightness * moments[0])
