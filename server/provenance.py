"""By what a sound was computed: the machine code, its processor, numpy and scipy decide over a sound's last bits."""

import re
from importlib.metadata import version
from pathlib import Path

from ..dsp.native.code import Code
from ..dsp.runtime.engine import Engine

_IN_A_LOG = re.compile(r"# carom .*; (code \S+ for \S+, numpy \S+, scipy \S+); ")


def computed_by(engine: Engine) -> str:
    """What computes an engine's sound, in words."""
    found = computing(engine.code)
    return f"code {found['code']} for {found['processor']}, numpy {found['numpy']}, scipy {found['scipy']}"


def computing(code: Code) -> dict[str, str]:
    """What computes the sound of engines that run some machine code, by name."""
    libraries = {name: version(name) for name in ("numpy", "scipy")}
    return {"code": code.key, "processor": code.processor, **libraries}


def logged_otherwise(score: Path, engine: Engine) -> str | None:
    """What to warn of where a score is a log, and something else computed its sound; None where nothing is to be said.

    OSError if the score cannot be read.
    """
    with score.open("rb") as file:
        found = _IN_A_LOG.match(file.readline(1_000).decode(errors="replace"))
    if found is None or found[1] == computed_by(engine):
        return None
    return f"{score} was logged by {found[1]}, and is rendered by {computed_by(engine)}: its last bits may differ"
