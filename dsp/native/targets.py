"""The targets of machine code: operating systems and kinds of processor; and which of them this machine is."""

import os
import platform
import sys
from functools import cache
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from ..errors import CaromError

VARIABLE = "CAROM_PROCESSOR"
"""The environment variable that names one of LEVELS for a processor that could do more, or PORTABLE."""

_ADDED = {
    "x86-64": "",
    "x86-64-v2": "CX16 POPCNT SSE3 SSE41 SSE42 SSSE3",
    "x86-64-v3": "AVX2 BMI BMI2 F16C FMA3 LZCNT MOVBE",
    "x86-64-v4": "AVX512F AVX512CD AVX512_SKX",
}  # by numpy's names of them
LEVELS = tuple(_ADDED)
"""Levels of x86-64, from the least to the most; each can do what those before it can."""

ARM = "aarch64"
"""The 64-bit processors of Arm, whatever they can do beyond the least."""

PORTABLE = "portable"
"""This family's processors, by code whose bits are the same on all (`portable.py`). Before a level, as in
portable-x86-64-v4: the same bits by the instructions of that level; before ARM: the same bits there."""

WASM = "wasm"
"""The system of WebAssembly, which has nothing of what other systems have."""

_OWN_NAMES = {"amd64": "x86_64", "arm64": ARM}
# LLVM's names. Images are linked from ELF on all systems (`images.py`); Windows has its own format for object files.
_TRIPLES = {
    ("linux", "x86_64"): "x86_64-unknown-linux-gnu",
    ("linux", ARM): "aarch64-unknown-linux-gnu",
    ("darwin", "x86_64"): "x86_64-apple-macosx10.15",
    ("darwin", ARM): "arm64-apple-macosx11.0",
    ("windows", "x86_64"): "x86_64-pc-windows-msvc-elf",
}
_OBJECT_TRIPLES = {"x86_64-pc-windows-msvc-elf": "x86_64-pc-windows-gnu"}


class Target(NamedTuple):
    """An operating system and a kind of processor."""

    system: str
    processor: str

    def __str__(self) -> str:
        return f"{self.system}-{self.processor}"

    @property
    def is_portable(self) -> bool:
        """True if its code gives the same bits as on all other processors."""
        return self.processor.startswith(PORTABLE)

    @property
    def level(self) -> str:
        """The one of LEVELS whose instructions its code may have, or an empty string."""
        level = self.processor.removeprefix(f"{PORTABLE}-")
        return level if level in LEVELS else ""

    @property
    def triple(self) -> str:
        """LLVM's name of it; this machine's where it is none of those that wheels hold code for."""
        if self.system == WASM:
            return "wasm32-unknown-unknown"
        return _TRIPLES.get((self.system, self.family)) or str(_llvm().get_process_triple())

    @property
    def family(self) -> str:
        """LLVM's name of its kind of processor."""
        return "x86_64" if self.level else self.processor.removeprefix(PORTABLE).removeprefix("-") or own_family()

    def machine(self) -> Any:
        """Return LLVM's maker of machine code for it."""
        return self._machine(self.triple)

    def object_machine(self) -> Any:
        """Return the same for object files that a system's own linker takes."""
        return self._machine(_OBJECT_TRIPLES.get(self.triple, self.triple))

    def image_machine(self) -> Any:
        """Return the same for images, which are linked from ELF on all systems (`images.py`)."""
        return self._machine(f"{self.triple}-elf" if self.system == "darwin" else self.triple)

    def _machine(self, triple: str) -> Any:
        cpu, features = (self.level, "-prefer-256-bit") if self.level else ("generic", "")
        return _machine(triple, cpu, _WASM_FEATURES if self.system == WASM else features)

    def optimiser(self) -> Any:
        """Return what LLVM optimises code for: portable code for one machine, whatever runs it."""
        machine = self.machine()
        return _machine("wasm64-unknown-unknown", "generic", _WASM_FEATURES) if self.is_portable else machine


_WASM_FEATURES = "+simd128,+bulk-memory,+bulk-memory-opt,+nontrapping-fptoint,+sign-ext,+mutable-globals"


def _machine(triple: str, cpu: str, features: str) -> Any:
    llvm = _llvm()
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    reloc = "static" if triple.startswith("wasm") else "pic"
    target = llvm.Target.from_triple(triple)
    return target.create_target_machine(cpu=cpu, features=features, opt=3, reloc=reloc, codemodel="default")


def _llvm() -> Any:
    """Return LLVM, which is imported only to compile."""
    import llvmlite.binding as llvm

    return llvm


WHEEL = tuple(
    Target(system, processor)
    for system, family in _TRIPLES
    for processor in ((ARM,) if family == ARM else LEVELS[1:])
)  # fmt: skip
"""All that a wheel for everybody holds code for."""


class ProcessorError(CaromError, ValueError):
    """A kind of processor that the environment's VARIABLE asks for, and this one is not."""


@cache
def system() -> str:
    """Return this operating system's name, as the names of compiled files have it."""
    return {"win32": "windows"}.get(sys.platform, sys.platform)


@cache
def processors() -> tuple[str, ...]:
    """Return the kinds of processor whose code this one runs, the most able first; ProcessorError where VARIABLE asks
    for another."""
    asked, own = os.environ.get(VARIABLE), own_family()
    able = _able() if own == "x86_64" else [own]
    if asked == PORTABLE:
        return tuple(f"{PORTABLE}-{level}" for level in reversed(able)) if own == "x86_64" else (PORTABLE,)
    if asked and asked not in able:
        can = f"{', '.join(able)}, which this processor can do"
        raise ProcessorError(f"{VARIABLE} = {asked!r}: expected {PORTABLE}, or one of {can}")
    return tuple(reversed(able[: able.index(asked) + 1] if asked else able))


def _able() -> list[str]:
    """Return the levels of x86-64 that this processor can do, from the least on."""
    has, able = _features(), []
    for level, added in _ADDED.items():
        if not all(has.get(name, True) for name in added.split()):
            break
        able.append(level)
    return able


def _features() -> dict[str, bool]:
    """Return which instructions this processor has, and the system lets it use, by numpy's names.

    Releases before 2.4 don't know all: they lack none that a processor with the others of its level has not.
    """
    core = "numpy._core" if hasattr(np, "_core") else "numpy.core"  # its name before 2.0
    return dict(vars(import_module(f"{core}._multiarray_umath"))["__cpu_features__"])


def own_family() -> str:
    """Return LLVM's name of this machine's kind of processor."""
    machine = platform.machine().lower()
    return _OWN_NAMES.get(machine, machine)


def targets() -> tuple[Target, ...]:
    """Return the targets whose code this machine runs, the most able first."""
    return tuple(Target(system(), processor) for processor in processors())


def built() -> tuple[Target, ...]:
    """Return the targets that a wheel holds code for if this machine builds it for machines of its family and
    system."""
    kinds = LEVELS[1:] if processors()[-1] in LEVELS else processors()
    return tuple(Target(system(), kind) for kind in kinds)
