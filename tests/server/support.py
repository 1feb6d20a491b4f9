"""Common code of the tests of the live server."""

from pathlib import Path

import numpy as np
import soundfile

from carom.server.osc import wire


def onsets(path: Path) -> int:
    """Find the strikes in a recording: rises out of silence, by 20 ms."""
    sound, _ = soundfile.read(path)
    level = np.abs(sound).max(axis=1)
    blocks = level[: len(level) // 960 * 960].reshape(-1, 960).max(axis=1)
    loud = blocks > 1e-3
    return int((loud[1:] & ~loud[:-1]).sum())


def counted(status: wire.Message) -> dict[str, float]:
    return dict(zip(status.args[9::2], status.args[10::2], strict=True))
