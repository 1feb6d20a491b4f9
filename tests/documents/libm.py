"""The mathematical functions of portable code, written anew from musl's sources: `python -m tests.documents.libm`.

It needs `pip install ziglang==0.13.0`, the last whose musl has all of them in C.
"""

import re
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

import llvmlite.binding as llvm

from carom.dsp.native.linking import show_only, tidy
from carom.dsp.native.portable import LIBRARY, MATHS
from carom.dsp.native.targets import PORTABLE, WASM, Target

SOURCES = """
exp exp2 exp_data pow pow_data log log_data log2 log2_data log1p expm1 sin cos __sin __cos __rem_pio2 __rem_pio2_large
scalbn atan atan2 acos sinh __expo2 __math_oflow __math_uflow __math_xflow __math_divzero __math_invalid
""".split()  # noqa: SIM905
FLAGS = """
-target wasm64-freestanding -g0 -O1 -fno-vectorize -fno-slp-vectorize -ffp-contract=off -fno-builtin -fno-sanitize=all
-D_XOPEN_SOURCE=700 -w -S -emit-llvm
""".split()  # noqa: SIM905
HEAD = """; Functions of musl's mathematical library (MIT licence; see COPYRIGHT beside this file) as LLVM's assembly.
; `python -m tests.documents.libm` wrote it, with the C compiler of ziglang 0.13.0, without contraction or vectors.
"""
INSTRUCTIONS = ("sqrt", "fabs", "floor")


def compiled(name: str, folder: Path) -> str:
    """Return a source of musl's as LLVM's assembly, without what is said of a target, and with names of our own."""
    spec = find_spec("ziglang")
    assert spec and spec.origin, "pip install ziglang==0.13.0"
    musl = Path(spec.origin).parent / "lib" / "libc" / "musl"
    inner = (
        "src/include src/internal arch/generic arch/x86_64 include ../include/x86_64-linux-musl ../include/generic-musl"
    )
    include = [f"-I{musl / each}" for each in inner.split()]
    out = folder / f"{name}.ll"
    words = [
        sys.executable,
        "-m",
        "ziglang",
        "cc",
        *FLAGS,
        *include,
        "-o",
        str(out),
        str(musl / "src/math" / f"{name}.c"),
    ]
    subprocess.run(words, check=True)
    text = bare(out.read_text())
    for each in INSTRUCTIONS:
        text = re.sub(rf"@{each}\b", f"@llvm.{each}.f64", text)
    text = re.sub(r"@(?!llvm\.)([\w.]+)", r"@carom_\1", text)
    for static in re.findall(r"^(?:define internal [^@]*|)@([\w.]+)(?:\(| = internal| = private)", text, re.MULTILINE):
        if not static.startswith("llvm."):
            own = rf"^(?:define internal [^@]*@{re.escape(static)}\(|@{re.escape(static)} = (?:internal|private))"
            if re.search(own, text, re.MULTILINE):
                text = re.sub(rf"@{re.escape(static)}(?![\w.])", f"@{static}.{name.strip('_')}", text)
    declared: set[str] = set()
    lines = []
    for line in text.split("\n"):
        found = re.match(r"declare [^@]*@([\w.]+)\(", line)
        if not found or found[1] not in declared:
            lines.append(line)
        declared |= {found[1]} if found else set()
    return "\n".join(lines)


def bare(text: str) -> str:
    """Return LLVM's assembly without attributes, comments, and what it says of a target."""
    text = re.sub(r"^(attributes #.*|target .*|!.*|source_filename.*|;.*|.*@llvm\.lifetime.*)$", "", text, flags=re.M)
    text = re.sub(r", ![\w.]+ !\d+", "", text)
    text = re.sub(r" #\d+(?=[ ,{\n])| #\d+$|\n* *; preds.*$", "", text, flags=re.M)
    text = re.sub(r"\b(hidden|dso_local|local_unnamed_addr|nocapture) ", "", text)
    return re.sub(r"\n\n+", "\n\n", text)


def main() -> None:
    whole = llvm.parse_assembly("")
    with tempfile.TemporaryDirectory() as folder:
        for name in SOURCES:
            whole.link_in(llvm.parse_assembly(compiled(name, Path(folder))))
    show_only(whole, {f"carom_{name}" for name in MATHS})
    tidy(whole, Target(WASM, PORTABLE).machine())
    LIBRARY.write_text(f"{HEAD}\n{bare(str(whole)).strip()}\n")


if __name__ == "__main__":
    main()
