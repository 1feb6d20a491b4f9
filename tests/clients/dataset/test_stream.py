"""Items of a recipe without files: the sounds and the truth of a data set, in any order, by any number of processes."""

import gc
import itertools

import numpy as np
import pytest

import carom
from tests.clients.dataset.support import SMALL, unpacked, written

BLOWS = {"object": {"preset": "xylophone-bar", "length": 0.2}, "impact": {"velocity": {"uniform": (0.5, 1)}}}


@pytest.mark.slow
def test_rows_are_those_of_the_data_set(made):
    path, out = made
    items = [item for shard in sorted(out.glob("*.tar")) for item in unpacked(shard)]
    for order, workers in ((range(6), 1), ([5, 0, 3], 2)):
        rows = list(carom.render_many(path, order, workers=workers))
        assert [row["item"] for row in rows] == list(order)
        for row in rows:
            item = items[row["item"]]
            assert row["sound"].dtype == np.float32
            np.testing.assert_array_equal(row["sound"], item["samples"] * item["truth"]["full_scale"])
            assert row["factors"] == item["truth"]["factors"] and row["objects"] == item["truth"]["objects"]
            assert (row["contacts"][0]["force"] == item["force"][:, 0]).all()


def test_a_dictionary_is_a_recipe_without_an_end():
    rows = carom.render_many({**BLOWS, "seconds": np.float64(0.05), "seed": 2})
    first, second = itertools.islice(rows, 2)
    assert first["sound"].shape == (2400, 1) and first["factors"] != second["factors"]
    (far,) = carom.render_many({**BLOWS, "seconds": 0.05, "seed": 2}, [999_999_999])
    assert far["item"] == 999_999_999
    error = np.square(carom.rebuild(first) - first["sound"]).sum() / np.square(first["sound"]).sum()
    assert error < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("gesture", [BLOWS["impact"], {"velocity": 1.0, "striker": "drumstick"}])
def test_an_item_leaves_nothing_in_memory(gesture):
    """An engine's state that waits for the search for garbage is memory and time."""
    rows = carom.render_many({**BLOWS, "impact": gesture, "seconds": 0.05, "seed": 2})
    next(rows)
    gc.collect()
    gc.disable()
    try:
        for _ in itertools.islice(rows, 3):
            pass
        assert gc.collect() == 0
    finally:
        gc.enable()


def test_wrong_arguments_of_render_many_are_refused():
    with pytest.raises(carom.PresetError, match=r"recipe: \[impact\] velocty: no such key; did you mean velocity\?"):
        carom.render_many({**BLOWS, "impact": {"velocity": 1.0, "velocty": 1.0}})
    with pytest.raises(carom.PresetError, match="is not JSON serializable: expected numbers, words"):
        carom.render_many({**BLOWS, "seed": object()})
    with pytest.raises(ValueError, match="workers = 0: expected a whole number from 1"):
        carom.render_many("bars", workers=0)
    with pytest.raises(ValueError, match="workers = '2': expected a whole number from 1"):
        carom.render_many("bars", workers="2")
    with pytest.raises(ValueError, match="numbers = 3: expected several whole numbers"):
        next(carom.render_many("bars", 3))
    for bad in (40, -1, 1.5, True):
        with pytest.raises(ValueError, match="expected whole numbers from 0 to 39"):
            next(carom.render_many("bars", [bad]))


@pytest.mark.slow
def test_an_item_that_cannot_be_is_named_by_any_process(tmp_path):
    path = written(tmp_path, "full_scale = 1e-3\n" + SMALL)
    for workers in (1, 2):
        with pytest.raises(carom.ItemError, match="item 0: its peak is"):
            list(carom.render_many(path, workers=workers))
