"""The Open Compound Eye Standard: every feature by hand, computed places, its own schemas."""

import json
import struct

import numpy as np
import pytest
from conftest import DATA, make_eye
from oces_builder import SCHEMAS, OcesFile, validator

import omma

needs_schemas = pytest.mark.skipif(not SCHEMAS.is_dir(), reason=f"there is no {SCHEMAS}")


def load(file, tmp_path, **options):
    return omma.load_eye(file.write(tmp_path / "eyes.gltf"), **options)


def one_head(file, *children, **rest):
    return file.node({"head": True}, children=list(children), **rest)


def test_ahead_is_ahead_and_left_is_left(tmp_path):
    file = OcesFile()
    one_head(file, file.node({"eye": file.simple_eye()}))
    eye = load(file, tmp_path)
    # OCES: +Z ahead, so +X is the left. Ours: -Z ahead, +X right.
    assert eye.position_m[0] == pytest.approx([-0.001, 0.0005, -0.002])
    assert eye.axis[0].tolist() == [0, 0, -1]
    assert eye.up[0].tolist() == [0, 1, 0]
    assert eye.facet_diameter_m[0] == pytest.approx(2e-5)
    assert eye.focal_offset_m[0] == pytest.approx(1e-4)
    # 2 atan((20 um / 2) / 100 um)
    assert eye.acceptance_angle_rad[0] == pytest.approx(2 * np.arctan(0.1), rel=1e-6)
    assert eye.columns == {}


def test_axes_and_the_local_frame(tmp_path):
    file = OcesFile()
    axes = [[0, 0, 1], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 3, 4]]
    one_head(
        file,
        file.node({"eye": file.eye(properties={"ORIENTATION": file.values(axes)})}),
    )
    eye = load(file, tmp_path)
    expected = [[0, 0, -1], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0.6, -0.8]]
    assert eye.axis == pytest.approx(np.array(expected), abs=1e-7)
    # V = W x U, where U is across W and Y, or X where W is along Y; turned into our frame.
    up = [[0, 1, 0], [0, 1, 0], [0, 0, 1], [0, 0, -1], [0, 0.8, 0.6]]
    assert eye.up == pytest.approx(np.array(up), abs=1e-7)
    # What is not there has the standard's defaults: origin, 1 m wide, focal point 1 m behind.
    assert (eye.position_m == 0).all()
    assert eye.acceptance_angle_rad == pytest.approx(2 * np.arctan(0.5))


def test_nodes_between_head_and_eye(tmp_path):
    file = OcesFile()
    half = np.sqrt(0.5)
    leaf = file.node({"eye": file.simple_eye()}, scale=[0.5, 0.5, 0.5])
    # A quarter turn about Y: +Z comes to +X.
    turned = file.node(rotation=[0, half, 0, half], translation=[0, 0.01, 0], children=[leaf])
    head = one_head(file, turned, translation=[100, 100, 100])  # where it is does not matter
    file.node(children=[head], rotation=[1, 0, 0, 0])
    eye = load(file, tmp_path)
    # (1, 0.5, 2) mm / 2, then (x, y, z) -> (z, y, -x), then up 10 mm, then our frame.
    assert eye.position_m[0] == pytest.approx([-0.001, 0.01025, 0.0005])
    assert eye.axis[0] == pytest.approx([-1, 0, 0], abs=1e-7)
    assert eye.up[0] == pytest.approx([0, 1, 0], abs=1e-7)
    # Scaled with the eye, so that the acceptance stays.
    assert eye.focal_offset_m[0] == pytest.approx(5e-5)
    assert eye.facet_diameter_m[0] == pytest.approx(1e-5)
    assert eye.acceptance_angle_rad[0] == pytest.approx(2 * np.arctan(0.1), rel=1e-6)


@pytest.mark.parametrize(
    ("plane", "position", "axis"),
    [
        ({"normal": "LEFT"}, [0.001, 0.0005, -0.002], [0.6, 0, -0.8]),
        ({}, [0.001, 0.0005, -0.002], [0.6, 0, -0.8]),
        ({"normal": [-2, 0, 0]}, [0.001, 0.0005, -0.002], [0.6, 0, -0.8]),
        ({"normal": "DORSOVENTRAL"}, [-0.001, -0.0005, -0.002], [-0.6, 0, -0.8]),
        ({"normal": "FORWARD", "position": [7, 7, 0.001]}, [-0.001, 0.0005, 0], [-0.6, 0, 0.8]),
        ({"normal": "ANTEROPOSTERIOR"}, [-0.001, 0.0005, 0.002], [-0.6, 0, 0.8]),
    ],
)
@pytest.mark.parametrize("where", ["eye", "node"])
def test_mirror_planes(tmp_path, plane, position, axis, where):
    file = OcesFile()
    file.oces["mirrorPlanes"] = [plane]
    planes = {"mirrorPlanes": [0]}
    which = file.simple_eye(name="left one", **(planes if where == "eye" else {}))
    which_properties = file.oces["eyes"][which]["ommatidialProperties"]
    which_properties["ORIENTATION"] = file.coarse([0.6, 0, 0.8])
    one_head(file, file.node({"eye": which, **(planes if where == "node" else {})}))
    eye = load(file, tmp_path)
    assert eye.eye_id.tolist() == [0, 1]
    assert eye.position_m[0] == pytest.approx([-0.001, 0.0005, -0.002])
    assert eye.axis[0] == pytest.approx([-0.6, 0, -0.8])
    assert eye.position_m[1] == pytest.approx(position, abs=1e-9)
    assert eye.axis[1] == pytest.approx(axis, abs=1e-7)
    assert eye.columns["eye_name"] == ["left one", "left one (mirrored)"]


def test_mirror_planes_are_of_the_head_not_of_the_node(tmp_path):
    file = OcesFile()
    file.oces["mirrorPlanes"] = [{"normal": "X"}]
    moved = file.node({"eye": file.simple_eye(mirrorPlanes=[0])}, translation=[0.01, 0, 0])
    one_head(file, moved)
    eye = load(file, tmp_path)
    assert eye.position_m[:, 0] == pytest.approx([-0.011, 0.011])


def test_sheared_cones(tmp_path):
    # A facet 20 um wide whose focal point is 100 um behind and 100 um to U: seen along the line
    # through both, 45 degrees from W.
    file = OcesFile()
    which = file.simple_eye()
    file.oces["eyes"][which]["ommatidialProperties"]["FOCAL_OFFSET"] = file.coarse([1e-4, 0, -1e-4])
    one_head(file, file.node({"eye": which}))
    eye = load(file, tmp_path)
    # U is OCES's +X, our -X; the focal point is on that side, so the axis leads to the other.
    half = np.sqrt(0.5)
    assert eye.axis[0] == pytest.approx([half, 0, -half], abs=1e-6)
    assert eye.focal_offset_m[0] == pytest.approx(1e-4 * np.sqrt(2), rel=1e-6)
    acceptance = eye.acceptance(0)
    assert acceptance.kernel == "gaussian"
    across = 2 * np.arctan(1e-5 / (1e-4 * np.sqrt(2)))
    along = np.arctan(1.1) - np.arctan(0.9)
    assert acceptance.width_rad(0) == pytest.approx(across, rel=1e-6)  # up and down
    assert acceptance.width_rad(np.pi / 2) == pytest.approx(along, rel=1e-6)


def test_properties_of_every_kind_become_columns(tmp_path):
    file = OcesFile()
    names = {
        "POSITION": file.values([[0, 0, 0], [1, 0, 0], [2, 0, 0]]),
        "AGE": file.property("ACCESSOR", file.accessor([3, 60000, 7], "<u2")),
        "RGB": file.values([[0.5, 0.25, 0], [1, 2, 3], [4, 5, 6]]),
        "SERIES": file.values(np.arange(15.0), dataStride=5),
        "PLAIN": file.coarse(7.5),
        "PAIRS": file.coarse([[1, 2], [3, 4]]),
    }
    one_head(file, file.node({"eye": file.eye(properties=names)}))
    columns = load(file, tmp_path).columns
    assert sorted(columns) == sorted(
        ["AGE", "PAIRS_w", "PAIRS_x", "PAIRS_y", "PAIRS_z", "PLAIN", "RGB_x", "RGB_y", "RGB_z"]
        + [f"SERIES_{i}" for i in range(5)]
    )
    assert columns["AGE"].tolist() == [3, 60000, 7]
    assert columns["RGB_y"].tolist() == [0.25, 2, 5]
    assert columns["SERIES_4"].tolist() == [4, 9, 14]
    assert columns["PAIRS_z"].tolist() == [3, 3, 3]
    assert columns["PLAIN"].tolist() == [7.5, 7.5, 7.5]


def test_what_is_disabled_is_not_there(tmp_path):
    file = OcesFile()
    on = file.node({"eye": file.simple_eye(name="on")})
    off = file.node({"eye": file.simple_eye(name="off", enabled=False)})
    node_off = file.node({"eye": file.simple_eye(name="node off"), "enabled": False})
    one_head(file, off, on, node_off)
    file.node({"head": True, "enabled": False}, name="sleeper")
    path = file.write(tmp_path / "a.gltf")
    assert omma.load_eye(path).columns["eye_name"] == ["on"]
    assert omma.eye.eye_file_heads(path) == [""]
    with pytest.raises(omma.Error, match=r"a\.gltf: node 4 \"sleeper\".*disabled"):
        omma.load_eye(path, head="sleeper")


def test_one_head_of_several(tmp_path):
    file = OcesFile()
    for x, name in ((0.0, "queen"), (1.0, "worker"), (2.0, "worker")):
        one_head(file, file.node({"eye": file.simple_eye()}, translation=[x, 0, 0]), name=name)
    path = file.write(tmp_path / "a.gltf")
    assert omma.eye.eye_file_heads(path) == ["queen", "worker", "worker"]
    assert omma.load_eye(path, head="queen").position_m[0, 0] == pytest.approx(-0.001)
    assert omma.load_eye(path, head=2).position_m[0, 0] == pytest.approx(-2.001)
    for head in (None, "worker", "drone", 3):
        with pytest.raises(omma.Error) as caught:
            omma.load_eye(path, head=head)
        for word in ["a.gltf", '0 "queen"', '1 "worker"', '2 "worker"']:
            assert word in str(caught.value)


def spacing_of(eye):
    distance = np.linalg.norm(eye.position_m[:, None].astype(float) - eye.position_m[None], axis=2)
    np.fill_diagonal(distance, np.inf)
    return distance.min(axis=1)


def surface_file(count, diameter, **properties):
    """A square of 2 m by 1 m in the plane z = 0, seen from +Z; diameters by vertex."""
    file = OcesFile()
    surface = {
        "POSITION": file.accessor([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]]),
        "NORMAL": file.accessor([[0, 0, 1]] * 4),
        "INDICES": file.accessor([0, 1, 2, 0, 2, 3], "<u2"),
        "TEXTURE_COORD": file.accessor([[0, 1], [1, 1], [1, 0], [0, 0]]),
        "TEXTURE_INDICES": file.accessor([0, 1, 2, 0, 2, 3], "<u2"),
    }
    values = {"DIAMETER": diameter(file), "FOCAL_OFFSET": file.coarse(-1)}
    values |= {name: value(file) for name, value in properties.items()}
    which = file.eye("SURFACE", values, surface=surface, ommatidialCount=count)
    one_head(file, file.node({"eye": which}))
    return file


def test_a_surface_is_filled_evenly(tmp_path):
    count = 400
    eye = load(surface_file(count, lambda file: file.coarse(0.05)), tmp_path)
    assert len(eye) == count
    x, y, z = eye.position_m.T
    assert (z == 0).all()
    assert x.min() >= -2
    assert x.max() <= 0
    assert y.min() >= 0
    assert y.max() <= 1
    assert (eye.axis == [0, 0, -1]).all()
    # Hexagonally there would be room for a spacing of 0.076; at random the mean to the nearest is
    # 0.035 (1 / (2 sqrt(density))), and none is kept apart.
    near = spacing_of(eye)
    assert near.min() > 0.6 * np.sqrt(2 / count / np.sqrt(0.75))
    assert np.mean(near) > 0.75 * np.sqrt(2 / count / np.sqrt(0.75))
    assert np.abs(np.histogram(x, 4, (-2, 0))[0] - count / 4).max() < 0.1 * count / 4
    again = load(surface_file(count, lambda file: file.coarse(0.05)), tmp_path)
    assert (again.position_m == eye.position_m).all()


@pytest.mark.parametrize("kind", ["vertices", "texture"])
def test_spacing_on_a_surface_follows_diameters(tmp_path, kind):
    def diameter(file):
        if kind == "vertices":  # from 0.02 at x = 0 to 0.06 at x = 2
            return file.values([0.02, 0.06, 0.06, 0.02])
        # The same from texels: their centres are a quarter and three quarters along.
        texture = file.texture([[102, 204]], wrapS=33071, wrapT=33071)
        return file.property("TEXTURE", texture, textureScale=0.05, textureCenter=-0.2)

    eye = load(surface_file(600, diameter), tmp_path)
    x = -eye.position_m[:, 0].astype(float)
    # Of the texture: (0.4 + 0.2) and (0.8 + 0.2) times 0.05, level outside the texels' centres.
    textured = np.interp(x, [0.5, 1.5], [0.03, 0.05])
    expected = 0.02 + 0.02 * x if kind == "vertices" else textured
    assert eye.facet_diameter_m == pytest.approx(expected, rel=1e-5)
    ratio = spacing_of(eye) / expected
    assert ratio.std() < 0.2 * ratio.mean()
    slope = np.polyfit(expected, spacing_of(eye), 1)
    assert slope[0] * 0.04 > 0.7 * np.mean(ratio) * 0.04


def test_a_surface_displaced_and_turned(tmp_path):
    file = surface_file(
        5,
        lambda f: f.coarse(0.1),
        DISPLACEMENT=lambda f: f.coarse([0.5, 0.25, 3]),
        RELATIVE_ORIENTATION=lambda f: f.coarse([0, 1, 0]),
    )
    eye = load(file, tmp_path)
    assert eye.position_m[:, 2] == pytest.approx(-3)
    assert eye.position_m[:, 0].max() <= -0.5
    assert eye.axis == pytest.approx(np.array([[0, 0.5**0.5, -(0.5**0.5)]] * 5), abs=1e-6)
    file = surface_file(
        5, lambda f: f.coarse(0.1), ABSOLUTE_ORIENTATION=lambda f: f.coarse([2, 0, 0])
    )
    assert load(file, tmp_path).axis.tolist() == [[-1, 0, 0]] * 5


def test_a_sphere(tmp_path):
    file = OcesFile()
    # Left half of the map (our right, -X of OCES) 0.1, right half 0.2; +Z is in the middle.
    texture = file.texture([[100, 200]], magFilter=9728)
    names = {
        "DIAMETER": file.property("TEXTURE", texture, textureScale=0.255),
        "FOCAL_OFFSET": file.coarse(-2),
    }
    which = file.eye("SPHERICAL", names, radius=3, ommatidialCount=500)
    one_head(file, file.node({"eye": which}))
    eye = load(file, tmp_path)
    assert np.linalg.norm(eye.position_m, axis=1) == pytest.approx(3, rel=1e-6)
    assert eye.axis == pytest.approx(eye.position_m / 3, abs=1e-6)
    right = eye.position_m[:, 0] > 0
    assert eye.facet_diameter_m[right] == pytest.approx(0.1)
    assert eye.facet_diameter_m[~right] == pytest.approx(0.2)
    # Facets half as wide: four times as many.
    assert right.sum() / (~right).sum() == pytest.approx(4, rel=0.15)


def extension_of(path):
    data = path.read_bytes()
    if path.suffix == ".glb":
        size = struct.unpack("<I", data[12:16])[0]
        data = data[20 : 20 + size]
    return json.loads(data)


def rich_eye():
    eye = make_eye(40)
    side = eye.axis[:, 0] > 0
    return eye.replace(
        eye_id=side.astype(np.int32),
        facet_diameter_m=2e-5,
        focal_offset_m=5e-5,
        acceptance=[omma.Acceptance.airy(2e-5, 500) if s else None for s in side],
        acceptance_angle_rad=eye.acceptance_angle_rad,
        receptor_types=[omma.receptors.ReceptorType("green", peak_wavelength_nm=544)],
        receptors=[0, 0],
        columns={"age": np.arange(40.0), "third": np.arange(40.0) / 3, "note": ["x"] * 40},
    )


@needs_schemas
@pytest.mark.parametrize("suffix", [".gltf", ".glb"])
@pytest.mark.parametrize("eye", [make_eye(20), rich_eye()], ids=["plain", "rich"])
def test_files_are_valid_by_the_standards_schemas(tmp_path, suffix, eye):
    path = tmp_path / f"eye{suffix}"
    omma.save_eye(path, eye)
    document = extension_of(path)
    check = validator()
    check("glTF.OCES_eyes.schema.json", document["extensions"]["OCES_eyes"])
    heads = 0
    for node in document["nodes"]:
        check("node.OCES_eyes.schema.json", node["extensions"]["OCES_eyes"])
        heads += node["extensions"]["OCES_eyes"].get("head", False)
    assert heads == 1
    assert document["extensionsUsed"] == ["OCES_eyes"]
    # The numbers the standard asks for give the acceptance by its own formula.
    one = document["extensions"]["OCES_eyes"]["eyes"][0]["ommatidialProperties"]
    assert {"POSITION", "ORIENTATION", "DIAMETER", "FOCAL_OFFSET"} <= set(one)


@needs_schemas
def test_the_schemas_find_fault():
    from jsonschema import ValidationError

    check = validator()
    good = json.loads(OcesFile().text())["extensions"]["OCES_eyes"]
    good["eyes"] = [
        {
            "type": "POINT_OMMATIDIAL",
            "ommatidialProperties": dict.fromkeys(
                ["POSITION", "ORIENTATION", "DIAMETER", "FOCAL_OFFSET"], 0
            ),
        }
    ]
    check("glTF.OCES_eyes.schema.json", good)
    del good["eyes"][0]["ommatidialProperties"]["DIAMETER"]
    with pytest.raises(ValidationError):
        check("glTF.OCES_eyes.schema.json", good)


def test_another_reader_finds_the_acceptance(tmp_path):
    """DIAMETER and FOCAL_OFFSET alone, as any program reads them, give the angle back."""
    eye = rich_eye()
    path = tmp_path / "eye.gltf"
    omma.save_eye(path, eye)
    document = json.loads(path.read_text())
    oces = document["extensions"]["OCES_eyes"]
    del oces["extras"]
    for one in oces["eyes"]:
        del one["extras"]
        one["ommatidialProperties"] = {
            name: index
            for name, index in one["ommatidialProperties"].items()
            if not name.startswith("OMMA_")
        }
    path.write_text(json.dumps(document))
    plain = omma.load_eye(path)
    order = np.argsort(eye.eye_id, kind="stable")
    assert (plain.position_m == eye.position_m[order]).all()
    assert (plain.axis == eye.axis[order]).all()
    assert plain.acceptance_angle_rad == pytest.approx(eye.acceptance_angle_rad[order], rel=1e-6)
    assert plain.facet_diameter_m == pytest.approx(2e-5)
    assert set(plain.columns) == {"age", "third", "eye_name"}


def test_what_others_change_wins(tmp_path):
    eye = rich_eye()
    path = tmp_path / "eye.gltf"
    omma.save_eye(path, eye)
    document = json.loads(path.read_text())
    oces = document["extensions"]["OCES_eyes"]
    oces["ommatidialProperties"].append({"type": "COARSE", "value": 4e-5})
    for one in oces["eyes"]:
        one["ommatidialProperties"]["DIAMETER"] = len(oces["ommatidialProperties"]) - 1
    path.write_text(json.dumps(document))
    changed = omma.load_eye(path)
    assert changed.facet_diameter_m == pytest.approx(4e-5)
    assert (np.asarray(changed.acceptance_of) == -1).all()
    assert (changed.acceptance_angle_rad > 1.2 * eye.acceptance_angle_rad).all()


def test_read_written_and_read_again(tmp_path):
    file = OcesFile()
    file.oces["mirrorPlanes"] = [{"normal": "X"}]
    rng = np.random.default_rng(2)
    names = {
        "POSITION": file.values(rng.normal(size=(9, 3)) * 1e-3),
        "ORIENTATION": file.values(rng.normal(size=(9, 3))),
        "DIAMETER": file.values(2e-5 + 1e-5 * rng.random(9)),
        "FOCAL_OFFSET": file.values(-1e-4 - 1e-4 * rng.random(9)),
        "AGE": file.values(rng.random((9, 3))),
    }
    which = file.eye(properties=names, name="left", mirrorPlanes=[0])
    one_head(file, file.node({"eye": which}, rotation=[0.1, 0.2, 0.3, 0.9]))
    first = load(file, tmp_path)
    for suffix in (".gltf", ".glb", ".csv"):
        omma.save_eye(tmp_path / f"b{suffix}", first)
        second = omma.load_eye(tmp_path / f"b{suffix}")
        from test_eye_files import assert_same

        assert_same(first, second)


@pytest.mark.skipif(not (DATA / "compound-ray").is_dir(), reason="there is no shared data")
@pytest.mark.parametrize("suffix", [".csv", ".gltf", ".glb"])
@pytest.mark.parametrize("name", ["AM_60185-real", "BT_77973-real"])
def test_real_eyes_survive(tmp_path, suffix, name):
    from test_eye_files import assert_same

    eye = omma.load_eye(DATA / "compound-ray" / "bees" / f"{name}.eye")
    omma.save_eye(tmp_path / f"a{suffix}", eye)
    assert_same(eye, omma.load_eye(tmp_path / f"a{suffix}"))


def test_a_scene_without_eyes(files):
    with pytest.raises(omma.Error, match=r"scene\.gltf: has no eyes.*OCES_eyes"):
        omma.load_eye(files / "scene.gltf")
