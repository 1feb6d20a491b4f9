"""Modal models in glTF: written, read back, and what a file leaves out."""

import json
import struct

import numpy as np
import pytest

import carom
from carom.clients.cli import main
from carom.presets import PresetError, Presets
from carom.presets.gltf import EXTENSION, glb_of, values_of
from carom.presets.gltf_tables import model_bytes
from carom.presets.tables import table_of
from tests import needs

trimesh = needs.module("trimesh")


@pytest.fixture(scope="module")
def mug():
    return Presets().object("mug")


def changed(data, change):
    """Return a file of which the JSON was changed."""
    (size,) = struct.unpack_from("<I", data, 12)
    said = json.loads(data[20 : 20 + size])
    change(said, said["extensions"][EXTENSION])
    text = json.dumps(said).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + size :]
    return data[:8] + struct.pack("<III", 20 + len(text) + len(rest), len(text), 0x4E4F534A) + text + rest


def without_ours(said, extension):
    del extension["modalModels"][0]["extras"]


def test_modes_are_read_back_as_they_were_written(mug):
    table = mug.geometry["table"]
    data = glb_of("mug", table, mug.material)
    again = table_of(model_bytes(data, "mug.glb", mug.material), "again")
    assert np.abs(again.frequency / table.frequency - 1).max() < 1e-6
    assert np.abs(again.decay / (mug.material.decay(table.frequency) + table.resistance / 2) - 1).max() < 1e-6
    assert np.abs(again.resistance / table.resistance - 1).max() < 1e-6
    # Shapes in the file itself are float32; a table's steps are 3e-5 of each mode's largest.
    shapes = values_of(data, "mug.glb")["shapes"]
    assert np.abs(shapes - table.shapes).max() < 1e-6 * np.abs(table.shapes).max()
    assert np.abs(again.shapes - table.shapes).max() <= np.abs(table.shapes).max() / 32767
    for name in ("points", "normals", "areas", "faces", "edges"):
        assert np.allclose(getattr(again, name), getattr(table, name), rtol=1e-6, atol=1e-9), name
    assert (again.mass, again.density) == (table.mass, table.density)


def test_the_file_is_glTF_that_others_read(mug, tmp_path):
    file = tmp_path / "mug.glb"
    file.write_bytes(glb_of("mug", mug.geometry["table"], mug.material))
    scene = trimesh.load_scene(file, process=False)
    (body,) = scene.dump()
    assert len(body.faces) == len(mug.geometry["table"].faces)
    (size,) = struct.unpack_from("<I", file.read_bytes(), 12)
    said = json.loads(file.read_bytes()[20 : 20 + size])
    model = said["extensions"][EXTENSION]["modalModels"][0]
    counts = [said["accessors"][model[key]]["count"] for key in ("frequencies", "positions", "shapes")]
    assert counts[2] == counts[0] * counts[1] and said["nodes"][0]["extensions"][EXTENSION] == {"modalModel": 0}


@pytest.mark.slow
def test_a_glb_with_a_model_plays(tmp_path, capsys):
    file = tmp_path / "mug.glb"
    assert main(["presets", "mug", "--glb", str(file)]) == 0
    made = carom.mesh(file, tmp_path / "mine", "cup", "ceramic")
    assert made.table.method == "cells"
    sounds = []
    path = {"path_from": (0.0, 0.045, 0.005), "path_to": (0.0, 0.045, 0.095)}
    for name, folder in (("mug", ()), ("cup", tmp_path / "mine")):
        with carom.Scene(presets=folder) as scene:
            scene.new("a", name, level=0.0, **path).impact(1.0, point=(0.041, 0.0, 0.09), striker="wood")
            sounds.append(scene.render(seconds=0.2).samples)
    assert np.abs(sounds[1] - sounds[0]).max() < 2e-3 * np.abs(sounds[0]).max()
    capsys.readouterr()


@pytest.mark.slow
def test_radiation_that_a_file_leaves_out_follows_from_its_surface(mug):
    """Radiation is computed anew by the shapes at the points: half of it is within 3 dB of that of the whole model."""
    table = mug.geometry["table"]
    data = changed(glb_of("mug", table, mug.material), without_ours)
    again = table_of(model_bytes(data, "mug.glb", mug.material), "again")
    apart = 10 * np.log10(again.resistance / table.resistance)
    assert np.median(np.abs(apart)) < 3.0
    assert again.mass == pytest.approx(table.mass, rel=1e-6)
    assert np.abs(again.frequency / table.frequency - 1).max() < 1e-6


def test_unreadable_models_are_refused_with_a_reason(mug):
    data = glb_of("mug", mug.geometry["table"], mug.material)

    def said(change):
        with pytest.raises(PresetError) as error:
            model_bytes(changed(data, change), "a.glb", mug.material)
        return str(error.value)

    def no_indices(said, extension):
        del extension["modalModels"][0]["indices"]

    def two(said, extension):
        extension["modalModels"] *= 2

    def wrong(said, extension):
        extension["modalModels"][0]["shapes"] = extension["modalModels"][0]["frequencies"]

    def none(said, extension):
        del extension["modalModels"]

    def counts(number):
        return lambda said, extension: said["accessors"][0].update(count=number)

    def beyond(said, extension):
        said["accessors"][extension["modalModels"][0]["indices"]].update(bufferView=0)

    def at_minus_one(said, extension):
        extension["modalModels"][0]["frequencies"] = -1

    def not_finite(said, extension):
        extension["modalModels"][0]["extras"]["carom"]["resistance"][0] = float("nan")

    for number in (-1, 0, 10**12, "3", None):
        assert "its modal model can't be read" in said(counts(number))
    assert "cut short" in said(beyond)
    assert "accessors has no number -1" in said(at_minus_one)
    assert "resistance: expected finite numbers" in said(not_finite)
    assert "no indices: expected the triangles" in said(no_indices)
    assert "2 modal models: expected one" in said(two)
    assert "a.glb: its modal model can't be read" in said(wrong)
    assert model_bytes(changed(data, none), "a.glb", mug.material) is None
    with pytest.raises(PresetError, match="can't be read"):
        values_of(b"no glb at all, but long enough", "a.glb")


def test_only_an_object_of_a_mesh_has_a_model(tmp_path, capsys):
    assert main(["presets", "church-bell", "--glb", str(tmp_path / "a.glb")]) == 1
    assert "expected an object of the shape mesh" in capsys.readouterr().err
