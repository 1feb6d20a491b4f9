"""The modes of presets: kept for equal objects, never more than there is room for, made with BLAS on one thread."""

import threading
from contextlib import ExitStack
from dataclasses import replace

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from carom.dsp import bodies
from carom.presets import Presets, making

PRESETS = Presets()


@pytest.fixture
def kept(monkeypatch):
    kept = making._Kept()
    monkeypatch.setattr(making, "_kept", kept)
    return kept


def arrays(modes):
    return modes.frequency, modes.decay, modes.strike, modes.pickup


def test_equal_objects_share_their_modes_and_others_do_not(kept):
    preset = PRESETS.object("wood-block")
    modes = preset.modes(20_000)
    assert PRESETS.object("wood-block").modes(20_000) is modes
    assert PRESETS.object("wood-block").replace(level=-3, velocity=2).modes(20_000) is modes
    material = PRESETS.material("steel")
    others = (
        preset.modes(4_000),
        preset.replace(thickness=0.01).modes(20_000),
        replace(preset, material=material).modes(20_000),
        replace(preset, material=replace(preset.material, alpha=1.0)).modes(20_000),
        replace(preset, pickups=(0.1, 0.2)).modes(20_000),
    )
    assert len({other.pickup.tobytes() + other.decay.tobytes() for other in (*others, modes)}) == 6


@pytest.mark.parametrize("name", ["cymbal", "tom", "bass-string", "church-bell", "wine-glass", "tubular-bell"])
def test_kept_modes_are_those_of_the_shape_and_cannot_be_changed(kept, name):
    preset = PRESETS.object(name)
    arguments = dict(preset.geometry) | ({"material": preset.material} if preset.shape != "listed" else {})
    arguments |= {"pickups": preset.pickups} if preset.pickups else {}
    expected = getattr(bodies, preset.shape)(top=6_000, **arguments)
    for _ in range(2):
        for array, other in zip(arrays(preset.modes(6_000)), arrays(expected), strict=True):
            assert array.tobytes() == other.tobytes()
            with pytest.raises(ValueError, match="read-only"):
                array[...] = 0.0


def test_the_modes_used_last_are_kept_as_far_as_they_fit(kept, monkeypatch):
    def modes(values):
        return bodies.Modes(np.ones(1), np.ones(1), np.ones((values - 4, 1)), np.ones((2, 1)), 1.0)

    monkeypatch.setattr(making, "KEPT_BYTES", 8 * 30)
    for key in "abc":
        kept.put(key, modes(10))
    first = kept.get("a")
    kept.put("d", modes(10))
    assert [kept.get(key) is not None for key in "abcd"] == [True, False, True, True]
    kept.put("a", modes(10))  # another thread made the same
    assert kept.get("a") is first
    kept.put("e", modes(31))
    assert not any(kept.get(key) for key in "abcde")
    kept.put("f", modes(30))
    assert kept.get("f")


def blas_threads():
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def test_blas_has_one_thread_until_the_last_user_goes():
    with threadpool_limits(2, "blas"):
        before = blas_threads()
        first, second = ExitStack(), ExitStack()
        first.enter_context(making._blas.on_one_thread())
        second.enter_context(making._blas.on_one_thread())
        first.close()
        assert blas_threads() == {1}
        second.close()
        assert blas_threads() == before
        with pytest.raises(ZeroDivisionError), making._blas.on_one_thread():
            raise ZeroDivisionError
        assert blas_threads() == before


def test_threads_make_modes_at_once(kept, monkeypatch):
    names = ["steel-plate", "tuning-fork", "iron-pan", "marimba-bar"]
    expected = {name: arrays(PRESETS.object(name).modes(10_000)) for name in names}
    monkeypatch.setattr(making, "_kept", making._Kept())
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
        assert [array.tobytes() for array in each] == [array.tobytes() for array in expected[name]]
