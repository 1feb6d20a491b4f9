"""The audio callback can't allocate, lock or touch Python: shown on every path through its compiled code."""

import ctypes
import re
from collections.abc import Callable, Iterator
from textwrap import dedent
from typing import Any

import llvmlite.binding as llvm
import numpy as np
import pytest
from numba import carray, cfunc, njit, objmode, types

from carom.dsp.native.compiling import bitcode
from carom.dsp.runtime import handover

pytestmark = pytest.mark.slow

ALLOWED = {
    # The C library: pure mathematics, the clock and the thread's number, which take no lock.
    *("exp", "exp2", "expm1", "log", "log1p", "log2", "pow", "sin", "cos", "acos", "atan2", "sinh", "sqrt", "floor"),
    *("clock_gettime", "gettid"),
    # LLVM, as "llvm.NAME.TYPES": instructions, or calls of the functions above.
    *(
        "llvm.exp",
        "llvm.exp2",
        "llvm.log",
        "llvm.pow",
        "llvm.sin",
        "llvm.cos",
        "llvm.atan2",
        "llvm.sqrt",
        "llvm.floor",
        "llvm.fabs",
    ),
    *("llvm.fma", "llvm.fmuladd", "llvm.ctpop", "llvm.cttz", "llvm.copysign", "llvm.minnum", "llvm.maxnum"),
    *("llvm.abs", "llvm.smin", "llvm.smax", "llvm.umin", "llvm.umax", "llvm.vector.reduce"),
    *("llvm.uadd.with.overflow", "llvm.usub.with.overflow", "llvm.umul.with.overflow", "llvm.usub.sat"),
    *("llvm.memset", "llvm.memcpy", "llvm.memmove", "llvm.prefetch"),
    *("llvm.masked.load", "llvm.masked.store", "llvm.masked.gather", "llvm.masked.scatter"),
    *("llvm.lifetime.start", "llvm.lifetime.end", "llvm.assume", "llvm.experimental.noalias.scope.decl"),
    *("llvm.x86.sse.stmxcsr", "llvm.x86.sse.ldmxcsr"),
}

_NAME = r'(?:"([^"]*)"|([\w.$-]+))'
_FUNCTION = re.compile(rf"^(define|declare) .*?@{_NAME}\(.*?(?:^}}|$)", re.MULTILINE)
_BODY = re.compile(rf"^define .*?@{_NAME}\(.*?^}}", re.MULTILINE | re.DOTALL)
_USED = re.compile(rf"@{_NAME}")
_CALL = re.compile(r"\b(?:call|invoke|callbr) .*")
_CALLED = re.compile(rf"[@%]{_NAME}\(")


def forbidden(assembly: str, entry: str) -> set[str]:
    """Return the names that `entry` reaches, in LLVM assembly, which are neither defined there nor in ALLOWED."""
    functions = {found[2] or found[3] for found in _FUNCTION.finditer(assembly)}
    defined = {found[1] or found[2]: found[0] for found in _BODY.finditer(assembly)}
    seen: set[str] = set()
    todo = [entry]
    while todo:
        name = todo.pop()
        if name not in seen:
            seen.add(name)
            todo.extend(references(defined[name], functions) if name in defined else ())
    return {name for name in seen if name not in defined and not allowed(name)}


def references(function: str, functions: set[str]) -> Iterator[str]:
    """Yield names of the functions that a function, as text, calls or takes the address of, and calls of what has no
    name."""
    _, _, body = function.partition("\n")
    yield from functions & {quoted or plain for quoted, plain in _USED.findall(body)}
    for call in _CALL.findall(body):
        called = _CALLED.search(call)
        if called is None or called[0].startswith("%"):
            yield "inline assembly" if re.search(r"\basm\b", call) else "indirect call"


def allowed(name: str) -> bool:
    """True if a name is in ALLOWED, or what is left of it without types at its end."""
    parts = name.split(".")
    return any(".".join(parts[:n]) in ALLOWED for n in range(1, len(parts) + 1))


def test_the_callback_reaches_no_allocator_no_python_and_no_lock(callback_code) -> None:
    assert forbidden(*callback_code) == set()


def test_the_function_that_a_device_calls_calls_nothing_but_the_callback() -> None:
    assembly = str(llvm.parse_bitcode(bitcode(handover.__name__)))
    assert forbidden(assembly, handover.guarded.__name__) == {"indirect call"}


SIGNATURE = types.intc(types.CPointer(types.float64), types.intc)

mutex_lock = types.ExternalFunction("pthread_mutex_lock", types.intc(types.CPointer(types.float64)))
at_an_address = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int)(abs)


def allocates(data, n):
    carray(data, (n,))[:] = np.empty(n)
    return 0


def makes_a_temporary(data, n):
    x = carray(data, (n,))
    x[:] = x * 2.0 + 1.0
    return 0


def appends(data, n):
    values = [0.0]
    for i in range(n):
        values.append(data[i])
    return len(values)


def raises(data, n):
    if n < 0:
        raise ValueError
    return 0


def prints(data, n):
    print(n)
    return 0


@njit
def _in_python(n):
    with objmode(m="intc"):
        m = len(str(n))
    return m


def calls_python(data, n):
    return _in_python(n)


def locks(data, n):
    return mutex_lock(data)


@njit
def _locks_deep_down(data, n):
    return mutex_lock(data) if n == 0 else _locks_deep_down(data, n - 1) + 1


def locks_deep_down(data, n):
    return _locks_deep_down(data, n)


def calls_an_address(data, n):
    return at_an_address(n)


@pytest.mark.parametrize(
    ("body", "culprit"),
    [
        (allocates, "NRT_MemInfo_alloc_aligned"),
        (makes_a_temporary, "NRT_MemInfo_alloc_aligned"),
        (appends, "NRT_MemInfo_varsize_realloc"),
        (raises, "numba_gil_ensure"),
        (prints, "PySys_FormatStdout"),
        (calls_python, "PyObject_CallFunctionObjArgs"),
        (locks, "pthread_mutex_lock"),
        (locks_deep_down, "pthread_mutex_lock"),
        (calls_an_address, "indirect call"),
    ],
)
def test_the_same_check_finds(body: Callable[..., int], culprit: str) -> None:
    compiled: Any = cfunc(SIGNATURE, error_model="numpy", forceinline=True)(body)
    assert culprit in forbidden(compiled.inspect_llvm(), compiled.native_name)


def test_a_harmless_callback_passes_and_code_that_nothing_reaches_is_no_fault() -> None:
    assembly = dedent("""
        declare void @free(ptr)
        declare double @llvm.exp.f64(double)
        declare double @llvm.exotic.f64(double)
        define double @entry(double %x) {
            %y = call double @llvm.exp.f64(double %x)
            ret double %y
        }
        define void @unreached(ptr %p) {
            call void @free(ptr %p)
            ret void
        }
        define ptr @takes_an_address() {
            ret ptr @unreached
        }
        define void @runs_assembly() {
            call void asm sideeffect "nop", ""()
            ret void
        }
        define double @exotic(double %x) {
            %y = call double @llvm.exotic.f64(double %x)
            ret double %y
        }
    """)
    assert forbidden(assembly, "entry") == set()
    assert forbidden(assembly, "unreached") == {"free"}
    assert forbidden(assembly, "takes_an_address") == {"free"}
    assert forbidden(assembly, "runs_assembly") == {"inline assembly"}
    assert forbidden(assembly, "exotic") == {"llvm.exotic.f64"}
