"""The truth about a clip's objects and contacts: numbers, words, and lists of these."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...dsp.bodies.modes import Modes
from ...dsp.engine.memory.records import SLID
from ...dsp.engine.memory.state import QUANTUM, TRACED_MOMENTS
from ...dsp.kept import Kept
from ...dsp.resonator.bank import top_of
from ...dsp.resonator.simd import LANES
from ...dsp.resonator.sizes import CLICK_MODES, LEAST_FED
from ...dsp.schema import GESTURES
from ..contacts import Contact, Drive
from ..modes import Click, Heard, Places, Settings, heard_as, places_of
from ..performer import Performer

Truth = dict[str, Any]
"""Ground truth by name."""

Ends = list[list[list[float]]]
"""Values by quantum, at its beginning and its end, and by channel."""

FREE = tuple(name for name, gesture in GESTURES.items() if not gesture.lasts)
"""Gestures between whose contacts a striker flies: nothing but the contact changes its speed then."""

AMPLIFIED = 2.0**24
"""Factor on the engine's samples, which loses no bit: it puts modes to rest at 1e-6, and quiet clips have their tails,
too."""

PATH = 3 + TRACED_MOMENTS
"""Columns of a path: place, gain, and of friction its place and its moments."""

CLICK_ROOM = 32
"""Places between an object's own modes and the end of those of its clicks."""

_MOST_STRIKERS = 64  # whose sounds are kept for one object

_SOUND = ("tune", "decay", "damp")
"""Settings of an object that change how its modes ring."""


@dataclass(frozen=True)
class _Seen:
    """An object in a quantum: its gains and its static output, both (2, channels) at the beginning and the end, and the
    settings of its modes."""

    gains: NDArray[np.float64]
    bend: NDArray[np.float64]
    settings: tuple[float, ...]


class Followed:
    """Objects from quantum to quantum, as what they do is more than their modes and the forces on them say."""

    def __init__(self) -> None:
        self._seen: dict[int, list[_Seen]] = {}
        self._in_space: set[int] = set()
        self._panicked: set[int] = set()
        self._covered: set[int] = set()

    def look(self, performer: Performer) -> None:
        """Take notice of a quantum that was computed."""
        channels = performer.engine.channels
        sides = [0, 1] if channels == 2 else [0] * channels
        main = performer.engine.state[0]["output"]["gain"]
        space = performer.engine.state[0]["surroundings"]
        if space["on"]:
            self._in_space.update(space["lines"]["serial"][space["lines"]["used"] == 1].tolist())
        for serial, placed in performer.engine.placed.items():
            record = performer.engine.state[0]["objects"][placed.handle.slot]
            if record["serial"] == serial:
                place, settings = record["place"], record["settings"]
                gains = np.array([place["before"][:channels], place["gain"][:channels]]) * main[:, None]
                bend = np.array([record["static_before"][sides], record["static"][sides]])
                seen = _Seen(gains, bend, tuple(float(settings[name]) for name in _SOUND))
                self._seen.setdefault(serial, []).append(seen)
                if record["fading"] > 0:
                    self._panicked.add(serial)
                first, felt = int(record["first"]), int(record["felt"])
                if performer.engine.state[0]["bank"]["held"][first : first + felt].any():
                    self._covered.add(serial)

    def fades(self, serial: int, gains: NDArray[np.float64], quanta: int) -> Ends:
        """Return an object's gains at the beginning and the end of each quantum, between which they go as lines, as
        shares of those in its table; none where they stay."""
        seen = [each.gains for each in self._seen.get(serial, ())]
        if all((each == gains).all() for each in seen):
            return []
        whole = np.array([seen[0]] * (quanta - len(seen)) + seen)
        shares: Ends = np.divide(whole, gains, out=np.zeros_like(whole), where=gains != 0.0).tolist()
        return shares

    def bends(self, serial: int, gains: NDArray[np.float64], quanta: int) -> Ends:
        """Return the sound (Pa) that a steady push would make at the beginning and the end of each quantum, which is
        left out of what is heard; none where there is none."""
        seen = [each.bend for each in self._seen.get(serial, ())]
        if not any(each.any() for each in seen):
            return []
        whole: Ends = (np.array([0.0 * seen[0]] * (quanta - len(seen)) + seen) * gains / AMPLIFIED).tolist()
        return whole

    def stayed(self, serial: int) -> bool:
        """True if an object rang on as it was made: no panic, nothing that covered it, and no place in space."""
        settings = {each.settings for each in self._seen.get(serial, ())}
        return serial not in self._in_space | self._panicked | self._covered and len(settings) <= 1

    def all_in(self, serials: Iterable[int]) -> bool:
        """True if no object was there but these."""
        return not self._seen or self._seen.keys() <= set(serials)


class Told:
    """An object of a scene as it is heard now, and all of its truth that does not depend on where it is touched."""

    def __init__(self, performer: Performer, rate: int, name: str, heard: tuple[Settings, NDArray[np.float64]]) -> None:
        """Find what is recorded of an object with these settings and gains."""
        self.strikers: dict[Hashable, _Sound] = {}
        """The sounds of strikers on it, by what they follow from."""
        self._placed, (settings, self.gains) = performer.placed(name), heard
        modes, preset = self._placed.modes, performer.scene.objects[name].preset
        self._level = self._placed.level / AMPLIFIED
        self._rate, self._settings = rate, settings
        self._heard: Heard = heard_as(modes, self._level, settings, self.gains, rate)
        self._bends = modes.glide > 0.0 or modes.sheet is not None
        self._by_moments = _by_moments(modes, settings.tune, rate)
        made = int(np.count_nonzero(modes.frequency <= top_of.py_func(rate)))
        self._identity = {
            "name": name,
            "preset": preset.name,
            "shape": preset.shape,
            "material": preset.material.name if preset.material else "",
            "mass": modes.mass,
        }
        self._rubbed = {
            "rubbed_relief": max(min(SLID - made, len(self._heard.relief.frequencies)), 0),
            "rubbed_clicks": len(self._heard.clicks) if made + CLICK_ROOM <= SLID else 0,
        }

    def about(self, frames: int, touched: float | None, moves: bool, followed: Followed, on_path: bool) -> Truth:
        """Describe an object: what it is, and the modes that a blow where it is touched excites. moves: it is touched
        elsewhere, too; on_path: but nowhere off its strike path."""
        serial, quanta = self._placed.handle.serial, -(-frames // QUANTUM)
        position = self._placed.position if touched is None else touched
        heard, shares = self._heard, self._heard.shares
        laid = self._placed.modes, self._level, self._settings, self.gains, self._rate
        return {
            **self._identity,
            "position": position,
            "linear": not self._bends and followed.stayed(serial) and on_path,
            "by_moments": [*self._by_moments],
            **self._rubbed,
            "modes": sines(heard.frequencies, heard.decays, heard.gains_at(position)),
            "clicks": [_click(each) | {"along": [*rows]} for each, rows in zip(heard.clicks, shares, strict=True)],
            "relief": sines(heard.relief.frequencies, heard.relief.decays, heard.relief_at(position)),
            "places": _places(places_of(*laid)) if moves else {},
            "fades": followed.fades(serial, self.gains, quanta),
            "bends": followed.bends(serial, self.gains, quanta),
        }


def told_of(performer: Performer, rate: int, name: str) -> Told | None:
    """Return the truth of an object as it is heard now; None where it came too late to be."""
    heard = performer.heard(performer.placed(name))
    return None if heard is None else Told(performer, rate, name, heard)


def _by_moments(modes: Modes, tune: float, rate: int) -> list[int]:
    """Return which of the modes in its table even a contact that is fed drives by moments: all where they are few, else
    those beyond whole lanes, as the engine lays them out by their decays."""
    key = id(modes), tune, rate
    known = _kept.get(key)
    if known is None:
        known = modes, _beyond_lanes(modes, tune, rate)
        _kept.put(key, known)
    return [*known[1]]


def _beyond_lanes(modes: Modes, tune: float, rate: int) -> list[int]:
    """Return the places of `_by_moments`."""
    top = top_of.py_func(rate)
    order = np.argsort(modes.decay, kind="stable")
    order = order[modes.frequency[order] <= top]
    fed = len(order) // LANES * LANES if len(order) >= LEAST_FED else 0
    beyond = np.zeros(len(modes.frequency), np.bool_)
    beyond[order[fed:]] = True
    found: list[int] = np.flatnonzero(beyond[(modes.frequency <= top) & (modes.frequency * tune <= top)]).tolist()
    return found


_kept: Kept[tuple[int, float, int], tuple[Modes, list[int]]] = Kept(256, lambda _: 1)
"""The places of `_by_moments` of modes, which are kept with them, and so keep their id."""

_NONE = (np.zeros(0), np.zeros(0), np.zeros((0, 0)))


def _click(click: Click) -> Truth:
    return {"frequency": click.frequency, "decay": click.decay, "gain": click.gains.tolist()}


def sines(frequency: NDArray[np.float64], decay: NDArray[np.float64], gain: NDArray[np.float64]) -> Truth:
    """Return damped sines: frequencies (Hz), decays (1/s), and for each channel the gains (Pa per N s)."""
    return {"frequency": frequency.tolist(), "decay": decay.tolist(), "gain": gain.T.tolist()}


def _places(found: Places) -> Truth:
    """Return the gains (channels, P, n) of modes and relief at P equally spaced positions of the strike path."""
    modes = found.strike[None] * found.weights.T[:, None, :]
    return {"modes": modes.astype(np.float32).tolist(), "relief": found.relief.astype(np.float32).tolist()}


def about_contacts(
    performer: Performer, contacts: Iterable[Contact], objects: Mapping[str, Told]
) -> list[Mapping[str, Any]]:
    """Describe contacts; where their forces begin among all forces, and their paths among all paths, and how many they
    are. objects: by name, those that are there."""
    told: list[Mapping[str, Any]] = []
    begin, path, rate = 0, 0, performer.engine.rate
    for each in contacts:
        free = each.gesture in FREE
        moved = 0 if each.drive.stays else len(each.force)
        told.append(
            {
                "object": each.object, "by": each.striker, "gesture": each.gesture, "id": each.id,
                "start": each.start, "duration": each.duration, "position": each.position,
                "by_position": each.by_position, "speed": each.speed, "velocity": each.velocity, "mass": each.mass,
                "impulse": each.impulse, "peak": each.peak, "gain": float(each.drive.gain[0]),
                "energy": 0.5 * each.mass * each.velocity**2 if free else 0.0,
                "loss": each.impulse * (each.velocity - 0.5 * each.impulse / each.mass) if free else 0.0,
                "striker": _sound_of(performer, each.drive, objects.get(each.object)).about(each.drive, rate),
                "first": each.first, "force_begin": begin, "force_count": len(each.force),
                "path_begin": path, "path_count": moved, "fed": each.drive.fed,
            }
        )  # fmt: skip
        begin += len(each.force)
        path += moved
    return told


def path_of(drive: Drive) -> NDArray[np.float64]:
    """Return where a contact that moves acts, with its gain and its friction: (n, PATH)."""
    friction = drive.friction if len(drive.friction) else np.zeros((len(drive.gain), PATH - 2))
    return np.column_stack([drive.position, drive.gain, friction])


class _Sound(NamedTuple):
    """The sound of a striker, as it is heard on an object: each of its clicks, how many there are, and what rings: with
    its force, or with a second pulse."""

    click: Click
    clicks: int
    ringing: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]
    is_second: bool

    def about(self, drive: Drive, rate: float) -> Truth:
        """Describe the sound in a contact: of clicks and ringing that the force moves, and of second pulses, by their
        times (s) and impulses (N s)."""
        ringing, none = sines(*self.ringing), dict[str, Any](frequency=[], decay=[], gain=[])
        return {
            "clicks": [_click(self.click)] * self.clicks,
            "ringing": none if self.is_second else ringing,
            "second": ringing if self.is_second else none,
            "snaps": [[frame / rate, impulse] for frame, impulse in drive.snaps],
        }


def _sound_of(performer: Performer, drive: Drive, told: Told | None) -> _Sound:
    """Return the sound of a contact's striker on an object, None where that is gone by now; all blows of one striker
    have the same."""
    if drive.sound < 0 or told is None:
        return _SILENT
    key = performer.engine.striker_at(drive.sound), drive.share, drive.ratio, drive.left
    known = told.strikers.get(key)
    if known is None:
        if len(told.strikers) >= _MOST_STRIKERS:
            told.strikers.clear()
        kind, share = performer.engine.state[0]["strikers"][drive.sound], drive.share / AMPLIFIED
        click = Click(
            float(kind["frequency"][0]) / drive.ratio,
            float(kind["sigma"][0]) / drive.ratio,
            float(kind["weight"][0]) * drive.ratio * share * told.gains,
        )
        rings = np.flatnonzero((np.arange(len(kind["frequency"])) >= kind["clicks"]) & (kind["frequency"] > 0.0))
        loud = np.outer(kind["weight"][rings] * share * drive.left, told.gains)
        ringing = kind["frequency"][rings], kind["sigma"][rings], loud
        known = _Sound(click, int(kind["clicks"]) // CLICK_MODES, ringing, bool(kind["momentum"] > 0.0))
        told.strikers[key] = known
    return known


_SILENT = _Sound(Click(0.0, 0.0, np.zeros(0)), 0, _NONE, False)
