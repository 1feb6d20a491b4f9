"""Macros: what each does to the sound, while it rings and before; the die, the morph, logs, and what is refused."""

import random
from pathlib import Path

import numpy as np
import pytest

import carom
from carom.dsp.bodies.macros import size_at
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.macros import ENGINE_SETTINGS, MACROS, NEUTRAL, SHAPING
from carom.dsp.runtime.engine import Engine
from carom.presets import Presets
from carom.presets.reshaping import LINE, Wanted, axes_of, material_at
from carom.server.files.log import Log
from carom.server.osc.score import parse
from carom.server.osc.wire import Message
from carom.server.scene.ahead import MOST
from carom.server.scene.session import Session
from tests.server.scene.support import refusal, say, seconds
from tests.support import render_lines

RATE = 48_000
BLOW = {"mass": 0.02, "stiffness": 1e7, "exponent": 1.5, "dissipation": 0.2}
OBJECTS = ("church-bell", "mug", "marimba-bar", "guitar-string", "glass-plate", "tom", "gong")
"""Listed, of a mesh, and of shapes; one whose modes are coupled."""


def bank(session: Session, name: str, column: str) -> np.ndarray:
    """Return a column of the modes of an object that contacts feel and ears hear, as they are now."""
    obj = session.objects[name]
    first = obj.handle.first
    count = np.count_nonzero(obj.modes.frequency <= session.engine.top_frequency)
    return session.engine.state["bank"][column][0][first : first + count].copy()


def rung(session: Session, name: str, position: float = 0.3) -> np.ndarray:
    """Strike an object and return a second of sound."""
    say(session, f"/object/{name}/impact", 1.0, position, *(x for pair in BLOW.items() for x in pair))
    return session.engine.process(RATE)


def partial(sound: np.ndarray, frequency: float, decay: float) -> float:
    """Return the level (dB) of a partial, by a window that falls as it does."""
    t = np.arange(len(sound)) / RATE
    return 20 * np.log10(np.abs((sound.mean(axis=1) * np.exp((-decay - 2j * np.pi * frequency) * t)).sum()))


def test_a_listed_bell_of_size_2_has_half_the_pitch_and_eight_times_the_mass(session):
    say(session, "/object/new", "bell", "church-bell")
    before, decay = bank(session, "bell", "frequency"), bank(session, "bell", "sigma")
    mass = session.objects["bell"].mass
    assert say(session, "/object/bell/macro/size", 0.75) == []
    seconds(session, 0.1)
    rung(session, "bell")
    assert size_at(0.75) == 2.0
    assert np.allclose(bank(session, "bell", "frequency"), before / 2, rtol=1e-6)
    assert np.all(bank(session, "bell", "sigma") < decay)
    assert session.objects["bell"].mass == pytest.approx(8 * mass, rel=1e-6)
    assert session.engine.objects["amplitude"][session.objects["bell"].handle.slot] == pytest.approx(8**-0.5, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "macro", "value", "key"),
    [("marimba-bar", "material", 1.0, "steel"), ("steel-plate", "size", 0.6, size_at(0.6))],
)
def test_a_changed_body_sounds_as_one_that_is_made_so(name, macro, value, key):
    """A bar of rosewood that is turned to steel is the bar that is made of steel: its partials within 1 dB and 5 cents,
    those that ring on and are at most 25 dB softer than the loudest, which no other one covers."""
    sounds, tables = [], []
    for made in (True, False):
        session = Session(Engine(RATE), Presets())
        say(session, "/object/new", "it", name, *((macro, key) if made else ()))
        if not made:
            say(session, f"/object/it/macro/{macro}", value)
        seconds(session, 0.1)
        sounds.append(rung(session, "it", 0.2))
        tables.append((bank(session, "it", "frequency"), bank(session, "it", "sigma")))
    levels = [partial(sounds[0], f, s) for f, s in zip(*tables[0], strict=True)]
    heard = [n for n, level in enumerate(levels) if level > max(levels) - 25 and tables[0][1][n] < 10.0]
    assert len(heard) > 2
    for n in heard:
        f, s = (column[n] for column in tables[0])
        assert np.abs(1200 * np.log2(tables[1][0] / f)).min() < 5
        assert partial(sounds[1], f, s) == pytest.approx(levels[n], abs=1.0)


@pytest.mark.parametrize("name", OBJECTS)
def test_every_macro_acts_on_every_object(session, name):
    assert say(session, "/object/new", "it", name)[0].address == "/done"
    for macro in MACROS:
        for value in (0.0, 1.0, 0.3):
            assert [
                reply for reply in say(session, f"/object/it/macro/{macro}", value) if reply.address == "/fail"
            ] == []
    settings = session.engine.objects["settings"][session.objects["it"].handle.slot]
    seconds(session, 0.1)
    sound = rung(session, "it")
    assert np.isfinite(sound).all() and np.abs(sound).max() > 0.0
    settings = session.engine.objects["settings"][session.objects["it"].handle.slot]
    assert all(settings[macro] == 0.3 for macro in MACROS)


@pytest.mark.parametrize("macro", [each.name for each in SHAPING])
@pytest.mark.parametrize("name", ["church-bell", "mug", "marimba-bar"])
def test_a_sweep_of_what_rings_makes_no_click(macro, name):
    """The fourth differences of a bell that is steered are at most those of an unsteered one, or of one that rings
    where the sweep ends, and those of a change of 2/64 of the sound in a sample."""

    def ring(*turned: float) -> np.ndarray:
        session = Session(Engine(RATE), Presets())
        other = {"mug": "bottle", "marimba-bar": "vibraphone-bar"}.get(name, name)
        address, first = ("/object/it/morph", (other,)) if macro == "morph" else (f"/object/it/macro/{macro}", ())
        say(session, "/object/new", "it", name)
        if turned:
            say(session, address, *first, turned[0])
        seconds(session, 0.05)
        say(session, "/object/it/impact", 1.0)
        before = session.engine.process(RATE // 4)
        for value in turned[1:]:
            say(session, address, *first, value, "over", 0.3)
        return np.concatenate([before, session.engine.process(RATE // 2)])[RATE // 10 :]

    start = dict.fromkeys(MACROS, 0.5).get(macro, 0.0)
    swept, still, ended = ring(start, 0.9), ring(), ring(0.9)

    def highest(sound: np.ndarray) -> float:
        return float(np.abs(np.diff(sound.astype(float), 4, axis=0)).max())

    assert not np.array_equal(swept, still)
    assert highest(swept) <= max(highest(still), highest(ended), 2 / QUANTUM * np.abs(swept).max())


def test_macros_that_all_take_from_a_body_leave_it_modes():
    """Losses of a material, a coat and a hand multiply; a roll on what is left stays finite."""
    with carom.Scene(limiter=False) as scene:
        body = scene.new("a", "triangle", tune=-15)
        body.macro(material=0.07, brightness=0.2, damping=0.64, hardness=0.02)
        body.roll(speed=0.135, seed=392, striker="brass", roughness=0.37, play=1)
        assert np.abs(scene.render(0.3).samples).max() > 0.0


SWEEP = """
0.0 /object/new it {name}
0.05 /object/it/impact 1.0
0.1 /object/it/macro/size [0.7 0.3] over [0.2 0.1]
0.15 /object/it/macro/material 0.8 over 0.2
0.2 /object/it/macro/brightness 0.1
0.25 /object/it/macro/hardness 0.9
0.3 /object/it/macro/force 0.7
0.35 /object/it/impact 1.0 0.4
0.4 /object/it/dice 3
0.45 /object/it/slide 0.3 id s
0.5 /object/it/macro/force 0.2 over 0.1
0.6 /object/it/undo
"""


@pytest.mark.parametrize("name", ["church-bell", "mug", "marimba-bar"])
def test_a_score_a_session_in_other_blocks_and_a_log_have_the_same_bits(tmp_path, name):
    lines = parse(SWEEP.format(name=name).encode(), Path("sweep"))
    first = render_lines(lines, seconds=0.8, limiter=False)
    session = Session(Engine(RATE), Presets())
    log = Log(session.engine, tmp_path / "log.txt")
    session.on_sent = log.expect
    log.start()
    for line in lines:
        session.perform([line.message], line.time * RATE)
    sound = np.concatenate([session.engine.process(frames) for frames in (100, 1, 7000, 333) * 6])[: len(first)]
    log.write()
    assert np.array_equal(sound, first[: len(sound)])
    log.close()
    logged = (tmp_path / "log.txt").read_text()
    assert "/dice" not in logged and logged.count("/macro/") > 10
    again = render_lines(
        [line for line in parse(logged.encode(), Path("log")) if line.message.address != "/panic"],
        seconds=0.8,
        limiter=False,
    )
    assert np.array_equal(again, first)


def test_a_macro_steers_what_goes_on(session):
    say(session, "/object/new", "pane", "glass-plate")
    say(session, "/object/pane/roll", 0.4, 0.4, "striker", "glass-marble", "id", "marble")
    say(session, "/object/pane/macro/place", 1.0)
    say(session, "/object/pane/macro/roughness", 0.75)
    seconds(session, 0.2)
    contacts = session.engine.state["contacts"][0]
    (target,) = contacts["target"][contacts["gesture"] > 0]
    assert target["position"] == pytest.approx(1.0) and target["roughness"] == pytest.approx(10**0.5)


def test_copies_for_notes_follow_the_macros(session):
    say(session, "/object/new", "bar", "marimba-bar")
    say(session, "/object/bar/macro/size", 0.6)
    say(session, "/object/bar/note", 60, 100)
    assert session.objects["bar.60"].macros["size"] == 0.6
    say(session, "/object/bar/macro/size", 0.4)
    assert session.objects["bar.60"].macros["size"] == 0.4


def test_dice_choose_what_their_seed_says_and_are_taken_back(session):
    say(session, "/object/new", "bell", "church-bell")

    def macros():
        return dict(session.objects["bell"].macros)

    before = macros()
    say(session, "/object/bell/dice", 5)
    thrown = macros()
    assert all(low <= thrown[name] <= high for name, each in MACROS.items() for low, high in [each.dice])
    say(session, "/object/bell/dice", 6)
    assert macros() != thrown
    say(session, "/object/bell/undo")
    assert macros() == thrown
    say(session, "/object/bell/undo")
    assert macros() == before


def test_a_macro_that_is_sent_ahead_does_not_reach_what_comes_before_it(session, monkeypatch):
    commands, send = [], session.engine.send
    monkeypatch.setattr(session.engine, "send", lambda made: commands.extend(made) or send(made))
    say(session, "/object/new", "bell", "church-bell")
    session.perform([Message("/object/bell/macro/force", (1.0,))], 4_800.0)
    say(session, "/object/bell/impact", 1.0)
    session.perform([Message("/object/bell/impact", (1.0,))], 9_600.0)
    assert [each.values["velocity"] for each in commands if each.kind == "impact"] == [1.0, 8.0]


AHEAD = [
    (0.0, "/object/new", "it", "marimba-bar"),
    (0.0, "/object/new", "other", "church-bell"),
    (0.1, "/object/other/macro/size", 0.6),
    (0.11, "/object/it/macro/size", 0.45),
    (0.12, "/object/it/macro/material", 0.8),
    (0.15, "/object/it/macro/hardness", 0.7),
    (0.16, "/object/it/macro/force", 0.6),
    (0.2, "/object/it/impact", 1.0, "play", 1),
    (0.25, "/object/it/impact", 0.5, "by", "other"),
    (0.3, "/object/it/roll", 0.3, "striker", "steel", "id", "r", "play", 1, "seed", 1),
    (0.4, "/object/it/macro/force", 0.4),
    (0.41, "/object/it/macro/place", 0.8),
    (0.45, "/object/it/damp", 0.3),
    (0.5, "/object/it/macro/hardness", 0.3),
    (0.55, "/object/it/impact", 1.0, "play", 1),
]


@pytest.mark.parametrize("seed", range(4))
def test_the_order_of_sending_ahead_is_no_matter(seed):
    """Macros and gestures of different times that are sent in any order sound as if they were sent as they come."""
    sounds = []
    for shuffled in (False, True):
        session = Session(Engine(RATE), Presets())
        sent = [(time, Message(address, tuple(args))) for time, address, *args in AHEAD]
        if shuffled:
            random.Random(seed).shuffle(order := [*range(2, len(sent))])
            sent[2:] = [sent[n] for n in order]
        for time, message in sent:
            session.perform([message], time * RATE)
        sounds.append(session.engine.process(RATE))
    assert np.abs(sounds[0]).max() > 0.0
    assert np.array_equal(*sounds)


def test_hardness_steers_a_roll_that_goes_on(session):
    say(session, "/object/new", "pane", "glass-plate")
    say(session, "/object/pane/roll", 0.4, 0.4, "striker", "glass-marble", "id", "marble")
    seconds(session, 0.1)
    contacts = session.engine.state["contacts"][0]
    (before,) = contacts["target"][contacts["gesture"] > 0].copy()
    say(session, "/object/pane/macro/hardness", 0.75)
    seconds(session, 0.2)
    (target,) = contacts["target"][contacts["gesture"] > 0]
    assert target["stiffness"] == pytest.approx(1000**0.5 * before["stiffness"])
    assert target["mass"] == pytest.approx(2**0.5 * before["mass"])


def test_a_gesture_that_cannot_be_with_a_macro_before_it_is_taken_back(session):
    say(session, "/object/new", "pane", "glass-plate")
    session.perform([Message("/object/pane/impact", (0.01, "mass", 20.0, "stiffness", 3e4, "id", "x"))], 9_600.0)
    (reply,) = [
        each for each in session.perform([Message("/object/pane/macro/hardness", (0.0,))], 4_800.0)
        if each.address == "/fail"
    ]  # fmt: skip
    assert reply.args[0] == "/object/pane/impact" and "the contact would last" in reply.args[1]
    assert not np.any(session.engine.process(RATE))
    assert session.gestures.running() == [] or list(session.take_ends())


def test_a_material_of_the_line_has_the_damping_that_a_file_gives_anew():
    preset = Presets().object("bottle")
    assert preset.damping == {"alpha": 8.0}
    assert material_at(preset, 1.0).alpha == 8.0 == preset.replace(material="steel").material.alpha


def test_there_is_nothing_to_take_back_before_a_throw(session):
    say(session, "/object/new", "bell", "church-bell")
    assert refusal(session, "/object/bell/undo") == "bell: nothing to take back; expected /object/bell/dice before"


def test_an_object_morphs_to_another_of_its_family(session):
    say(session, "/object/new", "bar", "marimba-bar")
    before = bank(session, "bar", "frequency")
    assert say(session, "/object/bar/morph", "vibraphone-bar", 1.0) == []
    seconds(session, 0.1)
    rung(session, "bar")
    other = np.sort(Presets().object("vibraphone-bar").modes(20_000.0).frequency)
    count = min(len(before), len(other), 20)
    assert np.sort(bank(session, "bar", "frequency"))[:count] == pytest.approx(other[:count], rel=1e-5)


@pytest.mark.parametrize(
    ("address", "args", "reason"),
    [
        ("macro/size", (1.5,), "size = 1.5: expected a number from 0 to 1"),
        ("macro/size", ("big",), "size = big: expected a number from 0 to 1"),
        ("macro/hardness", (0.5, "over", -1), "over = -1: expected a number from 0 to 3600 s"),
        (
            "morph",
            ("church-bell", 0.5),
            "preset = church-bell: it is of the shape listed; expected one of the shape plate",
        ),
        ("morph", ("nothing", 0.5), "no object 'nothing': expected one of"),
        ("morph", ("mug",), "morph is missing: expected /object/NAME/morph preset morph [key value ...]"),
        ("morph", (0.5, 0.5), "preset = 0.5: expected a name"),
        ("macro/sise", (0.5,), "unknown action 'sise'; expected size, material"),
        ("dice", (-1,), "seed = -1: expected a number from 0 to 2147483647"),
    ],
)
def test_wrong_macros_are_refused_with_a_reason(played, address, args, reason):
    assert reason in refusal(played, f"/object/pane/{address}", *args)
    assert played.objects["pane"].macros["size"] == NEUTRAL


def test_a_material_in_the_middle_is_the_objects_own_and_at_the_end_that_of_the_line():
    preset = Presets().object("marimba-bar")
    assert material_at(preset, NEUTRAL) == preset.material
    assert material_at(preset, 1.0).name == LINE[-1] and material_at(preset, 0.0).name == LINE[0]


def test_no_change_is_none():
    preset = Presets().object("church-bell")
    for changes in axes_of(Wanted(preset, preset.modes(20_000.0), 20_000.0, True)):
        middle = changes[len(changes) // 2] if changes is not changes[-1] else changes[0]
        assert np.abs(middle.modes).max() < 1e-12 and middle.amplitude == 0.0


def test_settings_of_the_engine_begin_with_those_that_are_told():
    assert [*ENGINE_SETTINGS][-len(SHAPING) :] == [each.name for each in SHAPING]


def test_python_turns_macros():
    with carom.Scene(limiter=False) as scene:
        bell = scene.new("bell", "church-bell")
        bell.macro(size=0.75, brightness=0.2, over=0.1)
        bell.dice(3)
        bell.undo()
        bell.impact(1.0, at=0.2)
        assert np.abs(scene.render(0.5).samples).max() > 0.0
        with pytest.raises(carom.CommandError, match="expected a macro"):
            bell.macro()


def test_no_macro_holds_up_the_sound_by_more_gestures_sent_ahead_than_are_bounded(session):
    """Each that begins later is carried out anew, and looked for among all that wait in the engine."""
    say(session, "/object/new", "a", "wood-block")
    for n in range(MOST):
        assert say(session, "/object/a/impact", 0.1, time=480_000.0 + n) == []
        if n % 100 == 0:
            session.engine.process(64)
    assert say(session, "/object/a/macro/force", 0.7) == []
    session.engine.process(64)
    say(session, "/object/a/impact", 0.1, time=480_000.0 + MOST)
    why = f"{MOST + 1} gestures that were sent ahead would change: expected at most {MOST}"
    assert refusal(session, "/object/a/macro/force", 0.2) == why


def struck(preset: str, striker: str, macros: dict[str, float], **keys: float) -> np.ndarray:
    """Return the octaves (dB) of a blow on an object and the half second after it."""
    with carom.Scene(RATE, limiter=False) as scene:
        body = scene.new("a", preset, **keys)
        if macros:
            body.macro(**macros)
        body.impact(1.0, striker=striker)
        sound = scene.render(0.5).samples[:, 0].astype(float)
    power, frequency = np.abs(np.fft.rfft(sound)) ** 2, np.fft.rfftfreq(len(sound), 1.0 / RATE)
    edges = 45.0 * 2.0 ** np.arange(9)
    return 10.0 * np.log10([power[(frequency >= f) & (frequency < 2.0 * f)].sum() for f in edges])


@pytest.mark.parametrize("striker", ["wet-finger", "hammer"])
@pytest.mark.parametrize("name", ["steel-plate", "steel-ring", "marimba-bar", "opera-gong"])
def test_a_size_by_its_macro_sounds_as_the_preset_of_that_size(name, striker):
    """Modes that it brings above hearing keep their part in what slow forces bend, clicks go with the mass that moves,
    and what couples modes with the strain."""
    for value in (0.2, 0.4, 0.6):
        macro, key = struck(name, striker, {"size": value}), struck(name, striker, {}, size=size_at(value))
        loud = key > key.max() - 40.0
        assert np.abs(macro - key)[loud].max() < 3.0


@pytest.mark.parametrize("name", ["steel-ring", "church-bell"])
@pytest.mark.parametrize("macro", ["brightness", "damping"])
def test_a_soft_blow_does_not_thump_where_decays_change(name, macro):
    """What slow forces bend stays unheard: below the lowest mode no octave is louder than it was by more than 3 dB."""
    plain = struck(name, "wet-finger", {})
    for value in (0.1, 0.9):
        assert (struck(name, "wet-finger", {macro: value}) - plain)[:2].max() < 3.0
