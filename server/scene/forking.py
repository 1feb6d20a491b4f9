"""Copies of what goes on in a scene: an engine's memory, and all that refers to it.

The engine's memory holds no addresses. So its pages are copied, and then what Python holds is walked through by
`pickle`: views of that memory become views of the copy, what never changes is shared, and all else is copied.
"""

import pickle
from functools import partial
from io import BytesIO
from types import MappingProxyType
from typing import Any, TypeVar, cast
from weakref import ProxyType, proxy

import numpy as np
from numpy.typing import NDArray

from ...dsp.bodies.modes import Modes
from ...dsp.engine.memory.commands import Command, Handle
from ...dsp.native.addresses import as_bytes
from ...dsp.runtime.arena import Arena
from ...dsp.runtime.engine import Engine
from ...dsp.runtime.plan import Plan
from ...presets import ObjectPreset, Presets
from ..osc.addresses import Call
from ..osc.arguments import Values
from .makeup import Measure
from .objects import PlayedObject
from .transaction import Sent

Root = TypeVar("Root")

_SHARED = {Call, Command, Handle, MappingProxyType, Measure, ObjectPreset, Plan, Presets, Sent, Values}
_BODIES = Modes.__module__.rpartition(".")[0]
"""Classes of what never changes, and the package of bodies, none of which does: their identity counts in places."""


def forked(root: Root, engine: Engine) -> Root:
    """Return a copy of an object that holds an engine; from then on neither does anything to the other.

    TypeError, PicklingError or AttributeError name what cannot be copied.
    """
    state, shapes = engine.copied_memory()
    file = BytesIO()
    writer = _Writer(file, root, engine, shapes)
    writer.dump(root)
    for each in writer.later:  # which grows meanwhile
        writer.dump(each.__dict__)
    file.seek(0)
    reader = _Reader(file, state, writer.shared)
    copy = cast(Root, reader.load())
    for each in reader.later:
        each.__dict__.update(reader.load())
    return copy


class _Writer(pickle.Pickler):
    """Writes what a root holds; `shapes` take the place of its engine's."""

    def __init__(self, file: BytesIO, root: object, engine: Engine, shapes: Arena) -> None:
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self._root, self._first, self._size = root, engine.pointer, engine.state.nbytes
        self._own_shapes, self._shapes = engine.shapes, shapes
        self.shared: list[object] = []
        self.later: list[PlayedObject] = []
        """Objects whose contents come later: they may refer to each other in long chains."""

    def reducer_override(self, what: Any) -> Any:
        """Return how what is not plain data is made again."""
        kind = type(what)
        own = what is self._own_shapes
        if own or kind in _SHARED or kind.__module__.startswith(_BODIES) or isinstance(what, np.dtype):
            self.shared.append(self._shapes if own else what)
            return _share, (len(self.shared) - 1,)
        if kind is PlayedObject:
            self.later.append(what)
            return _fill_later, ()
        if kind is ProxyType:
            return proxy, (self._root,)
        if kind is np.ndarray or kind is np.void:
            offset = (np.frombuffer(what, np.uint8) if kind is np.void else what).ctypes.data - self._first
            if 0 <= offset < self._size:
                return _view, (kind is np.void, offset, what.shape, what.dtype, what.strides)
        return NotImplemented


class _Reader(pickle.Unpickler):
    """Reads it for another state."""

    def __init__(self, file: BytesIO, state: NDArray[np.void], shared: list[object]) -> None:
        super().__init__(file)
        self.later: list[PlayedObject] = []
        self._made = {"_share": shared, "_fill_later": self.later, "_view": as_bytes(state)}

    def find_class(self, module: str, name: str) -> Any:
        """Return what a name stands for; no method of its own, which would keep the state in a circle."""
        found = super().find_class(module, name)
        return partial(found, self._made[name]) if module == __name__ else found


def _share(shared: list[object], place: int) -> object:
    """Return what both have."""
    return shared[place]


def _fill_later(later: list[PlayedObject]) -> PlayedObject:
    """Return an object whose contents come later."""
    later.append(PlayedObject.__new__(PlayedObject))
    return later[-1]


def _view(
    memory: NDArray[np.void], is_record: bool, offset: int, shape: tuple[int, ...], dtype: Any, strides: Any
) -> Any:  # fmt: skip
    """Return a view of a state's memory."""
    if is_record:
        return np.ndarray((1,), dtype, memory, offset)[0]
    return np.ndarray(shape, dtype, memory, offset, strides)
