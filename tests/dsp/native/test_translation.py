"""An edit translates what it changes, and no more; and what is translated after edits is what an empty cache gives."""

import importlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from textwrap import dedent
from typing import NamedTuple

import numpy as np
import pytest
from numba import njit

from carom.dsp.native import translation
from carom.dsp.native.code import functions_of
from carom.dsp.native.jit import KERNELS as KERNELS_BY_NAME
from carom.dsp.native.jit import kernel
from carom.dsp.native.translation import translate_units, translator

FILES = {
    "numbers.py": """
        import enum
        from typing import NamedTuple

        import numpy as np

        from carom.dsp.native.jit import intrinsic, ir, types

        from . import kernels  # a circle of modules

        GAIN = 3.0
        TABLE = np.array([1.0, 2.0, 4.0])
        PAIR = (5, 6.0)
        RECORD = np.dtype([("low", np.float64), ("high", np.float64)])
        REAL = np.float32(0.25)
        KIND = types.float64

        class Mode(enum.IntEnum):
            SLOW = 1
            FAST = 2

        class Colour(enum.Enum):
            RED = 1
            BLUE = 2

        class Limits(NamedTuple):
            least: float
            most: float

        MODE, COLOUR = Mode.SLOW, Colour.RED
        LIMITS = Limits(0.5, 7.0)

        def shifted(builder, value):
            return builder.fadd(value, ir.Constant(ir.DoubleType(), 11.0))

        @intrinsic
        def shift(typingctx, value):
            def codegen(context, builder, signature, args):
                return shifted(builder, args[0])

            return types.float64(types.float64), codegen
    """,
    "kernels.py": """
        from carom.dsp.native.jit import carray, kernel, noinline_kernel, simd_kernel
        from carom.dsp.native.pointers import pointer_to

        from . import numbers
        from .numbers import COLOUR, KIND, LIMITS, MODE, PAIR, REAL, RECORD, TABLE, Colour, Limits, Mode, shift

        @kernel
        def leaf(x):
            '''Return twice a number.'''
            return 2.0 * x  # twice

        @noinline_kernel
        def middle(x):
            return leaf(x) + 1.0

        @noinline_kernel
        def apart(x):
            return 0.5 * x

        @kernel
        def reads_gain(x):
            return numbers.kernels.numbers.GAIN * x

        @kernel
        def reads_table(i):
            return TABLE[i]

        @kernel
        def reads_pair(x):
            return PAIR[0] * x + PAIR[1]

        @kernel
        def reads_record(address):
            return carray(pointer_to(address), 1, RECORD)[0].high

        @kernel
        def reads_mode(x):
            return x if MODE == Mode.FAST else 0.0

        @kernel
        def reads_colour(x):
            return x if COLOUR is Colour.BLUE else 0.0

        @kernel
        def reads_limits(x):
            return min(LIMITS.most, max(LIMITS.least, x))

        @kernel
        def takes_limits(limits):
            return limits.most - 2.0 * limits.least

        @kernel
        def makes_limits(x):
            return takes_limits(Limits(1.0, x))

        @kernel
        def reads_real(x):
            return REAL * x

        @kernel
        def reads_kind(x):
            return KIND(x)

        @kernel
        def shifts(x):
            return shift(x)

        @kernel
        def ratio(over, under, more=13.0):
            return over / under + more

        def scaled_by(factor):
            @kernel
            def scaled(x):
                return factor * x

            return scaled

        twice, thrice = scaled_by(2.0), scaled_by(3.0)
        plus, minus = kernel(lambda x: x + 17.0), kernel(lambda x: x - 19.0)
    """,
    "functions.py": """
        from ctypes import c_double, c_int64

        from carom.dsp.native.jit import c_function

        from .kernels import *

        @c_function(c_double, c_double)
        def chain(x):
            return middle(x) + apart(x) + reads_gain(x) + reads_table(2) + reads_pair(x) + shifts(x)

        @c_function(c_double, c_double)
        def others(x):
            return reads_mode(x) + reads_colour(x) + reads_limits(x) + makes_limits(x) + reads_real(x) + reads_kind(x)

        @c_function(c_double, c_int64)
        def pointers(address):
            return reads_record(address)

        @c_function(c_double, c_double)
        def closures(x):
            return 100.0 * twice(x) + 10.0 * thrice(x) + plus(x) + 1000.0 * minus(x) + ratio(over=x, under=2.0)
    """,
}
KERNELS, UNITS = 24, 6

NOTHING = {
    "comment": ("kernels.py", "# twice", "# two times"),
    "docstring": ("kernels.py", "Return twice a number.", "Return two times a number."),
    "moved lines": ("kernels.py", "@kernel\ndef leaf", "\n\n\n@kernel\ndef leaf"),
    "a constant that nobody reads": ("numbers.py", "GAIN = 3.0", "GAIN = 3.0\nLOSS = 4.0"),
}
"""Edits that translate nothing: a file, a text in it, and another for that."""

EDITS = {
    "leaf": ("kernels.py", "return 2.0 * x", "return 4.0 * x", 1, 1),
    "type returned": ("kernels.py", "return 0.5 * x", "return int(x)", 2, 2),
    "strictness": ("kernels.py", "@kernel\ndef leaf", "@simd_kernel\ndef leaf", 1, 1),
    "inlined from now on": ("kernels.py", "@noinline_kernel\ndef apart", "@kernel\ndef apart", 1, 1),
    "name of a builtin": ("kernels.py", "twice, thrice", "min = max\ntwice, thrice", 1, 1),
    "names of parameters": ("kernels.py", "ratio(over, under,", "ratio(under, over,", 2, 1),
    "default": ("kernels.py", "more=13.0", "more=14.0", 2, 1),
    "closure": ("kernels.py", "scaled_by(2.0)", "scaled_by(5.0)", 2, 1),
    "lambda": ("kernels.py", "x + 17.0", "x + 18.0", 2, 1),
    "module's number": ("numbers.py", "GAIN = 3.0", "GAIN = 4.0", 1, 1),
    "array": ("numbers.py", "2.0, 4.0]", "2.0, 5.0]", 1, 1),
    "tuple": ("numbers.py", "(5, 6.0)", "(5, 7.0)", 1, 1),
    "type in a tuple": ("numbers.py", "(5, 6.0)", "(5.0, 6.0)", 1, 1),
    "dtype": ("numbers.py", '("low", np.float64)', '("low", np.int32)', 1, 1),
    "member": ("numbers.py", "Mode.SLOW, Colour.RED", "Mode.FAST, Colour.RED", 1, 1),
    "member of no number": ("numbers.py", "Mode.SLOW, Colour.RED", "Mode.SLOW, Colour.BLUE", 1, 1),
    "named tuple": ("numbers.py", "least: float\n    most", "most: float\n    least", 3, 1),
    "numpy's number": ("numbers.py", "float32(0.25)", "float32(0.5)", 1, 1),
    "numba's type": ("numbers.py", "KIND = types.float64", "KIND = types.float32", 2, 1),
    "helper of an intrinsic": ("numbers.py", "11.0", "12.0", 1, 1),
}
"""Edits: a file, a text in it, another for that; how many kernels are translated, and units compiled."""


class Made(NamedTuple):
    """The work of a start: how many kernels it has translated and how many units are new; and the bitcode of all."""

    translated: int
    compiled: int
    units: dict[str, bytes]


class Package:
    """A small package of kernels in a folder, with a cache beside it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._known: set[str] = set()
        for name, text in FILES.items():
            self.write(name, text)

    def write(self, name: str, text: str) -> None:
        (self.folder / "small").mkdir(exist_ok=True)
        (self.folder / "small" / name).write_text(dedent(text))

    def edit(self, name: str, before: str, after: str) -> None:
        text = (self.folder / "small" / name).read_text()
        assert text.count(before) == 1, before
        self.write(name, text.replace(before, after))

    def start(self, cache: str = "cache") -> Made:
        """Translate all C functions, as a new process does."""
        _forget()
        units: dict[str, bytes] = {}
        functions = functions_of(importlib.import_module("small.functions").__name__)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(translation, "user_cache", lambda: self.folder / cache)
            keys = translate_units(functions, lambda unit: units.update({unit.key: unit.source()}), int)
            count = translator().count
        assert sorted(keys) == sorted(units)
        new, self._known = units.keys() - self._known, self._known | units.keys()
        return Made(count, len(new), units)


def _forget() -> None:
    for module in [name for name in sys.modules if name.partition(".")[0] == "small"]:
        del sys.modules[module]
        for name in [name for name in KERNELS_BY_NAME if name.startswith(f"{module}:")]:
            del KERNELS_BY_NAME[name]
    importlib.invalidate_caches()
    translation._translator.cache_clear()


@pytest.fixture
def empty(tmp_path, monkeypatch):
    """The package, and a cache that is empty."""
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    yield Package(tmp_path)
    _forget()


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """The package as its first start leaves it, with a full cache."""
    with pytest.MonkeyPatch.context() as patch:
        package = Package(tmp_path_factory.mktemp("first"))
        patch.syspath_prepend(package.folder)
        patch.setattr(sys, "dont_write_bytecode", True)
        made = package.start()
        assert (made.translated, made.compiled) == (KERNELS, UNITS)
    return package


@pytest.fixture
def package(first, empty):
    """The package, and a cache that holds all of it."""
    shutil.copytree(first.folder / "cache", empty.folder / "cache")
    empty._known = set(first._known)
    return empty


@pytest.mark.slow
@pytest.mark.parametrize("edit", NOTHING)
def test_an_edit_of_no_code_translates_nothing(package, edit):
    package.edit(*NOTHING[edit])
    assert package.start()[:2] == (0, 0)


@pytest.mark.slow
@pytest.mark.parametrize("edit", EDITS)
def test_an_edit_translates_what_reads_it_and_no_more(package, edit):
    *change, translated, compiled = EDITS[edit]
    package.edit(*change)
    assert package.start()[:2] == (translated, compiled)
    package.edit(change[0], change[2], change[1])
    again = (
        package.start()
    )  # the former code is still there; of a kernel whose callees changed, one translation is kept
    assert again.translated <= 1 and again.compiled == 0


APART = """
import json
from small import functions
from carom.dsp.native import code, translation

units = {}
functions = code.functions_of("small.functions")
translation.translate_units(functions, lambda unit: units.update({unit.key: unit.source().hex()}), int)
print(json.dumps(units))
"""


@pytest.mark.slow
def test_an_edited_cache_holds_the_same_bytes_as_an_empty_one_of_another_process(package):
    done = set()
    for edit, (name, before, after, *_) in EDITS.items():
        # Two edits may be of one text. To numba two classes of named tuples of one name are one in a process.
        if edit != "named tuple" and (name, before) not in done:
            done.add((name, before))
            package.edit(name, before, after)
            package.start()
    env = os.environ | {"PYTHONPATH": str(package.folder), "XDG_CACHE_HOME": str(package.folder / "other")}
    run = subprocess.run([sys.executable, "-c", APART], env=env, check=True, stdout=subprocess.PIPE)
    assert {key: unit.hex() for key, unit in package.start().units.items()} == json.loads(run.stdout)


REFUSED = {
    "raises": "raise ValueError",
    "asserts": "assert n > 0\n    return n",
    "calls what raises": "return raises(n)",
    "an index that is checked": "return (1, 2, 3)[n]",
    "a step that may be 0": "m = 0\n    for i in range(0, 5, n):\n        m += i\n    return m",
    "numba's own function": "return n**n",
}
CANNOT_FAIL = {
    "a division by 0": "return 5 // n + 5 % n",
    "a step that is not 0": "m = 0\n    for i in range(0, n, 2):\n        m += i\n    return m",
    "an index of an array": "return TABLE[n]",
}
MODULE = """
    from ctypes import c_int64

    import numpy as np

    from carom.dsp.native.jit import c_function, kernel

    TABLE = np.array([1, 2, 3])

    @kernel
    def raises(n):
        if n > 3:
            raise ValueError("more than 3")
        return n

    @kernel
    def culprit(n):
        BODY

    @c_function(c_int64, c_int64)
    def call(n):
        return culprit(n)
"""


@pytest.mark.parametrize("case", REFUSED)
def test_a_kernel_that_can_fail_is_refused_by_name(empty, case):
    empty.write("functions.py", dedent(MODULE).replace("BODY", REFUSED[case]))
    name = "raises" if case.startswith("calls") else "culprit"
    with pytest.raises(TypeError, match=rf"small.functions:{name}: this kernel can fail"):
        empty.start()


@pytest.mark.parametrize("case", CANNOT_FAIL)
def test_a_kernel_that_cannot_fail_is_not_refused(empty, case):
    empty.write("functions.py", dedent(MODULE).replace("BODY", CANNOT_FAIL[case]))
    assert empty.start().translated == 2


PROCESSORS = {"generic": "", "znver2": "+avx,+avx2,+bmi,+bmi2,+fma", "skylake-avx512": "+avx2,+avx512f,+avx512vl,+fma"}
"""LLVM's names of processors that numba may find, and what they can do."""
LOOP = """
    from ctypes import c_int64, c_void_p

    import numpy as np

    from carom.dsp.native.jit import c_function, carray, kernel

    @kernel
    def add_rows(x, n):
        for m in range(0, n, 4):
            rows = (x[n], 2 * x[n], 3 * x[n], 4 * x[n], 5 * x[n], 6 * x[n], 7 * x[n], 8 * x[n])
            for k in range(min(4, n - m)):
                x[m + k] += rows[k]
                if n > 5:
                    x[32 + m + k] += rows[4 + k]

    @c_function(None, c_void_p, c_int64)
    def call(address, n):
        add_rows(carray(address, (64,), np.dtype(np.float64)), n)
"""


@pytest.mark.slow
def test_a_kernel_is_translated_alike_whatever_processor_numba_finds(empty):
    """An index of a tuple is checked: only where LLVM unrolls its loop is it seen that it can't fail."""
    empty.write("functions.py", dedent(LOOP))
    code = {}
    for name, features in PROCESSORS.items():
        found = {"NUMBA_CPU_NAME": name, "NUMBA_CPU_FEATURES": features}
        env = os.environ | found | {"PYTHONPATH": str(empty.folder), "XDG_CACHE_HOME": str(empty.folder / name)}
        run = subprocess.run([sys.executable, "-c", APART], env=env, capture_output=True, text=True)
        assert run.returncode == 0, f"{name}: {run.stderr}"
        code[name] = run.stdout
    assert len(set(code.values())) == 1


def test_a_function_that_numba_compiles_is_refused_in_a_kernel(empty):
    """An edit of it would not be seen."""
    other = "\nfrom numba import njit\n\n@njit\ndef other(n):\n    return n\n"
    empty.write("functions.py", dedent(MODULE).replace("BODY", "return other(n)") + other)
    with pytest.raises(
        TypeError, match=r"small.functions:other is compiled by numba itself: a kernel calls kernels only"
    ):
        empty.start()


@pytest.mark.parametrize("body", ["return culprit(n - 1)", "return other(n)"])
def test_a_kernel_that_calls_itself_is_refused(empty, body):
    other = "\n@kernel\ndef other(n):\n    return culprit(n)\n"
    empty.write("functions.py", dedent(MODULE).replace("BODY", body) + other)
    with pytest.raises(TypeError, match=r"small.functions:culprit calls itself"):
        empty.start()


WRONG = {
    "TABLE[0].lengthh": r"functions\.py:{line}: no field 'lengthh'; did you mean length\?$",
    "TABLE[0].length + 'm'": r"functions\.py:{line}: No implementation of function .*add.* found for signature:$",
    "missing(n)": r"functions\.py:{line}: NameError: name 'missing' is not defined$",
    "raises(n, n)": r"functions\.py:{line}: Cannot bind .* too many positional arguments",
}


@pytest.mark.parametrize("wrong", WRONG)
def test_a_kernel_that_is_wrong_is_refused_by_its_line_in_a_short_traceback(empty, wrong):
    text = (
        dedent(MODULE)
        .replace("BODY", f"return {wrong}")
        .replace("np.array([1, 2, 3])", "np.zeros(3, [('length', float)])")
    )
    empty.write("functions.py", text)
    line = text[: text.index(wrong)].count("\n") + 1
    with pytest.raises(TypeError, match=WRONG[wrong].format(line=line)) as refused:
        empty.start()
    assert len(refused.traceback) < 5


@kernel
def _rest(x):
    return x[1:]


@njit
def _rests(x, n):
    total = 0.0
    for _ in range(n):
        total += _rest(x)[0]
    return total, _rest(x)


def test_an_array_that_a_kernel_returns_is_counted_by_whoever_called_it():
    x = np.arange(4.0)
    before = sys.getrefcount(x)
    total, rest = _rests(x, 100)
    again = _rest(x)
    assert total == 100.0 and sys.getrefcount(x) == before + 2
    assert rest.tolist() == again.tolist() == [1.0, 2.0, 3.0]
    del rest, again
    assert sys.getrefcount(x) == before
