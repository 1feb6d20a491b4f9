"""All that Carom takes from numba beyond its documented names: nothing else imports or changes these.

A test translates a kernel with the numba that is installed, so that a release that moves a name fails there.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from llvmlite import ir
from numba.core import cgutils, typed_passes, types, typing, untyped_passes
from numba.core.base import BaseContext
from numba.core.callconv import excinfo_t
from numba.core.codegen import JITCodeLibrary, _parse_refprune_flags
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import register_pass
from numba.core.datamodel import models, register_default
from numba.core.dispatcher import _FunctionCompiler
from numba.core.lowering import Lower
from numba.core.registry import cpu_target
from numba.core.runtime.context import NRTContext
from numba.core.typed_passes import NativeLowering
from numba.core.types.misc import unliteral

__all__ = [
    "JITCodeLibrary",
    "call_symbol",
    "cgutils",
    "compiler_into",
    "compiler_of",
    "define_call",
    "global_compiler_lock",
    "quiet_compiler",
    "refprune_flags",
    "register_opaque",
    "type_of",
    "types",
    "typing",
    "unliteral",
]

# numba writes the types of all arguments as text before each of its passes, in case somebody asks. An engine's state
# is a record of records: their texts, each with all its fields, took a quarter of the time.
types.Record.__repr__ = lambda record: record.name

refprune_flags = _parse_refprune_flags

_UNUSED = (
    *("WithLifting", "InlineClosureLikes", "RewriteDynamicRaises", "MakeFunctionToJitFunction", "InlineInlinables"),
    *("FindLiterallyCalls", "LiteralUnroll", "LiteralPropagationSubPipelinePass"),
    *("InlineOverloads", "AnnotateTypes", "DumpParforDiagnostics"),
)
"""Passes for closures, `with`, `literal_unroll`, `prange` and inlined overloads, which no kernel has."""


def type_of(value: Any) -> Any:
    """Return the type that numba knows a global value by."""
    return cpu_target.typing_context.resolve_value_type(value)


def refresh() -> None:
    """Make numba look at what was registered since."""
    cpu_target.typing_context.refresh()
    cpu_target.target_context.refresh()


def register_opaque(kind: type) -> None:
    """Tell numba that values of a type of its own hold no data."""
    register_default(kind)(models.OpaqueModel)


def compiler_of(function: Callable[..., Any], options: dict[str, Any], pipeline: type) -> Any:
    """Return numba's compiler of one function: `fold_argument_types(args, kws)` and `compile(args, None)`."""
    return _FunctionCompiler(function, cpu_target, options, {}, pipeline)


def compiler_into(library: type) -> type:
    """Return numba's usual compiler, without the passes that no kernel needs, which writes LLVM's code into a library
    of a class of ours, and no more."""
    unused = {getattr(where, name, None) for where in (untyped_passes, typed_passes) for name in _UNUSED}
    lowering = _lowering_into(library)

    class Compiler(CompilerBase):  # type: ignore[misc]
        def define_pipelines(self) -> list[Any]:
            pipeline = DefaultPassBuilder.define_nopython_pipeline(self.state)
            pipeline.add_pass_after(lowering, NativeLowering)
            pipeline.passes = [each for each in pipeline.passes if each[0] not in {NativeLowering, *unused}]
            pipeline.finalize()
            return [pipeline]

    return Compiler


def _lowering_into(library: type) -> type:
    class Lowering(NativeLowering):  # type: ignore[misc]
        _name = f"lowering_into_{library.__name__}"

        def run_pass(self, state: Any) -> bool:
            state.library = library(state.targetctx.codegen(), state.func_id.func_qualname)
            state.library.enable_object_caching()
            state.flags.no_compile = True
            return bool(super().run_pass(state))

    register_pass(mutates_CFG=True, analysis_only=False)(Lowering)
    return Lowering


def define_call(symbol: Any, argument_types: tuple[Any, ...], libraries: tuple[Any, ...], key: object) -> None:
    """Tell numba how a call is written whose implementation has a key: by LLVM's symbol, its status unread.

    symbol: numba's description of the function. libraries: code that is linked where an ordinary function calls it.
    """

    def implementation(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return call_symbol(context, builder, symbol, args)

    implementation.signature = argument_types  # type: ignore[attr-defined]
    implementation.libs = libraries  # type: ignore[attr-defined]
    cpu_target.target_context._defns[key].append(implementation, argument_types)


def call_symbol(context: Any, builder: Any, symbol: Any, args: Any) -> Any:
    """Write a call of a kernel by its symbol. A kernel can't fail, so that nobody reads the status it returns."""
    function = context.declare_function(builder.module, symbol)
    convention = context.call_conv
    returned = cgutils.alloca_once(builder, convention.get_return_type(symbol.restype).pointee)
    error = cgutils.alloca_once(builder, ir.PointerType(excinfo_t), name="excinfo")
    packed = convention._get_arg_packer(symbol.argtypes).as_arguments(builder, args)
    builder.call(function, [returned, error, *packed])
    return context.get_returned_value(builder, symbol.restype, builder.load(returned))


@contextmanager
def quiet_compiler(mangle: Callable[[str, tuple[Any, ...]], str]) -> Iterator[None]:
    """Prepare numba to compile kernels, and nothing else, while this is entered.

    Kernels own nothing: reference counts are not written. Names hold no counters of this process: `mangle` makes them,
    of a function's name and the types of its arguments. LLVM is asked once for the size of each type.
    """
    sizes: dict[str, int] = {}
    size_of = BaseContext.get_abi_sizeof

    def remembered(context: Any, kind: Any) -> int:
        name = str(kind)
        if name not in sizes:
            sizes[name] = size_of(context, kind)
        return sizes[name]

    def named(context: Any, name: str, args: Any, *, abi_tags: Any = (), uid: Any = None) -> str:
        return mangle(name, args)

    def nothing(*_: Any) -> None:
        pass

    changed: list[tuple[Any, str, Any]] = [
        *((where, name, nothing) for where in (Lower, NRTContext) for name in ("incref", "decref")),
        (BaseContext, "mangler", named),
        (BaseContext, "get_abi_sizeof", remembered),
    ]
    with global_compiler_lock:
        before = [(where, name, getattr(where, name)) for where, name, _ in changed]
        for where, name, value in changed:
            setattr(where, name, value)
        try:
            yield
        finally:
            for where, name, value in before:
                setattr(where, name, value)
