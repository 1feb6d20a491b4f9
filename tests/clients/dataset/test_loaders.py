"""The examples that read a data set. Of torch, TensorFlow and Hugging Face's datasets, which are large, stand-ins do as
much as the examples ask for; webdataset is itself."""

import gc
import runpy
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pyarrow.parquet as pq
import pytest

from tests.clients.dataset.support import unpacked

EXAMPLES = Path(__file__).parents[3] / "clients" / "examples" / "dataset"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),  # webdataset closes no shard
]


@pytest.fixture
def example(made, monkeypatch, capsys):
    """Run an example on the small data set, with stand-ins by their names; what it prints, line by line."""
    _, out = made

    def play(name: str, **modules: object) -> list[str]:
        monkeypatch.setattr(sys, "argv", [name, str(out)])
        for module, stand_in in modules.items():
            monkeypatch.setitem(sys.modules, module, stand_in)
        runpy.run_path(str(EXAMPLES / name))
        gc.collect()
        return capsys.readouterr().out.splitlines()

    return play


def test_webdataset_reads_it(example, made):
    pytest.importorskip("webdataset")

    def batches(clips, batch_size, collate_fn):
        found = list(clips)
        return (collate_fn(found[n : n + batch_size]) for n in range(0, len(found), batch_size))

    data = SimpleNamespace(DataLoader=batches)
    torch = SimpleNamespace(from_numpy=np.asarray, stack=np.stack, utils=SimpleNamespace(data=data))
    (line,) = example("with_torch.py", torch=torch)
    assert line.startswith("(6, 12000) {'object.material': '")


def test_tf_data_gets_pascals(example, made):
    given = []

    class Data:
        @staticmethod
        def from_generator(generator, output_signature):
            given.extend(generator())
            return Data()

        def batch(self, count):
            return self

        def prefetch(self, count):
            return []

    specs = SimpleNamespace(TensorSpec=lambda shape, kind: (shape, kind), float32=np.float32)
    example("with_tensorflow.py", tensorflow=SimpleNamespace(data=SimpleNamespace(Dataset=Data), **vars(specs)))
    expected = [item for shard in sorted(made[1].glob("*.tar")) for item in unpacked(shard)]
    for (sound, speed), item in zip(given, expected, strict=True):
        np.testing.assert_allclose(sound, item["truth"]["full_scale"] * item["samples"][:, 0], rtol=1e-6)
        assert speed == pytest.approx(item["truth"]["factors"]["impact.velocity"], rel=1e-12)


def test_hugging_face_finds_each_rows_sound(example, made):
    class Table(list):
        def select_columns(self, names):
            return Table({name: row[name] for name in names} for row in self)

        def map(self, function):
            return Table({**row, **function(row)} for row in self)

        def with_format(self, name):
            return self

    def load_dataset(kind, data_files, split):
        assert (kind, split) == ("parquet", "train")
        return Table(pq.read_table(made[1] / Path(data_files).name.replace("*", "small")).to_pylist())

    lines = example("with_huggingface.py", datasets=SimpleNamespace(load_dataset=load_dataset))
    assert [line.split()[0] for line in lines] == [f"{n:09d}" for n in range(6)]
    assert all("(12000,)" in line for line in lines)
