"""The sound of a clip from its ground truth: linear objects, driven by the forces of their contacts.

A force in a sample is its Legendre moments m_k, sum (2k+1) m_k P_k(x) over x from -1 to 1. A mode of s = -decay + i w,
per sample, is at the sample's end

    z' = exp(s) z + sum_k (2k+1) (-1)^k exp(s/2) i_k(s/2) m_k,   and heard as gain Im z,

with i_k the modified spherical Bessel functions. A click is the same in continuous time, smoothed as the engine does it
(`dsp.resonator.click` says how and why).
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy.signal import lfilter
from scipy.special import spherical_in

from ..dsp.engine.memory.state import QUANTUM, TRACED_MOMENTS
from ..dsp.errors import CaromError
from ..dsp.resonator.click import FAR, FIRST, GAIN, LEAST, NEAR, SECOND, TAPS, WIDEST

Array = NDArray[Any]
Row = Mapping[str, Any]

_PATH = 5  # columns of a path: place, gain, place of friction, friction and its first moment
_ROWS = 4  # of shapes, between which a cubic goes
_SMALL, _TERMS = 1.0, 18  # |x| up to which exp(x) is summed as a series
_NODES, _WEIGHTS = legendre.leggauss(16)


class NotLinear(CaromError, ValueError):
    """A clip whose truth does not say its sound, as an object of it is not linear; the text names it."""


def rebuild(row: Row) -> NDArray[np.float64]:
    """Return the sound of a clip in Pa, (frames, channels), from its row of a data set's table.

    NotLinear where an object glides in pitch or was retuned meanwhile (`linear` is false).
    """
    frames, rate = int(row["frames"]), float(row["rate"])
    channels = len(row["exposure"])
    sound = np.zeros((frames, channels))
    for body in row["objects"]:
        if not body["linear"]:
            raise NotLinear(f"{body['name']}: it is not linear; expected an object whose `linear` is true")
        own = np.zeros((frames, channels))
        forces = _Forces(frames)
        for contact in row["contacts"]:
            if body["name"] in (contact["object"], contact["by"]):
                _add(forces, own, body["name"] == contact["object"], contact, rate)
        for kind in ("modes", "relief"):
            _ring(own, body, kind, forces, rate)
        for click in body["clicks"]:
            _click(own, click, forces.total, 0, rate)
        if len(body["bends"]):
            own -= _lines(body["bends"], frames)
        sound += own * _lines(body["fades"], frames) if len(body["fades"]) else own
    return sound


class _Forces:
    """All forces on an object over a clip: at places that stay, together; those that move; and the sum of all.

    Each is (frames, TRACED_MOMENTS) in N s, or from a first frame on, with its place in each frame.
    """

    def __init__(self, frames: int) -> None:
        self.total = np.zeros((frames, TRACED_MOMENTS))
        self.at: dict[float, Array] = {}
        self.moving: list[tuple[int, Array, Array]] = []

    def add(self, first: int, force: Array, place: Array) -> None:
        """Add a force from a frame on, at one place or at one in each frame."""
        self.total[first : first + len(force)] += force
        if len(place) == 1:
            whole = self.at.setdefault(float(place[0]), np.zeros_like(self.total))
            whole[first : first + len(force)] += force
        else:
            self.moving.append((first, force, place))


def _lines(ends: Any, frames: int) -> Array:
    """Return values (frames, channels) that go as lines from each quantum's beginning to its end."""
    flat = np.asarray([[*each] for quantum in ends for each in quantum], np.float64)
    begin, end = flat[::2], flat[1::2]
    share = (np.arange(frames) % QUANTUM + 1.0)[:, None] / QUANTUM
    quantum = np.arange(frames) // QUANTUM
    return np.asarray(begin[quantum] + share * (end - begin)[quantum])


def _add(forces: _Forces, sound: Array, touched: bool, contact: Row, rate: float) -> None:
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
    forces.add(first, force, path[:, 0] if len(path) and touched else place)
    if len(path) and path[:, 3:].any():
        rubbed = np.pad(path[:, 3:] / rate, ((0, 0), (0, TRACED_MOMENTS - 2)))
        forces.add(first, rubbed, path[:, 2] if touched else place)
    if touched:
        _strike(sound, contact["striker"], force, first, rate)


def _strike(sound: Array, striker: Row, force: Array, first: int, rate: float) -> None:
    """Add the striker's own sound: its click, its ringing in the phase of its velocity, and that of second pulses."""
    for click in striker["clicks"]:
        _click(sound, click, force, first, rate)
    for frequency, decay, gain in zip(*_columns(striker["ringing"]), strict=True):
        s = complex(-decay, 2 * np.pi * frequency) / rate
        heard = complex(s.real / s.imag, 1.0) * _mode(s, force, len(sound) - first)
        sound[first:] += np.outer(heard.imag, gain)
    for frequency, decay, gain in zip(*_columns(striker["second"]), strict=True):
        s = complex(-decay, 2 * np.pi * frequency) / rate
        for time, impulse in striker["snaps"]:
            begin = int(np.ceil(time * rate))
            since = np.arange(begin, len(sound)) - time * rate
            sound[begin:] += np.outer(impulse * np.exp(s * since).imag, gain)


def _ring(sound: Array, body: Row, kind: str, forces: _Forces, rate: float) -> None:
    """Add an object's modes, or their relief, under all forces on it."""
    frequency, decay, gain = _columns(body[kind])
    shapes = (
        [np.asarray([[*row] for row in side]) for side in body["places"][kind]] if _is_touched_all_over(body) else None
    )
    frames, channels = sound.shape
    for i in range(len(frequency)):
        s = complex(-decay[i], 2 * np.pi * frequency[i]) / rate
        if shapes is None:
            sound += np.outer(_mode(s, forces.total, frames).imag, gain[i])
            continue
        for c in range(channels):
            table = shapes[c][:, i]
            here = np.zeros_like(forces.total)
            for place, force in forces.at.items():
                here += force * _along(table, np.array([place]))
            for first, force, places in forces.moving:
                here[first : first + len(force)] += force * _along(table, places)[:, None]
            sound[:, c] += _mode(s, here, frames).imag


def _is_touched_all_over(body: Row) -> bool:
    """True if an object is touched at several places."""
    return bool(body["places"] and body["places"]["modes"])


def _columns(sines: Row) -> tuple[Array, Array, Array]:
    """Return frequencies, decays and gains (n, channels) of damped sines."""
    if not sines or not len(sines["frequency"]):
        return np.zeros(0), np.zeros(0), np.zeros((0, 1))
    return np.asarray(sines["frequency"]), np.asarray(sines["decay"]), np.array([*sines["gain"]], np.float64).T


def _along(table: Array, place: Array) -> Array:
    """Return a shape (P,) at places, by the cubic through the four rows around each."""
    x = place * (len(table) - 1)
    row = np.clip(x.astype(int) - 1, 0, len(table) - _ROWS)
    x = x - row
    weights = (
        -(x - 1) * (x - 2) * (x - 3) / 6, 0.5 * x * (x - 2) * (x - 3), -0.5 * x * (x - 1) * (x - 3),
        x * (x - 1) * (x - 2) / 6,
    )  # fmt: skip
    return np.asarray(sum(weight * table[row + n] for n, weight in enumerate(weights)))


def _mode(s: complex, force: Array, left: int) -> Array:
    """Return z of a mode for so many frames from the force's first on."""
    k = np.arange(TRACED_MOMENTS)
    answers = (2 * k + 1) * (-1.0) ** k * np.exp(0.5 * s) * spherical_in(k, 0.5 * s)
    driven = lfilter([1.0], [1.0, -np.exp(s)], force @ answers)
    after = driven[-1] * np.exp(s * np.arange(1, left - len(force) + 1))
    return np.concatenate([driven, after])


def _click(sound: Array, click: Row, force: Array, first: int, rate: float) -> None:
    """Add a click under a force, as the engine smoothes it."""
    s = complex(-click["decay"], 2 * np.pi * click["frequency"]) / rate
    own = max(np.exp(s.real), LEAST) * np.exp(1j * min(s.imag, WIDEST))
    poles = np.poly([own, own.conjugate(), NEAR, NEAR.conjugate(), FAR, FAR.conjugate()]).real
    taps = _taps(s) * GAIN
    driven = np.zeros(len(sound) - first)
    for k in range(TRACED_MOMENTS):
        part = np.convolve(force[:, k], taps[:, k])[: len(driven)]
        driven[: len(part)] += part
    sound[first:] += np.outer(lfilter([1.0], poles, driven), click["gain"])


def _taps(s: complex) -> Array:
    """Return the numerator's taps for each moment of a force, (TAPS, TRACED_MOMENTS)."""
    own = max(np.exp(s.real), LEAST) * np.exp(1j * min(s.imag, WIDEST))
    since = 0.5 * (1.0 - _NODES)
    integral = np.array([_integral(since + j, s) for j in range(TAPS)])
    fourth = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
    spline = np.array([np.convolve(column, fourth)[:TAPS] for column in integral.T])
    left = np.array([np.convolve(each, [1.0, -2.0 * own.real, abs(own) ** 2])[:TAPS] for each in spline])
    k = np.arange(TRACED_MOMENTS)
    moments = (0.5 * _WEIGHTS)[:, None] * legendre.legvander(_NODES, TRACED_MOMENTS - 1) * (2 * k + 1)
    return np.asarray(left.T @ moments)


def _integral(t: Array, s: complex) -> Array:
    """Return the fourth integral of a click over a time (samples), and shares of the third and the second."""
    weight = complex(s.real / s.imag, 1.0)
    x = s * t
    small = np.abs(x.real) + np.abs(x.imag) < _SMALL
    series = sum(x**n / np.prod(np.arange(5.0, 5.0 + n)) for n in range(_TERMS)) / 24.0
    safe = np.where(small, 1.0, x)
    closed = (np.exp(safe) - 1.0 - safe - safe**2 / 2 - safe**3 / 6) / safe**4
    fourth = np.where(small, series, closed) * t**4
    third = s * fourth + t**3 / 6
    second = s * third + t**2 / 2
    return np.asarray((weight * (fourth + FIRST * third + SECOND * second)).imag)
