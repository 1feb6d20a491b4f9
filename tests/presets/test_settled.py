"""Modes of built-in objects: the same bits on every machine, and those that are computed but for roundings."""

import hashlib
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy._core import _multiarray_umath as numpy_core

from carom.dsp.bodies.modes import Modes
from carom.dsp.native import store
from carom.dsp.resonator.bank import top_of
from carom.presets import Presets, settled
from carom.presets.settled import kept, names, settle
from tests.clients.export.pages import ENGINE

KINDS = [
    *("marimba-bar", "table-top", "splash-cymbal", "tom", "drinks-can", "guitar-string", "wine-glass", "steel-ring"),
    *("glass-ball", "church-bell", "mug"),
]
"""One of each shape."""
SCORE = "\n".join(
    ["0 /accuracy -60", "0 /room 8 6 3"]
    + [f"0 /object/new {name.replace('-', '')} {name}" for name in KINDS]
    + [f"{0.02 * n:.2f} /object/{name.replace('-', '')}/impact 1 0.3" for n, name in enumerate(KINDS)]
    + ["0.1 /object/tabletop/roll 0.5 striker glass-marble seed 1", "0.2 /object/marimbabar/bounce 0.05 seed 2"]
)
REMEDY = "`python -m tests.bench.settled modes` writes them anew"


def computed(name: str, monkeypatch: pytest.MonkeyPatch) -> Modes:
    with monkeypatch.context() as own:
        own.setattr(settled, "taken", False)
        return Presets().object(name).modes(top_of(48_000.0))


def sound_of(folder: Path, **own: str) -> str:
    """Return the SHA-256 of the score's sound by portable code, with modes that are computed anew."""
    cache, sound = folder / "cache" / "carom", folder / "sound.wav"
    cache.mkdir(parents=True)
    (cache / "code").symlink_to(store.user_cache(), target_is_directory=True)
    score = folder / "score.txt"
    score.write_text(SCORE, encoding="utf-8")
    run = [sys.executable, "-W", "ignore", "-m", "carom", "render", str(score), str(sound), "--seconds", "0.6"]
    environment = ENGINE | {"XDG_CACHE_HOME": str(cache.parent)} | own
    subprocess.run(run, env=environment, check=True, capture_output=True)
    return hashlib.sha256(sound.read_bytes()).hexdigest()


@pytest.mark.slow
def test_a_score_of_built_in_objects_has_the_same_bits_with_other_libraries(tmp_path: Path) -> None:
    """With four of BLAS's kernels, without fused products in C's functions, and without numpy's vectors."""
    without = {"NPY_DISABLE_CPU_FEATURES": " ".join(numpy_core.__cpu_dispatch__)}
    older = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX2_Usable,-FMA_Usable", **without}
    kernels: dict[str, dict[str, str]] = {"": {}, "Haswell": {}, "Zen": {}, "Nehalem": older}
    found = {
        sound_of(tmp_path / f"with {kernel}", **(own | {"OPENBLAS_CORETYPE": kernel} if kernel else own))
        for kernel, own in kernels.items()
    }
    assert len(found) == 1


@pytest.mark.slow
def test_the_modes_that_are_kept_are_those_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    assert sorted(names()) == Presets().names("objects"), REMEDY
    for name in ("xylophone-bar", "ceramic-tile", "splash-cymbal"):
        found, now = settle(modes := computed(name, monkeypatch)), kept(name)
        assert np.array_equal(found.frequency, now["frequency"]), REMEDY
        scale = np.abs(modes.strike).max(axis=0)
        sign = np.sign((found.strike * modes.strike).sum(axis=0))
        assert np.abs(sign * found.strike - modes.strike).max(initial=0.0, where=scale > 0) < 2e-4 * scale.max(), REMEDY
        assert found.decay == pytest.approx(modes.decay, 1e-4), REMEDY
        assert np.abs(found.pressure) == pytest.approx(np.abs(modes.pressure), 1e-4, 1e-6 * modes.pressure.max()), (
            REMEDY
        )


def test_an_object_of_which_only_level_and_strike_are_changed_has_the_modes_of_its_preset() -> None:
    for name in ("steel-ring", "tom", "xylophone-bar"):
        preset = Presets().object(name)
        assert preset.replace(level=preset.level - 1, velocity=0.5).modes(20_000) is preset.modes(20_000)


def test_modes_of_another_body_are_those_computed() -> None:
    longer = Presets().object("xylophone-bar").replace(length=0.2).modes(top_of(48_000.0))
    assert not np.array_equal(settle(longer).frequency[:4], kept("xylophone-bar")["frequency"][:4])
