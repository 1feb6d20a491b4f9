"""The processors that machine code is made for, and the one that this is."""

import os
import platform
import sys
from functools import cache
from typing import Any

import llvmlite.binding as llvm

VARIABLE = "CAROM_PROCESSOR"
"""The environment variable that names one of LEVELS for a processor that could do more."""

_ADDED = {
    "x86-64": "",
    "x86-64-v2": "cx16 popcnt sse3 sse4.1 sse4.2 ssse3",
    "x86-64-v3": "avx2 bmi bmi2 f16c fma lzcnt movbe",
    "x86-64-v4": "avx512f avx512bw avx512cd avx512dq avx512vl",
}
LEVELS = tuple(_ADDED)
"""Levels of x86-64, from the least to the most; each can do what those before it can."""


@cache
def system() -> str:
    """The operating system, as the names of compiled files say it."""
    return {"win32": "windows"}.get(sys.platform, sys.platform)


@cache
def processors() -> tuple[str, ...]:
    """The kinds of processor whose code this one runs, the most able first; ValueError where VARIABLE asks for more."""
    machine = platform.machine().lower()
    if machine not in ("x86_64", "amd64"):
        return (machine,)
    has, able = llvm.get_host_cpu_features(), []
    for level, added in _ADDED.items():
        if not all(has.get(name) for name in added.split()):
            break
        able.append(level)
    asked = os.environ.get(VARIABLE)
    if asked and asked not in able:
        raise ValueError(f"{VARIABLE} = {asked!r}: expected one of {', '.join(able)}, which this processor can do")
    return tuple(reversed(able[: able.index(asked) + 1] if asked else able))


def built() -> tuple[str, ...]:
    """The kinds of processor that a wheel holds code for, which is built on this one."""
    return LEVELS[1:] if processors()[-1] in LEVELS else processors()


def target_machine(processor: str) -> Any:
    """LLVM's maker of machine code for a kind of processor of this machine's family."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    cpu, features = (processor, "-prefer-256-bit") if processor in LEVELS else ("generic", "")
    target = llvm.Target.from_default_triple()
    return target.create_target_machine(cpu=cpu, features=features, opt=3, reloc="pic", codemodel="default")
