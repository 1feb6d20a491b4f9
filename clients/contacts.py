"""Contacts as they were played: when, between whom, and with which force."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..dsp.engine.memory.state import PUSHED, RUBBED, SNAPPED, TRACE, TRACED_MOMENTS


@dataclass(frozen=True)
class Striking:
    """The names in a command for its contacts, empty where there is none, and the mass (kg) that strikes."""

    object: str
    striker: str
    id: str
    gesture: str
    mass: float = 0.0
    by_position: float = 0.0


@dataclass(eq=False)  # not frozen, as it is made in half the time: thousands a second
class Drive:
    """The force of a contact as the modes get it, in each frame from its `first` on.

    moments: (n, 6) N, the force's Legendre moments over the sample that ends there, the mean first. gain: (n,), the
    factor on them. position, (n,): where it acts. friction: (n, 7), of what rubs along the surface: where, and its
    moments (N) with its gain; (0, 7) where nothing does. fed: the force, but not the friction, drives modes by
    one number a frame (dsp/resonator/fed.py). stays: it acts at one place with one gain, and nothing rubs. sound: the
    place of a striker that sounds among the engine's, -1: none; share: of its output; ratio: of its radius to that of
    its kind; left: the share of the force by which its own modes ring. snaps: second pulses of the striker, (frame,
    N s).
    """

    moments: NDArray[np.float64]
    gain: NDArray[np.float64]
    position: NDArray[np.float64]
    friction: NDArray[np.float64]
    fed: bool = False
    stays: bool = True
    sound: int = -1
    share: float = 0.0
    ratio: float = 1.0
    left: float = 1.0
    snaps: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True, eq=False)
class Contact:
    """A contact as it was played. It ends where the two part: a blow on an object that yields may be
    several contacts.

    Attributes
    ----------
    object : str
        Name of the object that was touched.
    striker : str
        Name of the object that touched it (`by`), else empty.
    id : str
        Id of the gesture, else empty.
    gesture : str
        Name of the gesture, such as "impact", "roll" or "rest".
    start : float
        Beginning on the scene's clock, s; it may lie between samples.
    duration : float
        Time until the force, or this sound, ends, s.
    position : float
        0 to 1 on the object's strike path, where it began.
    speed : float
        Speed at which striker and object met, or of a roll or a slide along the surface, m/s.
    velocity : float
        Speed of the striker towards the object, m/s; below 0 where the object caught up with it, 0 for rolls
        and slides.
    mass : float
        Mass of the striker, kg.
    impulse : float
        Impulse that the striker gave the object, N s, without the gesture's `gain`.
    first : int
        First frame of the sound that the force reaches.
    force : array (n,)
        Mean force over the sample that ends with each frame from there on, N. Of a roll it is the excess over its
        weight.
    drive : Drive
        The force in full, as the modes get it.
    by_position : float
        0 to 1 on the striker's strike path, if it is an object.
    """

    object: str
    striker: str
    id: str
    gesture: str
    start: float
    duration: float
    position: float
    speed: float
    velocity: float
    mass: float
    impulse: float
    first: int
    force: NDArray[np.float64] = field(repr=False)
    drive: Drive = field(repr=False)
    by_position: float = 0.0

    @property
    def peak(self) -> float:
        """The largest of the mean forces, N."""
        return float(self.force.max())


def assemble(
    trace: NDArray[np.void], rate: float, start: int, striking: Callable[[int], Striking]
) -> tuple[Contact, ...]:
    """Return the contacts of a trace, by start.

    trace: (n,) of TRACE, of the sound that begins at the sample `start` of a scene; rate: Hz;
    striking: the words of a command, by its number.
    """
    if not len(trace):
        return ()
    numbers, samples = trace["contact"], trace["sample"]
    if np.count_nonzero(numbers[1:] < numbers[:-1]) or np.count_nonzero(samples[1:] < samples[:-1]):
        trace = trace[np.lexsort((samples, numbers))]  # a swarm's are place by place
    table = _Table(trace, rate)
    contacts = [_contact(table, begin, end, start, striking) for begin, end in pairwise(table.borders)]
    return tuple(sorted(contacts, key=lambda contact: contact.start))


_AT = {name: TRACE.fields[name][1] // 8 for name in TRACE.names or ()}  # type: ignore[index]
"""The columns of TRACE by its names: of 8 bytes each, numbers or whole numbers."""

_SAMPLE, _GAIN, _POSITION, _IMPULSE, _KIND = (_AT[name] for name in ("sample", "gain", "position", "impulse", "kind"))
_MOMENTS = slice(_IMPULSE, _IMPULSE + TRACED_MOMENTS)
_PULSE = [_AT["begin"], _IMPULSE]


class _Table:
    """The entries of a trace as a table: a field of records takes as long as many columns."""

    def __init__(self, trace: NDArray[np.void], rate: float) -> None:
        self._trace = trace
        self.numbers: NDArray[np.float64] = trace.view(np.float64).reshape(len(trace), -1)
        self.whole: NDArray[np.int64] = self.numbers.view(np.int64)
        self.rate = rate
        self.forces = self.numbers[:, _MOMENTS] * rate + 0.0  # N: as is added to zeros, no -0
        self.gain, self.position = self.numbers[:, _GAIN].copy(), self.numbers[:, _POSITION].copy()
        contact, sample = self.whole[:, _AT["contact"]], self.whole[:, _SAMPLE]
        begins = contact[1:] != contact[:-1]
        self.borders = [0, *(place + 1 for place in begins.nonzero()[0].tolist()), len(trace)]
        """Places between contacts."""
        self.is_plain = bool(
            _is_steady(self.position)
            and _is_steady(self.whole[:, _GAIN:])  # what follows the force: its gain, and what it does
            and self.whole[0, _KIND] == PUSHED
            and np.count_nonzero(begins | (sample[1:] - sample[:-1] == 1)) == len(begins)
        )
        """True if all of it presses alike at one place, sample by sample."""

    def entry(self, place: int) -> dict[str, Any]:
        """Return an entry by its names."""
        return dict(zip(_AT, self._trace[place].item(), strict=True))


def _contact(table: _Table, begin: int, end: int, start: int, striking: Callable[[int], Striking]) -> Contact:
    """Return the contact of a table's entries from one up to another."""
    pressing: _Places = slice(begin, end)
    others, first, last = _NONE, begin, end - 1
    if not table.is_plain and np.count_nonzero(pushed := table.whole[pressing, _KIND] == PUSHED) < end - begin:
        pressing, others = begin + np.flatnonzero(pushed), begin + np.flatnonzero(~pushed)
        if len(pressing):  # else friction alone, or a second pulse
            first, last = int(pressing[0]), int(pressing[-1])
    begun = table.entry(first)
    drive = _drive(table, pressing, others, begun, last, start)
    said = striking(begun["command"])
    return Contact(
        said.object, said.striker, said.id, said.gesture,
        start=begun["begin"] / table.rate,
        duration=(table.numbers[last, _AT["end"]].item() - begun["begin"]) / table.rate,
        position=begun["position"],
        speed=begun["speed"],
        velocity=begun["velocity"],
        mass=said.mass,
        impulse=np.add.reduce(table.numbers[pressing, _IMPULSE]).item(),
        first=begun["sample"] + 1 - start,
        force=drive.moments[:, 0],
        drive=drive,
        by_position=said.by_position,
    )  # fmt: skip


_Places = slice | NDArray[np.intp]
_NONE = np.zeros(0, np.intp)


def _drive(
    table: _Table, pressing: _Places, others: NDArray[np.intp], begun: Mapping[str, Any], last: int, start: int
) -> Drive:
    """Return the force of a contact, by the places of its entries that press and of all others, the entry with which it
    begins, and the place of the last that presses; entries that lack are samples without one, where nothing else
    changes."""
    if table.is_plain:
        sounding = begun if begun["sound"] >= 0 else _SILENT
        return Drive(
            table.forces[pressing], table.gain[pressing], table.position[pressing], _NO_FRICTION, bool(begun["fed"]),
            sound=sounding["sound"], share=sounding["share"], ratio=sounding["ratio"], left=sounding["left"],
        )  # fmt: skip
    whole, first, end = table.whole, begun["sample"], table.whole[last, _SAMPLE].item()
    rubbed = snapped = _NONE
    if len(others):
        rubbed, snapped = (others[whole[others, _AT["kind"]] == kind] for kind in (RUBBED, SNAPPED))
        end = max([end, *whole[rubbed[-1:], _SAMPLE].tolist()])
    at = whole[pressing, _SAMPLE] - first
    own = pressing if len(at) else others
    sounding = begun
    if begun["sound"] < 0:
        sounds = np.flatnonzero(whole[own, _AT["sound"]] >= 0)
        sounding = table.entry(int(np.arange(len(whole))[own][sounds[0]])) if len(sounds) else _SILENT
    size, moments = end - first + 1, table.forces[pressing]
    gain, position = table.gain[pressing], table.position[pressing]
    stays = not len(rubbed) and _is_steady(gain) and _is_steady(position)
    if len(at) != size or np.count_nonzero(at == np.arange(size)) < size:  # several of a sample, or none
        moments = np.zeros((size, TRACED_MOMENTS))
        np.add.at(moments, at, table.forces[pressing])
        gain, position = _between(at, gain, size, 1.0), _between(at, position, size, begun["position"])
    return Drive(
        moments,
        gain,
        position,
        _friction(table, rubbed[whole[rubbed, _SAMPLE] >= first], first, size) if len(rubbed) else _NO_FRICTION,
        bool(np.count_nonzero(whole[own, _AT["fed"]])),
        stays=stays,
        sound=sounding["sound"],
        share=sounding["share"],
        ratio=sounding["ratio"],
        left=sounding["left"],
        snaps=_snaps(table, snapped, start) if len(snapped) else (),
    )


_SILENT: Mapping[str, Any] = {"sound": -1, "share": 0.0, "ratio": 1.0, "left": 1.0}
_NO_FRICTION = np.zeros((0, 1 + TRACED_MOMENTS))


def _snaps(table: _Table, snapped: NDArray[np.intp], start: int) -> tuple[tuple[float, float], ...]:
    """Return the frames and impulses (N s) of second pulses."""
    return tuple((begin - start, impulse) for begin, impulse in table.numbers[snapped][:, _PULSE].tolist())


def _friction(table: _Table, rubbed: NDArray[np.intp], first: int, size: int) -> NDArray[np.float64]:
    """Return where friction acts, and its moments (N) with its gain, (size, 7), by frames from `first` on."""
    friction = np.zeros((size, 1 + TRACED_MOMENTS))
    numbers = table.numbers[rubbed]
    moments = (numbers[:, _GAIN] * table.rate)[:, None] * numbers[:, _MOMENTS]
    friction[table.whole[rubbed, _SAMPLE] - first] = np.column_stack((numbers[:, _POSITION], moments))
    return friction


def _is_steady(known: NDArray[np.float64] | NDArray[np.int64]) -> bool:
    """True if values are all the same."""
    return not np.count_nonzero(known != known[:1])


def _between(at: NDArray[np.int64], known: NDArray[np.float64], size: int, usual: float) -> NDArray[np.float64]:
    """Return values by frame (size,), known at some frames, and between these along lines; `usual` if at none."""
    if _is_steady(known):
        return np.full(size, known[0] if len(at) else usual)
    return np.interp(np.arange(size), at, known)
