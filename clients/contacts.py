"""Contacts as they were played: when, between whom, and with which force."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Striking:
    """The names in a command for its contacts, empty where there is none, and the mass (kg) that strikes."""

    object: str
    striker: str
    id: str
    gesture: str
    mass: float = 0.0


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
    each frame from there on.

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
    order = np.argsort(trace["contact"], kind="stable")
    places = np.flatnonzero(np.diff(trace["contact"][order])) + 1
    runs = [run for run in np.split(trace[order], places) if len(run)]
    contacts = [_contact(run, rate, start, striking(int(run["command"][0]))) for run in runs]
    return tuple(sorted(contacts, key=lambda contact: contact.start))


def _contact(run: NDArray[np.void], rate: float, start: int, striking: Striking) -> Contact:
    first = int(run["sample"][0])
    force = np.zeros(int(run["sample"][-1]) - first + 1)
    force[run["sample"] - first] = run["impulse"] * rate  # a roll's may be 0 meanwhile, without an entry
    return Contact(
        striking.object, striking.striker, striking.id, striking.gesture,
        start=float(run["begin"][0]) / rate,
        duration=float(run["end"][-1] - run["begin"][0]) / rate,
        position=float(run["position"][0]),
        speed=float(run["speed"][0]),
        velocity=float(run["velocity"][0]),
        mass=striking.mass,
        impulse=float(run["impulse"].sum()),
        first=first + 1 - start,
        force=force,
    )  # fmt: skip
