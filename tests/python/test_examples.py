"""The bundled meadow and honeybee eyes: glTF 2.0's rules and the eye's model."""

import io
import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import omma

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
MEADOW = EXAMPLES / "meadow.glb"
COMPONENTS = {5121: np.dtype("u1"), 5123: np.dtype("<u2"), 5126: np.dtype("<f4")}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


@pytest.fixture(scope="module")
def meadow():
    """(document, binary chunk) of meadow.glb."""
    data = MEADOW.read_bytes()
    json_length = int.from_bytes(data[12:16], "little")
    return json.loads(data[20 : 20 + json_length]), data[28 + json_length :]


def accessor(meadow, index):
    """The values of an accessor, (count, width), after checking that they lie where they may."""
    document, blob = meadow
    entry = document["accessors"][index]
    view = document["bufferViews"][entry["bufferView"]]
    dtype, width = COMPONENTS[entry["componentType"]], WIDTHS[entry["type"]]
    stride = view.get("byteStride", dtype.itemsize * width)
    offset = entry.get("byteOffset", 0)
    assert offset % dtype.itemsize == 0
    assert (view["byteOffset"] + offset) % dtype.itemsize == 0
    assert offset + stride * (entry["count"] - 1) + dtype.itemsize * width <= view["byteLength"]
    return np.ndarray(
        (entry["count"], width),
        dtype,
        blob,
        view["byteOffset"] + offset,
        (stride, dtype.itemsize),
    )


def primitives(document):
    return [p for mesh in document["meshes"] for p in mesh["primitives"]]


def test_container_is_sound_and_small():
    data = MEADOW.read_bytes()
    assert len(data) < 3_000_000
    assert data[:4] == b"glTF"
    assert int.from_bytes(data[4:8], "little") == 2
    assert int.from_bytes(data[8:12], "little") == len(data)
    json_length = int.from_bytes(data[12:16], "little")
    assert json_length % 4 == 0
    assert data[16:20] == b"JSON"
    binary_length = int.from_bytes(data[20 + json_length : 24 + json_length], "little")
    assert binary_length % 4 == 0
    assert data[24 + json_length : 28 + json_length] == b"BIN\0"
    assert 28 + json_length + binary_length == len(data)
    document = json.loads(data[20 : 20 + json_length])
    assert document["buffers"] == [{"byteLength": binary_length}]
    assert document["asset"]["version"] == "2.0"
    assert document["asset"]["generator"]
    assert document["asset"]["copyright"]
    # Nothing is needed beyond the core of glTF: a reader may ignore that the materials are unlit.
    assert document["extensionsUsed"] == ["KHR_materials_unlit"]
    assert "extensionsRequired" not in document


def test_buffer_views_are_aligned_and_inside_the_buffer(meadow):
    document, blob = meadow
    images = {image["bufferView"] for image in document["images"]}
    attributes, indices = set(), set()
    for primitive in primitives(document):
        indices.add(document["accessors"][primitive["indices"]]["bufferView"])
        for index in primitive["attributes"].values():
            attributes.add(document["accessors"][index]["bufferView"])
    for i, view in enumerate(document["bufferViews"]):
        assert view["byteOffset"] % 4 == 0
        assert view["byteOffset"] + view["byteLength"] <= len(blob)
        expected = {34962} if i in attributes else {34963} if i in indices else {None}
        assert {view.get("target")} == expected
        assert ("byteStride" in view) == (i in attributes)
        assert view.get("byteStride", 4) % 4 == 0
        assert (i in attributes) + (i in indices) + (i in images) == 1


def test_accessors_hold_what_they_claim(meadow):
    document, _ = meadow
    for primitive in primitives(document):
        position = accessor(meadow, primitive["attributes"]["POSITION"])
        entry = document["accessors"][primitive["attributes"]["POSITION"]]
        assert np.isfinite(position).all()
        # Exactly: the specification wants the smallest and largest value as stored.
        assert position.min(axis=0).tolist() == entry["min"]
        assert position.max(axis=0).tolist() == entry["max"]
        for name, index in primitive["attributes"].items():
            values = accessor(meadow, index)
            assert len(values) == len(position)
            if name == "COLOR_0":
                assert document["accessors"][index]["normalized"] is True
                assert (values[:, 3] == 255).all()
            elif name == "TEXCOORD_0":
                assert np.isfinite(values).all()
        index = accessor(meadow, primitive["indices"])
        restart = np.iinfo(index.dtype).max
        assert len(index) % 3 == 0
        assert index.max() < min(len(position), restart)
        assert len(np.unique(index)) == len(position), "a vertex that no triangle uses"
        triangles = position[index.reshape(-1, 3)].astype(float)
        edges = triangles[:, 1:] - triangles[:, :1]
        area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1) / 2
        assert (area > 0).all(), "a triangle without area"


def test_nodes_form_trees_of_proper_transforms(meadow):
    document, _ = meadow
    nodes = document["nodes"]
    assert len(document["scenes"]) == 1
    roots = document["scenes"][document["scene"]]["nodes"]
    reached = list(roots)
    for index in reached:
        reached += nodes[index].get("children", [])
        assert len(reached) <= len(nodes), "a node with two parents"
    assert sorted(reached) == list(range(len(nodes)))
    for node in nodes:
        # The Khronos validator allows 5e-5 or more; these are rounded to 7 digits.
        assert abs(np.linalg.norm(node.get("rotation", [0, 0, 0, 1])) - 1) < 1e-6
        assert np.isfinite(node.get("translation", [0, 0, 0])).all()
        assert min(node.get("scale", [1])) > 0


def test_nothing_is_nameless_and_nothing_lies_unused(meadow):
    document, _ = meadow
    for key in ("nodes", "meshes", "materials", "textures", "images", "cameras", "scenes"):
        names = [entry["name"] for entry in document[key]]
        assert all(names)
        assert len(set(names)) == len(names), f"{key}: a name twice"
    parts = primitives(document)
    used = {
        "meshes": {n["mesh"] for n in document["nodes"] if "mesh" in n},
        "cameras": {n["camera"] for n in document["nodes"] if "camera" in n},
        "materials": {p["material"] for p in parts},
        "accessors": {i for p in parts for i in (p["indices"], *p["attributes"].values())},
        "textures": {
            m["pbrMetallicRoughness"]["baseColorTexture"]["index"]
            for m in document["materials"]
            if "baseColorTexture" in m["pbrMetallicRoughness"]
        },
        "images": {t["source"] for t in document["textures"]},
        "samplers": {t["sampler"] for t in document["textures"]},
    }
    used["bufferViews"] = {document["accessors"][i]["bufferView"] for i in used["accessors"]}
    used["bufferViews"] |= {image["bufferView"] for image in document["images"]}
    for key, indices in used.items():
        assert indices == set(range(len(document[key]))), key


def test_images_decode_and_cutouts_have_holes(meadow):
    image_module = pytest.importorskip("PIL.Image", reason="Pillow decodes the textures here")
    document, blob = meadow
    pictures = []
    for entry in document["images"]:
        view = document["bufferViews"][entry["bufferView"]]
        data = blob[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
        picture = image_module.open(io.BytesIO(data))
        picture.load()
        assert image_module.MIME[picture.format] == entry["mimeType"]
        pictures.append(picture)
    masks = 0
    for material in document["materials"]:
        texture = material["pbrMetallicRoughness"].get("baseColorTexture")
        picture = pictures[document["textures"][texture["index"]]["source"]] if texture else None
        if material.get("alphaMode") == "MASK":
            opaque = np.asarray(picture)[..., 3] >= 255 * material["alphaCutoff"]
            assert 0.1 < opaque.mean() < 0.9
            masks += 1
        elif picture:
            assert picture.mode == "RGB"
    assert masks == 2


def test_meadow_loads_without_warnings_and_is_a_meadow(meadow):
    document, _ = meadow
    scene = omma.load_scene(MEADOW)
    assert list(scene.warnings) == []
    stored = [document["accessors"][p["indices"]]["count"] // 3 for p in primitives(document)]
    drawn = sum(stored[node["mesh"]] for node in document["nodes"] if "mesh" in node)
    assert scene.triangle_count == drawn
    assert scene.instance_count == sum("mesh" in node for node in document["nodes"])
    assert 200_000 < drawn < 700_000
    assert scene.background.type == "simple_sky"
    assert [camera.name for camera in scene.cameras] == ["bee", "bee-low", "overview"]
    for camera in scene.cameras:
        assert math.radians(30) < camera.yfov_rad < math.radians(90)
    # Seen from anywhere in the meadow the land goes on to the hills, and the hills are higher.
    land = accessor(
        meadow, primitives(document)[mesh_of(document, "land")]["attributes"]["POSITION"]
    )
    distance = np.hypot(land[:, 0], land[:, 2])
    assert land[:, [0, 2]].min() < -150
    assert land[:, [0, 2]].max() > 150
    ring = land[(distance > 140) & (distance < 175), 1]
    assert ring.min() > land[distance < 30, 1].max() + 3
    # The bee flies within flowers, above the ground.
    eye = scene.camera("bee").world_from_camera[:3, 3]
    nearest = land[np.argmin(np.hypot(land[:, 0] - eye[0], land[:, 2] - eye[2]))]
    assert 0.4 < eye[1] - nearest[1] < 1.1


def mesh_of(document, name):
    return next(node["mesh"] for node in document["nodes"] if node["name"] == name)


def test_bee_sees_sky_above_and_green_below():
    scene = omma.load_scene(MEADOW)
    axis = np.array([[0, 1, 0], [0, -0.8, -0.6]])
    # The lower one is wide: the average over the grass in front, not one blade of it.
    eye = omma.Eye(np.zeros((2, 3)), axis, np.radians([0.1, 40]))
    up, down = omma.Renderer(scene, eye, omma.Fixed(256)).render("bee")[0]
    # The simple sky goes linearly in elevation from the horizon to the zenith; the head is tilted.
    head_up = scene.camera("bee").world_from_camera[:3, 1]
    fraction = math.asin(head_up[1]) / (math.pi / 2)
    horizon, zenith = np.array([143, 179, 203]) / 255 * 0.8, np.array([1, 31, 117]) / 255
    # 0.1 degrees of acceptance is 0.001 of the way from horizon to zenith.
    np.testing.assert_allclose(up, horizon + (zenith - horizon) * fraction, atol=0.001)
    assert down[1] > down[0] > down[2]
    assert 0.03 < down[1] < 0.4


# Honeybee eyes


@pytest.fixture(scope="module")
def right():
    return np.loadtxt(EXAMPLES / "honeybee_worker_right.eye", delimiter=" ")


def azimuth_elevation_deg(axis):
    """Azimuth from straight ahead to the right, -90 to 270 degrees, as it passes 180 behind."""
    azimuth = np.degrees(np.arctan2(axis[:, 0], axis[:, 2]))
    elevation = np.degrees(np.arcsin(axis[:, 1]))
    return np.where(azimuth < -90, azimuth + 360, azimuth), elevation


def six_neighbour_angle_deg(axis):
    """[ommatidium]: mean angle to its six nearest neighbours, by brute force."""
    mean = []
    for part in np.array_split(axis, 20):
        # Chords, not cosines: the cosine of a small angle has no digits left.
        chord = np.linalg.norm(part[:, None, :] - axis[None, :, :], axis=2)
        nearest = np.sort(np.partition(chord, 6, axis=1)[:, :7], axis=1)[:, 1:]
        mean.append(np.degrees(2 * np.arcsin(nearest / 2)).mean(axis=1))
    return np.concatenate(mean)


def test_eye_files_are_plain_and_small():
    for side in ("left", "right"):
        text = (EXAMPLES / f"honeybee_worker_{side}.eye").read_text(encoding="ascii")
        assert len(text) < 500_000
        assert text.endswith("\n")
        for line in text.splitlines():
            fields = line.split(" ")
            assert len(fields) == 8
            assert all(len(field) <= 15 and math.isfinite(float(field)) for field in fields)


def test_left_eye_mirrors_the_right(right):
    left = np.loadtxt(EXAMPLES / "honeybee_worker_left.eye", delimiter=" ")
    assert (left * [-1, 1, 1, -1, 1, 1, 1, 1] == right).all()


def test_eye_has_the_count_and_spacing_of_the_model(right):
    # 5,440 axes within 2 %: Giger's model does not say how the edge runs between its few points.
    assert abs(len(right) / 5440 - 1) < 0.02
    axis = right[:, 3:6]
    np.testing.assert_allclose(np.linalg.norm(axis, axis=1), 1, atol=2e-8)  # 8 decimals
    np.testing.assert_allclose(right[:, 6], math.radians(2.6), rtol=1e-7)
    assert (right[:, 7] == 0).all()
    angle = six_neighbour_angle_deg(axis)
    # The median is the model's own. Of the outer percentiles the upper one hangs on the axes at
    # the edge, whose neighbours lie on one side only, and with it on how the edge is filled in.
    assert np.median(angle) == pytest.approx(2.25, rel=0.02)
    assert np.percentile(angle, 5) == pytest.approx(1.63, rel=0.02)
    assert np.percentile(angle, 95) == pytest.approx(3.24, rel=0.06)


def test_field_of_view_ends_where_it_was_measured(right):
    azimuth, elevation = azimuth_elevation_deg(right[:, 3:6])
    edges = [(-60.2, -52.0, 176.8), (0.0, -14.5, 156.7), (58.9, -42.0, 215.8)]
    edges += [(-30.3, None, 166.8), (30.1, None, 174.3)]
    for at, nasal, temporal in edges:
        # Two rows: every other one is shifted. The last axis lies within half a step of 4.6
        # degrees (two rows share a column) of the edge, and not beyond it but for what the edge
        # itself moves (under 1.5 degrees of azimuth per degree) in the 1.2 degrees to that row.
        rows = np.unique(elevation[np.abs(elevation - at) < 2.5].round(4))
        rows = rows[np.argsort(np.abs(rows - at))[:2]]
        near = azimuth[np.isin(elevation.round(4), rows)]
        step = 4.6 / math.cos(math.radians(at))
        assert temporal - step / 2 - 2 < near.max() < temporal + 2
        if nasal is not None:
            assert nasal - 2 < near.min() < nasal + step / 2 + 2
    assert elevation.min() < -85
    assert elevation.max() > 85


def test_eye_looks_densest_ahead_and_at_the_equator(right):
    azimuth, elevation = azimuth_elevation_deg(right[:, 3:6])
    equator = np.sort(azimuth[np.abs(elevation) < 0.01])
    assert equator[np.argmin(np.abs(equator))] == pytest.approx(0, abs=1e-6)
    step = np.diff(equator)
    for at, expected in ((0, 3.7), (45, 2.4), (90, 3.7), (150, 4.6)):
        # Within the 0.2 degrees that the angle changes from one column to the next.
        near = np.argmin(np.abs(equator[:-1] + step / 2 - at))
        assert step[near] == pytest.approx(expected, abs=0.2)
    rows = np.unique(elevation.round(4))
    gap = np.diff(rows)
    assert gap[np.argmin(np.abs(rows[:-1]))] == pytest.approx(0.75, abs=0.001)
    at_60 = gap[np.argmin(np.abs(rows[:-1] - 60))]
    assert at_60 == pytest.approx(1.75, abs=0.05)  # rows lie 1.7 apart, the angle grows by 0.06


def test_eye_surface_is_one_a_honeybee_could_have(right):
    position, axis = right[:, :3], right[:, 3:6]
    extent = np.ptp(position, axis=0)
    assert 2.2 < extent[1] < 2.8  # mm, height
    assert 0.6 < extent[2] < 1.1
    assert 1.0 < position[:, 0].min() < position[:, 0].max() < 2.0
    # No axis points into its own eye's middle by more than the skew of real eyes (67-90 degrees).
    outward = position - [1.4, 0.05, 0]
    outward = outward / np.array([0.42, 1.2, 0.4]) ** 2
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    assert ((outward * axis).sum(axis=1) > math.cos(math.radians(100))).all()
    gap = np.linalg.norm(position[:, None] - position[None, ::40], axis=2)
    gap[gap == 0] = np.inf
    assert gap.min(axis=0).min() > 0.008  # lenses do not lie on one another
    assert gap.min(axis=0).max() < 0.05


def test_neighbours_in_the_file_are_neighbours_in_space(right):
    chord = np.linalg.norm(np.diff(right[:, 3:6], axis=0), axis=1)
    # A column, or at the end of a row the step to the next.
    assert np.degrees(chord.max()) < 6


def test_eyes_load_and_look_to_their_own_side(right):
    for side, sign in (("left", -1), ("right", 1)):
        eye = omma.load_eye(EXAMPLES / f"honeybee_worker_{side}.eye", unit="mm")
        assert len(eye) == len(right)
        assert sign * eye.position_m[:, 0].min() > 0
        assert sign * eye.axis[:, 0].mean() > 0.3
        assert eye.axis[:, 2].mean() < 0  # forward is -Z inside, +z in the file


def test_script_makes_the_bundled_eyes_again(tmp_path):
    script = EXAMPLES / "make_honeybee.py"
    subprocess.run([sys.executable, script, tmp_path], check=True, capture_output=True)
    for side in ("left", "right"):
        name = f"honeybee_worker_{side}.eye"
        assert (tmp_path / name).read_bytes() == (EXAMPLES / name).read_bytes()
