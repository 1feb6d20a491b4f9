"""The engine's room, by what it is for: a server and renders have much of it, a page or a game that plays a baked scene
little.

Everything that is imported afterwards is laid out by it, and compiled for it. No size changes a bit of the sound of
what has room.
"""

import os
from typing import NamedTuple

VARIABLE = "CAROM_SIZES"
"""The environment variable that names one of SIZES for a process."""


MOST_COUPLED = 512
"""Modes of a plate that can be coupled."""
MOST_SCATTERED = 3_840
"""Modes of a plate of which some are coupled: others exchange energy with these, up to what is heard."""


class Sizes(NamedTuple):
    """Room of an engine."""

    channels: int = 64
    objects: int = 16_384
    modes: int = 1_310_720
    """A million that are heard, and a quarter more for those beside them: reliefs, clicks, modes that are felt
    alone."""
    phase_modes: int = 163_840
    """The most modes in a phase of the spectral bank: 1.25 of an eighth of a million."""
    stems: int = 512
    """Objects whose shares of the mix can be kept."""
    contacts: int = 512
    """Contacts that can go on at once."""
    directed: int = 1_024
    """Most modes of an object that a contact with a direction acts on."""
    rolls: int = 128
    """Bodies that can roll or slide at once."""
    events: int = 8_192
    """Events that can wait for their time."""
    ring: int = 8_192
    """Commands on their way from Python; a power of two."""
    ramps: int = 4_096
    """Ramps that run or wait; each point of a list is one."""
    strikers: int = 256
    """Kinds of strikers that are kept at once."""
    voices: int = 256
    """Strikers that can sound at once."""
    sheets: int = 64
    """Plates at once whose modes can be coupled."""
    sheet_tables: int = 4_194_304
    """Values of float32 in the tables of all plates' grids: those of 30 different plates of 500 modes."""
    pulse_values: int = 33_554_432
    """Values of float32 in the tables of all swarms' pulses: those of drops and of seven exponents up to 2.5."""
    lines: int = 256
    """Objects that can be in space at once."""
    sensors: int = 32
    ended: int = 32_768
    """Ends of gestures that are kept for Python to read."""
    tap: int = 262_144
    """Frames of sound kept for a recorder that is slow."""
    notes: int = 32_768
    """Fates of commands kept for a log that is slow."""
    traced: int = 1_024
    """Frames for which samples of all contacts are kept for Python to read."""


SIZES = {
    "full": Sizes(),
    "small": Sizes(
        channels=2, objects=256, modes=16_384, phase_modes=2_560, stems=1, contacts=128, directed=384, rolls=16,
        events=3_456, ring=2_048, ramps=256, strikers=96, voices=64, sheets=8, sheet_tables=1_048_576,
        pulse_values=11_534_336, lines=8, sensors=1, ended=1_024, tap=64, notes=64, traced=1,
    ),
}  # fmt: skip
"""Room of all engines of a process, by name."""


def _chosen() -> str:
    """Return the name that VARIABLE holds. ValueError if it is none of them."""
    name = os.environ.get(VARIABLE) or "full"
    if name not in SIZES:
        raise ValueError(f"{VARIABLE} = {name!r}: expected one of {', '.join(SIZES)}")
    return name


NAME = _chosen()
"""The name of this process's sizes."""

CAPACITY = SIZES[NAME]
"""The sizes of this process."""
