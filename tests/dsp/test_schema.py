"""The schema: its declarations agree with each other, and do not depend on the interpreter's hashes."""

import ast
import dataclasses
import subprocess
import sys
from pathlib import Path

import pytest

from carom.dsp import schema
from carom.dsp.counters import Stats
from carom.dsp.schema import (
    GESTURES,
    PRESS,
    SETTINGS,
    STEERABLE,
    STRIKE,
    Parameter,
    gestures_steered_by,
)
from carom.dsp.schema_records import STATS, STEERED

PARAMETERS = [
    *((gesture.name, each) for gesture in GESTURES.values() for each in (gesture.argument, *STRIKE, *gesture.keys)),
    *(("object", setting) for setting in SETTINGS.values()),
]


def test_names_are_unique():
    """A gesture's key may stand for the one of the same name that all gestures share, and for no other."""
    for gesture in GESTURES.values():
        for names in (
            [each.name for each in (gesture.argument, *gesture.keys)],
            [each.name for each in (gesture.argument, *STRIKE)],
        ):
            assert len(names) == len(set(names)), gesture.name
    assert len(STEERABLE) == len(set(STEERABLE))


def test_a_default_is_allowed_and_so_is_the_useful_range():
    for owner, parameter in PARAMETERS:
        low, high = parameter.low, parameter.high
        assert low < high, (owner, parameter.name)
        assert parameter.default is None or parameter.within(parameter.default) == parameter.default, owner
        if parameter.useful:
            assert low <= parameter.useful[0] < parameter.useful[1] <= high, (owner, parameter.name)


def test_glides_are_declared_for_steerable_parameters_alone():
    for owner, parameter in PARAMETERS:
        assert parameter.glide >= 0.0 and parameter.name.islower(), (owner, parameter.name)
        assert parameter.steerable or (parameter.glide == 0.0 and parameter.steered == ""), (owner, parameter.name)
        if parameter.whole:
            assert {parameter.low % 1, parameter.high % 1} == {0.0}, (owner, parameter.name)


def test_every_gesture_is_explained_and_named_as_its_key_says():
    for name, gesture in GESTURES.items():
        assert gesture.name == name and gesture.help
    for name, setting in SETTINGS.items():
        assert setting.name == name and setting.help


def test_a_counter_has_a_type_and_a_meaning():
    for field in dataclasses.fields(Stats):
        assert field.type in (int, float) and field.metadata["help"], field.name
        assert type(field.default) is field.type, field.name
        assert STATS[field.name].kind == {int: "i", float: "f"}[field.type], field.name


@pytest.mark.slow
def test_every_counter_is_written_by_the_engine():
    """One that is declared and not counted would always be what it was at the beginning."""
    folder = Path(schema.__file__).parent
    written = set()
    for path in (*(folder / "engine").rglob("*.py"), folder / "runtime" / "callback.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
            written |= {each.attr for each in targets if isinstance(each, ast.Attribute) and "stats" in ast.dump(each)}
    assert {field.name for field in dataclasses.fields(Stats)} <= written


def test_the_records_hold_what_is_declared_in_its_order():
    assert STATS.names == tuple(field.name for field in dataclasses.fields(Stats))
    assert STEERED.names == STEERABLE


def test_the_steerable_are_those_of_the_gestures():
    assert set(STEERABLE) == {name for gesture in GESTURES.values() for name in gesture.steerable}
    for name in STEERABLE:
        steered = gestures_steered_by(name)
        assert set(steered) == {gesture.name for gesture in GESTURES.values() if name in gesture.steerable}
        assert steered and all(parameter.name == name and parameter.steerable for parameter in steered.values())
    assert "gain" not in PRESS.steerable and "gain" in GESTURES["impact"].steerable


@pytest.mark.slow
@pytest.mark.parametrize("seed", ["1", "2"])
def test_numbers_of_the_steerable_do_not_depend_on_hashes(seed):
    """The numbers stand in the engine's compiled code, which is kept between runs."""
    code = "from carom.dsp.schema import STEERABLE; print(*STEERABLE)"
    told = subprocess.check_output([sys.executable, "-c", code], env={"PYTHONHASHSEED": seed}, text=True)
    assert tuple(told.split()) == STEERABLE


def test_units_of_users_become_those_of_the_engine():
    settings = {name: setting.in_engine for name, setting in SETTINGS.items()}
    assert settings["gain"](-20.0) == pytest.approx(0.1, rel=1e-15)
    assert settings["tune"](12.0) == 2.0 and settings["tune"](-1.0) == pytest.approx(2 ** (-1 / 12), rel=1e-15)
    assert settings["pan"](-0.3) == -0.3 and settings["decay"](2.0) == 2.0


def test_a_range_is_told_with_its_unit():
    assert str(Parameter("height", 0.0, 1000.0, "m")) == "height 0 to 1000 m"
    assert str(Parameter("mass", 1e-9, 1e6, "kg", or_zero=True)) == "mass 0, or 1e-09 to 1e+06 kg"
