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


@dataclass(frozen=True, eq=False)
class Drive:
    """The force of a contact as the modes get it, in each frame from its `first` on.

    moments: (n, 6) N, the force's Legendre moments over the sample that ends there, the mean first. gain: (n,), the
    factor on them. position, (n,): where it acts. friction: (n, 7), of what rubs along the surface: where, and its
    moments (N) with its gain; (0, 7) where nothing does. fed: the force, but not the friction, drives modes by
    one number a frame (dsp/resonator/fed.py). stays: it acts at one place with one gain, and nothing rubs. sound: the
    place of a striker that sounds among the engine's, -1: none; share: of its output; ratio: of its radius to that of
    its kind. snaps: second pulses of the striker, (frame, N s).
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
    snaps: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True, eq=False)
class Contact:
    """A contact as it was played.

    object: the name of the object touched; striker: that of the object that touched it (its key `by`), else empty;
    id: the gesture's `id`, else empty; gesture: impact, bounce, roll, press, spin or slide.
    start: s on the scene's clock, between samples as it falls; duration: s until the force ends; both as far as this
    sound goes: a contact that outlasts it goes on in the next one.
    position: 0 to 1 on the object's strike path, where it began. speed: m/s at which striker and object met; of a roll
    or a slide, along the surface. velocity: m/s of the striker then, towards the object: below 0 where it was leaving,
    and the object caught up with it; of a roll or a slide 0. mass: kg, of the striker.
    impulse: N s that the striker gave the object. A gesture's `gain` makes it louder, and is not in here.
    first: the first frame of the sound that the force reaches; force: (n,) N, its mean over the sample that ends with
    each frame from there on; drive: the force in full, as the modes get it.

    A contact ends where the two part, be it for a microsecond: where they meet again, another one begins. So a blow on
    an object that gives way may be several contacts, whose impulses add up to what the striker loses; so may a press. A
    roll or a slide is one contact, hops and all; a roll's force is the excess over its weight, so that its sum tends to
    0.
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
    """0 to 1 on the striker's own strike path, if it is an object."""

    @property
    def peak(self) -> float:
        """The largest of the mean forces, N."""
        return float(self.force.max())


def assemble(
    trace: NDArray[np.void], rate: float, start: int, striking: Callable[[int], Striking]
) -> tuple[Contact, ...]:
    """Return the contacts of a trace, by start.

    trace: (n,) of TRACE, of the sound that begins at the sample `start` of a scene; rate: Hz; striking: what a command
    (by number) said.
    """
    numbers, samples = trace["contact"], trace["sample"]
    if (numbers[1:] < numbers[:-1]).any() or (samples[1:] < samples[:-1]).any():  # a swarm's are place by place
        order = np.lexsort((samples, numbers))
        trace, numbers = trace[order], numbers[order]
    begins = [0, *(np.flatnonzero(numbers[1:] != numbers[:-1]) + 1).tolist(), len(trace)]
    runs = [trace[begin:end] for begin, end in pairwise(begins) if begin < end]
    contacts = [_contact(run, rate, start, striking(int(run["command"][0]))) for run in runs]
    return tuple(sorted(contacts, key=lambda contact: contact.start))


def _contact(run: NDArray[np.void], rate: float, start: int, striking: Striking) -> Contact:
    pushes = run["kind"] == PUSHED
    pressing = run if pushes.all() else run[pushes]
    pushed = pressing if len(pressing) else run  # else friction alone, or a second pulse
    begun, last = _entry(pushed, 0), _entry(pushed, -1)
    drive = _drive(run, pushed, pressing, rate, start)
    return Contact(
        striking.object, striking.striker, striking.id, striking.gesture,
        start=begun["begin"] / rate,
        duration=(last["end"] - begun["begin"]) / rate,
        position=begun["position"],
        speed=begun["speed"],
        velocity=begun["velocity"],
        mass=striking.mass,
        impulse=float(pressing["impulse"].sum()) if len(pressing) else 0.0,
        first=begun["sample"] + 1 - start,
        force=drive.moments[:, 0],
        drive=drive,
        by_position=striking.by_position,
    )  # fmt: skip


def _entry(entries: NDArray[np.void], place: int) -> dict[str, Any]:
    """Return an entry of TRACE by its names: at once, as each of an array's records takes as long as all of one."""
    return dict(zip(TRACE.names or (), entries[place].item(), strict=True))


def _drive(
    run: NDArray[np.void], pushed: NDArray[np.void], pressing: NDArray[np.void], rate: float, start: int
) -> Drive:
    """Return the force of a contact; entries that lack are samples without one, where nothing else changes."""
    first, last = int(pushed["sample"][0]), int(pushed["sample"][-1])
    rubbed, snapped = run[:0], run[:0]
    if pressing is not run:
        kinds = run["kind"]
        rubbed, snapped = run[kinds == RUBBED], run[kinds == SNAPPED]
        last = max(last, int(rubbed["sample"][-1])) if len(rubbed) else last
    size, at = last - first + 1, pressing["sample"] - first
    sounds = pushed["sound"] >= 0
    known = _entry(pushed, int(sounds.argmax())) if sounds.any() else _SILENT
    gain, is_loud = _between(at, pressing["gain"], size, 1.0)
    position, is_there = _between(at, pressing["position"], size, float(pushed["position"][0]))
    return Drive(
        _moments(pressing, at, size, rate),
        gain,
        position,
        _friction(rubbed[rubbed["sample"] >= first], first, size, rate) if len(rubbed) else _NO_FRICTION,
        bool(pushed["fed"].any()),
        stays=is_loud and is_there and not len(rubbed),
        sound=known["sound"],
        share=known["share"],
        ratio=known["ratio"],
        snaps=tuple((float(each["begin"]) - start, float(each["impulse"])) for each in snapped),
    )


_SILENT: Mapping[str, Any] = {"sound": -1, "share": 0.0, "ratio": 1.0}


def _moments(pressing: NDArray[np.void], at: NDArray[np.int64], size: int, rate: float) -> NDArray[np.float64]:
    """Return the moments (size, 6) of what presses, by frames; several entries of one add up."""
    columns = pressing.view(np.float64).reshape(len(pressing), -1)
    forces = columns[:, _IMPULSE : _IMPULSE + TRACED_MOMENTS] * rate
    if len(at) == size and (at == np.arange(size)).all():
        return forces + 0.0  # as is added to zeros: no -0
    moments = np.zeros((size, TRACED_MOMENTS))
    np.add.at(moments, at, forces)
    return moments


_IMPULSE = TRACE.fields["impulse"][1] // 8  # type: ignore[index]
"""The first of an entry's columns of 8 bytes that hold its moments: the impulse, then `moments`."""


_NO_FRICTION = np.zeros((0, 1 + TRACED_MOMENTS))


def _friction(rubbed: NDArray[np.void], first: int, size: int, rate: float) -> NDArray[np.float64]:
    """Return where friction acts, and its moments (N) with its gain, (size, 7), by frames from `first` on."""
    friction = np.zeros((size, 1 + TRACED_MOMENTS))
    scale = rubbed["gain"] * rate
    columns = rubbed["position"], scale * rubbed["impulse"], scale[:, None] * rubbed["moments"]
    friction[rubbed["sample"] - first] = np.column_stack(columns)
    return friction


def _between(
    at: NDArray[np.int64], known: NDArray[np.float64], size: int, usual: float
) -> tuple[NDArray[np.float64], bool]:
    """Return values by frame (size,), known at some frames, and between these along lines; `usual` if at none; and
    whether they are all the same."""
    value = known[0] if len(at) else usual
    if (known == value).all():
        found = np.empty(size)
        found.fill(value)
        return found, True
    return np.interp(np.arange(size), at, known), False
