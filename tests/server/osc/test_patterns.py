"""Address patterns: matched like a naive reference, and in little time, whatever they are."""

import random
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from carom.server.osc.patterns import Selection, TooMuch, match


def naive_match(pattern: str, part: str) -> bool:
    """Match the same language by plain recursion: exponential, and easy to believe."""
    if not pattern:
        return not part
    head, rest = pattern[0], pattern[1:]
    if head == "*":
        return any(naive_match(rest, part[i:]) for i in range(len(part) + 1))
    if head == "{":
        words, closed, rest = rest.partition("}")
        return bool(closed) and any(
            naive_match(rest, part[len(word) :]) for word in words.split(",") if part.startswith(word)
        )
    if head == "[":
        inside, closed, rest = rest.partition("]")
        return bool(closed and part) and naive_in(part[0], inside) and naive_match(rest, part[1:])
    return part != "" and head in ("?", part[0]) and naive_match(rest, part[1:])


def naive_in(character: str, inside: str) -> bool:
    if inside.startswith("!"):
        return not naive_listed(character, inside[1:])
    return naive_listed(character, inside)


def naive_listed(character: str, inside: str) -> bool:
    while inside:
        if len(inside) > 2 and inside[1] == "-":
            if inside[0] <= character <= inside[2]:
                return True
            inside = inside[3:]
        else:
            if inside[0] == character:
                return True
            inside = inside[1:]
    return False


@pytest.mark.slow
@settings(max_examples=500)
@given(st.text("abc-!,*?[]{}", max_size=9), st.text("abc-!,", max_size=6))
def test_match_agrees_with_naive(pattern: str, part: str) -> None:
    assert match(pattern, part) == naive_match(pattern, part)


steps = st.one_of(
    st.sampled_from(["*", "?", "a", "b", "[ab]", "[!a]", "[a-b]", "[!b-c]", "[c-a]", "[a-]", "[]", "[!]"]),
    st.lists(st.text("abc*", max_size=3), max_size=3).map(lambda words: "{" + ",".join(words) + "}"),
)


@pytest.mark.slow
@settings(max_examples=500)
@given(st.lists(steps, max_size=6).map("".join), st.text("abc-!", max_size=7))
def test_match_agrees_with_naive_on_well_formed_patterns(pattern: str, part: str) -> None:
    assert match(pattern, part) == naive_match(pattern, part)


def test_match_agrees_with_naive_often_both_ways() -> None:
    chance = random.Random(1)
    pieces = ["*", "?", "a", "b", "[ab]", "[!a]", "{a,ab,}", "{b,ba}"]
    hits = 0
    for _ in range(4000):
        pattern = "".join(chance.choices(pieces, k=chance.randrange(5)))
        part = "".join(chance.choices("ab", k=chance.randrange(6)))
        assert match(pattern, part) == naive_match(pattern, part), (pattern, part)
        hits += match(pattern, part)
    assert 600 < hits < 3400


@pytest.mark.parametrize(
    ("pattern", "part", "expected"),
    [
        ("*", "", True),
        ("bell", "bell", True),
        ("bell", "bells", False),
        ("b*l", "bell", True),
        ("{bell,glass}-[0-9]", "glass-7", True),
        ("{bell,glass}-[!0-9]", "glass-7", False),
        ("cl?che", "cl\N{BELL}che", True),
        ("[a", "[a", False),
        ("{a", "{a", False),
        ("]}", "]}", True),
        ("a.c", "abc", False),
    ],
)
def test_match_examples(pattern: str, part: str, expected: bool) -> None:
    assert match(pattern, part) is expected


LONG = "a" * 10_000


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pattern", "part", "expected"),
    [
        ("*a" * 17 + "*!", "a" * 60, False),
        ("*" * 20 + "!", "a" * 36, False),
        ("*a" * 5000 + "!", LONG, False),
        ("*a" * 5000, LONG, True),
        ("?" * 10_000, LONG, True),
        ("{a,aa,}" * 1400 + "b", LONG, False),
        ("[a-z]" * 2000 + "*", LONG, True),
        ("[!a]" * 2500, LONG, False),
        ("[" * 10_000, LONG, False),
        ("{" * 10_000, LONG, False),
        ("{" + "a," * 5000 + "}", LONG, False),
        ("*[" + "a-bc" * 2000 + "]*" + "x", LONG, False),
        ("*" * 10_000, "".join(map(chr, range(0x4E00, 0x4E00 + 10_000))), True),
    ],
)
def test_match_takes_no_time(pattern: str, part: str, expected: bool) -> None:
    start = time.process_time()
    assert match(pattern, part) is expected
    assert time.process_time() - start < 2.0


def test_the_work_on_what_was_matched_is_bounded_but_for_one_message():
    selection = Selection(100.0)
    selection.charge(1_000.0, "/object/*/gains")
    selection.charge(0.0, "/object/a/pan")  # no pattern, no work
    with pytest.raises(TooMuch, match=r"^/object/\*/pan: too much for one packet; expected fewer patterns in it$"):
        selection.charge(1.0, "/object/*/pan")
