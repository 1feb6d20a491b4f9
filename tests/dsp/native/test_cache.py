"""The user's cache of compiled code: which level is taken from it, what goes where it is full, where it may lie."""

import logging
import os
import sys

import pytest

from carom.dsp.native import store, targets
from carom.dsp.native.code import load
from carom.dsp.native.sources import compiler_digest
from carom.dsp.native.store import Store
from carom.dsp.native.targets import processors
from tests.dsp.native.conftest import doubled


@pytest.mark.parametrize("file", ["cache", "cache/carom/code/units", "cache/carom/code/translations"])
def test_a_cache_that_cannot_be_written_is_said_once_and_kept_elsewhere(doubling, tmp_path, monkeypatch, caplog, file):
    (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / file).write_text("a file, where a folder is needed")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    store._other_cache.cache_clear()
    with caplog.at_level(logging.WARNING):
        assert doubled(doubling) == (42, "compiled")
        assert doubled(doubling) == (42, "cache")
        store._other_cache.cache_clear()  # as in another process
        assert doubled(doubling) == (42, "cache")
    assert caplog.text.count("cannot write the code cache") == 1
    assert store.user_cache().parent == tmp_path and store.is_kept(store.user_cache())


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="temporary files are each user's own on this system")
@pytest.mark.parametrize("way", ["open to others", "a link", "another user's", "renamed by others"])
def test_a_cache_among_temporary_files_that_others_may_write_is_not_taken(tmp_path, monkeypatch, caplog, way):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "shared"))
    (tmp_path / "shared").mkdir()
    (tmp_path / "shared").chmod(0o777 if way == "renamed by others" else 0o1777)
    planted = tmp_path / "shared" / f"carom-code-{os.getuid()}"
    if way == "a link":
        (tmp_path / "theirs").mkdir(mode=0o700)
        planted.symlink_to(tmp_path / "theirs")
    else:
        planted.mkdir()
        planted.chmod(0o770 if way == "open to others" else 0o700)  # whatever the umask
    if way == "another user's":
        other = os.getuid() + 1
        monkeypatch.setattr(os, "getuid", lambda: other)
        planted.rename(planted.with_name(f"carom-code-{os.getuid()}"))
    store._other_cache.cache_clear()
    with caplog.at_level(logging.WARNING):
        found = store._other_cache("no right")
    assert found.resolve().parent == (tmp_path / "shared").resolve() and found.name != planted.name
    assert not store.is_kept(found) and "each start compiles anew" in caplog.text
    store._other_cache.cache_clear()


def test_files_of_an_older_version_in_the_cache_are_left_alone(doubling, tmp_path):
    """The layout was code/MODULE/KEY/FILE: it may still be in use."""
    older = tmp_path / "cache" / "carom" / "code" / doubling / "0123456789abcdef"
    older.mkdir(parents=True)
    (older / "linux-x86-64-v3.bc").write_bytes(b"BC")
    (older / "linux-x86-64-v3.0123.o").write_bytes(b"ELF")
    assert doubled(doubling) == (42, "compiled")
    assert doubled(doubling) == (42, "cache")
    assert len(list(older.iterdir())) == 2


def test_code_that_was_not_used_for_longest_goes_when_the_cache_is_full(doubling, tmp_path, monkeypatch):
    assert doubled(doubling) == (42, "compiled")
    kept = Store(tmp_path / "cache" / "carom" / "code", compiler_digest())
    for path in kept.root.glob("units/*"):
        os.utime(path, (1e8, 1e8))  # they are named by a list in use
    for number in range(3):
        kept.write_unit(f"unit{number}", "source", "bc", bytes(1000))
        kept.write_translation(f"translation{number}", bytes(1000))
    for path in [*kept.root.glob("units/*"), *kept.root.glob("translations/*/translation*")]:
        os.utime(path, (1e9, 1e9))
    os.utime(next(kept.root.glob("translations/*/translation1")), (1e8, 1e8))
    kept.read_translation("translation1")
    os.utime(kept.root / "units" / "unit2", (1.1e9, 1.1e9))
    size = sum(path.stat().st_size for folder in ("units", "translations") for path in kept.root.glob(f"{folder}/*/*"))
    monkeypatch.setattr(store, "_MOST", size - 3500)
    kept.prune()
    found = {path.name for path in [*kept.root.glob("units/unit*"), *kept.root.glob("translations/*/translation*")]}
    assert found == {"unit2", "translation1"}
    monkeypatch.setattr(store, "_MOST", 0)
    for path in kept.root.glob("units/*"):
        os.utime(path, (1e8, 1e8))
    kept.prune()
    assert len(list(kept.root.glob("units/*"))) == 2  # the list's unit, and its image
    assert doubled(doubling) == (42, "cache")


def test_a_list_that_nobody_used_for_long_holds_nothing(doubling, tmp_path, monkeypatch):
    assert doubled(doubling) == (42, "compiled")
    kept = Store(tmp_path / "cache" / "carom" / "code", compiler_digest())
    for path in [*kept.root.glob("units/*"), *kept.root.glob("modules/*/*")]:
        os.utime(path, (1e8, 1e8))
    monkeypatch.setattr(store, "_MOST", 0)
    kept.prune()
    assert not list(kept.root.glob("units/*"))
    assert doubled(doubling) == (42, "compiled")
    assert doubled(doubling) == (42, "cache")


def test_translations_that_were_used_lately_stay_however_many_compilers_there_are(tmp_path):
    compilers = {name: Store(tmp_path, name) for name in "abcdef"}
    for name, each in compilers.items():
        each.write_translation("kernel", b"code")
        os.utime(tmp_path / "translations" / name, (1e9 + ord(name), 1e9 + ord(name)))
    assert compilers["a"].read_translation("kernel") == b"code"
    compilers["b"].write_translation("another", b"code")
    compilers["c"].prune()
    assert sorted(path.name for path in tmp_path.glob("translations/*")) == ["a", "b"]
    for each in compilers.values():
        each.write_translation("kernel", b"code")
    compilers["c"].prune()
    assert len(list(tmp_path.glob("translations/*"))) == 6


@pytest.fixture
def asking(monkeypatch):
    """A function that asks for a level by the environment, or for none."""

    def ask(level: str | None) -> None:
        processors.cache_clear()
        monkeypatch.delenv(targets.VARIABLE, raising=False)
        if level:
            monkeypatch.setenv(targets.VARIABLE, level)

    yield ask
    monkeypatch.undo()
    processors.cache_clear()


@pytest.mark.skipif(len(processors()) < 2, reason="this processor has no lesser level")
def test_a_lesser_level_in_the_cache_is_not_taken_for_this_machines_own(doubling, tmp_path, asking):
    """One that was asked for once, or that another machine which shares the folder has left; each keeps its own."""
    asking(None)
    own, lesser = processors()[:2]
    for level in (lesser, None):
        asking(level)
        assert doubled(doubling) == (42, "compiled") and load(doubling).processor == (level or own)
    for level in (lesser, None):
        asking(level)
        assert doubled(doubling) == (42, "cache") and load(doubling).processor == (level or own)
    for image in (tmp_path / "cache").rglob(f"*{own}.*.image"):
        image.unlink()  # listed, and gone
    assert doubled(doubling) == (42, "compiled") and load(doubling).processor == own


@pytest.mark.skipif(len(processors()) < 2, reason="this processor has no lesser level")
def test_a_lesser_level_plays_where_nothing_can_compile_and_says_so(doubling, asking, monkeypatch, caplog):
    asking(None)
    own, lesser = processors()[:2]
    asking(lesser)
    assert doubled(doubling) == (42, "compiled")
    asking(None)
    monkeypatch.delitem(sys.modules, "carom.dsp.native.compiling")
    monkeypatch.setitem(sys.modules, "llvmlite", None)
    with caplog.at_level(logging.WARNING):
        assert doubled(doubling) == (42, "cache") and load(doubling).processor == lesser != own
    assert f"doubling plays by code for {lesser}: " in caplog.text and "carom[compile]" in caplog.text
