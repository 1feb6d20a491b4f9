"""OSC on the wire: datagrams checked and read, messages and bundles written.

Not by python-osc, whose reader trusts sizes (a negative one loops for ever), drops the tags it does not know, pads
short floats, makes dates of time tags, ignores what follows the last argument, and copies the rest of the datagram for
each argument; its writer ends a string at a zero inside, takes a tuple of four for MIDI, and takes ten times as long.
"""

import reprlib
import struct
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

from ...dsp.errors import CaromError

Argument = int | float | str | bytes | bool | tuple["Argument", ...] | None
"""Argument of a message; a tuple is an array."""

DEFAULT_PORT, MOST_PORT = 57140, 65_535
IMMEDIATELY = 1
MAX_DATAGRAM = 65507  # bytes: the most that UDP over IPv4 carries
MAX_DEPTH = 8  # of bundles in bundles, and of arrays in arrays
MAX_ADDRESS = 1024  # characters: a pattern is matched with the name of every object

BUNDLE = b"#bundle\0"
_SIZE = struct.Struct(">i")
_TIME = struct.Struct(">Q")
_UNIX_EPOCH = 2208988800 << 32  # 1 January 1970 as an NTP time tag
_ERA = 1 << 64  # units of a time tag, of 2**-32 s
_CODES = {"i": "i", "h": "q", "f": "f", "d": "d", "t": "Q", "r": "I", "m": "4s", "c": "I"}
_SIZED = {tag: struct.Struct(">" + code) for tag, code in _CODES.items()}
# 1.0 calls I infinitum, 1.1 impulse: a bang. A control that is banged is on.
_CONSTANT = {"T": True, "F": False, "N": None, "I": True}


class BadPacket(CaromError, ValueError):
    """A datagram that is not OSC; the text says what is wrong with it."""


class Message(NamedTuple):
    """An address (or address pattern) and its arguments."""

    address: str
    args: tuple[Argument, ...] = ()


class Bundle(NamedTuple):
    """Messages for one moment: a 64-bit NTP time tag, 1 being at once."""

    time: int
    messages: tuple[Message, ...]


def parse(datagram: bytes) -> list[Bundle]:
    """Read a datagram whole, or raise BadPacket; in time proportional to its size.

    A bare message becomes a bundle for IMMEDIATELY. Bundles in bundles come out flat, in the order written:
    a bundle with others inside it is cut where they stand, and its pieces keep its time. An array is one argument,
    a tuple. Numbers are int (i h r t) or float (f d; NaN and infinities pass), s S c are str, b and m (four bytes
    of MIDI) are bytes. A message without arguments may lack the type tags.
    """
    if len(datagram) > MAX_DATAGRAM:
        raise BadPacket(f"{len(datagram)} bytes: expected at most {MAX_DATAGRAM}")
    if len(datagram) % 4 or not datagram:
        raise BadPacket(f"{len(datagram)} bytes: expected a multiple of 4, above 0")
    if datagram.startswith(BUNDLE):
        return list(_bundles(datagram, 1))
    return [Bundle(IMMEDIATELY, (_message(datagram),))]


def _bundles(data: bytes, depth: int) -> Iterator[Bundle]:
    if depth > MAX_DEPTH:
        raise BadPacket(f"bundles nested deeper than {MAX_DEPTH}")
    if len(data) < 16:
        raise BadPacket(f"bundle of {len(data)} bytes: expected at least 16")
    (time,) = _TIME.unpack_from(data, 8)
    messages: list[Message] = []
    start = 16
    while start < len(data):
        (size,) = _SIZE.unpack_from(data, start)
        start += 4
        if size <= 0 or size % 4 or size > len(data) - start:
            raise BadPacket(f"bundle element of {size} bytes: expected 4, 8 ... {len(data) - start}")
        element = data[start : start + size]
        start += size
        if not element.startswith(BUNDLE):
            messages.append(_message(element))
            continue
        if messages:
            yield Bundle(time, tuple(messages))
            messages = []
        yield from _bundles(element, depth + 1)
    if messages:
        yield Bundle(time, tuple(messages))


def _message(data: bytes) -> Message:
    address, at = _string(data, 0, "address")
    if not address.startswith("/"):
        raise BadPacket(f"address {reprlib.repr(address)}: expected it to start with /")
    if len(address) > MAX_ADDRESS:
        raise BadPacket(f"address of {len(address)} characters: expected at most {MAX_ADDRESS}")
    if at == len(data):
        return Message(address)
    if data[at : at + 1] != b",":
        raise BadPacket("arguments without type tags")
    tags, at = _string(data, at, "type tags")
    arguments, at = _arguments(data, at, tags)
    if at != len(data):
        raise BadPacket(f"{len(data) - at} bytes after the last argument")
    return Message(address, arguments)


def _arguments(data: bytes, at: int, tags: str) -> tuple[tuple[Argument, ...], int]:
    """Return the arguments that begin at a place, by their type tags (",if..."), and where they end."""
    arrays: list[list[Argument]] = [[]]  # the message's own arguments, then the arrays that are open, outermost first
    number = 1  # of the next value, whether it stands in an array or not
    for tag in tags[1:]:
        name = f"argument {number}"
        value: Argument
        if tag in _SIZED:
            read, at = _sized(data, at, tag, name)
            value = _character(read, name) if tag == "c" else read
        elif tag in "sS":
            value, at = _string(data, at, name)
        elif tag == "b":
            value, at = _blob(data, at, name)
        elif tag in _CONSTANT:
            value = _CONSTANT[tag]
        elif tag == "[":
            if len(arrays) > MAX_DEPTH:
                raise BadPacket(f"{name}: arrays nested deeper than {MAX_DEPTH}")
            arrays.append([])
            continue
        elif tag == "]" and len(arrays) > 1:
            array = tuple(arrays.pop())
            arrays[-1].append(array)
            continue
        else:
            raise BadPacket(f"{name} has the type tag {tag!r}: expected one of ihfdtrmcsSbTFNI or [ ]")
        arrays[-1].append(value)
        number += 1
    if len(arrays) > 1:
        raise BadPacket("type tags: an array is not closed")
    return tuple(arrays[0]), at


def _string(data: bytes, start: int, name: str) -> tuple[str, int]:
    end = data.find(b"\0", start)
    if end < 0:
        raise BadPacket(f"{name}: a string without its closing zero")
    try:
        return data[start:end].decode(), end // 4 * 4 + 4
    except UnicodeDecodeError:
        raise BadPacket(f"{name}: a string that is not UTF-8") from None


def _sized(data: bytes, start: int, tag: str, name: str) -> tuple[Any, int]:
    kind = _SIZED[tag]
    if start + kind.size > len(data):
        raise BadPacket(f"{name} of type {tag} is cut short")
    return kind.unpack_from(data, start)[0], start + kind.size


def _character(code: int, name: str) -> str:
    if not 0 < code < 128:
        raise BadPacket(f"{name} of type c is {code}: expected an ASCII character")
    return chr(code)


def _blob(data: bytes, start: int, name: str) -> tuple[bytes, int]:
    size, start = _sized(data, start, "i", name)
    if not 0 <= size <= len(data) - start:
        raise BadPacket(f"{name}: a blob of size {size}, with {len(data) - start} bytes left")
    return data[start : start + size], start + size + -size % 4


def argument(value: object) -> Argument:
    """Return an argument from what stands for one in Python: a list becomes a tuple, numpy's scalars and arrays plain
    values.

    Raises ValueError for what OSC cannot carry.
    """
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return tuple(map(argument, value))
    if value is None or isinstance(value, int | float | str | bytes):
        return value
    raise ValueError(f"{reprlib.repr(value)}: expected a number, a string, bytes, a boolean, None or a list of such")


def encode(address: str, *args: object, real: str = "f") -> bytes:
    """Write a message, with the strict types i (h past 32 bits), s, b, T, F, N, [ ] and, for float, `real`.

    Lists, tuples and numpy's arrays become OSC arrays, nested at most MAX_DEPTH deep.
    real: "f" is what every client reads (Pd knows no d, T, F and N); "d" loses nothing.
    Raises ValueError for what OSC cannot carry.
    """
    if not address.startswith("/"):
        raise ValueError(f"address {address!r}: expected it to start with /")
    if "\0" in address:
        raise ValueError(f"address {address!r} contains a zero character")
    tags, parts = [","], list[bytes]()
    try:
        for value in args:
            _add(tags, parts, value, real, 0)
        return _fitting(b"".join([_padded(address), _padded("".join(tags)), *parts]))
    except (OverflowError, RecursionError, ValueError, struct.error) as error:
        raise ValueError(f"{address}: cannot send {reprlib.repr(args)}: {error}") from error


def _add(tags: list[str], parts: list[bytes], value: object, real: str, depth: int) -> None:
    """Add an argument to a message's type tags and to its data."""
    if isinstance(value, str):
        if "\0" in value:
            raise ValueError("a string contains a zero character")
        tags.append("s")
        parts.append(_padded(value))
    elif isinstance(value, float):
        tags.append(real)
        parts.append(_SIZED[real].pack(value))
    elif value is True or value is False or value is None:
        tags.append("T" if value else "N" if value is None else "F")
    elif isinstance(value, int):
        tag = "h" if value.bit_length() > 31 else "i"
        tags.append(tag)
        parts.append(_SIZED[tag].pack(value))
    elif isinstance(value, tuple):
        if depth == MAX_DEPTH:
            raise ValueError(f"arrays nested deeper than {MAX_DEPTH}")
        tags.append("[")
        for item in value:
            _add(tags, parts, item, real, depth + 1)
        tags.append("]")
    elif isinstance(value, bytes):
        if not value:
            raise ValueError("a blob without bytes")
        tags.append("b")
        parts.append(_SIZE.pack(len(value)) + value + bytes(-len(value) % 4))
    else:
        _add(tags, parts, argument(value), real, depth)


def _padded(text: str) -> bytes:
    """Return a string as OSC has it: with at least one zero at its end."""
    data = text.encode()
    return data + bytes(4 - len(data) % 4)


_FEW, _SHORT = 30, 1_000
"""Arguments, and characters of a string in ASCII: a message of no more than that fits a datagram by far."""


def require_sendable(address: str, args: Sequence[Argument]) -> None:
    """Raise ValueError for a message that `encode` refuses; in a fraction of its time."""
    plain = address[:1] == "/" and len(args) <= _FEW and _is_plain(address)
    if not (plain and all([type(arg) is float or _is_plain(arg) for arg in args])):
        encode(address, *args, real="d")


def _is_plain(value: Argument) -> bool:
    """True for a number or a short string of which nothing needs to be looked at."""
    if type(value) is str:
        return len(value) <= _SHORT and value.isascii() and "\0" not in value
    return type(value) is float or (type(value) is int and -(2**63) <= value < 2**63)


def encode_bundle(time_tag: int, messages: Iterable[Message], real: str = "f") -> bytes:
    """Write one flat bundle for a 64-bit NTP time tag; floats and errors as in encode."""
    parts = [BUNDLE, _TIME.pack(time_tag)]
    for message in messages:
        packet = encode(message.address, *message.args, real=real)
        parts += [_SIZE.pack(len(packet)), packet]
    return _fitting(b"".join(parts))


def _fitting(packet: bytes) -> bytes:
    if len(packet) > MAX_DATAGRAM:
        raise ValueError(f"{len(packet)} bytes: a datagram holds at most {MAX_DATAGRAM}")
    return packet


def time_tag(unix_seconds: float) -> int:
    """Return the 64-bit NTP time tag of a Unix time (s), from 1900 to 26 February 2242. From 7 February 2036 on its
    32 bits of seconds count from 0 again: it is then that of a time in the era before, which the reader has to know
    (`unix_ns`); the first two mean now, and so become the third."""
    if not 0 <= unix_seconds + _UNIX_EPOCH / 2**32 < 2 * 2**32:
        raise ValueError(f"time {unix_seconds!r} s: expected a Unix time between 1900 and 26 February 2242")
    tag = (round(unix_seconds * 2**32) + _UNIX_EPOCH) % _ERA
    return tag if tag > IMMEDIATELY else IMMEDIATELY + 1


def unix_ns(tag: int, near: int) -> int:
    """Return the Unix time (ns) of a 64-bit NTP time tag in the era in which it is nearest to another, `near` (ns):
    eras are 136 years long. 0 and 1, meaning now, are the caller's to see first."""
    units = (tag - _UNIX_EPOCH - (near << 32) // 1_000_000_000 + _ERA // 2) % _ERA - _ERA // 2
    return near + (units * 1_000_000_000 >> 32)
