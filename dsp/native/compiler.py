"""Compilation of Carom's kernels by numba and LLVM: the one place where their settings live.

All kernels end inside one function, the audio callback (or a test's, or a study's): there are hundreds of them, one in
the other. numba would optimise each with all that is in it, again and again, and make machine code of it and wrappers
to call it from Python, which next to nobody does; that took over half of the time. So a kernel is only translated, and
the function that it ends in is optimised, once.
"""

import ctypes
from collections.abc import Callable
from typing import Any

import llvmlite.binding as llvm
from numba import cfunc, njit, types
from numba.core.codegen import JITCodeLibrary, _parse_refprune_flags
from numba.core.compiler import CompilerBase, DefaultPassBuilder, _LowerResult
from numba.core.compiler_machinery import register_pass
from numba.core.registry import cpu_target
from numba.core.typed_passes import NativeLowering
from numba.core.types.misc import unliteral
from numba.extending import intrinsic

from .jit import CFunction
from .platforms import assembly
from .targets import Target

# numba writes the types of all arguments as text before each of its passes, in case somebody asks. An engine's state
# is a record of records: their texts, each with all its fields, took a quarter of the time.
types.Record.__repr__ = lambda record: record.name


class _Library(JITCodeLibrary):
    """Code whose functions are made small, and no more, before they are linked.

    LLVM's passes for functions, which numba runs, take a condition that stays the same out of its loop by writing the
    loop twice. A loop around a call doubles all that is called: the whole engine did so with its channels' number.
    """

    def _optimize_functions(self, ll_module: Any) -> None:
        ll_module.data_layout = self._codegen._data_layout
        tuning = llvm.create_pipeline_tuning_options(speed_level=1)
        builder = llvm.create_pass_builder(self._codegen._tm, tuning)
        passes = llvm.create_new_function_pass_manager()
        passes.add_sroa_pass()
        passes.add_simplify_cfg_pass()
        passes.add_instruction_combine_pass()
        passes.add_simplify_cfg_pass()
        passes.add_dead_code_elimination_pass()
        passes.add_refprune_pass(_parse_refprune_flags())
        for function in ll_module.functions:
            if not function.is_declaration:
                passes.run(function, builder)


class _Part(_Library):
    """A kernel's code: to be linked into others, never to be run by itself."""

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True


def optimise(module: Any, target: Target) -> None:
    """Run LLVM's optimiser for a target; its vectors decide in which order sums are taken.

    Two runs: a scalar one, after which LLVM sees that no kernel can fail and drops the error paths, then the full one.
    The scalar run must not unroll loops: the full one vectorises unrolled modal loops by scatter and gather, which is
    2.4 times slower.
    """
    machine = target.machine()
    tuning = llvm.create_pipeline_tuning_options(speed_level=1)
    tuning.loop_unrolling = tuning.loop_interleaving = False
    tuning.loop_vectorization = tuning.slp_vectorization = False
    scalar = llvm.create_pass_builder(machine, tuning)
    scalar.getModulePassManager().run(module, scalar)
    tuning = llvm.create_pipeline_tuning_options(speed_level=3)
    tuning.loop_vectorization, tuning.slp_vectorization = True, False
    full = llvm.create_pass_builder(machine, tuning)
    passes = full.getModulePassManager()
    passes.add_refprune_pass(_parse_refprune_flags())
    passes.run(module, full)


class _Written(_Part):
    """The code of a function of C's, not optimised yet."""

    def get_pointer_to_function(self, name: str) -> int:
        self._ensure_finalized()
        return 0


@register_pass(mutates_CFG=True, analysis_only=False)
class _Writing(NativeLowering):
    _name = "writing_of_a_function"

    def run_pass(self, state: Any) -> bool:
        state.library = _Written(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return bool(super().run_pass(state))


@register_pass(mutates_CFG=True, analysis_only=False)
class _Translation(NativeLowering):
    _name = "translation_of_a_kernel"

    def run_pass(self, state: Any) -> bool:
        state.library = _Part(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        state.flags.no_compile = True
        super().run_pass(state)
        translated = state["cr"]
        stand_in = object()  # what numba knows it by
        state.targetctx.insert_user_function(stand_in, translated.fndesc, [state.library])
        state["cr"] = _LowerResult(translated.fndesc, translated.call_helper, cfunc=stand_in, env=translated.env)
        return True


@register_pass(mutates_CFG=True, analysis_only=False)
class _TranslationApart(_Translation):
    _name = "translation_of_a_kernel_that_is_not_inlined"

    def run_pass(self, state: Any) -> bool:
        super().run_pass(state)
        state.library.get_function(state["cr"].fndesc.llvm_func_name).add_function_attribute("noinline")
        return True


def _compiler(lowering: type) -> type:
    """Return numba's usual compiler, but for its last step."""

    class Compiler(CompilerBase):
        def define_pipelines(self) -> list[Any]:
            pipeline = DefaultPassBuilder.define_nopython_pipeline(self.state)
            pipeline.add_pass_after(lowering, NativeLowering)
            pipeline.passes = [each for each in pipeline.passes if each[0] is not NativeLowering]
            pipeline.finalize()
            return [pipeline]

    return Compiler


_OF_C = _compiler(_Writing)
"""The `pipeline_class` for a function of C's: its code is only written down, to be made machine code of later."""

_SAFE: dict[str, Any] = {"error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
_INLINED: dict[str, Any] = {"forceinline": True, "pipeline_class": _compiler(_Translation)}
_APART: dict[str, Any] = {"forceinline": False, "pipeline_class": _compiler(_TranslationApart)}

# The flags with which modal sums become SIMD reductions; closed forms are compiled without them.
_REASSOCIATE = {"contract", "reassoc", "nsz"}


def part(function: Callable[..., Any], simd: bool, inlined: bool) -> Any:
    """Compile a kernel for numba: it is translated where another function calls it."""
    settings = _SAFE | (_INLINED if inlined else _APART) | ({"fastmath": _REASSOCIATE} if simd else {})
    compiled = njit(**settings)(function)
    resolve = compiled.get_call_template

    # To numba a number that is written out is a type of its own, for which a kernel would be translated once more.
    def resolve_plain(args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
        return resolve(tuple(map(unliteral, args)), {name: unliteral(kind) for name, kind in kws.items()})

    compiled.get_call_template = resolve_plain
    compiled._insert = lambda *_: None  # there is nothing that could be run from Python
    return compiled


def whole(part: Any) -> Any:
    """Compile a kernel as a function of its own."""

    @njit(error_model="numpy")
    def call(*args):
        return part(*args)

    return call


def type_of(value: Any) -> Any:
    """Return the type that numba knows a global value by."""
    return cpu_target.typing_context.resolve_value_type(value)


def type_of_intrinsic(function: Callable[..., Any]) -> Any:
    """Return the type of an intrinsic that was met while something else is compiled."""
    made = intrinsic(function)
    cpu_target.typing_context.refresh()
    cpu_target.target_context.refresh()
    return type_of(made)


def type_of_external(name: str, returned: Any, arguments: tuple[Any, ...]) -> Any:
    """Return the type of a function of the C library, whose pointers are numbers."""
    kinds = [types.uintp if each is ctypes.c_void_p else _KINDS[each] for each in arguments]
    return type_of(types.ExternalFunction(name, _KINDS[returned](*kinds)))


_KINDS = {
    None: types.void,
    ctypes.c_void_p: types.voidptr,
    ctypes.c_int: types.intc,
    ctypes.c_ulong: types.uint64,  # of which only the lower half is given on Windows
    ctypes.c_int64: types.int64,
    ctypes.c_double: types.float64,
}


def written(functions: list[CFunction]) -> Any:
    """Write LLVM's module of functions of C, each by its name, not optimised."""
    module = None
    for function in functions:
        signature = _KINDS[function.returned](*(_KINDS[each] for each in function.arguments))
        made = cfunc(signature, error_model="numpy", forceinline=True, pipeline_class=_OF_C)(function.py_func)
        one = made._library._final_module.clone()
        for each in [*one.functions, *one.global_variables]:
            if not each.is_declaration and each.name != made.native_name:
                each.linkage = "internal"
        one.get_function(made.native_name).name = function.py_func.__name__
        if module is None:
            module = one
        else:
            module.link_in(one)
    return module


def optimised(source: bytes, target: Target) -> Any:
    """Optimise LLVM's module of the bitcode of `written` for a target. TypeError if it needs Python."""
    module = llvm.parse_bitcode(source)
    machine = target.machine()
    support = llvm.parse_assembly(assembly(target.system, target.triple))
    for each in (module, support):
        each.triple, each.data_layout = target.triple, str(machine.target_data)
    names = [each.name for each in support.functions if not each.is_declaration]
    module.link_in(support)
    for name in names:
        module.get_function(name).linkage = "internal"
    optimise(module, target)
    passes = llvm.create_new_module_pass_manager()
    passes.add_global_dead_code_eliminate_pass()
    passes.add_strip_dead_prototype_pass()
    passes.run(module, llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options()))
    python = [each.name for each in module.functions if each.name.startswith(("Py", "numba_", "NRT_"))]
    if python:
        names = [each.name for each in module.functions if not each.is_declaration]
        raise TypeError(f"{', '.join(names)}: this code needs Python: {', '.join(python)}")
    return module


_OF_C_LIBRARY = ("sin", "cos", "tan", "exp", "exp2", "log", "log2", "log10", "pow")
"""Functions that LLVM has instructions for, and calls where a processor has none."""


def needed(module: Any) -> list[str]:
    """Return the functions of the system's libraries that the code of a module calls."""
    names = [each.name for each in module.functions if each.is_declaration]
    inner = [name.split(".")[1] for name in names if name.startswith("llvm.")]
    return sorted({name for name in names if not name.startswith("llvm.")} | set(inner) & set(_OF_C_LIBRARY))
