"""Scenes that are damaged, or that say what no engine can do: refused in a sentence, or finite sound."""

import random
import subprocess
import sys
from pathlib import Path

import pytest

from carom.clients.cli import main
from carom.clients.export.scene_file import SceneError, checked_map, summed
from tests import needs
from tests.attack import library
from tests.attack.children import Child
from tests.bench import mutated_scenes
from tests.clients.export.pages import ENGINE

SEED, CHANGES = 1, 160


@pytest.mark.slow
@needs.without("cc")
def test_a_changed_scene_is_refused_or_plays_finite_sound(tmp_path: Path) -> None:
    """Bits, numbers and ends that are changed, half with a mended checksum: no crash, no index that the sanitizers tell
    of, no NaN, none over a second. `tests.bench.mutated_scenes` tries 10,000 with Carom's engine."""
    program = mutated_scenes.build(tmp_path, tiny=True)
    for name, share in mutated_scenes.SHARES.items():
        found = list(mutated_scenes.tried(program, name, SEED, round(share * CHANGES)))
        assert [each for each in found if each.fault] == []
        assert {each.end for each in found} == {"r", "p"}
        assert all(each.reason for each in found if each.end == "r")
        with Child() as child:  # and whatever is called, in any order
            whole = (tmp_path / f"{name}.carom").read_bytes()
            refused, fine, fault = child.run(library.attempt, str(library.shared_of(tmp_path)), whole, SEED)
            assert refused and fine and not fault


@pytest.mark.slow
def test_an_engine_without_python_begins_as_one_with_it() -> None:
    """Its memory is that of `new_state`, and a file may not write what counts samples and commands."""
    subprocess.run([sys.executable, "-m", "tests.clients.export.fresh"], env=ENGINE, check=True)


def test_a_changed_byte_is_told_by_python() -> None:
    """Whatever bit is another, whatever is missing or more: the file is no scene, or a damaged one."""
    chance = random.Random(SEED)
    whole = summed(b"carom 2\n" + bytes(32) + (16).to_bytes(8, "little") + b'{"rate":48000}  ' + chance.randbytes(4096))
    assert checked_map(whole, "a.carom") == {"rate": 48000}
    for _ in range(10_000):
        changed = bytearray(whole)
        match chance.randrange(4):
            case 0 | 1:
                changed[chance.randrange(len(changed))] ^= 1 << chance.randrange(8)
            case 2:
                del changed[chance.randrange(len(changed)) :]
            case 3:
                changed += chance.randbytes(1 + chance.randrange(9))
        with pytest.raises(SceneError, match=r"^a\.carom: (expected a scene that|it is damaged: its bytes)"):
            checked_map(bytes(changed), "a.carom")


def test_commands_tell_a_scene_from_a_score(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A scene where a score is expected: whole, or damaged."""
    said = b'{"title":"bell","rate":48000,"frames":24000} '
    whole = summed(b"carom 2\n" + bytes(32) + len(said).to_bytes(8, "little") + said)
    file = tmp_path / "bell.carom"
    for content, told in (
        (whole, "a whole scene (bell, 0.5 s at 48000 Hz), which programs in C play: expected a score"),
        (whole[:-2], "it is damaged: its bytes are not those of its checksum; export the scene anew"),
    ):
        file.write_bytes(content)
        for command in ("render", "play"):
            words = [command, str(file), *([str(tmp_path / "out.wav")] if command == "render" else [])]
            assert main(words) == 1
            assert capsys.readouterr().err == f"carom {command}: {file}: {told}\n"
