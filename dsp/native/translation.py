"""Kernels as LLVM's code: each a module of its own, kept on disk, and translated again only where it must be.

numba would optimise each kernel with all that is in it, again and again, make machine code of it and wrappers to call
it from Python, which next to nobody does. So a kernel is only translated here (`lowering.py`). Its module declares the
kernels that it calls, by names that are the same in every process. A translation holds as long as the kernel's own code
is the same (`digests.py`), and each kernel that it calls returns the same type: an edit of one kernel translates that
kernel.
"""

import pickle
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from numba import NumbaError

from .digests import digest, name_of, own_digest
from .jit import KERNELS, CFunction, Kernel
from .lowering import Call, Translation, argument_types, lower, lower_c
from .numba_internals import define_call, global_compiler_lock, place_and_cause, quiet_compiler
from .pickled import digest_of_types, pickled, unpickled
from .sources import compiler_digest
from .store import Store, user_cache
from .units import Unit


class KernelError(TypeError):
    """A kernel that can't be translated: its text says which line is wrong, and why."""


class Translator:
    """Translates kernels, and keeps what it has translated. One thread at a time uses it: numba's lock sees to that.

    store: files of earlier translations.
    """

    def __init__(self, store: Store) -> None:
        self._store = store
        self._known: dict[tuple[str, tuple[Any, ...]], Translation] = {}
        self._calls: list[list[Call]] = [[]]
        self._running: list[tuple[str, tuple[Any, ...]]] = []
        self.done: Callable[[Translation], None] = lambda _: None  # called with each; those that it calls come first
        self.count = 0  # of those that were translated anew

    def forget(self) -> None:
        """Look at all kernels again: modules may have been imported anew since."""
        self._known.clear()

    def kernel(self, kernel: Kernel[..., Any], kinds: tuple[Any, ...]) -> Translation:
        """Return a kernel's translation for types of arguments: of this process, of an earlier one, or made now."""
        name = name_of(kernel)
        found = self._known.get((name, kinds))
        if found is None or found.own != own_digest(kernel):
            made = found = self._made(kernel, name, kinds, lambda: lower(kernel, kinds))
            found.key = define_call(found, kinds, lambda: [each.bitcode for each in self.within(made)])
        self._calls[-1].append((name, kinds, found.restype))
        return found

    def known(self, kernel: Kernel[..., Any], kinds: tuple[Any, ...]) -> Translation:
        """Return a translation of this process."""
        return self._known[name_of(kernel), kinds]

    def c_function(self, function: CFunction) -> Translation:
        """Return the translation of a function of C."""
        return self._made(function, name_of(function), argument_types(function), lambda: lower_c(function))

    def called_by(self, translation: Translation) -> list[Translation]:
        """Return the translations of the kernels that one calls."""
        return [self._known[name, kinds] for name, kinds, _ in translation.calls]

    def within(
        self, translation: Translation, follows: Callable[[Translation], bool] = lambda _: True
    ) -> list[Translation]:
        """Return a translation, and those that it calls however deep, as far as it is followed, by their symbols."""
        parts, waiting = {translation.mangled_name: translation}, [translation]
        while waiting:
            for each in self.called_by(waiting.pop()):
                if follows(each) and each.mangled_name not in parts:
                    parts[each.mangled_name] = each
                    waiting.append(each)
        del parts[translation.mangled_name]
        return [translation, *(parts[symbol] for symbol in sorted(parts))]

    def unit(self, translation: Translation) -> Unit:
        """Return a function that is not inlined as a unit, with all that is inlined into it."""
        parts = self.within(translation, lambda each: each.inline)
        return Unit(translation.mangled_name, tuple(each.bitcode for each in parts))

    def _made(
        self, kernel: Any, name: str, kinds: tuple[Any, ...], translate: Callable[[], Translation]
    ) -> Translation:
        key = name, kinds
        if key in self._running:
            raise TypeError(f"{name} calls itself: a kernel can't")
        self._running.append(key)
        file = f"{digest(f'{name} {own_digest(kernel)}')}-{digest_of_types(kinds)}"
        try:
            made = self._kept(file, kinds)
            if made is None:
                with self._collecting() as calls, quiet_compiler(_symbol):
                    try:
                        made = translate()
                    except NumbaError as error:
                        raise KernelError(place_and_cause(error)) from None
                made.own, made.calls = own_digest(kernel), list(dict.fromkeys(calls))
                self._store.write_translation(file, pickled(made, self._store))
                self.count += 1
        finally:
            self._running.pop()
        self._known[key] = made
        self.done(made)
        return made

    def _kept(self, file: str, kinds: tuple[Any, ...]) -> Translation | None:
        """Return a translation of an earlier process, if all that it calls still returns the same types."""
        content = self._store.read_translation(file)
        try:
            kept: Translation | None = unpickled(content, self._store) if content else None
            if kept is None or kept.argtypes != kinds:
                return None
            with self._collecting():
                holds = all(self.kernel(_named(name), args).restype == kind for name, args, kind in kept.calls)
        except (LookupError, ImportError, AttributeError, ValueError, pickle.UnpicklingError, KernelError):
            return None
        return kept if holds else None

    @contextmanager
    def _collecting(self) -> Iterator[list[Call]]:
        """Collect the kernels that are called meanwhile."""
        self._calls.append([])
        try:
            yield self._calls[-1]
        finally:
            self._calls.pop()


def translator() -> Translator:
    """Return the translator of this process, which keeps what it makes in the user's cache."""
    with global_compiler_lock:  # two threads that came at once would have one each
        return _translator(user_cache())


@cache
def _translator(root: Path) -> Translator:
    return Translator(Store(root, compiler_digest()))


def _named(name: str) -> Kernel[..., Any]:
    """Return the kernel of a name; LookupError if there is none any more."""
    path, _, own = name.partition("@")
    if path not in KERNELS:
        import_module(path.partition(":")[0])
    kernel: Kernel[..., Any]
    for kernel in reversed(KERNELS.get(path, [])):
        if not own or own_digest(kernel) == own:
            return kernel
    raise LookupError(name)


def _symbol(name: str, kinds: tuple[Any, ...]) -> str:
    """Return LLVM's name of a function for arguments of some types, the same in every process."""
    plain = "".join(each if each.isalnum() or each in "._" else "_" for each in name)
    plain = f"{plain}.{digest_of_types(kinds)}"
    return f"_ZN{len(plain)}{plain}E"


def translate_units(
    functions: list[CFunction], unit_done: Callable[[Unit], None], translated: Callable[[], None]
) -> list[str]:
    """Translate functions of C and all kernels that they call, and return the keys of the units that they make.

    unit_done: called with each unit, as early as its code is known. translated: called after each kernel.
    """
    made = translator()
    told: dict[str, str] = {}

    def done(translation: Translation) -> None:
        translated()
        if not translation.inline and translation.mangled_name not in told:
            unit = made.unit(translation)
            told[translation.mangled_name] = unit.key
            unit_done(unit)

    with global_compiler_lock:
        made.forget()
        made.done = done
        try:
            parts = [part for each in functions for part in made.within(made.c_function(each))]
        except KernelError as error:
            raise error.with_traceback(None) from None  # which shows numba's frames alone, by the hundred
        finally:
            made.done = lambda _: None
    return [told[name] for name in sorted({each.mangled_name for each in parts} & told.keys())]
