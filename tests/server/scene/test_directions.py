"""Blows and slides in a direction, at a point of a surface: a bar's modes against their closed forms."""

import math

import numpy as np
import pytest

from carom.dsp.mesh import forms
from carom.dsp.mesh.model import Wanted
from carom.dsp.runtime.engine import Engine
from carom.presets import Presets
from carom.presets.made import preset_text
from carom.presets.meshes import table_bytes_of
from carom.presets.tables import table_of
from carom.server.scene.session import Session
from carom.server.telling import mode_levels
from tests.server.scene.support import refusal, say

pytestmark = pytest.mark.slow  # to compute the mesh takes 4 s

LENGTH, WIDTH, THICKNESS = 0.3, 0.02, 0.015
END, ASIDE, TOP = LENGTH / 2, WIDTH / 4, THICKNESS / 2
"""Half its length; points lie so far off the middle line, and so high."""
FREE = 4.730041  # times the length: the wave number of a free bar's lowest mode


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """Presets with a bar of steel that is a mesh."""
    folder = tmp_path_factory.mktemp("bar")
    body = forms.box(LENGTH, WIDTH, THICKNESS)
    data = table_bytes_of(body.points, body.faces, Presets().material("steel"), Wanted(modes=20))
    (folder / "objects").mkdir()
    (folder / "objects" / "bar.npz").write_bytes(data)
    text = preset_text("bar", "a box", "steel", table_of(data, "bar"))
    (folder / "objects" / "bar.toml").write_text(text)
    return Presets(folder)


@pytest.fixture
def session(library):
    return Session(Engine(48_000), library)


def levels(session, *blow):
    """Return frequencies (Hz), and amplitudes after a light and slow blow, of the modes that are felt and heard."""
    say(session, "/object/new", "bar", "bar")
    say(session, "/object/bar/impact", 0.05, *blow, "striker", "steel", "mass", 1e-4)
    engine = session.engine
    engine.process(2_000)
    obj = engine.objects[session.objects["bar"].handle.slot]
    count, first = int(obj["felt"]), int(obj["first"])
    frequency = engine.state["bank"][0]["frequency"][first : first + count].copy()
    found = np.sqrt(mode_levels(engine, session.objects["bar"].handle.slot)[:count])
    say(session, "/object/bar/free", 1)
    engine.process(8_000)
    return frequency, found


def of_mode(session, hertz, *blow):
    frequency, found = levels(session, *blow)
    nearest = np.abs(frequency - hertz).argmin()
    assert frequency[nearest] == pytest.approx(hertz, rel=0.03)
    return found[nearest]


def bent(x):
    """Return the lowest free mode of bending and its slope (1/m) at x from the middle, where it is 1 at the ends."""
    k = FREE / LENGTH
    high, low = math.cos(k * END), math.cosh(k * END)
    shape = math.cos(k * x) / high + math.cosh(k * x) / low
    slope = k * (-math.sin(k * x) / high + math.sinh(k * x) / low)
    return shape / 2, slope / 2


STEEL = Presets().material("steel")
SPEED = math.sqrt(STEEL.youngs_modulus / STEEL.density)
BENDING = FREE**2 / (2 * math.pi * LENGTH**2) * SPEED * THICKNESS / math.sqrt(12)
STRETCHING = SPEED / (2 * LENGTH)


@pytest.mark.parametrize("x", [-0.12, -0.04, 0.09])
def test_a_push_along_a_bar_stretches_it(session, x):
    """The lowest stretching mode is a cosine over the length, and the same over the section."""
    whole = of_mode(session, STRETCHING, "point", END, 0.0, 0.0)  # on the end face
    pushed = of_mode(session, STRETCHING, "point", x, 0.0, TOP, "direction", 2.0, 0.0, 0.0)
    assert pushed / whole == pytest.approx(abs(math.sin(math.pi * x / LENGTH)), abs=0.02)


@pytest.mark.parametrize("x", [-0.14, 0.05, 0.12])
def test_a_push_along_the_face_of_a_bar_bends_it(session, x):
    """A section turns by the slope, about the middle line: half the thickness above it moves along."""
    shape, slope = bent(x)
    struck = of_mode(session, BENDING, "point", x, 0.0, TOP)
    pushed = of_mode(session, BENDING, "point", x, 0.0, TOP, "direction", 1.0, 0.0, 0.0)
    assert pushed / struck == pytest.approx(abs(TOP * slope / shape), rel=0.05)


def test_a_push_across_the_face_of_a_bar_twists_it(session):
    """A section turns as a whole: it moves along the face as far as the face is from the middle."""
    frequency, struck = levels(session, "point", 0.1, ASIDE, TOP)
    middle = levels(session, "point", 0.1, 0.0, TOP)[1]
    twist = np.argmax(np.where(frequency < STRETCHING, struck / (middle + 1e-3 * struck), 0.0))
    pushed = levels(session, "point", 0.1, 0.0, TOP, "direction", 0.0, -1.0, 0.0)[1]
    assert pushed[twist] / struck[twist] == pytest.approx(TOP / ASIDE, rel=0.05)


@pytest.mark.parametrize("gesture", ["impact", "slide"])
def test_the_direction_of_the_normal_changes_nothing(session, gesture):
    sounds = []
    for direction in ((), ("direction", 0.0, 0.0, 5.0)):
        say(session, "/object/new", "bar", "bar")
        along = ("along", 1.0, "sweep", 0.0, "force", 5.0, "seed", 3, "id", "g") if gesture == "slide" else ()
        say(session, f"/object/bar/{gesture}", 0.3, "point", 0.05, 0.002, TOP, *along, *direction)
        sounds.append(session.engine.process(9_600).copy())
        say(session, "/object/bar/free", 1)
        session.engine.process(8_000)
    plain, directed = sounds
    assert np.abs(plain).max() > 1e-4
    assert np.abs(directed - plain).max() < 1e-3 * np.abs(plain).max()


def test_a_slide_in_a_direction_pushes_along_it(session):
    """Friction along the bar's middle line stretches and bends it, and twists it no more than across it does."""
    heard = {}
    for name, direction in (("along", (1.0, 0.0, 0.0)), ("across", (0.0, 1.0, 0.0))):
        say(session, "/object/new", "bar", "bar")
        keys = ("force", 20.0, "roughness", 0.0, "static", 0.8, "dynamic", 0.2, "seed", 3)
        say(session, "/object/bar/slide", 0.05, "point", -0.12, 0.0, TOP, *keys, "direction", *direction)
        session.engine.process(9_600)
        obj = session.engine.objects[session.objects["bar"].handle.slot]
        first = int(obj["first"])
        frequency = session.engine.state["bank"][0]["frequency"][first : first + int(obj["felt"])]
        found = mode_levels(session.engine, session.objects["bar"].handle.slot)
        heard[name] = found[np.abs(frequency - STRETCHING).argmin()]
        say(session, "/object/bar/free", 1)
        session.engine.process(8_000)
    assert heard["along"] > 1e3 * heard["across"]


@pytest.mark.parametrize(
    ("gesture", "args", "said"),
    [
        ("impact", (1.0, "direction", 1.0, 0.0, 0.0), "direction = 1 0 0: expected it beside a point"),
        (
            "impact",
            (1.0, "point", 0.0, 0.0, 0.0, "direction", 0.0, 0.0, 0.0),
            "direction = 0 0 0: expected a vector",
        ),
        ("roll", (1.0, "point", 0.0, 0.0, 0.0, "direction", 0.0, 0.0, 1.0), "direction: no such key"),
    ],
)
def test_wrong_directions_are_refused(session, gesture, args, said):
    say(session, "/object/new", "bar", "bar")
    assert said in refusal(session, f"/object/bar/{gesture}", *args)
