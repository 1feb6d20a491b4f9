"""Words that are not known, and those that are meant."""

import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from carom.dsp.wording import expected, near, suggestion

KEYS = ("length", "width", "thickness", "edges", "path_from", "path_to")


@pytest.mark.parametrize(
    ("word", "known", "found"),
    [
        ("lenght", KEYS, ["length"]),
        ("LENGTH", KEYS, ["length"]),
        ("bell", ("church-bell", "gong", "tubular-bell"), ["church-bell", "tubular-bell"]),  # a part of both
        ("rendre", ("serve", "render", "send"), ["render"]),  # the others are much less near
        ("gain", (), []),
        ("colour", KEYS, []),
        ("be", ("church-bell",), []),
        ("-50", ("-40", "-60"), []),  # a number is wrong, not misspelt
    ],
)
def test_the_nearest_words_are_found(word, known, found):
    assert near(word, known) == found


def test_an_error_asks_or_lists():
    assert expected("lenght", KEYS) == "did you mean length?"
    assert expected("colour", KEYS) == f"expected one of {', '.join(KEYS)}"
    assert expected(1.0, ("a", "b")) == "expected one of a, b" and expected("a", ()) == "there is none"
    assert suggestion("colour", KEYS) == suggestion(None, KEYS) == ""
    many = [f"word{n}" for n in range(2_000)]
    assert expected("colour", many).endswith("word62, word63 and 1,936 more")


@pytest.mark.slow
@given(st.text(max_size=80), st.lists(st.text(max_size=80), max_size=8))
def test_any_text_is_compared(word, known):
    assert set(near(word, known)) <= set(known)


def test_many_long_names_are_compared_in_little_time():
    """A server refuses thousands of messages a second, and may have 512 objects."""
    names = [f"{'name' * 14}{n:08d}" for n in range(512)]
    begun = time.thread_time()
    assert near("name" * 14 + "0000000x", names)
    assert time.thread_time() - begun < 0.05
