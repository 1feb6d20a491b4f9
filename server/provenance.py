"""The provenance of a sound: the machine code, its processor and numpy decide its last bits."""

import re
from importlib.metadata import version
from pathlib import Path

from ..dsp.native.code import Code
from ..dsp.runtime.engine import Engine

_IN_A_LOG = re.compile(r"# carom .*; (code \S+ for \S+, numpy [^;]+); ")


def computed_by(engine: Engine) -> str:
    """Say in words what computes an engine's sound."""
    found = computing(engine.code)
    return f"code {found['code']} for {found['processor']}, numpy {found['numpy']}"


def computing(code: Code) -> dict[str, str]:
    """Return what computes the sound of engines that run some machine code, by name."""
    return {"code": code.key, "processor": code.processor, "numpy": version("numpy")}


def logged_otherwise(score: Path, engine: Engine) -> str | None:
    """Return the warning for a score that is a log of a sound which something else computed; None if there is nothing
    to warn of.

    OSError if the score cannot be read.
    """
    with score.open("rb") as file:
        found = _IN_A_LOG.match(file.readline(1_000).decode(errors="replace"))
    if found is None or found[1] == computed_by(engine):
        return None
    return f"{score} was logged by {found[1]}, and is rendered by {computed_by(engine)}: its last bits may differ"
