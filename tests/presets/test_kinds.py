"""Strikers, surfaces and objects from files; an error names the file, the key and its value."""

import math

import pytest

from carom.dsp.bodies.material import contact_between, hertz
from carom.presets import PresetError, Presets
from tests.presets.examples import BAR, GROUND, LISTED, with_object

PRESETS = Presets()


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
            "mass = 0: expected a number from 1e-09 to 1e+06 kg",
        ),
        (
            "mass = 1\nstiffness = 1e6\ndissipation = 0\nexponent = 5",
            "exponent = 5: expected a number from 1 to 4",
        ),
    ],
)
def test_wrong_strikers_are_named(folder, text, message):
    (folder / "strikers" / "bad.toml").write_text(f'description = "d"\nsource = "s"\n{text}', encoding="utf-8")
    with pytest.raises(PresetError) as caught:
        Presets([folder]).striker("bad")
    assert message in str(caught.value) and "bad.toml: " in str(caught.value)


def test_a_surface_is_its_profile(folder):
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
    (folder / "surfaces" / "bad.toml").write_text(GROUND.replace(old, new), encoding="utf-8")
    with pytest.raises(PresetError, match=message):
        Presets([folder]).surface("bad")


def test_objects_strike_each_other_by_their_materials():
    board = PRESETS.object("wood-board")
    laws = {name: board.struck_by(board.replace(material=name)) for name in ("rubber", "wood", "glass", "steel")}
    stiffness = [law[0] for law in laws.values()]
    assert stiffness == sorted(stiffness) and stiffness[1] > 100 * stiffness[0]
    assert laws["rubber"][1] > laws["glass"][1] and all(law[2] == 1.5 for law in laws.values())
    assert laws["steel"] == contact_between(PRESETS.material("steel"), board.material)
    blunt = board.struck_by(board, radius=0.04)
    assert blunt[0] == pytest.approx(2 * board.struck_by(board)[0]) and blunt[1:] == board.struck_by(board)[1:]


def test_an_object_without_a_material_meets_others_as_steel(folder):
    listed, board = with_object(folder, LISTED).object("mine"), PRESETS.object("wood-board")
    steel = board.replace(material="steel")
    assert board.struck_by(listed) == board.struck_by(steel)
    assert listed.struck_by(board) == pytest.approx(steel.struck_by(board))


def test_a_material_without_a_dissipation_has_a_middling_one(folder):
    text = 'source = "s"\ndensity = 1000\nyoungs_modulus = 1e9\npoisson_ratio = 0.3\nalpha = 1\nbeta = 0\n'
    for name, more, dissipation in (("plain", "", 0.2), ("dull", "dissipation = 2\n", 2.0)):
        (folder / "materials" / f"{name}.toml").write_text(text + more, encoding="utf-8")
        assert Presets([folder]).material(name).dissipation == dissipation
    (folder / "materials" / "bad.toml").write_text(text + "dissipation = -1\n", encoding="utf-8")
    with pytest.raises(PresetError, match=r"dissipation = -1: expected a number from 0 to 1e\+06 s/m"):
        Presets([folder]).material("bad")


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
    preset = with_object(folder, LISTED).object("mine")
    assert preset.material is None
    assert list(preset.modes(20000).frequency) == [440, 881]
    for wrong, message in [
        (LISTED + "[damping]\nalpha = 1\n", "alpha = 1: expected no key"),
        (
            LISTED.replace("[440, 881]", "[]"),
            "frequency = []: expected a list of 1 to 1024, each a number from 1 to 20000 Hz",
        ),
        (LISTED.replace("[440, 881]", "[440, 0]"), "frequency: item 2 = 0: expected a number from 1 to 20000 Hz"),
        (LISTED.replace("t60 = 2", 't60 = "2"'), "t60 = '2': expected a number from 0.001 to 200 s, or a list"),
    ]:
        with pytest.raises(PresetError) as caught:
            with_object(folder, wrong).object("mine")
        assert message in str(caught.value)
    with pytest.raises(PresetError, match=r"3 of t60.*expected 2"):
        with_object(folder, LISTED.replace("t60 = 2", "t60 = [1, 2, 3]")).object("mine").modes(20000)
