"""The examples that read a data set, with what they read it by: torch, Hugging Face's datasets and webdataset.

The first two take some GB (`pip install 'carom[loaders]'`). Where they are not installed, and of TensorFlow, stand-ins
do as much as the examples ask for.
"""

import gc
import runpy
import sys
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pyarrow.parquet as pq
import pytest

from tests import needs
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


def test_torch_reads_it_by_webdataset(example):
    needs.module("webdataset")

    def batches(clips, batch_size, collate_fn):
        found = list(clips)
        return (collate_fn(found[n : n + batch_size]) for n in range(0, len(found), batch_size))

    data = SimpleNamespace(DataLoader=batches)
    stand_in = SimpleNamespace(from_numpy=np.asarray, stack=np.stack, utils=SimpleNamespace(data=data))
    (line,) = example("with_torch.py", **({} if find_spec("torch") else {"torch": stand_in}))
    assert line.replace("torch.Size([6, 12000])", "(6, 12000)").startswith("(6, 12000) {'object.material': '")


def test_torch_renders_without_files(made):
    """Two processes of a DataLoader render all items once."""
    torch = needs.module("torch")
    import carom.torch

    path, out = made
    loader = torch.utils.data.DataLoader(carom.torch.Items(path), batch_size=2, num_workers=2)
    batches = list(loader)
    assert sorted(int(number) for batch in batches for number in batch["item"]) == list(range(6))
    items = [item for shard in sorted(out.glob("*.tar")) for item in unpacked(shard)]
    for batch in batches:
        assert batch["sound"].shape[1:] == (1, 12_000) and batch["sound"].dtype == torch.float32
        for number, sound, speed in zip(
            batch["item"], batch["sound"], batch["factors"]["impact.velocity"], strict=True
        ):
            item = items[int(number)]
            np.testing.assert_array_equal(sound[0], item["truth"]["full_scale"] * item["samples"][:, 0])
            assert float(speed) == item["truth"]["factors"]["impact.velocity"]
    ones = carom.torch.Items(path, range(2), select=lambda row: row["contacts"][0]["impulse"])
    assert list(ones) == [item["truth"]["contacts"][0]["impulse"] for item in items[:2]]
    with pytest.raises(carom.PresetError, match="no recipe 'barz'"):
        carom.torch.Items("barz")


def test_hugging_face_reads_it(example):
    needs.module("datasets")
    lines = [line for line in example("with_huggingface.py") if "(12000,)" in line]
    assert [line.split()[0] for line in lines] == [f"{n:09d}" for n in range(6)]


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

    def load_dataset(folder, split):
        assert split == "train"
        return Table(pq.read_table(Path(folder) / "small.parquet").to_pylist())

    lines = example("with_huggingface.py", datasets=SimpleNamespace(load_dataset=load_dataset))
    assert [line.split()[0] for line in lines] == [f"{n:09d}" for n in range(6)]
    assert all("(12000,)" in line for line in lines)
