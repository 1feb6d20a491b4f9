"""Each object's share of the sound, quantum by quantum."""

import numpy as np
from numpy.typing import NDArray


class Stems:
    """The shares of objects in a record of STATE, where they are kept. Call `process` quantum by quantum."""

    def __init__(self, record: np.void) -> None:
        self._output = record["output"]

    def keep(self, on: bool) -> None:
        """Keep each object's share from here on, or no more."""
        self._output["stems_on"] = on

    def shares(self) -> NDArray[np.float64]:
        """Return (STEMS, channels, QUANTUM) by slot: each object's share of the quantum that left last, before the
        limiter. It is a view."""
        shares: NDArray[np.float64] = self._output["stems"][self._turn, :, : self._output["channels"]]
        return shares

    def sounding(self) -> list[int]:
        """Return the slots whose shares are not silent."""
        sounding: list[int] = np.flatnonzero(self._output["stem_sounds"][self._turn]).tolist()
        return sounding

    @property
    def _turn(self) -> int:
        """Index of the one of two quanta that left last: a limiter keeps it back by one."""
        return int(self._output["turn"]) ^ int(self._output["delay"] > 0)
