"""Commands: every value lands in the field of its name, and what is missing or unknown is named."""

import numpy as np
import pytest

from carom.dsp.engine.memory.commands import COMMAND, NUMBERS, STEERS, Command, Handle, Kind, write
from carom.dsp.macros import ENGINE_SETTINGS, MACROS
from carom.dsp.numerics.constants import STANDARD_GRAVITY
from carom.dsp.runtime.engine import NOW, Engine, Stamp
from carom.dsp.schema import GESTURES, SETTINGS, STEERABLE
from tests.dsp.engine.support import HARD, RATE, SURFACE, bell, gesture, impact, steer

HERE, THERE = Handle(3, 7, 64, 128), Handle(5, 9, 0, 0)

RECORDS = {
    Kind.NEW: ("layout", "settings"),
    **dict.fromkeys(GESTURES, ("values",)),
    Kind.BUDGET: ("budget",),
}
"""The records that a command of a kind fills."""

NEEDED = {
    Kind.NEW: (
        *("first", "size", "table", "rows", "faces", "surface", "felt", "bent", "unheard", "level", "glide", "cone"),
        *("sheet", "block", "lighter"),
    ),
    "impact": ("mass", "stiffness", "dissipation", "exponent", "position"),
    "bounce": ("mass", "stiffness", "dissipation", "exponent", "position", "seed"),
    "roll": ("mass", "stiffness", "dissipation", "exponent", "position", "speed", "radius", "seed"),
    "press": ("mass", "stiffness", "dissipation", "exponent", "position", "force"),
    "spin": ("mass", "stiffness", "dissipation", "exponent", "position", "duration", "seed"),
    "slide": (
        *("mass", "stiffness", "dissipation", "exponent", "position", "speed", "force", "sweep", "radius", "patch"),
        *("static", "dynamic", "stribeck", "tangential", "along", "seed"),
    ),
    "rest": ("mass", "stiffness", "dissipation", "exponent", "position", "load"),
    "rain": ("mass", "stiffness", "dissipation", "exponent", "position", "rate", "seed"),
    "shake": ("mass", "stiffness", "dissipation", "exponent", "position", "rate", "seed"),
    "crumple": ("mass", "stiffness", "dissipation", "exponent", "position", "speed", "seed"),
    "pour": ("mass", "stiffness", "dissipation", "exponent", "position", "rate", "seed"),
    "step": ("mass", "stiffness", "dissipation", "exponent", "position", "force", "seed"),
    "shatter": ("mass", "stiffness", "dissipation", "exponent", "position", "seed"),
    Kind.BUDGET: ("steps", "modes"),
}
"""The values that have no default."""

every_record = pytest.mark.parametrize("kind", RECORDS, ids=str)

ALL = {
    *(
        "velocity",
        "by_position",
        "restitution",
        "gain",
        "sound",
        "sound_serial",
        "press",
        "delay",
        "pulses",
        "whole",
        "friction",
        "level",
        "stage",
    ),
    *("x", "y", "z", "by_x", "by_y", "by_z", "on_surface", "by_on_surface"),
}
"""Values of any gesture that it need not be given."""


def written(command, number=0):
    entry = np.zeros(1, COMMAND)[0]
    write(entry, number, command)
    return entry


def name_of(kind):
    return kind if isinstance(kind, str) else kind.name


def fields(kind):
    """Return the record of each value that a command of a kind has."""
    if kind in GESTURES:
        own = {each.name for each in GESTURES[kind].keys} | {*NEEDED[kind]} | ALL
        return {name: "values" for name in COMMAND["values"].names if name in own}
    return {name: record for record in RECORDS[kind] for name in names_of(record)}


def names_of(record):
    """Return the names of a record's values that commands give: a new object's macros are in the middle."""
    return SETTINGS if record == "settings" else COMMAND[record].names


def some(names):
    return {name: 2.0 + n for n, name in enumerate(names)}


@every_record
def test_every_value_lands_in_the_field_of_its_name(kind):
    values = some(fields(kind))
    entry = written(Command(NOW, kind, HERE, values))
    assert {name: entry[record][name] for name, record in fields(kind).items()} == values
    others = [(record, name) for record in ("values", "settings", "layout", "budget") for name in names_of(record)]
    assert not any(entry[record][name] for record, name in others if fields(kind).get(name) != record)


@pytest.mark.slow
@every_record
def test_a_value_that_is_missing_is_named(kind):
    values = some(NEEDED[kind])
    written(Command(NOW, kind, HERE, values))
    for name in NEEDED[kind]:
        with pytest.raises(ValueError, match=f"{name_of(kind)}: {name} is missing"):
            written(Command(NOW, kind, HERE, {key: value for key, value in values.items() if key != name}))


@every_record
def test_values_that_are_unknown_are_named(kind):
    with pytest.raises(ValueError, match=f"{name_of(kind)}: it has no bite, zeal"):
        written(Command(NOW, kind, HERE, {**some(NEEDED[kind]), "zeal": 1.0, "bite": 1.0}))


def test_defaults_are_the_schemas_in_the_engines_units():
    bounce = written(Command(NOW, "bounce", HERE, some(NEEDED["bounce"])))
    assert bounce["values"]["gain"] == 1.0 and bounce["values"]["gravity"] == STANDARD_GRAVITY
    zeros = ("velocity", "by_position", "irregularity", "delay", "weight")
    assert not any(bounce["values"][name] for name in zeros)
    roll = written(Command(NOW, "roll", HERE, some(NEEDED["roll"])))["values"]
    assert roll["roughness"] == 1.0 and roll["friction"] == roll["asymmetry"] == roll["travel"] == 0.0
    new = written(Command(NOW, Kind.NEW, HERE, some(NEEDED[Kind.NEW])))["settings"]
    assert new.dtype.names == tuple(ENGINE_SETTINGS) and new.dtype.names[:6] == tuple(SETTINGS)
    assert new.item() == (1.0, 0.0, 1.0, 1.0, 1.0, 0.0, *[0.5] * len(MACROS), 0.0)


def test_objects_and_numbers_are_written():
    entry = written(gesture("roll", HERE, HARD, 12.5, 4, THERE, ("mass", "speed"), speed=1.0, radius=0.1, seed=2), 8)
    assert (entry["time"], entry["has_clock"], entry["number"], entry["kind"]) == (12.5, 0, 8, Kind.GESTURE) and entry[
        "what"
    ] == NUMBERS["roll"]
    assert (entry["slot"], entry["serial"], entry["by_slot"], entry["by_serial"]) == (3, 7, 5, 9)
    assert entry["gesture"] == 4 and entry["surface"].item() == SURFACE
    assert entry["given"] == 1 << STEERABLE.index("mass") | 1 << STEERABLE.index("speed")
    entry = written(Command(NOW, Kind.SYNC, value=17.0))
    assert (entry["value"], entry["slot"], entry["serial"], entry["by_serial"]) == (17.0, 0, 0, 0)
    stamped = written(Command(Stamp(100.0, 10**15), Kind.PANIC))
    assert (stamped["time"], stamped["has_clock"], stamped["clock"]) == (100.0, 1, 10**15)


def test_an_entry_keeps_nothing_of_the_command_before_it():
    """Entries of the ring are used again and again."""
    entry = np.zeros(1, COMMAND)[0]
    full = {**some(fields("roll")), "gain": 3.0}
    write(entry, 1, Command(Stamp(1.0, 5), "roll", HERE, full, 1.0, 6, "", ("mass",), THERE, (1.0,) * 7))
    write(entry, 2, Command(NOW, "roll", None, some(NEEDED["roll"])))
    fresh = written(Command(NOW, "roll", None, some(NEEDED["roll"])), 2)
    assert entry == fresh


@pytest.mark.parametrize("name", STEERABLE)
def test_a_steered_parameter_is_written_as_its_place_among_the_steerable(name):
    entry = written(steer(5, name, 0.25))
    assert (entry["kind"], entry["gesture"], entry["value"]) == (Kind.STEER, 5, 0.25)
    assert STEERABLE[entry["parameter"]] == name


@pytest.mark.parametrize("name", SETTINGS)
def test_a_setting_is_written_as_its_place_among_the_settings(name):
    entry = written(Command(NOW, Kind.SET, HERE, value=0.25, parameter=name))
    assert tuple(SETTINGS)[entry["parameter"]] == name and entry["value"] == 0.25


def test_a_parameter_that_is_unknown_is_named():
    with pytest.raises(ValueError, match=r"STEER: parameter = 'bite': expected one of position, "):
        written(steer(5, "bite", 1.0))
    with pytest.raises(ValueError, match=r"SET: parameter = 'speed': expected one of gain, pan, "):
        written(Command(NOW, Kind.SET, HERE, value=1.0, parameter="speed"))
    with pytest.raises(ValueError, match=r"roll: given bite: expected some of position, "):
        written(Command(NOW, "roll", HERE, some(NEEDED["roll"]), given=("bite",)))


def test_the_engine_steers_as_the_schema_says():
    for number, each in enumerate(GESTURES.values()):
        assert STEERS[number].tolist() == [name in each.steerable for name in STEERABLE]


def test_of_commands_that_are_sent_together_one_that_is_wrong_stops_all():
    engine = Engine(RATE)
    handle = engine.add(bell())
    before = engine.sent
    with pytest.raises(ValueError, match="impact: mass is missing"):
        engine.send([impact(handle), Command(NOW, "impact", handle, {"position": 0.5})])
    assert engine.sent == before
    engine.process(640)
    assert engine.stats.impacts == 0
