"""Strikers, surfaces and objects from files; an error names the file, the key and its value."""

import math

import numpy as np
import pytest

from carom.dsp import bodies
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
    assert PRESETS.striker("felt-hammer").contact(None) == (2.76e-3, 2.88e15, 3.55, 4.3)


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
            "material = 'stele': did you mean steel",
        ),
        (
            "mass = 0\nstiffness = 1e6\ndissipation = 0\nexponent = 1",
            "mass = 0: expected a number from 1e-09 to 1e+06 kg",
        ),
        (
            "mass = 1\nstiffness = 1e6\ndissipation = 0\nexponent = 7",
            "exponent = 7: expected a number from 1 to 6",
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
    plain = presets.surface("plain")
    assert plain.profile == (1e-5, 0.01, 2.0, 0.0, 1.0, 0.0, 0.05) and plain.dissipation == 0.5
    assert presets.surface("waves").profile == (1e-5, 0.01, 2.0, 1e-4, 0.1, 0.0, 0.05)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("dissipation = 0.5", "", "dissipation is missing"),
        ("slope = 2", "slope = 1", "slope = 1: expected a number from 1.01 to 5"),
        ("slope = 2", "slop = 2", "slop = 2: did you mean slope?"),
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


def test_losses_that_were_measured_hold_what_is_radiated(folder):
    own = with_object(folder, BAR).object("mine")
    whole = with_object(folder, BAR + '[damping]\nlosses = "measured"\n').object("mine")
    one, other = own.modes(5000), whole.modes(5000)
    assert other.decay == pytest.approx(whole.material.decay(other.frequency))
    radiated = 2 * math.pi * (one.pressure**2).mean(axis=0) / (1.2 * 343)  # sigma = R/2 = 2 pi G^2/(rho c)
    assert one.decay - other.decay == pytest.approx(radiated) and np.all(radiated > 0)
    assert other.pressure == pytest.approx(one.pressure * np.minimum(1, np.sqrt(other.decay / radiated)))
    little = with_object(folder, BAR + '[damping]\nlosses = "measured"\nalpha = 0\nloss_factor = 1e-8\n').object("mine")
    assert (little.modes(5000).pressure ** 2).mean(axis=0) == pytest.approx(
        little.modes(5000).decay * 1.2 * 343 / (2 * math.pi)
    )  # no more than is lost


def test_the_stereo_width_keeps_the_power(folder):
    point, wide = (
        with_object(folder, f"stereo_width = {width}\n" + BAR).object("mine").modes(20000) for width in (0, 1)
    )
    assert point.pressure[0] == pytest.approx(point.pressure[1], rel=1e-15)
    assert (wide.pressure**2).sum(axis=0) == pytest.approx((point.pressure**2).sum(axis=0))
    assert np.array_equal(np.sign(wide.pressure), np.sign(point.pressure))
    sides = np.abs(wide.pressure[1] / wide.pressure[0])
    assert sides.min() < 0.5 and sides.max() > 2
    usual = with_object(folder, BAR).object("mine").modes(20000)
    assert 0.5 < np.abs(np.log(usual.pressure[1] / usual.pressure[0])).max() < np.abs(np.log(sides)).max()


MORE = """
[partials]
ratio = [1.5, 6]
t60 = 0.5
level = [-6, -20]
[noise]
edges = [2e3, 4e3]
t60 = 0.1
level = -20
modes = 30
[cavity]
volume = 2e-4
area = 6e-4
neck = 0.01
level = -3
"""


def test_an_object_has_the_modes_that_its_preset_adds(folder):
    plain, more = (with_object(folder, BAR + text).object("mine") for text in ("", MORE))
    assert more.modes(20000).frequency.size == plain.modes(20000).frequency.size + 2 + 30 + 1
    assert more.modes(20000) is with_object(folder, BAR + MORE).object("mine").modes(20000)
    lowest = plain.modes(20000).frequency[0]
    assert {1.5 * lowest, 6 * lowest} <= set(more.modes(20000).frequency)


@pytest.mark.slow
def test_a_change_of_material_changes_the_losses_of_what_is_added(folder):
    steel = with_object(folder, BAR + MORE).object("mine")
    assert decay_of_the_second_partial(steel) == pytest.approx(math.log(1000) / 0.5)
    for wooden in (steel.replace(material="wood"), steel.replace(length=0.2).replace(material="wood", velocity=2)):
        inside = wooden.material.decay(6 * lowest_of(wooden))
        assert inside < decay_of_the_second_partial(wooden) < inside + math.log(1000) / 0.5
        back = wooden.replace(material="steel")
        assert decay_of_the_second_partial(back) == pytest.approx(math.log(1000) / 0.5)


def lowest_of(preset):
    return bodies.bar(preset.material, top=20000, **preset.geometry).frequency[0]


def decay_of_the_second_partial(preset):
    modes = preset.modes(20000)
    (decay,) = modes.decay[np.isclose(modes.frequency, 6 * lowest_of(preset), rtol=1e-12)]
    return decay


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("length = 0.3", "lenght = 0.3", "[geometry] lenght = 0.3: did you mean length?"),
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
        ('material = "steel"', "", "material is missing: expected the name of a material"),
        ('striker = "wood"', "", "[strike] striker is missing: expected the name of a striker"),
        ('material = "steel"', 'material = "../steel"', "material = '../steel': expected a name of up to 64 letters"),
        ('material = "steel"', 'material = "qwxyz"', "material = 'qwxyz': expected one of"),
        ('source = "none"', "", "source is missing"),
        ('striker = "wood"', 'striker = "wod"', "[strike] striker = 'wod': did you mean wood"),
        ("velocity = 1", "velocity = 0", "[strike] velocity = 0: expected a number from 0.001 to 100 m/s"),
        ("position = 0.5", "position = 1.5", "[strike] position = 1.5: expected a number from 0 to 1"),
        ("[geometry]", "[geomtry]", "geomtry = "),
        ("level = -3", "level = -3\nstereo_width = 2", "stereo_width = 2: expected a number from 0 to 1"),
        ("[strike]", '[damping]\nlosses = "all"\n[strike]', "[damping] losses = 'all': expected one of material, mea"),
        ("[strike]", "[damping]\nalpha = -1\n[strike]", "[damping] alpha = -1: expected a number from 0"),
        ("level = -3", "strike = 3", "strike = 3: expected a section of keys"),
        (
            "[strike]",
            "[partials]\nratio = [2]\nt60 = 1\n[strike]",
            "[partials] level is missing: expected a number from",
        ),
        (
            "[strike]",
            "[partials]\nt60 = 1\nlevel = -9\n[strike]",
            "[partials] frequency and ratio: expected one of the",
        ),
        (
            "[strike]",
            "[noise]\nedges = [900, 500]\nt60 = 1\nlevel = -9\n[strike]",
            "[noise] edges = [900.0, 500.0]: expected two or more, in ascending order",
        ),
        (
            "[strike]",
            "[noise]\nedges = [500, 900]\nt60 = 1\nlevel = -9\nmodes = 2.5\n[strike]",
            "[noise] modes = 2.5: expected a whole number from 1 to 512",
        ),
        (
            "[strike]",
            "[cavity]\nvolume = 1e-3\n[strike]",
            "[cavity] area is missing: expected a number from 1e-08 to 10",
        ),
        ("[geometry]", "[geometry", "not TOML"),
    ],
)
def test_wrong_objects_are_named(folder, old, new, message):
    assert old in BAR
    text = (
        BAR.replace(old, new, 1)
        if (old, new) != ("level = -3", "strike = 3")
        else "strike = 3\n" + BAR.split("[strike]")[0]
    )
    with pytest.raises(PresetError) as caught:
        with_object(folder, text).object("mine")
    assert message in str(caught.value)
    assert str(caught.value).startswith(f"{folder / 'objects' / 'mine.toml'}: ")


def test_a_geometry_that_contradicts_itself_is_named_when_modes_are_made(folder):
    text = BAR.replace("width = 0.03\nthickness = 0.01", "diameter = 0.02\nwall = 0.015")
    with pytest.raises(PresetError, match=r"mine.toml: \[geometry\] wall = 0.015: expected at most half"):
        with_object(folder, text).object("mine").modes(20000)
    with pytest.raises(PresetError, match=r"mine.toml: \[geometry\] no mode lies between 1 Hz and 20 Hz: expected"):
        with_object(folder, BAR.replace("width", 'ends = "cantilever"\nwidth', 1)).object("mine").modes(20)


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


def test_a_preset_in_a_size_that_does_not_ring_is_named():
    glass = Presets().object("wine-glass").replace(size=0.048)
    with pytest.raises(PresetError, match=r"^wine-glass: no mode lies between 1 Hz and 10000 Hz: expected a body that"):
        glass.modes(10_000.0)
