"""Translations as bytes. Each record type has a file of its own: else each kernel's would hold the engine's state."""

import pickle
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any

from .digests import digest
from .numba_internals import types
from .store import Store


def pickled(value: Any, store: Store) -> bytes:
    """Return anything with numba's types in it as bytes; the records are written to the store."""
    file = BytesIO()
    _Pickler(file, store).dump(value)
    return file.getvalue()


def unpickled(content: bytes, store: Store) -> Any:
    """Return what `pickled` was given. LookupError if a record is gone."""
    return _Unpickler(content, store).load()


def digest_of_types(kinds: tuple[Any, ...]) -> str:
    """Return a digest of types of numba's, the same in every process."""
    return digest(" ".join(map(_digest_of_type, kinds)))


@cache
def _digest_of_type(kind: Any) -> str:
    fields = kind.fields if isinstance(kind, types.BaseNamedTuple) else ""  # its name lacks them
    return digest(f"{type(kind).__name__} {kind.name} {fields}")


class _Pickler(pickle.Pickler):
    """A pickler that names records by their digests."""

    def __init__(self, file: BytesIO, store: Store) -> None:
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self._store = store

    def persistent_id(self, value: Any) -> str | None:
        if not isinstance(value, types.Record):
            return None
        name = _digest_of_type(value)
        _RECORDS[name] = value
        if (name, self._store.root) not in _WRITTEN:
            fields = [(field, info._asdict()) for field, info in value.fields.items()]
            content = pickled((fields, value.size, value.aligned), self._store)
            self._store.write_translation(f"record-{name}", content)
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
            _RECORDS[name] = types.Record(*unpickled(content, self._store))
        return _RECORDS[name]


_RECORDS: dict[str, Any] = {}
_WRITTEN: set[tuple[str, Path]] = set()
