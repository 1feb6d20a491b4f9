"""Keys that change an object's preset, as /object/new takes them."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from carom.dsp.bodies.modes import MOST_MODES
from carom.dsp.sizes import MOST_SCATTERED
from carom.presets import PresetError, Presets
from tests.presets.examples import LISTED, with_object

PRESETS = Presets()


def test_replaced_geometry_changes_the_pitch_and_nothing_else():
    bar = PRESETS.object("glockenspiel-bar")
    longer = bar.replace(length=bar.geometry["length"] * 2)
    assert longer.modes(20000).frequency[0] == pytest.approx(bar.modes(20000).frequency[0] / 4, rel=0.01)
    assert (longer.material, longer.level, longer.striker) == (bar.material, bar.level, bar.striker)
    assert bar == PRESETS.object("glockenspiel-bar") and bar.replace(level=0).geometry == bar.geometry


def test_material_level_damping_and_strike_can_be_replaced():
    bar = PRESETS.object("glockenspiel-bar")
    other = bar.replace(material="aluminium", level=-20, alpha=9.0, striker="rubber", velocity=0.5, position=0)
    assert other.material.density == 2700 and other.material.alpha == 9.0
    assert other.material.loss_factor == bar.material.loss_factor  # the object's own stays
    assert (other.level, other.striker, other.velocity, other.position) == (-20.0, "rubber", 0.5, 0.0)


def test_a_key_takes_the_place_of_those_it_excludes():
    string = PRESETS.object("piano-string").replace(fundamental=220.0)
    assert "tension" not in string.geometry
    assert string.modes(20000).frequency[0] == pytest.approx(220, rel=1e-3)
    rod = PRESETS.object("marimba-bar").replace(diameter=0.02)
    assert set(rod.geometry) == {"length", "diameter"}
    assert rod.modes(20000).frequency.size > 3
    with pytest.raises(PresetError, match="tension and fundamental: expected one of the two"):
        string.replace(tension=100.0, fundamental=100.0)


EDGES = ("free", "clamped", "supported", "free")


@pytest.mark.parametrize(
    "edges",
    [
        EDGES,
        list(EDGES),
        "free,clamped,supported,free",
        "free clamped supported free",
        " free, clamped,supported ,free,",
    ],
)
def test_a_list_may_be_a_tuple_or_a_text(edges):
    plate = PRESETS.object("glass-plate").replace(edges=edges)
    assert plate.geometry["edges"] == EDGES
    assert plate.modes(2000).frequency == pytest.approx(
        PRESETS.object("glass-plate").replace(edges=EDGES).modes(2000).frequency
    )


def test_numbers_in_a_text_are_numbers(folder):
    listed = with_object(folder, LISTED).object("mine")
    changed = listed.replace(frequency="440, 881.5 1.32e3", modal_mass=0.5, t60="1,2,3")
    assert changed.geometry["frequency"] == (440.0, 881.5, 1320.0) and changed.geometry["t60"] == (1.0, 2.0, 3.0)
    assert list(changed.modes(20000).frequency) == [440.0, 881.5, 1320.0]
    assert listed.replace(frequency="440", modal_mass="0.5", t60="2").geometry["t60"] == 2.0


@pytest.mark.parametrize(
    ("edges", "message"),
    [
        (["free"] * 3, "edges = ['free', 'free', 'free']: expected a list of 4, each one of free, clamped, supported"),
        (
            ("free",) * 2,
            "edges = ['free', 'free']: expected a list of 4, each one of free, clamped, supported",
        ),
        ("free", "edges = ['free']: expected a list of 4, each one of free, clamped, supported"),
        ("", "edges = []: expected a list of 4, each one of free, clamped, supported"),
        (3, "edges = 3: expected a list of 4, each one of free, clamped, supported"),
        ("free,free,free,glued", "edges: item 4 = 'glued': expected one of free, clamped, supported"),
        (["free", 1, "free", "free"], "edges: item 2 = 1: expected one of free, clamped, supported"),
        (["free", ["free"], "free", "free"], "edges: item 2 = ['free']: expected one of free, clamped, supported"),
    ],
)
def test_an_error_about_a_list_names_its_item_and_repeats_nothing(edges, message):
    with pytest.raises(PresetError) as caught:
        PRESETS.object("glass-plate").replace(edges=edges)
    assert str(caught.value) == message


@pytest.mark.parametrize("frequency", [(440.0,) * 1025, "440," * 1025, (440.0, math.nan), "440,nan", (440.0, True), ()])
def test_lists_of_numbers_have_limits(folder, frequency):
    with pytest.raises(
        PresetError, match=r"^frequency.*: expected a (list of 1 to 1024, each a )?number from 1 to 20000 Hz$"
    ) as caught:
        with_object(folder, LISTED).object("mine").replace(frequency=frequency)
    assert len(str(caught.value)) < 200


def test_the_keys_are_those_that_can_be_replaced(folder):
    bar, listed = PRESETS.object("marimba-bar"), with_object(folder, LISTED).object("mine")
    assert bar.keys[:2] == ("length", "width") and {"alpha", "striker", "level", "material"} < set(bar.keys)
    assert len(set(bar.keys)) == len(bar.keys) and "alpha" not in listed.keys
    for preset in (bar, listed):
        with pytest.raises(PresetError) as caught:
            preset.replace(colour=1)
        assert str(caught.value) == f"colour = 1: expected one of {', '.join(preset.keys)}"


def test_whole_numbers_may_come_as_floats():
    assert PRESETS.object("wine-glass").replace(rows=2.0).geometry["rows"] == 2
    with pytest.raises(PresetError, match=r"^rows = 1.5: expected a whole number from 1 to 3$"):
        PRESETS.object("wine-glass").replace(rows=1.5)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"lenght": 1}, "lenght = 1: did you mean length?"),
        ({"length": 1000.0}, "length = 1000.0: expected a number from 0.001 to 20 m"),
        ({"length": math.nan}, "length = nan: expected"),
        ({"length": None}, "length = None: expected"),
        ({"length": b"\0"}, "length = b'\\x00': expected"),
        ({"material": 3}, "material = 3: expected a name"),
        ({"material": "stell"}, "material = 'stell': did you mean steel?"),
        ({"level": 1e9}, "level = 1000000000.0: expected a number from -120 to 120 dB"),
        ({"undercut": True}, "undercut = True: expected a number from 0 to 0.95"),
        ({"ends": "glued"}, "ends = 'glued': expected one of free, cantilever"),
        ({"shape": "disc"}, "shape = 'disc': expected one of"),
        ({"size": 900}, "size = 900: length = "),
        ({"size": "tiny"}, "size = 'tiny': expected a number from 0.001 to 1000 times"),
    ],
)
def test_wrong_changes_name_the_key_and_no_file(changes, message):
    with pytest.raises(PresetError) as caught:
        PRESETS.object("marimba-bar").replace(**changes)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    ("name", "size", "message"),
    [
        ("ceramic-bowl", 0.012, "size = 0.012: radius = 0.00084: expected a number from 0.001 to 20 m"),
        ("kalimba-tine", 0.0072, "size = 0.0072: length = 0.000358056: expected a number from 0.001 to 20 m"),
        ("drinks-can", 77.7, "size = 77.7: [cavity] volume = 166.53: expected a number from 1e-08 to 10 m3"),
        ("xylophone-bar", 900.0000001, "size = 900.0000001: length = 328.14: expected a number from 0.001 to 20 m"),
    ],
)
def test_a_length_that_follows_from_a_size_is_named_by_six_digits(name, size, message):
    with pytest.raises(PresetError) as caught:
        PRESETS.object(name).replace(size=size)
    assert str(caught.value) == message


@pytest.mark.parametrize(("name", "fixed"), [("mug", "a table's"), ("church-bell", "listed")])
def test_a_size_is_refused_where_modes_are_given(name, fixed):
    with pytest.raises(PresetError, match=f"size = 2: expected none, as the modes of {name} are {fixed}"):
        PRESETS.object(name).replace(size=2)


@pytest.mark.slow
@given(
    st.sampled_from([name for name in PRESETS.names("objects")]),
    st.dictionaries(
        st.sampled_from(["length", "width", "thickness", "radius", "height", "diameter", "wall", "undercut", "split"]),
        st.floats() | st.floats(1e-5, 0.1) | st.floats(0.01, 2),
        max_size=3,
    ),
)
def test_any_numbers_give_a_body_or_an_error_that_says_why(name, changes):
    try:
        modes = PRESETS.object(name).replace(**changes).modes(4000)
    except PresetError as error:
        assert str(error)
    else:
        assert modes.frequency.size <= (MOST_SCATTERED if modes.sheet else MOST_MODES)
        for array in (modes.frequency, modes.decay, modes.strike, modes.pressure):
            assert np.all(np.isfinite(array))
        assert math.isfinite(modes.mass) and modes.mass > 0
