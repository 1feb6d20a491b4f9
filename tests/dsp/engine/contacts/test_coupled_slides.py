"""Slides that feel the modes of what they slide on, with what friction does to them: against DOP853, and each other."""

import numpy as np
import pytest

import carom
from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.engine.memory.commands import Command, Kind
from carom.dsp.engine.memory.state import COUPLING, QUANTUM
from carom.dsp.runtime.engine import NOW, Engine
from tests.dsp.engine.contacts.test_coupled_rolls import apart, course, light, pane, reference
from tests.dsp.engine.contacts.test_coupling import modal
from tests.dsp.engine.support import bell, gesture, numbered, steer, strike

RATE = 48_000
LAW = (0.02, 3e6, 0.5, 1.5)
LAID = 0.02 * RATE  # samples: time constant with which a striker is laid on
SLIDE = {"speed": 0.3, "sweep": -1.0, "force": 0.2, "radius": 0.02, "patch": 0.0, "static": 0.0, "dynamic": 0.0,
         "stribeck": 1e-3, "tangential": 0.0, "along": 0.0, "seed": 5}  # fmt: skip
RUB = {**SLIDE, "static": 0.5, "dynamic": 0.5, "along": 0.3}
FIRM = (0.001, 3e9, 0.5, 1.5), {**SLIDE, "force": 20.0}
"""A slide that swings on its contact by 1.9 rad in a sample."""
NEARLY_FIRM = (0.001, 1.2e9, 0.5, 1.5)
"""The same by 1.4: without loss no block follows 1.9."""


def sliding(level="-60", body=None, law=LAW, time=0.0, quality=0, **keys):
    """Return an engine in which a slide goes on, and the handle of its object."""
    engine = Engine(RATE)
    handle = engine.add(body or light(), 0.05)
    first = [Command(NOW, Kind.ACCURACY, value=LEVELS.index(level)), Command(NOW, Kind.QUALITY, value=quality)]
    engine.send([*first, gesture("slide", handle, law, time, 7, **{**SLIDE, **keys})])
    return engine, handle


def slide_of(engine):
    return next(each for each in numbered(engine) if each["gesture"] == 7)


def rubbed(keys):
    """Return the share of a slide's force that its friction is, by the time (s) since it was laid on."""
    return lambda t: keys["along"] * keys["dynamic"] * (1.0 - (1.0 - 1.0 / LAID) ** (t * RATE))


def pushes(engine, quanta):
    """Return the force (N) beyond the weight in the last samples of so many quanta."""
    found = []
    for _ in range(quanta):
        engine.process(QUANTUM)
        found.append(slide_of(engine)["forces"].copy())
    return np.array(found)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("level", "law", "keys", "bound"),
    [
        ("-50", LAW, SLIDE, -110), ("-60", LAW, SLIDE, -120), ("exact", LAW, SLIDE, -140), ("-50", *FIRM, -70),
        ("-60", *FIRM, -70), ("exact", *FIRM, -120), ("-50", LAW, RUB, -65), ("exact", LAW, RUB, -65),
    ],
)  # fmt: skip
def test_a_slide_and_the_modes_that_it_moves_against_dop853(level, law, keys, bound):
    """A body on an object that is as light, 20 ms, without friction and with it: the normal force feels what that
    does. At -50 and -60 blocks follow it."""
    engine, handle = sliding(level, law=law, time=3.25, **keys)
    (frequency, sigma, phi), states, times, ahead = course(engine, handle, 15)
    right = reference(frequency, sigma, lambda s: phi, times, law, keys, rubbed=rubbed(keys))
    assert engine.stats.coupled == 1
    assert ahead[-1] == (level != "exact")
    assert apart(states @ phi, right @ phi) < bound


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("body", [light(), light(1e-3), light(0.05, 60.0), bell(24, modal_mass=0.5), pane(0.5)])
def test_a_slide_over_a_flat_object_pushes_with_its_force(level, body):
    engine, _ = sliding(level, body, roughness=0.0, along=0.0)
    found = np.abs(pushes(engine, 75))
    assert engine.stats.coupled == 1
    assert found.max() < 1e-5 * SLIDE["force"]


@pytest.mark.parametrize("keys", [SLIDE, RUB])
def test_a_slide_feels_a_blow_on_its_object(keys):
    """The normal force changes while the object swings. At quality 1 that is a dashpot, and it does not."""
    swings = {}
    for quality in (0, 1):
        engine, handle = sliding(quality=quality, roughness=0.0, **keys)
        engine.process(100 * QUANTUM)
        still = np.std(pushes(engine, 10))
        strike(engine, handle, velocity=0.05)
        swings[quality] = np.std(pushes(engine, 10)[1:])
        assert still < 1e-3 * keys["force"]
    assert swings[0] > 0.1 * keys["force"] > 100.0 * swings[1]


@pytest.mark.parametrize(("along", "law", "force"), [(0.0, LAW, 0.2), (0.3, LAW, 0.2), (0.0, NEARLY_FIRM, 20.0)])
def test_a_slide_over_a_flat_object_gives_it_no_energy(along, law, force):
    """Nothing is lost but by friction at a crawl: the energy of a ringing object, body and contact never grows."""
    m, k, _, a = law
    engine, handle = sliding(body=light(0.05, 1e6), law=(m, k, 0.0, a), roughness=0.0, speed=1e-10, static=0.5,
                             dynamic=0.5, along=along, force=force)  # fmt: skip
    engine.process(10 * QUANTUM)
    strike(engine, handle, velocity=0.02)
    engine.process(10 * QUANTUM)  # the striker leaves slowly: the slide may throw the object after it
    energies = []
    for _ in range(150):
        engine.process(QUANTUM)
        z, contact = modal(engine, handle, 4)[3], slide_of(engine)["coupled"]
        x, v = contact["motion"][0], contact["v"]
        stored = k * max(x, 0.0) ** (a + 1) / (a + 1)
        energies.append(0.5 * np.sum(np.abs(z) ** 2) + 0.5 * m * v * v + stored - force * x)
        assert engine.state["objects"]["ahead"][0, handle.slot] == 1
    energies = np.array(energies) + a / (a + 1) * force * (force / k) ** (1 / a)  # 0 at rest
    assert np.max(energies - np.minimum.accumulate(energies)) < 1e-5 * energies[0]


@pytest.mark.parametrize(
    "keys", [{}, {"along": 0.3}, {"along": 0.3, "tangential": 1e6}, {"along": 0.0, "law": FIRM[0], "force": 20.0}]
)
def test_no_bit_of_a_slide_depends_on_the_block_size(keys):
    found = []
    for size in (QUANTUM, 1000, 37):
        engine, handle = sliding(**{**RUB, **keys, "travel": 0.1, "position": 0.2})
        strike(engine, handle, time=2_000.25, velocity=0.3)
        sound = np.concatenate([engine.process(size) for _ in range(8_000 // size + 1)])
        found.append(sound[:8_000])
        assert engine.stats.faults == 0
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_array_equal(found[0], found[2])


@pytest.mark.slow
@pytest.mark.parametrize("later", [0, 5])
def test_steered_friction_is_as_loud_as_by_dop853(later):
    """Friction that comes a sample late drives the swings of what slides on modes that are 50 times as light as it, by
    16 dB, but where the object is a dashpot: also if it begins quanta later than the slide."""
    law, keys = (0.015, 1.56e9, 2.0, 1.5), {**RUB, "static": 0.35, "dynamic": 0.35, "along": 1.0, "force": 0.147}
    engine, handle = sliding(body=bell(8, modal_mass=8 * law[0] / 50), law=law, time=3.25, **{**keys, "along": 0.0})
    engine.process(later * QUANTUM)
    assert later == 0 or slide_of(engine)["solver"] == COUPLING
    engine.send([steer(7, "along", 1.0, later * QUANTUM + 4.0)])
    (frequency, sigma, phi), states, times, _ = course(engine, handle, 60, modes=8)
    right = reference(frequency, sigma, lambda s: phi, times, law, keys, rubbed=rubbed(keys), within=1e-5)
    assert slide_of(engine)["solver"] != COUPLING
    levels = [10 * np.log10((np.abs(each[20:]) ** 2).sum()) for each in (states, right)]
    assert abs(levels[0] - levels[1]) < 1.5
    engine.send([steer(7, "along", 0.0)])
    engine.process(2 * QUANTUM)
    assert slide_of(engine)["solver"] == COUPLING


@pytest.mark.slow
def test_a_steered_force_is_as_loud_as_by_dop853():
    """A body that is pressed on 12 times as much swings faster, so that its friction comes too late for that; when it
    is let go it feels the modes again, not before its force has fallen."""
    law, keys = (0.015, 1.56e9, 2.0, 1.5), {**RUB, "static": 0.35, "dynamic": 0.35, "along": 1.0, "force": 0.0125}
    engine, handle = sliding(body=bell(8, modal_mass=8 * law[0] / 50), law=law, time=3.25, **keys)
    engine.process(QUANTUM)
    assert slide_of(engine)["solver"] == COUPLING
    engine.send([steer(7, "force", 0.147)])
    states, times, forces = [], [], []
    for _ in range(150):
        engine.process(QUANTUM)
        frequency, sigma, phi, z = modal(engine, handle, 8)
        states.append(z)
        times.append((engine.position - 1 - 3.25) / RATE)
        forces.append(law[0] * engine.state["rolls"]["g"][0, slide_of(engine)["roll"]])
    assert slide_of(engine)["solver"] != COUPLING
    keys["force"] = lambda t: np.interp(t, times, forces)
    right = reference(frequency, sigma, lambda s: phi, np.array(times), law, keys, rubbed=rubbed(keys), within=1e-5)
    levels = [10 * np.log10((np.abs(each[90:]) ** 2).sum()) for each in (np.array(states), right)]
    assert abs(levels[0] - levels[1]) < 1.5
    engine.send([steer(7, "force", 0.0125)])
    engine.process(75 * QUANTUM)
    assert slide_of(engine)["solver"] != COUPLING
    engine.process(375 * QUANTUM)
    assert slide_of(engine)["solver"] == COUPLING


def test_steered_friction_chooses_at_the_same_time_in_any_block_and_takes_no_room_for_good():
    """The friction of a slide that travels is steered to and fro: it feels the modes, or it does not."""
    steers = [("along", 0.9, 2_000.0), ("along", 0.0, 5_000.0), ("static", 0.9, 5_500.0), ("along", 0.5, 6_000.0)]
    keys = {**RUB, "law": (0.015, 1.56e9, 2.0, 1.5), "force": 0.147, "along": 0.0, "static": 0.35, "dynamic": 0.35}
    found = []
    for size in (QUANTUM, 1000, 37):
        engine, _ = sliding(body=bell(24, modal_mass=2.4e-3), travel=0.1, position=0.2, **keys)
        engine.send([steer(7, *each) for each in steers])
        sound, rooms = [], []
        for _ in range(9_000 // size + 1):
            sound.append(engine.process(size))
            coupled = slide_of(engine)["solver"] == COUPLING
            rooms.append((coupled, engine.stats.coupled_modes == (slide_of(engine)["modes"] if coupled else 0)))
        found.append(np.concatenate(sound)[:9_000])
        assert all(fits for _, fits in rooms) and len({coupled for coupled, _ in rooms}) == 2
        assert engine.stats.coupled == 2 and engine.stats.faults == 0
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_array_equal(found[0], found[2])


@pytest.mark.parametrize("key", ["static", "dynamic", "along"])
def test_a_slide_that_is_steered_at_once_is_one_that_begins_so(key):
    """Whichever value of its friction is the one that lets it feel the modes no more; heard is the same surface."""
    heard = []
    for at_once in (False, True):
        keys = {**RUB, "law": (0.015, 1.56e9, 2.0, 1.5), "force": 0.147, "along": 0.5, "static": 0.0, "dynamic": 0.0}
        keys["static"], given = (0.7, 0.0) if key == "along" else (0.0, keys[key])
        keys[key] = given if at_once else 0.7
        engine, _ = sliding(body=bell(8, modal_mass=2.4e-3), **keys)
        if at_once:
            engine.send([steer(7, key, 0.7)])
        heard.append(engine.process(40 * QUANTUM)[:, 0])
        assert slide_of(engine)["solver"] != COUPLING
    np.testing.assert_allclose(heard[1], heard[0], rtol=0, atol=1e-6 * np.abs(heard[0]).max())


SOUNDS = {
    "tin-lid": {}, "plastic-cup": {}, "frame-drum": {}, "ceramic-bowl": {}, "wood-board": {},
    "glass-plate": {"striker": "chalk"}, "aluminium-pipe": {"striker": "knife", "speed": 0.7},
}  # fmt: skip
"""Slides of objects: some without friction, some of which it is a part."""
STRONG = (
    (48_000, "glass-plate", {}), (48_000, "steel-plate", {"force": 20.0}), (48_000, "tin-lid", {"force": 0.2}),
    (48_000, "polycarbonate-sheet", {"force": 1.0}), (48_000, "plastic-cup", {"force": 0.5}),
    (96_000, "plastic-cup", {}),
)  # fmt: skip
"""Slides at a rate: three so firm that a contact swings by 1.5 to 3 rad in a sample, and three whose contact loses 2
to 17 times its speed in one."""


def heard(name, accuracy, seconds, rate=RATE, **keys):
    """Return the left channel of an object's slide."""
    with carom.Scene(rate, limiter=False) as scene:
        scene.accuracy(accuracy)
        scene.new("a", name, stereo_width=0).slide(seed=1, **keys)
        return scene.render(seconds).samples[:, 0].astype(float)


@pytest.mark.slow
@pytest.mark.parametrize(("rate", "name", "keys"), [*((RATE, *each) for each in SOUNDS.items()), *STRONG])
def test_sounds_of_slides_are_as_exact_as_was_asked_for(rate, name, keys):
    """The first 20 ms, beside `exact`."""
    right = heard(name, "exact", 0.02, rate, **keys)
    for level in (-50, -60):
        found = heard(name, str(level), 0.02, rate, **keys)
        assert apart(found, right) < level


@pytest.mark.slow
@pytest.mark.parametrize("name", ["glass-plate", "wood-board", "frame-drum"])
def test_steady_slides_are_as_loud_as_at_exact(name):
    """Third octaves that are heard, within 1 dB."""
    levels = []
    for accuracy in ("exact", "-60", "-50"):
        sound = heard(name, accuracy, 0.3, **SOUNDS[name])[4_800:]
        power = np.abs(np.fft.rfft(sound * np.hanning(len(sound)))) ** 2
        edges = 1_000.0 * 2.0 ** ((np.arange(-6, 13) - 0.5) / 3)
        bands = np.searchsorted(np.fft.rfftfreq(len(sound), 1 / RATE), edges)
        levels.append(10 * np.log10(np.add.reduceat(power, bands)[:-1]))
    loud = levels[0] > levels[0].max() - 50.0
    assert all(np.abs(each - levels[0])[loud].max() < 1.0 for each in levels)


@pytest.mark.slow
@pytest.mark.parametrize("material", ["rubber", "polycarbonate"])
def test_roll_beside_a_slide_as_stiff_is_as_accurate_as_asked(material):
    """A weight rolls on a sheet that something as stiff slides on: at `exact` no force is held."""
    found = []
    for accuracy in ("exact", "-60"):
        with carom.Scene(22_050, limiter=False) as scene:
            scene.accuracy(accuracy)
            size = {"length": 0.5, "width": 0.4, "thickness": 0.002, "most_modes": 16}
            sheet = scene.new("a", "glass-plate", stereo_width=0, material=material, **size)
            sheet.roll(seed=1, mass=0.58, stiffness=7e6, radius=0.026, surface="concrete", speed=0.29, position=0.8)
            sheet.slide(
                seed=1, mass=0.016, stiffness=2e9, radius=0.002, surface="boards", speed=1.9, force=11.5, position=0.23
            )
            made = scene.render(0.005)
        assert made.report.steps_held == 0
        found.append(made.samples[:, 0].astype(float))
    assert apart(found[1], found[0]) < -60
