"""Framing of packets in a stream: by SLIP, END on either side (OSC 1.1), or each after its size (OSC 1.0).

A client's first byte shows which of the two it speaks: a size below 64 KiB begins with a zero, SLIP with END or with
the packet itself. Replies go out in the same framing.
"""

import struct
from collections.abc import Iterator
from contextlib import suppress

from ...dsp.errors import CaromError
from .wire import MAX_DATAGRAM, BadPacket, parse

_END = b"\xc0"
_ESCAPE = b"\xdb"
_ESCAPED = {b"\xdc": _END, b"\xdd": _ESCAPE}
_SIZE = struct.Struct(">i")
_LONGEST_BARE = 1_024  # bytes of a packet that is looked for in a stream without framing

UNFRAMED = "OSC without framing: expected an END (c0) after each packet (SLIP), or the size (int32) before each"


class Broken(CaromError, ValueError):
    """A stream in which no packet can be found any more; the text says why."""


class Slip:
    """RFC 1055: packets between END bytes; what looks like END or ESC inside is escaped."""

    last = "an END (c0) after each packet"
    """End of a packet, in words."""

    def __init__(self) -> None:
        self.rest = b""
        """Bytes of a packet that has not ended."""
        self.ended = False
        """True once an END has come."""

    def packets(self, data: bytes) -> Iterator[bytes]:
        """Yield the packets that are whole once `data` has come; raise Broken for a wrong escape or one longer than a
        datagram."""
        *frames, self.rest = (self.rest + data).split(_END)
        self.ended |= bool(frames)
        for frame in frames:
            if frame:
                yield _unescaped(frame)
        if len(self.rest) > 2 * MAX_DATAGRAM:  # all of it escaped
            raise Broken(f"SLIP: {len(self.rest)} bytes without an END: expected packets up to {MAX_DATAGRAM} bytes")

    @property
    def is_unframed(self) -> bool:
        """True if without any END it begins with a whole packet, after which it rests or another one begins."""
        data = self.rest
        for size in range(8, 0 if self.ended else min(len(data), _LONGEST_BARE) + 1, 4):
            if size == len(data) or data[size : size + 1] in (b"/", b"#"):
                with suppress(BadPacket):
                    parse(data[:size])
                    return True
        return False

    @staticmethod
    def framed(packet: bytes) -> bytes:
        return _END + packet.replace(_ESCAPE, b"\xdb\xdd").replace(_END, b"\xdb\xdc") + _END


def _unescaped(frame: bytes) -> bytes:
    head, *tails = frame.split(_ESCAPE)
    parts = [head]
    for tail in tails:
        if tail[:1] not in _ESCAPED:
            raise Broken(f"SLIP: ESC followed by {tail[:1].hex() or 'END'}: expected dc or dd")
        parts += [_ESCAPED[tail[:1]], tail[1:]]
    return b"".join(parts)


class Sized:
    """OSC 1.0 on a stream: each packet after its size, a big-endian int32."""

    last = "as many bytes as the size before them says"
    """End of a packet, in words."""

    def __init__(self) -> None:
        self.rest = b""
        """Bytes of a packet that has not ended, and its size."""

    def packets(self, data: bytes) -> Iterator[bytes]:
        """Yield the packets that are whole once `data` has come; raise Broken for a size that none can have."""
        stream = self.rest + data
        at = 0
        while len(stream) - at >= _SIZE.size:
            (size,) = _SIZE.unpack_from(stream, at)
            if not 0 < size <= MAX_DATAGRAM:
                raise Broken(f"size = {size} bytes: expected 4, 8 ... {MAX_DATAGRAM // 4 * 4}")
            if len(stream) - at - _SIZE.size < size:
                break
            at += _SIZE.size + size
            yield stream[at - size : at]
        self.rest = stream[at:]

    @staticmethod
    def framed(packet: bytes) -> bytes:
        return _SIZE.pack(len(packet)) + packet


Framing = Slip | Sized


def framing(first: int) -> Framing:
    """Return the framing of a stream that begins with this byte; raise Broken if there is none."""
    if first == 0:
        return Sized()
    if bytes([first]) in (_END, b"/", b"#"):
        return Slip()
    raise Broken(
        f"a stream that begins with {first:02x}: expected SLIP (c0), or packets each after its int32 size (00)"
    )
