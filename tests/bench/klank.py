"""scsynth's Klank, the resonator bank that Carom is measured against: a synth of many modes, rendered offline."""

import shutil
import struct
import subprocess
from pathlib import Path

import numpy as np

from carom.server.osc.wire import Message, encode_bundle

SCSYNTH = shutil.which("scsynth")

_SCALAR, _AUDIO = 0, 2  # rates of unit generators


def render(folder: Path, modes: int, seconds: int, rate: int) -> None:
    """Render a mono Klank of so many modes by scsynth, struck four times a second; `folder` is for its files."""
    definition = folder / "klank.scsyndef"
    definition.write_bytes(_definition(modes))
    score = folder / "score.osc"
    start = encode_bundle(0, [Message("/d_load", (str(definition),)), Message("/s_new", ("klank", 1, 0, 0))])
    end = encode_bundle(seconds << 32, [Message("/c_set", (0, 0))])
    score.write_bytes(b"".join(struct.pack(">i", len(bundle)) + bundle for bundle in (start, end)))
    command = [SCSYNTH, "-N", score, "_", folder / "out.wav", str(rate), "WAV", "int16", "-o", "1", "-i", "0"]
    subprocess.run([str(part) for part in command], check=True, capture_output=True)


def _definition(modes: int) -> bytes:
    """Return A SynthDef file (version 2): Out(0, Klank(Impulse(4), specs))."""
    table = np.column_stack((np.linspace(100, 15000, modes), np.full(modes, 1e-4), np.full(modes, 60.0)))
    constants = [0.0, 1.0, 4.0, *table.flat]  # of a Klank: frequency, amplitude, ring time, mode by mode
    zero, one, four = ((-1, n) for n in range(3))
    specs = [(-1, n) for n in range(3, len(constants))]
    units = [
        _unit("Impulse", _AUDIO, [four, zero], 1),
        _unit("Klank", _AUDIO, [(0, 0), one, zero, one, *specs], 1),
        _unit("Out", _AUDIO, [zero, (1, 0)], 0),
    ]
    return b"".join((
        b"SCgf", struct.pack(">ih", 2, 1), _pascal("klank"),
        struct.pack(f">i{len(constants)}f", len(constants), *constants),
        struct.pack(">iii", 0, 0, len(units)), *units, struct.pack(">h", 0),
    ))  # fmt: skip


def _unit(name: str, rate: int, inputs: list[tuple[int, int]], outputs: int) -> bytes:
    head = _pascal(name) + struct.pack(">biih", rate, len(inputs), outputs, 0)
    return head + b"".join(struct.pack(">ii", *i) for i in inputs) + bytes([rate] * outputs)


def _pascal(text: str) -> bytes:
    return bytes([len(text)]) + text.encode()
