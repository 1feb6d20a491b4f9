"""A module's functions of C as one object file, in which nothing else can be seen: for what is linked by others."""

import importlib
from typing import NamedTuple

from ..errors import NoCodeError
from . import carried
from .code import functions_of, lacking
from .digests import digest
from .sources import hash_of
from .store import Store, user_cache
from .targets import Target

KIND = "whole"
"""The kind of its files in a store."""


class Whole(NamedTuple):
    """An object file: of which module, for which target.

    prefix: of the functions' names, which then are hidden in a shared library that the object file is linked into.
    """

    module: str
    target: Target
    prefix: str = ""

    def content(self) -> bytes:
        """Return it: from the cache, else from what came along with the package, else compiled now.

        NoCodeError where it is in neither, and there is no compiler.
        """
        importlib.import_module(self.module)
        kept = Store(user_cache())
        found = self.found(kept)
        if found is None and carried.unpacked(kept):
            found = self.found(kept)
        if found is None:
            try:
                merging = importlib.import_module(f"{__package__}.merging")  # it imports llvmlite and numba
            except ModuleNotFoundError as error:
                raise NoCodeError(lacking(self.module, self.target)) from error
            merging.make_whole(self)
            found = self.found(kept)
        if found is None:
            raise OSError(f"the compiled code in {kept.root} has gone while it was compiled")
        return found

    def found(self, kept: Store) -> bytes | None:
        """Return it if it lies in a store."""
        for name, listed in kept.lists(self.module):
            units = listed.units.get(str(self.target), [])
            if units and name == hash_of(listed.sources):
                key = self.key(units)
                kept.use_unit(key)
                return kept.read_unit(key, str(self.target), KIND)
        return None

    def key(self, units: list[str]) -> str:
        """Return the name by which it is kept, if it is made of some units."""
        names = [each.py_func.__name__ for each in functions_of(self.module)]
        return digest(f"{units} {self.prefix} {names} {hash_of([f'{__package__}.merging'])}")
