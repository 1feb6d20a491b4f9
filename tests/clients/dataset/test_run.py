"""Whole data sets: the same bytes on any number of workers and after a kill, and what stops a run."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from carom.clients.cli import main
from carom.clients.dataset.files import SCHEMA, FolderError
from carom.clients.dataset.recipe import read
from carom.clients.dataset.run import Workers, run
from carom.clients.dataset.versions import VersionError
from tests.clients.dataset.support import SMALL, contents, unpacked, written
from tests.support import CAROM, limited

pytestmark = pytest.mark.slow


def test_data_set_is_shards_and_a_table(made):
    _, out = made
    shards = [f"small-{n:06d}.tar" for n in range(3)]
    assert sorted(contents(out)) == sorted(["README.md", "dataset.json", "small.parquet", *shards])
    about = json.loads((out / "dataset.json").read_text())
    assert about["items"] == 6 and about["shards"] == shards and about["schema"] == SCHEMA
    assert {"carom", "sources", "code", "numpy", "scipy", "libsndfile", "pyarrow"} <= set(about["computed_by"])
    found = [item for name in shards for item in unpacked(out / name)]
    table = pq.read_table(out / "small.parquet")
    assert json.loads(table.schema.metadata[b"carom"])["computed_by"] == about["computed_by"]
    rows = table.to_pylist()
    assert [row["item"] for row in rows] == list(range(6)) and [row["shard"] for row in rows] == sorted(2 * shards)
    for row, item in zip(rows, found, strict=True):
        assert row["key"] == item["key"] and row["factors"] == item["truth"]["factors"]
        assert row["objects"][0]["modes"] == item["truth"]["objects"][0]["modes"]
        (contact,) = row["contacts"]
        assert contact["force"] == item["force"][:, 0].tolist()
        assert contact["impulse"] == item["truth"]["contacts"][0]["impulse"]


def test_the_card_names_a_table_of_each_side(tmp_path):
    """Read as the Hub reads it: by the card's data files, no row of which is on another side."""
    split = 'split = { by = "object.material", test = 0.5 }\n'
    tables = run(read(written(tmp_path, split + SMALL)), tmp_path / "out", Workers(1))
    card = (tmp_path / "out" / "README.md").read_text()
    files = dict(re.findall(r"- split: (\w+)\n    path: (\S+)", card))
    assert files == {"train": "small-train.parquet", "test": "small-test.parquet"}
    assert [tmp_path / "out" / name for name in files.values()] == tables
    items = []
    for side, name in files.items():
        rows = pq.read_table(tmp_path / "out" / name).to_pylist()
        assert {row["split"] for row in rows} == {side}
        items += [row["item"] for row in rows]
    assert sorted(items) == list(range(6))


def test_two_workers_make_the_same_bytes(tmp_path):
    """Items are bars, and plates, whose shapes are products of two factors."""
    mixed = SMALL.replace('"xylophone-bar"', '{ choice = ["xylophone-bar", "glass-plate", "steel-plate"] }')
    path = written(tmp_path, mixed, "mixed")
    for workers in ("1", "2"):
        words = [*CAROM, "dataset", path, tmp_path / workers, "--workers", workers]
        subprocess.run(words, check=True, timeout=120)
    assert contents(tmp_path / "1") == contents(tmp_path / "2")


def test_a_run_that_was_killed_goes_on_to_the_same_bytes(made, tmp_path):
    path, out = made
    words = [*CAROM, "dataset", path, tmp_path / "two", "--workers", "1"]
    begun = subprocess.Popen(words)
    try:
        deadline = time.monotonic() + 60
        while not list((tmp_path / "two").glob("*.tar")) and time.monotonic() < deadline:
            time.sleep(0.005)
    finally:
        os.kill(begun.pid, signal.SIGKILL)
        begun.wait()
    (tmp_path / "two" / "small-000002.tar.x.part").write_bytes(b"half")
    run(read(path), tmp_path / "two", Workers(1))
    assert contents(tmp_path / "two") == contents(out)


def test_a_worker_that_is_killed_ends_the_run_in_a_sentence_whatever_the_other_does(tmp_path):
    path = written(tmp_path, SMALL.replace("seconds = 0.25", "seconds = 20.0"))
    begun = subprocess.Popen([*CAROM, "dataset", path, tmp_path / "two", "--workers", "2"], stderr=subprocess.PIPE)
    try:
        deadline = time.monotonic() + 60
        while len(workers := spawned(begun.pid)) < 2 and time.monotonic() < deadline:
            time.sleep(0.05)
        os.kill(workers[0], signal.SIGKILL)
        _, said = begun.communicate(timeout=60)
        assert begun.returncode == 1 and b"a worker was killed; repeat the command to go on from here" in said
    finally:
        begun.kill()


def spawned(process):
    """Return the workers that a process has started, but for the one that counts its resources."""
    children = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    return [int(each) for each in children if b"spawn_main" in Path(f"/proc/{each}/cmdline").read_bytes()]


def test_a_shard_that_is_gone_is_made_again_and_a_whole_set_is_left_alone(made, tmp_path):
    path, out = made
    told = []
    before = contents(out)
    run(read(path), out, Workers(1), progress=lambda done, count: told.append((done, count)))
    assert told == [(6, 6)] and contents(out) == before


def test_a_folder_of_something_else_is_refused(made, tmp_path):
    path, out = made
    (tmp_path / "mine.txt").write_text("")
    with pytest.raises(FolderError, match=r"mine\.txt is there: expected a new or empty folder"):
        run(read(path), tmp_path, Workers(1))
    with pytest.raises(FolderError, match="another number of items: 4, there are 6"):
        run(read(path, 4), out, Workers(1))
    with pytest.raises(FolderError, match="another text of the recipe"):
        run(read(written(tmp_path, SMALL + "\n")), out, Workers(1))


def test_other_versions_are_refused_by_name(made, tmp_path, monkeypatch):
    path, out = made
    about = json.loads((out / "dataset.json").read_text())
    about["computed_by"]["numpy"] = "1.0"
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "dataset.json").write_text(json.dumps(about))
    with pytest.raises(VersionError, match=r"begun by other versions: numpy .*: expected 1.0$"):
        run(read(path), tmp_path / "out", Workers(1))


def error_of(done: "subprocess.CompletedProcess[str]") -> str:
    """Return the one line in which a run ended; a busy machine says before it, every 5 s, how far it has come."""
    *progress, error = done.stderr.splitlines()
    assert done.returncode == 1 and all(" items after " in line for line in progress)
    return error


def test_a_full_disk_is_one_line_and_leaves_no_half_shard(tmp_path):
    """The disk has room for the modes that its processes share, but not for a shard."""
    path = written(tmp_path, 'format = "wav"\nsamples = "float"\n' + SMALL.replace("seconds = 0.25", "seconds = 4.0"))
    words = [*limited(1_000_000), "dataset", path, tmp_path / "out", "--workers", "1"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60)
    error = error_of(done)
    assert f"{tmp_path / 'out'}/small-00000" in error and "File too large" in error
    assert not list((tmp_path / "out").glob("*.tar")) and not list((tmp_path / "out").glob("*.part"))


@pytest.mark.parametrize(
    ("lacks", "options", "extra"), [("pyarrow", "", "dataset"), ("distributed", "--dask x", "dask")]
)
def test_an_extra_that_is_missing_is_one_line(tmp_path, lacks, options, extra):
    words = ["dataset", "bars", str(tmp_path / "out"), *options.split()]
    code = f"import sys; sys.modules[{lacks!r}] = None; from carom.clients.cli import main; sys.exit(main({words!r}))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    said = f"carom dataset: {lacks} is missing: pip install 'carom[{extra}]'\n"
    assert (done.returncode, done.stderr) == (1, said)


def test_a_scheduler_that_is_not_there_is_one_line(made, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("carom.clients.dataset.dask._PATIENCE", 0.1)
    monkeypatch.setattr("carom.clients.commands.dataset.on_end", lambda act: None)
    path, _ = made
    assert main(["dataset", str(path), str(tmp_path / "out"), "--dask", "tcp://127.0.0.1:1"]) == 1
    said = capsys.readouterr().err
    assert said.startswith("carom dataset: dask = tcp://127.0.0.1:1: ") and said.count("\n") == 1


def test_an_item_that_cannot_be_ends_the_run_in_one_line(tmp_path):
    path = written(tmp_path, "full_scale = 1e-3\n" + SMALL)
    words = [*CAROM, "dataset", path, tmp_path / "out", "--workers", "1"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60)
    assert error_of(done).startswith("carom dataset: item 0: its peak is")


def test_an_object_without_modes_is_named_by_its_item(tmp_path):
    small = SMALL.replace('"xylophone-bar"', '"wine-glass"\nsize = { choice = [1.0, 0.04] }').replace(
        "shard", "rate = 16_000\nshard"
    )
    words = [*CAROM, "dataset", written(tmp_path, small), tmp_path / "out", "--workers", "1"]
    said = error_of(subprocess.run(words, capture_output=True, text=True, timeout=60))
    assert re.match(r"carom dataset: item \d: .*no mode lies between .*object.size = 0.04", said), said
