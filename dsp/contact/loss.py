"""The loss that leaves a restitution: where w = mu v_in is the same at every contact, so is E = |v_out/v_in|."""

from ..native.jit import kernel
from .law import restitution_of

_NEARLY_ONE = 1e-5  # 1 - E up to which two terms of a series are exact to 1e-15
_STRONG = 0.025  # E below which E = 1/w
_STEPS = 12
_SETTLED = 1e-14


@kernel
def loss_of(restitution: float) -> float:
    """Return w of a restitution E in (0, 1]: invert `restitution_of` by Newton's method.

    It is at most 1.5 (1 - E)/E. The slope follows from equation (6) of Papetti, Avanzini, Rocchesso 2011 (see law.py).
    """
    lost = 1.0 - restitution
    if lost <= _NEARLY_ONE:
        return 1.5 * lost * (1.0 + lost)
    if restitution <= _STRONG:
        return 1.0 / restitution
    w = lost * (1.0 + 0.5 * restitution) / restitution
    for _ in range(_STEPS):
        e = restitution_of(w)
        d = w * e
        slope = (w * (1.0 - d) / (d * (1.0 + w)) - e) / w
        step = (e - restitution) / slope
        w = max(w - step, 0.5 * w)
        if abs(step) <= _SETTLED * w:
            break
    return w
