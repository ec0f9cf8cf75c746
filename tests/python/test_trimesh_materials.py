"""What becomes of the materials of trimesh, and of alpha in colours of vertices and faces."""

import warnings

import numpy as np
import pytest

import omma
from omma.scene import from_trimesh, load_scene

trimesh = pytest.importorskip("trimesh")
pillow = pytest.importorskip("PIL.Image")

CORNERS = [(-1, -1, -2), (1, -1, -2), (1, 1, -2), (-1, 1, -2)]
FACES = [(0, 1, 2), (0, 2, 3)]
COORDINATES = [(0, 0), (1, 0), (1, 1), (0, 1)]
BLUE = omma.Background.constant((0, 0, 1))


def square(**visual):
    made = trimesh.Trimesh(CORNERS, FACES, process=False)
    if visual:
        made.visual = trimesh.visual.TextureVisuals(uv=COORDINATES, **visual)
    return made


def seen(scene):
    eye = omma.Eye([[0.1, 0.2, 0]], [[0, 0, -1]], 0.0)
    return omma.Renderer(omma.World(scene, background=BLUE), eye, omma.Fixed(64)).render(np.eye(4))[
        0, 0
    ]


def picture(*color):
    return pillow.fromarray(np.full((4, 4, len(color)), color, np.uint8))


def physical(**more):
    return square(material=trimesh.visual.material.PBRMaterial(**more))


def test_physical_materials_are_taken_whole():
    factors = {
        "baseColorFactor": [51, 102, 153, 128],
        "emissiveFactor": [0.5, 0.25, 1],
        "metallicFactor": 0.75,
        "roughnessFactor": 0.3,
        "alphaMode": "MASK",
        "alphaCutoff": 0.4,
        "doubleSided": True,
    }
    shine, glow = picture(0, 128, 255), picture(188, 188, 188)
    scene = from_trimesh(
        physical(
            **factors,
            emissiveTexture=glow,
            metallicRoughnessTexture=shine,
            normalTexture=picture(128, 128, 255),
            baseColorTexture=glow,
        )
    )
    (made,) = scene.materials
    assert made.base_color == pytest.approx((0.2, 0.4, 0.6, 128 / 255))
    assert made.emissive == (0.5, 0.25, 1)
    assert (made.metallic, made.roughness) == pytest.approx((0.75, 0.3))
    assert (made.alpha_mode, made.alpha_cutoff) == ("mask", pytest.approx(0.4))
    assert made.double_sided
    assert made.emissive_texture == made.base_color_texture  # one picture
    of = [made.emissive_texture, made.metallic_roughness_texture, made.normal_texture]
    first = [scene.images[scene.textures[one.texture].image].pixels[0, 0, :3] for one in of]
    assert np.array_equal(first, [[188] * 3, [0, 128, 255], [128, 128, 255]])


def test_a_file_and_trimesh_say_the_same_of_what_shines(tmp_path):
    glow = picture(255, 128, 0)
    mesh = physical(
        baseColorFactor=[0, 0, 0, 255], emissiveFactor=[1, 1, 0.5], emissiveTexture=glow,
        metallicFactor=0.5, roughnessFactor=0.25, metallicRoughnessTexture=glow,
    )  # fmt: skip
    mesh.export(tmp_path / "lamp.glb")
    file = load_scene(tmp_path / "lamp.glb")
    memory = from_trimesh(trimesh.load(tmp_path / "lamp.glb"))
    assert seen(file)[0] > 0.9
    assert seen(memory) == pytest.approx(seen(file), abs=1e-6)
    for name in ("metallic", "roughness", "emissive", "base_color"):
        assert getattr(memory.materials[0], name) == getattr(file.materials[0], name)


def test_what_says_nothing_of_metal_is_none():
    (plain,) = from_trimesh(physical(baseColorFactor=[255, 0, 0, 255])).materials
    assert (plain.metallic, plain.roughness, plain.emissive) == (0, 1, (0, 0, 0))
    (by_picture,) = from_trimesh(physical(metallicRoughnessTexture=picture(0, 255, 255))).materials
    assert by_picture.metallic == 1


def test_other_materials_are_told():
    several = trimesh.visual.material.MultiMaterial([trimesh.visual.material.SimpleMaterial()])
    with pytest.warns(UserWarning, match="MultiMaterial"):
        scene = from_trimesh(square(material=several))
    assert scene.materials[0].base_color == (1, 1, 1, 1)


@pytest.mark.parametrize("kind", ["vertex_colors", "face_colors"])
def test_alpha_of_colours_lets_light_through(kind):
    mesh = square()
    setattr(mesh.visual, kind, [255, 0, 0, 64])
    scene = from_trimesh(mesh)
    assert scene.materials[0].alpha_mode == "blend"
    assert seen(scene) == pytest.approx((64 / 255, 0, 1 - 64 / 255), abs=1e-5)
    setattr(mesh.visual, kind, [255, 0, 0, 255])
    assert from_trimesh(mesh).materials[0].alpha_mode == "opaque"
    # Programs that know of no alpha leave it 0.
    setattr(mesh.visual, kind, [255, 0, 0, 0])
    with pytest.warns(UserWarning, match="alpha"):
        scene = from_trimesh(mesh)
    assert seen(scene) == pytest.approx((1, 0, 0))


def test_alpha_of_diffuse_colours_and_colours_beside_a_material():
    glass = trimesh.visual.material.SimpleMaterial(diffuse=[255, 0, 0, 64])
    assert seen(from_trimesh(square(material=glass))) == pytest.approx(
        (64 / 255, 0, 1 - 64 / 255), abs=1e-5
    )
    both = physical(baseColorFactor=[255, 255, 255, 255])
    both.visual.vertex_attributes["color"] = np.full((4, 4), (255, 0, 0, 64), np.uint8)
    scene = from_trimesh(both)
    assert scene.materials[0].alpha_mode == "opaque"  # glTF's own word
    assert scene.meshes[0].colors[0] == pytest.approx((1, 0, 0, 64 / 255))


def test_two_meshes_one_of_which_is_clear():
    clear, solid = square(), square()
    clear.visual.vertex_colors = [255, 0, 0, 64]
    solid.visual.vertex_colors = [255, 0, 0, 255]
    scene = from_trimesh(trimesh.Scene({"clear": clear, "solid": solid}))
    modes = {one.name: scene.materials[one.material].alpha_mode for one in scene.meshes}
    assert modes == {"clear": "blend", "solid": "opaque"}


def ply(alphas, kind="uchar", largest=255):
    rows = [f"{x} {y} {z} {largest} 0 0 {a}" for (x, y, z), a in zip(CORNERS, alphas, strict=True)]
    names = "".join(f"property {kind} {one}\n" for one in ("red", "green", "blue", "alpha"))
    return (
        "ply\nformat ascii 1.0\nelement vertex 4\n"
        "property float x\nproperty float y\nproperty float z\n" + names + "element face 1\n"
        "property list uchar int vertex_indices\nend_header\n" + "\n".join(rows) + "\n4 0 1 2 3\n"
    )


def test_alpha_of_ply_files(tmp_path):
    path = tmp_path / "leaf.ply"
    for text in (ply([64] * 4), ply([64 / 255] * 4, "float", 1)):
        path.write_text(text)
        assert seen(load_scene(path)) == pytest.approx((64 / 255, 0, 1 - 64 / 255), abs=1e-5)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        path.write_text(ply([255] * 4))
        scene = load_scene(path)
        assert scene.materials[0].alpha_mode == "opaque"
        path.write_text(ply([255, 255, 255, 0]))
        assert load_scene(path).materials[0].alpha_mode == "blend"
    path.write_text(ply([0] * 4))
    with pytest.warns(UserWarning, match="alpha"):
        scene = load_scene(path)
    assert seen(scene) == pytest.approx((1, 0, 0))
