"""The kinds of strikers that sound, in the engine's memory: each is laid out once, and found again by what it is."""

import math
from collections import OrderedDict
from functools import lru_cache

import numpy as np

from ..bodies.striker import Snap, StrikerSound
from ..engine.memory.striker_state import STRIKER, STRIKERS
from ..native.addresses import as_bytes
from ..resonator.simd import LANES
from ..resonator.sizes import CLICK_MODES


class Strikers:
    """The places of strikers that sound in a record of STATE.

    Where all are taken one that moves in no gesture makes room: the one that was requested least recently; where all
    move, it is that of all. Its gestures are then silent strikers; those that still wait for their time are counted.
    """

    def __init__(self, record: np.void, top: float) -> None:
        """Prepare the places of `record`; modes above `top` (Hz) are left out."""
        self._places = record["strikers"]
        self._bytes = as_bytes(self._places)
        self._moving, self._since = record["contacts"]["sound"], record["last_command"]
        self._top = top
        self.forget()

    def forget(self) -> None:
        """Begin anew, as in memory that is as it was at first."""
        self._known: OrderedDict[StrikerSound, dict[str, float]] = OrderedDict()
        self._sounds: dict[int, StrikerSound] = {}
        self._serial = 0

    def lay_out(self, sound: StrikerSound) -> dict[str, float]:
        """Lay a striker's sound out; return its place and serial."""
        if laid := self._known.get(sound):
            self._known.move_to_end(sound)
            return laid
        place = len(self._known)
        if place == STRIKERS:
            place = self._make_room()
        self._serial += 1
        self._write(place, sound)
        self._sounds[place] = sound
        laid = self._known[sound] = {"sound": place, "sound_serial": self._serial}
        return laid

    def _make_room(self) -> int:
        """Forget a striker; return its place."""
        moving = set(self._moving[self._since > 0].tolist())
        still = (sound for sound, laid in self._known.items() if laid["sound"] not in moving)
        return int(self._known.pop(next(still, next(iter(self._known))))["sound"])

    def at(self, place: int) -> StrikerSound | None:
        """Return the sound that is laid out at a place; None where there is none."""
        return self._sounds.get(place)

    def _write(self, place: int, sound: StrikerSound) -> None:
        self._places["serial"][place] = 0  # nobody takes what is half written
        self._bytes[place] = _laid(sound, self._top)
        self._places["serial"][place] = self._serial


@lru_cache(maxsize=64)
def _laid(sound: StrikerSound, top: float) -> np.void:
    """Return the bytes of a striker, of STRIKER, with its modes up to `top` (Hz), and no serial yet; read-only."""
    modes: list[tuple[float, ...]] = [sound.click[:3]] * CLICK_MODES if sound.click else []
    if sound.ringing:
        each = zip(sound.ringing.frequency, sound.ringing.decay, sound.ringing.weight, strict=True)
        modes += [mode for mode in each if mode[0] <= top]
    made = np.zeros(1, STRIKER)
    entry = made[0]
    entry["clicks"] = CLICK_MODES if sound.click else 0
    columns = np.reshape(modes, (-1, 3)).T
    for name, column in zip(("frequency", "sigma", "weight"), columns, strict=True):
        entry[name][: len(modes)] = column
    entry["weight"] *= sound.mass
    entry["size"] = max(1, math.ceil(len(modes) / LANES)) * LANES
    entry["radius"] = sound.radius
    snap = sound.snap or Snap(0.0, 1.0, 0.0, 0.0)
    entry["momentum"], entry["exponent"], entry["scatter"], entry["delay"] = (
        snap.momentum, snap.exponent, snap.scatter, snap.delay,
    )  # fmt: skip
    bends = sound.ringing.frequency if sound.ringing else ()
    entry["bends"], entry["bend"][: len(bends)] = len(bends), bends
    entry["mobility"] = sound.ringing.mobility * sound.mass if sound.ringing else 1.0
    made.flags.writeable = False
    laid: np.void = as_bytes(made)[0]
    return laid
