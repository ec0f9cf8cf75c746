"""CompoundRay's library under its old name: frames, pictures, poses, geometry."""

import base64
import itertools
import json
import math
import shutil
from ctypes import c_ubyte, c_void_p

import numpy as np
from compoundray_lib import (
    BLUE,
    CYAN,
    GREEN,
    GREY,
    RED,
    ROOM,
    YELLOW,
    frame,
    go,
    position,
    read_ppm,
    set_size,
    shader,
)
from conftest import write_gltf
from numpy.ctypeslib import ndpointer


def test_bottom_row_first_and_top_row_first(lib, tmp_path):
    go(lib, "front")
    set_size(lib, 30, 20)
    lib.rotateCameraLocallyAround(math.pi / 4, 1, 0, 0)  # up: the blue ceiling, the grey wall below
    picture = frame(lib)
    assert (picture[19, 15] == [*BLUE, 255]).all()
    assert (picture[0, 15] == [*GREY, 255]).all()
    lib.saveFrameAs(str(tmp_path / "frame.ppm").encode())
    assert (read_ppm(tmp_path / "frame.ppm") == picture[::-1, :, :3]).all()
    assert [p.name for p in tmp_path.iterdir() if "part" in p.name] == []
    copied = np.empty((20, 30, 3), np.uint8)
    lib.getFrame(copied.ctypes.data_as(c_void_p))
    assert (copied == picture[..., :3]).all()


def test_a_picture_is_what_its_rays_see(lib):
    """Every pixel of a perspective picture against the wall its ray meets, in plain NumPy."""
    go(lib, "front")
    width, height = 37, 23  # not square: the field is all the same
    set_size(lib, width, height)
    lib.setCameraPose(1, -2, 3, 0.3, 0.8, -0.4)
    lib.translateCameraLocally(0.5, 0.25, -1)
    picture = frame(lib)

    def turn(angle, axis):
        k = np.eye(3)[axis]
        cross = np.cross(k, np.eye(3)).T  # of k with each column
        along = (1 - np.cos(angle)) * np.outer(k, k)
        return np.cos(angle) * np.eye(3) + np.sin(angle) * cross + along

    space = turn(-0.4, 2) @ turn(0.8, 1) @ turn(0.3, 0)  # columns: right, up, forward
    origin = np.array([1, -2, 3]) + space @ [0.5, 0.25, -1]
    np.testing.assert_allclose(position(lib), origin, atol=1e-6)
    colors = {(0, 1): RED, (0, -1): GREEN, (1, 1): BLUE, (1, -1): YELLOW, (2, 1): CYAN,
              (2, -1): GREY}  # fmt: skip
    compared = 0
    for row, column in itertools.product(range(height), range(width)):
        # 90 degrees of view in both directions, through the pixel's lower left corner.
        ray = space @ [2 * column / width - 1, 2 * row / height - 1, 1]
        with np.errstate(divide="ignore"):
            distances = (10 * np.sign(ray) - origin) / ray
        first, second = np.sort(distances)[:2]
        if second - first < 1e-4:
            continue  # a corner of the room
        axis = int(np.argmin(distances))
        assert tuple(picture[row, column, :3]) == colors[axis, int(np.sign(ray[axis]))]
        compared += 1
    assert compared > 0.9 * width * height


def test_orthographic_and_panoramic(lib):
    set_size(lib, 8, 8)
    go(lib, "map")
    assert (frame(lib)[..., :3] == GREY).all()  # all rays parallel, within the room
    lib.translateCamera(8, 0, 0)  # the right half is now beyond the wall at +x
    beyond = frame(lib)
    assert (beyond[:, :4, :3] == GREY).all()
    assert not (beyond[:, 5:, :3] == GREY).all()
    go(lib, "panorama")
    picture = frame(lib)
    middle = [tuple(picture[4, column, :3]) for column in (0, 2, 4, 6)]
    assert middle == [CYAN, GREEN, GREY, RED]
    assert tuple(picture[0, 3, :3]) == YELLOW
    assert tuple(picture[7, 3, :3]) == BLUE


def test_what_is_nearer_than_a_hundredth_is_not_seen(lib):
    """In units of the ray's own length for a perspective camera, of the world for a panoramic."""
    set_size(lib, 2, 2)  # pixel (1, 1) looks straight ahead
    for name, near in (("front", 0.01), ("panorama", 0.01), ("map", 0.01)):
        go(lib, name)
        scale = 3.0
        lib.setCameraLocalSpace(scale, 0, 0, 0, scale, 0, 0, 0, -scale)
        reach = near * (1 if name == "panorama" else scale)
        for distance, seen in ((1.05 * reach, True), (0.95 * reach, False)):
            lib.setCameraPosition(0, 0, -10 + distance)
            assert (tuple(frame(lib)[1, 1, :3]) == GREY) == seen, (name, distance)


def test_reset_looks_to_plus_z(lib):
    set_size(lib, 2, 2)
    for name in ("front", "panorama", "map"):
        go(lib, name)
        lib.setCameraPosition(1, 1, 1)
        lib.resetCameraPose()
        assert position(lib) == [0, 0, 0]
        assert tuple(frame(lib)[1, 1, :3]) == CYAN
    go(lib, "insect")
    shader(lib, "single_dimension")
    lib.resetCameraPose()
    set_size(lib, 6, 1)
    # The eye's forward, back, right, left, up, down: its right is +x though it looks along +z.
    expected = [CYAN, GREY, RED, GREEN, BLUE, YELLOW]
    assert [tuple(p[:3]) for p in frame(lib)[0]] == expected


def test_poses_that_cannot_be(lib, capfd):
    set_size(lib, 3, 3)
    go(lib, "front")
    before = frame(lib)
    lib.rotateCameraAround(1, 0, 0, 0)
    assert "ERROR" in capfd.readouterr().err
    for space in ([0] * 9, [math.nan] + [0] * 8, [1, 0, 0, 1, 0, 0, 0, 0, 1]):
        lib.setCameraLocalSpace(*space)
        lib.renderFrame()
        assert "ERROR: the camera 'front' has a local space" in capfd.readouterr().err
        assert (lib.getFramePointer() == before).all()
    lib.resetCameraPose()
    lib.setCameraPosition(math.inf, 0, 0)
    lib.renderFrame()
    assert "ERROR" in capfd.readouterr().err


def test_sizes_that_cannot_be(lib, capfd):
    go(lib, "front")
    for size in ((0, 0), (-5, 10), (1, 1)):
        lib.setRenderSize(*size)
        lib.getFramePointer.restype = ndpointer(dtype=c_ubyte, shape=(1, 1, 4))
        assert frame(lib)[0, 0, 3] == 255
    lib.setRenderSize(2**30, 2**30)
    assert "ERROR" in capfd.readouterr().err
    assert frame(lib)[0, 0, 3] == 255
    lib.setCurrentEyeSamplesPerOmmatidium(2**31 - 1)
    go(lib, "insect")
    lib.setCurrentEyeSamplesPerOmmatidium(2**31 - 1)
    assert "ERROR" in capfd.readouterr().err
    lib.changeCurrentEyeSamplesPerOmmatidiumBy(2**31 - 1)
    assert lib.getCurrentEyeSamplesPerOmmatidium() == 2**20


def test_geometry(lib):
    root = math.sqrt(2)
    np.testing.assert_allclose(lib.getGeometryMaxBounds(b"box").values(), [2 + root, 1, root], 1e-6)
    np.testing.assert_allclose(
        lib.getGeometryMinBounds(b"box").values(), [2 - root, -1, -root], 1e-6
    )
    np.testing.assert_allclose(
        lib.getGeometryMinBounds(b"wall -z").values(), [-10, -10, -10], atol=1e-5
    )
    assert (lib.getGeometryMaxBounds(b"nothing").values() == 0).all()
    # A cube turned by 45 degrees about y: |x - 2| + |z| below the root of 2.
    rng = np.random.default_rng(2)
    for x, y, z in rng.uniform([0, -1.5, -2], [4, 1.5, 2], (200, 3)):
        inside = abs(x - 2) + abs(z) < root and abs(y) < 1
        assert lib.isInsideHitGeometry(x, y, z, b"box") == inside
    set_size(lib, 3, 3)
    go(lib, "front")
    lib.setCameraLocalSpace(0, 0, 1, 0, 1, 0, 1, 0, 0)  # towards the box, which is not drawn
    assert tuple(frame(lib)[1, 1, :3]) == RED


def test_no_background_named_is_the_test_pattern(fresh, tmp_path):
    path = write_gltf(tmp_path / "bare.gltf", triangles=False)
    fresh.loadGlTFscene(str(path).encode())
    assert fresh.getCurrentCameraName() == b"Default Camera"
    set_size(fresh, 4, 4)
    fresh.setCameraLocalSpace(0, 0, 1, 0, 1, 0, 1, 0, 0)
    direction = np.array([1, -1 / 2 * 10, -1 / 2 * 10])  # pixel (1, 1); its scale is 10
    x, y, z = direction / np.linalg.norm(direction)
    expected = [
        (math.atan2(z, x) + math.pi) / (2 * math.pi),
        (math.asin(y) + math.pi / 2) / math.pi,
    ]
    shown = frame(fresh)[1, 1, :3]
    np.testing.assert_allclose(shown[:2], 255 * np.array(expected) ** (1 / 2.2), atol=1)
    assert shown[2] == 0


def test_a_binary_scene(fresh, tmp_path):
    """The room as .glb: the same picture."""
    document = json.loads((ROOM / "room.gltf").read_text())
    data = base64.b64decode(document["buffers"][0].pop("uri").split(",")[1])
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    size = 28 + len(text) + len(data)
    header = [0x46546C67, 2, size, len(text), 0x4E4F534A]
    path = tmp_path / "room.glb"
    path.write_bytes(
        np.array(header, "<u4").tobytes() + text
        + np.array([len(data), 0x004E4942], "<u4").tobytes() + data
    )  # fmt: skip
    shutil.copy(ROOM / "six.eye", tmp_path)
    fresh.loadGlTFscene(str(path).encode())
    assert fresh.getCameraCount() == 6
    set_size(fresh, 3, 3)
    go(fresh, "front")
    assert tuple(frame(fresh)[1, 1, :3]) == GREY


def test_after_stop(lib, capfd):
    set_size(lib, 3, 3)
    go(lib, "front")
    before = frame(lib)
    lib.stop()
    assert (lib.getFramePointer() == before).all()
    lib.renderFrame()
    assert "ERROR: there is no scene" in capfd.readouterr().err
    assert lib.getCurrentCameraName() == b"front"
    lib.loadGlTFscene(str(ROOM / "room.gltf").encode())
    go(lib, "front")
    assert (frame(lib) == before).all()


def test_a_script_may_hold_the_frame_while_the_size_shrinks(lib):
    set_size(lib, 900, 700)
    held = lib.getFramePointer()
    set_size(lib, 3, 2)
    assert not held.any()  # two and a half megabytes, given back they would be out of reach
    assert held.ctypes.data == lib.getFramePointer().ctypes.data
