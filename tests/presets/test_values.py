"""Values: what fits is used, what does not is named, and its item in a list."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from carom.presets.values import Choice, Many, Name, OneOrMany, Quantity, Row, Section, Text, Unfit, Whole, shown

NUMBER = Quantity(-2, 5, "m")
WORD = Choice(("free", "clamped"))
POINT = Row((NUMBER, Quantity(0, 1)))


@pytest.mark.parametrize(
    ("domain", "value", "fitted"),
    [
        (NUMBER, 3, 3.0),
        (NUMBER, -2.0, -2.0),
        (Whole(1, 3), 2.0, 2),
        (Whole(0, 2**63 - 1), 2**53 + 1, 2**53 + 1),
        (Text(), "a b", "a b"),
        (Name(), "a-b_1", "a-b_1"),
        (WORD, "free", "free"),
        (POINT, [1, 0], (1.0, 0.0)),
        (POINT, (1, 0), (1.0, 0.0)),
        (Many(NUMBER), [1], (1.0,)),
        (OneOrMany(NUMBER), 1, 1.0),
        (OneOrMany(NUMBER), (1, 2), (1.0, 2.0)),
        (Section(), {"a": 1}, {"a": 1}),
    ],
)
def test_a_value_that_fits_is_given_as_it_is_used(domain, value, fitted):
    result = domain.fit(value)
    assert result == fitted and type(result) is type(fitted)


@pytest.mark.parametrize(
    ("domain", "value", "message"),
    [
        (NUMBER, 6, " = 6: expected a number from -2 to 5 m"),
        (NUMBER, math.nan, " = nan: expected a number from -2 to 5 m"),
        (NUMBER, True, " = True: expected a number from -2 to 5 m"),
        (NUMBER, "1", " = '1': expected a number from -2 to 5 m"),
        (Whole(1, 3), 1.5, " = 1.5: expected a whole number from 1 to 3"),
        (Text(), 1, " = 1: expected a text"),
        (Name(), "a b", " = 'a b': expected a name of up to 64 letters, digits, _ and -"),
        (WORD, "loose", " = 'loose': expected one of free, clamped"),
        (POINT, (1,), " = [1]: expected a list of 2: a number from -2 to 5 m, then a number from 0 to 1"),
        (POINT, [1, 2], ": item 2 = 2: expected a number from 0 to 1"),
        (Many(NUMBER), (), " = []: expected a list of 1 to 1024, each a number from -2 to 5 m"),
        (Many(NUMBER), [1, 9], ": item 2 = 9: expected a number from -2 to 5 m"),
        (OneOrMany(NUMBER), 9, " = 9: expected a number from -2 to 5 m, or a list of such"),
        (OneOrMany(NUMBER), [9], ": item 1 = 9: expected a number from -2 to 5 m"),
        (Section(), 1, " = 1: expected a section of keys"),
    ],
)
def test_a_value_that_does_not_fit_is_named(domain, value, message):
    with pytest.raises(Unfit) as caught:
        domain.fit(value)
    assert str(caught.value) == message


@given(st.lists(st.floats(-2, 5), min_size=1), st.sampled_from([",", ", ", " ", " ,", "\t"]))
def test_a_text_spells_its_numbers_exactly(numbers, separator):
    told = tuple(0.0 if abs(each) < NUMBER.least else each for each in numbers)
    assert Many(NUMBER).fit(Many(NUMBER).parse(separator.join(map(repr, numbers)))) == told


@pytest.mark.slow
@given(st.text())
def test_any_text_is_parsed(text):
    for domain in (Many(NUMBER), POINT, OneOrMany(NUMBER)):
        try:
            domain.fit(domain.parse(text))
        except Unfit as error:
            assert ": expected a" in str(error)


@pytest.mark.slow
@given(st.recursive(st.floats() | st.text() | st.none(), lambda inner: st.lists(inner) | st.lists(inner).map(tuple)))
def test_errors_stay_short(value):
    assert len(shown(value)) <= 300
