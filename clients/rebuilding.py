"""The sound of a clip from its ground truth: linear objects, driven by the forces of their contacts.

A force in a sample is its Legendre moments m_k, sum (2k+1) m_k P_k(x) over x from -1 to 1. A mode of s = -decay + i w,
per sample, is at the sample's end

    z' = exp(s) z + sum_k (2k+1) (-1)^k exp(s/2) i_k(s/2) m_k,   and heard as gain Im z,

with i_k the modified spherical Bessel functions. The force of a slide, and of a roll that feels no modes, drives modes
by one number a frame instead, as `dsp.resonator.fed` says. A click is a mode, or several, whose outputs have phases
(`dsp.resonator.click` says how and why).
"""

import reprlib
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..dsp.arguments import ArgumentError, explain_arguments
from ..dsp.engine.memory.state import QUANTUM, TRACED_MOMENTS
from ..dsp.errors import CaromError, require_scipy
from ..dsp.numerics.legendre import KEPT
from ..dsp.resonator.click import click_mode
from ..dsp.resonator.fed import LINE, WINDOW, feed_tap
from ..dsp.resonator.sizes import CLICK_MODES, HALF, REACH

Array = NDArray[Any]
Row = Mapping[str, Any]

_PATH = 3 + TRACED_MOMENTS  # columns of a path: place, gain, place of friction and its moments
_COLUMNS = "frames", "rate", "exposure", "objects", "contacts", "linear"  # of a row, of which it is rebuilt
_ROWS = 4  # of shapes, between which a cubic goes


class NotLinear(CaromError, ValueError):
    """A clip whose sound does not follow from its truth, as an object of it is not linear; the text names it."""


@explain_arguments
def rebuild(row: Row) -> NDArray[np.float64]:
    """Return the sound of a clip from its row of a data set's table.

    Parameters
    ----------
    row : dict
        Row of the table, or of `carom.render_many`.

    Returns
    -------
    array
        float64 (frames, channels), in Pa.

    Raises
    ------
    NotLinear
        An object glides in pitch, was retuned, faded in a panic, is heard in space, was touched off its strike path,
        or was freed: its `linear` is false.
    ArgumentError
        It is no row.
    MissingLibrary
        There is no scipy.

    Examples
    --------
    >>> import carom, numpy as np
    >>> row = next(carom.render_many("bars", range(1)))
    >>> sound = carom.rebuild(row)
    >>> bool(np.abs(sound - row["sound"]).max() < 1e-3 * np.abs(sound).max())
    True
    """
    _require_row(row)
    require_scipy("to rebuild a clip", "dataset")
    frames, rate = int(row["frames"]), float(row["rate"])
    channels = len(row["exposure"])
    sound = np.zeros((frames, channels))
    for body in row["objects"]:
        if not body["linear"]:
            raise NotLinear(f"{body['name']}: it is not linear; expected an object whose `linear` is true")
        own = np.zeros((frames, channels))
        forces = _Forces(frames), _Forces(frames), _Fed(frames)
        for contact in row["contacts"]:
            if body["name"] in (contact["object"], contact["by"]):
                _add(forces, own, body["name"] == contact["object"], contact, rate)
        for kind in ("modes", "relief"):
            _ring(own, body, kind, forces, rate)
        for n, click in enumerate(body["clicks"]):
            pushed, rubbed, fed = (each.along(np.asarray(click["along"], np.float64)) for each in forces)
            _click(own, click, pushed + rubbed * float(n < body["rubbed_clicks"]) + fed, 0, rate)
        if len(body["bends"]):
            own -= _lines(body["bends"], frames)
        sound += own * _lines(body["fades"], frames) if len(body["fades"]) else own
    if not row["linear"]:
        raise NotLinear("an object was freed before the clip's end; expected objects that stay")
    return sound


def _require_row(row: Row) -> None:
    """Raise ArgumentError for what has not the columns of a row."""
    for name in _COLUMNS:
        try:
            row[name]
        except (TypeError, LookupError):
            raise ArgumentError(
                f"row = {reprlib.repr(row)}: it has no {name!r}; expected a row of a data set's table, which has "
                f"{', '.join(_COLUMNS)}"
            ) from None


class _Forces:
    """All forces on an object over a clip: at places that stay, together; those that move; and the sum of all.

    Each is (frames, TRACED_MOMENTS) in N s, or from a first frame on, with its place in each frame.
    """

    def __init__(self, frames: int) -> None:
        self.total = np.zeros((frames, TRACED_MOMENTS))
        self.at: dict[float, Array] = {}
        self.moving: list[tuple[int, Array, _Course]] = []

    def add(self, first: int, force: Array, place: Array) -> None:
        """Add a force from a frame on, at one place or at one in each frame."""
        self.total[first : first + len(force)] += force
        if len(place) == 1:
            whole = self.at.setdefault(float(place[0]), np.zeros_like(self.total))
            whole[first : first + len(force)] += force
        else:
            course = _course(_everywhere(first, place, first + len(place)), LINE)
            self.moving.append((first, force, _Course(*(each[first:] for each in course))))

    def along(self, table: Array | None) -> Array:
        """Return the force (frames, TRACED_MOMENTS) on a shape: 1, or of a table of its values along the path."""
        if table is None:
            return self.total
        here = np.zeros_like(self.total)
        for place, force in self.at.items():
            here += force * _along(table, np.array([place]))
        for first, force, course in self.moving:
            here[first : first + len(force)] += force * course.shape(table)[:, None]
        return here


class _Fed(_Forces):
    """Forces that drive modes by one number a frame: of each, that number in every frame, the sums of those around by
    which it goes straight into the sound (REACH + 1, frames), and its place."""

    def __init__(self, frames: int) -> None:
        super().__init__(frames)
        self.samples: list[tuple[Array, Array, _Course, _Course]] = []

    def add(self, first: int, force: Array, place: Array) -> None:
        """Add a force from a frame on, at one place or at one in each frame."""
        super().add(first, force, place)
        frames = len(self.total)
        moments = np.zeros((frames + HALF, KEPT))
        moments[first : first + len(force)] = force[:, :KEPT]
        parts = np.array([np.convolve(moments[:, k], WINDOW[::-1, k]) for k in range(KEPT)])
        samples = parts.sum(axis=0)[HALF - 1 :][: frames + HALF]
        samples[: (first - 1) // QUANTUM * QUANTUM + REACH + 1] = 0.0  # in the quantum in which it begins
        around = np.pad(samples, (REACH - 1, 0))
        through = [around[REACH + k :][:frames] + (around[REACH - k :][:frames] if k else 0) for k in range(REACH + 1)]
        everywhere = _everywhere(first, place, frames)
        by_line, by_quantum = (_course(everywhere, lines) for lines in (LINE, QUANTUM))
        self.samples.append((samples[:frames], np.array(through), by_line, by_quantum))


def _everywhere(first: int, places: Array, frames: int) -> Array:
    """Return places in all frames, of those from a frame on: before, they move as they begin to."""
    since = np.arange(frames) - first
    begun = places[np.clip(since, 0, len(places) - 1)]
    step = float(places[1] - places[0]) if len(places) > 1 and (first + 1) % LINE else 0.0
    return np.asarray(np.clip(begun + np.minimum(since, 0) * step, 0.0, 1.0))


def _lines(ends: Any, frames: int) -> Array:
    """Return values (frames, channels) that go as lines from each quantum's beginning to its end."""
    flat = np.asarray([[*each] for quantum in ends for each in quantum], np.float64)
    begin, end = flat[::2], flat[1::2]
    share = (np.arange(frames) % QUANTUM + 1.0)[:, None] / QUANTUM
    quantum = np.arange(frames) // QUANTUM
    return np.asarray(begin[quantum] + share * (end - begin)[quantum])


_Kinds = tuple[_Forces, _Forces, _Fed]
"""Forces on an object: those that push, friction, and those that push by one number a frame."""


def _add(forces: _Kinds, sound: Array, touched: bool, contact: Row, rate: float) -> None:
    """Add a contact's force to those on an object; where it is the one that is touched, add the striker's sound."""
    first = int(contact["first"])
    count = min(len(contact["force"]), len(sound) - first)
    if count <= 0:
        return
    others = np.reshape(contact["moments"], (-1, TRACED_MOMENTS - 1))
    moments = np.column_stack([contact["force"], others])[:count].astype(np.float64)
    path = np.reshape(contact["path"], (-1, _PATH))[:count].astype(np.float64)
    gain = path[:, 1] if len(path) else np.full(count, contact["gain"])
    force = moments * gain[:, None] / rate
    place = np.array([contact["position"] if touched else contact["by_position"]])
    forces[2 if contact["fed"] else 0].add(first, force, path[:, 0] if len(path) and touched else place)
    if len(path) and path[:, 3:].any():
        forces[1].add(first, path[:, 3:] / rate, path[:, 2] if touched else place)
    if touched:
        _strike(sound, contact["striker"], force, first, rate)


def _strike(sound: Array, striker: Row, force: Array, first: int, rate: float) -> None:
    """Add the striker's own sound: its click, its ringing in the phase of its velocity, and that of second pulses."""
    for click in striker["clicks"]:
        _click(sound, click, force, first, rate)
    for frequency, decay, gain in zip(*_columns(striker["ringing"]), strict=True):
        sound[first:] += np.outer(_in_phase(frequency, decay, force, len(sound) - first, rate), gain)
    for frequency, decay, gain in zip(*_columns(striker["second"]), strict=True):
        s = complex(-decay, 2 * np.pi * frequency) / rate
        for time, impulse in striker["snaps"]:
            begin = int(np.ceil(time * rate))
            since = np.arange(begin, len(sound)) - time * rate
            sound[begin:] += np.outer(impulse * np.exp(s * since).imag, gain)


def _ring(sound: Array, body: Row, kind: str, forces: _Kinds, rate: float) -> None:
    """Add an object's modes, or their relief, under all forces on it."""
    frequency, decay, gain = _columns(body[kind])
    shapes = (
        [np.asarray([[*row] for row in side]) for side in body["places"][kind]] if _is_touched_all_over(body) else None
    )
    frames, channels = sound.shape
    are_fed = kind == "modes" and bool(forces[2].samples)
    for i in range(len(frequency)):
        s = complex(-decay[i], 2 * np.pi * frequency[i]) / rate
        for c in range(channels if shapes else 1):
            table = shapes[c][:, i] if shapes else None
            by_moments = [forces[0]]
            if kind == "modes" or i < body["rubbed_relief"]:
                by_moments.append(forces[1])
            if not are_fed or i in body["by_moments"]:
                by_moments.append(forces[2])
            heard = _mode(s, np.sum([each.along(table) for each in by_moments], axis=0), frames).imag
            if forces[2] not in by_moments:
                heard += _fed(s, forces[2], table)
            if shapes:
                sound[:, c] += heard
            else:
                sound += np.outer(heard, gain[i])


def _fed(s: complex, forces: _Fed, table: Array | None) -> Array:
    """Return Im z of a mode under forces that drive it by one number a frame (dsp/resonator/fed.py)."""
    from scipy.signal import lfilter

    r, theta = np.exp(s.real), s.imag
    taps = np.array([feed_tap.py_func(theta, k) for k in range(REACH + 1)])
    blows, heard = np.zeros(len(forces.total)), np.zeros(len(forces.total))
    for samples, through, by_line, by_quantum in forces.samples:
        blows += samples * (1.0 if table is None else by_line.shape(table))
        heard += taps @ through * (1.0 if table is None else by_quantum.shape(table))
    return np.asarray(heard + lfilter([r * np.sin(theta)], [1.0, -2 * r * np.cos(theta), r * r], blows))


def _is_touched_all_over(body: Row) -> bool:
    """True if an object is touched at several places."""
    return bool(body["places"] and body["places"]["modes"])


def _columns(sines: Row) -> tuple[Array, Array, Array]:
    """Return frequencies, decays and gains (n, channels) of damped sines."""
    if not sines or not len(sines["frequency"]):
        return np.zeros(0), np.zeros(0), np.zeros((0, 1))
    return np.asarray(sines["frequency"]), np.asarray(sines["decay"]), np.array([*sines["gain"]], np.float64).T


class _Course(NamedTuple):
    """The way of a force, (n,) each: the places between which a shape goes as a line, how far on it is, the place whose
    rows of the shape's table it keeps, and its own place, at which it acts where those rows are too few for a line."""

    begin: Array
    end: Array
    share: Array
    kept: Array
    own: Array

    def shape(self, table: Array) -> Array:
        """Return a shape under the force in each frame."""
        row = _row_of(table, self.kept)
        here, there = (_along(table, place, row) for place in (self.begin, self.end))
        far = np.abs(self.end - self.begin) * (len(table) - 1) > 1.0  # beyond the rows that a line keeps
        passes = far & (self.kept == self.begin)
        return np.where(passes, _along(table, self.own), here + self.share * (there - here))


def _course(places: Array, lines: int) -> _Course:
    """Return the way of a force along places, as lines of so many frames; those of LINE frames keep their rows."""
    frame = np.arange(len(places))
    begins = frame // lines * lines
    last = np.minimum(begins + lines, len(places)) - 1
    begin = places[begins]
    end = places[last] + (places[last] - places[np.maximum(last - 1, begins)])  # what is steered goes on elsewhere
    share = (frame - begins) / (last + 1 - begins)
    return _Course(begin, end, share, begin if lines == LINE else begin + share * (end - begin), places)


def _row_of(table: Array, place: Array) -> Array:
    """Return the first of the four rows around each place."""
    return np.asarray(np.clip((place * (len(table) - 1)).astype(int) - 1, 0, len(table) - _ROWS))


def _along(table: Array, place: Array, row: Array | None = None) -> Array:
    """Return a shape (P,) at places, by the cubic through four rows, those around each if no others are given."""
    row = _row_of(table, place) if row is None else row
    x = place * (len(table) - 1) - row
    weights = (
        -(x - 1) * (x - 2) * (x - 3) / 6, 0.5 * x * (x - 2) * (x - 3), -0.5 * x * (x - 1) * (x - 3),
        x * (x - 1) * (x - 2) / 6,
    )  # fmt: skip
    return np.asarray(sum(weight * table[row + n] for n, weight in enumerate(weights)))


def _mode(s: complex, force: Array, left: int) -> Array:
    """Return z of a mode for so many frames from the force's first on."""
    from scipy.signal import lfilter
    from scipy.special import spherical_in

    k = np.arange(TRACED_MOMENTS)
    answers = (2 * k + 1) * (-1.0) ** k * np.exp(0.5 * s) * spherical_in(k, 0.5 * s)
    driven = lfilter([1.0], [1.0, -np.exp(s)], force @ answers)
    after = driven[-1] * np.exp(s * np.arange(1, left - len(force) + 1))
    return np.concatenate([driven, after])


def _in_phase(frequency: float, decay: float, force: Array, left: int, rate: float) -> Array:
    """Return exp(-decay t) (cos(omega t) - decay/omega sin(omega t)), for so many frames from a force's first on."""
    s = complex(-decay, 2 * np.pi * frequency) / rate
    return np.asarray((complex(s.real / s.imag, 1.0) * _mode(s, force, left)).imag)


def _click(sound: Array, click: Row, force: Array, first: int, rate: float) -> None:
    """Add a click under a force, as the engine has it."""
    heard = np.zeros(len(sound) - first)
    for k in range(CLICK_MODES):
        frequency, decay, weight = click_mode.py_func(k, click["frequency"], click["decay"], rate)
        if frequency > 0.0:
            s = complex(-decay, 2 * np.pi * frequency) / rate
            heard += (weight * _mode(s, force, len(heard))).imag
    sound[first:] += np.outer(heard, click["gain"])
