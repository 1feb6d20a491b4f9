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
    "carom.dsp.runtime.callback",
    "carom.dsp.runtime.handover",
    "carom.dsp.runtime.jobs",
    "carom.dsp.runtime.pacer",
    "carom.server.bridge.mujoco.track",
    "carom.server.bridge.telling",
    "carom.server.net.udp",
)
"""The modules that define functions of C."""

EVERYWHERE = os.environ.get("CAROM_WHEEL") == "everywhere"
"""Whether the wheel is for all systems, and not only for those like this one: its code takes minutes more to make."""

BUILD = f"""
import sys
from carom.dsp.native import code, store, targets
code.build(sys.argv[1:], {"targets.WHEEL" if EVERYWHERE else "targets.built()"}, store.PACKAGED)
"""


class BuildWithCode(build_py):
    """Copies the package, and has the copy compile itself, which takes long where no code of it is cached."""

    def run(self) -> None:
        super().run()
        if not self.editable_mode:
            # A front end that builds apart from what is installed, as pip does, says in PYTHONPATH where numba is.
            paths = [str(Path(self.build_lib).resolve()), os.environ.get("PYTHONPATH")]
            environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}
            subprocess.run([sys.executable, "-c", BUILD, *COMPILED], env=environment, cwd=self.build_lib, check=True)


setup(cmdclass={"build_py": BuildWithCode})
