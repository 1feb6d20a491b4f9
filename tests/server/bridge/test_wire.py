"""A simulation told over OSC, by a client that knows nothing of Carom but the addresses, and by a score."""

import socket
import time
from contextlib import ExitStack

import numpy as np
import pytest
import soundfile
from pythonosc.osc_bundle_builder import IMMEDIATELY, OscBundleBuilder
from pythonosc.osc_message import OscMessage
from pythonosc.osc_message_builder import OscMessageBuilder

import carom
from carom.dsp.runtime.engine import NOW
from carom.dsp.runtime.engine import Engine as SoundEngine
from carom.presets import Presets
from carom.server.osc.addresses import calls
from carom.server.osc.oscquery import node
from carom.server.osc.score import parse
from carom.server.scene.session import Session
from carom.server.scene.transaction import NotMade
from tests.support import serving

WORLD = """
0 /world/body floor plate wood 0.5 0.4 0.01 held 1 most_modes 32
0 /world/body ball sphere glass 0.02
0 /world/pair floor ball surface polished-wood
0.01 /world/step 0.0
0.02 /world/pose ball 0 0 0.02 1 0 0 0 0 0 -1
0.02 /world/touch floor ball 0 0 0 0 0 1 approach 1.0 depth 0.002
0.02 /world/step 0.01
"""


def test_a_score_may_tell_a_simulation(render_text):
    sound = render_text(WORLD, seconds=0.3)
    begun = np.flatnonzero(np.abs(sound).max(axis=1) > 1e-6)[0]
    assert begun == pytest.approx(0.028 * 48_000, abs=4)  # a step after its line, 2 ms before the step's end


POURED = """
0 /world/body bowl plate ceramic 0.2 0.2 0.004 held 1 most_modes 32
0 /world/grains rice striker rice
"""


def test_a_score_that_pours_grains_is_as_loud_as_a_world_that_does():
    steps = [0.01 * n for n in range(1, 60)]
    lines = [f"{at:g} /world/pour rice bowl 6 speed 1.5\n{at:g} /world/step {at:g}" for at in steps]
    sound = carom.render(POURED + "\n".join(lines), 48_000, calibrated=True, seconds=0.6).samples
    with carom.World(microphones=[(0.0, 0.0, 0.0)] * 2, keep=True) as world:
        world.body("bowl", "plate", (0.2, 0.2, 0.004), "ceramic", held=True, most_modes=32)
        world.grains("rice", striker="rice")
        for at in steps:
            world.pour("rice", "bowl", 6, speed=1.5)
            world.step(at)
        right = world.sound().samples
    loud, wanted = (float((each[9600:24_000] ** 2).mean()) for each in (sound, right))
    assert 10 * np.log10(loud / wanted) == pytest.approx(0.0, abs=1.0)


def test_a_score_may_tell_bodies_that_are_grains(render_text):
    balls = "".join(f"0 /world/body ball{n} sphere steel 0.003\n" for n in range(8))
    kind = "0 /world/grains balls bodies ball*\n"
    hits = [
        f"{0.002 * n:g} /world/touch bowl ball{n % 8} 0.05 0 0.002 0 0 1 approach 0.5\n"
        f"{0.002 * n:g} /world/step {0.002 * n:g}"
        for n in range(100)
    ]  # fmt: skip
    assert np.abs(render_text(POURED + balls + kind + "\n".join(hits), seconds=0.3)).max() > 1e-6


@pytest.mark.parametrize(
    "line, reason",
    [
        ("/world/grains rice", "grains rice: there are some of that name already"),
        ("/world/grains peas", "grains peas: expected either bodies or a striker"),
        ("/world/grains peas striker ryce", "grains peas: no striker 'ryce': did you mean rice?"),
        ("/world/grains peas bodies pea*", "body pea*: no such body; expected one of bowl"),
        ("/world/grains peas bodies bowl", "grains peas: body bowl: it is held"),
        ("/world/pour rise bowl 3 speed 1", "grains rise: no such grains with a striker; did you mean rice?"),
        ("/world/pour rice bow 3 speed 1", "body bow: no such body; did you mean bowl?"),
        ("/world/pour rice bowl 3", "grains rice: expected speed, impulse or energy"),
        ("/world/pour rice bowl -3 speed 1", "count = -3: expected a number from 0 to 1e+06"),
        ("/world/pour rice bowl nan speed 1", "count = 'nan'"),
        ("/world/pour rice bowl 3 speed wide", "speed = wide: expected a number"),
    ],
)
def test_wrong_messages_about_grains_are_refused(render_text, line, reason):
    with pytest.raises(Exception) as refused:
        render_text(POURED + "0.1 " + line, seconds=0.2)
    assert reason in str(refused.value)


TOLD = """
/world/microphones 0 0 0.1 0 0 0.2
/world/body bowl plate ceramic 0.2 0.2 0.004 held 1 most_modes 32
/world/body ball sphere glass 0.02 most_modes 8
/world/grains seeds striker rice
/world/pour seeds bowl 3 speed 1
/world/pose ball 0 0 0.02
/world/touch bowl ball 0 0 0.002 0 0 1 approach 0.5
"""


@pytest.mark.slow
def test_messages_put_off_for_a_table_of_pulses_are_carried_out_once():
    session = Session(SoundEngine(48_000), Presets())
    lines = f"{TOLD}/object/bowl/shake 5 exponent 2.3".strip().splitlines()
    messages = [line.message for line in parse("".join(f"0 {line}\n" for line in lines).encode(), "told")]
    asked = [call for message in messages for call in calls(message)]
    with pytest.raises(NotMade, match=r"2\.3"):
        session.perform_calls(asked, NOW, beside={1.5})
    told = session._told_world()
    assert told._touches == [] and told._poses == {} and not told.simulation.bodies and not told.simulation.grains.some
    assert [reply.address for reply in session.perform_calls(asked, NOW, beside={1.5, 2.3})] == ["/done"] * 2
    assert told.simulation.hearing.microphones[1].position == (0.0, 0.0, 0.2)
    assert len(told._touches) == 1 and set(told._poses) == {"ball"}
    heaps, piled = (told.simulation.state[name][0] for name in ("heaps", "piled"))
    assert piled == 1 and heaps[0]["count"] == 3.0


def test_refused_pour_leaves_the_rest_of_its_step():
    """Hammers at next to no speed, whose blows would last for seconds, are silent beside rice, and faster ones
    than there are refused by themselves: all later steps were refused."""
    session = Session(SoundEngine(48_000), Presets())

    def say(text):
        lines = parse("".join(f"0 {line}\n" for line in text.strip().splitlines()).encode(), "told")
        return session.perform([line.message for line in lines], NOW)

    say(POURED.replace("\n0 ", "\n").strip().removeprefix("0 ") + "\n/world/grains hammers striker hammer")
    refused, heard = [], 0.0
    for n in range(1, 30):
        speed = 2e3 if n == 7 else 1e-11
        told = f"/world/pour hammers bowl 3 speed {speed}\n/world/pour rice bowl 30 speed 1.5\n/world/step {0.02 * n}"
        refused += say(told)
        heard = max(heard, abs(session.engine.process(960)).max())
    assert len(refused) == 1 and "speed = 2000: expected a number from 0 to 1000 m/s" in refused[0].args[1]
    assert heard > 1e-4


def test_oscquery_has_the_addresses():
    found = node("/world", {})
    assert set(found["CONTENTS"]) == {"body", "pair", "microphones", "pose", "touch", "grains", "pour", "step", "end"}
    assert found["CONTENTS"]["step"]["TYPE"] == "f" and found["CONTENTS"]["touch"]["TYPE"] == "ssffffff"


class Engine:
    """A game engine's side: datagrams made by python-osc, and the answers to them."""

    def __init__(self, port: int) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.connect(("127.0.0.1", port))
        self.socket.settimeout(5.0)

    def send(self, *messages) -> None:
        bundle = OscBundleBuilder(IMMEDIATELY)
        for address, *args in messages:
            made = OscMessageBuilder(address)
            for arg in args:
                made.add_arg(float(arg) if isinstance(arg, int) else arg)
            bundle.add_content(made.build())
        self.socket.send(bundle.build().dgram)

    def answers(self, until: str) -> list[tuple]:
        found = []
        while not found or found[-1][0] != until:
            message = OscMessage(self.socket.recv(65_536))
            found.append((message.address, *message.params))
        return found


@pytest.mark.slow
def test_an_engine_that_is_not_python_is_heard(tmp_path):
    record = tmp_path / "a.wav"
    with ExitStack() as closed, serving(tmp_path, "--device", "none", "--record", record) as server:
        engine = Engine(server.port)
        closed.callback(engine.socket.close)
        engine.send(("/world/body", "floor", "plate", "wood", 0.5, 0.4, 0.01, "held", 1))
        engine.send(("/world/body", "ball", "sphere", "glass", 0.02))
        engine.send(("/world/step", 0), ("/sync", 1))
        assert not [each for each in engine.answers("/synced") if each[0] == "/fail"]
        for n in range(1, 60):  # it falls, hits at step 20, and rolls on at 0.5 m/s from step 40
            rolls = n >= 40
            touch = (
                "/world/touch",
                "floor",
                "ball",
                0.005 * n,
                0,
                0,
                0,
                0,
                1,
                "approach",
                float(n == 20),
                "force",
                0.8,
            )
            pose = ("/world/pose", "ball", 0.005 * n, 0, 0.02, 1, 0, 0, 0, 0.5, 0, 0, 0, 25.0 * rolls, 0)
            engine.send(pose, *([touch] if n == 20 or rolls else []), ("/world/step", 0.01 * n))
            time.sleep(0.01)
        engine.send(("/world/touch", "floor", "bal", 0, 0, 0, 0, 0, 1))
        engine.send(("/world/step", 0.3), ("/gestures",), ("/status",), ("/sync", 2))
        answers = engine.answers("/synced")
        fails = [each[2] for each in answers if each[0] == "/fail"]
        assert fails[0] == "body bal: no such body; did you mean ball?"
        assert fails[1].startswith("step 61: time = 0.3") and len(fails) == 2
        (gestures,) = [each for each in answers if each[0] == "/gestures.reply"]
        assert gestures[3] == "contact.1"
        (status,) = [each for each in answers if each[0] == "/status.reply"]
        assert dict(zip(status[10::2], status[11::2], strict=True))["impacts"] >= 1
        engine.send(("/world/end",), ("/sync", 3))
        engine.answers("/synced")
        time.sleep(0.2)
    sound, _ = soundfile.read(record)
    assert np.abs(sound).max() > 1e-4
