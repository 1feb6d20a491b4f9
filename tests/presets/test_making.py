"""The modes of presets: kept for equal objects, never more than there is room for, made with BLAS on one thread."""

import threading
import time
from contextlib import ExitStack
from dataclasses import replace

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from carom.dsp import bodies
from carom.dsp.bodies import Partials
from carom.dsp.bodies.added import Complete
from carom.dsp.bodies.heard import Best
from carom.dsp.kept import Kept
from carom.dsp.numerics.blas import on_one_thread
from carom.presets import Presets, making

PRESETS = Presets()


def fresh():
    return Kept(making.KEPT_BYTES, making._bytes)


@pytest.fixture
def kept(monkeypatch):
    kept = fresh()
    monkeypatch.setattr(making, "_kept", kept)
    return kept


def arrays(modes):
    return modes.frequency, modes.decay, modes.strike, modes.pressure


@pytest.mark.slow
def test_equal_objects_share_their_modes_and_others_do_not(kept):
    preset = PRESETS.object("marimba-bar")
    modes = preset.modes(20_000)
    assert PRESETS.object("marimba-bar").modes(20_000) is modes
    assert PRESETS.object("marimba-bar").replace(level=-3, velocity=2).modes(20_000) is modes
    material = PRESETS.material("steel")
    others = (
        preset.modes(4_000),
        preset.replace(thickness=0.01).modes(20_000),
        replace(preset, material=material).modes(20_000),
        replace(preset, material=replace(preset.material, alpha=7.0)).modes(20_000),
        preset.replace(stereo_width=0.2).modes(20_000),
        replace(preset, added=(Partials(ratio=(1.5,), t60=1.0, level=-9.0),)).modes(20_000),
    )
    assert len({other.pressure.tobytes() + other.decay.tobytes() for other in (*others, modes)}) == 7


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cymbal", "tom", "bass-string", "church-bell", "wine-glass", "tubular-bell"])
def test_kept_modes_are_those_of_the_shape_and_cannot_be_changed(kept, name):
    preset = PRESETS.object(name)
    arguments = dict(preset.geometry) | ({"material": preset.material} if preset.shape != "listed" else {})
    make = getattr(bodies, preset.shape)
    made = (Complete(make, preset.added, preset.written) if preset.added else make)(top=6_000, **arguments)
    expected = Best(preset.stereo_width).of(made)
    for _ in range(2):
        for array, other in zip(arrays(preset.modes(6_000)), arrays(expected), strict=True):
            assert array.tobytes() == other.tobytes()
            with pytest.raises(ValueError, match="read-only"):
                array[...] = 0.0


@pytest.mark.slow
@pytest.mark.parametrize("name", PRESETS.names("objects"))
def test_an_object_is_made_soon_and_its_copy_in_another_process_lies_in_memory_alike(kept, name):
    """An object with what radiates takes a tenth of a second more than its modes alone, here with room for a busy
    machine. Ground truth of data sets, and all else that BLAS computes of modes, has the same bits for a copy."""
    preset = PRESETS.object(name)
    start = time.thread_time()
    modes = preset.modes(22_800)
    assert time.thread_time() - start < 0.8
    assert all(array.flags.c_contiguous for array in (*arrays(modes), *(modes.unheard or ())))


def blas_threads():
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def test_blas_has_one_thread_until_the_last_user_goes():
    with threadpool_limits(2, "blas"):
        before = blas_threads()
        first, second = ExitStack(), ExitStack()
        first.enter_context(on_one_thread())
        second.enter_context(on_one_thread())
        first.close()
        assert blas_threads() == {1}
        second.close()
        assert blas_threads() == before
        with pytest.raises(ZeroDivisionError), on_one_thread():
            raise ZeroDivisionError
        assert blas_threads() == before


@pytest.mark.slow
def test_threads_make_modes_at_once(kept, monkeypatch):
    names = ["steel-plate", "tuning-fork", "iron-pan", "marimba-bar"]
    expected = {name: arrays(PRESETS.object(name).modes(10_000)) for name in names}
    monkeypatch.setattr(making, "_kept", fresh())
    found, before = {}, blas_threads()

    def work(number):
        for name in names[number:] + names[:number]:
            found[number, name] = arrays(PRESETS.object(name).modes(10_000))

    threads = [threading.Thread(target=work, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 16 and blas_threads() == before
    for (_, name), each in found.items():
        for array, other in zip(each, expected[name], strict=True):  # sums may be ordered by where their terms lie
            np.testing.assert_allclose(array, other, rtol=1e-12, atol=1e-15 * np.abs(other).max())
