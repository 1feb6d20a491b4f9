"""Presets: all built-in ones make sound bodies; whatever is wrong in a file or a change is named."""

import inspect
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from carom.dsp.bodies.material import hertz
from carom.presets.library import BUILT_IN, SHAPES, PresetError, Presets

PRESETS = Presets()

BAR = """
description = "a bar"
source = "none"
shape = "bar"
material = "steel"
level = -3
[geometry]
length = 0.3
width = 0.03
thickness = 0.01
[strike]
striker = "wood"
velocity = 1
position = 0.5
"""


@pytest.fixture
def folder(tmp_path):
    for kind in ("objects", "strikers", "materials"):
        (tmp_path / kind).mkdir()
    return tmp_path


def with_object(folder, text, name="mine"):
    (folder / "objects" / f"{name}.toml").write_text(text, encoding="utf-8")
    return Presets([folder])


# the built-in presets


@pytest.mark.parametrize("name", PRESETS.names("objects"))
def test_every_object_is_a_body_that_can_be_struck(name):
    preset = PRESETS.object(name)
    modes = preset.modes(20000)
    assert 3 <= modes.frequency.size <= 1024
    assert np.all(np.diff(modes.frequency) >= 0) and modes.frequency[-1] <= 20000
    assert 1e-3 < modes.mass < 1e4
    t60 = math.log(1000) / modes.decay
    assert np.all((t60 > 1e-4) & (t60 < 60))
    for array in (modes.strike, modes.pickup):
        assert np.all(np.isfinite(array)) and np.abs(array).max() > 0
    # physical modal masses: a good part of the body's, but for the sharp peak a disc's modes have at its centre
    assert 0.005 < 1 / np.max(modes.strike**2) / modes.mass < 2
    contact = PRESETS.striker(preset.striker).contact(preset.material)
    assert all(math.isfinite(value) and value > 0 for value in contact)
    assert preset.description and preset.source


def test_the_library_covers_all_shapes_and_many_materials():
    objects = [PRESETS.object(name) for name in PRESETS.names("objects")]
    assert {preset.shape for preset in objects} == set(SHAPES)
    assert len({preset.material.name for preset in objects}) >= 8
    assert len(objects) >= 18
    assert len(PRESETS.names("materials")) >= 10
    assert len(PRESETS.names("strikers")) >= 8


@pytest.mark.parametrize(
    ("name", "pitch", "ratios"),
    [
        ("marimba-bar", 261.63, [1, 4]),
        ("xylophone-bar", 523.25, [1, 3, 6]),
        ("vibraphone-bar", 174.61, [1, 4]),
        ("glockenspiel-bar", 2093.0, [1, 2.7]),
        ("tuning-fork", 440.0, [1, 6.2]),
        ("piano-string", 261.63, [1, 2, 3]),
        ("bass-string", 65.41, [1, 2, 3]),
        ("church-bell", 220.0, [1]),
    ],
)
def test_tuned_objects_are_in_tune(name, pitch, ratios):
    frequency = PRESETS.object(name).modes(20000).frequency
    assert 1200 * math.log2(frequency[0] / pitch) == pytest.approx(0, abs=6)  # cents
    assert frequency[: len(ratios)] / frequency[0] == pytest.approx(ratios, rel=0.01)


@pytest.mark.parametrize("name", PRESETS.names("strikers"))
def test_every_striker_meets_every_material(name):
    striker = PRESETS.striker(name)
    for material in [None, *map(PRESETS.material, PRESETS.names("materials"))]:
        mass, stiffness, dissipation, exponent = striker.contact(material)
        assert 1e-4 < mass < 100 and stiffness > 0 and 0 <= dissipation <= 10 and 1 <= exponent <= 5


@pytest.mark.parametrize("name", PRESETS.names("materials"))
def test_every_material_is_a_solid(name):
    material = PRESETS.material(name)
    assert 400 < material.density < 12000
    speed = math.sqrt(material.youngs_modulus / material.density)
    assert 50 < speed < 6000  # m/s
    assert 1e-4 < math.log(1000) / material.decay(1000.0) < 30


@pytest.mark.parametrize("kind", ["objects", "strikers", "materials"])
def test_files_are_lowercase_names_with_sources(kind):
    for path in (BUILT_IN / kind).iterdir():
        assert path.suffix == ".toml" and path.stem == path.stem.lower()
        assert "source = " in path.read_text(encoding="utf-8")


def test_the_schema_is_the_functions_signature():
    for name, shape in SHAPES.items():
        arguments = set(inspect.signature(shape.make).parameters) - {"material", "top", "pickups"}
        assert set(shape.fields) == arguments, name


# strikers


def test_a_ball_meets_a_material_by_hertz():
    steel, glass = PRESETS.material("steel"), PRESETS.material("glass")
    mass, stiffness, _, exponent = PRESETS.striker("steel").contact(glass)
    assert mass == pytest.approx(7850 * 4 / 3 * math.pi * 0.005**3)
    assert stiffness == pytest.approx(hertz(steel, 0.005, glass))
    assert exponent == 1.5
    assert PRESETS.striker("steel").contact(None)[1] > stiffness


def test_a_ball_may_be_lighter_than_a_solid_one(folder):
    ball = 'description = "d"\nsource = "s"\nmaterial = "steel"\nradius = 0.02\ndissipation = 0.1\nmass = 0.002'
    (folder / "strikers" / "hollow.toml").write_text(ball, encoding="utf-8")
    assert Presets([folder]).striker("hollow").mass == 0.002


def test_a_given_law_is_taken_as_it_is():
    assert PRESETS.striker("felt-hammer").contact(None) == (2.97e-3, 4.5e9, 0.15, 2.5)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("mass = 1\nstiffness = 1e6\ndissipation = 0", "exponent is missing"),
        ('material = "steel"\ndissipation = 0', "radius is missing"),
        (
            'material = "steel"\nradius = 0.01\ndissipation = 0\nstiffness = 1e6',
            "stiffness = 1000000.0: expected one of",
        ),
        (
            'material = "stele"\nradius = 0.01\ndissipation = 0',
            "material = 'stele': no material 'stele': did you mean steel",
        ),
        (
            "mass = 0\nstiffness = 1e6\ndissipation = 0\nexponent = 1",
            "mass = 0: expected a number from 1e-06 to 1000 kg",
        ),
    ],
)
def test_wrong_strikers_are_named(folder, text, message):
    (folder / "strikers" / "bad.toml").write_text(f'description = "d"\nsource = "s"\n{text}', encoding="utf-8")
    with pytest.raises(PresetError) as caught:
        Presets([folder]).striker("bad")
    assert message in str(caught.value) and "bad.toml: " in str(caught.value)


# surfaces

GROUND = """
description = "d"
source = "s"
roughness = 1e-5
correlation = 0.01
slope = 2
dissipation = 0.5
"""


def test_a_surface_is_its_profile(folder):
    (folder / "surfaces").mkdir()
    (folder / "surfaces" / "plain.toml").write_text(GROUND, encoding="utf-8")
    (folder / "surfaces" / "waves.toml").write_text(GROUND + "ripple = 1e-4\nwavelength = 0.1\n", encoding="utf-8")
    presets = Presets([folder])
    assert (
        presets.surface("plain").profile == (1e-5, 0.01, 2.0, 0.0, 1.0) and presets.surface("plain").dissipation == 0.5
    )
    assert presets.surface("waves").profile == (1e-5, 0.01, 2.0, 1e-4, 0.1)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("dissipation = 0.5", "", "dissipation is missing"),
        ("slope = 2", "slope = 1", "slope = 1: expected a number from 1.01 to 5"),
        ("slope = 2", "slop = 2", "slop = 2: expected one of description"),
        ("correlation = 0.01", "", "correlation is missing"),
    ],
)
def test_wrong_surfaces_are_named(folder, old, new, message):
    (folder / "surfaces").mkdir()
    (folder / "surfaces" / "bad.toml").write_text(GROUND.replace(old, new), encoding="utf-8")
    with pytest.raises(PresetError, match=message):
        Presets([folder]).surface("bad")


# objects from a user's folder


def test_a_users_preset_comes_before_the_built_in_one(folder):
    presets = with_object(folder, BAR, "gong")
    assert presets.object("gong").shape == "bar"
    assert presets.object("gong").level == -3.0
    assert PRESETS.object("gong").shape == "disc"
    assert presets.object("pot-lid") == PRESETS.object("pot-lid")
    assert presets.names("objects") == PRESETS.names("objects")
    assert "mine" in with_object(folder, BAR).names("objects")


def test_the_first_folder_comes_first(folder, tmp_path_factory):
    with_object(folder, BAR, "gong")
    other = tmp_path_factory.mktemp("other")
    (other / "objects").mkdir()
    (other / "objects" / "gong.toml").write_text(BAR.replace("level = -3", "level = -9"), encoding="utf-8")
    assert Presets([folder, other]).object("gong").level == -3.0
    assert Presets([other, folder]).object("gong").level == -9.0


def test_an_objects_own_damping_replaces_its_materials(folder):
    plain = with_object(folder, BAR).object("mine")
    damped = with_object(folder, BAR + "[damping]\nalpha = 40\n").object("mine")
    difference = damped.modes(5000).decay - plain.modes(5000).decay
    assert difference == pytest.approx((40 - plain.material.alpha) / 2)
    assert damped.material.beta == plain.material.beta


def test_pickups_are_where_the_preset_puts_them(folder):
    ends = with_object(folder, BAR + "[pickup]\nleft = 0\nright = 1\n").object("mine").modes(5000)
    assert ends.pickup == pytest.approx(ends.strike[[0, -1]])
    other = with_object(folder, BAR + "[pickup]\nleft = 1\nright = 0\n").object("mine").modes(5000)
    assert other.pickup == pytest.approx(ends.strike[[-1, 0]])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("length = 0.3", "lenght = 0.3", "[geometry] lenght = 0.3: expected one of length, width"),
        ("length = 0.3", "", "[geometry] length is missing: expected a number from 0.001 to 20 m"),
        ("length = 0.3", 'length = "long"', "[geometry] length = 'long': expected a number from 0.001 to 20 m"),
        ("length = 0.3", "length = true", "[geometry] length = True: expected a number"),
        ("length = 0.3", "length = nan", "[geometry] length = nan: expected a number"),
        ("length = 0.3", "length = inf", "[geometry] length = inf: expected a number"),
        ("length = 0.3", "length = -0.3", "[geometry] length = -0.3: expected a number"),
        ("length = 0.3", f"length = 1{'0' * 400}", "expected a number from 0.001 to 20 m"),
        ("thickness = 0.01", "diameter = 0.01", "[geometry] width and diameter: expected one of the two"),
        ('shape = "bar"', 'shape = "cube"', "shape = 'cube': expected one of bar, string, plate"),
        ('shape = "bar"', "", "shape is missing: expected one of bar"),
        ('material = "steel"', "", "material is missing"),
        ('material = "steel"', 'material = "../steel"', "material = '../steel': expected a name of up to 64 letters"),
        ('material = "steel"', 'material = "qwxyz"', "no material 'qwxyz': expected one of"),
        ('source = "none"', "", "source is missing"),
        ('striker = "wood"', 'striker = "wod"', "[strike] striker = 'wod': no striker 'wod': did you mean wood"),
        ("velocity = 1", "velocity = 0", "[strike] velocity = 0: expected a number from 0.001 to 100 m/s"),
        ("position = 0.5", "position = 1.5", "[strike] position = 1.5: expected a number from 0 to 1"),
        ("[geometry]", "[geomtry]", "geomtry = "),
        ("[strike]", "[pickup]\nleft = 0.1\n[strike]", "[pickup] left: expected left and right"),
        ("[strike]", "[damping]\nalpha = -1\n[strike]", "[damping] alpha = -1: expected a number from 0"),
        ("level = -3", "strike = 3", "strike = 3: expected a section of keys"),
        ("[geometry]", "[geometry", "not TOML"),
    ],
)
def test_wrong_objects_are_named(folder, old, new, message):
    assert old in BAR
    text = BAR.replace(old, new, 1) if old != "level = -3" else "strike = 3\n" + BAR.split("[strike]")[0]
    with pytest.raises(PresetError) as caught:
        with_object(folder, text).object("mine")
    assert message in str(caught.value)
    assert str(caught.value).startswith(f"{folder / 'objects' / 'mine.toml'}: ")


def test_a_geometry_that_contradicts_itself_is_named_when_modes_are_made(folder):
    text = BAR.replace("width = 0.03\nthickness = 0.01", "diameter = 0.02\nwall = 0.015")
    with pytest.raises(PresetError, match=r"mine.toml: \[geometry\] wall = 0.015: expected at most half"):
        with_object(folder, text).object("mine").modes(20000)
    with pytest.raises(PresetError, match=r"mine.toml: \[geometry\] no mode lies between 1 Hz and 20 Hz"):
        with_object(folder, BAR).object("mine").modes(20)


def test_listed_objects_need_no_material_and_take_no_damping(folder):
    listed = """
description = "two partials"
source = "none"
shape = "listed"
level = 0
[geometry]
frequency = [440, 881]
t60 = 2
modal_mass = [0.5, 0.7]
mass = 1
[strike]
striker = "wood"
velocity = 1
position = 0
"""
    preset = with_object(folder, listed).object("mine")
    assert preset.material is None
    assert list(preset.modes(20000).frequency) == [440, 881]
    for wrong, message in [
        (listed + "[damping]\nalpha = 1\n", "alpha = 1: expected one of no key"),
        (listed.replace("[440, 881]", "[]"), "frequency = []: expected a list, each a number from 1 to 20000 Hz"),
        (listed.replace("[440, 881]", "[440, 0]"), "frequency = [440, 0]: expected a list"),
        (listed.replace("t60 = 2", 't60 = "2"'), "t60 = '2': expected a number from 0.001 to 200 s, or a list"),
    ]:
        with pytest.raises(PresetError) as caught:
            with_object(folder, wrong).object("mine")
        assert message in str(caught.value)
    with pytest.raises(PresetError, match=r"3 of t60.*expected 2"):
        with_object(folder, listed.replace("t60 = 2", "t60 = [1, 2, 3]")).object("mine").modes(20000)


def test_a_file_that_is_not_utf_8_is_named(folder):
    (folder / "objects" / "mine.toml").write_bytes(b'description = "\xff"')
    with pytest.raises(PresetError, match=r"mine\.toml: not TOML"):
        Presets([folder]).object("mine")


def test_deep_nesting_is_an_error_not_a_crash(folder):
    with pytest.raises(PresetError):
        with_object(folder, "x = " + "[" * 100000).object("mine")


@pytest.mark.parametrize("name", ["../objects/gong", "gong.toml", "", "a b", "/etc/passwd", "gong\n", "gong\0", "göng"])
def test_names_cannot_leave_the_folders(name):
    for look_up in (PRESETS.object, PRESETS.striker, PRESETS.material):
        with pytest.raises(PresetError, match="expected a name of up to 64 letters, digits, _ and -"):
            look_up(name)


def test_unknown_names_come_with_close_ones():
    with pytest.raises(PresetError, match="no object 'marimba': did you mean marimba-bar"):
        PRESETS.object("marimba")
    with pytest.raises(PresetError, match=r"no striker 'zzzzzz': expected one of .*wood"):
        PRESETS.striker("zzzzzz")


def test_a_missing_folder_and_an_unknown_kind_are_named(tmp_path):
    with pytest.raises(PresetError, match="nowhere: expected a folder"):
        Presets([tmp_path / "nowhere"])
    with pytest.raises(ValueError, match="kind = 'sounds': expected one of materials, strikers, surfaces, objects"):
        PRESETS.names("sounds")


# changes


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


@pytest.mark.parametrize("edges", [["free"] * 3, ["free"] * 5, ["free", "free", "free", "glued"], "free"])
def test_a_row_has_all_its_values_and_each_fits(edges):
    with pytest.raises(PresetError, match=r"^edges = .*: expected a list of one of free, clamped, supported, one of"):
        PRESETS.object("glass-plate").replace(edges=edges)


def test_whole_numbers_may_come_as_floats():
    assert PRESETS.object("wine-glass").replace(rows=2.0).geometry["rows"] == 2
    with pytest.raises(PresetError, match=r"^rows = 1.5: expected a whole number from 1 to 3$"):
        PRESETS.object("wine-glass").replace(rows=1.5)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"lenght": 1}, "lenght = 1: expected one of length, width"),
        ({"length": 1000.0}, "length = 1000.0: expected a number from 0.001 to 20 m"),
        ({"length": math.nan}, "length = nan: expected"),
        ({"length": None}, "length = None: expected"),
        ({"length": b"\0"}, "length = b'\\x00': expected"),
        ({"material": 3}, "material = 3: expected a name"),
        ({"material": "stell"}, "material = 'stell': no material 'stell': did you mean steel"),
        ({"level": 1e9}, "level = 1000000000.0: expected a number from -120 to 120 dB"),
        ({"undercut": True}, "undercut = True: expected a number from 0 to 0.95"),
        ({"ends": "glued"}, "ends = 'glued': expected one of free, cantilever"),
        ({"shape": "disc"}, "shape = 'disc': expected one of"),
    ],
)
def test_wrong_changes_name_the_key_and_no_file(changes, message):
    with pytest.raises(PresetError) as caught:
        PRESETS.object("marimba-bar").replace(**changes)
    assert str(caught.value).startswith(message)


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
        assert modes.frequency.size <= 1024
        for array in (modes.frequency, modes.decay, modes.strike, modes.pickup):
            assert np.all(np.isfinite(array))
        assert math.isfinite(modes.mass) and modes.mass > 0
