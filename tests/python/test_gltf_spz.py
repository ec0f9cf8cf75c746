"""glTF whose Gaussian splats are packed as SPZ: what is unpacked stands where the file places it,
and broken files end in an error that names where."""

import base64
import gzip
import json
import os
import struct
import tempfile
import tracemalloc

import numpy as np
import pytest
import splat_bytes
from conftest import write_gltf
from hypothesis import given, settings
from hypothesis import strategies as st
from splat_files import ARRAYS

import omma
from omma.job.info import describe_file
from omma.scene import load_splats
from omma.scene.files import read_scene
from omma.scene.gltf_text import names_splats

BASE = "KHR_gaussian_splatting"
NESTED = f"{BASE}_compression_spz_2"
OLDER = f"{BASE}_compression_spz"
ALONE = "KHR_spz_gaussian_splats_compression"
SHOWN = {"kernel": "ellipse", "colorSpace": "srgb_rec709_display"}
TURN = [0, np.sin(0.3), 0, np.cos(0.3)]


def primitive(view, name=NESTED, count=None, **base):
    attributes = {} if count is None else {"POSITION": 0}
    if name == ALONE:
        return {"mode": 0, "attributes": attributes, "extensions": {ALONE: {"bufferView": view}}}
    inside = {**SHOWN, **base, "extensions": {name: {"bufferView": view}}}
    return {"mode": 0, "attributes": attributes, "extensions": {BASE: inside}}


def document_of(blobs, primitives, nodes=None, **more):
    """A document of buffer views in buffer 0, a mesh of each list of primitives, and nodes."""
    at, views = 0, []
    for blob in blobs:
        views.append({"buffer": 0, "byteOffset": at, "byteLength": len(blob)})
        at += -(-len(blob) // 4) * 4
    names = [BASE, NESTED]
    found = {
        "asset": {"version": "2.0"},
        "extensionsUsed": names,
        "extensionsRequired": names,
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes or primitives)))}],
        "nodes": nodes or [{"mesh": k, "name": f"n{k}"} for k in range(len(primitives))],
        "meshes": [{"primitives": each} for each in primitives],
        "bufferViews": views,
        "buffers": [{"byteLength": at}],
    }
    return {**found, **more}, b"".join(one + b"\0" * (-len(one) % 4) for one in blobs)


def write_glb(path, document, binary):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    path.write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks)
    return path


def blob(count=30, terms=4, version=2, seed=1, **more):
    return splat_bytes.spz(splat_bytes.raw_splats(count, terms, seed), version, **more)


def alone(tmp_path, data, name="alone.spz"):
    """The same as a file of its own."""
    (tmp_path / name).write_bytes(data)
    return load_splats(tmp_path / name)


def check_same(found, wanted):
    for name in ARRAYS:
        assert np.array_equal(getattr(found, name), getattr(wanted, name)), name


@pytest.fixture(autouse=True)
def own_temporary_folder(tmp_path_factory, monkeypatch):
    """Nothing is left in it."""
    folder = tmp_path_factory.mktemp("temporary")
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    yield
    assert os.listdir(folder) == []


@pytest.mark.parametrize("version", [2, 3, 4])
@pytest.mark.parametrize("name", [NESTED, OLDER, ALONE])
def test_every_name_and_version(tmp_path, name, version):
    if version == 4:
        pytest.importorskip("zstandard")
    data = blob(version=version)
    names = [name] if name == ALONE else [BASE, name]
    document, binary = document_of(
        [data], [[primitive(0, name)]], extensionsUsed=names, extensionsRequired=names
    )
    shares = []
    path = write_glb(tmp_path / "a.glb", document, binary)
    scene = read_scene(path, progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1
    (cloud,) = scene.splats
    check_same(cloud, alone(tmp_path, data))
    assert (cloud.name, cloud.color_space, cloud.direction) == ("n0", "srgb", "center")
    assert np.array_equal(cloud.world_from_splats, np.eye(4))
    assert scene.path == str(path)
    told = [f"{path}: mesh 0, primitive 0: names no colour space of its splats; sRGB is taken, as "
            "3DGS trains"] if name == ALONE else []  # fmt: skip
    assert scene.warnings == told


def test_they_stand_where_nodes_place_them_beside_others(tmp_path):
    """Meshes, splats that are not packed, two clouds in one mesh, one mesh under two nodes."""
    data, other = blob(20, 1), blob(50, 9, seed=2)
    triangle = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes()
    plain = np.array([[0.5, 0.25, 0.125]], "<f4").tobytes()
    rest = np.array([0, 0, 0, 1, 1, 1, 1, 0.5, 0, 0, 0], "<f4").tobytes()

    def accessor(view, kind, count, offset=0, **more):
        return {
            "bufferView": view, "componentType": 5126, "type": kind, "count": count,
            "byteOffset": offset, **more,
        }  # fmt: skip

    accessors = [
        accessor(2, "VEC3", 3, min=[0, 0, 0], max=[1, 1, 0]),
        accessor(3, "VEC3", 1, min=[0.5, 0.25, 0.125], max=[0.5, 0.25, 0.125]),
        accessor(4, "VEC4", 1),
        accessor(4, "VEC3", 1, 16),
        accessor(4, "SCALAR", 1, 28),
        accessor(4, "VEC3", 1, 32),
    ]
    unpacked = {
        "mode": 0,
        "attributes": {
            "POSITION": 1,
            f"{BASE}:ROTATION": 2,
            f"{BASE}:SCALE": 3,
            f"{BASE}:OPACITY": 4,
            f"{BASE}:SH_DEGREE_0_COEF_0": 5,
        },
        "extensions": {BASE: SHOWN},
    }
    document, binary = document_of(
        [data, other, triangle, plain, rest],
        [[primitive(0), {"attributes": {"POSITION": 0}}, primitive(1)], [unpacked]],
        [
            {"mesh": 0, "name": "a", "translation": [1, 2, 3], "scale": [2, 2, 2]},
            {"mesh": 1, "name": "b"},
            {"name": "turned", "rotation": TURN, "children": [3]},
            {"mesh": 0, "name": "c", "translation": [0, 0, -5]},
            {"mesh": 0, "name": "elsewhere"},
        ],
        accessors=accessors,
        scenes=[{"nodes": [0, 1, 2]}, {"nodes": [4]}],
    )
    path = write_glb(tmp_path / "a.glb", document, binary)
    scene = omma.load_scene(path)
    first, second = alone(tmp_path, data), alone(tmp_path, other)
    assert [cloud.name for cloud in scene.splats] == ["a", "a", "b", "c", "c"]
    for cloud, wanted in zip(scene.splats, (first, second, None, first, second), strict=True):
        if wanted is not None:
            check_same(cloud, wanted)
    assert scene.splats[2].positions_m.tolist() == [[0.5, 0.25, 0.125]]
    moved = np.diag([2.0, 2, 2, 1])
    moved[:3, 3] = 1, 2, 3
    assert np.array_equal(scene.splats[1].world_from_splats, moved)
    c, s = np.cos(0.6), np.sin(0.6)
    there = [[c, 0, s, -5 * s], [0, 1, 0, 0], [-s, 0, c, -5 * c], [0, 0, 0, 1]]
    assert scene.splats[3].world_from_splats == pytest.approx(np.array(there))
    assert [one.name for one in scene.instances] == ["a", "c"]
    assert scene.triangle_count == 2
    (only, _) = omma.load_scene(path, 1).splats
    assert only.name == "elsewhere"
    up = omma.load_scene(path, up="z", unit="mm").splats[0].world_from_splats
    assert up[:3, 3] == pytest.approx([0.001, 0.003, -0.002])


@pytest.mark.parametrize("kind", ["beside", "below", "data"])
def test_text_files_whose_buffers_are_elsewhere(tmp_path, kind):
    """With a mesh and a picture of the scene's own, in files beside it."""
    path = write_gltf(tmp_path / "a.gltf")
    document = json.loads(path.read_text())
    data = blob()
    if kind == "data":
        uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    else:
        uri = "packed%20splats.spz" if kind == "beside" else "below/packed.spz"
        (tmp_path / "below").mkdir()
        (tmp_path / uri.replace("%20", " ")).write_bytes(data)
    document["buffers"].append({"uri": uri, "byteLength": len(data)})
    view = {"buffer": len(document["buffers"]) - 1, "byteLength": len(data)}
    document["bufferViews"].append(view)
    document["meshes"].append({"primitives": [primitive(len(document["bufferViews"]) - 1)]})
    document["nodes"].append({"mesh": len(document["meshes"]) - 1, "name": "shrub"})
    document["scenes"][0]["nodes"].append(len(document["nodes"]) - 1)
    before = omma.load_scene(path)
    path.write_text(json.dumps(document))
    scene = omma.load_scene(path)
    check_same(scene.splats[0], alone(tmp_path, data))
    assert scene.replace(splats=[]) == before


def test_they_are_seen_as_splats_of_a_file_of_their_own(tmp_path, run_omma, monkeypatch):
    data = blob(200, 4, 3)
    node = {"mesh": 0, "name": "shrub", "translation": [0, 0, -3]}
    document, binary = document_of([data], [[primitive(0)]], [node])
    path = write_glb(tmp_path / "a.glb", document, binary)
    placed = np.eye(4)
    placed[2, 3] = -3
    wanted = omma.Scene(
        splats=[alone(tmp_path, data).replace(world_from_splats=placed, name="shrub")]
    )
    eye = omma.eye.generate_eye(40)
    seen, alike = (
        omma.Renderer(one, eye, omma.Fixed(16)).render(np.eye(4))
        for one in (omma.load_scene(path), wanted)
    )
    assert seen.tobytes() == alike.tobytes()
    assert np.ptp(seen) > 0.01
    lines = dict(describe_file(path))
    assert lines["splats"].startswith("200 Gaussian splats of shrub, harmonics of degree 1")
    monkeypatch.chdir(tmp_path)
    omma.save_eye("e.csv", eye)
    words = ("--eye", "e.csv", "--position", 0, 0, 0, "-o", "r.npy")
    assert run_omma("render", "a.glb", *words)[0] == 0
    assert np.load("r.npy").tobytes() == seen.tobytes()


def test_what_the_extension_says_is_kept(tmp_path):
    document, binary = document_of(
        [blob()], [[primitive(0, colorSpace="lin_rec709_display", extras={"direction": "ray"})]]
    )
    (cloud,) = omma.load_scene(write_glb(tmp_path / "a.glb", document, binary)).splats
    assert (cloud.color_space, cloud.direction) == ("linear", "ray")


def test_what_there_is_to_warn_of(tmp_path):
    one = primitive(0, count=29)
    del one["extensions"][BASE]["colorSpace"]
    document, binary = document_of(
        [blob(30, 1, 3, bits=0)],
        [[one]],
        accessors=[{"componentType": 5126, "type": "VEC3", "count": 29}],
    )
    path = write_glb(tmp_path / "a.glb", document, binary)
    place = f"{path}: mesh 0, primitive 0: "
    assert read_scene(path).warnings == [
        f"{place}says 29 splats, its SPZ has 30",
        f"{place}names no colour space of its splats; sRGB is taken, as 3DGS trains",
    ]
    columns = splat_bytes.raw_splats(200, 1)
    columns["x"][7] = 3e6  # of 200, so that it is no place of the cloud
    document, binary = document_of([splat_bytes.spz(columns, 3, bits=1)], [[primitive(0)]])
    path = write_glb(tmp_path / "b.glb", document, binary)
    with pytest.warns(UserWarning, match="primitive 0: 1 splats are left out: position beyond 1e6"):
        (cloud,) = omma.load_scene(path).splats
    assert len(cloud.positions_m) == 199


def changed(data, **head):
    """Another head before the same splats."""
    raw = bytearray(gzip.decompress(data))
    for at, code, value in head.values():
        struct.pack_into(code, raw, at, value)
    return gzip.compress(bytes(raw))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (blob()[:-9], "SPZ: expected a whole gzip file, found its end"),
        (gzip.compress(gzip.decompress(blob())[:-5]), "bytes more of its splats, found the end"),
        (
            b"splats",
            "SPZ: expected a file of .spz, of gzip or NGSP, found a file that begins with 'spla'",
        ),
        (b"", "SPZ: expected a file of .spz"),
        (changed(blob(), count=(8, "<I", 1 << 30)), "expected 1,073,741,824 splats as its head"),
        (changed(blob(), count=(8, "<I", 0)), "expected Gaussian splats, found none"),
        (changed(blob(), degree=(12, "<B", 3)), "bytes more of its splats"),
        (changed(blob(), degree=(12, "<B", 4)), "degree 0 to 3, found degree 4"),
        (gzip.compress(gzip.decompress(blob()) + bytes(1 << 22)), "expected the end after 30"),
    ],
)
def test_broken_spz(tmp_path, data, message):
    document, binary = document_of([data], [[{"attributes": {}}], [primitive(0)]])
    document["meshes"][1]["name"] = "shrub"
    path = write_glb(tmp_path / "a.glb", document, binary)
    with pytest.raises(omma.Error) as told:
        omma.load_scene(path)
    assert str(told.value).startswith(f'{path}: mesh 1 "shrub", primitive 0: SPZ')
    assert message in str(told.value)


def without(document, *keys):
    for key in keys[:-1]:
        document = document[key]
    del document[keys[-1]]


def put(document, value, *keys):
    for key in keys[:-1]:
        document = document[key]
    document[keys[-1]] = value


IN_FILE = ("meshes", 0, "primitives", 0)
PACKED = (*IN_FILE, "extensions", BASE, "extensions", NESTED)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: put(d, 3, *PACKED, "bufferView"), "refers to buffer view 3, there are 1"),
        (lambda d: put(d, -1, *PACKED, "bufferView"), "refers to buffer view -1"),
        (lambda d: put(d, "0", *PACKED, "bufferView"), "bufferView: expected a whole number"),
        (lambda d: put(d, True, *PACKED, "bufferView"), "bufferView: expected a whole number"),
        (lambda d: without(d, *PACKED, "bufferView"), "bufferView: expected a whole number"),
        (lambda d: put(d, [], *PACKED), "spz_2: expected an object"),
        (lambda d: put(d, 7, *IN_FILE, "extensions", BASE), "splatting: expected an object"),
        (lambda d: put(d, 5, *IN_FILE, "attributes"), "attributes: expected an object"),
        (lambda d: put(d, {}, "meshes"), "meshes: expected an array"),
        (lambda d: put(d, 1 << 20, "bufferViews", 0, "byteLength"), "found the end of buffer 0"),
        (lambda d: put(d, -4, "bufferViews", 0, "byteOffset"), "of 0 or more"),
        (lambda d: put(d, 1, "bufferViews", 0, "buffer"), "refers to buffer 1, there are 1"),
        (lambda d: put(d, "../x.bin", "buffers", 0, "uri"), "expected a file in the folder"),
        (lambda d: put(d, "gone.bin", "buffers", 0, "uri"), "expected a file in the folder"),
        (lambda d: put(d, "data:;base64,!", "buffers", 0, "uri"), "expected a data URI"),
        (lambda d: put(d, "data:;base64", "buffers", 0, "uri"), "expected a data URI"),
        (lambda d: put(d, 4, *IN_FILE, "mode"), "mode: expected 0, points"),
        (lambda d: put(d, "x", *IN_FILE, "extensions", BASE, "colorSpace"), "colorSpace: expected"),
        (lambda d: put(d, 9, "nodes", 0, "mesh"), "refers to mesh 9"),
        (lambda d: d["extensionsRequired"].append("KHR_x"), "requires the glTF extension KHR_x"),
        (lambda d: put(d, "1.0", "asset", "version"), "expected glTF 2.0"),
    ],
)
def test_broken_documents(tmp_path, change, message):
    document, binary = document_of([blob()], [[primitive(0)]])
    change(document)
    path = write_glb(tmp_path / "a.glb", document, binary)
    with pytest.raises(omma.Error) as told:
        omma.load_scene(path)
    assert str(told.value).startswith(f"{path}: ")
    assert message in str(told.value)


def test_what_progress_raises_is_the_callers(tmp_path):
    document, binary = document_of([blob()], [[primitive(0)]])
    path = write_glb(tmp_path / "a.glb", document, binary)
    for limit in (0.1, 0.9):

        def stop(share, limit=limit):
            if share > limit:
                raise ZeroDivisionError("enough")

        with pytest.raises(ZeroDivisionError, match="enough"):
            omma.load_scene(path, progress=stop)


@settings(max_examples=150, deadline=None)
@given(at=st.floats(0, 1), byte=st.integers(0, 255), cut=st.booleans())
def test_changed_files_end_in_an_error_or_a_scene(tmp_path_factory, at, byte, cut):
    document, binary = document_of([blob(5, 1)], [[primitive(0)]])
    path = write_glb(tmp_path_factory.mktemp("changed") / "a.glb", document, binary)
    data = bytearray(path.read_bytes())
    where = min(int(at * len(data)), len(data) - 1)
    data[where] = byte
    path.write_bytes(data[:where] if cut else data)
    said = ""
    try:
        read_scene(path)
    except omma.Error as error:
        said = str(error)
    assert said == "" or str(path) in said


def test_a_job_of_them(tmp_path):
    pytest.importorskip("zarr")
    from dataset_jobs import write_job

    job = write_job(tmp_path / "job", count=2, dataset='outputs = ["responses", "truth"]\n')
    large = {"mesh": 0, "scale": [20, 20, 20]}
    document, binary = document_of([blob()], [[primitive(0)]], [large])
    write_glb(tmp_path / "job/scene.glb", document, binary)
    job.write_text(job.read_text().replace("scene.gltf", "scene.glb"))
    omma.datasets.run(job, tmp_path / "out.zarr")
    views = omma.datasets.open_views(tmp_path / "out.zarr", ["source_distance"])
    assert np.isfinite(views[[0, 1]]["source_distance"]).any()


def test_a_large_file_is_not_read_to_see_what_it_names(tmp_path):
    """Of a text with its buffers in it no more is in memory than it takes to look through it."""
    path = tmp_path / "large.gltf"
    path.write_text('{"asset":{"version":"2.0"},"extras":"' + "A" * 50_000_000 + '"}')
    tracemalloc.start()
    try:
        found = names_splats(str(path))
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert not found
    assert peak < 1_000_000
    path.write_text('{"extensionsUsed":["KHR_gaussian_splatting"]}')
    assert names_splats(str(path))
    for odd in (b"", b"glTF", b"glTF" + bytes(16), b"glTF" + 16 * b"\xff"):
        path.write_bytes(odd)
        assert not names_splats(str(path))
