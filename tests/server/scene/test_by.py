"""Objects that strike others: the contact's law comes from both materials, given keys win, and a log keeps it."""

import numpy as np
import pytest

from carom.dsp.contact import contact_time
from carom.dsp.runtime.engine import NOW, Engine
from carom.presets import Presets
from carom.server.files.log import Log
from carom.server.osc.score import read
from carom.server.osc.wire import Message
from carom.server.render import Options, blocks
from carom.server.scene.session import Session
from tests.presets.examples import LISTED

LAW = ("mass", "stiffness", "dissipation", "exponent")


@pytest.fixture
def scene(tmp_path):
    (tmp_path / "objects").mkdir()
    (tmp_path / "objects" / "listed.toml").write_text(LISTED)
    scene = Session(Engine(48_000), Presets([tmp_path]))
    made = [("board", "wood-board"), ("listed", "listed"), ("other", "listed")]
    made += [(name, "wood-block", "material", name, "gain", -120) for name in ("rubber", "wood", "glass", "steel")]
    replies = scene.perform([Message("/object/new", args) for args in made], NOW)
    assert {reply.address for reply in replies} == {"/done"}
    return scene


def carried_out(scene, *args, action="impact"):
    """Return the keys of a message to the board, as a log would have them."""
    sent = []
    scene.on_sent = lambda first, more: sent.extend(more)
    replies = scene.perform([Message(f"/object/board/{action}", args)], NOW)
    assert "/fail" not in {reply.address for reply in replies}, replies
    first = next(n for n, arg in enumerate(args) if isinstance(arg, str))
    said = sent[-1].message.args[first:]
    return dict(zip(said[::2], said[1::2], strict=True))


@pytest.mark.slow
def test_each_body_strikes_a_board_in_its_own_way(scene):
    """The bodies have equal mass: the softer, the longer the contact; the softest sounds the dullest. Hard ones ring
    themselves."""
    times, centroids = [], []
    for name in ("rubber", "wood", "glass", "steel"):
        law = carried_out(scene, 1.0, 0.3, "by", name, "mass", 0.05)
        times.append(float(contact_time(1.0, *(law[key] for key in LAW))))
        spectrum = np.abs(np.fft.rfft(scene.engine.process(48_000).sum(axis=1))) ** 2
        centroids.append(np.average(np.arange(len(spectrum)), weights=spectrum))
        scene.engine.process(48_000)
    assert times == sorted(times, reverse=True) and centroids[0] == min(centroids)
    assert times[0] > 5 * times[1] and centroids[0] < centroids[1] / 2


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rubber", "steel"])
def test_the_law_is_that_of_the_presets_and_the_mass_the_object_s(scene, name):
    law = carried_out(scene, 1.0, "by", name)
    board, by = scene.objects["board"], scene.objects[name]
    assert tuple(law[key] for key in LAW) == (by.mass, *board.preset.struck_by(by.preset))


@pytest.mark.slow
def test_given_keys_win(scene):
    plain = carried_out(scene, 1.0, "by", "steel")
    given = {"mass": 0.5, "stiffness": 1e7, "dissipation": 0.5, "exponent": 2.0}
    for key, value in given.items():
        assert carried_out(scene, 1.0, "by", "steel", key, value) == {**plain, key: value}
    felt = scene.presets.striker("felt").contact(scene.objects["board"].preset.material)
    law = carried_out(scene, 1.0, "by", "steel", "striker", "felt")
    assert tuple(law[key] for key in LAW) == (plain["mass"], *felt[1:])


def test_a_blunter_body_is_stiffer(scene):
    plain, blunt = (carried_out(scene, 1.0, "by", "glass", *more) for more in ((), ("by_radius", 0.04)))
    assert blunt["stiffness"] == pytest.approx(2 * plain["stiffness"])


def test_a_roll_s_radius_is_that_of_its_contact(scene):
    radius = {"radius": 0.04, "by_radius": 0.09}
    small = carried_out(scene, 0.1, "by", "glass", action="roll")
    rough = Message("/object/board/roll", (0.1, "by", "glass", "surface", "asphalt", "roughness", 100, "id", "rough"))
    assert "radius = 0.01: expected at least" in str(scene.perform([rough], NOW)[0].args[1])
    for id, times, keys in (("a", 2, ["radius"]), ("b", 3, ["by_radius"]), ("c", 3, ["radius", "by_radius"])):
        args = [word for key in keys for word in (key, radius[key])]
        law = carried_out(scene, 0.1, "by", "glass", *args, "id", id, action="roll")
        assert law["stiffness"] == pytest.approx(times * small["stiffness"])
        assert law["dissipation"] == scene.presets.surface("wood").dissipation
        assert law["mass"] == scene.objects["glass"].mass
    law = carried_out(scene, 0.2, "by", "glass", "id", "c", action="roll")
    assert "mass" not in law and "radius" not in law  # which would steer the roll that goes on


def test_a_listed_body_without_a_material_counts_as_steel_and_that_is_said_once(scene):
    def warned(address, *args):
        return [reply.args[0] for reply in scene.perform([Message(address, args)], NOW) if reply.address == "/warning"]

    text = "{} has no material: where it and another object meet, it counts as steel"
    assert warned("/object/board/impact", 1.0) == []
    assert warned("/object/board/impact", 1.0, "by", "listed", "striker", "wood") == []
    assert warned("/object/board/impact", 0.0, "by", "listed") == []
    assert warned("/object/board/impact", 1.0, "by", "listed") == [text.format("listed")]
    assert warned("/object/board/impact", 1.0, "by", "listed") == []
    assert warned("/object/listed/impact", 1.0, "by", "other") == [text.format("other")]
    law = carried_out(scene, 1.0, "by", "listed")
    board, steel = scene.objects["board"].preset, scene.objects["steel"].preset
    assert tuple(law[key] for key in LAW[1:]) == board.struck_by(steel)


def test_a_log_renders_to_the_same_bits_once_materials_have_changed(tmp_path):
    engine, scores = Engine(48_000), tmp_path / "log.txt"
    scene, log = Session(engine, Presets()), Log(engine, scores)
    scene.on_sent = log.expect
    log.start()
    messages = [Message("/object/new", ("board", "wood-board")), Message("/object/new", ("cup", "wine-glass"))]
    messages += [
        Message("/object/board/impact", (1.0, "by", "cup")),
        Message("/object/board/bounce", (0.01, "by", "cup", "by_radius", 0.003)),
        Message("/object/board/roll", (0.1, "by", "cup")),
    ]
    assert "/fail" not in {reply.address for reply in scene.perform(messages, NOW)}
    heard = engine.process(24_000)
    log.close()
    folder = tmp_path / "changed"
    (folder / "materials").mkdir(parents=True)
    text = Presets().path("materials", "wood").read_text()
    (folder / "materials" / "wood.toml").write_text(text.replace("dissipation = 0.45", "dissipation = 0.1"))
    changed = Presets([folder])
    assert changed.material("wood").dissipation == 0.1

    def rendered(lines):
        return np.concatenate(list(blocks(lines, Engine(48_000), changed, Options(seconds=0.5))))

    lines = read(scores)
    assert all(set(LAW) < set(map(str, line.message.args)) for line in lines[2:5])
    np.testing.assert_array_equal(rendered(lines), heard)
    (tmp_path / "plain.txt").write_text("".join(f"0 {m.address} {' '.join(map(str, m.args))}\n" for m in messages))
    assert not np.array_equal(rendered(read(tmp_path / "plain.txt")), heard)
