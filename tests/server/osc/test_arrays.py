"""Arrays: lists, tuples and numpy's as they go over OSC."""

import numpy as np
import pytest

from carom.server.osc import wire


def nested_list(depth: int) -> list[object]:
    inner: list[object] = []
    for _ in range(depth - 1):
        inner = [inner]
    return inner


def sent_and_read(value: object) -> wire.Argument:
    (bundle,) = wire.parse(wire.encode("/a", value, real="d"))
    (message,) = bundle.messages
    (argument,) = message.args
    return argument


def test_the_deepest_array() -> None:
    packet = wire.encode("/a", nested_list(8))
    assert packet == b"/a\0\0," + b"[" * 8 + b"]" * 8 + bytes(3)
    assert sent_and_read(nested_list(8)) == wire.argument(nested_list(8))
    for depth in (9, 100_000):
        with pytest.raises(ValueError, match="/a: cannot send"):
            wire.encode("/a", nested_list(depth))


def test_the_numbers_of_an_array_have_strict_types() -> None:
    assert wire.encode("/a", [1.0, [2, "s"]], 3.0)[4:16] == b",[f[is]]f\0\0\0"
    assert wire.encode("/a", [1.0], real="d")[4:8] == b",[d]"


@pytest.mark.parametrize(
    ("value", "read"),
    [
        ([1, 2.5, "a"], (1, 2.5, "a")),
        ((1, 2, 3, 4), (1, 2, 3, 4)),  # not MIDI
        ([True, None, [b"x", []]], (True, None, (b"x", ()))),
        (np.array([440.0, 881.5]), (440.0, 881.5)),
        (np.array([[1, 2], [3, 4]]), ((1, 2), (3, 4))),
        ([np.float32(0.5), np.int64(3), np.bool_(True)], (0.5, 3, True)),
        (np.float32(0.1), 0.10000000149011612),
        (np.str_("a"), "a"),
    ],
)
def test_lists_and_numpy_go_as_arrays_and_plain_values(value: object, read: wire.Argument) -> None:
    assert repr(sent_and_read(value)) == repr(read)
    assert repr(wire.argument(value)) == repr(read)
