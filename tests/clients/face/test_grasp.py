"""A gripper of MuJoCo that lifts a mug, against the linearised law of its fingers; a marble that rolls past."""

import numpy as np
import pytest

import carom
from tests import needs

mujoco = needs.module("mujoco")

from carom.presets.supports import SUPPORTS  # noqa: E402
from tests.clients.face.corpus import module  # noqa: E402
from tests.dsp.engine.contacts.test_coupling import modal  # noqa: E402
from tests.dsp.engine.contacts.test_rests import contact_of  # noqa: E402

pytestmark = pytest.mark.slow

grasp = module("grasp")
RATE = 48_000
MODES = 5
AIR = 343.2  # m/s, about


def stepped(data, bridge, until):
    """Step the gripper up to a time; return what the finger senses."""
    sensed = []
    while data.time < until - 0.5 * grasp.STEP:
        grasp.steer(data)
        bridge.step()
        sensed.append(bridge.world.sensed["finger"].copy())
    return np.concatenate(sensed)


def handle_of(world, name):
    return world._scene._open.scene.objects[name].handle


def linear_decays(world, free=False):
    """Return the decays (1/s) of the mug's first modes, between two fingers of the linearised law, with their modes."""
    engine = world._scene._open.engine
    mug = world._scene._open.placed("mug").modes
    fingers = [world._scene._open.placed(name).modes for name in ("left", "right")]
    gestures = [world._scene._open.gesture(id) for id in world.simulation._gestures.running.values()]
    parts = [mug, *fingers]
    frequency = np.concatenate([[0.0, 0.0], *[each.frequency for each in parts]])
    sigma = np.concatenate([[0.0, 0.0], *[each.decay for each in parts]])
    spring = np.diag((2 * np.pi * frequency) ** 2 + sigma**2)
    damper = np.diag(2 * sigma)
    for n, gesture in enumerate(() if free else gestures):
        contact = contact_of(engine, gesture)
        law, load = SUPPORTS["finger"], float(contact["now"]["load"])
        assert load == pytest.approx(grasp.GRIP, rel=0.1)
        assert [contact[key] for key in ("k", "mu", "a")] == [law.stiffness, law.dissipation, law.exponent]
        rows = np.zeros((3, len(frequency)))
        rows[0, n] = 1.0 / np.sqrt(law.mass)
        both = {"mug": contact["now"]["by_position"], "left": contact["now"]["position"]}
        shape = [at(mug, both["mug"]), at(fingers[n], both["left"])]
        first = 2 + len(mug.frequency) + n * len(fingers[0].frequency)
        b = np.zeros(len(frequency))
        b[n] = 1.0 / np.sqrt(law.mass)
        b[2 : 2 + len(mug.frequency)] = shape[0]
        b[first : first + len(shape[1])] = shape[1]
        k = law.exponent * law.stiffness ** (1 / law.exponent) * load ** (1 - 1 / law.exponent)
        spring += k * np.outer(b, b)
        damper += law.dissipation * load * np.outer(b, b)
    size = len(frequency)
    poles = np.linalg.eigvals(np.block([[np.zeros((size, size)), np.eye(size)], [-spring, -damper]]))
    wanted = [poles[np.argmin(abs(poles.imag - 2 * np.pi * f))] for f in mug.frequency[:MODES]]
    return -np.real(wanted)


def at(modes, position):
    """Return the shapes of modes at a position on the strike path."""
    shapes = modes.along
    place = position * (len(shapes) - 1)
    return np.array([np.interp(place, np.arange(len(shapes)), shape) for shape in shapes.T])


@pytest.fixture(scope="module")
def held():
    """The decays of the mug in the fingers, as they are and as they are expected, and what the finger felt."""
    data, bridge = grasp.gripper(microphones=[(0.0, -0.6, 0.3)])
    felt = stepped(data, bridge, 2.56)
    world = bridge.world
    mug, engine = handle_of(world, "mug"), world._scene._open.engine
    amplitudes = []
    for _ in range(20):
        felt = np.concatenate([felt, stepped(data, bridge, data.time + grasp.STEP)])
        amplitudes.append(np.abs(modal(engine, mug, MODES)[3]))
    decays = -np.polyfit(np.arange(20) * grasp.STEP, np.log(amplitudes), 1)[0]
    expected, free = linear_decays(world), linear_decays(world, free=True)
    felt = np.concatenate([felt, stepped(data, bridge, grasp.ENDS)])
    world.close()
    return decays, expected, free, felt


def test_a_struck_mug_in_the_fingers_rings_as_short_as_their_law_says(held):
    decays, expected, free, _ = held
    assert expected[0] > 5.0 * free[0]
    np.testing.assert_allclose(decays, expected, rtol=0.08)


def test_the_finger_feels_the_touch_the_knock_the_setting_down_and_the_slip_and_then_nothing(held):
    felt = held[3]

    def level(begin, end):
        return np.abs(felt[round(begin * RATE) : round(end * RATE)]).max()

    assert level(0.0, 1.5) == 0.0  # the mug is struck, and the finger is not there
    assert level(1.55, 1.7) > 0.05
    assert level(2.45, 2.53) < 1e-3 * level(2.53, 2.65)  # the knock comes through the finger's own contact
    assert level(3.5, 3.75) < 1e-3 * level(3.75, 3.85)  # and so does the table
    assert level(4.3, 4.6) > 100 * level(4.1, 4.2)
    assert level(4.9, 5.0) < 0.05 * level(4.6, 4.7)
    assert level(5.6, 6.0) < 1e-4 * level(4.6, 4.7)  # the third blow is not felt: the fingers let go


def rolled(**ears):
    """Return the sound of a marble, and its place in each step."""
    data, bridge = grasp.roller(**ears)
    sounds, places = [], []
    for _ in range(round(grasp.PASSED / grasp.STEP)):
        places.append(data.body("marble").xpos.copy())
        sounds.append(bridge.step())
    bridge.world.close()
    return np.concatenate(sounds).astype(float), np.array(places)


def test_a_marble_passes_from_left_to_right():
    sound, places = rolled(listener=grasp.EARS)
    there = places[:, 0]
    left = there < -1.0
    halves = [
        10 * np.log10(np.square(sound[round(a * RATE) : round(b * RATE)]).mean(axis=0))
        for a, b in ((0.3, 0.9), (1.7, 2.3))
    ]
    assert left[:400].all() and there[-400] > 1.0
    assert halves[0][0] > halves[0][1] + 8.0 and halves[1][1] > halves[1][0] + 8.0


def test_the_marbles_sound_arrives_when_and_as_fast_as_its_way_says():
    """The dry sound, shifted by r(t)/c, is what is heard; at a constant delay it is not."""
    where = (0.0, -0.6, 0.3)
    heard, places = rolled(listener=carom.Listener(where, layout="ambisonics"))
    dry, _ = rolled(microphones=[where])
    steps = np.arange(len(places)) * grasp.STEP
    frames = np.arange(len(dry)) / RATE
    distance = np.interp(frames, steps, np.linalg.norm(places - where, axis=1))
    for begin, end in ((0.4, 0.6), (2.0, 2.2)):
        window = slice(round(begin * RATE), round(end * RATE))
        found = [
            alike(np.interp(frames[window], frames + delay, dry[:, 0]), heard[window, 0])
            for delay in (distance / AIR, np.full(len(dry), distance[window].mean() / AIR))
        ]
        assert found[0] > 0.9 > 0.5 > found[1]


def alike(one, other):
    """Return the greatest correlation of two sounds below 3 kHz, for shifts of up to 2 ms."""
    low = [np.fft.irfft(np.fft.rfft(each)[: round(3_000 * len(each) / RATE)], len(each)) for each in (one, other)]
    norm = np.sqrt(np.square(low[0]).sum() * np.square(low[1]).sum())
    return max(np.roll(low[0], shift) @ low[1] for shift in range(-96, 97)) / norm
