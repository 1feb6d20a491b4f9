"""Objects that stand on a support by themselves, as their presets say."""

import numpy as np
import pytest
from scipy.special import j0

import carom
from carom.dsp.runtime.engine import NOW, Engine
from carom.presets import PresetError, Presets
from carom.presets.supports import SUPPORTS
from carom.server.files.log import Log
from carom.server.osc.score import read
from carom.server.osc.wire import Message
from carom.server.scene.session import Session
from tests.support import render_lines

STANDS = """
description = "a"
source = "b"
shape = "bar"
material = "steel"
level = 0.0
[geometry]
length = 0.3
width = 0.03
thickness = 0.004
[strike]
striker = "wood"
velocity = 1.0
position = 0.3
[rest]
support = "felt"
positions = [0.1]
"""


@pytest.fixture
def presets(tmp_path):
    """The presets that come with Carom, and a bar that stands on felt."""
    folder = tmp_path / "presets"
    (folder / "objects").mkdir(parents=True)
    (folder / "objects" / "lying.toml").write_text(STANDS)
    return Presets(folder)


def heard(presets, *messages, log=None):
    """Return the sound of messages at 0, and of a strike after 0.1 s."""
    engine = Engine(48_000)
    session = Session(engine, presets)
    if log:
        session.on_sent = log(engine)
    for address, *args in messages:
        replies = session.perform([Message(address, tuple(args))], NOW)
        assert all(reply.address == "/done" for reply in replies), replies
    before = engine.process(4_800)
    assert np.abs(before).max() < 1e-9
    session.perform([Message("/object/a/impact", (0.5,))], NOW)
    return engine.process(24_000)


def test_an_object_stands_as_if_a_message_had_laid_it_there(presets):
    new = "/object/new", "a", "lying"
    free = heard(presets, (*new, "rest", "none"))
    np.testing.assert_array_equal(heard(presets, new), heard(presets, (*new, "rest", "none"), REST))
    power = [np.square(sound[12_000:]).sum() for sound in (heard(presets, new), free)]
    assert power[0] < 0.3 * power[1]


REST = "/object/a/rest", "felt", 0.1


def test_standing_object_is_lifted_or_laid_elsewhere(presets):
    """Laid elsewhere by its weight it no longer stands where it did; a finger on it does not lift it."""
    new = "/object/new", "a", "lying"
    free = heard(presets, (*new, "rest", "none"))
    np.testing.assert_array_equal(heard(presets, new, ("/object/a/rest", "none")), free)
    np.testing.assert_array_equal(
        heard(presets, new, ("/object/a/rest", "foam", 0.5)),
        heard(presets, (*new, "rest", "none"), ("/object/a/rest", "foam", 0.5)),
    )
    np.testing.assert_array_equal(
        heard(presets, new, ("/object/a/rest", "finger", 0.9)),
        heard(presets, (*new, "rest", "none"), REST, ("/object/a/rest", "finger", 0.9)),
    )


def test_another_support_may_be_asked_for(presets):
    """A key of /object/new, and of Python's `new`."""
    new = "/object/new", "a", "lying"
    np.testing.assert_array_equal(
        heard(presets, (*new, "rest", "foam")), heard(presets, (*new, "rest", "none"), ("/object/a/rest", "foam", 0.1))
    )
    with pytest.raises(PresetError, match=r"rest = 'wool': expected one of felt, .*, table, none"):
        presets.object("lying").replace(rest="wool")
    with pytest.raises(PresetError, match="rest = 'felt': expected"):
        presets.object("wood-block").replace(rest="felt")


def test_an_object_that_stands_is_one_line_of_a_log(presets, tmp_path):
    logs = []

    def log(engine):
        logs.append(Log(engine, tmp_path / "log.txt"))
        logs[0].start()
        return logs[0].expect

    sound = heard(presets, ("/object/new", "a", "lying"), ("/object/a/rest", "none"), REST, log=log)
    logs[0].write()
    lines = read(tmp_path / "log.txt")
    said = [line.message.address.rsplit("/", 1)[1] for line in lines]
    assert said == ["new", "rest", "rest", "impact"]
    rendered = render_lines(lines, presets, limiter=False, seconds=0.6)
    np.testing.assert_array_equal(rendered[4_800:], sound)


G, MASS = 9.80665, 0.3 * 0.03 * 0.004 * 7850.0


@pytest.mark.parametrize(
    ("section", "reason"),
    [
        ("", r"\[rest\] positions or points: expected one of positions and points"),
        ("positions = [0.1]\npoints = [[0, 0, 0]]", r"\[rest\] positions and points: expected one of"),
        ("points = [[0, 0, 0]]", r"\[rest\] points: expected positions, as a bar has no surface"),
        ("positions = []", r"\[rest\] positions = \[\]: expected a list of 1 to 8, each a number from 0 to 1"),
    ],
)
def test_a_section_says_in_one_way_where_an_object_stands(tmp_path, section, reason):
    (tmp_path / "objects").mkdir()
    (tmp_path / "objects" / "lying.toml").write_text(STANDS.replace("positions = [0.1]", section))
    with pytest.raises(PresetError, match=reason):
        Presets(tmp_path).object("lying")


def test_on_two_felts_each_bears_half(presets, tmp_path):
    """A message that says no place lays the object on the same two, as one gesture."""
    two = tmp_path / "presets" / "objects" / "two.toml"
    two.write_text(STANDS.replace("positions = [0.1]", "positions = [0.1, 0.7]"))
    free = "/object/new", "a", "two", "rest", "none"
    halves = [("/object/a/rest", "felt", at, "load", G * MASS / 2, "id", "x") for at in (0.1, 0.7)]
    sound = heard(presets, ("/object/new", "a", "two"))
    np.testing.assert_array_equal(sound, heard(presets, free, *halves))
    np.testing.assert_array_equal(sound, heard(presets, free, ("/object/a/rest", "felt", "id", "x")))
    np.testing.assert_array_equal(
        heard(presets, free), heard(presets, free, ("/object/a/rest", "felt", "id", "x"), ("/gesture/x/stop",))
    )


def test_object_that_stands_nowhere_is_not_lifted():
    session = Session(Engine(48_000), Presets())
    session.perform([Message("/object/new", ("a", "glass-plate"))], NOW)
    (warning,) = session.perform([Message("/object/a/rest", ("none",))], NOW)
    assert warning.address == "/warning"
    assert warning.args[0] == "a stands on nothing by itself; what a message laid down is lifted by /gesture/ID/stop"


@pytest.mark.slow
def test_a_tumbler_on_a_table_loses_what_its_foot_feeds_into_it():
    """The lowest two modes against the poles of all modes on three springs, on points of a plate that feel each
    other by J0: within 10 %; they ring under half as long as without the table."""
    engine = Engine(48_000)
    session = Session(engine, Presets())
    for address, *args in (("/object/new", "a", "tumbler"), ("/object/a/impact", 0.05, 0.9)):
        session.perform([Message(address, tuple(args))], NOW)
    engine.process(64)
    tumbler, on = session.objects["a"], engine.state
    feet = [contact for contact in on["contacts"][0] if contact["trait"]["rests"] and contact["touching"]]
    assert len(feet) == 3
    lost = _poles(tumbler, feet, [_shapes(on, contact) for contact in feet])
    sound = engine.process(48_000)[:, 0].astype(float)
    first, last = (_level(sound, at, 1_043.0) for at in (0.25, 0.55))
    assert np.log(first / last) / 0.6 == pytest.approx(lost.mean(), rel=0.1)
    assert lost.min() > 2.2 * tumbler.modes.decay[:2].max()


def _shapes(on, contact):
    """Return the shapes of all modes where a contact touches its object."""
    point, obj = contact["point"][0], on["objects"][0][contact["point"][0]["slot"]]
    shape, size = on["bank"]["shape"].reshape(-1), int(obj["size"])
    begin = int(obj["table"]) + int(point["row"]) * size
    rows = shape[begin : begin + 4 * size].reshape(4, size)
    return (point["weights"] @ rows)[: int(obj["live"])]


def _poles(body, feet, shapes):
    """Return the decays (1/s) of the lowest two modes on the law's springs, linearised, as large as the masses are."""
    modes, phi, table = body.modes, np.array(shapes)[:, : len(body.modes.frequency)], SUPPORTS["table"]
    mass, k, mu, a = (float(feet[0][key]) for key in ("m", "k", "mu", "a"))
    load = float(feet[0]["now"]["load"])
    spring = a * k ** (1 / a) * load ** (1 - 1 / a)
    points = np.array(body.preset.standing.points)
    apart = np.linalg.norm(points[:, None] - points, axis=2)
    natural, n, lost = (2 * np.pi * modes.frequency) ** 2 + modes.decay**2, len(modes.frequency), []
    for i in range(2):
        pole = 2j * np.pi * 1_043.0
        for _ in range(20):
            wave = 2 * np.pi / table.wavelength * np.sqrt(pole.imag / (2e3 * np.pi))
            give = np.eye(3) * (1 / (spring / pole + mu * load) + 1 / (pole * mass))
            force = phi.T @ np.linalg.solve(give + j0(wave * apart) / table.resistance, phi)
            matrix = np.block([[np.zeros((n, n)), np.eye(n)], [-np.diag(natural), -np.diag(2 * modes.decay) - force]])
            found, vectors = np.linalg.eig(matrix)
            near = np.where(np.abs(found.imag - pole.imag) < 500.0, np.abs(vectors[i] / np.abs(vectors[:n]).max(0)), 0)
            pole = found[near.argmax()]
        lost.append(-pole.real)
    return np.array(lost)


def _level(sound, at, frequency):
    """Return the energy of a sound about a time (s), within 40 Hz of a frequency."""
    window = sound[int(at * 48_000) :][:4_096] * np.hanning(4_096)
    bins = np.fft.rfftfreq(4_096, 1 / 48_000)
    return np.square(np.abs(np.fft.rfft(window)))[np.abs(bins - frequency) < 40].sum()


def test_lifted_object_stands_no_more():
    session = Session(Engine(48_000), Presets())
    session.perform([Message("/object/new", ("a", "tumbler"))], NOW)
    assert session.perform([Message("/object/a/rest", ("none",))], NOW) == []
    (warning,) = session.perform([Message("/object/a/rest", ("none",))], NOW)
    assert warning.address == "/warning" and warning.args[0].startswith("a stands on nothing by itself")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "under"), [("polycarbonate-sheet", "table"), ("polycarbonate-sheet", "other"), ("ceramic-tile", "other")]
)
def test_a_soft_blow_on_what_lies_on_a_hard_support_is_as_accurate_as_asked(name, under):
    """The blow compresses the contact by a thousandth of what the load does: steps are as fine as that takes."""
    exact, *others = (
        carom.render(
            f"0 /accuracy {level}\n0 /object/new a {name}\n0 /object/new other {name} tune 0.3\n"
            f"0 /object/a/rest {under}\n0.002 /object/a/impact 0.001 0.3\n",
            seconds=0.1,
            limiter=False,
        ).samples.astype(float)
        for level in ("exact", "-60", "-80")
    )
    for sound, bound in zip(others, (1e-3, 1e-4), strict=True):
        assert np.linalg.norm(sound - exact) < bound * np.linalg.norm(exact)
