"""Bounds of numbers: none can be declared without, and what is too little to tell is 0 or refused."""

import dataclasses
import gc
import importlib
import math
import pkgutil

import pytest

import carom
from carom.dsp.errors import CaromError
from carom.dsp.numerics.quantities import BOUNDS, Parameter, Range, Ranged
from carom.presets import schema
from carom.presets.gestures import FIELDS
from carom.presets.values import Many, Quantity, Row, Rows
from carom.server import options, render
from carom.server.osc.addresses import VERBS
from carom.server.osc.arguments import Note, Numbers, Refused, Vector, check_number, shown

SUBNORMAL = 5e-324
WRONG = (math.nan, math.inf, -math.inf, 1e308, -1e308, 10**400)


@pytest.mark.parametrize("ends", [(0.0, math.inf), (-math.inf, 0.0), (math.nan, 1.0), (2.0, 1.0), (0.0, 1e300)])
@pytest.mark.parametrize("kind", [Range, Quantity, lambda *ends: Parameter("x", *ends)])
def test_a_range_without_finite_bounds_cannot_be_declared(kind, ends):
    with pytest.raises(ValueError, match="expected a range within"):
        kind(*ends)


def test_a_range_beyond_its_unit_or_of_an_unknown_one_cannot_be_declared():
    with pytest.raises(ValueError, match="expected a range within"):
        Range(0.0, 1e10, "kg")
    with pytest.raises(ValueError, match="expected no end that is less than 1e-15, but 0"):
        Range(1e-20, 1.0, "kg")
    with pytest.raises(ValueError, match="unit = 'furlong': expected one of"):
        Range(0.0, 1.0, "furlong")
    with pytest.raises(ValueError, match="expected a range within"):
        Range(0.0, 1.0, "kg", or_zero=True)


def ranges():
    """Return all ranges that any module of Carom has declared."""
    for each in pkgutil.walk_packages(carom.__path__, "carom."):
        if each.name.split(".")[1] in ("dsp", "presets", "server") or ".dataset." in each.name:
            try:
                importlib.import_module(each.name)
            except ImportError:
                continue
    # An object's own type: a weak reference's proxy would answer for what is gone.
    return [each for each in gc.get_objects() if issubclass(type(each), Ranged)]


@pytest.mark.slow
def test_all_declared_ranges_lie_within_the_bounds_of_their_units():
    found = ranges()
    assert len(found) > 300
    for each in found:
        _, least, most = BOUNDS[each.unit]
        assert all(math.isfinite(end) and (end == 0 or least <= abs(end) <= most) for end in (each.low, each.high))
        assert all(each.within(value) is None for value in WRONG), each
        assert each.within(SUBNORMAL) in (None, 0.0) and each.within(-SUBNORMAL) in (None, 0.0)
        assert each.within(each.low) == float(each.low) and each.within(each.high) == float(each.high)
        assert (each.within(0.0) == 0.0) == (each.or_zero or each.low <= 0.0 <= each.high)


def leaves(domain):
    """Return the numbers that a domain holds."""
    if isinstance(domain, Row):
        return [leaf for each in domain.items for leaf in leaves(each)]
    return leaves(domain.item) if isinstance(domain, Many | Rows) else [domain]


def test_every_number_of_an_address_or_a_preset_has_a_range():
    numbers = []
    for verb in VERBS.values():
        for key in (*verb.required, *verb.optional, *verb.keys, *((verb.many,) if verb.many else ())):
            numbers += key.axes if isinstance(key, Vector) else (key.number if isinstance(key, Numbers) else key,)
    numbers = [each for each in numbers if hasattr(each, "low")]
    assert len(numbers) > 200 and all(isinstance(each, Parameter | Note) for each in numbers)
    fields = [each for each in vars(schema).values() if isinstance(each, dict)] + list(FIELDS.values())
    fields += [each.fields for each in (*schema.SHAPES.values(), *schema.ADDED.values())]
    found = [leaf for each in fields for domain in each.values() for leaf in leaves(domain)]
    numbers = [each for each in found if hasattr(each, "low")]
    assert len(numbers) > 150 and all(isinstance(each, Ranged) for each in numbers)


@pytest.mark.parametrize("chosen", [options.Options, render.Options])
def test_every_number_of_an_option_is_checked(chosen):
    for each in dataclasses.fields(chosen):
        if each.name != "contact" and ("int" in str(each.type) or "float" in str(each.type)):  # its own check has that
            for value in WRONG:
                given = (value, value) if "tuple" in str(each.type) else value
                with pytest.raises((CaromError, TypeError), match=r"[Ee]xpected"):
                    chosen(**{each.name: given})


@pytest.mark.parametrize("value", [SUBNORMAL, 1e-308, -SUBNORMAL, 1e-10, 2e6, math.nan, math.inf, -1.0])
@pytest.mark.parametrize("name", ["wall_mass", "thick_mass"])
def test_a_mass_that_may_be_0_is_0_or_a_mass(name, value):
    number = VERBS["/object/NAME/shatter"].named[name]
    assert check_number(number, 0) == 0.0 and check_number(number, -0.0) == 0.0 and check_number(number, 1e-9) == 1e-9
    with pytest.raises(Refused) as refused:
        check_number(number, value)
    assert str(refused.value) == f"{name} = {shown(value)}: expected 0, or from 1e-09 to 1e+06 kg"


def test_numbers_too_small_to_tell_are_0():
    velocity = VERBS["/object/NAME/impact"].named["velocity"]
    assert check_number(velocity, SUBNORMAL) == 0.0 and check_number(velocity, 1e-300) == 0.0
    assert check_number(velocity, 1e-6) == 1e-6
    assert Range(-1.0, 1.0).within(-SUBNORMAL) == 0.0
