"""Common code of the engine's tests: a body, a contact law, and gestures as commands with named values."""

from collections.abc import Collection

import numpy as np

from carom.dsp.bodies import Modes, listed
from carom.dsp.engine.memory.commands import Command, Handle, Kind
from carom.dsp.runtime.engine import NOW, Engine
from carom.dsp.schema import LAW

RATE = 48_000.0

Law = tuple[float, float, float, float]
HARD: Law = (0.01, 1e9, 0.5, 1.5)
"""m (kg), k (N/m^a), mu (s/m), a: about 6 samples at 1 m/s."""

SURFACE = (3e-7, 1e-3, 2.0, 0.0, 1.0, 0.0, 1.0)
"""A profile for bodies that roll."""


def bell(n: int = 24, t60: float = 1.0, modal_mass: float = 10.0) -> Modes:
    """Return a body of n modes that sounds the same wherever it is struck."""
    return listed(
        frequency=np.linspace(300, 15_000, n), t60=np.full(n, t60), modal_mass=modal_mass, mass=10.0, top=20_000
    )  # fmt: skip


def gesture(
    kind: Kind,
    handle: Handle,
    law: Law,
    time: float = NOW,
    number: int = 0,
    by: Handle | None = None,
    given: Collection[str] = (),
    **values: float,
) -> Command:
    """Return a command that brings a striker of a law, in the middle of the object if no position is among the
    values."""
    of_law = {each.name: value for each, value in zip(LAW, law, strict=True)}
    return Command(time, kind, handle, {"position": 0.5, **of_law, **values}, 0.0, number, "", given, by, SURFACE)


def impact(handle: Handle, law: Law = HARD, time: float = NOW, velocity: float = 1.0, **values: float) -> Command:
    """Return an impact that no number is given to, and that no object makes."""
    return gesture("impact", handle, law, time, velocity=velocity, **values)


def strike(
    engine: Engine, handle: Handle, law: Law = HARD, time: float = NOW, velocity: float = 1.0, **values: float
) -> None:
    """Send an impact."""
    engine.send([impact(handle, law, time, velocity, **values)])


def setting(handle: Handle, name: str, value: float, time: float = NOW) -> Command:
    """Return a command that changes a setting of an object, in the engine's units."""
    return Command(time, Kind.SET, handle, value=value, parameter=name)


def steer(number: int, parameter: str, value: float, time: float = NOW) -> Command:
    """Return a command that gives a running gesture's parameter a new value."""
    return Command(time, Kind.STEER, value=value, gesture=number, parameter=parameter)


def stop(number: int, time: float = NOW) -> Command:
    """Return a command that ends a gesture."""
    return Command(time, Kind.STOP, gesture=number)


def free(handle: Handle, at_once: bool, time: float = NOW) -> Command:
    """Return a command that frees an object: at once, or once it is silent."""
    return Command(time, Kind.FREE, handle, value=float(at_once))


def panic(time: float = NOW) -> Command:
    """Return a command that silences everything."""
    return Command(time, Kind.PANIC)


def set_limiter(engine: Engine, on: bool) -> None:
    """Switch the limiter on or off."""
    engine.send([Command(NOW, Kind.LIMITER, value=float(on))])


def active(engine: Engine) -> int:
    """Return the objects that the engine has."""
    return int(engine.objects["used"].sum())


def numbered(engine: Engine) -> list[np.void]:
    """Return the contacts, waiting or touching, of gestures that were given a number."""
    contacts = engine.state["contacts"][0]
    return [contacts[i] for i in np.flatnonzero(contacts["gesture"])]
