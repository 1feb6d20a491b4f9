"""What pyproject.toml cannot say: a wheel holds machine code of the functions that Carom compiles."""

import os
import shutil
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import TextIO

from setuptools import setup
from setuptools.command.build_py import build_py

COMPILED = (
    "carom.dsp.runtime.callback",
    "carom.dsp.native.atomics",
    "carom.dsp.native.system",
    "carom.dsp.contact.law",
    "carom.dsp.contact.pulse",
    "carom.dsp.rolling.surface",
    "carom.dsp.swarm.making",
    "carom.dsp.runtime.handover",
    "carom.dsp.runtime.jobs",
    "carom.dsp.runtime.pacer",
    "carom.server.bridge.mujoco.track",
    "carom.server.bridge.telling",
    "carom.server.bridge.touching",
    "carom.server.net.udp",
)
"""The modules that define functions of C: the engine, then what takes some seconds."""

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
wanted = {targets}
print("carom: compiling the engine for", *(each.processor for each in wanted), file=sys.stderr, flush=True)
compiling.build(sys.argv[1:], wanted, store.PACKAGED)
"""

PACK = """
import sys
from carom.clients.export import c
from carom.dsp import sizes
from carom.dsp.native import compiling, store, targets, wasm
from carom.dsp.runtime import callback
from carom.server.bridge import touching
print("carom: compiling portable code,", sizes.NAME, "engine", file=sys.stderr, flush=True)
exports = sizes.NAME == "small"
wanted = compiling.portable(targets.built()[:1] if exports else targets.built())
own = targets.Target(targets.system(), targets.PORTABLE)
files = [*c.engine_files(own), *map(wasm.object_file, (callback.__name__, touching.__name__))] if exports else []
compiling.pack(sys.argv[1:], wanted, files, store.PACKAGED)
"""
"""Packs portable code for this system, and processors of this one's family: of the engine that plays here, or of that
of exports, with what these are made of."""

PORTABLE = ("everywhere", "family")
"""For which of TARGETS a wheel holds portable code, too."""


class BuildWithCode(build_py):
    """Copies the package, and has the copy compile itself, which takes long where no code of it is cached. An editable
    package is laid out by links."""

    def run(self) -> None:
        super().run()
        asked = os.environ.get("CAROM_WHEEL", "machine")
        if asked not in TARGETS:
            raise ValueError(f"CAROM_WHEEL = {asked!r}: expected one of {', '.join(TARGETS)}")
        if self.editable_mode:
            self._link()
        elif TARGETS[asked]:
            # A front end that builds apart from what is installed, as pip does, says in PYTHONPATH where numba is.
            paths = [str(Path(self.build_lib).resolve()), os.environ.get("PYTHONPATH")]
            environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}
            scripts = [(BUILD.format(targets=TARGETS[asked]), "full")]
            scripts += [(PACK, "full"), (PACK, "small")] if asked in PORTABLE else []
            begun, terminal = time.monotonic(), terminal_or_stderr()
            with terminal:
                print(file=terminal, flush=True)  # the line of the front end is left as it is
                for script, sizes in scripts:
                    own = environment | {"CAROM_SIZES": sizes}
                    words = [sys.executable, "-c", script, *COMPILED]
                    subprocess.run(words, env=own, cwd=self.build_lib, check=True, stderr=terminal)
                print(f"carom: compiled in {time.monotonic() - begun:.0f} s", file=terminal)

    def _link(self) -> None:
        """Lay the packages out by links, as they are installed, in a folder that Python and type checkers look into.

        setuptools' own finder, which no type checker knows, is asked last: after a folder of the name `carom` that lies
        beside the script, as the checkout itself may. It stays for systems without links, and for files that are new.
        `pip uninstall` leaves the links: they end with the checkout.
        """
        tree = Path(".editable").resolve()
        shutil.rmtree(tree, ignore_errors=True)
        try:
            for package, folder in self.package_dir.items():
                place = tree.joinpath(*package.split("."))
                if package == "carom":
                    place.mkdir(parents=True)
                    for file in Path(folder).iterdir():
                        if file.is_file():
                            (place / file.name).symlink_to(os.path.relpath(file, place))
                else:
                    place.symlink_to(os.path.relpath(folder, place.parent), target_is_directory=True)
        except OSError:  # Windows makes links for those alone who have the right to
            shutil.rmtree(tree, ignore_errors=True)
            return
        site = Path(self.get_finalized_command("install").install_lib)
        (site / "carom-links.pth").write_text(f"{tree}\n")


def terminal_or_stderr() -> TextIO:
    """Return the terminal where this process's group has one, as front ends show nothing of what a build says."""
    with suppress(OSError):
        terminal = open("CONOUT$" if sys.platform == "win32" else "/dev/tty", "w")  # noqa: SIM115
        if sys.platform == "win32" or os.tcgetpgrp(terminal.fileno()) == os.getpgrp():
            return terminal
    return os.fdopen(os.dup(2), "w")


setup(cmdclass={"build_py": BuildWithCode})
