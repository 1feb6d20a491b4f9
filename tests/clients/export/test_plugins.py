"""A scene as a plug-in: hosts of CLAP, VST3 and LV2 hear the bits of a render, and of each other."""

import os
import platform
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from carom.clients.commands.export import PLUGINS, read_scene
from carom.clients.export import plugins
from carom.clients.export.instruments import MACROS
from carom.presets import Presets
from carom.server.osc.score import ScoreError, parse
from tests import needs
from tests.clients.export import lv2_host
from tests.clients.export.conftest import TINY
from tests.clients.export.lv2_host import Midi
from tests.clients.export.make_plugin import FRAMES, RATE
from tests.clients.export.pages import ENGINE

pytestmark = [
    pytest.mark.slow,
    needs.without("cc"),
    needs.linux("a plug-in's format"),
]

HERE = Path(__file__).parent
VENDOR = Path(plugins.__file__).parent / "vendor"
STRICT = ["-std=c11", "-Wall", "-Wextra", "-Werror"]


class Told(NamedTuple):
    """A host's findings by their first word, the state that it saved, and the sound."""

    lines: dict[str, list[str]]
    state: str
    sound: "np.ndarray[tuple[int, int], np.dtype[np.float32]]"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a plug-in, events, what they shall sound like, and the host."""
    folder = tmp_path_factory.mktemp("plugin")
    subprocess.run([sys.executable, "-m", "tests.clients.export.make_plugin", folder, TINY], env=ENGINE, check=True)
    subprocess.run(["cc", *STRICT, "-I", VENDOR, HERE / "host.c", "-ldl", "-o", folder / "host"], check=True)
    return folder


def played(
    folder: Path, events: str, block: int = 700, frames: int = 2_000, rate: int = RATE, state: str | None = None
) -> Told:
    """Return the findings of a host that plays events; block: the most frames at once."""
    words = ["./host", "./two-of-them.clap", "carom.two-of-them.bell", rate, frames, block, "out.f32"]
    if state is not None:
        (folder / "state").write_text(state)
        words.append("state")
    done = subprocess.run([*map(str, words)], cwd=folder, input=events, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    said, _, saved = done.stdout.partition("state\n")
    lines: dict[str, list[str]] = {}
    for line in said.splitlines():
        word, _, rest = line.partition(" ")
        lines.setdefault(word, []).append(rest)
    return Told(lines, saved, np.fromfile(folder / "out.f32", np.float32).reshape(-1, 2))


@pytest.mark.parametrize("block", [1, 64, 700, 4_096])
def test_a_host_hears_the_bits_of_a_render(made: Path, block: int) -> None:
    """Notes, expressions and macros sound to the bit as their score does, in blocks of any size, without an
    allocation; the host learns which notes have ended."""
    wanted = np.fromfile(made / "sound.f32", np.float32).reshape(-1, 2)
    told = played(made, (made / "played.txt").read_text(), block, FRAMES)
    assert np.array_equal(told.sound, wanted) and wanted.any()
    assert told.lines["allocations"] == ["0"]
    ends = told.lines["end"]
    assert ends[1:] == ["12000 61 8 1", "21000 60 9 0", "21500 83 3 5"]
    assert ends[0].endswith(" 60 7 0") and 7_001 <= int(ends[0].split()[0]) <= 9_000  # released, and all is silent


def test_a_plugin_says_what_it_is(made: Path) -> None:
    """A scene's objects are instruments of sixteen parameters, whose texts read back, at the rates that were baked."""
    told = played(made, "").lines
    names = [line.split("|")[:2] for line in told["plugin"]]
    assert names == [["carom.two-of-them.bell", "Carom bell"], ["carom.two-of-them.block", "Carom block"]]
    assert [line.split("|")[0] for line in told["param"]] == [
        "Position", "Striker", "Tune", "Decay", "Damp", "Release damp", "Gain", "Pan", "Size", "Material",
        "Brightness", "Damping", "Hardness", "Force", "Place", "Roughness",
    ]  # fmt: skip
    for line in told["param"]:
        _, _, high, _, _, back = line.split("|")
        assert float(back) == float(high)
    assert told["ports"] == ["2 stereo 7"] and told["latency"] == ["127"]
    assert played(made, "", rate=44_100).lines["latency"] == ["127"]


def test_a_state_is_kept(made: Path) -> None:
    """Parameters that are set before a plug-in is active are saved, read again, and heard as if they were set; what is
    no state is refused."""
    asked = "-1 param 0 0.3\n-1 param 1 7\n-1 param 2 3.25\n-1 param 6 -6.1\n-1 param 7 5\n"
    notes = "10 on 60 0.5 1 0\n500 on 64 0.5 2 0\n"
    first = played(made, asked + notes)
    assert "Tune=3.25\n" in first.state and "Pan=1\n" in first.state and "Gain=-6.0999999999999996\n" in first.state
    again = played(made, notes, state=first.state)
    assert again.lines["loaded"] == ["1 1"] and again.state == first.state
    assert np.array_equal(again.sound, first.sound)
    assert not np.array_equal(played(made, notes).sound, first.sound)
    for wrong in ("", "carom 2\n", first.state[:5]):
        assert played(made, notes, state=wrong).lines["loaded"] == ["0 0"]
    unknown = "carom 1\nColour=3\nTune=99\nStriker=nobody\nno line"
    assert "Tune=24\n" in played(made, "", state=unknown).state


OLD_STATE = "carom 1\nPosition=0.25\nStriker=yarn\nTune=3.25\nDecay=2\nDamp=0\nRelease damp=0.5\nGain=-6\nPan=1\n"
"""A state that a plug-in saved before it had macros."""


def test_a_state_without_macros_loads_and_leaves_them_in_the_middle(made: Path) -> None:
    """A project that was saved before plug-ins had macros sounds as it did; a macro that is turned is heard."""
    notes = "10 on 60 0.5 1 0\n"
    asked = "-1 param 0 0.25\n-1 param 2 3.25\n-1 param 3 2\n-1 param 5 0.5\n-1 param 6 -6\n-1 param 7 1\n"
    striker = plugins_strikers().index("yarn")
    old = played(made, notes, state=OLD_STATE)
    assert old.lines["loaded"] == ["1 1"] and "Striker=yarn\n" in old.state and "Size=0.5\n" in old.state
    assert np.array_equal(played(made, f"{asked}-1 param 1 {striker}\n{notes}").sound, old.sound)
    for macro in range(8, 15):  # the last one, roughness, is of rolls and slides
        assert not np.array_equal(played(made, f"5 param {macro} 0.7\n{notes}", state=OLD_STATE).sound, old.sound)


def plugins_strikers() -> list[str]:
    return [plugins.OWN_STRIKER, *Presets().names("strikers")]


def test_a_reset_begins_anew(made: Path) -> None:
    """Notes make the same sound after a reset as at first."""
    notes = "10 on 60 0.5 1 0\n500 midi 144 62 90\n700 express 2 1 60 1 0\n"
    later = "".join(f"{int(line.split()[0]) + 1_000} {line.split(' ', 1)[1]}\n" for line in notes.splitlines())
    told = played(made, f"{notes}1000 reset\n{later}", block=300)
    assert np.array_equal(told.sound[:1_000], told.sound[1_000:]) and told.sound.any()


def test_an_expression_that_is_no_number_changes_nothing(made: Path) -> None:
    """A host's volume, tuning or pressure of NaN is passed over: it silenced the note."""
    note = "10 on 60 0.5 1 0\n"
    wrong = "".join(f"{500 + n} express {n} nan 60 1 0\n" for n in range(7))
    assert np.array_equal(played(made, note + wrong).sound, played(made, note).sound)


def test_a_note_whose_velocity_is_no_number_takes_no_body(made: Path) -> None:
    """A host's note of NaN is passed over: it ended the note that rang, and took its body."""
    note, later = "10 on 60 0.5 1 0\n", "900 express 2 1 60 1 0\n"
    told, wanted = (played(made, note + wrong + later) for wrong in ("500 on 72 nan 2 0\n", ""))
    assert np.array_equal(told.sound, wanted.sound) and told.lines.get("end") == wanted.lines.get("end")


def test_channels_of_mpe_bend_far_and_follow_their_manager(made: Path) -> None:
    """A member's bend is of 48 semitones once its zone is laid out, and of two before; the manager's is added; a
    registered parameter sets the range."""
    note, zone = "10 midi 145 60 90\n", "".join(f"0 midi 176 {c} {v}\n" for c, v in ((101, 0), (100, 6), (6, 15)))
    far = f"{zone}{note}50 midi 225 0 96\n"  # half of 48
    tuned = f"{note}50 express 2 %s 60 -1 1\n"
    assert np.array_equal(played(made, far).sound, played(made, tuned % 24).sound)
    near = f"{note}50 midi 225 0 96\n"
    assert np.array_equal(played(made, near).sound, played(made, tuned % 1).sound)
    both = f"{far}900 midi 224 0 0\n"  # the manager's: two down
    assert np.array_equal(played(made, both).sound, played(made, tuned % 24 + "900 express 2 22 60 -1 1\n").sound)
    ranged = "".join(f"0 midi 177 {c} {v}\n" for c, v in ((101, 0), (100, 0), (6, 12))) + near
    assert np.array_equal(played(made, ranged).sound, played(made, tuned % 6).sound)


def controls(sample: int, channel: int, *pairs: tuple[int, int]) -> str:
    return "".join(f"{sample} midi {176 + channel} {number} {value}\n" for number, value in pairs)


ZONE = controls(0, 0, (101, 0), (100, 6), (6, 15))


def test_a_keyboard_for_mpe_that_does_not_say_so_bends_far(made: Path) -> None:
    """It sets a channel up before its note, or plays two channels besides the first at once; one alone does neither."""
    first, second, bent = "10 midi 145 60 90\n", "12 midi 146 64 90\n", "50 midi 225 0 96\n"
    for set_up in ("5 midi 225 0 64\n", "5 midi 209 0\n", controls(5, 1, (74, 64))):
        assert np.array_equal(
            played(made, set_up + first + bent).sound, played(made, ZONE + set_up + first + bent).sound
        )
    both = first + second + bent
    assert np.array_equal(played(made, both).sound, played(made, ZONE + both).sound)
    assert not np.array_equal(played(made, first + bent).sound, played(made, ZONE + first + bent).sound)


def test_a_range_of_bends_on_a_member_is_that_of_its_zone(made: Path) -> None:
    notes = "10 midi 145 60 90\n10 midi 146 64 90\n50 midi 225 0 96\n50 midi 226 0 96\n"
    ranged = ZONE + controls(0, 3, (101, 0), (100, 0), (6, 12)) + notes
    wanted = "10 midi 145 60 90\n10 midi 146 64 90\n50 express 2 6 60 -1 1\n50 express 2 6 64 -1 2\n"
    assert np.array_equal(played(made, ranged).sound, played(made, wanted).sound)


@pytest.mark.parametrize(("zone", "channel"), [("", 0), (ZONE, 1)])
def test_a_pedal_holds_what_is_let_go(made: Path, zone: str, channel: int) -> None:
    """A released key sounds on until the pedal of its channel, or of its zone, comes up; a held one goes on."""
    note, off = f"0 param 5 1\n{zone}10 midi {144 + channel} 60 90\n", f"midi {128 + channel} 60 0\n"
    held, wanted = note + controls(20, 0, (64, 127)) + f"300 {off}", note + f"900 {off}"
    assert np.array_equal(played(made, held + controls(900, 0, (64, 0))).sound, played(made, wanted).sound)
    assert np.array_equal(played(made, held).sound, played(made, note).sound)
    assert not np.array_equal(played(made, wanted).sound, played(made, note).sound)
    kept = note + controls(20, 0, (64, 127)) + controls(300, 0, (64, 0))
    assert np.array_equal(played(made, kept).sound, played(made, note).sound)


def test_an_object_is_a_score_of_its_own() -> None:
    """The name of an object stands for a score that makes it; a name of neither is refused."""
    name, title, content = read_scene("church-bell", Presets())
    assert (name, title) == ("church-bell", "church-bell") and parse(content, name)[0].message.args[1] == "church-bell"
    assert read_scene("demo", Presets())[1] == "demo"
    with pytest.raises(ScoreError, match="no score 'church-bel'"):
        read_scene("church-bel", Presets())


BUNDLES = {
    "clap": "two-of-them.clap",
    "vst3": f"two-of-them.vst3/Contents/{platform.machine()}-linux/two-of-them.so",
    "lv2": "two-of-them.lv2/two-of-them.so",
}
ENTRIES = {
    "clap": ["clap_entry"],
    "vst3": ["GetPluginFactory", "ModuleEntry", "ModuleExit", "clap_entry"],
    "lv2": ["clap_entry", "lv2_descriptor"],
}
SOURCES = {"clap": "plugin.c", "vst3": "vst3.c", "lv2": "lv2.c"}


@pytest.mark.parametrize("form", plugins.FORMATS)
def test_the_sources_compile_without_a_warning(made: Path, form: str) -> None:
    """The sources that are exported make a plug-in by the command that they name, which shows its entries alone."""
    told = (made / SOURCES[form]).read_text().split("*/")[0].partition("\n   cc ")[2]
    words = ["cc", *told.replace("\\\n", " ").split()]
    words[words.index("-o") + 1] = f"own.{form}"
    strict = ["-Wall", "-Wextra", "-Werror"]
    done = subprocess.run([*words, *strict], cwd=made, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    for name in (f"own.{form}", BUNDLES[form]):
        shown = subprocess.run(["nm", "-D", "--defined-only", made / name], capture_output=True, text=True).stdout
        assert sorted(line.split()[-1] for line in shown.splitlines()) == ENTRIES[form]


MIDI: list[Midi] = [
    (100, b"\x90\x3c\x59"), (1_001, b"\x90\x40\x20"), (6_000, b"\x80\x3c\x40"), (7_001, b"\x90\x3c\x7f"),
    (12_800, b"\xe0\x00\x60"), (12_800, b"\xd0\x10"), (12_800, b"\xb0\x40\x7f"), (13_001, b"\x80\x40\x00"),
]  # fmt: skip
"""pedalboard gives controllers at the beginnings of its blocks."""
FRAMES_OF_MIDI = 16_000
CONTROLS = (0.25, 2.0, -6.0, 1.0, 0.0, 0.5, -27.0, 0.5, 0.75, 0.25, 0.625, 0.375, 0.75, 0.5625, 0.25, 0.75)
"""Of the parameters: shares of their ranges that single precision has."""


def by_clap(made: Path) -> NDArray[np.float32]:
    """Return the sound of MIDI with all parameters set, as the host of CLAP hears it."""
    asked = "".join(f"0 param {n} {value!r}\n" for n, value in enumerate(CONTROLS))
    notes = "".join(f"{at} midi {' '.join(map(str, [*message, 0][:3]))}\n" for at, message in MIDI)
    return played(made, asked + notes, 512, FRAMES_OF_MIDI).sound


@pytest.mark.parametrize("block", [64, 512, 9_000])
def test_a_host_of_lv2_hears_the_bits_of_clap(made: Path, block: int) -> None:
    bell = lv2_host.Plugin(made / BUNDLES["lv2"], 0, RATE)
    assert bell.uri == "urn:carom:two-of-them:bell"
    assert np.array_equal(bell.run(MIDI, CONTROLS, FRAMES_OF_MIDI, block), by_clap(made))
    assert bell.latency.value == 127.0
    bell.close()


def test_lv2_refuses_a_rate_that_the_scene_is_not_baked_for_and_ends_its_list(made: Path) -> None:
    with pytest.raises(ValueError, match="32000"):
        lv2_host.Plugin(made / BUNDLES["lv2"], 0, 32_000.0)
    with pytest.raises(LookupError, match="2"):
        lv2_host.Plugin(made / BUNDLES["lv2"], 2, RATE)


@needs.without("lv2_validate")
@needs.without("sord_validate")
def test_lv2_is_described_as_its_specification_asks(made: Path, tmp_path: Path) -> None:
    bundle = tmp_path / "two-of-them.lv2"
    bundle.symlink_to(made / bundle.name)
    done = subprocess.run(["lv2_validate", *bundle.glob("*.ttl")], capture_output=True, text=True)
    assert done.stdout.startswith("Found 0 errors"), done.stderr
    listed = subprocess.run(
        ["lv2ls"], env={**os.environ, "LV2_PATH": str(tmp_path)}, capture_output=True, text=True, check=True
    )
    assert listed.stdout.split() == ["urn:carom:two-of-them:bell", "urn:carom:two-of-them:block"]


def by_vst3(folder: Path, block: int, state: bytes | None = None) -> tuple[Any, NDArray[np.float32]]:
    """Return the bell as pedalboard loads it, and its sound of MIDI."""
    load = needs.module("pedalboard").load_plugin  # which waits as long as said for silence; there is none
    bell = load(str(folder / "two-of-them.vst3"), plugin_name="Carom bell", initialization_timeout=0.1)
    if state is None:
        for name, value, macro in zip(KEYS, CONTROLS, MACROS, strict=True):
            share = (value - macro.low) / (macro.high - macro.low)
            if share == float(np.float32(share)):  # but for the striker, and Decay, which stays as it is
                bell.parameters[name].raw_value = share
        bell.striker = bell.parameters["striker"].valid_values[int(CONTROLS[1])]
    else:
        bell.raw_state = state
    notes = [(message, (at + 0.5) / RATE) for at, message in MIDI]  # it rounds down
    return bell, np.ascontiguousarray(bell(notes, FRAMES_OF_MIDI / RATE, RATE, 2, block).T)


KEYS = (
    "position", "striker", "tune_semitones", "decay_times", "damp", "release_damp", "gain_db", "pan", "size",
    "material", "brightness", "damping", "hardness", "force", "place", "roughness",
)  # fmt: skip
"""The parameters, as pedalboard calls them."""


@pytest.mark.parametrize("block", [100, 512])
def test_another_s_host_of_vst3_hears_the_bits_of_clap(made: Path, block: int) -> None:
    bell, sound = by_vst3(made, block)
    assert bell.reported_latency_samples == 127 and bell.is_instrument
    assert np.array_equal(sound, by_clap(made)) and sound.any()


def test_a_state_of_vst3_is_kept(made: Path) -> None:
    bell, sound = by_vst3(made, 512)
    again, same = by_vst3(made, 512, state=bell.raw_state)
    assert np.array_equal(same, sound)
    assert [again.parameters[name].raw_value for name in KEYS] == [bell.parameters[name].raw_value for name in KEYS]


@pytest.mark.parametrize("form", plugins.FORMATS)
def test_a_plugin_is_installed_where_hosts_look_for_it(
    made: Path, form: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    for _ in range(2):  # a second time in place of the first
        there = plugins.install(made / f"two-of-them.{form}")
    assert there == tmp_path / f".{form}" / f"two-of-them.{form}"
    wanted = (made / BUNDLES[form]).read_bytes()
    assert (tmp_path / f".{form}" / BUNDLES[form]).read_bytes() == wanted
    assert list(there.parent.iterdir()) == [there]


def test_all_formats_are_targets_of_an_export() -> None:
    assert PLUGINS == plugins.FORMATS
