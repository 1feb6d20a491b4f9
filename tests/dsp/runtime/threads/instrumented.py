"""Kernels as ThreadSanitizer judges them: the code that the engine runs, with each access to memory told.

clang's own pass reads LLVM's text of clang's own version alone; numba's is newer. So the calls that the pass would add
are written into the text here. The order of each atomic operation is read from a table as it runs, so that one program
tells what happens with any of them weakened.
"""

import re
import shutil
import subprocess
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite.binding as llvm

from carom.dsp.native import atomics
from carom.dsp.native.jit import CFunction
from carom.dsp.native.linking import show_only
from carom.dsp.native.translation import translator
from carom.dsp.runtime import handover, jobs, pacer
from carom.server.net import udp
from tests.dsp.runtime.threads import entries

FUNCTIONS: tuple[CFunction, ...] = (
    entries.take, entries.tap, entries.note, entries.report, entries.trace,
    handover.guarded, pacer.pace, jobs.work, jobs.finish, udp.drain,
    atomics.publish_at, atomics._observe, atomics._confirm, atomics._swap,
)  # fmt: skip

LACKING = "clang or gcc with ThreadSanitizer is not installed: apt install clang"

_ORDERS = {"monotonic": 0, "acquire": 2, "release": 3, "acq_rel": 4, "seq_cst": 5}
_SIZES = {"ptr": 8, "double": 8, "float": 4, "half": 2}
_ATOMIC = re.compile(
    r"  (?:(?P<to>%\S+) = )?(?:(?P<load>load) atomic i64, ptr (?P<at>\S+) (?P<order>\w+), align 8"
    r"|(?P<store>store) atomic i64 (?P<value>\S+), ptr (?P<place>\S+) (?P<stored>\w+), align 8"
    r"|(?P<swap>cmpxchg) ptr (?P<word>\S+), i64 (?P<before>\S+), i64 (?P<after>\S+) (?P<done>\w+) (?P<failed>\w+).*"
    r"|(?P<fence>fence) (?P<kind>\w+))"
)
_LOAD = re.compile(r"  %\S+ = load (?P<type>.+?), ptr (?P<at>%\S+), align")
_STORE = re.compile(r"  store (?P<type><[^>]+>|\{[^}]+\}|\[[^]]+\]|\S+) .*, ptr (?P<at>%\S+), align")
_COPY = re.compile(
    r"  (?:tail )?call void @llvm\.mem(?:cpy|move)\S+\(ptr (?:[\w()]+ )*?(?P<to>%\S+), "
    r"ptr (?:[\w()]+ )*?(?P<at>%\S+), i64 (?P<size>\S+),"
)
_DECLARED = """
@order_of = external global [64 x i32]
declare i64 @__tsan_atomic64_load(ptr, i32)
declare void @__tsan_atomic64_store(ptr, i64, i32)
declare i64 @__tsan_atomic64_compare_exchange_val(ptr, i64, i64, i32, i32)
declare void @__tsan_atomic_thread_fence(i32)
declare void @__tsan_read_range(ptr, i64)
declare void @__tsan_write_range(ptr, i64)
"""


class Operation(NamedTuple):
    """An atomic operation of a kernel, in the order in which the kernel's text has them."""

    kernel: str
    what: str  # load, store, cmpxchg or fence
    order: str


def _machine() -> Any:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_default_triple().create_target_machine(reloc="pic", codemodel="small")


def orders(function: CFunction, kernel: str) -> Counter[str]:
    """Return how many atomic operations of each kind and order the code of a kernel within a function of C has."""
    parts = translator().within(translator().c_function(function))
    lines = (each for part in parts for each in _atomics(str(llvm.parse_bitcode(part.bitcode))))
    return Counter(f"{each.what} {each.order}" for _, each, _ in lines if each and each.kernel == kernel)


def operations() -> list[Operation]:
    """Return the atomic operations of all kernels."""
    return _instrumented()[1]


@cache
def _instrumented() -> tuple[Any, list[Operation]]:
    """Return LLVM's module of FUNCTIONS with all that they call, each access told, and its atomic operations."""
    parts = {
        part.mangled_name: part.bitcode
        for function in FUNCTIONS
        for part in translator().within(translator().c_function(function))
    }
    found: list[Operation] = []
    module = llvm.parse_assembly("")
    for part in parts.values():
        module.link_in(llvm.parse_assembly(_told(str(llvm.parse_bitcode(part)), found)))
    show_only(module, {function.py_func.__name__ for function in FUNCTIONS})
    options = llvm.create_pipeline_tuning_options(speed_level=1)
    options.loop_vectorization = options.slp_vectorization = options.loop_unrolling = False
    builder = llvm.create_pass_builder(_machine(), options)
    builder.getModulePassManager().run(module, builder)
    return module, found


def _atomics(text: str) -> Iterator[tuple[str, Operation | None, re.Match[str] | None]]:
    """Yield each line of LLVM's text of a kernel, with the atomic operation that it is."""
    kernel = ""
    for line in text.splitlines():
        if line.startswith("define"):
            symbol = re.search(r'@"?([\w.$]+)', line)
            assert symbol
            named = re.match(r"_ZN\d+(?:\w+\.)*?(\w+)\.[0-9a-f]{8}", symbol[1])
            kernel = named[1] if named else symbol[1]
        match = _ATOMIC.match(line)
        if match:
            what = match["load"] or match["store"] or match["swap"] or match["fence"]
            order = match["order"] or match["stored"] or match["done"] or match["kind"]
            yield line, Operation(kernel, what, order), match
        else:
            assert not re.search(r" atomic |cmpxchg|atomicrmw|  fence ", line), line
            yield line, None, None


def _told(text: str, found: list[Operation]) -> str:
    """Return LLVM's text of a kernel with a call before each access to memory but its own frame's, and calls in place
    of its atomic operations, which are added to those that were found."""
    lines: list[str] = []
    frame: set[str] = set()
    for line, operation, atomic in _atomics(text):
        if line.startswith("define"):
            frame = set()
        if match := re.match(r"  (%\S+) = alloca", line):
            frame.add(match[1])
        if operation and atomic:
            lines += _atomic(atomic, len(found))
            found.append(operation)
            continue
        for pattern, name in ((_LOAD, "read"), (_STORE, "write")):
            match = pattern.match(line)
            if match and match["at"] not in frame:
                lines.append(f"  call void @__tsan_{name}_range(ptr {match['at']}, i64 {_size(match['type'])})")
        if match := _COPY.match(line):
            lines.append(f"  call void @__tsan_read_range(ptr {match['at']}, i64 {match['size']})")
            lines.append(f"  call void @__tsan_write_range(ptr {match['to']}, i64 {match['size']})")
        assert match or not re.search(r"call .*@llvm\.mem(cpy|move)", line), line
        lines.append(line)
    return "\n".join([*lines, _DECLARED])


def _atomic(match: re.Match[str], number: int) -> list[str]:
    """Return the calls that stand for an atomic operation, whose order is that of its number."""
    order, to = f"%told.{number}", match["to"]
    lines = [
        f"  {order}.at = getelementptr [64 x i32], ptr @order_of, i64 0, i64 {number}",
        f"  {order} = load i32, ptr {order}.at",
    ]
    if match["load"]:
        lines.append(f"  {to} = call i64 @__tsan_atomic64_load(ptr {match['at']}, i32 {order})")
    elif match["store"]:
        lines.append(f"  call void @__tsan_atomic64_store(ptr {match['place']}, i64 {match['value']}, i32 {order})")
    elif match["fence"]:
        lines.append(f"  call void @__tsan_atomic_thread_fence(i32 {order})")
    else:
        old = f"{order}.old"
        lines += [
            f"  {old} = call i64 @__tsan_atomic64_compare_exchange_val("
            f"ptr {match['word']}, i64 {match['before']}, i64 {match['after']}, i32 {order}, i32 {order})",
            f"  {old}.did = icmp eq i64 {old}, {match['before']}",
            f"  {old}.pair = insertvalue {{ i64, i1 }} poison, i64 {old}, 0",
            f"  {to} = insertvalue {{ i64, i1 }} {old}.pair, i1 {old}.did, 1",
        ]
    return lines


def _size(kind: str) -> int:
    """Return the bytes of a type of LLVM's."""
    if kind in _SIZES:
        return _SIZES[kind]
    if match := re.fullmatch(r"i(\d+)", kind):
        return (int(match[1]) + 7) // 8
    match = re.fullmatch(r"[<\[](\d+) x (\w+)[>\]]", kind)
    assert match, kind
    return int(match[1]) * _size(match[2])


@cache
def compiler() -> str | None:
    """Return a compiler of C that links programs that ThreadSanitizer runs; None where there is none."""
    for name in ("clang", "gcc"):
        if shutil.which(name):
            tried = subprocess.run(
                f"d=$(mktemp -d) && echo 'int main(void) {{ return 0; }}' > $d/a.c && "
                f"{name} -fsanitize=thread $d/a.c -o $d/a && $d/a; r=$?; rm -r $d; exit $r",
                shell=True, capture_output=True,
            )  # fmt: skip
            if tried.returncode == 0:
                return name
    return None


def build(folder: Path, sizes: dict[str, int]) -> Path:
    """Build the program of threads.c with the kernels in a folder, and return it. sizes: its constants."""
    module, found = _instrumented()
    assert len(found) <= 64
    module.verify()
    (folder / "kernels.o").write_bytes(_machine().emit_object(module))
    orders = ", ".join(str(_ORDERS[each.order]) for each in found)
    defined = [f"-D{name}={value}" for name, value in sizes.items()]
    program = folder / "threads"
    made = subprocess.run(
        # ThreadSanitizer hears of a memset or memcpy that is called, not of one that gcc writes out in place.
        [compiler() or "", "-fsanitize=thread", "-O1", "-g", "-fno-builtin", "-pthread", *defined, f"-DORDERS={orders}",
         str(Path(__file__).with_name("threads.c")), str(folder / "kernels.o"), "-lm", "-o", str(program)],
        capture_output=True, text=True,
    )  # fmt: skip
    assert made.returncode == 0, made.stderr
    return program
