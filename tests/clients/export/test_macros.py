"""Macros that are turned live in an export for C: its sound is that of the server's render of the same messages."""

import ctypes
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from tests import needs
from tests.clients.export.make_macros import FRAMES
from tests.clients.export.pages import ENGINE
from tests.clients.export.test_plugins import HERE, STRICT, VENDOR, played

pytestmark = [pytest.mark.slow, needs.without("cc"), needs.linux("a shared library")]


def heard(folder: Path, played: str, frames: int) -> NDArray[np.float32]:
    """Return the sound of the library in a folder that gets messages at their times; AssertionError names a refusal."""
    library = ctypes.CDLL(str(folder / "libcarom.so"))
    library.carom_open.restype = ctypes.c_void_p
    library.carom_answer.restype = ctypes.c_char_p
    baked = (folder / "scene.carom").read_bytes()
    scene = ctypes.c_void_p(library.carom_open(baked, ctypes.c_size_t(len(baked)), 1))
    assert scene, library.carom_answer(None)
    done, sound = 0, np.zeros((frames, library.carom_channels(scene)), np.float32)

    def process(count: int) -> None:
        nonlocal done
        out = sound[done:].ctypes.data_as(ctypes.c_void_p)
        library.carom_process(scene, out, ctypes.c_size_t(count))
        done += count

    for line in played.splitlines():
        time, message = line.split(" ", 1)
        process(max(0, int(48_000 * float(time)) - 960 - done))
        assert library.carom_send(scene, message.encode(), ctypes.c_double(float(time))), (
            message,
            library.carom_answer(scene),
        )
    process(frames - done)
    library.carom_close(scene)
    return sound


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a library, a plug-in, and what both shall sound like, of the engine itself."""
    folder = tmp_path_factory.mktemp("macros")
    subprocess.run([sys.executable, "-m", "tests.clients.export.make_macros", str(folder)], env=ENGINE, check=True)
    subprocess.run(["cc", *STRICT, "-I", VENDOR, HERE / "host.c", "-ldl", "-o", folder / "host"], check=True)
    return folder


def test_macros_turned_live_in_c_sound_as_the_server_s(made: Path) -> None:
    """Every macro of five kinds of body, under blows, rolls, slides and a note, to the bit."""
    wanted = np.fromfile(made / "sound.f32", np.float32).reshape(-1, 2)
    sound = heard(made, (made / "played.txt").read_text(), len(wanted))
    assert np.array_equal(sound, wanted) and sound.any()


def test_macros_that_a_host_automates_sound_as_the_server_s(made: Path) -> None:
    """A plug-in's parameters, set before a blow and swept while it rings, to the bit in blocks of any size."""
    wanted = np.fromfile(made / "plugin.f32", np.float32).reshape(-1, 2)
    for block in (64, 700):
        told = played(made, (made / "events.txt").read_text(), block, FRAMES)
        assert np.array_equal(told.sound, wanted) and wanted.any()
        assert told.lines["allocations"] == ["0"]


def test_a_plugin_of_one_object_stays_small(made: Path) -> None:
    assert (made / "two-of-them.clap").stat().st_size < 2_500_000


def test_a_macro_of_a_body_without_a_table_is_refused_with_a_sentence(folder: Path) -> None:
    """An export of many objects has tables only where its score turns them; the other macros need none."""
    with pytest.raises(AssertionError, match="size of church_bell: this export has no table of it; expected a plug-in"):
        heard(folder, "0.1 /object/church_bell/macro/size 0.6\n", 4_800)
    assert heard(folder, "0.1 /object/church_bell/macro/force 0.6\n", 4_800).shape == (4_800, 2)
