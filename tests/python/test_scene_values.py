"""Scenes, their parts, backgrounds and cameras as values: made of arrays, read back, compared,
copied, pickled, changed, joined."""

import contextlib
import copy
import pickle
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import omma
from omma.light import Spectrum
from omma.scene import (
    Camera,
    ExtraReflectance,
    HitBox,
    Image,
    Instance,
    Material,
    Mesh,
    PunctualLight,
    Texture,
    TextureUse,
    merge_scenes,
    place_scene,
)

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
TRIANGLE = ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])


def everything():
    """A scene with each kind of part, and all that parts can say."""
    rng = np.random.default_rng(0)
    turned = omma.look_at((1, 2, 3), (4, 0, 0))
    return omma.Scene(
        meshes=[
            Mesh(
                rng.normal(size=(4, 3)),
                [[0, 1, 2], [0, 2, 3]],
                name="leaf",
                normals=np.tile([0, 0, 1], (4, 1)),
                texture_coordinates=rng.random((4, 2)),
                second_texture_coordinates=rng.random((4, 2)),
                colors=rng.random((4, 4)),
                material=0,
            ),
            Mesh(*TRIANGLE),
            Mesh(*TRIANGLE, material=1),
        ],
        instances=[
            Instance(0, turned, name="here"),
            Instance(0, name="there"),
            Instance(1, name="both", node=3),
            Instance(2, name="both", node=3),
        ],
        materials=[
            Material(
                "green",
                base_color=(0.1, 0.5, 0.2, 0.9),
                base_color_texture=TextureUse(0, 1, (0.1, 0.2), (2, 3), 0.5),
                emissive=(3.7, 0.1, 0.0),
                emissive_texture=1,
                alpha_mode="mask",
                alpha_cutoff=0.3,
                double_sided=True,
            ),
            Material("paper", unlit=True, alpha_mode="blend"),
            Material(
                "petal",
                emissive=(0.5, 0.25, 0.125),
                metallic=0.1,
                roughness=0.3,
                metallic_roughness_texture=TextureUse(2, 1, scale=(3, 3)),
                normal_texture=3,
                normal_scale=0.7,
                ior=1.4,
                specular=0.9,
                specular_texture=2,
                specular_color=(1, 0.9, 0.8),
                specular_color_texture=TextureUse(0, 1),
                transmission=0.05,
                transmission_texture=TextureUse(2, 0, (0.5, 0.25)),
                diffuse_transmission=0.3,
                diffuse_transmission_factor_texture=TextureUse(3, 1),
                diffuse_transmission_color=(0.2, 0.9, 0.1),
                diffuse_transmission_texture=4,
                clearcoat=0.2,
                clearcoat_texture=3,
                clearcoat_roughness=0.6,
                clearcoat_roughness_texture=TextureUse(2, rotation_rad=0.5),
                clearcoat_normal_texture=2,
                clearcoat_normal_scale=0.3,
                reflectance=Spectrum([300, 401.5, 700], [0.05, 0.1, 1 / 3]),
                transmittance=Spectrum([300, 700], [0.001, 0.2]),
                spectral_luminance=0.3,
                extra_reflectance=ExtraReflectance(
                    TextureUse(3, 1), [None, Spectrum([300, 400], [0.5, 0.1])]
                ),
                emission=Spectrum([400, 700], [1e-9, 123.456]),
            ),
            Material(
                "tea",
                transmission=1,
                thickness_m=0.25,
                attenuation_color=(0.5, 0.25, 0.125),
                attenuation_distance_m=0.75,
                absorption_per_m=Spectrum([300, 700], [0.001, 0.2]),
            ),
        ],
        textures=[
            Texture(0, "clamp_to_edge", "mirrored_repeat", "nearest"),
            Texture(1),
            Texture(2),
            Texture(3),
            Texture(0),
        ],
        images=[
            Image(rng.integers(0, 256, (3, 5, 4), np.uint8), "bytes"),
            Image(rng.random((2, 3, 3), np.float32) * 40, "floats"),
            Image(rng.integers(0, 256, (2, 2, 3), np.uint8), "roughness"),
            Image(rng.random((2, 3, 3), np.float32), "normals"),
        ],
        cameras=[
            Camera("ahead", world_from_camera=turned, yfov_rad=0.7, aspect_ratio=1.5),
            Camera("map", type="orthographic", xmag_m=3, ymag_m=2, data_name="lens"),
            Camera("all", type="panoramic", extras={"note": [1, "ö"]}),
            Camera("bee", type="compound", extras={"compound-structure": "bee.eye"}),
        ],
        hit_boxes=[HitBox("zone", *TRIANGLE, turned)],
        lights=[
            PunctualLight("sun", type="directional", intensity=1e5, world_from_light=turned),
            PunctualLight(color=(1, 0.5, 0), range_m=3.5),
            PunctualLight(
                "lamp",
                type="spot",
                inner_cone_rad=0.1,
                outer_cone_rad=0.3,
                spectrum=Spectrum([300, 500, 700], [0, 1.5, 1 / 3]),
            ),
        ],
        background=omma.Background.constant((0.1, 0.2, 7.5)),
    )


BACKGROUNDS = [
    omma.Background.constant((0.1, 0.2, 0.3)),
    omma.Background.simple_sky(),
    omma.Background.test_pattern(),
    omma.Background.image(np.full((2, 4, 3), 200, np.uint8)),
    omma.Background.image(np.full((2, 4, 3), 5.5)),
]


def values():
    scene = everything()
    lists = (
        scene.meshes, scene.instances, scene.materials, scene.textures, scene.images,
        scene.cameras, scene.hit_boxes, [scene.materials[0].base_color_texture], BACKGROUNDS,
        scene.lights, [scene.materials[2].reflectance, scene.materials[2].extra_reflectance],
    )  # fmt: skip
    return [scene, omma.Scene(), omma.load_scene(EXAMPLES / "meadow.glb")] + [
        one for found in lists for one in found
    ]


@pytest.mark.parametrize("value", values(), ids=lambda value: repr(value)[:40])
def test_values_behave_as_values(value):
    again = pickle.loads(pickle.dumps(value))
    assert again is not value
    assert again == value
    assert hash(again) == hash(value)
    assert repr(again) == repr(value)
    assert copy.copy(value) == value == copy.deepcopy(value)
    assert value != 1
    assert sum(value == other for other in values()) == 1


def test_they_pickle_to_another_process(tmp_path):
    scene = everything()
    (tmp_path / "scene.pickle").write_bytes(pickle.dumps(scene))
    code = (
        "import pickle, sys; scene = pickle.load(open(sys.argv[1], 'rb'));"
        "pickle.dump(scene, open(sys.argv[2], 'wb'))"
    )
    paths = [tmp_path / "scene.pickle", tmp_path / "again.pickle"]
    subprocess.run([sys.executable, "-c", code, *paths], check=True)
    assert pickle.loads(paths[1].read_bytes()) == scene


def test_where_it_came_from_is_pickled_and_not_compared(scene):
    again = pickle.loads(pickle.dumps(scene))
    assert (again.path, again.warnings) == (scene.path, scene.warnings)
    assert (again.scene_names, again.node_count) == (scene.scene_names, scene.node_count)
    made = scene.replace()
    assert made == scene
    assert made.path == ""


def test_what_parts_say():
    scene = everything()
    leaf = scene.meshes[0]
    assert leaf.positions_m.dtype == np.float32
    assert leaf.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert leaf.triangles.dtype == np.uint32
    assert leaf.colors.shape == (4, 4)
    assert leaf.texture_coordinates.shape == leaf.second_texture_coordinates.shape == (4, 2)
    assert leaf.material == 0
    plain = scene.meshes[1]
    assert plain.normals is plain.colors is plain.texture_coordinates is plain.material is None
    use = scene.materials[0].base_color_texture
    assert (use.texture, use.texcoord_set, use.scale) == (0, 1, (2, 3))
    assert scene.materials[1].base_color_texture is None
    assert scene.images[0].pixels.shape == (3, 5, 4)
    assert (scene.images[1].pixels[..., 3] == 1).all()
    assert [one.node for one in scene.instances] == [None, None, 3, 3]
    assert [one.type for one in scene.cameras] == [
        "perspective", "orthographic", "panoramic", "compound",
    ]  # fmt: skip
    assert scene.cameras[2].extras == {"panoramic": "true", "note": [1, "ö"]}
    assert scene.cameras[3].compound_structure == "bee.eye"
    assert scene.camera("lens").name == "map"
    assert scene.hit_box_names == ["zone"]
    petal = scene.materials[2]
    assert petal.reflectance.wavelength_nm.tolist() == [300, 401.5, 700]
    assert petal.reflectance.value.tolist() == [0.05, 0.1, 1 / 3]
    assert not petal.reflectance.value.flags.writeable
    assert petal.extra_reflectance.spectra == (None, Spectrum([300, 400], [0.5, 0.1]), None)
    assert (petal.ior, petal.normal_scale) == pytest.approx((1.4, 0.7))
    plain = scene.materials[0]
    assert (plain.metallic, plain.roughness) == (0, 1)
    assert plain.reflectance is plain.extra_reflectance is plain.normal_texture is None
    assert [one.type for one in scene.lights] == ["directional", "point", "spot"]
    assert scene.lights[1].spectrum is None
    assert scene.background.color == pytest.approx((0.1, 0.2, 7.5))


def test_arrays_are_views_that_keep_the_scene():
    scene = everything()
    positions, pixels = scene.meshes[0].positions_m, scene.images[0].pixels
    for array in (positions, pixels, scene.hit_boxes[0].positions_m):
        assert not array.flags.writeable
        assert not array.flags.owndata
    assert np.shares_memory(positions, scene.meshes[0].positions_m)
    before = positions.copy(), pixels.copy()
    del scene
    garbage = [np.full(2000, 7.0) for _ in range(200)]
    assert (positions == before[0]).all()
    assert (pixels == before[1]).all()
    assert garbage


def test_replace():
    scene = everything()
    lit = scene.replace(background=omma.Background.constant((1, 1, 1)))
    assert lit.background.color == (1, 1, 1)
    assert lit.meshes == scene.meshes
    assert lit != scene
    assert scene.meshes[0].replace(name="leaf") == scene.meshes[0]
    assert scene.meshes[0].replace(name="stem") != scene.meshes[0]
    with pytest.raises(TypeError, match="there is no 'mesh'; there are meshes, instances"):
        scene.replace(mesh=[])


def test_instances_that_move_together_are_compared_not_their_numbers():
    scene = everything()
    numbered = [one if one.node is None else one.replace(node=77) for one in scene.instances]
    assert scene.replace(instances=numbered) == scene
    alone = [one.replace(node=None) for one in scene.instances]
    assert scene.replace(instances=alone) != scene


def test_the_meadow_made_of_its_arrays_is_seen_alike():
    """Golden: bit for bit what the file gives."""
    loaded = omma.load_scene(EXAMPLES / "meadow.glb")
    made = omma.Scene(
        meshes=[
            Mesh(
                np.array(mesh.positions_m),
                np.array(mesh.triangles, np.int64),
                name=mesh.name,
                normals=mesh.normals,
                texture_coordinates=mesh.texture_coordinates,
                second_texture_coordinates=mesh.second_texture_coordinates,
                colors=mesh.colors,
                material=mesh.material,
            )
            for mesh in loaded.meshes
        ],
        instances=loaded.instances,
        materials=loaded.materials,
        textures=loaded.textures,
        images=[Image(np.array(image.pixels), image.name) for image in loaded.images],
        cameras=loaded.cameras,
        background=loaded.background,
    )
    assert made == loaded
    eye = omma.load_eye(EXAMPLES / "honeybee_worker_left.eye")
    eye = eye.take(np.arange(0, len(eye), 10))
    pose = omma.look_at((0, 1, 0), (0, 1, -5))
    seen, again = (omma.Renderer(s, eye, omma.Fixed(8)).render(pose) for s in (loaded, made))
    assert seen.std() > 0.01
    assert seen.tobytes() == again.tobytes()


def test_the_table_of_notebooks():
    table = everything().replace(cameras=[Camera("a<b>&c")])._repr_html_()
    assert table.startswith("<table>")
    assert "a&lt;b&gt;&amp;c" in table
    assert "6 in 4 instances of 3 meshes" in table
    assert "0.1, 0.2, 7.5" in table


def test_merged_scenes_are_those_scenes(eye):
    box = omma.scene.box(paint=np.random.default_rng(1).random((8, 8, 3)), center_m=(0, 0, -3))
    scene = everything().replace(background=omma.Background.simple_sky())
    merged = merge_scenes([scene, box, place_scene(box, omma.look_at((5, 0, 0), (5, 0, 1)))])
    assert merged.background.type == "simple_sky"
    assert merged.triangle_count == scene.triangle_count + 24
    assert [one.name for one in merged.instances] == ["here", "there", "both", "both", "box", "box"]
    assert len(omma.World(merged).instances) == 5
    # What is under the indices is what was.
    for mesh, old in zip(merged.meshes[3:], box.meshes * 2):
        assert mesh.replace(material=0) == old
        use = merged.materials[mesh.material].base_color_texture
        assert merged.images[merged.textures[use.texture].image] == box.images[0]
    assert merged.meshes[:3] == scene.meshes
    assert merged.lights == scene.lights
    again = merge_scenes([box, scene])
    petal = again.materials[len(box.materials) + 2]
    assert petal.normal_texture.texture == 3 + len(box.textures)
    assert petal.metallic_roughness_texture.texture == 2 + len(box.textures)
    assert petal.diffuse_transmission_texture.texture == 4 + len(box.textures)
    assert petal.specular_texture.texture == 2 + len(box.textures)
    assert petal.specular_color_texture.texture == len(box.textures)
    assert petal.transmission_texture.texture == 2 + len(box.textures)
    assert petal.clearcoat_texture.texture == 3 + len(box.textures)
    assert petal.clearcoat_roughness_texture.texture == 2 + len(box.textures)
    assert petal.clearcoat_normal_texture.texture == 2 + len(box.textures)
    assert petal.diffuse_transmission_factor_texture.texture == 3 + len(box.textures)
    assert petal.extra_reflectance.texture.texture == 3 + len(box.textures)
    assert petal.extra_reflectance.spectra == scene.materials[2].extra_reflectance.spectra
    other = omma.Background.constant((1, 0, 0))
    assert merge_scenes([box, box], background=other).background == other
    # One alone is itself.
    assert merge_scenes([scene]) == scene


def test_cameras_of_one_name_are_not_merged():
    one = omma.Scene(cameras=[Camera("bee")])
    with pytest.raises(omma.Error, match=r"scenes\[1\]: its camera 'bee' is also in scenes\[0\]"):
        merge_scenes([one, one])
    other = one.replace(cameras=[one.cameras[0].replace(name="ant")])
    assert [c.name for c in merge_scenes([one, other]).cameras] == ["bee", "ant"]
    with pytest.raises(omma.Error, match="scenes: expected at least one"):
        merge_scenes([])


def test_placed_scenes():
    shifted = np.eye(4)
    shifted[:3, 3] = 1, 2, 3
    scene = everything()
    placed = place_scene(scene, shifted)
    assert placed.bounds == pytest.approx(scene.bounds + (1, 2, 3))
    assert placed.cameras[0].world_from_camera[:3, 3] == pytest.approx((2, 4, 6))
    assert placed.lights[1].world_from_light[:3, 3] == pytest.approx((1, 2, 3))
    assert placed.hit_box_bounds("zone") == pytest.approx(
        scene.hit_box_bounds("zone") + (1, 2, 3), abs=1e-12
    )
    with pytest.raises(omma.Error, match="world_from_scene"):
        place_scene(scene, np.full((4, 4), np.nan))


WRONG = {
    "positions_m: expected numbers of shape": lambda: Mesh([[0, 0]], [[0, 0, 0]]),
    "position of vertex 1 is not finite": lambda: Mesh([[0, 0, 0], [0, np.nan, 0]], [[0, 1, 0]]),
    "triangle 0 has vertex 3, there are 3": lambda: Mesh(TRIANGLE[0], [[0, 1, 3]]),
    "triangles: vertex -1 is negative": lambda: Mesh(TRIANGLE[0], [[0, 1, -1]]),
    "triangles: vertex 4294967296 is more": lambda: Mesh(TRIANGLE[0], [[0, 1, 2**32]]),
    "triangles: expected whole numbers": lambda: Mesh(TRIANGLE[0], [[0.0, 1, 2]]),
    "has 2 colours for 3 vertices": lambda: Mesh(*TRIANGLE, colors=np.ones((2, 3))),
    "colors: expected numbers of shape": lambda: Mesh(*TRIANGLE, colors=np.ones((3, 5))),
    "has 1 normals for 3": lambda: Mesh(*TRIANGLE, normals=[[0, 0, 1]]),
    "material: expected 0 to": lambda: Mesh(*TRIANGLE, material=-1),
    'mesh 0 "m": refers to material 0, there are 0': lambda: omma.Scene(
        meshes=[Mesh(*TRIANGLE, name="m", material=0)]
    ),
    'instance 0 "i": refers to mesh 5': lambda: omma.Scene(instances=[Instance(5, name="i")]),
    "material 0: refers to texture 2": lambda: omma.Scene(
        materials=[Material(base_color_texture=2)]
    ),
    "texture 0: refers to image 1": lambda: omma.Scene(textures=[Texture(1)]),
    "its base colour is negative": lambda: omma.Scene(materials=[Material(base_color=(-1, 0, 0))]),
    "is unlit and has an emission": lambda: omma.Scene(
        materials=[Material(unlit=True, emissive=(1, 0, 0))]
    ),
    "base_color: expected three or four": lambda: Material(base_color=(1, 2)),
    "alpha_mode: expected one of opaque, mask, blend": lambda: Material(alpha_mode="MASK"),
    "metallic: expected 0 to 1, found 2": lambda: Material(metallic=2),
    "ior: expected 1 to 10": lambda: Material(ior=0),
    "specular_color: expected 0 to 1": lambda: Material(specular_color=(0, 0, 3)),
    "spectral_luminance: expected more than 0": lambda: Material(spectral_luminance=0),
    "reflectance: value: expected 0 to 1, found 1.5 at 300 nm": lambda: Material(
        reflectance=Spectrum([300, 400], [1.5, 0])
    ),
    "reflectance and transmittance: expected at most 1 together, found 1.2": lambda: Material(
        reflectance=Spectrum([300, 400], [0.6, 0.6]), transmittance=Spectrum([350, 450], [0.6, 0])
    ),
    "wavelength_nm: expected 2 to 10000": lambda: Spectrum([300], [1]),
    "wavelength_nm: expected 2 or more": lambda: Spectrum([], []),
    "wavelength_nm: expected wavelengths that grow, found 400 and then 300": lambda: Spectrum(
        [400, 300], [1, 1]
    ),
    "value: expected numbers that are finite and not negative, found -1": lambda: Spectrum(
        [300, 400], [-1, 1]
    ),
    "value: expected one for each of 2 wavelengths, found 3": lambda: Spectrum(
        [300, 400], [1, 1, 1]
    ),
    "spectra: expected one to three, found 0": lambda: ExtraReflectance(0, []),
    "expected a texture and spectra, found only a texture": lambda: ExtraReflectance(0, [None]),
    "intensity: expected a number that is finite and not negative": lambda: PunctualLight(
        intensity=-1
    ),
    "cones: expected 0 <= inner < outer": lambda: PunctualLight(type="spot", inner_cone_rad=1),
    "type: expected one of directional, point, spot": lambda: PunctualLight(type="area"),
    "light 0: world_from_light is not finite": lambda: PunctualLight(
        world_from_light=np.full((4, 4), np.inf)
    ),
    "material 0: refers to texture 7": lambda: omma.Scene(materials=[Material(normal_texture=7)]),
    "the normal of vertex 1 is zero": lambda: Mesh(
        *TRIANGLE, normals=[[0, 0, 1], [0, 0, 0], [0, 0, 1]]
    ),
    "the colour of vertex 2 is negative": lambda: Mesh(
        *TRIANGLE, colors=[[1, 1, 1], [1, 1, 1], [1, 1, -0.1]]
    ),
    "pixels: expected": lambda: Image(np.zeros((2, 2, 2), np.uint8)),
    "pixels: expected finite values": lambda: Image(np.full((2, 2, 3), np.nan)),
    "type: expected one of perspective": lambda: Camera(type="fisheye"),
    "extras: say that the camera is panoramic": lambda: Camera(extras={"panoramic": True}),
    "extras: expected what JSON can hold": lambda: Camera(extras={"a": {1j}}),
    "world_from_camera is not finite": lambda: Camera(world_from_camera=np.full((4, 4), np.inf)),
    "the bottom row": lambda: Camera(world_from_camera=np.ones((4, 4))),
    'hit box 0 "h": triangle 0 has vertex 9': lambda: HitBox("h", TRIANGLE[0], [[0, 1, 9]]),
    "another world_from_mesh": lambda: omma.Scene(
        meshes=[Mesh(*TRIANGLE)] * 2,
        instances=[Instance(0, node=1), Instance(1, np.diag([2, 2, 2, 1]), node=1)],
    ),
}


@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
def test_greys_have_no_axis_of_colours(dtype):
    grey = (np.arange(6).reshape(2, 3) * 30).astype(dtype)
    expected = Image(np.repeat(grey[..., None], 3, 2)).pixels
    for shades in (grey, grey[..., None], np.asfortranarray(grey)):
        assert np.array_equal(Image(shades).pixels, expected)
        assert np.array_equal(omma.Background.image(shades).pixels, expected)
    assert omma.scene.plane((1, 1), grey).images[0].pixels.tolist() == expected.tolist()


@pytest.mark.parametrize("message", WRONG)
def test_what_is_wrong_is_said(message):
    with pytest.raises(omma.Error) as caught:
        WRONG[message]()
    assert message in str(caught.value)


def test_other_types_are_named():
    with pytest.raises(TypeError, match=r"meshes\[1\]: expected omma.scene.Mesh, found int"):
        omma.Scene(meshes=[Mesh(*TRIANGLE), 1])
    with pytest.raises(TypeError, match=r"meshes: expected a list of omma.scene.Mesh, found Mesh"):
        omma.Scene(meshes=Mesh(*TRIANGLE))
    with pytest.raises(TypeError, match=r"background: expected omma.Background, found str"):
        omma.Scene(background="sky")
    with pytest.raises(TypeError, match="double_sided: expected True or False, found int"):
        Material(double_sided=1)
    with pytest.raises(TypeError, match=r"emission: expected omma.light.Spectrum or None, found"):
        Material(emission=[1, 2])
    with pytest.raises(TypeError, match=r"extra_reflectance: expected omma.scene.ExtraReflectance"):
        Material(extra_reflectance=0)
    with pytest.raises(TypeError, match=r"lights\[0\]: expected omma.scene.PunctualLight, found"):
        omma.Scene(lights=[1])


anything = st.one_of(
    st.none(),
    st.integers(),
    st.floats(),
    st.text(max_size=3),
    st.lists(st.floats(), max_size=4),
    st.lists(st.lists(st.integers(-2, 5), max_size=4), max_size=4),
    st.sampled_from(
        [np.zeros((0, 3)), np.zeros((3, 3), complex), np.empty((2, 0)), np.array(["a"]), object()]
    ),
)


@settings(max_examples=200, deadline=None)
@given(
    st.sampled_from(
        [Mesh, Image, Instance, Material, Camera, HitBox, TextureUse, PunctualLight, Spectrum]
    ),
    st.data(),
)
def test_nonsense_is_refused_or_makes_a_value(part, data):
    """Whatever is given: an error of ours or a TypeError, or a part that a scene takes or names."""
    names = {
        Mesh: ("positions_m", "triangles", "colors", "texture_coordinates", "material", "name"),
        Image: ("pixels", "name"),
        Instance: ("mesh", "world_from_mesh", "name", "node"),
        Material: (
            "name", "base_color", "emissive", "alpha_cutoff", "base_color_texture", "ior",
            "specular_color", "normal_texture", "reflectance",
        ),
        Camera: ("name", "yfov_rad", "extras", "world_from_camera"),
        HitBox: ("name", "positions_m", "triangles"),
        TextureUse: ("texture", "offset", "rotation_rad"),
        PunctualLight: ("name", "color", "intensity", "outer_cone_rad", "world_from_light"),
        Spectrum: ("wavelength_nm", "value"),
    }[part]  # fmt: skip
    with contextlib.suppress(omma.Error, TypeError):
        made = part(**{name: data.draw(anything) for name in names})
        assert pickle.loads(pickle.dumps(made)) == made


def test_a_texture_without_texture_coordinates_is_told():
    """Of a scene made in memory, by the world that is made of it; and once, not where it goes."""
    picture = Image(np.ones((4, 4, 3), np.float32))
    guide = ExtraReflectance(0, [Spectrum([300, 410], [0.4, 0])])
    for material in (Material(base_color_texture=0), Material(extra_reflectance=guide)):
        scene = omma.scene.plane((2, 2), name="petal").replace(
            materials=[material], images=[picture], textures=[Texture(0)]
        )
        assert any('"petal"' in one for one in scene.warnings)
        with pytest.warns(UserWarning, match="no texture coordinates"):
            world = omma.World(scene)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            pickle.loads(pickle.dumps(world))
    (mesh,) = scene.meshes
    mapped = Mesh(
        mesh.positions_m,
        mesh.triangles,
        texture_coordinates=np.zeros((len(mesh.positions_m), 2)),
        material=0,
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        omma.World(scene.replace(meshes=[mapped]))
