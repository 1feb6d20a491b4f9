"""Files, hosts and surfaces as others make them, from outside: what a process prints, and what a socket answers.

Pages, plug-ins and replies that nobody reads are tried by a browser, a host and sockets elsewhere: `test_web`,
`test_plugins` and `test_socket`, `test_unread`.
"""

import json
import socket
import struct

import numpy as np
import pytest
import soundfile

from carom.dsp.mesh import forms
from carom.server.osc import wire
from tests import needs

L = [(0, 0), (80, 0), (80, 20), (20, 20), (20, 60), (0, 60)]  # mm, from an inner corner on


def prism(outline, height, unit):
    """Return an .obj file of a prism, its caps one polygon each, its indices counted back."""
    points = [(x * unit, y * unit, z * unit) for z in (0, height) for x, y in outline]
    count = len(outline)
    low, high = list(range(count)), list(range(count, 2 * count))
    sides = [(n, (n + 1) % count, count + (n + 1) % count, count + n) for n in range(count)]
    rings = [[*low[3::-1], *low[:3:-1]], [*high[3:], *high[:3]], *sides]
    lines = [f"v {x:g} {y:g} {z:g}" for x, y, z in points]
    return "\n".join([*lines, *("f " + " ".join(str(n - 2 * count) for n in ring) for ring in rings)])


def mesh(carom, tmp_path, name, data, *options):
    """Return what `carom mesh` says of a file, and its exit code."""
    (tmp_path / name).write_bytes(data if isinstance(data, bytes) else data.encode())
    done = carom("mesh", name, "mine", "--name", "a", "--material", "steel", "--no-report", "--modes", "6", *options)
    assert "Traceback" not in done.stderr
    return done.stderr, done.returncode


def test_a_concave_polygon_whose_indices_count_back_has_its_mass(carom, tmp_path):
    """So heavy a body is asked about before its modes are computed."""
    needs.module("mapbox_earcut")
    said, code = mesh(carom, tmp_path, "l.obj", prism(L, 50, 1e-2))
    kilograms = 7850 * (80 * 20 + 20 * 40) * 50e-6
    assert code == 1 and f"0.8 x 0.6 x 0.5 m, {kilograms:,.0f} kg: expected" in said


def quantized(size):
    """Return a .glb file of a box as gltfpack writes it: normalised shorts, and a node that scales them."""
    box = forms.box(*size)
    most = float(np.abs(box.points).max())
    body = np.zeros((len(box.points), 4), "<i2")
    body[:, :3] = np.round(box.points / most * 32767)
    parts = [body.tobytes(), box.faces.astype("<u2").tobytes()]
    views = [{"buffer": 0, "byteOffset": 0, "byteLength": len(parts[0]), "byteStride": 8}]
    views.append({"buffer": 0, "byteOffset": len(parts[0]), "byteLength": len(parts[1])})
    places = {"bufferView": 0, "componentType": 5122, "count": len(body), "type": "VEC3", "normalized": True}
    faces = {"bufferView": 1, "componentType": 5123, "count": box.faces.size, "type": "SCALAR"}
    said = {
        "asset": {"version": "2.0"},
        "extensionsRequired": ["KHR_mesh_quantization"],
        "buffers": [{"byteLength": sum(map(len, parts))}],
        "bufferViews": views,
        "accessors": [places, faces],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0, "scale": [most] * 3}],
        "scenes": [{"nodes": [0]}],
    }
    text, data = json.dumps(said).encode(), b"".join(parts)
    text, data = text.ljust(-(-len(text) // 4) * 4), data.ljust(-(-len(data) // 4) * 4, b"\0")
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def stl(size, count, tail=b""):
    """Return a binary .stl file of a box, whose head tells a count, and that ends in a tail."""
    box = forms.box(*size)
    facets = b"".join(struct.pack("<12fH", 0, 0, 0, *box.points[face].ravel(), 0) for face in box.faces)
    return bytes(80) + struct.pack("<I", count) + facets + tail


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        ("zero.obj", prism(L, 10, 1e-3).replace(" -12", " 0"), ": a face of point 0: expected 1 and above"),
        ("mm.obj", prism(L, 10, 1.0), "80 x 60 x 10 m: expected 0.003 to 3 m; scale: 0.001 reads mm, 0.01 cm"),
        ("cm.stl", stl((9, 1.35, 0.45), 0), "9 x 1.35 x 0.45 m: expected 0.003 to 3 m"),
        ("tail.stl", stl((9, 1.35, 0.45), 16, b"made by"), "9 x 1.35 x 0.45 m: expected 0.003 to 3 m"),
        ("packed.glb", quantized((9, 1.35, 0.45)), "9 x 1.35 x 0.45 m: expected 0.003 to 3 m"),
        ("new.glb", quantized((9, 1, 1)).replace(b"KHR_mesh_quantization", b"EXT_mesh_quantization"), "needs the ext"),
    ],
)
def test_a_mesh_is_read_as_it_is_meant_or_refused_with_its_size(carom, tmp_path, name, data, said):
    needs.module("mapbox_earcut")
    told, code = mesh(carom, tmp_path, name, data)
    assert code == 1 and said in told and told.count("\n") == 1


@pytest.mark.slow
def test_the_channel_of_a_recording_that_is_struck_is_fitted(carom, tmp_path):
    t = np.arange(11_025) / 22_050
    hit = 0.05 * np.sin(2 * np.pi * 440 * t) * np.exp(-12 * t) * (t > 0.05)
    soundfile.write(tmp_path / "two.wav", np.stack([0.3 * np.sin(2 * np.pi * 50 * t), hit], axis=1), 22_050)
    done = carom("fit", "two.wav", "mine", "--name", "a", "--licence", "CC0", "--no-report")
    assert done.returncode == 0 and "2 channels: channel 2 is taken, where most rises and decays" in done.stderr
    (tmp_path / "a.m4a").write_bytes(b"\0\0\0\x1cftypM4A " + bytes(16))
    done = carom("fit", "a.m4a", "mine", "--name", "a")
    assert done.returncode == 1 and "ffmpeg -i a.m4a a.wav" in done.stderr and done.stderr.count("\n") == 1


@pytest.mark.slow
@pytest.mark.parametrize("mark", [wire.encode("/c_set", 0, 0), b"\0\0\0\0,\0\0\0"], ids=["c_set", "zero"])
def test_a_score_of_SuperCollider_is_as_long_as_its_end_mark_says(carom, tmp_path, mark):
    packets = [(0, wire.encode("/object/new", "bell", "church-bell")), (0, wire.encode("/object/bell/impact", 1.0))]
    bundles = [
        b"#bundle\0" + struct.pack(">IIi", second, 0, len(each)) + each for second, each in [*packets, (1, mark)]
    ]
    (tmp_path / "a.osc").write_bytes(b"".join(struct.pack(">i", len(each)) + each for each in bundles))
    assert carom("render", "a.osc", "a.wav").returncode == 0
    assert soundfile.info(tmp_path / "a.wav").duration == 1.0


@pytest.mark.slow
def test_surfaces_and_languages_are_understood_or_told_what_is_wrong(server):
    """Buttons; arguments inside the address; an array of sclang's, which is a blob; a stream without framing."""
    with server.client() as client:
        client.new("a", "church-bell")
        for address in ("/panic", "/gesture/x/stop"):
            for value in (1, 1.0, True, None, 0, 0.0, False):
                client.send(address, value)
        client.ask("/sync", 1)
        told = [str(each) for each in client.errors()]
        assert len(told) == 4 and all("x: no such gesture is running" in each for each in told), told
        client.send("/object/new b church-bell")
        client.send("/object/a/place", wire.encode("/x", 0.5, 0.5))
        client.ask("/sync", 2)
        inside, blob = [str(each) for each in client.errors()]
        assert "arguments inside the address: expected the address /object/new alone" in inside
        assert "which SuperCollider makes of an array (send $[, its values, $])" in blob
    with socket.create_connection(("127.0.0.1", server.port), timeout=5) as stream:
        stream.sendall(wire.encode("/version"))
        assert b"OSC without framing: expected an END (c0) after each packet" in stream.recv(1_024)
