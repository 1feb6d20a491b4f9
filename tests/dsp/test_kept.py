"""A cache keeps what was asked for last, as far as it fits, and not for long."""

import time

from carom.dsp import kept
from carom.dsp.kept import Kept


def test_values_asked_for_last_are_kept_as_far_as_they_fit():
    values = Kept(30, len)
    for key in "abc":
        values.put(key, key * 10)
    first = values.get("a")
    values.put("d", "d" * 10)
    assert [values.get(key) is not None for key in "abcd"] == [True, False, True, True]
    values.put("a", "a" * 5)  # another thread made the same
    assert values.get("a") is first
    assert dict(values.all()) == {key: key * 10 for key in "acd"}
    values.put("e", "e" * 31)
    assert not values.all()
    values.put("f", "f" * 30)
    assert values.get("f")


def test_values_that_nobody_asks_for_go_when_another_is_asked_for(monkeypatch):
    values, now = Kept(30, len), 1_000.0
    monkeypatch.setattr(time, "monotonic", lambda: now)
    values.put("a", "aaa")
    values.put("b", "bbb")
    now += 0.75 * kept.SECONDS
    assert values.get("a")
    now += 0.5 * kept.SECONDS
    assert values.get("c") is None
    assert [key for key, _ in values.all()] == ["a"]
    values.put("c", "ccc")
    assert [key for key, _ in values.all()] == ["a", "c"]
    for number in range(10):  # what has gone takes no room
        now += 2.0 * kept.SECONDS
        values.put(f"d{number}", "d" * 30)
        assert len(values.all()) == 1


def test_all_that_is_kept_anywhere_is_forgotten_once_nobody_asks(monkeypatch):
    first, second, now = Kept(30, len), Kept(30, len), 1_000.0
    monkeypatch.setattr(time, "monotonic", lambda: now)
    first.put("a", "1234")
    second.put("b", "1234")
    kept.forget()
    assert first.all() and second.all()
    now += kept.SECONDS + 1.0
    kept.forget()
    assert not first.all() and not second.all()
