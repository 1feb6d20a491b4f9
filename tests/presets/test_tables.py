"""Tables of modes, and the presets that play them."""

import shutil

import numpy as np
import pytest

from carom.dsp.bodies.mesh import mesh, usual_path
from carom.presets import BUILT_IN, PresetError, Presets
from carom.presets.tables import read_table, table_bytes, table_of

MUG = BUILT_IN / "objects" / "mug.npz"


def preset(folder, text):
    """Write a preset of the shape mesh that has these lines, beside the mug's table; return the library."""
    (folder / "objects").mkdir()
    shutil.copy(MUG, folder / "objects" / "mug.npz")
    lines = ['description = "a"', 'source = "b"', 'shape = "mesh"', 'material = "ceramic"', "level = 0.0", text]
    lines += ["[strike]", 'striker = "wood"', "velocity = 1.0", "position = 0.5"]
    (folder / "objects" / "mine.toml").write_text("\n".join(lines) + "\n")
    return Presets(folder)


def test_a_table_is_read_as_it_was_written():
    table = read_table(MUG)
    data = table_bytes(table.arrays)
    again = table_of(data, "again")
    assert again.frequency.tolist() == table.frequency.tolist()
    assert np.abs(again.shapes - table.shapes).max() <= np.abs(table.shapes).max() / 32767
    assert table_bytes(again.arrays) == table_bytes(table_of(table_bytes(again.arrays), "").arrays)
    assert again == table_of(data, "elsewhere")
    for name, value in table.arrays.items():  # steps are kept as they are; another zlib packs them otherwise
        np.testing.assert_array_equal(again.arrays[name], value)


@pytest.mark.parametrize("data", [b"", b"no table", b"PK\x05\x06" + bytes(18)])
def test_files_that_hold_no_table_are_refused(data):
    with pytest.raises(PresetError, match="mine: expected a table of modes"):
        table_of(data, "mine")


def test_arrays_that_do_not_fit_are_said():
    values = read_table(MUG).arrays
    with pytest.raises(PresetError, match=r"frequency: expected numbers above 0 that ascend"):
        table_of(table_bytes({**values, "frequency": values["frequency"][::-1]}), "x")
    with pytest.raises(PresetError, match=r"areas of \(3,\): expected"):
        table_of(table_bytes({**values, "areas": np.ones(3)}), "x")


def test_a_strike_at_a_point_of_the_table_has_its_shapes():
    table = read_table(MUG)
    number = int(np.argmax(table.points[:, 2]))
    _, normals, shapes = table.near(table.points[[number]])
    assert normals[0] @ table.normals[number] > 0.8
    size = np.abs(table.shapes[:, :, :12]).max()
    assert np.abs(shapes[0, :, :12] - table.shapes[number, :, :12]).max() < 0.1 * size


def test_modes_follow_the_table_and_the_material_damps_them():
    ceramic = Presets().material("ceramic")
    table = read_table(MUG)
    made = mesh(ceramic, table=table, top=10_000.0)
    count = int((table.frequency <= 10_000).sum())
    assert made.frequency.tolist() == table.frequency[:count].tolist()
    assert np.allclose(made.decay, ceramic.decay(made.frequency) + table.resistance[:count] / 2)
    assert made.unheard is not None and made.mass == table.mass
    start, end = usual_path(table)
    turned = mesh(ceramic, table=table, top=10_000.0, path_from=tuple(end), path_to=tuple(start), tilt=-5.0)
    assert np.allclose(np.abs(turned.along[::-1]), np.abs(made.along), atol=1e-9)


def test_a_blow_has_a_direction():
    """Blows along the normal and across it add as vectors do."""
    ceramic, table = Presets().material("ceramic"), read_table(MUG)
    normal, half, across = (mesh(ceramic, table=table, top=9000.0, tilt=tilt).along for tilt in (0.0, 45.0, 90.0))
    assert np.allclose(half, (normal + across) / np.sqrt(2), atol=1e-12)
    assert np.abs(across).max() > 0.1 * np.abs(normal).max()


def test_another_material_needs_another_table():
    with pytest.raises(PresetError, match=r"density = 7850: expected 2700, that of the table; make the table anew"):
        Presets().object("mug").replace(material="steel").modes(20_000.0)


@pytest.mark.slow
def test_a_box_of_a_preset_is_struck_on_its_faces_and_edges(tmp_path, monkeypatch):
    monkeypatch.setattr("carom.presets.meshes.cache_folder", lambda: tmp_path / "kept")
    library = preset(tmp_path, "[mesh]\nbox = [0.1, 0.08, 0.01]\nmodes = 12\npoints = 60")
    modes = library.object("mine").modes(20000.0)
    corners = modes.faces.corners.reshape(-1, 3)
    assert np.abs(corners).max(axis=0) == pytest.approx([0.05, 0.04, 0.005]) and modes.faces.edges.any()
    (kept,) = (tmp_path / "kept").glob("*.npz")
    stamp = kept.stat().st_mtime_ns
    again = library.object("mine")
    assert again.modes(20000.0).frequency.tolist() == modes.frequency.tolist() and kept.stat().st_mtime_ns == stamp


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ('[geometry]\ntable = "none.npz"', "there is no such file"),
        ('[geometry]\ntable = "../../../etc/passwd"', "expected a file in the preset's folder"),
        ("[geometry]\ntable = 3", "expected a table in the preset's folder"),
        ("", "table is missing"),
        ('[mesh]\nfile = "mug.npz"', "expected a file that ends in .obj, .stl, .ply, .glb, .gltf"),
        ("[mesh]\nwall = 0.1", "file: expected one of file, box, cylinder"),
        ('[mesh]\nfile = "mug.npz"\nbox = [1.0, 1.0, 1.0]', "file and box: expected one of file, box, cylinder"),
        ("[mesh]\nbox = [0.1, 0.1, 0.1]\nwall = 0.1", "wall: expected none of a solid box"),
        ("[mesh]\nbox = [1.0, 0.01, 0.01]", "a box of 1e\\+03 x 10 x 10 mm: expected edges"),
        ('[mesh]\nfile = "mug.npz"\n[geometry]\ntable = "mug.npz"', "expected one of the two"),
    ],
)
def test_wrong_files_are_named(tmp_path, lines, said):
    with pytest.raises(PresetError, match=said):
        preset(tmp_path, lines).object("mine")


def test_no_message_names_a_file(tmp_path):
    library = preset(tmp_path, '[geometry]\ntable = "mug.npz"')
    with pytest.raises(PresetError, match=r"table = 'mug.npz': expected a table in the preset's folder"):
        library.object("mine").replace(table="mug.npz")
    assert library.object("mine").replace(path_from="0 0 0", path_to="0 0 0.1").modes(9000.0).frequency.size
