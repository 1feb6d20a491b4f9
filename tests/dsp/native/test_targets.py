"""Machine code for other systems and processors: made here, of one translation, in the format of each."""

import struct
from ctypes import c_int64

import platformdirs
import pytest

from carom.dsp.native import code, compiling
from carom.dsp.native.images import link
from carom.dsp.native.jit import c_function
from carom.dsp.native.store import Store
from carom.dsp.native.system import clock_ns, flush_denormals, monotonic_ns, pause_ns, restore_denormals, thread_id
from carom.dsp.native.targets import ARM, LEVELS, WHEEL, Target, built, targets
from carom.dsp.native.translation import translator
from carom.dsp.native.units import for_image, optimised

CALLED = {
    "linux": ["clock_gettime", "gettid", "nanosleep"],
    "darwin": ["clock_gettime", "nanosleep"],
    "windows": ["QueryPerformanceCounter", "Sleep"],
}
ELF, MACH_O = b"\x7fELF", 0xFEEDFACF
X86_64, AARCH64 = {ELF: 62, MACH_O: 0x01000007}, {ELF: 183, MACH_O: 0x0100000C}


@c_function(c_int64)
def everything():
    """Return all that differs between systems."""
    mode = flush_denormals()
    pause_ns(1)
    restore_denormals(mode)
    return monotonic_ns() + thread_id()


@pytest.fixture(scope="module")
def source() -> bytes:
    return translator().unit(translator().c_function(everything)).source()


def kind(made: bytes) -> tuple[object, int]:
    """Return the format of machine code, and its processor's number in there."""
    if made.startswith(ELF):
        return ELF, struct.unpack_from("<H", made, 18)[0]
    return struct.unpack_from("<II", made)


@pytest.mark.parametrize("target", WHEEL, ids=str)
def test_code_is_made_for_every_target_of_a_wheel(source, target):
    best = optimised(source, target)
    assert ("fpcr" in str(best)) == (target.processor == ARM) != ("ldmxcsr" in str(best))
    numbers = AARCH64 if target.processor == ARM else X86_64
    container = MACH_O if target.system == "darwin" else ELF
    assert kind(target.machine().emit_object(best)) == (container, numbers[container])
    made = for_image(best, target)
    assert kind(made) == (ELF, numbers[ELF])
    image = link([made], ["everything"])
    assert image.needs == CALLED[target.system] and image.functions.keys() == {"everything"}


def test_a_wheel_is_for_these_systems():
    assert {target.system for target in WHEEL} == set(CALLED)
    assert {target.processor for target in WHEEL} == {ARM, *LEVELS[1:]}


@pytest.mark.slow
def test_functions_of_the_system_run_on_this_machine():
    before = clock_ns()
    assert everything() > before


def test_code_for_another_system_is_kept_beside_and_not_taken(tmp_path, monkeypatch):
    monkeypatch.setattr(platformdirs, "user_cache_path", lambda name: tmp_path / name)
    other = Target("windows" if built()[0].system == "linux" else "linux", LEVELS[1])
    compiling.build(["carom.dsp.native.system"], (other,), tmp_path / "objects")
    ((_, listed),) = Store(tmp_path / "objects").lists("carom.dsp.native.system")
    assert list(listed.units) == [str(other)] and "carom.dsp.native.platforms" in listed.sources
    assert code._found("carom.dsp.native.system", Store(tmp_path / "objects"), "package", targets()) is None
