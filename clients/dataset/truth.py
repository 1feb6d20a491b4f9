"""The truth about a clip's objects and contacts: numbers, words, and lists of these."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...dsp.bodies.modes import Modes
from ...dsp.engine.memory.records import SLID
from ...dsp.engine.memory.state import QUANTUM, TRACED_MOMENTS
from ...dsp.kept import Kept
from ...dsp.resonator.bank import top_of
from ...dsp.resonator.simd import LANES
from ...dsp.resonator.sizes import CLICK_MODES
from ...dsp.schema import GESTURES
from ..contacts import Contact, Drive
from ..modes import Click, Places, mode_table, places_of
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
        """True if an object rang on as it was made, through no panic, and was never heard from a place in space."""
        settings = {each.settings for each in self._seen.get(serial, ())}
        return serial not in self._in_space | self._panicked and len(settings) <= 1

    def all_in(self, serials: Iterable[int]) -> bool:
        """True if no object was there but these."""
        return self._seen.keys() <= set(serials)


def about_object(
    performer: Performer, rate: int, frames: int, name: str, touched: float | None, moves: bool, followed: Followed
) -> Truth:
    """Describe an object: what it is, and the modes that a blow where it is touched excites; empty where it came too
    late. moves: it is touched elsewhere, too."""
    placed = performer.placed(name)
    heard = performer.heard(placed)
    if heard is None:
        return {}
    settings, gains = heard
    preset, serial = performer.scene.objects[name].preset, placed.handle.serial
    position = placed.position if touched is None else touched
    level = placed.level / AMPLIFIED
    table = mode_table(placed.modes, level, settings, gains, position, rate)
    relief = table.relief
    bends = placed.modes.glide > 0.0 or placed.modes.sheet is not None
    made = int(np.count_nonzero(placed.modes.frequency <= top_of.py_func(rate)))
    return {
        "name": name,
        "preset": preset.name,
        "shape": preset.shape,
        "material": preset.material.name if preset.material else "",
        "mass": placed.modes.mass,
        "position": position,
        "linear": not bends and followed.stayed(serial) and name not in performer.off_path,
        "by_moments": _by_moments(placed.modes, settings.tune, rate),
        "rubbed_relief": max(min(SLID - made, len(relief.frequencies) if relief else 0), 0),
        "rubbed_clicks": len(table.clicks) if made + CLICK_ROOM <= SLID else 0,
        "modes": sines(table.frequencies, table.decays, table.gains),
        "clicks": [_click(each) for each in table.clicks],
        "relief": sines(relief.frequencies, relief.decays, relief.gains) if relief else sines(*_NONE),
        "places": _places(places_of(placed.modes, level, settings, gains, rate)) if moves else {},
        "fades": followed.fades(serial, gains, -(-frames // QUANTUM)),
        "bends": followed.bends(serial, gains, -(-frames // QUANTUM)),
    }


def _by_moments(modes: Modes, tune: float, rate: int) -> list[int]:
    """Return which of the modes in its table even a contact that is fed drives by moments: those beyond whole lanes, as
    the engine lays them out by their decays."""
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
    heard = np.flatnonzero((modes.frequency <= top) & (modes.frequency * tune <= top))
    found: list[int] = np.flatnonzero(np.isin(heard, order[len(order) // LANES * LANES :])).tolist()
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


def about_contacts(performer: Performer, contacts: Iterable[Contact]) -> list[Mapping[str, Any]]:
    """Describe contacts; where their forces begin among all forces, and their paths among all paths, and how many they
    are."""
    told: list[Mapping[str, Any]] = []
    begin = path = 0
    strikers = _Strikers(performer)
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
                "striker": strikers.about(each),
                "first": each.first, "force_begin": begin, "force_count": len(each.force),
                "path_begin": path, "path_count": moved, "fed": each.drive.fed,
            }
        )  # fmt: skip
        begin += len(each.force)
        path += moved
    return told


def path_of(drive: Drive) -> NDArray[np.float64]:
    """Return where a contact that moves acts, with its gain and its friction: (n, PATH), n = 0 where it stays."""
    if drive.stays:
        return np.zeros((0, PATH))
    friction = drive.friction if len(drive.friction) else np.zeros((len(drive.gain), PATH - 2))
    return np.column_stack([drive.position, drive.gain, friction])


class _Strikers:
    """The sound of contacts' strikers, as it is heard on the object: of clicks and ringing that their force moves, and
    of a second pulse, by its times (s) and impulses (N s)."""

    def __init__(self, performer: Performer) -> None:
        self._performer = performer
        self._known: dict[tuple[str, int, float, float], Truth] = {}

    def about(self, contact: Contact) -> Truth:
        """Describe the sound of a contact's striker."""
        drive, rate = contact.drive, self._performer.engine.rate
        key = contact.object, drive.sound, drive.share, drive.ratio
        if key not in self._known:
            self._known[key] = self._sound(contact)
        return {**self._known[key], "snaps": [[frame / rate, impulse] for frame, impulse in drive.snaps]}

    def _sound(self, contact: Contact) -> Truth:
        """Describe what does not differ between the blows of one striker on one object."""
        performer, drive = self._performer, contact.drive
        there = drive.sound >= 0 and contact.object in performer.scene.objects  # it may be gone by now
        heard = performer.heard(performer.placed(contact.object)) if there else None
        if heard is None:
            return {"clicks": [], "ringing": sines(*_NONE), "second": sines(*_NONE)}
        kind, gains = performer.engine.state[0]["strikers"][drive.sound], heard[1]
        share = drive.share / AMPLIFIED
        click = {
            "frequency": float(kind["frequency"][0]) / drive.ratio,
            "decay": float(kind["sigma"][0]) / drive.ratio,
            "gain": (float(kind["weight"][0]) * drive.ratio * share * gains).tolist(),
        }
        rings = np.flatnonzero((np.arange(len(kind["frequency"])) >= kind["clicks"]) & (kind["frequency"] > 0.0))
        weights = np.outer(kind["weight"][rings] * share, gains)
        ringing = sines(kind["frequency"][rings], kind["sigma"][rings], weights)
        return {
            "clicks": [click] * (int(kind["clicks"]) // CLICK_MODES),
            "ringing": sines(*_NONE) if kind["momentum"] > 0.0 else ringing,
            "second": ringing if kind["momentum"] > 0.0 else sines(*_NONE),
        }
