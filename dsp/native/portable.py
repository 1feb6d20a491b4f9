"""Code that gives the same bits on every processor and system, and as WebAssembly.

It is optimised once, for vectors of 128 bits and 64-bit addresses, whatever runs it afterwards. No flag is left by
which a code generator may reorder or contract sums, and its mathematical functions are its own (`libm/libm.ll`): a
target may split vectors, and nothing else. Denormals are numbers on all of them.
"""

import re
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm

from .linking import show_only, tidy
from .targets import PORTABLE, WASM, Target

MATHS = ("exp", "exp2", "log", "log2", "log1p", "expm1", "pow", "sin", "cos", "atan2", "acos", "sinh")
"""The functions that it has of its own, of float64; each is called carom_NAME."""

LIBRARY = Path(__file__).parent / "libm" / "libm.ll"
"""The file of these functions."""

_FLAGS = re.compile(r"(?<= )(?:(?:reassoc|nnan|ninf|nsz|arcp|contract|afn|fast) )+")
_ARITHMETIC = re.compile(r"= (?:tail |notail |musttail )?(?:f\w+|select|phi|call) ")
_CALLED = re.compile(rf"@(?:llvm\.({'|'.join(MATHS)})\.f64|({'|'.join(MATHS)}))(?=\()")
_ROOT = "llvm.sqrt.f64"  # which all processors have
_DECLARED = re.compile(rf"declare [^@]*@(?:{_ROOT}|carom_(?:{'|'.join(MATHS)}))\(")
_DEFINED = re.compile(r"^define [^@]*@([\w.]+)\(", re.MULTILINE)


def with_own_functions(module: Any) -> Any:
    """Return LLVM's module with calls of its own mathematical functions in place of the system's."""
    text = _CALLED.sub(lambda found: f"@carom_{found[1] or found[2]}", str(module)).replace("@sqrt(", f"@{_ROOT}(")
    lines = [line for line in text.split("\n") if not _DECLARED.match(line)]
    defined = {found[1] for found in _DEFINED.finditer(text)}
    for name in (_ROOT, *(f"carom_{name}" for name in MATHS)):
        if f"@{name}(" in text and name not in defined:
            arguments = ", ".join(["double"] * (2 if name in ("carom_pow", "carom_atan2") else 1))
            lines.append(f"declare double @{name}({arguments}) nounwind willreturn memory(none)")
    return llvm.parse_assembly("\n".join(lines))


def strict(module: Any) -> Any:
    """Return LLVM's module without the flags by which a code generator may change a sum."""
    lines = str(module).split("\n")
    return llvm.parse_assembly("\n".join(_FLAGS.sub("", each) if _ARITHMETIC.search(each) else each for each in lines))


@cache
def functions() -> dict[str, bytes]:
    """Return the bitcode of each of its mathematical functions, by the symbol, with all that it calls."""
    whole = llvm.parse_assembly(LIBRARY.read_text())
    made = {}
    for name in MATHS:
        symbol, own = f"carom_{name}", whole.clone()
        show_only(own, {symbol})
        tidy(own, Target(WASM, PORTABLE).machine())
        made[symbol] = own.as_bitcode()
    return made
