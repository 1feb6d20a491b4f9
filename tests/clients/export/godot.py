"""A small fake of Godot: what an extension's functions see of it, and how it calls them.

Strings, arrays of bytes and dictionaries are keys of Python's objects; names are equal if their texts are; a Variant is
a type and a value.
"""

import ctypes
import itertools
from ctypes import CFUNCTYPE, POINTER, Structure, byref, c_char_p, c_int, c_int64, c_uint8, c_uint32, c_void_p
from pathlib import Path
from typing import Any

BOOL, INT, FLOAT, STRING, VECTOR3, QUATERNION, DICTIONARY, BYTES = 1, 2, 3, 4, 9, 15, 27, 29
SIZES = {BOOL: 1, INT: 8, FLOAT: 8, STRING: 8, VECTOR3: 12, QUATERNION: 16, DICTIONARY: 8, BYTES: 16}
KEPT = (STRING, DICTIONARY, BYTES)
VARIANT = 24

Virtual = CFUNCTYPE(None, c_void_p, POINTER(c_void_p), c_void_p)


class Property(Structure):
    _fields_ = [
        ("type", c_int), ("name", POINTER(c_void_p)), ("class_name", c_void_p), ("hint", c_uint32),
        ("hint_text", c_void_p), ("usage", c_uint32),
    ]  # fmt: skip


class CallError(Structure):
    _fields_ = [("error", c_int), ("argument", c_int), ("expected", c_int)]


Call = CFUNCTYPE(None, c_void_p, c_void_p, POINTER(c_void_p), c_int64, c_void_p, POINTER(CallError))
CallTyped = CFUNCTYPE(None, c_void_p, c_void_p, POINTER(c_void_p), c_void_p)


class Method(Structure):
    _fields_ = [
        ("name", POINTER(c_void_p)), ("told", c_void_p), ("call", Call), ("call_typed", CallTyped), ("flags", c_uint32),
        ("returns", c_uint8), ("result", POINTER(Property)), ("result_kind", c_int), ("count", c_uint32),
        ("arguments", POINTER(Property)), ("kinds", POINTER(c_int)), ("defaults_count", c_uint32),
        ("defaults", c_void_p),
    ]  # fmt: skip


class Class(Structure):
    _fields_ = [
        ("is_virtual", c_uint8), ("is_abstract", c_uint8), ("is_exposed", c_uint8), ("unused", c_void_p * 11),
        ("create", CFUNCTYPE(c_void_p, c_void_p)), ("free", CFUNCTYPE(None, c_void_p, c_void_p)),
        ("recreate", c_void_p), ("find_virtual", CFUNCTYPE(c_void_p, c_void_p, POINTER(c_void_p))),
        ("virtuals", c_void_p * 2), ("rid", c_void_p), ("told", c_void_p),
    ]  # fmt: skip


class Initialization(Structure):
    _fields_ = [
        ("first_level", c_int), ("told", c_void_p), ("begin", CFUNCTYPE(None, c_void_p, c_int)),
        ("end", CFUNCTYPE(None, c_void_p, c_int)),
    ]  # fmt: skip


class Godot:
    """Godot with one extension: its classes, and objects of them."""

    def __init__(self, library: Path, entry: str) -> None:
        self.kept: dict[int, Any] = {}  # objects by their keys
        self.names: dict[bytes, int] = {}
        self.numbers = itertools.count(1)
        self.classes: dict[str, tuple[str, Class]] = {}
        self.methods: dict[tuple[str, str], Method] = {}
        self.objects: dict[int, tuple[str, int]] = {}  # class and instance of an object
        self.functions = {name: self._function(name) for name in _SIGNATURES}
        self.inner = {  # what functions return
            "from": {type_: _Convert(self._to_variant(type_)) for type_ in SIZES},
            "to": {type_: _Convert(self._from_variant(type_)) for type_ in SIZES},
            "new": {type_: _Construct(self._new(type_)) for type_ in SIZES},
            "free": {type_: _Destruct(lambda at: self.kept.pop(_key(at), None) and None) for type_ in KEPT},
        }
        self.size = _Builtin(lambda at, _values, result, _count: _put(result, c_int64(len(self.kept[_key(at)]))))
        self.find = CFUNCTYPE(c_void_p, c_char_p)(
            lambda name: ctypes.cast(self.functions[name.decode()], c_void_p).value
        )
        self.started = Initialization()
        entered = getattr(ctypes.CDLL(str(library)), entry)(self.find, c_void_p(0), byref(self.started))
        assert entered & 0xFF == 1 and self.started.first_level == 2
        for level in range(4):
            self.started.begin(None, level)

    def _function(self, name: str) -> Any:
        return CFUNCTYPE(*_SIGNATURES[name])(getattr(self, name))

    def keep(self, held: Any) -> int:
        key = next(self.numbers)
        self.kept[key] = held
        return key

    def _new(self, type_: int) -> Any:
        return lambda into, _of: _put(
            into, c_int64(self.keep({DICTIONARY: {}, STRING: ""}[type_]) if type_ in KEPT else 0)
        )

    def _to_variant(self, type_: int) -> Any:
        def convert(into: int, at: int) -> None:
            ctypes.memset(into, 0, VARIANT)
            _put(into, c_int(type_))
            ctypes.memmove(into + 8, at, SIZES[type_])
            if type_ in KEPT:
                _put(into + 8, c_int64(self.keep(self.kept[_key(at)])))

        return convert

    def _from_variant(self, type_: int) -> Any:
        def convert(into: int, at: int) -> None:
            ctypes.memmove(into, at + 8, SIZES[type_])
            if type_ in KEPT:
                _put(into, c_int64(self.keep(self.kept[_key(at + 8)])))
            elif type_ == FLOAT and c_int.from_address(at).value == INT:
                _put(into, ctypes.c_double(c_int64.from_address(at + 8).value))

        return convert

    # Godot's functions.
    def string_name_new_with_latin1_chars(self, into: int, text: bytes, _static: int) -> None:
        _put(into, c_int64(self.names.setdefault(text, len(self.names) + 1)))

    def string_new_with_utf8_chars(self, into: int, text: bytes) -> None:
        _put(into, c_int64(self.keep(text.decode())))

    def string_to_utf8_chars(self, at: int, into: int | None, most: int) -> int:
        text = self.kept[_key(at)].encode()
        if into:
            ctypes.memmove(into, text, min(most, len(text)))
        return len(text)

    def get_variant_from_type_constructor(self, type_: int) -> int:
        return _address(self.inner["from"][type_])

    def get_variant_to_type_constructor(self, type_: int) -> int:
        return _address(self.inner["to"][type_])

    def variant_get_ptr_constructor(self, type_: int, number: int) -> int:
        assert number == 0
        return _address(self.inner["new"][type_])

    def variant_get_ptr_destructor(self, type_: int) -> int | None:
        return _address(self.inner["free"][type_]) if type_ in KEPT else None

    def variant_get_ptr_builtin_method(self, type_: int, name: int, hash_: int) -> int:
        assert (type_, _key(name), hash_) == (BYTES, self.names[b"size"], 3173160232)
        return _address(self.size)

    def variant_get_type(self, at: int) -> int:
        return c_int.from_address(at).value

    def variant_destroy(self, at: int) -> None:
        if c_int.from_address(at).value in KEPT:
            self.kept.pop(_key(at + 8))

    def packed_byte_array_operator_index_const(self, at: int, index: int) -> int:
        return ctypes.addressof(self.kept[_key(at)]) + index

    def dictionary_operator_index(self, at: int, key: int) -> int:
        return ctypes.addressof(self.kept[_key(at)].setdefault(self.kept[_key(key + 8)], (c_int64 * 3)()))

    def ref_set_object(self, at: int, made: int) -> None:
        _put(at, c_int64(made))

    def classdb_construct_object(self, _name: int) -> int:
        return next(self.numbers)

    def object_set_instance(self, made: int, name: int, instance: int) -> None:
        self.objects[made] = (self._text(name), instance)

    def classdb_register_extension_class2(self, _library: int, name: int, parent: int, info: int) -> None:
        self.classes[self._text(name)] = (self._text(parent), Class.from_buffer_copy(Class.from_address(info)))

    def classdb_unregister_extension_class(self, _library: int, name: int) -> None:
        del self.classes[self._text(name)]

    def classdb_register_extension_class_method(self, _library: int, of: int, info: int) -> None:
        told = Method.from_buffer_copy(Method.from_address(info))
        types = [told.arguments[n].type for n in range(told.count)]
        self.methods[self._text(of), self._text(ctypes.addressof(told.name.contents))] = told
        told.types, told.made = types, told.result.contents.type

    def _text(self, name: int) -> str:
        return next(text for text, key in self.names.items() if key == _key(name)).decode()

    # How scripts and the audio server call.
    def new(self, name: str) -> int:
        made = self.classes[name][1]
        return int(made.create(made.told))

    def free(self, made: int) -> None:
        name, instance = self.objects.pop(made)
        self.classes[name][1].free(self.classes[name][1].told, instance)

    def call(self, made: int, name: str, *given: Any, typed: bool = False) -> Any:
        """Call a method, with variants or with values of its types."""
        of, instance = self.objects[made]
        method = self.methods[of, name]
        types = method.types if typed else [_type_of(each) for each in given]
        values = [self._value(type_, each) for type_, each in zip(types, given, strict=True)]
        made, result, error = method.made, ctypes.create_string_buffer(VARIANT), CallError()
        at = ctypes.addressof(result)
        if typed:
            self.inner["new"][made](at, None)
            method.call_typed(method.told, instance, _pointers(values), result)
        else:
            variants = [ctypes.create_string_buffer(VARIANT) for _ in values]
            for type_, variant, value in zip(types, variants, values, strict=True):
                self.inner["from"][type_](ctypes.addressof(variant), ctypes.addressof(value))
            method.call(method.told, instance, _pointers(variants), len(variants), result, byref(error))
            for variant in variants:
                self.variant_destroy(ctypes.addressof(variant))
            at += 8
        taken = None if error.error else self._python(made, at)
        kept = [ctypes.addressof(value) for type_, value in zip(types, values, strict=True) if type_ in KEPT]
        for each in kept + [at] * (made in KEPT and not error.error):
            self.kept.pop(_key(each))
        if error.error:
            raise TypeError(error.error, error.argument, error.expected)
        return taken

    def call_virtual(self, made: int, name: str, result: Any, *values: Any) -> Any:
        """Call a virtual method, which puts its result into `result`."""
        of, instance = self.objects[made]
        asked = c_void_p(self.names.setdefault(name.encode(), len(self.names) + 1))
        found = self.classes[of][1].find_virtual(None, byref(asked))
        assert found, f"{of} has no {name}"
        Virtual(found)(instance, _pointers(values), ctypes.addressof(result))
        return result.value

    def play(self, stream: int) -> int:
        """Have a stream played, as its player does; what the audio thread mixes."""
        ref = c_void_p()
        self.call_virtual(stream, "_instantiate_playback", ref)
        playback = int(ref.value or 0)
        self.call_virtual(playback, "_start", c_uint8(), ctypes.c_double(0.0))
        assert self.call_virtual(playback, "_is_playing", c_uint8()) == 1
        return playback

    def mix(self, playback: int, frames: int) -> list[float]:
        """Return frames of sound, left and right in turn."""
        out = (ctypes.c_float * (2 * frames))()
        values = (c_void_p(ctypes.addressof(out)), ctypes.c_double(1.0), c_int64(frames))
        assert self.call_virtual(playback, "_mix", c_int64(), *values) == frames
        return list(out)

    def _value(self, type_: int, given: Any) -> Any:
        if type_ == BYTES:
            return (c_int64 * 2)(self.keep((c_uint8 * len(given)).from_buffer_copy(given)), 0)
        if type_ == STRING:
            return c_int64(self.keep(given))
        if type_ in (VECTOR3, QUATERNION):
            return (ctypes.c_float * len(given))(*given)
        return {BOOL: c_uint8, INT: c_int64, FLOAT: ctypes.c_double}[type_](given)

    def _python(self, type_: int, at: int) -> Any:
        if type_ == DICTIONARY:
            return {key: ctypes.c_double.from_buffer(told, 8).value for key, told in self.kept[_key(at)].items()}
        if type_ == STRING:
            return self.kept[_key(at)]
        return {BOOL: c_uint8, INT: c_int64, FLOAT: ctypes.c_double}[type_].from_address(at).value


def _type_of(given: Any) -> int:
    if isinstance(given, tuple):
        return VECTOR3 if len(given) == 3 else QUATERNION
    return {int: INT, float: FLOAT, str: STRING, bytes: BYTES}[type(given)]


def _pointers(values: Any) -> Any:
    return (c_void_p * max(len(values), 1))(*(ctypes.addressof(each) for each in values))


def _key(at: int) -> int:
    return c_int64.from_address(at).value


def _put(into: int, value: Any) -> None:
    ctypes.memmove(into, byref(value), ctypes.sizeof(value))


def _address(function: Any) -> int:
    return int(ctypes.cast(function, c_void_p).value or 0)


_Convert = CFUNCTYPE(None, c_void_p, c_void_p)
_Construct = CFUNCTYPE(None, c_void_p, c_void_p)
_Destruct = CFUNCTYPE(None, c_void_p)
_Builtin = CFUNCTYPE(None, c_void_p, c_void_p, c_void_p, c_int)

_SIGNATURES = {
    "string_name_new_with_latin1_chars": (None, c_void_p, c_char_p, c_uint8),
    "string_new_with_utf8_chars": (None, c_void_p, c_char_p),
    "string_to_utf8_chars": (c_int64, c_void_p, c_void_p, c_int64),
    "get_variant_from_type_constructor": (c_void_p, c_int),
    "get_variant_to_type_constructor": (c_void_p, c_int),
    "variant_get_type": (c_int, c_void_p),
    "variant_destroy": (None, c_void_p),
    "variant_get_ptr_constructor": (c_void_p, c_int, ctypes.c_int32),
    "variant_get_ptr_destructor": (c_void_p, c_int),
    "variant_get_ptr_builtin_method": (c_void_p, c_int, c_void_p, c_int64),
    "packed_byte_array_operator_index_const": (c_void_p, c_void_p, c_int64),
    "dictionary_operator_index": (c_void_p, c_void_p, c_void_p),
    "ref_set_object": (None, c_void_p, c_void_p),
    "classdb_construct_object": (c_void_p, c_void_p),
    "object_set_instance": (None, c_void_p, c_void_p, c_void_p),
    "classdb_register_extension_class2": (None, c_void_p, c_void_p, c_void_p, c_void_p),
    "classdb_unregister_extension_class": (None, c_void_p, c_void_p),
    "classdb_register_extension_class_method": (None, c_void_p, c_void_p, c_void_p),
}
