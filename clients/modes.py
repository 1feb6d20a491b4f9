"""The modes of an object as the engine plays them: labels for its sound."""

from collections.abc import Hashable
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..dsp.bodies.modes import Modes
from ..dsp.engine.bodies.objects import GONE, sigma_of, weigh
from ..dsp.engine.memory.channels import pan_gains
from ..dsp.kept import Kept
from ..dsp.resonator.bank import top_of
from ..dsp.runtime.plan import planned

_ROWS = 4  # between which mode shapes are interpolated


class Click(NamedTuple):
    """A heavily damped sound of a body about the point that is struck.

    An impulse of J (N s) at t = 0 adds, at the output c,
    J gains[c] exp(-decay t) (cos(w t) - decay/w sin(w t)), w = 2 pi frequency.
    """

    frequency: float
    """Hz"""
    decay: float
    """1/s"""
    gains: NDArray[np.float64]
    """(channels,) of full scale, or in Pa where the scene is calibrated, per N s."""


class Relief(NamedTuple):
    """Heavily damped sines that an object adds to its modes, of the form of ModeTable's: with them a slow force, that
    merely bends the body, is not heard. They are over long before the modes are."""

    frequencies: NDArray[np.float64]
    """(m,) Hz."""
    decays: NDArray[np.float64]
    """(m,) 1/s."""
    gains: NDArray[np.float64]
    """(m, channels), as ModeTable's."""


class ModeTable(NamedTuple):
    """Modes of an object struck at one position, by ascending frequency.

    An impulse of J (N s) at t = 0 sounds, in channel c, as
    J sum_i gains[i, c] exp(-decays[i] t) sin(2 pi frequencies[i] t). `clicks` and `relief` add to it.

    Attributes
    ----------
    frequencies : float64 (n,)
        Hz.
    decays : float64 (n,)
        1/s: a level falls by 60 dB in ln(1000)/decay.
    gains : float64 (n, channels)
        Full scale per N s, or Pa per N s in a calibrated scene. Below 0 in opposite phase, 0 at a node.
    clicks : tuple of Click
        Sounds of a sudden motion: of the whole body, and of a thin body about the point that is struck.
    relief : Relief or None
        Heavily damped modes that keep slow forces from being heard.
    """

    frequencies: NDArray[np.float64]
    decays: NDArray[np.float64]
    gains: NDArray[np.float64]
    clicks: tuple[Click, ...] = ()
    relief: Relief | None = None


class Settings(NamedTuple):
    """The settings of an object as the engine has them: amplitude, pan (-1 to 1), distance (m), ratios of frequencies
    and of decay times, damping (0 to 1)."""

    gain: float
    pan: float
    distance: float
    tune: float
    decay: float
    damp: float


def gains_of(settings: Settings, channels: int, main: float = 1.0) -> NDArray[np.float64]:
    """Return (channels,): the gain of each channel for an object that its pan places; main: the main gain
    (amplitude)."""
    gains = np.zeros(channels)
    pan_gains.py_func(gains, channels, settings.pan, settings.gain / settings.distance * main)
    return gains


def mode_table(
    modes: Modes, level: float, settings: Settings, gains: NDArray[np.float64], position: float, rate: float
) -> ModeTable:
    """Return the table of modes that were laid out at a level (amplitude), heard with gains (channels,), struck at a
    position (0 to 1), for a rate in Hz."""
    known = heard_as(modes, level, settings, gains, rate)
    relief = Relief(known.relief.frequencies.copy(), known.relief.decays.copy(), known.relief_at(position))
    return ModeTable(
        known.frequencies.copy(), known.decays.copy(), known.gains_at(position), known.clicks_at(position), relief
    )  # fmt: skip


class Heard(NamedTuple):
    """An object as it is heard: all that its tables of modes have in common, wherever it is struck."""

    modes: Modes
    level: float
    gains: NDArray[np.float64]
    heard: NDArray[np.int64]
    frequencies: NDArray[np.float64]
    decays: NDArray[np.float64]
    sides: NDArray[np.float64]
    clicks: tuple[Click, ...]
    relief: "_Still"

    def gains_at(self, position: float) -> NDArray[np.float64]:
        """Return the gains of its modes, (n, channels), struck at a position (0 to 1)."""
        shape = _shape_at(self.modes.along, position)[self.heard]
        return self.level * (self.sides * shape).T * self.gains

    @property
    def shares(self) -> list[NDArray[np.float64]]:
        """The shares of its clicks at equally spaced positions along the strike path."""
        rows = max(len(self.modes.along), _ROWS)
        return [each.rows(rows if len(each.along) > 1 else _ROWS) for each in self.modes.clicks]

    def clicks_at(self, position: float) -> tuple[Click, ...]:
        """Return its clicks, struck at a position (0 to 1)."""
        heard = zip(self.clicks, self.shares, strict=True)
        return tuple(each._replace(gains=each.gains * _shape_at(rows[:, None], position)) for each, rows in heard)

    def relief_at(self, position: float) -> NDArray[np.float64]:
        """Return the gains of its relief, (m, channels), struck at a position (0 to 1)."""
        each = [_shape_at(shape, position) * self.relief.share for shape in self.relief.along]
        sized = np.array(each if len(each) == len(self.gains) else each * len(self.gains)).T
        return sized * (self.level * self.gains)


class _Still(NamedTuple):
    """A relief: frequencies, decays, shapes along the strike path on each side, and their shares."""

    frequencies: NDArray[np.float64]
    decays: NDArray[np.float64]
    along: NDArray[np.float64]
    share: NDArray[np.float64]


_kept: Kept[Hashable, Heard] = Kept(64, lambda _: 1)


def heard_as(modes: Modes, level: float, settings: Settings, gains: NDArray[np.float64], rate: float) -> Heard:
    """Return modes that were laid out as they are heard; arguments as of `mode_table`."""
    key = id(modes), level, settings, gains.tobytes(), rate  # what is kept keeps its modes, and so their id
    known = _kept.get(key)
    if known is None:
        frequencies = modes.frequency * settings.tune
        top = top_of.py_func(rate)
        heard = np.flatnonzero((modes.frequency <= top) & (frequencies <= top))
        known = Heard(
            modes,
            level,
            gains,
            heard,
            frequencies[heard],
            _decays(modes, settings, rate)[heard],
            _sides(modes, len(gains))[:, heard],
            tuple(Click(each.frequency, each.decay, level * each.strength * gains) for each in modes.clicks),
            _still(modes, settings.tune, len(gains), rate),
        )
        _kept.put(key, known)
    return known


class Places(NamedTuple):
    """Mode shapes all along an object's strike path, beside a ModeTable of it: its gains at a position are
    shape x weight, by the cubic through four rows around it."""

    strike: NDArray[np.float64]
    """(P, n) kg^-1/2, at P equally spaced positions 0..1."""
    weights: NDArray[np.float64]
    """(n, channels)."""
    relief: NDArray[np.float64]
    """(channels, P, b): gains of the relief."""


def places_of(modes: Modes, level: float, settings: Settings, gains: NDArray[np.float64], rate: float) -> Places:
    """Return the shapes of the modes of `mode_table` along the strike path; arguments as there."""
    frequencies = modes.frequency * settings.tune
    top = top_of.py_func(rate)
    heard = np.flatnonzero((modes.frequency <= top) & (frequencies <= top))
    rows = modes.along if len(modes.along) >= _ROWS else np.repeat(modes.strike[:1], _ROWS, axis=0)
    found = _still(modes, settings.tune, len(gains), rate)
    shapes = found.along if len(gains) == 2 else [found.along[0]] * len(gains)
    sized = [level * gain * shape * found.share for gain, shape in zip(gains, shapes, strict=True)]
    return Places(rows[:, heard], level * _sides(modes, len(gains))[:, heard].T * gains, np.array(sized))


def _sides(modes: Modes, channels: int) -> NDArray[np.float64]:
    """Return the weights of modes on each side: of two channels left and right, else one of both."""
    if channels == 2:
        return modes.pressure
    return np.asarray(np.copysign(np.sqrt(0.5 * (modes.pressure**2).sum(axis=0)), modes.pressure[:1]))


def _decays(modes: Modes, settings: Settings, rate: float) -> NDArray[np.float64]:
    """Return the decays of all modes, as the engine has them."""
    if not len(modes.decay):  # a small body that clicks alone
        return modes.decay
    bank = SimpleNamespace(sigma=modes.decay, held=np.zeros_like(modes.decay))
    state: Any = SimpleNamespace(bank=bank, rate=rate)
    obj: Any = SimpleNamespace(first=0, settings=settings)
    most = int(np.argmax(modes.decay))
    if settings.decay == 1.0 and settings.damp == 0.0 and sigma_of.py_func(state, obj, most) == modes.decay[most]:
        return modes.decay  # nothing changes them, and the heaviest is not too heavy
    return np.array([sigma_of.py_func(state, obj, i) for i in range(len(modes.decay))])


def _still(modes: Modes, tune: float, channels: int, rate: float) -> _Still:
    """Return the relief of modes that are heard in so many channels, as the engine has it
    (engine/bodies/objects.py)."""
    top = top_of.py_func(rate)
    plan = planned(modes, top, 0.5 * rate, channels == 2)
    found = plan.relief
    frequency = found.frequency * tune
    share = np.minimum(1.0, top / frequency)
    along = found.shape[:, : plan.rows]
    return _Still(frequency * share, found.decay * tune * share, along, np.where(share > GONE, share, 0.0))


def _shape_at(strike: NDArray[np.float64], position: float) -> NDArray[np.float64]:
    """Return the mode shapes (n,) at a position, by the engine's cubic through the four rows around it."""
    if len(strike) < _ROWS:
        return np.asarray(strike[0])  # the position does not matter
    x = position * (len(strike) - 1)
    row = min(max(int(x) - 1, 0), len(strike) - _ROWS)
    weights = np.empty(_ROWS)
    weigh.py_func(weights, x - row, 1.0)
    return np.asarray(weights @ strike[row : row + _ROWS])
