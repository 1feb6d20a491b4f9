"""Mesh files as others write them: polygons of any form, indices that count back, arrays that are packed."""

import base64
import json
import struct

import numpy as np
import pytest

from carom.dsp.mesh import forms
from carom.dsp.mesh.cleaning import cleaned, openings
from carom.dsp.mesh.polygons import Polygons, triangulated
from carom.dsp.mesh.surface import MeshError, Surface, volume_of
from carom.dsp.mesh.winding import sides_of
from carom.presets.mesh_files import read_obj, read_ply, read_stl
from carom.presets.meshes import read_mesh, read_parts
from tests import needs

needs.module("mapbox_earcut")


def star(rng, count):
    """Return the corners (n, 2) of a polygon that is not convex, some of them in the middle of a side."""
    angle = 2 * np.pi * np.arange(count) / count
    at = (rng.uniform(0.02, 0.1, count) * np.array([np.cos(angle), np.sin(angle)])).T
    return np.concatenate(
        [[a, (a + b) / 2][: 1 + (rng.random() < 0.4)] for a, b in zip(at, np.roll(at, -1, 0), strict=True)]
    )


def prism(outline, height=0.03):
    """Return the points and the polygons of a prism, and its volume."""
    count = len(outline)
    points = np.vstack([np.c_[outline, np.zeros(count)], np.c_[outline, np.full(count, height)]])
    low, high = list(range(count)), list(range(count, 2 * count))
    sides = [(n, (n + 1) % count, count + (n + 1) % count, count + n) for n in range(count)]
    x, y = outline.T
    area = float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
    return points, [low[::-1], high, *sides], area * height


def turned(rng, points):
    """Return points that are turned any way, and moved."""
    return points @ np.linalg.qr(rng.standard_normal((3, 3)))[0] + rng.uniform(-1, 1, 3)


def obj(points, polygons, backwards=False):
    """Return an .obj file, the indices of which count back from the end or not."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
    shift = -len(points) if backwards else 1
    lines += ["f " + " ".join(f"{n + shift}//1" for n in ring) for ring in polygons]
    return "\n".join(lines).encode()


def ply(points, polygons, form):
    """Return a .ply file of a format."""
    order = {"binary_little_endian": "<", "binary_big_endian": ">"}.get(form)
    head = f"ply\nformat {form} 1.0\nelement vertex {len(points)}\nproperty double x\nproperty double y\n"
    head += f"property double z\nproperty uchar red\nelement face {len(polygons)}\nproperty uchar flags\n"
    head += "property list uchar int vertex_index\nend_header\n"
    if order is None:
        rows = [" ".join(map(repr, [*point, 7])) for point in points.tolist()]
        rows += [" ".join(map(str, [0, len(ring), *ring])) for ring in polygons]
        return (head + "\n".join(rows) + "\n").encode()
    body = b"".join(struct.pack(f"{order}dddB", *point, 7) for point in points)
    body += b"".join(struct.pack(f"{order}BB{len(ring)}i", 0, len(ring), *ring) for ring in polygons)
    return head.encode() + body


def require_body(read, volume):
    """Assert that triangles enclose a volume, with no face that has air on both sides, and no hole."""
    surface, notes = cleaned(read.points, read.faces)
    assert volume_of(surface) == pytest.approx(volume, rel=1e-9)
    assert not openings(surface) and not sides_of(surface).wrong.any() and notes == ()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_concave_polygons_become_the_body_that_they_enclose(seed):
    rng = np.random.default_rng(seed)
    points, polygons, volume = prism(star(rng, int(rng.integers(4, 30))))
    points = turned(rng, points)
    # A polygon may begin at any corner.
    polygons = [list(np.roll(ring, int(rng.integers(len(ring))))) for ring in polygons]
    for back in (False, True):
        require_body(triangulated(read_obj("a.obj", obj(points, polygons, back))), volume)
    for form in ("ascii", "binary_little_endian", "binary_big_endian"):
        require_body(triangulated(read_ply("a.ply", ply(points, polygons, form))), volume)


def test_a_polygon_that_goes_round_a_hole_by_a_bridge_keeps_the_hole():
    outer = [(0, 0), (6, 0), (6, 6), (0, 6)]
    ring = [*outer, outer[0], (2, 2), (2, 4), (4, 4), (4, 2), (2, 2)]
    at = np.c_[np.array(ring, float), np.zeros(len(ring))]
    corners, none = np.arange(len(ring)), np.zeros(1, np.int64)
    faces = triangulated(Polygons(at, corners, np.array([len(ring)]), none, ((),))).faces
    a, b, c = at[faces].transpose(1, 0, 2)
    areas = np.cross(b - a, c - a)[:, 2] / 2
    assert areas.sum() == pytest.approx(36 - 4) and (areas >= 0).all()


@pytest.mark.parametrize(
    ("faces", "said"),
    [
        ("f 0 1 2", "line 5: a face of point 0: expected 1 and above, or -1 to -4 back .* the file counts from 0"),
        ("f 1 2 3\nf 1 2 -5", "line 6: a face of point -5: expected 1 and above, or -1 to -4 back"),
        ("f 1 2 3\nf 1 2 5", "line 6: a face of point 5: expected 1 to 4"),
        ("f 1 2 3,4", "line 5: a face of '3,4': expected the numbers of points"),
        ("v 0,1 0 0", "line 5: v '0,1 0 0': expected three numbers"),
        ("curv 0 1 1 2", "free-form surfaces alone"),
    ],
)
def test_wrong_obj_files_are_refused_with_a_reason(faces, said):
    head = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    with pytest.raises(MeshError, match=said):
        read_obj("a.obj", (head + faces).encode())


def test_indices_count_back_from_where_the_face_stands(tmp_path):
    """Two bodies, one after the other, each of whose faces name the points before it."""
    one, other = forms.box(0.1, 0.03, 0.01), forms.moved(forms.box(0.1, 0.03, 0.02), (0.2, 0, 0))
    parts = [b"o one", obj(one.points, one.faces, True), b"o other", obj(other.points, other.faces, True)]
    (tmp_path / "two.obj").write_bytes(b"\n".join(parts))
    read = read_parts(tmp_path / "two.obj")
    assert read.names == (("one",), ("other",)) and list(np.bincount(read.of)) == [16, 16]
    assert volume_of(Surface(read.points, read.faces)) == pytest.approx(0.1 * 0.03 * 0.03)


@pytest.mark.parametrize("ends", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_text_is_read_whatever_ends_its_lines_and_encodes_it(ends, encoding):
    box = forms.box(0.2, 0.03, 0.01)
    corners = (f"vertex {x!r} {y!r} {z!r}" for x, y, z in box.points[box.faces].reshape(-1, 3).tolist())
    facets = "\n".join(f"facet\nouter loop\n{a}\n{b}\n{c}\nendloop" for a, b, c in zip(*[corners] * 3, strict=True))
    texts = {read_obj: obj(box.points, box.faces).decode(), read_stl: f"solid a\n{facets}\nendsolid a\n"}
    for reader, text in texts.items():
        read = triangulated(reader("a", text.replace("\n", ends).encode(encoding)))
        assert volume_of(Surface(read.points, read.faces)) == pytest.approx(6e-5)


@pytest.mark.parametrize(
    "outline",
    [
        [(0, 0), (1, 1), (1, 0), (0, 1)],  # whose halves take each other away
        [(0, 0), (1, 1), (1, 0), (0.2, 1)],
        [(np.cos(angle), np.sin(angle)) for angle in 4 * np.pi / 5 * np.arange(5)],  # round its middle twice
    ],
)
def test_a_polygon_that_crosses_itself_is_named_by_its_place(outline):
    points, polygons, _ = prism(np.array(outline, float))
    with pytest.raises(MeshError, match=rf"a face of {len(outline)} corners about \(.*\) crosses itself: expected"):
        triangulated(read_obj("a.obj", obj(turned(np.random.default_rng(1), points), polygons)))


def test_a_pointer_of_git_lfs_is_named(tmp_path):
    for ending in ("obj", "stl", "ply", "glb", "gltf"):
        (tmp_path / f"a.{ending}").write_text("version https://git-lfs.github.com/spec/v1\noid sha256:aa\nsize 9\n")
        with pytest.raises(MeshError, match=r"a pointer of Git LFS, not the file: .* git lfs pull"):
            read_mesh(tmp_path / f"a.{ending}")


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("element", ["vertex", "face"])
@pytest.mark.parametrize("off", [-1, 1])
def test_a_ply_whose_head_counts_wrong_is_refused(form, element, off):
    """Two bodies: without its last rows the first one is whole."""
    box = forms.together(forms.box(0.1, 0.03, 0.01), forms.moved(forms.box(0.1, 0.03, 0.01), (0.2, 0, 0)))
    data, count = ply(box.points, box.faces, form), {"vertex": len(box.points), "face": len(box.faces)}[element]
    triangulated(read_ply("a.ply", data))
    wrong = data.replace(f"{element} {count}".encode(), f"{element} {count + off * count // 2}".encode())
    with pytest.raises(MeshError, match=r"its header announces|a face of point|a list of"):
        read_ply("a.ply", wrong)


def stl(count, tail=b""):
    """Return a binary .stl file of a box, whose head tells a count."""
    box = forms.box(0.2, 0.03, 0.01)
    data = b"".join(struct.pack("<12fH", 0, 0, 0, *box.points[face].ravel(), 0) for face in box.faces)
    return b"solid of some program".ljust(80) + struct.pack("<I", count) + data + tail


@pytest.mark.parametrize("data", [stl(16), stl(0), stl(0xFFFFFFFF), stl(16, tail=b"made by"), stl(0, tail=b"x")])
def test_a_binary_stl_is_read_whatever_follows_it_or_its_head_leaves_open(data):
    read = triangulated(read_stl("a.stl", data))
    assert volume_of(Surface(read.points, read.faces)) == pytest.approx(6e-5, rel=1e-6)


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (stl(17), "cut short: 16 of its triangles are there: expected the 17"),
        (stl(10), "16 triangles: expected the 10 that its header announces"),
        (b"solid a\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n", "cut short: its last facet has no endloop"),
        (b"solid a\nfacet\nvertex 0 0 x\nendloop", "a vertex that is no number"),
        (b"solid a\nfacet\nvertex 0 0 1\nendloop\nendfacet\nfacet normal", "cut short: its last facet has no endloop"),
    ],
)
def test_an_stl_that_is_not_whole_is_refused(data, said):
    with pytest.raises(MeshError, match=said):
        read_stl("a.stl", data)


def gltf(points, faces, kind="<f4", node=None, sparse=False, strip=False, **more):
    """Return a .gltf file of a mesh, its places as numbers of a kind, normalised where these are whole."""
    whole = np.dtype(kind).kind in "iu"
    most = float(np.abs(points).max())
    stored = np.round(points / most * np.iinfo(kind).max).astype(kind) if whole else points.astype(kind)
    padded = np.zeros((len(points), 4), kind)  # a stride that is wider than a place
    padded[:, :3] = stored
    indices = np.arange(len(points)) if strip else faces
    parts = [padded.tobytes(), indices.astype("<u2").tobytes(), np.arange(len(points)).astype("<u2").tobytes()]
    begin = np.cumsum([0, *map(len, parts)])
    views = [
        {"buffer": 0, "byteOffset": int(at), "byteLength": len(part)} for at, part in zip(begin, parts, strict=False)
    ]
    views[0]["byteStride"] = padded.strides[0]
    types = {"<f4": 5126, "<i2": 5122, "<u2": 5123, "<i1": 5120}
    places = {"componentType": types[kind], "count": len(points), "type": "VEC3", "normalized": whole}
    if sparse:
        tight = stored.tobytes()
        views.append({"buffer": 0, "byteOffset": int(begin[-1]), "byteLength": len(tight)})
        parts.append(tight)
        rows = {"bufferView": 2, "componentType": 5123}
        places["sparse"] = {"count": len(points), "indices": rows, "values": {"bufferView": 3}}
    else:
        places["bufferView"] = 0
    data = base64.b64encode(b"".join(parts)).decode()
    said = {
        "asset": {"version": "2.0"},
        "buffers": [{"uri": f"data:application/octet-stream;base64,{data}", "byteLength": sum(map(len, parts))}],
        "bufferViews": views,
        "accessors": [places, {"bufferView": 1, "componentType": 5123, "count": int(indices.size), "type": "SCALAR"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "mode": 5 if strip else 4}]}],
        "nodes": [{"mesh": 0, "scale": [most if whole else 1.0] * 3, **(node or {})}],
        "scenes": [{"nodes": [0]}],
    }
    return json.dumps(said | more).encode()


@pytest.mark.parametrize("kind", ["<f4", "<i2", "<i1"])
@pytest.mark.parametrize("sparse", [False, True])
def test_arrays_of_glTF_are_read_as_they_are_packed(tmp_path, kind, sparse):
    box = forms.box(0.2, 0.03, 0.01)
    (tmp_path / "a.gltf").write_bytes(gltf(*box, kind, sparse=sparse))
    points, faces = read_mesh(tmp_path / "a.gltf")
    step = 0.1 / 127 if kind == "<i1" else 1e-5
    assert np.ptp(points, axis=0) == pytest.approx([0.2, 0.03, 0.01], abs=2 * step)
    assert volume_of(Surface(points, faces)) > 0


def test_a_strip_and_a_node_that_mirrors_keep_faces_outward(tmp_path):
    strip = np.array([3, 2, 6, 7, 4, 2, 0, 3, 1, 6, 5, 4, 1, 0])  # of a cube (F. Evans et al., 1996)
    corners = np.array([[1, 1, 1], [0, 1, 1], [1, 1, 0], [0, 1, 0], [1, 0, 1], [0, 0, 1], [0, 0, 0], [1, 0, 0]], float)
    cube = 0.1 * corners[[0, 1, 2, 3, 4, 5, 6, 7]]
    volumes = []
    for node in ({}, {"scale": [-1, 1, 1]}):
        (tmp_path / "a.gltf").write_bytes(gltf(cube[strip], None, strip=True, node=node))
        volumes.append(volume_of(Surface(*read_mesh(tmp_path / "a.gltf"))))
    assert np.abs(volumes) == pytest.approx([1e-3, 1e-3]) and volumes[0] * volumes[1] > 0


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"extensionsRequired": ["EXT_new"]}, "needs the extension EXT_new"),
        ({"asset": {"version": "1.0"}}, "asset.version = 1.0: expected 2.0"),
        ({"nodes": [{"mesh": 0, "skin": 0, "name": "arm"}]}, "node arm has a skin"),
        ({"nodes": [{"mesh": 0, "children": [0]}]}, "node 0 is there twice"),
        ({"nodes": [{"mesh": 3}]}, "meshes has no number 3: expected 0 to 0"),
        (
            {"nodes": [{"mesh": 0, "rotation": [0, 0, 0, 0]}]},
            "expected numbers .rotation = .* turns nothing",
        ),
        ({"meshes": [{"primitives": {"mode": 4}}]}, "a primitive 'mode': expected an object in an array"),
        ({"scenes": "first"}, r"scenes\[0\] = f: expected an object"),
        ({"buffers": [{"uri": "../a.bin"}]}, "a buffer in '../a.bin': expected a file in its folder"),
        ({"buffers": [{"uri": "b.bin"}]}, "its buffer b.bin: No such file"),
    ],
)
def test_wrong_gltf_files_are_refused_with_a_reason(tmp_path, more, said):
    (tmp_path / "a.gltf").write_bytes(gltf(*forms.box(0.2, 0.03, 0.01), **more))
    with pytest.raises(MeshError, match=said):
        read_mesh(tmp_path / "a.gltf")


def test_a_rotation_that_is_no_unit_quaternion_does_not_stretch(tmp_path):
    (tmp_path / "a.gltf").write_bytes(gltf(*forms.box(0.2, 0.03, 0.01), node={"rotation": [0, 0, 1, 1]}))
    points, _ = read_mesh(tmp_path / "a.gltf")
    assert np.ptp(points, axis=0) == pytest.approx([0.03, 0.2, 0.01])


def test_a_glTF_that_is_cut_says_it_once(tmp_path):
    said = json.loads(gltf(*forms.box(0.2, 0.03, 0.01)))
    said["accessors"][1]["count"] -= 1
    text = json.dumps(said).encode()
    head = struct.pack("<4sII", b"glTF", 2, 20 + len(text))
    for data, why in (
        (text, r"\d+ corners of triangles: expected a multiple of 3"),
        (head, "it holds no JSON: expected a whole .glb file"),
        (head + struct.pack("<II", len(text), 0x4E4F534A) + text[:-9], r"cut short: \d+ bytes: expected \d+ at least"),
        (struct.pack("<4sII", b"glTF", 1, 20), "a .glb file of version 1: expected 2"),
    ):
        file = tmp_path / ("a.gltf" if data is text else "a.glb")
        file.write_bytes(data)
        with pytest.raises(MeshError, match=rf"{file}: {why}$"):
            read_mesh(file)


def packed(extension, view=None):
    """Return a .gltf file whose only primitive, or bufferView, is of an extension."""
    return {
        "bufferViews": [{"buffer": 0, "byteLength": 4, **({"extensions": {extension: view}} if view else {})}],
        "buffers": [{"uri": "data:,AAAA", "byteLength": 4}],
    }


def test_packed_meshes_whose_library_is_missing_are_named_with_the_way_to_it(tmp_path, monkeypatch):
    import sys

    for name in ("DracoPy", "meshoptimizer"):
        monkeypatch.setitem(sys.modules, name, None)
    draco = {"POSITION": 0}, {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}}
    meshes = {"meshes": [{"primitives": [{"attributes": draco[0], "extensions": draco[1]}]}]}
    view = {"buffer": 0, "byteLength": 4, "byteStride": 12, "count": 8, "mode": "ATTRIBUTES"}
    for more, said in (
        (meshes, r"packed by KHR_draco_mesh_compression: pip install 'carom\[draco\]', or export it without"),
        (packed("EXT_meshopt_compression", view), r"pip install 'carom\[meshopt\]' .*gltfpack -i a.gltf"),
    ):
        (tmp_path / "a.gltf").write_bytes(gltf(*forms.box(0.2, 0.03, 0.01), **more))
        with pytest.raises(MeshError, match=said):
            read_mesh(tmp_path / "a.gltf")


def test_places_that_meshoptimizer_filtered_are_read(tmp_path, monkeypatch):
    """gltfpack -vpf: each number is an exponent of 8 bits and a mantissa of 24."""
    import sys
    from types import SimpleNamespace

    box = forms.box(0.2, 0.03, 0.01)
    mantissas, exponents = np.frexp(box.points)
    bits = (np.round(mantissas * 2**22).astype("<i4") & 0xFFFFFF) | ((exponents - 22).astype("<i4") << 24)
    rows = bits.astype("<i4").tobytes()
    stand_in = SimpleNamespace(decode_vertex_buffer=lambda count, stride, data, kind: np.frombuffer(data, np.uint8))
    monkeypatch.setitem(sys.modules, "meshoptimizer", SimpleNamespace(decoder=stand_in))
    said = json.loads(gltf(*box))
    for sieve, why in (("EXPONENTIAL", None), ("OCTAHEDRAL", "filter OCTAHEDRAL: .* no filter but EXPONENTIAL")):
        view = {"buffer": 1, "byteLength": len(rows), "byteStride": 12, "count": len(box.points)}
        view |= {"mode": "ATTRIBUTES", "filter": sieve}
        said["bufferViews"][0]["extensions"] = {"EXT_meshopt_compression": view}
        uri = f"data:;base64,{base64.b64encode(rows).decode()}"
        said["buffers"] = [said["buffers"][0], {"uri": uri, "byteLength": len(rows)}]
        (tmp_path / "a.gltf").write_text(json.dumps(said))
        if why:
            with pytest.raises(MeshError, match=why):
                read_mesh(tmp_path / "a.gltf")
        else:
            assert read_mesh(tmp_path / "a.gltf")[0] == pytest.approx(box.points, abs=1e-7)


def test_a_mesh_that_draco_packed_is_read(tmp_path):
    draco = needs.module("DracoPy")
    box = forms.box(0.2, 0.03, 0.01)
    data = draco.encode(box.points.astype(np.float32), faces=box.faces.astype(np.uint32), quantization_bits=14)
    extension = {"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}}
    more = {
        "buffers": [{"uri": f"data:,{base64.b64encode(data).decode()}", "byteLength": len(data)}],
        "bufferViews": [{"buffer": 0, "byteLength": len(data)}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "extensions": extension}]}],
        "extensionsRequired": ["KHR_draco_mesh_compression"],
    }
    (tmp_path / "a.gltf").write_bytes(gltf(*box, **more))
    points, faces = read_mesh(tmp_path / "a.gltf")
    assert volume_of(Surface(points, faces)) == pytest.approx(6e-5, rel=5e-3)


def test_a_mesh_whose_mass_tells_another_unit_is_asked_about(tmp_path):
    import carom

    box = forms.box(1.1, 0.9, 0.8)
    (tmp_path / "box.obj").write_bytes(obj(box.points, box.faces))
    with pytest.raises(MeshError, match=r"1.1 x 0.9 x 0.8 m, 6,217 kg: expected at most 500 kg; scale: 0.001 reads mm"):
        carom.mesh(tmp_path / "box.obj", tmp_path, "box", "steel")
