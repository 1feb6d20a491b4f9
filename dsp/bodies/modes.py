"""The modes of a body, and the steps that all shapes share in computing them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..errors import CaromError
from .acceleration import Click
from .material import Array
from .material import Indices as Indices

if TYPE_CHECKING:
    from .karman import Sheet

MOST_MODES = 1024
_LEAST = 1e-300  # Hz
LOWEST_FREQUENCY = 1.0  # Hz; below lie rigid motions, which a Ritz method returns as rounding noise
PATH_STEP = 0.6  # rad of the shortest wave between two positions: cubic interpolation then errs by < 0.6 %


class Silent(CaromError, ValueError):
    """A body that has no mode between the lowest frequency and `top` (Hz): the highest one wanted, or a lower one where
    its series ends before that."""

    def __init__(self, top: float) -> None:
        super().__init__(
            f"no mode lies between {LOWEST_FREQUENCY:g} Hz and {top:g} Hz: expected a body that rings there; a larger "
            "or thinner one rings lower"
        )
        self.top = top


class Unheard(NamedTuple):
    """Modes that contacts feel and nobody hears (unheard.py): frequency (Hz) and decay (1/s), (k,), and strike (P, k),
    as in Modes. Their frequencies may be as high as they like."""

    frequency: Array
    decay: Array
    strike: Array


class Faces(NamedTuple):
    """Triangles of a body's surface: corners (f, 3, 3) in m, in the body's frame; rows (f,) of Modes.strike that hold
    the shapes at the first of them, with those at the others in the next two rows. The first `path` rows lie along the
    strike path, at the places `line` (path, 3) in m. curvature (f, 3, 2): both principal ones at the corners (1/m),
    positive where convex; edges (f, 3): 1 where the side from a corner to the next is a sharp edge. These shapes are
    along the surface's normals; `block` rows behind each lie those along x, and behind these along y and z."""

    corners: Array
    rows: Indices
    path: int
    line: Array
    curvature: Array
    edges: Indices
    block: int


@dataclass(frozen=True)
class Modes:
    """The audible modes of a body: w(x, t) = sum_i phi_i(x) q_i(t), q'' + 2 sigma q' + omega^2 q = phi(x) F.

    Attributes
    ----------
    frequency : float64 (n,)
        Hz, ascending.
    decay : float64 (n,)
        Decay rates sigma, 1/s, radiation included.
    strike : float64 (P, n)
        Mass-normalised shapes at P equally spaced positions, 0 to 1 along the strike path, kg^-1/2; P = 1: the position
        does not matter. With `faces`, rows follow with shapes at their corners.
    pressure : float64 (2, n)
        Sound pressure at 1 m, left and right, per unit modal velocity (q' of 1 sqrt(kg) m/s), Pa, rms over directions:
        G with (L^2 + R^2)/2 = G^2.
    mass : float
        Mass of the whole body, kg.
    clicks : tuple of Click
        Sounds of a sudden motion: of a free body as a whole, of a thin one about the striking point.
    glide : float
        Rise of the tension for each joule of vibration, Delta T/T, 1/J; 0: none.
    cone : float
        Its rise about a striker, tau (1 + tau) = glide cone velocity^2, kg; 0: none.
    unheard : Unheard or None
        Compliance of inaudible modes. None: unknown.
    sheet : Sheet or None
        Coupling of a plate's modes by stretching. None: they are not coupled.
    faces : Faces or None
        Faces of the surface, for contacts off the strike path.
    fundamental : float
        The mode by which notes are tuned, Hz; 0: the lowest.

    Notes
    -----
    A mode that radiates the power R q'^2/2 has G = sqrt(rho c R/(4 pi)), and R/2 is in its decay.
    """

    frequency: Array
    decay: Array
    strike: Array
    pressure: Array
    mass: float
    clicks: tuple[Click, ...] = ()
    glide: float = 0.0
    cone: float = 0.0
    unheard: Unheard | None = None
    sheet: "Sheet | None" = None
    faces: Faces | None = None
    fundamental: float = 0.0

    @property
    def pitch(self) -> float:
        """The pitch (Hz) that notes are tuned by; 0 where no mode is heard."""
        return self.fundamental or (float(self.frequency[0]) if self.frequency.size else 0.0)

    @property
    def along(self) -> Array:
        """The rows of `strike` along the strike path."""
        return self.strike if self.faces is None else self.strike[: self.faces.path]


def columns(size: int, of: str, **given: float | Sequence[float]) -> list[Array]:
    """Return each of the values given, one or as many as there are frequencies or the like, as an array (size,)."""
    try:
        return [np.broadcast_to(np.asarray(values, np.float64), (size,)) for values in given.values()]
    except ValueError:
        counts = ", ".join(f"{np.size(values)} of {name}" for name, values in given.items())
        raise ValueError(f"{counts}: expected {size}, as many as {of}, or one") from None


def ascending(frequency: Array) -> Indices:
    """Return indices of modes by ascending frequency; those that differ by rounding alone stay in their order."""
    return np.argsort(np.round(np.log(np.maximum(frequency, _LEAST)), 9), kind="stable")


def audible(frequency: Array, top: float, most: int | None = None) -> Indices:
    """Return indices of the modes to keep, by ascending frequency: from 1 Hz to `top` (Hz), at most `most`, MOST_MODES
    if not given.

    Silent if there is none.
    """
    order = ascending(frequency)
    heard = order[(frequency[order] >= LOWEST_FREQUENCY) & (frequency[order] <= top)]
    if not heard.size:
        raise Silent(top)
    return heard[: most or MOST_MODES]


def selected(modes: Modes, keep: npt.NDArray[Any]) -> Modes:
    """Return the body with the audible modes that an index array or a mask keeps."""
    place = np.full(modes.frequency.size, -1)
    kept = np.arange(modes.frequency.size)[keep]
    place[kept] = np.arange(kept.size)
    return replace(
        modes,
        sheet=modes.sheet and modes.sheet.moved(place),
        frequency=modes.frequency[keep],
        decay=modes.decay[keep],
        strike=modes.strike[:, keep],
        pressure=modes.pressure[:, keep],
    )


def read_only(*arrays: npt.NDArray[Any]) -> None:
    """Make arrays that are kept for later safe from whoever gets them."""
    for array in arrays:
        array.flags.writeable = False


def path(radians: float) -> Array:
    """Return equally spaced positions 0..1 along a path that the shortest wave crosses in `radians` of phase."""
    return np.linspace(0, 1, max(5, 2 * math.ceil(radians / (2 * PATH_STEP)) + 1))


def require_positive(**values: float | None) -> None:
    """Raise ValueError naming the first of the values that is given and is not a positive number."""
    for name, value in values.items():
        if value is not None and not 0 < value < math.inf:
            raise ValueError(f"{name} = {value}: expected a positive number")


def require_choice(name: str, value: str, choices: Sequence[str]) -> None:
    """Raise ValueError naming `value` if it is none of `choices`."""
    if value not in choices:
        raise ValueError(f"{name} = {value}: expected one of {', '.join(choices)}")
