"""Packets in streams: whatever the pieces in which they come, the same packets leave, and nonsense is refused."""

import random
import time
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from carom.server.osc.framing import Broken, Sized, Slip, framing
from carom.server.osc.wire import MAX_DATAGRAM

FRAMINGS = [Slip, Sized]
awkward = st.sampled_from([b"\xc0\xdb", b"\xdb\xdc\xdd\xc0" * 3])
packets = st.lists(st.one_of(st.binary(min_size=1, max_size=40), awkward))


@pytest.mark.slow
@pytest.mark.parametrize("kind", FRAMINGS)
@given(packets, st.integers(1, 9))
def test_whatever_the_pieces(kind, sent, piece):
    stream = b"".join(map(kind.framed, sent))
    reader = kind()
    got = [packet for i in range(0, len(stream), piece) for packet in reader.packets(stream[i : i + piece])]
    assert got == sent


def test_framed_packets_are_as_the_standards_print_them():
    assert Slip.framed(b"a\xc0b\xdbc") == b"\xc0a\xdb\xdcb\xdb\xddc\xc0"
    assert Sized.framed(b"/abc\0\0\0\0") == b"\0\0\0\x08/abc\0\0\0\0"
    # Many ENDs in a row are line noise, and a first packet may come without one (RFC 1055).
    assert list(Slip().packets(b"/a\0\0\xc0\xc0\xc0/b\0\0\xc0")) == [b"/a\0\0", b"/b\0\0"]


@pytest.mark.parametrize("kind", FRAMINGS)
def test_the_largest_packet(kind):
    largest = b"\xc0" * MAX_DATAGRAM
    assert list(kind().packets(kind.framed(largest))) == [largest]


@pytest.mark.parametrize(
    ("kind", "stream", "before", "reason"),
    [
        (Slip, b"\xc0/a\0\0\xc0\xc0ab\xdbcd\xc0/b\0\0\xc0", [b"/a\0\0"], "ESC followed by 63"),
        (Slip, b"\xc0ab\xdb\xc0", [], "ESC followed by END"),
        (Slip, b"a" * (2 * MAX_DATAGRAM + 1), [], "without an END"),
        (Sized, b"\0\0\0\4/a\0\0\0\0\0\0", [b"/a\0\0"], "size = 0 bytes"),
        (Sized, b"\0\1\0\0", [], "size = 65536"),
        (Sized, b"\xff\xff\xff\xfc", [], "size = -4"),
    ],
)
def test_nonsense_is_refused(kind, stream, before, reason):
    got = []
    with pytest.raises(Broken, match=reason):
        for packet in kind().packets(stream):
            got.append(packet)
    assert got == before


def test_told_apart_by_the_first_byte():
    assert isinstance(framing(0), Sized)
    for first in b"\xc0/#":
        assert isinstance(framing(first), Slip)
    for first in set(range(256)) - set(b"\0\xc0/#"):
        with pytest.raises(Broken, match=f"begins with {first:02x}"):
            framing(first)


@pytest.mark.parametrize("kind", FRAMINGS)
def test_random_streams_end_or_go_on(kind):
    chance = random.Random(3)
    for _ in range(300):
        stream = bytes(chance.choices(b"\0\0\0\4\xc0\xdb\xdc\xdd/a,", k=400))
        with suppress(Broken):
            assert all(list(kind().packets(stream)))


@pytest.mark.slow
@pytest.mark.parametrize("kind", FRAMINGS)
def test_a_packet_in_single_bytes_takes_no_time(kind):
    stream = kind.framed(bytes(range(256)) * 255)
    reader = kind()
    started = time.process_time()
    assert sum(len(list(reader.packets(stream[i : i + 1]))) for i in range(len(stream))) == 1
    assert time.process_time() - started < 2.0
