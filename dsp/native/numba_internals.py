"""All that Carom takes from numba beyond its documented names: nothing else imports or changes these.

A test translates kernels with the numba that is installed, so that a release that moves a name fails there, with the
name and numba's version.
"""

import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

import llvmlite.binding as llvm
from llvmlite import ir
from numba.core import cgutils, typed_passes, types, typing, untyped_passes
from numba.core.base import BaseContext
from numba.core.callconv import CPUCallConv, excinfo_t
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import register_pass
from numba.core.datamodel import models, register_default
from numba.core.dispatcher import _FunctionCompiler
from numba.core.errors import TypingError
from numba.core.lowering import Lower
from numba.core.registry import cpu_target
from numba.core.runtime.context import NRTContext
from numba.core.typed_passes import NativeLowering
from numba.core.types.misc import unliteral
from numba.cpython import slicing
from numba.np import arrayobj
from numba.np.unsafe.ndarray import to_fixed_tuple

from ..wording import suggestion
from .checked import changes
from .targets import Target

__all__ = [
    "cgutils",
    "compiler_of",
    "define_call",
    "global_compiler_lock",
    "lowered",
    "place_and_cause",
    "quiet_compiler",
    "refresh",
    "register_opaque",
    "target_machine",
    "to_fixed_tuple",
    "type_of",
    "types",
    "typing",
    "unliteral",
]

# numba writes the types of all arguments as text before each of its passes, in case somebody asks. An engine's state
# is a record of records: their texts, each with all its fields, took a quarter of the time.
types.Record.__repr__ = lambda record: record.name


def _type_of_field(record: Any, field: str) -> Any:
    """Return the type of a record's field. numba raises a KeyError where there is none, and doesn't say where."""
    if field not in record.fields:
        raise TypingError(f"no field {field!r}; {suggestion(field, record.fields)}".rstrip("; "))
    return record.fields[field].type


types.Record.typeof = _type_of_field

_UNUSED = (
    *("WithLifting", "InlineClosureLikes", "RewriteDynamicRaises", "MakeFunctionToJitFunction", "InlineInlinables"),
    *("FindLiterallyCalls", "LiteralUnroll", "LiteralPropagationSubPipelinePass"),
    *("InlineOverloads", "AnnotateTypes", "DumpParforDiagnostics"),
)
"""Passes for closures, `with`, `literal_unroll`, `prange` and inlined overloads, which no kernel has."""

_INTERNAL: dict[Any, Any] = {}
"""Functions that numba has compiled for kernels, as numba keeps them."""

_NUMBERS = types.Number, types.Boolean, types.Literal
_CALLS: dict[tuple[Any, Any], Any] = {}
"""The signatures of operators for numbers, as numba finds them."""


def type_of(value: Any) -> Any:
    """Return the type that numba knows a global value by."""
    return cpu_target.typing_context.resolve_value_type(value)


def place_and_cause(error: Any) -> str:
    """Say in a line where a kernel is wrong, and what numba finds wrong with it."""
    text = str(error)
    places = re.findall(r"^During: typing of .* at (\S+) \((\d+)\)", text, re.MULTILINE)
    file, line = places[0] if places else (error.loc.filename, error.loc.line) if error.loc else ("a kernel", 0)
    cause = next(each for each in text.splitlines() if each and not each.startswith("Failed in nopython"))
    return f"{file}:{line}: {re.sub(r'Record[(].*;(True|False)[)]', 'a record', cause)}"


def refresh() -> None:
    """Make numba look at what was registered since."""
    cpu_target.typing_context.refresh()
    cpu_target.target_context.refresh()


def register_opaque(kind: type) -> None:
    """Tell numba that values of a type of its own hold no data."""
    register_default(kind)(models.OpaqueModel)


@cache
def target_machine() -> Any:
    """Return the processor that kernels are translated and judged for: one for all, so that no kernel is refused, or
    written otherwise, on another."""
    return Target("linux", "x86-64-v2").machine()


def pointer_of(parts: Any) -> Any:
    """Return LLVM's pointer to the parts of an array, as numba writes them."""
    return parts._getpointer()


class _OwnCode(JITCodeLibrary):
    """A kernel's own module; the functions that numba itself compiles for it are linked in."""

    def _optimize_functions(self, ll_module: Any) -> None:
        """Make functions small, and no more.

        LLVM's passes for functions, which numba runs, take a condition that stays the same out of its loop by writing
        the loop twice. A loop around a call doubles all that is called.
        """
        ll_module.data_layout = self._codegen._data_layout
        builder = llvm.create_pass_builder(target_machine(), llvm.create_pipeline_tuning_options(speed_level=1))
        passes = llvm.create_new_function_pass_manager()
        passes.add_sroa_pass()
        passes.add_simplify_cfg_pass()
        passes.add_instruction_combine_pass()
        passes.add_simplify_cfg_pass()
        passes.add_dead_code_elimination_pass()
        for function in ll_module.functions:
            if not function.is_declaration:
                passes.run(function, builder)

    def finalize(self) -> None:
        foreign = [each for each in dict.fromkeys(self._linking_libraries) if not isinstance(each, _WholeCode)]
        for library in foreign:
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        for function in self._final_module.functions if foreign else ():
            if not function.is_declaration and str(function.linkage).endswith("linkonce_odr"):
                function.linkage = "internal"
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        return 0  # nobody calls it here


class _WholeCode(JITCodeLibrary):
    """A kernel with all that it calls, to be linked into an ordinary function of numba's.

    parts: returns the bitcode of all of them.
    """

    def __init__(self, name: str, parts: Callable[[], Iterable[bytes]]) -> None:
        super().__init__(cpu_target.target_context.codegen(), name)
        self._parts = parts
        self._finalized = True

    def _get_module_for_linking(self) -> Any:
        if self._shared_module is None:
            for each in self._parts():
                self._final_module.link_in(llvm.parse_bitcode(each))
        return super()._get_module_for_linking()


@register_pass(mutates_CFG=True, analysis_only=False)
class _Lowering(NativeLowering):
    _name = "lowering_of_own_code"

    def run_pass(self, state: Any) -> bool:
        state.library = _OwnCode(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        state.flags.no_compile = True
        return bool(super().run_pass(state))


class _Compiler(CompilerBase):
    """numba's usual compiler, without the passes that no kernel needs, which writes LLVM's code and no more."""

    def define_pipelines(self) -> list[Any]:
        unused = {getattr(where, name, None) for where in (untyped_passes, typed_passes) for name in _UNUSED}
        pipeline = DefaultPassBuilder.define_nopython_pipeline(self.state)
        pipeline.add_pass_after(_Lowering, NativeLowering)
        pipeline.passes = [each for each in pipeline.passes if each[0] not in {NativeLowering, *unused}]
        pipeline.finalize()
        return [pipeline]


def compiler_of(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """Return numba's compiler of one function: `fold_argument_types(args, kws)` and `compile(args, returned)`."""
    return _FunctionCompiler(function, cpu_target, options, {}, _Compiler)


def lowered(
    function: Callable[..., Any], options: dict[str, Any], argument_types: tuple[Any, ...], returned: Any = None
) -> tuple[Any, Any]:
    """Return numba's description of a function, and LLVM's module of its own code."""
    compiled = compiler_of(function, options).compile(argument_types, returned)
    compiled.library._ensure_finalized()
    return compiled.fndesc, compiled.library._final_module


def define_call(symbol: Any, argument_types: tuple[Any, ...], parts: Callable[[], Iterable[bytes]]) -> object:
    """Tell numba how a kernel is called: by LLVM's symbol, its status unread. Return the key that finds it.

    symbol: as numba describes a function. parts: returns the bitcode that an ordinary function that calls it is linked
    with.
    """

    def implementation(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _call_symbol(context, builder, symbol, args)

    key = object()
    implementation.signature = argument_types  # type: ignore[attr-defined]
    implementation.libs = (_WholeCode(symbol.mangled_name, parts),)  # type: ignore[attr-defined]
    cpu_target.target_context._defns[key].append(implementation, argument_types)
    return key


def _call_symbol(context: Any, builder: Any, symbol: Any, args: Any) -> Any:
    """Write a call of a kernel by its symbol. A kernel can't fail, so that nobody reads the status it returns."""
    function = context.declare_function(builder.module, symbol)
    function.attributes.discard("alwaysinline")  # its own code says so, which may be edited without that of its callers
    convention = context.call_conv
    returned = cgutils.alloca_once(builder, convention.get_return_type(symbol.restype).pointee)
    error = cgutils.alloca_once(builder, ir.PointerType(excinfo_t), name="excinfo")
    packed = convention._get_arg_packer(symbol.argtypes).as_arguments(builder, args)
    builder.call(function, [returned, error, *packed])
    value = context.get_returned_value(builder, symbol.restype, builder.load(returned))
    context.nrt.incref(builder, symbol.restype, value)  # an ordinary function counts: a kernel returns no reference
    return value


@contextmanager
def quiet_compiler(mangle: Callable[[str, tuple[Any, ...]], str]) -> Iterator[None]:
    """Prepare numba to compile kernels, and nothing else, while this is entered.

    Kernels own nothing: reference counts are not written. Names hold no counters of this process: `mangle` makes them,
    of a function's name and the types of its arguments. Errors, which kernels never meet, hold no paths of files. An
    index counts from the beginning: code that looks whether it is negative took 8 % of the time of rolls. LLVM
    is asked once for the size of each type. Functions that numba compiles for kernels are kept apart from those for
    others, which count references and have other names. What an operator returns for numbers is looked up once: that
    took a tenth of the time.
    """
    sizes: dict[str, int] = {}
    size_of, call_type = BaseContext.get_abi_sizeof, types.BaseFunction.get_call_type

    def remembered(context: Any, kind: Any) -> int:
        name = str(kind)
        if name not in sizes:
            sizes[name] = size_of(context, kind)
        return sizes[name]

    def named(context: Any, name: str, args: Any, *, abi_tags: Any = (), uid: Any = None) -> str:
        return mangle(name, args)

    def known_call(function: Any, context: Any, args: Any, kws: Any) -> Any:
        operator = getattr(function.typing_key, "__module__", "") == "_operator"
        if not operator or kws or not all(isinstance(each, _NUMBERS) for each in args):
            return call_type(function, context, args, kws)
        if (function, args) not in _CALLS:
            _CALLS[function, args] = call_type(function, context, args, kws)
        return _CALLS[function, args]

    def unplaced(convention: Any, error: Any, arguments: Any, place: Any, name: Any) -> tuple[Any, Any, None]:
        return error, arguments, None

    def nothing(*_: Any) -> None:
        pass

    def from_the_beginning(context: Any, builder: Any, kind: Any, index: Any, size: Any) -> Any:
        return context.cast(builder, index, kind, types.intp)

    changed: list[tuple[Any, str, Any]] = [
        (arrayobj, "fix_integer_index", from_the_beginning),
        *((where, name, nothing) for where in (Lower, NRTContext) for name in ("incref", "decref")),
        (BaseContext, "mangler", named),
        (CPUCallConv, "build_excinfo_struct", unplaced),
        (BaseContext, "get_abi_sizeof", remembered),
        (types.BaseFunction, "get_call_type", known_call),
        (cpu_target.target_context, "cached_internal_func", _INTERNAL),
        *changes(Lower, BaseContext, cgutils, slicing, pointer_of),
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
