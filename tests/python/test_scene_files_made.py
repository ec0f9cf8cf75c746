"""Scenes written as .glb and read again; meshes of other formats; files that are none."""

import json
import os
import re
import struct
import warnings
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from test_scene_values import BACKGROUNDS, everything

import omma
from omma.scene import (
    BoundaryTable,
    ExtraReflectance,
    Image,
    Instance,
    Material,
    Mesh,
    PunctualLight,
    TextureUse,
    from_trimesh,
    load_scene,
    merge_scenes,
    save_scene,
)

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def document_of(path):
    """The JSON of a .glb file."""
    data = path.read_bytes()
    assert struct.unpack("<4sII", data[:12]) == (b"glTF", 2, len(data))
    size, kind = struct.unpack("<I4s", data[12:20])
    assert kind == b"JSON"
    return json.loads(data[20 : 20 + size])


def saved_and_loaded(scene, folder):
    save_scene(folder / "scene.glb", scene)
    return load_scene(folder / "scene.glb")


@pytest.mark.parametrize("background", BACKGROUNDS)
def test_a_saved_scene_is_equal(tmp_path, background):
    scene = everything().replace(background=background)
    again = saved_and_loaded(scene, tmp_path)
    assert again == scene
    assert again.background == background
    assert again.warnings == []  # who made it with Omma knows what a light would show


def test_the_meadow_is_seen_alike(tmp_path, eye):
    scene = load_scene(EXAMPLES / "meadow.glb")
    again = saved_and_loaded(scene, tmp_path)
    assert again == scene
    pose = omma.look_at((0, 1, 0), (0, 1, -5))
    seen, other = (omma.Renderer(s, eye, omma.Fixed(8)).render(pose) for s in (scene, again))
    assert seen.tobytes() == other.tobytes()
    # Shared meshes are stored once.
    assert len(again.meshes) == len(scene.meshes) < len(scene.instances)
    assert os.path.getsize(tmp_path / "scene.glb") < 3 * os.path.getsize(scene.path)


def test_solids_are_saved(tmp_path):
    picture = np.random.default_rng(2).integers(0, 256, (16, 32, 3), np.uint8)
    scene = merge_scenes(
        [
            omma.scene.drum(1, 2, picture, repeats=4, sharp=True),
            omma.scene.cylinder(0.1, 0.3, (0.2, 0.3, 0.1), center_m=(0, 0, -0.5)),
            omma.scene.disc(0.1, (1, 0, 0, 0.5), center_m=(0, 0.3, -0.5)),
        ]
    )
    assert saved_and_loaded(scene, tmp_path) == scene


@pytest.mark.skipif(not DATA.is_dir(), reason=f"no real data at {DATA}")
@pytest.mark.parametrize("name", ["natural-standin-sky.gltf", "ofstad-arena.gltf", "env_2.gltf"])
def test_real_scenes_are_saved(name, tmp_path):
    scene = load_scene(DATA / "compound-ray" / "scenes" / name)
    assert saved_and_loaded(scene, tmp_path) == scene


def test_what_others_read(tmp_path):
    """As the glTF 2.0 specification has it."""
    save_scene(tmp_path / "scene.glb", everything())
    document = document_of(tmp_path / "scene.glb")
    assert document["asset"]["version"] == "2.0"
    assert set(document["extensionsUsed"]) == {
        "KHR_lights_punctual", "KHR_materials_clearcoat", "KHR_materials_diffuse_transmission",
        "KHR_materials_emissive_strength", "KHR_materials_ior", "KHR_materials_specular",
        "KHR_materials_transmission", "KHR_materials_unlit", "KHR_materials_volume",
        "KHR_texture_transform",
    }  # fmt: skip
    green = document["materials"][0]
    assert max(green["emissiveFactor"]) <= 1
    assert green["alphaMode"] == "MASK"
    assert all(image["mimeType"] == "image/png" for image in document["images"])
    views = document["bufferViews"]
    assert all(view["byteOffset"] % 4 == 0 for view in views)
    end = max(view["byteOffset"] + view["byteLength"] for view in views)
    assert document["buffers"] == [{"byteLength": end}]
    for mesh in document["meshes"]:
        for primitive in mesh["primitives"]:
            position = document["accessors"][primitive["attributes"]["POSITION"]]
            assert len(position["min"]) == len(position["max"]) == 3
    assert document["meshes"][-1]["extras"] == {"hitbox": "true"}


fractions = st.just(0.0) | st.floats(0, 1, width=32)
colors = st.tuples(fractions, fractions, fractions)
positive = st.floats(0, 1e6)


@st.composite
def spectra(draw, most=1.0):
    knots = sorted(draw(st.sets(st.floats(100, 5000), min_size=2, max_size=5)))
    return omma.light.Spectrum(knots, [draw(st.floats(0, most)) for _ in knots])


@st.composite
def boundaries(draw):
    knots = sorted(draw(st.sets(st.floats(100, 5000), min_size=2, max_size=4)))
    a = draw(arrays(np.float32, (len(knots), draw(st.integers(2, 4))), elements=fractions))
    return BoundaryTable(knots, np.stack([a, a * 0.5, a * -0.75], axis=-1))


@st.composite
def materials(draw):
    maybe = st.none()
    metallic, coat = draw(fractions), draw(fractions)
    is_volume = metallic == coat == 0
    use = st.builds(TextureUse, st.just(0), st.integers(0, 1), st.tuples(fractions, fractions))
    texture = maybe | use
    normal, of_coat = draw(texture), draw(texture)
    return Material(
        metallic=metallic,
        roughness=draw(fractions),
        metallic_roughness_texture=draw(texture),
        normal_texture=normal,
        normal_scale=1 if normal is None else draw(st.floats(-8, 8, width=32)),
        ior=draw(st.floats(1, 10, width=32)),
        specular=draw(fractions),
        specular_texture=draw(texture),
        specular_color=draw(colors),
        specular_color_texture=draw(texture),
        transmission=draw(fractions),
        transmission_texture=draw(texture),
        thickness_m=draw(st.floats(0, 8, width=32)) if is_volume else 0,
        attenuation_color=draw(colors),
        attenuation_distance_m=draw(st.floats(2**-10, 1e3, width=32) | maybe),
        absorption_per_m=draw(maybe | spectra(1e3)),
        diffuse_transmission=draw(fractions),
        diffuse_transmission_factor_texture=draw(texture),
        diffuse_transmission_color=draw(colors),
        diffuse_transmission_texture=draw(texture),
        clearcoat=coat,
        clearcoat_texture=draw(texture),
        clearcoat_roughness=draw(fractions),
        clearcoat_roughness_texture=draw(texture),
        clearcoat_normal_texture=of_coat,
        clearcoat_normal_scale=1 if of_coat is None else draw(st.floats(-8, 8, width=32)),
        reflectance=draw(maybe | spectra(0.5)),
        transmittance=draw(maybe | spectra(0.5)),
        spectral_luminance=draw(st.floats(2**-10, 10, width=32)),
        extra_reflectance=draw(
            maybe | st.builds(ExtraReflectance, use, st.lists(spectra(), min_size=1, max_size=3))
        ),
        emission=draw(maybe | spectra(1e9)),
        boundary=draw(maybe | boundaries()) if metallic > 0 else None,
        unlit=draw(st.booleans()),
    )


@st.composite
def lights(draw):
    kind = draw(st.sampled_from(["directional", "point", "spot"]))
    cones = {}
    if kind == "spot":
        inner, outer = sorted(draw(st.sets(st.floats(0, 1.5), min_size=2, max_size=2)))
        cones = {"inner_cone_rad": inner, "outer_cone_rad": outer}
    place = np.eye(4)
    place[:3, 3] = draw(st.tuples(positive, positive, positive))
    return PunctualLight(
        draw(st.text(max_size=3)),
        type=kind,
        color=draw(colors),
        intensity=draw(positive),
        range_m=draw(positive),
        world_from_light=place,
        spectrum=draw(st.none() | spectra(1e9)),
        **cones,
    )


@settings(
    max_examples=50, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(st.lists(materials(), max_size=3), st.lists(lights(), max_size=3))
def test_all_that_scatters_and_shines_is_kept(tmp_path, made, lamps):
    scene = omma.Scene(
        materials=[Material(base_color_texture=0), *made],  # so that the texture is used
        images=[Image(np.full((1, 1, 3), 0.3, np.float32))],
        lights=lamps,
    )
    assert saved_and_loaded(scene, tmp_path) == scene


def test_data_are_written_as_data(tmp_path):
    """Normals in floats: other programs see the codes of the values, not of light."""
    values = np.array([[[0.5, 0.25, 1.0]]], np.float32)
    scene = omma.Scene(materials=[Material(normal_texture=0)], images=[Image(values)])
    again = saved_and_loaded(scene, tmp_path)
    assert again == scene
    document = document_of(tmp_path / "scene.glb")
    view = document["bufferViews"][document["images"][0]["bufferView"]]
    data = (tmp_path / "scene.glb").read_bytes()
    start = 28 + struct.unpack("<I", data[12:16])[0] + view.get("byteOffset", 0)
    (tmp_path / "normals.png").write_bytes(data[start : start + view["byteLength"]])
    assert Image(tmp_path / "normals.png").pixels[0, 0].tolist() == [128, 64, 255, 255]


def test_nothing_is_left_where_writing_fails(tmp_path):
    with pytest.raises(omma.Error, match=r"expected a name that ends in \.glb"):
        save_scene(tmp_path / "scene.gltf", omma.Scene())
    (tmp_path / "scene.glb").mkdir()
    with pytest.raises(omma.Error):
        save_scene(tmp_path / "scene.glb", everything())

    def stop(share):
        raise KeyError(share)

    with pytest.raises(KeyError):
        save_scene(tmp_path / "other.glb", everything(), progress=stop)
    assert [one.name for one in tmp_path.iterdir()] == ["scene.glb"]


def test_an_empty_scene_is_saved(tmp_path):
    assert saved_and_loaded(omma.Scene(), tmp_path) == omma.Scene()


def test_what_is_not_seen_is_not_saved(tmp_path):
    triangle = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], name="a")
    scene = omma.Scene(
        meshes=[triangle, triangle.replace(name="b")],
        instances=[Instance(1)],
        images=[Image(np.zeros((1, 1, 3), np.uint8))],
        materials=[Material("unused")],
    )
    again = saved_and_loaded(scene, tmp_path)
    assert [one.name for one in again.meshes] == ["b"]
    assert again.images == []
    assert again.materials == scene.materials


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"background-color": [1, 2]}, "background-color: expected an array of 3 numbers"),
        ({"background-image": 7}, "background-image: refers to image 7, there are 0"),
        ({"background-image": "sky"}, "background-image: expected an integer from 0"),
    ],
)
def test_broken_extras_are_named(tmp_path, change, message):
    from conftest import write_gltf

    with pytest.raises(omma.Error, match=message):
        load_scene(write_gltf(tmp_path / "scene.gltf", scene_extras=change))


def test_files_of_blender_are_told_how_to_export(tmp_path):
    with pytest.raises(omma.Error, match=r"File > Export > glTF 2\.0"):
        load_scene(tmp_path / "arena.blend")


trimesh = pytest.importorskip("trimesh")

# A wedge that is different along each axis, so that a turn shows.
WEDGE = trimesh.Trimesh(
    [[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]],
    [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    process=False,
)


@pytest.mark.parametrize("ending", ["obj", "ply", "stl"])
def test_meshes_of_other_formats(tmp_path, ending):
    path = tmp_path / f"wedge.{ending}"
    WEDGE.export(path)
    scene = load_scene(path)
    assert scene.path == str(path)
    assert scene.triangle_count == 4
    assert scene.bounds.tolist() == [[0, 0, 0], [1, 2, 3]]
    small = load_scene(path, unit="mm", up="z")
    assert small.bounds == pytest.approx(np.array([[0, 0, -0.002], [0.001, 0.003, 0]]))
    # Outside stays outside: the volume is positive and the same.
    for one in (scene, small):
        mesh, place = one.meshes[0], one.instances[0].world_from_mesh
        corners = mesh.positions_m[mesh.triangles] @ place[:3, :3].T + place[:3, 3]
        scale = 1 if one is scene else 1e-9
        assert np.linalg.det(corners).sum() / 6 == pytest.approx(1 * scale)


def test_what_is_no_mesh_is_named(tmp_path):
    with pytest.raises(omma.Error, match=r"none\.obj: expected a file, found none"):
        load_scene(tmp_path / "none.obj")
    (tmp_path / "bad.ply").write_bytes(b"\xff\x00nonsense")
    with pytest.raises(omma.Error, match=r"bad\.ply: not readable as PLY"):
        load_scene(tmp_path / "bad.ply")
    (tmp_path / "empty.obj").write_text("# nothing\n")
    with pytest.raises(omma.Error, match=r"empty\.obj: "):
        load_scene(tmp_path / "empty.obj")
    WEDGE.export(tmp_path / "wedge.stl")
    with pytest.raises(omma.Error, match="scene_index: expected none"):
        load_scene(tmp_path / "wedge.stl", 0)
    with pytest.raises(omma.Error, match="up: expected one of y, z"):
        load_scene(tmp_path / "wedge.stl", up="x")
    with pytest.raises(omma.Error, match="up: expected one of y, z"):
        load_scene(EXAMPLES / "meadow.glb", up="x")


def test_gltf_of_programs_that_do_not_heed_its_unit(tmp_path, run_omma):
    """A room written in millimetres with +Z up: the same as in metres with +Y up, cameras too."""
    room = omma.scene.merge_scenes(
        [omma.scene.plane((6, 4)), omma.scene.box((0.5, 2, 0.3), (0.6, 0.3, 0.1))]
    ).replace(
        cameras=[omma.scene.Camera("eye", world_from_camera=omma.look_at((0.2, 1, 1.5), (0, 0, 0)))]
    )
    wrong = np.array([[1e3, 0, 0, 0], [0, 0, -1e3, 0], [0, 1e3, 0, 0], [0, 0, 0, 1.0]])
    written = omma.scene.place_scene(room, wrong)
    written = written.replace(
        cameras=[written.cameras[0].replace(
            world_from_camera=written.cameras[0].world_from_camera @ np.diag([1e-3] * 3 + [1])
        )]
    )  # fmt: skip
    omma.scene.save_scene(tmp_path / "room.glb", written)
    read = load_scene(tmp_path / "room.glb", unit="mm", up="z")
    assert read.path.endswith("room.glb")
    assert np.allclose(read.bounds, room.bounds, atol=1e-6)
    pose = read.cameras[0].world_from_camera
    assert np.allclose(pose, room.cameras[0].world_from_camera, atol=1e-6)
    eye = omma.eye.generate_eye(100)
    seen = [omma.Renderer(one, eye, omma.Fixed(16)).render(pose) for one in (read, room)]
    assert np.allclose(*seen, atol=1e-4)
    said = run_omma("info", str(tmp_path / "room.glb"))[1]
    assert "6000 x 4000 x 2000 m, as of a landscape; if it is in millimetres, 6 m, as of" in said
    assert "flat" not in said
    said = run_omma("info", str(tmp_path / "room.glb"), "--unit", "mm", "--up", "z")[1]
    assert re.search("6 x 2 x 4 m, as of a tree, a room or a plot$", said, re.MULTILINE)


def test_colours_of_trimesh():
    wedge = WEDGE.copy()
    wedge.visual.vertex_colors = [[255, 0, 0, 255], [188, 188, 188, 255]] * 2
    colors = from_trimesh(wedge).meshes[0].colors
    assert colors[0].tolist() == [1, 0, 0, 1]
    assert colors[1, 0] == pytest.approx(0.5029, abs=1e-4)  # sRGB 188
    wedge = WEDGE.copy()
    wedge.visual.face_colors = [[255, 0, 0, 255]] * 3 + [[0, 0, 255, 255]]
    mesh = from_trimesh(wedge).meshes[0]
    assert mesh.positions_m.shape == (12, 3)
    assert mesh.colors[-1].tolist() == [0, 0, 1, 1]


def test_pictures_of_trimesh(tmp_path):
    """An OBJ file with a picture: upper left red, as one sees it from in front."""
    image = pytest.importorskip("PIL.Image")
    pixels = np.full((8, 8, 3), (0, 0, 255), np.uint8)
    pixels[:4, :4] = 255, 0, 0
    image.fromarray(pixels).save(tmp_path / "red.png")
    (tmp_path / "square.mtl").write_text("newmtl wall\nKd 0.5 0.5 0.5\nmap_Kd red.png\n")
    (tmp_path / "square.obj").write_text(
        "mtllib square.mtl\nusemtl wall\n"
        "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n"
        "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
        "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n"
    )
    scene = load_scene(tmp_path / "square.obj")
    eye = omma.Eye([[-0.5, 0.5, 1], [0.5, 0.5, 1], [-0.5, -0.5, 1]], [[0, 0, -1]] * 3, 0.0)
    seen = omma.Renderer(scene, eye, omma.Fixed(1)).render(np.eye(4))[0]
    assert seen.tolist() == [[1, 0, 0], [0, 0, 1], [0, 0, 1]]


def test_scenes_of_trimesh_share_meshes_and_keep_names():
    several = trimesh.Scene()
    several.add_geometry(WEDGE, node_name="one", geom_name="wedge")
    moved = trimesh.transformations.translation_matrix((5, 0, 0))
    several.graph.update("two", geometry="wedge", matrix=moved)
    scene = from_trimesh(several)
    assert len(scene.meshes) == 1
    assert {one.name for one in scene.instances} == {"one", "two"}
    assert scene.bounds.tolist() == [[0, 0, 0], [6, 2, 3]]
    with pytest.raises(omma.Error, match=r"mesh: expected a trimesh\.Trimesh"):
        from_trimesh("wedge.obj")


@pytest.mark.parametrize("kind", ["vertex", "face"])
def test_vertex_colours_that_trimesh_wrote_are_warned_of(tmp_path, kind):
    """It writes bytes of sRGB where glTF says linear: 188 is 0.503 of a PLY, 0.737 of a GLB."""
    box = trimesh.creation.box((10, 10, 10))
    setattr(box.visual, f"{kind}_colors", np.array([188, 188, 188, 255], np.uint8))
    for name in ("c.ply", "c.obj", "c.glb", "c.gltf"):
        box.export(tmp_path / name)

    def grey(scene):
        return scene.meshes[0].colors[0, 0]

    linear = 0.5029  # ((188 / 255 + 0.055) / 1.055)^2.4
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert grey(omma.load_scene(tmp_path / "c.ply")) == pytest.approx(linear, abs=1e-4)
        ruled = omma.load_scene(tmp_path / "c.glb", color_rule="compoundray")
    assert not [one for one in ruled.warnings if "trimesh" in one]
    for name in ("c.glb", "c.gltf"):
        with pytest.warns(UserWarning, match=r"vertex colours are taken as linear.*from_trimesh"):
            scene = omma.load_scene(tmp_path / name, unit="mm", up="z")
        assert grey(scene) == pytest.approx(188 / 255, abs=1e-6)
        assert sum("trimesh" in one for one in scene.warnings) == 1
        # What the warning says to do.
        remedy = from_trimesh(trimesh.load(tmp_path / name))
        assert grey(remedy) == pytest.approx(linear, abs=1e-4)


def test_scenes_of_trimesh_without_colours_are_not_warned_of(tmp_path):
    WEDGE.export(tmp_path / "plain.glb")
    assert not [one for one in omma.load_scene(tmp_path / "plain.glb").warnings if "trimesh" in one]
