"""`carom mesh`: a file becomes an object, or a sentence."""

import numpy as np
import pytest

import carom
from carom.clients.cli import main
from carom.clients.examples.meshes import household
from carom.dsp.errors import CaromError
from carom.dsp.mesh import forms, model
from carom.dsp.runtime.engine import Engine, prepare
from carom.server.scene.session import Session
from tests import needs
from tests.server.scene.support import say
from tests.server.scene.test_points import stiffness_of

trimesh = needs.module("trimesh")
QUICK = ("--modes", "12", "--points", "60")


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    """A cache of tables that the test begins without, and models of half the cells."""
    import platformdirs

    prepare()  # the engine, whose code would be compiled into an empty cache
    monkeypatch.setattr(platformdirs, "user_cache_path", lambda name: tmp_path / "cache" / name)
    monkeypatch.setattr(model, "CELLS", (4, 40))
    monkeypatch.setattr(model, "FINE", (4, 80))


def ply(vertices=4, faces=4, points="1"):
    """Return the bytes of a tetrahedron, with what a head and its first face say."""
    rows = ["0 0 0", "0.1 0 0", "0 0.1 0", "0 0 0.1", f"3 0 2 {points}", "3 0 1 3", "3 0 3 2", "3 1 2 3"]
    head = ["ply", "format ascii 1.0", f"element vertex {vertices}", *(f"property float {axis}" for axis in "xyz")]
    head += [f"element face {faces}", "property list uchar int vertex_indices", "end_header"]
    return "\n".join((*head, *rows, "")).encode()


def written(surface, path, unit=1.0):
    trimesh.Trimesh(surface.points / unit, surface.faces, process=False).export(path)
    return path


@pytest.mark.parametrize(("size", "said"), [(40.0, "0.001 reads mm"), (1e-5, "expected a larger one")])
def test_a_mesh_of_an_unusual_size_is_asked_about_the_way_it_is_off(tmp_path, capsys, size, said):
    file = written(forms.box(size, size / 2, size / 4), tmp_path / "odd.ply")
    assert main(["mesh", str(file), str(tmp_path / "mine"), "--name", "odd", "--material", "steel"]) == 1
    told = capsys.readouterr().err
    assert "expected 0.003 to 3 m; scale: " + said in told and ("reads mm" in told) == (size > 1)


@pytest.mark.parametrize("scale", ["0", "-1", "inf"])
def test_a_scale_that_is_none_is_named(tmp_path, capsys, scale):
    file = written(forms.box(0.2, 0.1, 0.05), tmp_path / "box.ply")
    assert main(["mesh", str(file), str(tmp_path), "--name", "a", "--material", "tin", "--scale", scale]) == 1
    assert f"scale = {scale}: expected a positive number" in capsys.readouterr().err


@pytest.mark.slow
def test_a_mesh_becomes_an_object_with_a_report(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(model, "CELLS", (4, 80))  # its mass to four digits
    file = written(forms.box(0.2, 0.03, 0.008), tmp_path / "bar.stl", 1e-3)
    out = tmp_path / "mine"
    assert main(["mesh", str(file), str(out), "--name", "bar", "--material", "steel", *QUICK]) == 1
    asked = capsys.readouterr().err
    assert "200 x 30 x 8 m: expected 0.003 to 3 m" in asked and "0.001 reads mm" in asked
    options = ["--name", "bar", "--material", "steel", "--scale", "0.001", "--errors", *QUICK]
    assert main(["mesh", str(file), str(out), *options]) == 0
    told = capsys.readouterr()
    assert [line.rsplit("/")[-1] for line in told.out.split()] == ["bar.toml", "bar.npz", "bar.html"]
    assert "a solid of" in told.err and "0.2 x 0.03 x 0.008 m, 0.3768 kg\n" in told.err
    page = (out / "bar.html").read_text()
    assert page.count("<tr>") == 13 and "data:image/png" in page and "data:audio" in page
    closed = carom.dsp.bodies.bar(
        carom.Presets().material("steel"), length=0.2, width=0.03, thickness=0.008, top=9000.0
    )
    modes = carom.Presets(out).object("bar").modes(20_000.0)
    assert modes.frequency[:3] == pytest.approx(closed.frequency[:3], rel=5e-3)
    assert modes.mass == pytest.approx(closed.mass, rel=1e-3)
    with carom.Scene(presets=out) as scene:
        scene.new("a", "bar").impact(1.0, position=0.1)
        assert np.abs(scene.render(seconds=0.2).samples).max() > 1e-4


@pytest.mark.slow
def test_modes_of_a_mesh_that_a_preset_names_are_kept(tmp_path):
    folder = tmp_path / "mine" / "objects"
    folder.mkdir(parents=True)
    written(forms.ball(0.03, 2), folder / "ball.ply")
    text = (
        'description = "a"\nsource = "b"\nshape = "mesh"\nmaterial = "glass"\nlevel = 0.0\n[mesh]\nfile = "ball.ply"\n'
        'modes = 10\npoints = 60\n[strike]\nstriker = "wood"\nvelocity = 1.0\nposition = 0.5\n'
    )
    (folder / "ball.toml").write_text(text)
    first = carom.Presets(tmp_path / "mine").object("ball").geometry["table"]
    kept = list((tmp_path / "cache").rglob("*.npz"))
    assert len(kept) == 1
    stamp = kept[0].stat().st_mtime_ns
    assert carom.Presets(tmp_path / "mine").object("ball").geometry["table"] == first
    assert kept[0].stat().st_mtime_ns == stamp
    kept[0].write_bytes(b"broken")
    assert carom.Presets(tmp_path / "mine").object("ball").geometry["table"] == first


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["obj", "ply", "glb", "stl"])
def test_all_formats_are_read_alike(tmp_path, ending):
    from carom.presets.meshes import read_mesh

    ball = forms.ball(0.05, 1)
    points, faces = read_mesh(written(ball, tmp_path / f"ball.{ending}"))
    corners, own = points[faces], ball.points[ball.faces]
    assert np.abs(np.sort(corners.reshape(-1, 3), axis=0) - np.sort(own.reshape(-1, 3), axis=0)).max() < 1e-6


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        ("a.txt", b"x", "expected a file that ends in .obj"),
        ("a.glb", b"glTF but not quite", "a.glb: a .glb file of version .*: expected 2"),
        ("a.gltf", b"{", "a.gltf: expected JSON, as all glTF files hold"),
        ("a.obj", bytes(8), "its bytes are no text: expected an .obj file"),
        ("a.obj", b"f one two three", "line 1: a face of 'one': expected the numbers of points"),
        (
            "a.stl",
            bytes(80) + b"\x02\0\0\0" + bytes(54),
            "a.stl: cut short: 1 of its triangles are there: expected the 2 that its header announces",
        ),
        ("a.glb", b"junk", "a.glb: begins with b'junk': expected b'glTF'"),
        ("a.ply", ply(points="9"), "a face of point 9: expected numbers from 0 to 3"),
        ("a.ply", ply(points="-1"), "a face of point -1: expected numbers from 0 to 3"),
        ("a.ply", ply(vertices=-1), "a.ply: element vertex -1: expected a count from 0 on"),
        ("a.ply", ply(faces=-1), "a.ply: element face -1: expected a count from 0 on"),
        ("a.ply", ply(faces=10**9), "a.ply: 8 rows: expected the 1000000004 that its header announces"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "a.obj: line 4: a face of point 9: expected 1 to 3"),
        ("a.stl", bytes(80) + b"\xff\xff\xff\xff", "a.stl"),
        ("a.stl", b"", "a.stl"),
        ("a.obj", b"v 0 0 0\n", "a.obj"),
    ],
)
def test_files_without_a_mesh_are_said(tmp_path, name, data, said):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(CaromError, match=said):
        carom.mesh(tmp_path / name, tmp_path, "a", "steel")


@pytest.mark.parametrize(("name", "first"), [("a.dae", "a.dae: expected"), ("a.urdf", "a.urdf: save it by MuJoCo as")])
def test_the_command_names_the_files_that_it_takes(tmp_path, capsys, name, first):
    assert main(["mesh", str(tmp_path / name)]) == 1
    said = capsys.readouterr().err
    assert (
        first in said and "expected a mesh (.obj, .stl, .ply, .glb, .gltf) or a model of MuJoCo (.xml or .mjb)" in said
    )


@pytest.mark.slow
def test_the_examples_meshes_are_closed_but_for_the_sheet():
    from carom.dsp.mesh.cleaning import cleaned

    for name, (make, material, wall, _) in household.OBJECTS.items():
        made = make()
        parts = made if isinstance(made, dict) else {"": made}
        assert isinstance(material, str) or set(material) <= {"*", *parts}
        faces = 0
        for part in parts.values():
            surface, notes = cleaned(*part, wall=wall is not None)
            faces += len(surface.faces)
            assert not any("hole" in note or "flipped" in note or "inside" in note for note in notes), (name, notes)
        assert faces > 80, name


def spade(path):
    """Write a blade of steel with a shaft that is its own part."""
    scene = trimesh.Scene()
    blade, shaft = forms.box(0.12, 0.06, 0.004), forms.moved(forms.box(0.2, 0.02, 0.016), (0.155, 0, 0))
    for name, part in (("blade", blade), ("shaft", shaft)):
        scene.add_geometry(trimesh.Trimesh(*part, process=False), node_name=name, geom_name=name)
    scene.export(path)
    return path


def test_a_part_that_a_file_does_not_have_is_said_with_those_that_it_has(tmp_path, capsys):
    file = spade(tmp_path / "spade.glb")
    given = ["--name", "spade", "--material", "steel", "--material", "grip=wood"]
    assert main(["mesh", str(file), str(tmp_path), *given]) == 1
    assert "part grip: there is none; expected one of blade, shaft" in capsys.readouterr().err
    assert main(["mesh", str(file), str(tmp_path), "--name", "a", "--material", "shaft=wood"]) == 2
    assert "--material: expected one for the body" in capsys.readouterr().err


@pytest.mark.slow
def test_a_body_of_two_materials_loses_by_both_and_is_struck_as_the_part_is(tmp_path):
    file = spade(tmp_path / "spade.obj")
    made = carom.mesh(file, tmp_path / "mine", "spade", {"*": "steel", "shaft": "wood"}, modes=16, points=80)
    table, presets = made.table, carom.Presets(tmp_path / "mine")
    steel, wood = (presets.material(each) for each in ("steel", "wood"))
    assert table.materials == (steel, wood) and any("shaft: of wood" in note for note in table.notes)
    assert table.mass == pytest.approx(7850 * 0.12 * 0.06 * 0.004 + 750 * 0.2 * 0.02 * 0.016 * 0.975, rel=0.03)
    assert table.material_at((0.2, 0, 0.008)) == wood and table.material_at((-0.05, 0, 0.002)) is None
    share = table.energy[1]
    lost = share * (wood.decay(table.frequency) - wood.alpha / 2) + (1 - share) * (
        steel.decay(table.frequency) - steel.alpha / 2
    )
    modes = presets.object("spade").modes(20_000.0)
    expected = lost + steel.alpha / 2 + table.resistance / 2
    assert modes.decay == pytest.approx(expected[: len(modes.decay)], rel=1e-6)
    # The preset may name the mesh instead.
    folder = tmp_path / "other" / "objects"
    folder.mkdir(parents=True)
    spade(folder / "spade.obj")
    text = (tmp_path / "mine" / "objects" / "spade.toml").read_text()
    section = '[mesh]\nfile = "spade.obj"\nmodes = 16\npoints = 80\n[mesh.materials]\nshaft = "wood"\n'
    (folder / "spade.toml").write_text(text.replace('[geometry]\ntable = "spade.npz"\n', section))
    assert carom.Presets(tmp_path / "other").object("spade").geometry["table"] == table
    session = Session(Engine(48_000), presets)
    say(session, "/object/new", "mug", "spade")
    felt = [stiffness_of(session, "point", *point) for point in ((-0.05, 0.01, 0.002), (0.2, 0.003, 0.008))]
    plane = [presets.striker("wood").contact(each)[1] for each in (steel, wood)]
    assert felt == pytest.approx(plane, rel=1e-6)
    assert stiffness_of(session, "position", 1.0) == pytest.approx(plane[1], rel=1e-6)
