"""Cameras from Python and the command line; their geometry is tested in C++ (render_camera.cpp)."""

import json
import signal
import struct
import subprocess
import sys
import zlib

import numpy as np
import pytest
from conftest import DATA, write_gltf

import omma
from omma.job.all_cameras import file_names

TURN_RIGHT = {"rotation": [0, -np.sqrt(0.5), 0, np.sqrt(0.5)]}


def png_pixels(path):
    """Pixels of an 8-bit PNG file: (height, width, channels)."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    width, height, depth, kind = struct.unpack(">IIBB", data[16:26])
    channels = {2: 3, 6: 4}[kind]
    assert depth == 8
    at, packed = 8, b""
    while at < len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        if data[at + 4 : at + 8] == b"IDAT":
            packed += data[at + 8 : at + 8 + length]
        at += 12 + length
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, -1)
    out = np.zeros((height + 1, width + 1, channels), np.int32)
    for y, row in enumerate(rows):
        kind, line = row[0], row[1:].reshape(width, channels).astype(np.int32)
        for x in range(width):
            left, up, corner = out[y + 1, x], out[y, x + 1], out[y, x]
            paeth = left + up - corner
            distance = [np.abs(paeth - each) for each in (left, up, corner)]
            nearest = np.where(
                (distance[0] <= distance[1]) & (distance[0] <= distance[2]),
                left,
                np.where(distance[1] <= distance[2], up, corner),
            )
            add = [0 * left, left, up, (left + up) // 2, nearest][kind]
            out[y + 1, x + 1] = (line[x] + add) % 256
    return out[1:, 1:].astype(np.uint8)


@pytest.fixture(scope="module")
def zoo(tmp_path_factory):
    """A folder with zoo.gltf: five cameras of all types 2 m over the coloured ground, and its eye.

    The flags are as files have them: booleans and strings in any case.
    """
    folder = tmp_path_factory.mktemp("zoo")
    up = {"translation": [0, 2, 0]}
    down = {"translation": [0, 2, 0], "rotation": [-np.sqrt(0.5), 0, 0, np.sqrt(0.5)]}
    path = write_gltf(
        folder / "zoo.gltf",
        cameras=[
            ("look", None, up),
            ("map", None, down),
            ("all round", {"panoramic": "TRUE"}, up),
            ("bug", {"compound-eye": True, "compound-structure": "bug.eye"}, up),
            (
                "bug",
                {
                    "compound-eye": "True",
                    "compound-structure": "bug.eye",
                    "compound-projection": "single_dimension_fast",
                },
                up | TURN_RIGHT,
            ),
        ],
        scene_extras={"background-shader": "simple_sky"},
    )
    document = json.loads(path.read_text())
    document["cameras"][0]["perspective"]["aspectRatio"] = 1.5
    document["cameras"][1] = {
        "type": "orthographic",
        "orthographic": {"xmag": 10, "ymag": 10, "znear": 0.1, "zfar": 100},
    }
    path.write_text(json.dumps(document))
    rng = np.random.default_rng(3)
    axis = rng.normal(size=(50, 3))
    omma.save_eye(folder / "bug.eye", omma.Eye(1e-3 * axis, axis, 0.2), unit="m")
    return folder


@pytest.fixture(scope="module")
def world(zoo):
    return omma.load_scene(zoo / "zoo.gltf")


@pytest.fixture
def omma_command(zoo, monkeypatch, run_omma):
    """Runs ``omma ARGUMENTS`` in the zoo's folder: exit code, stdout, stderr."""
    monkeypatch.chdir(zoo)
    return run_omma


def test_types(world):
    types = [camera.type for camera in world.cameras]
    assert types == ["perspective", "orthographic", "panoramic", "compound", "compound"]
    assert world.cameras[4].compound_projection == "single_dimension_fast"
    assert repr(world.cameras[2]) == "<omma.scene.Camera 'all round' panoramic>"


def test_cameras_by_name_and_index(world):
    assert world.camera("map").type == "orthographic"
    assert world.camera(2).name == world.camera("2").name == "all round"
    assert world.camera(np.int64(0)).name == "look"
    for missing in ("nobody", 5, -1):
        with pytest.raises(omma.Error) as caught:
            world.camera(missing)
        assert f'there is no camera "{missing}"; there are 0 "look", 1 "map"' in str(caught.value)
    with pytest.raises(omma.Error, match='2 cameras are called "bug": 3, 4'):
        world.camera("bug")
    with pytest.raises(TypeError, match="name or a whole number"):
        world.camera(1.5)


def test_a_map_from_above(world):
    # The ground's corners: red at -x -z (far left seen from above with ahead up), green, blue,
    # white; colours vary linearly between them.
    picture = omma.render_camera(world, "map", width=40, height=40, samples=1)
    assert picture.shape == (40, 40, 3)
    assert picture.dtype == np.float32
    corner = 0.5 / 40  # of the way from the corner to the next
    for row, column, color in [
        (0, 0, (1, 0, 0)), (0, 39, (0, 1, 0)), (39, 39, (0, 0, 1)), (39, 0, (1, 1, 1)),
    ]:  # fmt: skip
        # Two edges away from the corner's colour by `corner` each, and float rounding.
        assert picture[row, column] == pytest.approx(color, abs=2 * corner + 1e-6)
    # On the edge from red to blue, which the two triangles share: no green.
    along = 0.5 + corner
    assert picture[20, 20] == pytest.approx((1 - along, 0, along), abs=1e-5)


def test_horizon_of_a_perspective_camera(world):
    picture = omma.render_camera(world, "look", width=60)
    assert picture.shape == (40, 60, 3)  # its aspect ratio of 1.5
    # simple_sky at the horizon, to the left of the middle; the ground ends at 10 m, 2 m below.
    sky = np.array([143, 179, 203]) / 255 * 0.8
    assert picture[19, 30] == pytest.approx(sky, abs=0.01)
    edge = 20 + 20 * (2 / 10) / np.tan(0.5)  # row where the ground ends straight ahead
    assert picture[int(edge) - 1, 30, 2] > 0.5
    assert picture[int(edge) + 2, 30, 2] < 0.3


def test_panorama(world):
    picture = omma.render_camera(world, "all round", width=64)
    assert picture.shape == (32, 64, 3)
    top = np.array([1, 31, 117]) / 255
    assert picture[0].mean(axis=0) == pytest.approx(top, abs=0.03)
    # The lowest row is a small ring below the camera, around the middle of the ground.
    assert picture[31].std(axis=0).max() < 0.1
    # Straight ahead in the middle and below the horizon: between the far corners, red and green.
    assert picture[18, 32, :2].min() > 0.3
    # To the right: between green and blue; behind: between blue and white.
    assert picture[18, 48, 0] < 0.3
    assert picture[18, 0, 2] > 0.6


def test_a_renderer_serves_as_well(world, zoo):
    eye = omma.load_eye(zoo / "bug.eye")
    blue = omma.Background.constant((0, 0, 1))
    renderer = omma.Renderer(world, eye, threads=1, background=blue)
    picture = omma.render_camera(renderer, 0, width=30, samples=4, seed=2)
    same = omma.render_camera(world, 0, width=30, samples=4, seed=2, background=blue, threads=3)
    assert (picture == same).all()
    assert (picture != omma.render_camera(world, 0, width=30, samples=4, seed=3)).any()
    with pytest.raises(omma.Error, match="background"):
        omma.render_camera(renderer, 0, background=blue)
    with pytest.raises(omma.Error, match="threads"):
        omma.render_camera(renderer, 0, threads=1)


def test_wrong_arguments(world):
    for arguments, words in [
        ({"camera": 3}, "compound eye"),
        ({"camera": 9}, "there is no camera"),
        ({"camera": 0, "width": 0}, "width"),
        ({"camera": 0, "height": 1 << 20}, "height"),
        ({"camera": 0, "samples": 0}, "samples"),
        ({"camera": 0, "seed": -1}, "seed"),
    ]:
        with pytest.raises(omma.Error, match=words):
            omma.render_camera(world, **arguments)
    with pytest.raises(TypeError, match="scene"):
        omma.render_camera("zoo.gltf", 0)


def test_progress_and_what_it_raises(world):
    fractions = []
    omma.render_camera(world, 0, width=400, samples=4, threads=1, progress=fractions.append)
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1

    def stop(fraction):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        omma.render_camera(world, 0, width=400, samples=4, progress=stop)


CTRL_C = """
import omma

def progress(share):
    print("under way", flush=True)

try:
    omma.render_camera(omma.load_scene("zoo.gltf"), 0, width=20000, samples=1024, progress=progress)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


def test_ctrl_c(zoo):
    process = subprocess.Popen(
        [sys.executable, "-c", CTRL_C], stdout=subprocess.PIPE, text=True, cwd=zoo
    )
    try:
        assert process.stdout.readline() == "under way\n"
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=60)  # the whole picture would take many minutes
        assert out.splitlines()[-1] == "interrupted"
    finally:
        process.kill()
        process.communicate()


def test_display():
    linear = np.array([[[0, 0.5, 1], [2, -0.5, 0.25]]], np.float32)
    expected = [[[0, 255 * 0.5 ** (1 / 2.2), 255], [255, 0, 255 * 0.25 ** (1 / 2.2)]]]
    assert omma.picture.display(linear) == pytest.approx(np.array(expected), abs=1)
    assert omma.picture.display(linear, gamma=1)[0, 1].tolist() in ([255, 0, 63], [255, 0, 64])


def test_eye_of_a_camera(world, zoo, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    eye = omma.picture.camera_eye(world, 3)  # beside the scene
    assert len(eye) == 50
    assert np.linalg.norm(eye.position_m, axis=1).max() > 1e-3  # metres, as the scene
    assert omma.picture.camera_eye(world, 3, unit="mm").position_m == pytest.approx(
        eye.position_m / 1000
    )
    # As given first: from where we are.
    omma.save_eye(tmp_path / "bug.eye", omma.Eye([[0, 0, 0]], [[0, 0, -1]], 0.1))
    assert len(omma.picture.camera_eye(world, world.cameras[3])) == 1
    with pytest.raises(omma.Error, match="camera 'look' names no eye"):
        omma.picture.camera_eye(world, "look")


def test_command_renders_any_camera(omma_command, world, tmp_path):
    outputs = ("-o", tmp_path / "a.png", "-o", tmp_path / "a.npy")
    for camera in ("look", "map", "all round"):
        code, out, err = omma_command(
            *("render", "zoo.gltf", "--camera", camera, "--width", 48, "--samples", 4, *outputs)
        )
        assert (code, err) == (0, "")
        expected = omma.render_camera(world, camera, width=48, samples=4)
        assert (np.load(tmp_path / "a.npy") == expected).all()
        assert (png_pixels(tmp_path / "a.png") == omma.picture.display(expected)).all()
        assert f"view       camera {camera}, {world.camera(camera).type}" in out
        assert f"picture    48 x {len(expected)} pixels" in out
        assert "(4 per pixel)" in out
    code, out, _ = omma_command("render", "zoo.gltf", "--camera", "1", "--height", 9, *outputs)
    assert code == 0
    assert "camera map" in out
    assert np.load(tmp_path / "a.npy").shape == (9, 9, 3)


def test_command_renders_a_compound_camera(omma_command, world, tmp_path):
    def run(*arguments):
        code, _, err = omma_command(
            *("render", "zoo.gltf", *arguments, "-o", tmp_path / "a.png", "-o", tmp_path / "a.npy")
        )
        assert (code, err) == (0, "")
        return png_pixels(tmp_path / "a.png"), np.load(tmp_path / "a.npy")

    eye = omma.picture.camera_eye(world, 4)
    responses = omma.Renderer(world, eye).render(world.cameras[4].world_from_camera)
    picture, array = run("--camera", 4)
    assert (array == responses).all()
    assert picture.shape == (1, 50, 3)  # single_dimension_fast, as the camera says
    assert (picture[0] == omma.picture.display(responses)[0]).all()
    picture, array = run("--camera", 4, "--projection", "mollweide", "--width", 40)
    assert (picture == omma.picture.project(eye, responses, "mollweide", 40)).all()
    assert (picture == run("--camera", 4, "--projection", "mollweide", "--height", 20)[0]).all()
    # Without a camera the first compound one, which says nothing of a projection.
    picture, _ = run("--width", 30)
    responses = omma.Renderer(world, eye).render(world.cameras[3].world_from_camera)
    assert (picture == omma.picture.project(eye, responses, "spherical_orientationwise", 30)).all()
    picture, _ = run("--camera", 3, "--projection", "spherical_positionwise_ids", "--width", 30)
    ids = omma.picture.projection_ids(eye, "spherical_positionwise", 30)
    assert (picture == omma.picture.encode_ids(ids)).all()
    picture, _ = run("--camera", 3, "--projection", "raw_ommatidial_samples", "--samples", 5)
    renderer = omma.Renderer(world, eye, omma.Fixed(5))
    rays = renderer.render_rays(world.cameras[3].world_from_camera)
    assert picture.shape == (5, 50, 3)
    assert (picture == omma.picture.project(eye, rays, "raw_ommatidial_samples")).all()


def test_all_cameras_in_one_command(omma_command, world, tmp_path):
    folder = tmp_path / "new" / "pictures"
    code, out, err = omma_command(
        "render-cameras", "zoo.gltf", "-o", folder, "--width", 32, "--samples", 4
    )
    assert (code, err) == (0, "")
    names = ["look", "map", "all_round", "bug", "bug_2"]
    assert sorted(path.name for path in folder.iterdir()) == sorted(f"{n}.png" for n in names)
    for camera, name in zip(world.cameras, names, strict=True):
        assert f"wrote      {folder / name}.png" in out
        pixels = png_pixels(folder / f"{name}.png")
        if camera.type != "compound":
            expected = omma.picture.display(omma.render_camera(world, camera, width=32, samples=4))
        else:
            eye = omma.picture.camera_eye(world, camera)
            responses = omma.Renderer(world, eye, omma.Fixed(4)).render(camera.world_from_camera)
            which = camera.compound_projection or "spherical_orientationwise"
            # What has a pixel for each ommatidium keeps its size.
            width = None if which == "single_dimension_fast" else 32
            expected = omma.picture.project(eye, responses, which, width)
        assert (pixels == expected).all(), name
    assert "camera 4   bug (compound, single_dimension_fast): 50 x 1 pixels" in out
    # Once more, over what is there, with one projection for all eyes.
    code, out, _ = omma_command(
        *("render-cameras", "zoo.gltf", "-o", folder, "--width", 32),
        *("--projection", "lambert", "--samples", 1),
    )
    assert code == 0
    assert png_pixels(folder / "bug_2.png").shape == (32, 32, 3)


def test_the_old_option_for_all_cameras(omma_command, world, tmp_path):
    """It works with a warning, which no help mentions."""
    given = ("--width", 32, "--samples", 4, "--seed", 3)
    code, out, err = omma_command(
        "render", "zoo.gltf", "--all-cameras", "-o", tmp_path / "old", *given
    )
    assert (code, err) == (
        0,
        "omma: warning: --all-cameras is the command omma render-cameras now; the old option works "
        "until 0.2\n",
    )
    assert f"wrote      {tmp_path / 'old' / 'bug_2'}.png" in out
    assert omma_command("render-cameras", "zoo.gltf", "-o", tmp_path / "new", *given)[0] == 0
    for old in sorted((tmp_path / "old").iterdir()):
        assert old.read_bytes() == (tmp_path / "new" / old.name).read_bytes()
    assert "--all-cameras" not in omma_command("render", "--help")[1]


def test_a_projection_that_there_is_not(omma_command, zoo, tmp_path):
    odd = {"compound-eye": "true", "compound-structure": "bug.eye", "compound-projection": "odd"}
    write_gltf(zoo / "odd.gltf", cameras=[("odd", odd, {})])
    for command, output in (("render", "a.png"), ("render-cameras", "all")):
        code, _, err = omma_command(command, "odd.gltf", "-o", tmp_path / output, "--width", 20)
        assert code == 0
        assert err.startswith("omma: warning: camera 'odd': there is no projection 'odd'")
        assert err.count("\n") == 1


def test_info_lists_cameras_with_their_type(omma_command):
    code, out, _ = omma_command("info", "zoo.gltf")
    assert code == 0
    for text in (
        "0 look: perspective at",
        "1 map: orthographic at",
        "2 all round: panoramic at",
        "4 bug: compound at (0, 2, 0) m, eye bug.eye as single_dimension_fast",
    ):
        assert text in out


def test_file_names_are_safe_and_unlike():
    names = ["a", "A", "a", "../../x", "b/c d", "", "..", "é", "a_2", "x" * 500]
    found = file_names(names)
    assert found[:9] == ["a", "A_2", "a_3", "_.._x", "b_c_d", "camera", "camera_2", "é", "a_2_2"]
    assert len(found[9]) == 100
    assert len({name.lower() for name in found}) == len(names)


def test_hit_boxes(tmp_path):
    path = write_gltf(tmp_path / "box.gltf")
    document = json.loads(path.read_text())
    # The ground becomes a pyramid under the point (0, 4, 0): a fifth vertex and its sides.
    corners = [[-10, 0, -10], [10, 0, -10], [10, 0, 10], [-10, 0, 10], [0, 4, 0]]
    sides = [[0, 1, 2], [0, 2, 3], [1, 0, 4], [2, 1, 4], [3, 2, 4], [0, 3, 4]]
    data = np.array(corners, "<f4").tobytes() + np.array(sides, "<u2").tobytes()
    (tmp_path / "box.bin").write_bytes(data)
    document["buffers"] = [{"uri": "box.bin", "byteLength": len(data)}]
    document["bufferViews"] = [
        {"buffer": 0, "byteOffset": 0, "byteLength": 60},
        {"buffer": 0, "byteOffset": 60, "byteLength": 36},
    ]
    document["accessors"] = [
        {
            **{"bufferView": 0, "componentType": 5126, "count": 5, "type": "VEC3"},
            **{"min": [-10, 0, -10], "max": [10, 4, 10]},
        },
        {"bufferView": 1, "componentType": 5123, "count": 18, "type": "SCALAR"},
    ]
    mesh = {"name": "pyramid", "extras": {"hitbox": "true"}}
    mesh["primitives"] = [{"attributes": {"POSITION": 0}, "indices": 1}]
    document["meshes"] = [mesh]
    document["nodes"] = [
        {"mesh": 0, "translation": [0, 1, 0]},
        {"mesh": 0, "translation": [100, 1, 0]},
    ]
    document["scenes"][0]["nodes"] = [0, 1]
    path.write_text(json.dumps(document))
    scene = omma.load_scene(path)
    assert scene.triangle_count == 0
    # Both places of the mesh are one region.
    assert scene.hit_box_names == ["pyramid"]
    assert len(scene.hit_boxes) == 2
    assert scene.hit_box_bounds("pyramid").tolist() == [[-10, 1, -10], [110, 5, 10]]
    points = [[0, 2, 0], [0, 4.9, 0], [0, 5.1, 0], [0, 0.9, 0], [9, 3, 0], [100, 2, 1], [50, 2, 0]]
    inside = scene.is_inside("pyramid", points)
    assert inside.dtype == bool
    assert inside.tolist() == [True, True, False, False, False, True, False]
    assert scene.is_inside("pyramid", np.zeros((0, 3))).shape == (0,)
    with pytest.raises(omma.Error, match="there is no hit box 'cube'; there are 'pyramid'"):
        scene.is_inside("cube", points)
    with pytest.raises(omma.Error, match="points_m"):
        scene.is_inside("pyramid", [0, 1, 2])
    with pytest.raises(omma.Error, match="the scene has none"):
        omma.Scene().hit_box_bounds("pyramid")


SCENES = [
    ("natural-standin-sky.gltf", 4), ("test-scene.gltf", 6), ("test-scene-sky.gltf", 6),
    ("env_2.gltf", 2), ("environment.glb", 2), ("ofstad-arena.gltf", 3),
]  # fmt: skip


@pytest.mark.skipif(not DATA.is_dir(), reason=f"no real data at {DATA}")
@pytest.mark.parametrize(("scene", "count"), SCENES)
def test_every_camera_of_real_scenes(scene, count, tmp_path):
    path = DATA / "compound-ray" / "scenes" / scene
    report = omma.job.render_all_cameras(path, tmp_path, omma.Fixed(2), width=64)
    assert len(report.cameras) == len(list(tmp_path.glob("*.png"))) == count
    assert report.warnings == tuple(omma.load_scene(path).warnings)
    for camera in report.cameras:
        picture = png_pixels(tmp_path / camera.output)
        assert picture.shape[:2] == (camera.height, camera.width)
        # The cameras of the experiment's scenes stand inside a sphere of one colour.
        assert scene.startswith("env") or picture.std() > 0
