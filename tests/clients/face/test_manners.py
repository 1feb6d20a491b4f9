"""Manners of the Python face: sounds that are cut and added, objects that say what they are, errors of one base."""

import pickle
import threading
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

import carom


@pytest.fixture(scope="module")
def sound():
    with carom.Scene(contacts=True, stems=True) as scene:
        bar = scene.new("bar", "marimba-bar", pan=0.5)
        bar.impact(1.0, at=Fraction(1, 100))
        return scene.render(Fraction(1, 4))


def test_a_slice_is_the_sound_from_there_on(sound):
    cut = sound[240:960]
    assert cut.shape == (720, 2) and cut.start == 240 / 48_000 and cut.duration == 0.015
    assert (cut.samples == sound.samples[240:960]).all() and (cut.stems["bar"] == sound.stems["bar"][240:960]).all()
    (contact,) = cut.contacts
    assert contact.first == sound.contacts[0].first - 240 and not sound[960:].contacts
    for bad in (3, slice(0, 10, 2)):
        with pytest.raises(TypeError, match="expected a slice of frames"):
            sound[bad]


def test_sounds_add_up(sound):
    both = sound + sound[:100]
    np.testing.assert_array_equal(both.samples[:100], 2 * sound.samples[:100])
    np.testing.assert_array_equal(both.samples[100:], sound.samples[100:])
    with pytest.raises(carom.CaromError, match="expected sounds of one rate"):
        sound + sound.mono


def test_mono_is_the_mean_and_resampled_is_the_same_tone(sound):
    np.testing.assert_allclose(sound.mono.samples[:, 0], sound.samples.mean(axis=1), atol=1e-7)
    other = sound.resample(44_100)
    assert other.rate == 44_100 and other.duration == pytest.approx(sound.duration, abs=1 / 44_100)
    spectra = [np.abs(np.fft.rfft(each.mono.samples[:, 0], each.rate)) for each in (sound, other)]
    assert spectra[0][:8_000].argmax() == spectra[1][:8_000].argmax()
    assert spectra[1].max() / 44_100 == pytest.approx(spectra[0].max() / 48_000, rel=0.01)
    np.testing.assert_array_equal(sound.resample(np.int64(44_100)).samples, other.samples)
    for bad in (0, 16_000.0):
        with pytest.raises(carom.CaromError, match=f"rate = {bad}: expected a whole number from 8000"):
            sound.resample(bad)


def test_things_say_what_they_are(sound):
    assert repr(sound).startswith("<carom.Sound 0.25 s, 48000 Hz, channels 2, peak 0.")
    scene = carom.Scene(channels=1)
    scene.new("bar", "marimba-bar")
    assert repr(scene) == "<carom.Scene 48000 Hz, channels 1, at 0 s, objects 1>"
    scene.close()
    assert repr(scene) == "<carom.Scene closed>"
    assert repr(carom.World()) == "<carom.World 48000 Hz, at 0 s, bodies 0>"


def test_a_scene_is_for_one_thread_at_a_time():
    scene = carom.Scene()
    with scene._alone("render"):
        errors = []

        def strike():
            for act in (lambda: scene.new("bar", "marimba-bar"), lambda: scene.render(0.1)):
                try:
                    act()
                except carom.CommandError as error:
                    errors.append(str(error))

        thread = threading.Thread(target=strike)
        thread.start()
        thread.join()
    assert [each.split(":")[0] for each in errors] == ["/object/new", "render"]
    assert all("another thread is at work in this scene" in each for each in errors)
    scene.new("bar", "marimba-bar")


def test_a_world_says_why_it_is_not_pickled():
    with pytest.raises(TypeError, match="a World is an engine at work: it cannot be copied or pickled"):
        pickle.dumps(carom.World())


def test_a_misspelt_density_is_asked_for():
    with pytest.raises(carom.WorldError, match=r"^body ball: densty = 3: did you mean density\?$"):
        carom.World().body("ball", "sphere", 0.1, "steel", densty=3)


def test_errors_have_one_base_and_dir_is_public():
    errors = [getattr(carom, name) for name in carom.__all__ if name.endswith("Error")]
    assert len(errors) > 5 and all(issubclass(each, carom.CaromError) for each in errors)
    assert {name for name in dir(carom) if not name.startswith("__")} == {*carom.__all__} - {"__version__"}


def test_fractions_and_decimals_are_numbers_as_others_are():
    heard = []
    for kind in (float, Fraction, Decimal):
        with carom.Scene() as scene:
            bar = scene.new("bar", "marimba-bar", length=kind("0.25"), gains=[kind("0.5"), kind("1")])
            bar.impact(kind("0.5"), position=kind("0.375"), at=kind("0.125"), mass=kind("0.0625"))
            scene.gain("bar", kind("-3"), over=kind("0.5"))
            heard.append(scene.render(kind("0.5")).samples)
    for each in heard[1:]:
        np.testing.assert_array_equal(each, heard[0])
    made = [carom.World() for _ in range(2)]
    for world, kind in zip(made, (float, Fraction), strict=True):
        world.body("ball", "sphere", kind("0.25"), "steel", mass=kind("0.5"), inertia=[kind("0.5")] * 3)
    assert made[0].simulation.bodies[0].mass == made[1].simulation.bodies[0].mass == 0.5


def test_errors_are_of_one_class_and_go_to_other_processes():
    with carom.Scene() as scene:
        bar = scene.new("bar", "marimba-bar")
        for wrong in (
            lambda: scene.render(-1),
            lambda: scene.render(frames=0.5),
            lambda: scene.render(),
            lambda: bar.modes(2),
            lambda: scene.render(0.1).pressure,
            lambda: carom.Presets().object("marimba-baa"),
        ):
            with pytest.raises(carom.CaromError) as caught:
                wrong()
            assert isinstance(caught.value, ValueError)
            assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)
