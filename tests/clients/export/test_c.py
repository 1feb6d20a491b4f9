"""A scene as a library for C: what a plain C compiler makes of it renders the bits, and carries out messages."""

import ctypes
import json
import math
import os
import re
import struct
import subprocess
import sys
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from carom.clients.export import c
from carom.clients.export.scene_file import summed
from carom.dsp.native.code import functions_of
from carom.server.bridge import touching
from carom.server.osc.score import format_line
from carom.server.osc.wire import Message
from tests import needs

from .asking import asking, rules_of
from .tiny import HEAVY

pytestmark = [pytest.mark.slow, needs.without("cc")]

MODULES = ("tests.clients.export.tiny", c.PREFIX), (touching.__name__, c.TRACKER)
"""The modules of the engine and of the tracker, and the beginnings of their names in a library."""

SOURCES = Path(c.__file__).parent / "c"
STRICT = ["-std=c11", "-O1", "-Wall", "-Wextra", "-Werror"]


def run(*words: object, **more: Any) -> "subprocess.CompletedProcess[str]":
    return subprocess.run([*map(str, words)], capture_output=True, text=True, **more)


@pytest.fixture(scope="module")
def example(folder: Path) -> Path:
    """The example, compiled and linked as its page says."""
    made = run("cc", "example.c", "libcarom.a", "-lm", "-o", "example", cwd=folder)
    assert (made.stderr, made.returncode) == ("", 0)
    return folder / "example"


def test_the_example_renders_a_score_to_the_bit(example: Path, folder: Path, tmp_path: Path) -> None:
    """The WAV file of a program in C holds the samples of a render, by the static library and by the shared one."""
    wanted = (folder / "sound.f32").read_bytes()
    shared = folder / "shared"
    run("cc", "example.c", "-L.", "-lcarom", "-Wl,-rpath,.", "-o", shared, cwd=folder, check=True)
    for program in (example, shared):
        run(program, folder / "scene.carom", tmp_path / "made.wav", cwd=folder, check=True)
        made = (tmp_path / "made.wav").read_bytes()
        assert made[:4] == b"RIFF" and struct.unpack("<HHI", made[20:28]) == (3, 2, 48_000)
        assert made[44:] == wanted and any(wanted)


def test_wrong_scenes_and_messages_are_refused_with_a_reason(example: Path, folder: Path, tmp_path: Path) -> None:
    """The example names what is no scene, and the reason of a refusal; a cut or damaged scene is not opened."""
    made = run(example, SOURCES / "carom.h", tmp_path / "a.wav")
    unlike = "expected a scene that was exported with this library\n"
    damaged = "it is damaged: its bytes are not those of its checksum; export the scene anew\n"
    assert made.returncode == 1 and made.stderr.endswith(f"carom.h: {unlike}")
    for words in ("fast", "1 direction 1", "1 point [0 0 0.1] direction [1 0 0]", "1 by church_bell"):
        refused = run(example, folder / "scene.carom", tmp_path / "a.wav", f"/object/church_bell/impact {words}")
        assert refused.returncode == 1 and refused.stderr.count("\n") == 1
        assert any(word in refused.stderr for word in words.split()), refused.stderr
    whole = (folder / "scene.carom").read_bytes()
    for size in (0, 11, 5_000, len(whole) // 2, len(whole) - 8):
        (tmp_path / "cut.carom").write_bytes(whole[:size])
        refused = run(example, tmp_path / "cut.carom", tmp_path / "a.wav")
        assert refused.returncode == 1 and refused.stderr.endswith(("can't be read\n", unlike, damaged)), size
    other = re.sub(rb'"layout":"[0-9a-f]{16}"', b'"layout":"0123456789abcdef"', whole)
    assert len(other) == len(whole) and other != whole  # of an engine whose memory is laid out otherwise: it hung
    (tmp_path / "other.carom").write_bytes(summed(other))
    refused = run(example, tmp_path / "other.carom", tmp_path / "a.wav", timeout=60)
    assert refused.stderr.endswith(f"other.carom: {unlike}")


@pytest.mark.parametrize("target", ["web", "c", "clap"])
def test_an_empty_score_is_refused_before_an_engine_is_compiled(tmp_path: Path, target: str) -> None:
    (tmp_path / "empty.txt").write_text("# nothing yet\n")
    words = [sys.executable, "-m", "carom", "export", "--to", target, "empty.txt", "out"]
    made = run(*words, cwd=tmp_path, env=os.environ | {"XDG_CACHE_HOME": str(tmp_path / "cache")})
    assert made.returncode == 1 and "the score is empty" in made.stderr and made.stderr.count("\n") == 1
    assert not (tmp_path / "cache").exists()


@pytest.mark.parametrize(("target", "compiler", "named"), [("clap", "no-such-cc", "no-such-cc"), ("c", "", "cc")])
def test_a_missing_compiler_is_told_before_an_engine_is_compiled(
    tmp_path: Path, target: str, compiler: str, named: str
) -> None:
    words = [sys.executable, "-m", "carom", "export", "--to", target, "church-bell", "out"]
    own = {"XDG_CACHE_HOME": str(tmp_path / "cache"), "CC": compiler, "PATH": str(tmp_path)}
    made = run(*words, cwd=tmp_path, env=os.environ | own)
    assert made.returncode == 1 and f"carom export: {named}: no such C compiler here" in made.stderr
    assert not (tmp_path / "cache").exists() and not (tmp_path / "out").exists()


def test_the_library_shows_its_own_names_alone(folder: Path) -> None:
    """Programs see the functions of the header, and no other name of the library's."""
    declared = {word.split("(")[0].strip("* ") for word in (SOURCES / "carom.h").read_text().split() if "(" in word}
    wanted = {word for word in declared if word.startswith("carom_")}
    for words, others in (
        (["-g", "libcarom.a"], {each for module, prefix in MODULES for each in _names(module, prefix)}),
        (["-D", "libcarom.so"], set()),
    ):
        told = run("nm", "--defined-only", *words, cwd=folder).stdout
        assert {line.split()[-1] for line in told.splitlines() if " T " in line} == wanted | others, words


def test_messages_become_the_commands_of_a_session(folder: Path, tmp_path: Path) -> None:
    """Messages to the library reach its engine with the values that a session gives them."""
    asked = json.loads((folder / "asked.json").read_text())
    program = tmp_path / "ask"
    made = run("cc", *STRICT, *asking(folder), "-o", program)
    assert (made.stderr, made.returncode) == ("", 0)
    lines = [format_line(0.0, message_of(each)).partition(" ")[2] for each in asked]
    told = run(program, folder / "scene.carom", input="\n".join(lines), check=True).stdout.splitlines()
    fields = rules_of(folder)["command"]["fields"]
    wrong = []
    for each, got in zip(asked, told, strict=True):
        commands = [] if got.startswith("!") else [bytes.fromhex(word) for word in got.split()]
        if len(commands) != len(each["commands"]):
            wrong.append((each["message"], got[:200]))
            continue
        for wanted, command in zip(each["commands"], commands, strict=True):
            found = {name: read(command, *fields[name]) for name in wanted}
            differ = {k: (v, found[k]) for k, v in wanted.items() if not math.isclose(v, found[k], rel_tol=1e-12)}
            wrong += [(each["message"], differ)] if differ else []
    assert len(asked) == 400 and not wrong, f"{len(wrong)} of {len(asked)}: {wrong[:5]}"


def test_a_button_acts_as_it_is_pressed_and_not_as_it_is_let_go(folder: Path, tmp_path: Path) -> None:
    """A program in C sends what control surfaces do to addresses without arguments: 1 is a command, 0 is none."""
    program = tmp_path / "ask"
    run("cc", *STRICT, *asking(folder), "-o", program, check=True)
    held = "/object/church_bell/press 1.0 id hand"
    lines = ["/panic 1", "/panic 1.0", "/panic 0", "/panic 0.0", "/panic", "/panic 2", "/panic on", held,
             "/gesture/hand/stop 0", "/gesture/hand/stop 1.0", "/gesture/a/stop 0", "/gesture/a/stop 1"]  # fmt: skip
    told = run(program, folder / "scene.carom", input="\n".join(lines), check=True).stdout.splitlines()
    kind, kinds = rules_of(folder)["command"]["fields"]["kind"], rules_of(folder)["kinds"]
    commands = [[read(bytes.fromhex(word), *kind) for word in got.split()] for got in told if not got.startswith("!")]
    panic, begin, stop = ([float(kinds[name])] for name in ("PANIC", "GESTURE", "STOP"))
    assert commands == [panic, panic, [], [], panic, begin, [], stop, []]
    refused = [got for got in told if got.startswith("!")]
    assert ["/panic" in got or "argument" in got for got in refused[:2]] == [True, True], refused
    assert len(refused) == 3 and "a: no such gesture" in refused[2]


def test_a_message_is_refused_whole(folder: Path) -> None:
    """The library refuses what is no time, lists that are too long, and lists for which it has no room."""
    library = ctypes.CDLL(str(folder / "libcarom.so"))
    library.carom_open.restype, library.carom_answer.restype = ctypes.c_void_p, ctypes.c_char_p
    baked = (folder / "scene.carom").read_bytes()
    scene = ctypes.c_void_p(library.carom_open(baked, ctypes.c_size_t(len(baked)), 1))

    def told(message: str, at: float = -1.0) -> str:
        taken = library.carom_send(scene, message.encode(), ctypes.c_double(at))
        return "" if taken else library.carom_answer(scene).decode()

    for at in (math.nan, math.inf):
        assert told("/panic", at) == f"at = {at}: expected a time in s"
    assert told("/gain -3 over 1 over 2") == "over = 2: given twice"
    points = "/gain [" + 64 * "-3 " + "] over 1"
    assert "at most 64" in told(points.replace("]", "-3]"))
    assert not told("/panic")
    ring = rules_of(folder)["state"]["ring"]
    lists = next(n for n in range(ring) if told(points))
    assert (lists, next(n for n in range(ring) if told("/panic"))) == divmod(ring - 1, 64)
    library.carom_close(scene)


class Report(ctypes.Structure):
    _fields_ = [
        ("load", ctypes.c_double), ("frames", ctypes.c_longlong),
        *((name, ctypes.c_long) for name in ("contacts", "sounding", "waiting", "dropped", "late", "refused")),
        ("loudest", ctypes.c_double), ("linear", ctypes.c_long),
    ]  # fmt: skip


def test_commands_for_which_the_engine_has_no_room_are_counted(folder: Path) -> None:
    """A batch of more commands than the ring takes: those beyond are left out, and told."""
    library = ctypes.CDLL(str(folder / "libcarom.so"))
    library.carom_open.restype = ctypes.c_void_p
    baked, rules = (folder / "scene.carom").read_bytes(), rules_of(folder)
    size, ring = rules["command"]["size"], rules["state"]["ring"]
    length = int.from_bytes(baked[40:48], "little")
    said, data = json.loads(baked[48 : 48 + length]), baked[48 + length :]
    command, fields = bytearray(size), rules["command"]["fields"]
    struct.pack_into("<q", command, fields["kind"][0], rules["kinds"]["GAIN"])
    struct.pack_into("<d", command, fields["value"][0], 0.5)
    data += bytes(-len(data) % 8)
    at, runs, *_ = said["batches"][-1]
    said["batches"].append([at + 1_024, runs, len(data), ring + 7])
    data += (ring + 7) * bytes(command)
    text = json.dumps(said).encode()
    text += b" " * (-len(text) % 8)
    baked = summed(b"carom 2\n" + bytes(32) + len(text).to_bytes(8, "little") + text + data)
    scene = ctypes.c_void_p(library.carom_open(baked, ctypes.c_size_t(len(baked)), 0))
    report, sound = Report(), (ctypes.c_float * (2 * 4_096))()
    for _ in range(said["frames"] // 4_096 + 1):
        library.carom_process(scene, sound, ctypes.c_size_t(4_096))
    library.carom_report(scene, ctypes.byref(report))
    library.carom_close(scene)
    assert report.refused == 7


def test_what_found_no_room_is_reported(folder: Path) -> None:
    """The message after one that found no room says so, once; the report counts it, and how loud it would have been."""
    library = ctypes.CDLL(str(folder / "libcarom.so"))
    library.carom_open.restype = ctypes.c_void_p
    baked = (folder / "scene.carom").read_bytes()
    scene = ctypes.c_void_p(library.carom_open(baked, ctypes.c_size_t(len(baked)), 1))
    report, sound, told = Report(), (ctypes.c_float * 512)(), []
    for mass in (1.0, HEAVY, HEAVY, 1.0, 1.0):
        message = f"/object/church_bell/impact 1.0 mass {mass} stiffness 1e6".encode()
        told.append(library.carom_send(scene, message, ctypes.c_double(-1.0)))
        library.carom_process(scene, sound, ctypes.c_size_t(256))
    library.carom_report(scene, ctypes.byref(report))
    library.carom_load(scene, 1)
    told.append(library.carom_send(scene, b"/panic", ctypes.c_double(-1.0)))
    library.carom_close(scene)
    assert told == [1, 1, 2, 2, 1, 1]
    assert (report.dropped, report.linear, report.refused) == (2, 2, 0)
    assert math.isclose(report.loudest, 10.0 * math.log10(0.5) - 0.691)


def test_the_program_on_the_page_compiles(folder: Path, tmp_path: Path) -> None:
    """The page's programs are C11 and C++ without a warning."""
    texts = re.findall(r"```c\n(.*?)```", (SOURCES.parents[1] / "export.md").read_text(), re.DOTALL)
    assert len(texts) == 2
    for text, words in product(texts, (["-std=c11", "-x", "c"], ["-std=c++17", "-x", "c++"])):
        made = run("cc", *words, "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-I", folder, "-", input=text)
        assert "cc1plus" in made.stderr or (made.stderr, made.returncode) == ("", 0), words


def _names(module: str, prefix: str) -> set[str]:
    return {f"{prefix}{each.py_func.__name__}" for each in functions_of(module)}


def message_of(each: dict[str, Any]) -> Message:
    address, *args = each["message"]
    return Message(address, tuple(args))


def read(command: bytes, place: int, whole: int) -> float:
    """Return a field of a command's bytes."""
    return float(struct.unpack_from("<q" if whole else "<d", command, place)[0])
