"""The tables of swarms' pulses in the engine's memory: one for each exponent of a contact law, and one for drops."""

import numpy as np

from ..swarm.record import PULSES, TABLE
from ..swarm.tables import is_made, pulse_table
from .arena import EngineFull

DROPS = 0.0
"""The place of drops among exponents, which are 1 at least."""


class PulseTables:
    """The tables in a record of STATE. Each is made when it is first asked for, within a second, and stays."""

    def __init__(self, record: np.void) -> None:
        self._record = record["pulses"]
        self._numbers: dict[float, int] = {}
        self._taken = 0

    def lay_out(self, exponent: float) -> dict[str, float]:
        """Return the value `pulses` for a contact law's exponent, or DROPS. EngineFull if there is no room."""
        if exponent not in self._numbers:
            self._numbers[exponent] = self._write(exponent)
        return {"pulses": self._numbers[exponent]}

    @property
    def numbers(self) -> dict[float, int]:
        """The value `pulses` of each exponent that has a table."""
        return dict(self._numbers)

    @property
    def taken(self) -> int:
        """Values that tables take."""
        return self._taken

    def lacks(self, exponent: float) -> bool:
        """True if there is room for the table of an exponent, which is not made."""
        return exponent not in self._numbers and len(self._numbers) < PULSES and not is_made(exponent)

    def _write(self, exponent: float) -> int:
        place = len(self._numbers)
        if place == PULSES:
            raise EngineFull(f"no room for swarms of exponent {exponent:g}: there are {PULSES - 1} others, and drops")
        table = pulse_table(exponent)
        size = len(table.values)
        if self._taken + size > TABLE:
            raise EngineFull(f"no room for swarms of exponent {exponent:g}: their pulses take {size} values")
        entry = self._record["tables"]
        entry[place : place + 1] = table.record
        entry[place]["first"] += self._taken
        self._record["values"][self._taken : self._taken + size] = table.values
        self._taken += size
        return place + 1
