"""What pyproject.toml cannot say: a wheel holds machine code of the functions that Carom compiles."""

import os
import subprocess
import sys
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

COMPILED = (
    "carom.dsp.native.atomics",
    "carom.dsp.native.system",
    "carom.dsp.contact.law",
    "carom.dsp.contact.pulse",
    "carom.dsp.rolling.surface",
    "carom.dsp.swarm.making",
    "carom.dsp.runtime.callback",
    "carom.dsp.runtime.handover",
    "carom.dsp.runtime.jobs",
    "carom.dsp.runtime.pacer",
    "carom.server.bridge.mujoco.track",
    "carom.server.bridge.telling",
    "carom.server.net.udp",
)
"""The modules that define functions of C."""

TARGETS = {
    "everywhere": "targets.WHEEL",  # all systems: takes minutes more
    "family": "targets.built()",  # this system, and all processors of this one's family
    "machine": "targets.targets()[:1]",  # this processor alone: what plays here has compiled it already
    "source": "",  # none
}
"""What the environment variable CAROM_WHEEL may say, and the targets whose code the wheel holds for it."""

BUILD = """
import sys
from carom.dsp.native import compiling, store, targets
compiling.build(sys.argv[1:], {targets}, store.PACKAGED)
"""


PACK = """
import sys
from carom.clients.export import c
from carom.dsp import sizes
from carom.dsp.native import compiling, store, targets, wasm
from carom.dsp.runtime import callback
exports = sizes.NAME == "small"
wanted = compiling.portable(targets.built()[:1] if exports else targets.built())
files = [c.engine_file(), wasm.object_file(callback.__name__)] if exports else []
compiling.pack(sys.argv[1:], wanted, files, store.PACKAGED)
"""
"""Packs portable code for this system, and processors of this one's family: of the engine that plays here, or of that
of exports, with what these are made of."""

PORTABLE = ("everywhere", "family")
"""For which of TARGETS a wheel holds portable code, too."""


class BuildWithCode(build_py):
    """Copies the package, and has the copy compile itself, which takes long where no code of it is cached."""

    def run(self) -> None:
        super().run()
        asked = os.environ.get("CAROM_WHEEL", "family")
        if asked not in TARGETS:
            raise ValueError(f"CAROM_WHEEL = {asked!r}: expected one of {', '.join(TARGETS)}")
        if TARGETS[asked] and not self.editable_mode:
            # A front end that builds apart from what is installed, as pip does, says in PYTHONPATH where numba is.
            paths = [str(Path(self.build_lib).resolve()), os.environ.get("PYTHONPATH")]
            environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}
            subprocess.run(
                [sys.executable, "-c", BUILD.format(targets=TARGETS[asked]), *COMPILED],
                env=environment, cwd=self.build_lib, check=True,
            )  # fmt: skip
            for sizes in ("full", "small") if asked in PORTABLE else ():
                own = environment | {"CAROM_SIZES": sizes}
                subprocess.run([sys.executable, "-c", PACK, *COMPILED], env=own, cwd=self.build_lib, check=True)


setup(cmdclass={"build_py": BuildWithCode})
