"""Kernels as LLVM's code: each a module of its own, kept on disk, and translated again only where it must be.

numba would optimise each kernel with all that is in it, again and again, make machine code of it and wrappers to call
it from Python, which next to nobody does. So a kernel is only translated here. Its module declares the kernels that it
calls, by names that are the same in every process. A translation holds as long as the kernel's own code is the same,
and each kernel that it calls returns the same type: an edit of one kernel translates that kernel.

No kernel can fail, or owns anything: whoever calls one reads no status and counts no references.
"""

import ctypes
import pickle
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from io import BytesIO
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
import numba
from numba.extending import intrinsic

from . import numba_internals as internals
from .digests import digest, name_of, own_digest
from .jit import KERNELS, CFunction, Kernel
from .numba_internals import JITCodeLibrary, types
from .sources import compiler_digest
from .store import Store, user_cache
from .units import Unit

_C: dict[str, Any] = {"nopython": True, "error_model": "numpy", "no_cpython_wrapper": True}
_SAFE = _C | {"no_cfunc_wrapper": True}

# What the modal sums need to become SIMD reductions; closed forms are compiled without it.
_REASSOCIATE = {"contract", "reassoc", "nsz"}


@dataclass
class Translation:
    """A kernel's own code for arguments of some types, as LLVM's bitcode, and the calls that it was translated for.

    The fields after `calls` are those that numba describes a function by.
    """

    kernel: str  # its name
    own: str  # the digest of its own code
    bitcode: bytes
    calls: list[tuple[str, tuple[Any, ...], Any]]  # the kernels that it calls: name, types of arguments, type returned
    mangled_name: str  # LLVM's symbol
    restype: Any
    argtypes: tuple[Any, ...]
    args: tuple[str, ...]  # their names
    inline: bool
    noalias: bool
    key: object = field(default=None, compare=False)  # what numba finds the way to call it by, in this process


class Translator:
    """Translates kernels, and keeps what it has translated.

    store: files of earlier translations.
    """

    def __init__(self, store: Store) -> None:
        self._store = store
        self.done: Callable[[Translation], None] = lambda _: None  # called with each; those that it calls come first
        self._known: dict[tuple[str, tuple[Any, ...]], Translation] = {}
        self._calls: list[list[tuple[str, tuple[Any, ...], Any]]] = [[]]
        self._running: list[tuple[str, tuple[Any, ...]]] = []
        self.count = 0  # of those that were translated anew

    def kernel(self, kernel: Kernel, argument_types: tuple[Any, ...]) -> Translation:
        """Return a kernel's translation: of this process, of an earlier one, or made now."""
        name = name_of(kernel)
        found = self._known.get((name, argument_types))
        if found is None or found.own != own_digest(kernel):
            found = self._made(kernel, name, argument_types, lambda: _translated(kernel, argument_types))
            found.key = object()
            internals.define_call(found, argument_types, (_Linked(self, found),), found.key)
        self._calls[-1].append((name, argument_types, found.restype))
        return found

    def c_function(self, function: CFunction) -> Translation:
        """Return the translation of a function of C."""
        signature = _KINDS[function.returned](*(_KINDS[each] for each in function.arguments))
        return self._made(function, name_of(function), signature.args, lambda: _translated_c(function, signature))

    def called_by(self, translation: Translation) -> list[Translation]:
        """Return the translations of the kernels that one calls."""
        return [self._known[name, types] for name, types, _ in translation.calls]

    def unit(self, translation: Translation) -> Unit:
        """Return a function that is not inlined as a unit, with all that is inlined into it."""
        parts, waiting = {translation.mangled_name: translation}, [translation]
        while waiting:
            for each in self.called_by(waiting.pop()):
                if each.inline and each.mangled_name not in parts:
                    parts[each.mangled_name] = each
                    waiting.append(each)
        return Unit(translation.mangled_name, tuple(each.bitcode for each in parts.values()))

    def _made(
        self, kernel: Any, name: str, argument_types: tuple[Any, ...], translate: Callable[[], Translation]
    ) -> Translation:
        key = name, argument_types
        if key in self._running:
            raise TypeError(f"{name} calls itself: a kernel can't")
        self._running.append(key)
        file = f"{digest(f'{name} {own_digest(kernel)}')}-{_digest_of(argument_types)}"
        try:
            made = self._kept(file, argument_types)
            if made is None:
                with self._collecting() as calls, internals.quiet_compiler(_symbol):
                    made = translate()
                made.kernel, made.own, made.calls = name, own_digest(kernel), list(dict.fromkeys(calls))
                self._store.write_translation(file, _pickled(made, self._store))
                self.count += 1
        finally:
            self._running.pop()
        self._known[key] = made
        self.done(made)
        return made

    def _kept(self, file: str, argument_types: tuple[Any, ...]) -> Translation | None:
        """Return a translation of an earlier process, if all that it calls still returns the same types."""
        content = self._store.read_translation(file)
        try:
            kept = _unpickled(content, self._store) if content else None
            if kept is None or kept.argtypes != argument_types:
                return None
            with self._collecting():
                holds = all(self.kernel(_named(name), args).restype == kind for name, args, kind in kept.calls)
        except (LookupError, ImportError, AttributeError, ValueError, pickle.UnpicklingError, numba.NumbaError):
            return None
        return kept if holds else None

    @contextmanager
    def _collecting(self) -> Iterator[list[tuple[str, tuple[Any, ...], Any]]]:
        """Collect the kernels that are called meanwhile."""
        self._calls.append([])
        try:
            yield self._calls[-1]
        finally:
            self._calls.pop()


def translator(store: Store | None = None) -> Translator:
    """Return the translator of this process, for a store: the user's cache if not given."""
    store = store or Store(user_cache(), compiler_digest())
    return _translator(store.root)


@cache
def _translator(root: Path) -> Translator:
    return Translator(Store(root, compiler_digest()))


def _named(name: str) -> Kernel:
    """Return the kernel of a name; LookupError if there is none any more."""
    path, _, own = name.partition("@")
    if path not in KERNELS:
        import_module(path.partition(":")[0])
    for kernel in reversed(KERNELS[path]):
        if not own or own_digest(kernel) == own:
            return kernel
    raise LookupError(name)


def _translated(kernel: Kernel, argument_types: tuple[Any, ...]) -> Translation:
    simd, inlined = kernel.settings
    options = _SAFE | {"forceinline": inlined} | ({"fastmath": _REASSOCIATE} if simd else {})
    compiled = internals.compiler_of(kernel.py_func, options, _COMPILER).compile(argument_types, None)
    compiled.library._ensure_finalized()
    described, module = compiled.fndesc, compiled.library._final_module
    _check_that_it_cannot_fail(kernel, module, described.mangled_name)
    if not inlined:
        module.get_function(described.mangled_name).add_function_attribute("noinline")
    name = f"{described.mangled_name}{own_digest(kernel) if '<locals>' in kernel.py_func.__qualname__ else ''}"
    module.get_function(described.mangled_name).name = name
    return Translation(
        kernel="",
        own="",
        bitcode=module.as_bitcode(),
        calls=[],
        mangled_name=name,
        restype=described.restype,
        argtypes=described.argtypes,
        args=described.args,
        inline=described.inline,
        noalias=described.noalias,
    )


def _translated_c(function: CFunction, signature: Any) -> Translation:
    compiler = internals.compiler_of(function.py_func, _C | {"forceinline": True}, _COMPILER)
    compiled = compiler.compile(signature.args, signature.return_type)
    compiled.library._ensure_finalized()
    described, module = compiled.fndesc, compiled.library._final_module
    _check_that_it_cannot_fail(function, module, described.mangled_name)
    wrapper, name = described.llvm_cfunc_wrapper_name, function.py_func.__name__
    for each in [*module.functions, *module.global_variables]:
        if not each.is_declaration and each.name != wrapper:
            each.linkage = "internal"
    module.get_function(wrapper).name = name
    return Translation(
        kernel="",
        own="",
        bitcode=module.as_bitcode(),
        calls=[],
        mangled_name=name,
        restype=signature.return_type,
        argtypes=signature.args,
        args=(),
        inline=False,
        noalias=False,
    )


def _check_that_it_cannot_fail(kernel: Any, module: Any, symbol: str) -> None:
    """Refuse a kernel whose code can return a status other than 0: nobody would read it."""
    if _can_fail(module.get_function(symbol)):
        whole = module.clone()  # what numba has compiled for it may fail, though not for the arguments that it gives
        for each in whole.functions:
            if not each.is_declaration and each.name != symbol:
                each.linkage = "internal"
                each.add_function_attribute("alwaysinline")
        machine = internals.cpu_target.target_context.codegen()._tm
        passes = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(speed_level=2))
        passes.getModulePassManager().run(whole, passes)
        if _can_fail(whole.get_function(symbol)):
            raise TypeError(f"{name_of(kernel)}: this kernel can fail: it raises, or does what may raise")


def _can_fail(function: Any) -> bool:
    return any(status != "0" for status in re.findall(r"^ +ret i32 (\S+)", str(function), re.MULTILINE))


class _Own(JITCodeLibrary):  # type: ignore[misc]
    """A kernel's own module; the functions that numba itself compiles for it are linked in."""

    def _optimize_functions(self, ll_module: Any) -> None:
        """Make functions small, and no more.

        LLVM's passes for functions, which numba runs, take a condition that stays the same out of its loop by writing
        the loop twice. A loop around a call doubles all that is called.
        """
        ll_module.data_layout = self._codegen._data_layout
        builder = llvm.create_pass_builder(self._codegen._tm, llvm.create_pipeline_tuning_options(speed_level=1))
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
        foreign = [each for each in dict.fromkeys(self._linking_libraries) if not isinstance(each, _Linked)]
        for library in foreign:
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        for function in self._final_module.functions if foreign else ():
            if not function.is_declaration and str(function.linkage).endswith("linkonce_odr"):
                function.linkage = "internal"
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        return 0  # nobody calls it here


class _Linked(JITCodeLibrary):  # type: ignore[misc]
    """A kernel with all that it calls, to be linked into an ordinary function of numba's."""

    def __init__(self, translator: Translator, translation: Translation) -> None:
        super().__init__(internals.cpu_target.target_context.codegen(), translation.mangled_name)
        self._translator, self._translation = translator, translation
        self._finalized = True

    def _get_module_for_linking(self) -> Any:
        if self._shared_module is None:
            waiting, seen = [self._translation], {self._translation.mangled_name}
            while waiting:
                each = waiting.pop()
                self._final_module.link_in(llvm.parse_bitcode(each.bitcode))
                called = [one for one in self._translator.called_by(each) if one.mangled_name not in seen]
                seen.update(one.mangled_name for one in called)
                waiting += called
        return super()._get_module_for_linking()


_COMPILER = internals.compiler_into(_Own)


def _symbol(name: str, argument_types: tuple[Any, ...]) -> str:
    """Return LLVM's name of a function for arguments of some types, the same in every process."""
    plain = "".join(each if each.isalnum() or each in "._" else "_" for each in name)
    plain = f"{plain}.{_digest_of(argument_types)}"
    return f"_ZN{len(plain)}{plain}E"


def _digest_of(argument_types: tuple[Any, ...]) -> str:
    return digest(" ".join(map(_digest_of_type, argument_types)))


@cache
def _digest_of_type(kind: Any) -> str:
    return digest(f"{type(kind).__name__} {kind.name}")


class _Pickler(pickle.Pickler):
    """A pickler that names records by their digests: an engine's state would be written with each kernel."""

    def __init__(self, file: BytesIO, store: Store) -> None:
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self._store = store

    def persistent_id(self, value: Any) -> str | None:
        if not isinstance(value, types.Record):
            return None
        name = _digest_of_type(value)
        _RECORDS[name] = value
        if (name, self._store.root) not in _WRITTEN:
            inner = BytesIO()
            fields = [(field, info._asdict()) for field, info in value.fields.items()]
            _Pickler(inner, self._store).dump((fields, value.size, value.aligned))
            self._store.write_translation(f"record-{name}", inner.getvalue())
            _WRITTEN.add((name, self._store.root))
        return name


class _Unpickler(pickle.Unpickler):
    def __init__(self, content: bytes, store: Store) -> None:
        super().__init__(BytesIO(content))
        self._store = store

    def persistent_load(self, name: str) -> Any:
        if name not in _RECORDS:
            content = self._store.read_translation(f"record-{name}")
            if content is None:
                raise LookupError(name)
            _RECORDS[name] = types.Record(*_Unpickler(content, self._store).load())
        return _RECORDS[name]


_RECORDS: dict[str, Any] = {}
_WRITTEN: set[tuple[str, Path]] = set()


def _pickled(translation: Translation, store: Store) -> bytes:
    file = BytesIO()
    key, translation.key = translation.key, None
    _Pickler(file, store).dump(translation)
    translation.key = key
    return file.getvalue()


def _unpickled(content: bytes, store: Store) -> Translation:
    made: Translation = _Unpickler(content, store).load()
    return made


class KernelType(types.Callable, types.Dummy):  # type: ignore[misc]
    """The type that numba knows a kernel by, whose calls are translated when their arguments are known."""

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = kernel
        self._folding = internals.compiler_of(kernel.py_func, _SAFE, _COMPILER)
        super().__init__(f"kernel({name_of(kernel)} {own_digest(kernel)})")

    @property
    def key(self) -> str:
        return str(self.name)

    def __call__(self, *args: Any) -> Any:
        return types.Type.__call__(self, *args)

    def get_call_type(self, context: Any, args: Any, kws: Any) -> Any:
        signature, args = self._folding.fold_argument_types(args, kws)
        # To numba a number that is written out is a type of its own, for which a kernel would be translated once more.
        args = tuple(map(internals.unliteral, args))
        return internals.typing.signature(translator().kernel(self.kernel, args).restype, *args).replace(
            pysig=signature
        )

    def get_call_signatures(self) -> tuple[list[Any], bool]:
        return [], True

    def get_impl_key(self, signature: Any) -> object:
        return translator()._known[name_of(self.kernel), signature.args].key


internals.register_opaque(KernelType)


def type_of_kernel(kernel: Kernel) -> Any:
    """Return the type that numba knows a kernel by."""
    return KernelType(kernel)


def type_of_intrinsic(function: Callable[..., Any]) -> Any:
    """Return the type of an intrinsic that was met while something else is compiled."""
    made = intrinsic(function)
    internals.refresh()
    return internals.type_of(made)


def type_of_external(name: str, returned: Any, arguments: tuple[Any, ...]) -> Any:
    """Return the type of a function of the C library, whose pointers are numbers."""
    kinds = [types.uintp if each is ctypes.c_void_p else _KINDS[each] for each in arguments]
    return internals.type_of(types.ExternalFunction(name, _KINDS[returned](*kinds)))


_KINDS = {
    None: types.void,
    ctypes.c_void_p: types.voidptr,
    ctypes.c_int: types.intc,
    ctypes.c_ulong: types.uint64,  # of which only the lower half is given on Windows
    ctypes.c_int64: types.int64,
    ctypes.c_double: types.float64,
}


def translate_units(
    functions: list[CFunction], store: Store, unit_done: Callable[[Unit], None], translated: Callable[[], None]
) -> list[str]:
    """Translate functions of C and all kernels that they call, and return the keys of the units that they make.

    unit_done: called with each unit, as early as its code is known. translated: called after each kernel.
    """
    made = translator(store)
    told: dict[str, str] = {}

    def tell(translation: Translation) -> None:
        if not translation.inline and translation.mangled_name not in told:
            unit = made.unit(translation)
            told[translation.mangled_name] = unit.key
            unit_done(unit)

    def done(translation: Translation) -> None:
        translated()
        tell(translation)

    made.done = done
    try:
        waiting = [made.c_function(each) for each in functions]
    finally:
        made.done = lambda _: None
    seen = set()
    while waiting:  # units that were known before
        each = waiting.pop()
        if each.mangled_name not in seen:
            seen.add(each.mangled_name)
            tell(each)
            waiting += made.called_by(each)
    return [told[name] for name in sorted(told.keys() & seen)]


def whole(kernel: Kernel) -> Any:
    """Return a kernel as a function of its own, which Python can call."""

    @numba.njit(error_model="numpy")
    def call(*args):
        return kernel(*args)

    return call
