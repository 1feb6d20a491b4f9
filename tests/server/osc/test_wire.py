"""OSC on the wire: what is read, what is refused, and that neither takes long, whatever arrives."""

import math
import struct
import time
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pythonosc.osc_bundle import OscBundle
from pythonosc.osc_message import OscMessage

from carom.server.osc import wire
from carom.server.osc.wire import IMMEDIATELY, BadPacket, Bundle, Message

# The two examples of the OSC 1.0 specification, byte for byte.
FREQUENCY = b"/oscillator/4/frequency\0,f\0\0\x43\xdc\0\0"
FOO = b"/foo\0\0\0\0,iisff\0\0\0\0\x03\xe8\xff\xff\xff\xffhello\0\0\0\x3f\x9d\xf3\xb6\x40\xb5\xb2\x2d"
# As sclang 3.13 sends 3, true, false, nil, $[, 1, 2.5, "q", $], $T, $N, \\sym, Int8Array[1, 2, 3].
SCLANG = (
    b"#bundle\0\0\0\0\0\0\0\0\1\0\0\0</x\0\0,iiii[ifs]TNsb\0\0\0\0\0\3\0\0\0\1\0\0\0\0\0\0\0\0"
    b"\0\0\0\1@ \0\0q\0\0\0sym\0\0\0\0\3\1\2\3\0"
)


def only(datagram: bytes) -> Message:
    (bundle,) = wire.parse(datagram)
    assert bundle.time == IMMEDIATELY
    (message,) = bundle.messages
    return message


def packed(address: bytes, tags: bytes = b"", data: bytes = b"") -> bytes:
    padded = [text + bytes(4 - len(text) % 4) for text in (address, tags)]
    return b"".join(padded) + data


def bundled(time_tag: int, *elements: bytes) -> bytes:
    sized = [struct.pack(">i", len(element)) + element for element in elements]
    return b"#bundle\0" + struct.pack(">Q", time_tag) + b"".join(sized)


def as_lists(value: object) -> object:
    return [as_lists(item) for item in value] if isinstance(value, list | tuple) else value


def test_specification_examples() -> None:
    assert only(FREQUENCY) == Message("/oscillator/4/frequency", (440.0,))
    message = only(FOO)
    assert message.args[:3] == (1000, -1, "hello")
    assert message.args[3:] == pytest.approx((1.234, 5.678), rel=1e-7)
    assert wire.encode("/oscillator/4/frequency", 440.0) == FREQUENCY
    assert wire.encode("/foo", 1000, -1, "hello", 1.234, 5.678) == FOO


def test_sclang_bundle() -> None:
    assert only(SCLANG) == Message("/x", (3, 1, 0, 0, (1, 2.5, "q"), True, None, "sym", b"\1\2\3"))


@pytest.mark.parametrize(
    ("tags", "data", "args"),
    [
        (b",", b"", ()),
        (b",i", struct.pack(">i", -5), (-5,)),
        (b",h", struct.pack(">q", -(2**63)), (-(2**63),)),
        (b",f", struct.pack(">f", 0.1), (0.10000000149011612,)),
        (b",d", struct.pack(">d", 0.1), (0.1,)),
        (b",d", struct.pack(">d", math.inf), (math.inf,)),
        (b",t", struct.pack(">Q", 2**64 - 1), (2**64 - 1,)),
        (b",r", b"\xff\0\0\x80", (0xFF000080,)),
        (b",m", b"\0\x90\x3c\x7f", (b"\0\x90\x3c\x7f",)),
        (b",cc", b"\0\0\0\x01\0\0\0\x7f", ("\x01", "\x7f")),
        (b",sS", "né\0\0\0\0\0".encode()[:4] + b"abc\0", ("né", "abc")),
        (b",s", b"\0\0\0\0", ("",)),
        (b",b", b"\0\0\0\x05abcde\0\0\0", (b"abcde",)),
        (b",b", b"\0\0\0\0", (b"",)),
        (b",TFNI", b"", (True, False, None, True)),
        (b",[i[s]]f", b"\0\0\0\1a\0\0\0\0\0\0\0", ((1, ("a",)), 0.0)),
        (b",[][[T]]", b"", ((), ((True,),))),
    ],
)
def test_every_type(tags: bytes, data: bytes, args: tuple[wire.Argument, ...]) -> None:
    read = only(packed(b"/a", tags, data)).args
    assert read == args
    assert [type(value) for value in read] == [type(value) for value in args]


def test_nan_passes() -> None:
    (value,) = only(packed(b"/a", b",f", b"\x7f\xc0\0\0")).args
    assert isinstance(value, float) and math.isnan(value)


def test_the_longest_address() -> None:
    assert len(only(packed(b"/" + b"*" * 1023, b",")).address) == 1024


def test_without_type_tags() -> None:
    assert only(b"/abc\0\0\0\0") == Message("/abc")


def test_nested_bundles_come_flat_in_order() -> None:
    a, b, c, d = (packed(b"/" + name, b",") for name in (b"a", b"b", b"c", b"d"))
    inner = bundled(30, c)
    assert wire.parse(bundled(20, a, b, inner, bundled(40), d)) == [
        Bundle(20, (Message("/a"), Message("/b"))),
        Bundle(30, (Message("/c"),)),
        Bundle(20, (Message("/d"),)),
    ]
    assert wire.parse(bundled(20)) == []


def nested(depth: int) -> bytes:
    packet = packed(b"/a", b",")
    for _ in range(depth):
        packet = bundled(1, packet)
    return packet


def test_depth() -> None:
    assert only(nested(8)) == Message("/a")
    with pytest.raises(BadPacket, match="deeper than 8"):
        wire.parse(nested(9))
    with pytest.raises(BadPacket, match="deeper than 8"):
        wire.parse(nested(3000))


@pytest.mark.parametrize(
    ("datagram", "reason"),
    [
        (b"", "0 bytes"),
        (b"/ab\0,", "5 bytes"),
        (bytes(65512), "at most 65507"),
        (b"/abc", "address: a string without its closing zero"),
        (b"abc\0", "'abc': expected it to start with /"),
        (b"\0\0\0\0", "'': expected it to start with /"),
        (packed(b"/" + b"*" * 1024), "address of 1025 characters: expected at most 1024"),
        (b"/\xff\xfe\0", "address: a string that is not UTF-8"),
        (b"/a\0\0,i\0\0", "argument 1 of type i is cut short"),
        (b"/a\0\0,d\0\0\0\0\0\0", "argument 1 of type d is cut short"),
        (b"/a\0\0,is\0\0\0\0\1abcd", "argument 2: a string without its closing zero"),
        (b"/a\0\0,s\0\0\xc3\x28\0\0", "argument 1: a string that is not UTF-8"),
        (b"/a\0\0,iii", "type tags: a string without its closing zero"),
        (b"/a\0\0,Q\0\0", "argument 1 has the type tag 'Q'"),
        (b"/a\0\0,]\0\0", "type tag ']'"),
        (b"/a\0\0,[[]\0\0\0\0", "array is not closed"),
        (packed(b"/a", b",[]]"), "type tag ']'"),
        (packed(b"/a", b",[[i]i", bytes(6)), "expected a multiple of 4"),
        (packed(b"/a", b",[[i]i", bytes(4)), "argument 2 of type i is cut short"),
        (packed(b"/a", b"," + b"[" * 9 + b"]" * 9), "arrays nested deeper than 8"),
        (packed(b"/a", b"," + b"[" * 60_000), "arrays nested deeper than 8"),
        (b"/a\0\0\0\0\0\1", "arguments without type tags"),
        (b"/a\0\0,\0\0\0\0\0\0\1", "4 bytes after the last argument"),
        (b"/a\0\0,b\0\0\xff\xff\xff\xfc", "blob of size -4, with 0 bytes left"),
        (b"/a\0\0,b\0\0\0\0\0\5abcd", "blob of size 5, with 4 bytes left"),
        (b"/a\0\0,c\0\0\0\0\1\0", "expected an ASCII character"),
        (b"/a\0\0,c\0\0\0\0\0\0", "expected an ASCII character"),
        (b"#bundle\0\0\0\0\0", "bundle of 12 bytes"),
        (bundled(1) + b"\xff\xff\xff\xfc", "element of -4 bytes"),  # on which python-osc loops for ever
        (bundled(1) + b"\0\0\0\0", "element of 0 bytes"),
        (bundled(1) + b"\0\0\0\3abc\0", "element of 3 bytes"),
        (bundled(1) + b"\0\0\0\x08/a\0\0", "element of 8 bytes: expected 4, 8 ... 4"),
        (bundled(1) + b"\x7f\xff\xff\xfc/a\0\0", "element of 2147483644 bytes"),
        (bundled(1, packed(b"/good", b","), b"bad\0"), "'bad'"),
    ],
)
def test_bad_packets(datagram: bytes, reason: str) -> None:
    with pytest.raises(BadPacket) as refused:
        wire.parse(datagram)
    assert reason in str(refused.value)


texts = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=9)
scalars = st.one_of(
    st.integers(-(2**63), 2**63 - 1),
    st.floats(width=32),
    texts,
    st.booleans(),
    st.none(),
    st.binary(min_size=1, max_size=9),
)
arguments = scalars | st.recursive(scalars, lambda items: st.lists(items, max_size=4).map(tuple), max_leaves=8)
messages = st.builds(Message, texts.map("/".__add__), st.lists(arguments, max_size=6).map(tuple))
tags = st.integers(0, 2**64 - 1)


@pytest.mark.slow
@given(tags, st.lists(messages, min_size=1, max_size=4), st.sampled_from("fd"))
def test_bundle_reads_as_written(tag: int, sent: list[Message], real: str) -> None:
    (bundle,) = wire.parse(wire.encode_bundle(tag, sent, real=real))
    # repr: NaN is itself there, and True is not 1.
    assert (bundle.time, repr(bundle.messages)) == (tag, repr(tuple(sent)))


@pytest.mark.slow
@given(messages)
def test_python_osc_reads_what_is_written(message: Message) -> None:
    sent = wire.encode(message.address, *message.args, real="d")
    read = OscMessage(sent)
    assert (read.address, repr(read.params)) == (message.address, repr(as_lists(message.args)))
    assert OscBundle(wire.encode_bundle(IMMEDIATELY, [message])).num_contents == 1


def survives(datagram: bytes) -> None:
    try:
        bundles = wire.parse(datagram)
    except BadPacket:
        return
    assert all(message.address.startswith("/") for bundle in bundles for message in bundle.messages)


@pytest.mark.slow
@settings(max_examples=500)
@given(st.binary(max_size=80), st.sampled_from([b"", b"/a\0\0,", b"#bundle\0", bundled(1)]))
def test_random_bytes(tail: bytes, head: bytes) -> None:
    survives(head + tail)
    survives(head + tail + bytes(-len(head + tail) % 4))


@pytest.mark.slow
@settings(max_examples=500)
@given(tags, st.lists(messages, min_size=1, max_size=3), st.data())
def test_mutated_packets(tag: int, sent: list[Message], data: st.DataObject) -> None:
    inner = wire.encode_bundle(tag, sent)
    packet = bytearray(bundled(tag, inner, wire.encode(sent[0].address), inner))
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(packet) - 1))
        packet[at] = data.draw(st.sampled_from([0, 1, 4, 0x7F, 0x80, 0xFC, 0xFF, *b"/#,sibd[]T"]))
    survives(bytes(packet))


@pytest.mark.parametrize(
    ("packet", "whole"),
    [
        (FREQUENCY, {24}),
        (FOO, {8}),
        (SCLANG, {16}),
        (nested(8), {16}),
        (bundled(1, FOO, bundled(2, SCLANG)), {16, 20 + len(FOO)}),
    ],
)
def test_truncated_at_every_length(packet: bytes, whole: set[int]) -> None:
    """Only an address alone, and a bundle cut between its elements, are OSC still."""
    for size in set(range(len(packet))) - whole:
        with pytest.raises(BadPacket):
            wire.parse(packet[:size])
    for size in whole:
        wire.parse(packet[:size])


@pytest.mark.parametrize(
    "packet",
    [
        packed(b"/a", b"," + b"T" * 65000),
        packed(b"/a", b"," + b"[]" * 32000),
        packed(b"/a", b"," + b"s" * 13000, bytes(4 * 13000)),
        packed(b"/a", b"," + b"b" * 13000, bytes(4 * 13000)),
        packed(b"/a", b"," + b"d" * 7200, bytes(8 * 7200)),
        packed(b"/a", b",s", b"a" * 65000 + bytes(4)),
        bundled(1, *[b"/\0\0\0"] * 8000),
        bundled(1, *[bundled(1)] * 3000),
        bundled(1, *[nested(7)] * 420),
    ],
)
def test_the_largest_packets_take_no_time(packet: bytes) -> None:
    start = time.process_time()
    wire.parse(packet)
    assert time.process_time() - start < 1.0


@pytest.mark.parametrize(
    ("address", "args"),
    [
        ("a", ()),
        ("", ()),
        ("/a\0b", ()),
        ("/a", ("x\0y",)),
        ("/a", ("\ud800",)),
        ("/a", (b"",)),
        ("/a", (2**63,)),
        ("/a", (1e39,)),
        ("/a", ({},)),
        ("/a", ([{}],)),
        ("/a", (["x\0y"],)),
        ("/a", ((1, (2**63,)),)),
        ("/a", ("x" * 65507,)),
    ],
)
def test_messages_that_osc_cannot_carry_are_refused(address: str, args: tuple[wire.Argument, ...]) -> None:
    with pytest.raises(ValueError):
        wire.encode(address, *args)


def test_bundle_too_large() -> None:
    assert len(wire.encode("/a", "x" * 65_495)) == 65_504  # the most that is a multiple of 4
    with pytest.raises(ValueError, match="65508 bytes"):
        wire.encode("/a", "x" * 65_496)
    with pytest.raises(ValueError, match="65507"):
        wire.encode_bundle(1, [Message("/a", ("x" * 40000,))] * 2)


@given(st.floats(allow_nan=False))
def test_doubles_lose_nothing(value: float) -> None:
    assert only(wire.encode("/a", value, real="d")).args == (value,)


def test_strict_types() -> None:
    sent = wire.encode("/a", 1, 2**31, 1.0, "s", b"b", True, False, None)
    assert sent[4:16] == b",ihfsbTFN\0\0\0"


@given(st.floats(-2208988799, 2**33 - 2208988801), st.floats(-(2**31) + 1, 2**31 - 1))
def test_time_tags(seconds: float, away: float) -> None:
    """Of two eras, each 136 years long, read by a clock that is up to 68 years away."""
    exact = (Fraction(seconds) + 2208988800) * 2**32 % 2**64
    tag = wire.time_tag(seconds)
    assert min(abs(tag - exact), 2**64 - abs(tag - exact)) <= 2
    read = wire.unix_ns(tag, round(10**9 * (Fraction(seconds) + Fraction(away))))
    assert abs(read - 10**9 * Fraction(seconds)) <= 10**9 * Fraction(1, 2**31) + 2


def test_time_tag_landmarks() -> None:
    assert wire.time_tag(0.0) == 2208988800 << 32
    assert wire.time_tag(1.5) == 2208988801 << 32 | 1 << 31
    second = 2**32 - 2208988800  # 7 February 2036, 06:28:16 UTC
    assert [wire.time_tag(second - 1.0), wire.time_tag(second), wire.time_tag(second + 1.0)] == [
        (2**32 - 1) << 32, wire.IMMEDIATELY + 1, 1 << 32,
    ]  # fmt: skip
    for beyond in (2**33 - 2208988800, -2208988801, math.nan, math.inf):
        with pytest.raises(ValueError, match="26 February 2242"):
            wire.time_tag(beyond)
