"""Scenes and backgrounds as Python sees them; the loader itself is tested in C++."""

import json
import re
import warnings
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA, make_eye, write_gltf

import omma

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def test_what_a_scene_says(scene, files):
    assert scene.path == str(files / "scene.gltf")
    assert scene.triangle_count == 2
    assert scene.mesh_count == scene.instance_count == 1
    assert scene.node_count == 3
    assert scene.bounds.tolist() == [[-10, 0, -10], [10, 0, 10]]
    assert scene.background.type == "simple_sky"
    assert scene.warnings == []
    assert "2 triangles" in repr(scene)


def test_cameras(scene):
    plain, insect = scene.cameras
    assert (plain.name, plain.type, plain.extras) == (
        "plain", "perspective", {"note": "look", "n": [1, 2]},
    )  # fmt: skip
    assert plain.compound_structure == ""
    assert insect.compound_structure == "bug.eye"
    expected = np.diag([0.5, 0.5, 0.5, 1])
    expected[:3, 3] = 1, 2, 3
    assert insect.world_from_camera == pytest.approx(expected)
    assert scene.camera("insect").name == "insect"
    with pytest.raises(omma.Error) as caught:
        scene.camera("nobody")
    assert "nobody" in str(caught.value)
    assert "insect" in str(caught.value)


def test_empty_scenes(tmp_path, eye):
    for empty in (
        omma.Scene(),
        omma.load_scene(write_gltf(tmp_path / "empty.gltf", triangles=False)),
    ):
        assert empty.triangle_count == 0
        assert empty.bounds is None
        assert (omma.Renderer(empty, eye).render(np.eye(4)) == 0).all()


def test_scene_index(files):
    assert omma.load_scene(files / "scene.gltf", 0).triangle_count == 2
    for index in (1, 99, -1):
        with pytest.raises(omma.Error, match="scene"):
            omma.load_scene(files / "scene.gltf", scene_index=index)


def test_backgrounds(eye, tmp_path):
    def seen(background):
        return omma.Renderer(omma.Scene(), eye, background=background).render(np.eye(4))[0]

    # 8-bit pixels are sRGB: 188 is 0.5029 linear; float pixels are linear already.
    white = np.full((8, 16, 3), 188, np.uint8)
    assert seen(omma.Background.image(white)) == pytest.approx(0.50289, abs=1e-4)
    assert seen(omma.Background.image(np.full((8, 16, 4), 2.5))) == pytest.approx(2.5, rel=1e-6)
    omma.save_png(tmp_path / "white.png", white)
    assert (seen(omma.Background.image(tmp_path / "white.png")) ==
            seen(omma.Background.image(white))).all()  # fmt: skip
    up = seen(omma.Background.simple_sky())[eye.axis[:, 1].argmax()]
    assert up[2] > up[1] > up[0]
    assert omma.Background.constant((1, 2, 3)).color == (1, 2, 3)
    assert omma.Background.test_pattern().type == "test_pattern"


def test_image_is_the_right_way_round():
    # Left half red (the animal's left), right half green; top half also blue.
    image = np.zeros((64, 128, 3), np.float32)
    image[:, :64, 0] = image[:, 64:, 1] = image[:32, :, 2] = 1
    looks = [[-1, 0.5, -1], [1, 0.5, -1], [1, -0.5, 1], [-1, -0.5, 1]]
    eye = omma.Eye(np.zeros((4, 3)), looks, np.radians(1))
    background = omma.Background.image(image)
    seen = omma.Renderer(omma.Scene(), eye, background=background).render(np.eye(4))[0]
    assert seen.round(5).tolist() == [[1, 0, 1], [0, 1, 1], [0, 1, 0], [1, 0, 0]]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: omma.Background.constant("red"), ["color", "(3,)"]),
        (lambda: omma.Background.constant((1, 2)), ["color", "(3,)", "(2,)"]),
        (lambda: omma.Background.constant((1, 2, float("inf"))), ["color", "finite"]),
        (lambda: omma.Background.image(np.zeros((2, 2, 2), np.uint8)), ["image", "(2, 2, 2)"]),
        (lambda: omma.Background.image(np.zeros((2, 2, 3), int)), ["image", "int64"]),
        (lambda: omma.Background.image(np.full((2, 2, 3), np.nan)), ["image", "finite"]),
        (lambda: omma.Background.image(np.zeros((0, 2, 3))), ["image", "(0, 2, 3)"]),
        (lambda: omma.Background.image("missing.png"), ["missing.png"]),
    ],
)
def test_wrong_backgrounds(make, words):
    with pytest.raises(omma.Error) as caught:
        make()
    for word in words:
        assert word in str(caught.value)


@pytest.mark.skipif(not DATA.is_dir(), reason=f"no real data at {DATA}")
def test_real_data():
    scenes = DATA / "compound-ray" / "scenes"
    meadow = omma.load_scene(scenes / "natural-standin-sky.gltf")
    assert meadow.triangle_count == 24_200
    assert sum(camera.compound_structure != "" for camera in meadow.cameras) == 3
    bee = omma.load_eye(DATA / "compound-ray" / "bees" / "AM_60185-real.eye")
    assert len(bee) == 6374
    responses = omma.Renderer(meadow, bee, omma.Fixed(4)).render(meadow.cameras[0].name)
    assert np.isfinite(responses).all()
    assert 0 < responses.mean() < 1


def test_a_scene_that_is_not_lit_says_so_once(tmp_path, run_omma):
    lit = write_gltf(
        tmp_path / "lit.gltf",
        extensionsUsed=["KHR_lights_punctual"],
        extensions={"KHR_lights_punctual": {"lights": [{"type": "point"}]}},
    )
    document = json.loads(lit.read_text())
    document["materials"] = [{"name": "plain"}]
    document["meshes"][0]["primitives"][0]["material"] = 0
    document["nodes"][0]["extensions"] = {"KHR_lights_punctual": {"light": 0}}
    lit.write_text(json.dumps(document))
    says = (
        "without a light surfaces show their own colours, unshaded; made for light: 1 of 1 "
        "materials, 1 lamp"
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene = omma.load_scene(lit)
        assert scene.warnings == [says]
        omma.World(scene, light=omma.light.lamps())
    with pytest.warns(UserWarning, match=re.escape(f"{lit}: {says}")) as heard:
        omma.World(scene)
    assert [one.filename for one in heard] == [__file__]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        omma.World(scene)  # told once a session
    omma.save_eye(tmp_path / "bug.eye", make_eye())
    given = ("--eye", tmp_path / "bug.eye", "-o", tmp_path / "a.npy")
    code, _, err = run_omma("render", lit, *given)
    assert (code, err) == (0, f"omma: warning: {says}\n")
    for file in (lit, tmp_path / "a.npy"):
        if file.suffix == ".npy":
            pytest.importorskip("xarray")
        _, out, err = run_omma("info", file)
        assert out.count(says) == 1
        assert err == ""


def test_a_scene_of_unlit_materials_says_nothing(tmp_path):
    scene = write_gltf(
        tmp_path / "unlit.gltf",
        extensionsUsed=["KHR_materials_unlit"],
        materials=[{"extensions": {"KHR_materials_unlit": {}}}],
    )
    document = json.loads(scene.read_text())
    document["meshes"][0]["primitives"][0]["material"] = 0
    scene.write_text(json.dumps(document))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert omma.load_scene(scene).warnings == []
        omma.load_scene(EXAMPLES / "meadow.glb")
