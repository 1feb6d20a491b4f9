"""How Carom's kernels are compiled: the one place where numba's settings live.

All kernels end inside one function, the audio callback (or a test's, or a study's): there are two hundred of them, one
in the other. numba would optimise each with all that is in it, again and again, and make machine code of it and
wrappers to call it from Python, which next to nobody does; that took over half of the time. So a kernel is only
translated, and the function that it ends in is optimised, once.
"""

from collections.abc import Callable
from typing import Any

import llvmlite.binding as llvm
from numba import njit
from numba.core.codegen import JITCodeLibrary, _parse_refprune_flags
from numba.core.compiler import CompilerBase, DefaultPassBuilder, _LowerResult
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import NativeLowering
from numba.core.types.misc import unliteral


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


class _Whole(_Library):
    """The code of a function that kernels end in.

    Two runs of LLVM's optimiser: a scalar one, after which LLVM sees that no kernel can fail and drops the error paths,
    then the full one. The scalar run must not unroll loops: the full one vectorises unrolled modal loops by scatter
    and gather, which is 2.4 times slower.
    """

    def _optimize_final_module(self) -> None:
        tuning = llvm.create_pipeline_tuning_options(speed_level=1)
        tuning.loop_unrolling = tuning.loop_interleaving = False
        tuning.loop_vectorization = tuning.slp_vectorization = False
        scalar = llvm.create_pass_builder(self._codegen._tm, tuning)
        scalar.getModulePassManager().run(self._final_module, scalar)
        full, builder = self._codegen._module_pass_manager()
        full.run(self._final_module, builder)


@register_pass(mutates_CFG=True, analysis_only=False)
class _Completion(NativeLowering):
    _name = "completion_of_kernels"

    def run_pass(self, state: Any) -> bool:
        state.library = _Whole(state.targetctx.codegen(), state.func_id.func_qualname)
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


def _compiler(lowering: type) -> type:
    """numba's usual compiler, but for its last step."""

    class Compiler(CompilerBase):
        def define_pipelines(self) -> list[Any]:
            pipeline = DefaultPassBuilder.define_nopython_pipeline(self.state)
            pipeline.add_pass_after(lowering, NativeLowering)
            pipeline.passes = [each for each in pipeline.passes if each[0] is not NativeLowering]
            pipeline.finalize()
            return [pipeline]

    return Compiler


WHOLE = _compiler(_Completion)
"""The `pipeline_class` for a function in which nothing may be left of errors that its kernels can't have."""

# Without forceinline the error paths of calls stay in the compiled callback (and with them the Python API),
# and a fresh and a cache-loaded compilation differ in bits.
_SAFE: dict[str, Any] = {
    "forceinline": True, "error_model": "numpy", "pipeline_class": _compiler(_Translation),
    "no_cpython_wrapper": True, "no_cfunc_wrapper": True,
}  # fmt: skip

# What the modal sums need to become SIMD reductions; closed forms are compiled without it.
_REASSOCIATE = {"contract", "reassoc", "nsz"}


def kernel(function: Callable[..., Any]) -> Any:
    """Decorator: a kernel with strict IEEE arithmetic. Called from Python, it runs as a function of its own."""
    return _also_from_python(_once_for_all_numbers(njit(**_SAFE)(function)))


def simd_kernel(function: Callable[..., Any]) -> Any:
    """Decorator: a kernel whose sums may be reordered into vector lanes."""
    return _also_from_python(_once_for_all_numbers(njit(**_SAFE, fastmath=_REASSOCIATE)(function)))


def _once_for_all_numbers(part: Any) -> Any:
    """To numba a number that is written out is a type of its own, for which a kernel would be translated once more."""
    resolve = part.get_call_template

    def resolve_plain(args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
        return resolve(tuple(map(unliteral, args)), {name: unliteral(kind) for name, kind in kws.items()})

    part.get_call_template = resolve_plain
    return part


def _also_from_python(part: Any) -> Any:
    @njit(error_model="numpy")
    def whole(*args):
        return part(*args)

    part._insert = lambda *_: None  # so the dispatcher finds nothing to run, and asks for it
    part._compile_for_args = lambda *_, **__: whole
    return part
