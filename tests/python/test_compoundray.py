"""CompoundRay's library under its old name, as its ctypes scripts use it."""

import ctypes
import itertools
import math
import os
import shutil
import subprocess
import sys
from ctypes import (
    CDLL,
    POINTER,
    Structure,
    byref,
    c_bool,
    c_char_p,
    c_double,
    c_float,
    c_int,
    c_size_t,
    c_ubyte,
    c_void_p,
)
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA, write_gltf
from numpy.ctypeslib import ndpointer

import omma

ROOM = Path(__file__).resolve().parents[1] / "compat"
SCENES = DATA / "compound-ray" / "scenes"
GREY = 186  # trunc(255 * 0.5 ** (1 / 2.2))
CYAN, RED, GREEN, BLUE, YELLOW = (0, 255, 255), (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 0)
EVERY_FUNCTION = [
    "setVerbosity",
    "loadGlTFscene",
    "stop",
    "setRenderSize",
    "renderFrame",
    "displayFrame",
    "saveFrameAs",
    "getFramePointer",
    "getFrame",
    "getCameraCount",
    "nextCamera",
    "previousCamera",
    "getCurrentCameraIndex",
    "getCurrentCameraName",
    "gotoCamera",
    "gotoCameraByName",
    "setCameraPosition",
    "getCameraPosition",
    "setCameraLocalSpace",
    "rotateCameraAround",
    "rotateCameraLocallyAround",
    "translateCamera",
    "translateCameraLocally",
    "resetCameraPose",
    "setCameraPose",
    "isCompoundEyeActive",
    "setCurrentEyeSamplesPerOmmatidium",
    "getCurrentEyeSamplesPerOmmatidium",
    "changeCurrentEyeSamplesPerOmmatidiumBy",
    "getCurrentEyeOmmatidialCount",
    "setOmmatidia",
    "getCurrentEyeDataPath",
    "setCurrentEyeShaderName",
    "isInsideHitGeometry",
    "getGeometryMaxBounds",
    "getGeometryMinBounds",
    "getWindowPointer",
]


class Float3(Structure):
    _fields_ = [("x", c_float), ("y", c_float), ("z", c_float)]

    def values(self):
        return np.array([self.x, self.y, self.z])


class Packet(Structure):
    _fields_ = [
        (name, c_float) for name in ["px", "py", "pz", "dx", "dy", "dz", "acceptance", "offset"]
    ]


def declare(lib):
    """Argument and result types, where they are not int."""
    types = {
        "setVerbosity": ([c_bool], None),
        "loadGlTFscene": ([c_char_p], None),
        "saveFrameAs": ([c_char_p], None),
        "renderFrame": ([], c_double),
        "getFrame": ([c_void_p], None),
        "getCameraCount": ([], c_size_t),
        "getCurrentCameraIndex": ([], c_size_t),
        "getCurrentCameraName": ([], c_char_p),
        "gotoCameraByName": ([c_char_p], c_bool),
        "setCameraPosition": ([c_float] * 3, None),
        "getCameraPosition": ([POINTER(c_float)] * 3, None),
        "setCameraLocalSpace": ([c_float] * 9, None),
        "rotateCameraAround": ([c_float] * 4, None),
        "rotateCameraLocallyAround": ([c_float] * 4, None),
        "translateCamera": ([c_float] * 3, None),
        "translateCameraLocally": ([c_float] * 3, None),
        "setCameraPose": ([c_float] * 6, None),
        "isCompoundEyeActive": ([], c_bool),
        "getCurrentEyeSamplesPerOmmatidium": ([], c_int),
        "getCurrentEyeOmmatidialCount": ([], c_size_t),
        "setOmmatidia": ([c_void_p, c_size_t], None),
        "getCurrentEyeDataPath": ([], c_char_p),
        "setCurrentEyeShaderName": ([c_char_p], None),
        "isInsideHitGeometry": ([c_float] * 3 + [c_char_p], c_bool),
        "getGeometryMaxBounds": ([c_char_p], Float3),
        "getGeometryMinBounds": ([c_char_p], Float3),
        "getWindowPointer": ([], c_void_p),
    }
    for name, (arguments, result) in types.items():
        getattr(lib, name).argtypes = arguments
        getattr(lib, name).restype = result
    return lib


@pytest.fixture
def fresh(tmp_path):
    """The library as a new process finds it: a copy has a state of its own."""
    copy = tmp_path / "libEyeRenderer3.so"
    shutil.copy(omma.compoundray_library(), copy)
    return declare(CDLL(str(copy)))


@pytest.fixture
def lib(fresh):
    """With the room loaded, quiet."""
    fresh.setVerbosity(False)
    fresh.loadGlTFscene(str(ROOM / "room.gltf").encode())
    return fresh


def set_size(lib, width, height):
    lib.setRenderSize(width, height)
    lib.getFramePointer.restype = ndpointer(dtype=c_ubyte, shape=(height, width, 4))


def frame(lib):
    assert lib.renderFrame() > 0
    return np.copy(lib.getFramePointer())


def go(lib, name):
    assert lib.gotoCameraByName(name.encode())


def position(lib):
    values = [c_float(math.nan) for _ in range(3)]
    lib.getCameraPosition(*[byref(value) for value in values])
    return [value.value for value in values]


def shader(lib, name):
    lib.setCurrentEyeShaderName(name.encode())


def ids(picture):
    r, g, b, a = (picture[..., k].astype(np.uint32) for k in range(4))
    return r << 24 | g << 16 | b << 8 | a


def set_ommatidia(lib, rows):
    packets = (Packet * len(rows))(*[Packet(*row) for row in rows])
    lib.setOmmatidia(packets, len(rows))


def read_ppm(path):
    magic, size, depth, pixels = path.read_bytes().split(b"\n", 3)
    assert (magic, depth) == (b"P6", b"255")
    width, height = map(int, size.split())
    return np.frombuffer(pixels, np.uint8).reshape(height, width, 3)


def test_the_path_is_that_of_a_library():
    assert omma.compoundray_library().endswith("libEyeRenderer3.so")


def test_only_and_all_functions_are_exported(fresh):
    for name in [*EVERY_FUNCTION, "_Z16getWindowPointerv"]:
        assert hasattr(fresh, name), name
    if shutil.which("nm") is None:
        pytest.skip("there is no nm to list the symbols with")
    listed = subprocess.run(
        ["nm", "-D", "--defined-only", omma.compoundray_library()],
        check=True, capture_output=True, text=True,
    ).stdout  # fmt: skip
    assert {line.split()[-1] for line in listed.splitlines()} == {
        *EVERY_FUNCTION,
        "_Z16getWindowPointerv",
    }


def test_nothing_happens_when_it_is_loaded(tmp_path):
    code = f"import ctypes; ctypes.CDLL({omma.compoundray_library()!r}); print('loaded')"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "loaded\n", "")


@pytest.mark.parametrize("name", EVERY_FUNCTION)
def test_no_function_crashes_in_a_fresh_process(name):
    """Called without arguments the registers hold what they hold: nulls are given instead."""
    code = f"""
import ctypes, sys
lib = ctypes.CDLL({omma.compoundray_library()!r})
zeros = [ctypes.c_void_p(0)] * 4 + [ctypes.c_float(0)] * 9
lib.{name}(*zeros)
lib.{name}(*zeros)
lib.renderFrame()
lib.stop()
lib.{name}(*zeros)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_before_a_scene(fresh, capfd):
    assert fresh.getCameraCount() == 0
    assert not fresh.isCompoundEyeActive()
    assert fresh.getCurrentEyeSamplesPerOmmatidium() == -1
    assert fresh.getCurrentEyeOmmatidialCount() == 0
    assert fresh.getCurrentEyeDataPath() == b""
    fresh.getFramePointer.restype = ndpointer(dtype=c_ubyte, shape=(400, 400, 4))
    assert not fresh.getFramePointer().any()
    fresh.renderFrame()
    assert "ERROR: there is no scene" in capfd.readouterr().err
    fresh.nextCamera()
    assert fresh.getCurrentCameraName() == b"Default Camera"
    assert fresh.getCameraCount() == 1
    assert position(fresh) == [0, 0, 0]


def test_bad_files_are_errors_and_change_nothing(lib, tmp_path, capfd):
    broken = tmp_path / "broken.gltf"
    broken.write_text("{")
    for path in (b"no-such.gltf", str(broken).encode(), b"", None):
        lib.loadGlTFscene(path)
        assert "ERROR: Failed to load GLTF scene" in capfd.readouterr().err
    assert lib.getCameraCount() == 6
    set_size(lib, 3, 3)
    go(lib, "front")
    assert (frame(lib)[1, 1] == [GREY, GREY, GREY, 255]).all()


def test_messages_as_theirs(fresh, tmp_path, capfd):
    fresh.loadGlTFscene(str(ROOM / "room.gltf").encode())
    err = capfd.readouterr().err
    assert 'WARNING: Unable to open "no-such.eye", attempting to open at relative address' in err
    assert "ERROR" in err
    assert 'Unable to open "' + str(ROOM / "no-such.eye") in err
    target = tmp_path / "frame.ppm"
    fresh.setRenderSize(20, 10)
    fresh.renderFrame()
    fresh.getFramePointer()
    fresh.saveFrameAs(str(target).encode())
    fresh.stop()
    out = capfd.readouterr().out.splitlines()
    assert out[0] == "[PyEye] Resizing rendering buffer to (20, 10)."
    assert out[1].startswith("[PyEye] Rendered frame in ")
    assert out[1].endswith("ms.")
    assert out[2] == "[PyEye] Retrieving frame pointer..."
    assert out[3] == f"[PyEye] Saved render as '{target}'"
    assert out[4] == "[PyEye] Cleaning eye renderer resources."


def test_verbosity_silences_them(fresh, capfd):
    fresh.setVerbosity(False)
    fresh.loadGlTFscene(str(ROOM / "room.gltf").encode())
    fresh.setRenderSize(20, 10)
    fresh.renderFrame()
    fresh.getFramePointer()
    fresh.isInsideHitGeometry(0, 0, 0, b"nothing")
    captured = capfd.readouterr()
    assert captured.out == ""
    assert 'WARNING: No hitbox with the given name "nothing"' in captured.err
    fresh.setVerbosity(True)
    fresh.renderFrame()
    assert capfd.readouterr().out.startswith("[PyEye]")


def test_cameras_in_the_order_of_nodes(lib):
    names = []
    for i in range(lib.getCameraCount()):
        lib.gotoCamera(i)
        assert lib.getCurrentCameraIndex() == i
        names.append(lib.getCurrentCameraName().decode())
    # Roots by index whatever the order the scene lists them in; the eye without a file is left out.
    assert names == ["nested", "front", "insect", "panorama", "map", "vector"]
    lib.nextCamera()
    assert lib.getCurrentCameraIndex() == 0
    lib.previousCamera()
    assert lib.getCurrentCameraIndex() == 5
    for index, expected in ((6, 0), (-1, 5), (-7, 5), (2**31 - 1, (2**31 - 1) % 6)):
        lib.gotoCamera(index)
        assert lib.getCurrentCameraIndex() == expected
    assert lib.gotoCameraByName(b"map")
    assert lib.getCurrentCameraIndex() == 4
    assert not lib.gotoCameraByName(b"node of map")  # names of cameras, not of nodes
    assert lib.getCurrentCameraIndex() == 0


def test_bottom_row_first_and_top_row_first(lib, tmp_path):
    go(lib, "front")
    set_size(lib, 30, 20)
    lib.rotateCameraLocallyAround(math.pi / 4, 1, 0, 0)  # up: the blue ceiling, the grey wall below
    picture = frame(lib)
    assert (picture[19, 15] == [*BLUE, 255]).all()
    assert (picture[0, 15] == [GREY] * 3 + [255]).all()
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
              (2, -1): (GREY,) * 3}  # fmt: skip
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
    assert middle == [CYAN, GREEN, (GREY,) * 3, RED]
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
            assert (tuple(frame(lib)[1, 1, :3]) == (GREY,) * 3) == seen, (name, distance)


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
    expected = [CYAN, (GREY,) * 3, RED, GREEN, BLUE, YELLOW]
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


def test_an_eye_is_sought_as_given_then_beside_the_scene(fresh, tmp_path, monkeypatch):
    folder = tmp_path / "scenes"
    folder.mkdir()
    for name in ("room.gltf", "six.eye"):
        shutil.copy(ROOM / name, folder)
    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.chdir(work)
    fresh.loadGlTFscene(b"../scenes/room.gltf")
    go(fresh, "insect")
    assert fresh.getCurrentEyeDataPath() == b"../scenes/six.eye"
    assert fresh.getCurrentEyeOmmatidialCount() == 6
    (work / "six.eye").write_text("0 0 0 0 0 1 0.1 0\n0 0 0 0 1 0 0.1 0\n")
    fresh.loadGlTFscene(b"../scenes/room.gltf")
    go(fresh, "insect")
    assert fresh.getCurrentEyeDataPath() == b"six.eye"
    assert fresh.getCurrentEyeOmmatidialCount() == 2
    monkeypatch.chdir(folder)
    fresh.loadGlTFscene(b"room.gltf")
    go(fresh, "insect")
    assert fresh.getCurrentEyeDataPath() == b"six.eye"


def test_ids_over_four_channels(lib):
    """More than 65,536 ommatidia, so that three of the four bytes are used."""
    go(lib, "insect")
    count = 70_000
    rows = np.zeros((count, 8), np.float32)
    rows[:, 5] = -1  # backwards, but for the last
    rows[-1, 5] = 1
    lib.setOmmatidia(rows.ctypes.data_as(c_void_p), count)
    assert lib.getCurrentEyeOmmatidialCount() == count
    shader(lib, "spherical_orientationwise_ids")
    set_size(lib, 4, 4)
    picture = frame(lib)
    assert list(picture[2, 2]) == [0, 1, 17, 111]  # 69,999 = 0x1116f
    assert ids(picture)[2, 2] == count - 1
    assert ids(picture)[2, 0] == 0


def test_spherical_projections_by_brute_force(lib):
    """All three kinds of map against every ommatidium compared with every pixel."""
    rng = np.random.default_rng(5)
    directions, positions = rng.normal(size=(2, 40, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    rows = np.hstack([positions, directions, np.full((40, 1), 0.01), np.zeros((40, 1))])
    go(lib, "insect")
    set_ommatidia(lib, rows)
    width, height = 50, 31
    set_size(lib, width, height)

    def pixel_direction(x, y):
        azimuth, elevation = (2 * x - 1) * np.pi, (2 * y - 1) * np.pi / 2
        return np.stack([np.sin(azimuth) * np.cos(elevation), np.sin(elevation) + 0 * azimuth,
                         np.cos(azimuth) * np.cos(elevation)], axis=-1)  # fmt: skip

    x, y = np.meshgrid(np.arange(width) / width, np.arange(height) / height)
    for name, towards in (("orientation", directions), ("position", positions)):
        shader(lib, f"spherical_{name}wise_ids")
        unit = towards / np.linalg.norm(towards, axis=1, keepdims=True)
        cosine = pixel_direction(x, y) @ unit.T
        two = np.sort(cosine, axis=-1)[..., -2:]
        sure = two[..., 1] - two[..., 0] > 1e-5  # float arithmetic may decide the others
        found = ids(frame(lib))
        assert (found == cosine.argmax(-1))[sure].all()
        assert sure.mean() > 0.95

    # The split one has no ids: the colours tell, each ommatidium's taken from single_dimension.
    shader(lib, "single_dimension")
    set_size(lib, 40, 1)
    colors = frame(lib)[0]
    shader(lib, "spherical_split_orientationwise")
    set_size(lib, width, height)
    found = frame(lib)
    right = x > 0.5
    cosine = pixel_direction(np.where(2 * x > 1, 2 * x - 1, 2 * x), y) @ directions.T
    side = np.where(right[..., None], positions[:, 0] > 0, positions[:, 0] < 0)
    side &= (x != 0.5)[..., None]
    side[..., 0] = True  # the first ommatidium belongs to both
    cosine = np.where(side, cosine, -2)
    two = np.sort(cosine, axis=-1)[..., -2:]
    sure = two[..., 1] - two[..., 0] > 1e-5
    assert (found == colors[cosine.argmax(-1)])[sure].all()


def test_an_eye_with_all_positions_in_its_centre(lib):
    """No position has a direction then; CompoundRay's comparison never leaves the first."""
    go(lib, "insect")
    set_ommatidia(lib, [(0, 0, 0, *axis, 0.1, 0) for axis in np.eye(3)])
    set_size(lib, 8, 8)
    for name in ("spherical_positionwise_ids", "spherical_positionwise"):
        shader(lib, name)
        picture = frame(lib)
        assert (picture == picture[0, 0]).all()
    assert tuple(picture[0, 0, :3]) == RED


def test_the_fast_projection_leaves_the_rest(lib):
    go(lib, "front")
    set_size(lib, 8, 2)
    background = frame(lib)
    go(lib, "vector")  # single_dimension_fast
    picture = frame(lib)
    assert (picture[1] == background[1]).all()
    assert (picture[0, 6:] == background[0, 6:]).all()
    assert [tuple(p[:3]) for p in picture[0, :6]] == [(GREY,) * 3, CYAN, RED, GREEN, BLUE, YELLOW]


def test_raw_samples_are_shares_of_the_mean(lib):
    """Undone, the samples' shares add up to what single_dimension shows, within 8 bits."""
    go(lib, "vector")
    samples = 50
    set_ommatidia(lib, [(0, 0, 0, 1, 0, 1, 1.2, 0), (0, 0, 0, 0, 1, 1, 0.9, 0)])
    lib.setCurrentEyeSamplesPerOmmatidium(samples)
    shader(lib, "raw_ommatidial_samples")
    set_size(lib, 2, samples)
    picture = frame(lib)
    share = int(255 * (1 / samples) ** (1 / 2.2))
    assert set(np.unique(picture[:, 0, 0])) <= {0, share, int(255 * (0.5 / samples) ** (1 / 2.2))}
    counts = [(picture[:, 0, 0] == share).sum()]
    for _ in range(20):
        counts.append((frame(lib)[:, 0, 0] == share).sum())
    assert len(set(counts)) > 5  # new samples each time
    # Half of what the first one sees is the red wall; of floor and ceiling only the floor has red.
    assert 0.3 < np.mean(counts) / samples < 0.6


def test_each_eye_has_its_own_samples(lib):
    go(lib, "insect")
    lib.setCurrentEyeSamplesPerOmmatidium(7)
    lib.changeCurrentEyeSamplesPerOmmatidiumBy(3)
    go(lib, "vector")
    assert lib.getCurrentEyeSamplesPerOmmatidium() == 1
    lib.changeCurrentEyeSamplesPerOmmatidiumBy(-3)
    assert lib.getCurrentEyeSamplesPerOmmatidium() == 1
    go(lib, "insect")
    assert lib.getCurrentEyeSamplesPerOmmatidium() == 10
    go(lib, "front")
    assert lib.getCurrentEyeSamplesPerOmmatidium() == -1
    lib.setCurrentEyeSamplesPerOmmatidium(3)  # nothing to set


def test_every_frame_has_new_samples(lib):
    go(lib, "vector")
    axis = np.array([1, 0, 1]) / math.sqrt(2)  # towards an edge of the room
    set_ommatidia(lib, [(0, 0, 0, *axis, 1.0, 0)] * 50)
    set_size(lib, 50, 1)
    frames = np.array([frame(lib)[0, :, 0] for _ in range(40)])
    assert all((a != b).any() for a, b in itertools.pairwise(frames))
    # Ommatidia are independent, too: no frame is all one colour (chance 2^-50).
    assert (frames.min(axis=1) != frames.max(axis=1)).all()


@pytest.mark.parametrize("kernel", ["compoundray", "gaussian"])
def test_the_kernel_of_the_environment(fresh, monkeypatch, kernel):
    """A wide ommatidium towards the red wall, against Omma's own renderer."""
    if kernel == "gaussian":
        monkeypatch.setenv("OMMA_COMPAT_KERNEL", "gaussian")
    else:
        monkeypatch.delenv("OMMA_COMPAT_KERNEL", raising=False)
    fresh.loadGlTFscene(str(ROOM / "room.gltf").encode())
    go(fresh, "vector")
    acceptance, samples = 1.5, 200_000
    set_ommatidia(fresh, [(0, 0, 0, 1, 0, 0, acceptance, 0)])
    fresh.setCurrentEyeSamplesPerOmmatidium(samples)
    set_size(fresh, 1, 1)
    shown = frame(fresh)[0, 0, :3] / 255
    scene = omma.load_scene(ROOM / "room.gltf")
    eye = omma.Eye(np.zeros((1, 3)), [[1.0, 0, 0]], acceptance)
    renderer = omma.Renderer(scene, eye, samples=1 << 16, kernel=kernel)
    expected = renderer.render(np.eye(4))[0, 0]
    # Truncation takes up to a level; 200,000 random samples err by 0.5 / sqrt(200000) = 0.0011, a
    # quarter of a level here. The kernels differ by 30 levels.
    np.testing.assert_allclose(shown, expected ** (1 / 2.2), atol=2 / 255)


def test_an_unknown_kernel_is_said(fresh, monkeypatch, capfd):
    monkeypatch.setenv("OMMA_COMPAT_KERNEL", "pillbox")
    fresh.loadGlTFscene(str(ROOM / "room.gltf").encode())
    assert "ERROR: OMMA_COMPAT_KERNEL" in capfd.readouterr().err
    assert fresh.getCameraCount() == 6


def test_the_scale_of_the_node_scales_the_eye(lib):
    """The node has scale 0.5: positions count half, and so does the focal offset."""
    go(lib, "insect")
    shader(lib, "single_dimension")
    set_size(lib, 1, 1)
    for at, color in ((17, RED), (19, None)):  # world x is 1 + at / 2; the wall is at 10
        set_ommatidia(lib, [(at, 0, 0, 1, 0, 0, 0, 0)])
        assert (tuple(frame(lib)[0, 0, :3]) == RED) == (color == RED)
    # Nearer than the offset nothing is seen: 2 * 0.5 beyond a wall 0.5 away from the position.
    set_ommatidia(lib, [(17, 0, 0, 1, 0, 0, 0, 2)])
    assert tuple(frame(lib)[0, 0, :3]) == RED
    set_ommatidia(lib, [(19, 0, 0, 1, 0, 0, 0, 4)])  # the ray starts in front of the wall, unseen
    assert tuple(frame(lib)[0, 0, :3]) != RED


def test_ommatidia_that_cannot_be(lib, capfd):
    go(lib, "insect")
    for row in ((0, 0, 0, 0, 0, 0, 0.1, 0), (math.nan, 0, 0, 0, 0, 1, 0.1, 0),
                (0, 0, 0, 0, 0, 1, 0.1, -1)):  # fmt: skip
        set_ommatidia(lib, [(0, 0, 0, 0, 0, 1, 0.1, 0), row])
        assert "ERROR: setOmmatidia, ommatidium 1" in capfd.readouterr().err
    assert lib.getCurrentEyeOmmatidialCount() == 6
    set_ommatidia(lib, [(0, 0, 0, 0, 0, 5, 100.0, 0)])  # an acceptance of all directions
    assert lib.getCurrentEyeOmmatidialCount() == 1
    go(lib, "front")
    set_ommatidia(lib, [(0, 0, 0, 0, 0, 1, 0.1, 0)])  # no eye, no effect
    assert lib.getCurrentEyeOmmatidialCount() == 0


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
    import base64
    import json

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
    assert tuple(frame(fresh)[1, 1, :3]) == (GREY,) * 3


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


def test_from_several_threads(lib):
    """ctypes lets other threads run meanwhile; calls take turns."""
    from concurrent.futures import ThreadPoolExecutor

    set_size(lib, 20, 20)
    go(lib, "front")

    def work(k):
        for _ in range(10):
            lib.setCurrentEyeShaderName(b"single_dimension")
            lib.renderFrame()
            (lib.nextCamera if k % 2 else lib.previousCamera)()
        return lib.getCameraCount()

    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(work, range(4))) == [6] * 4


def test_it_lives_beside_the_package_itself(lib, renderer):
    """Both hold an engine; neither meets the other's symbols."""
    responses = renderer.render(np.eye(4))
    go(lib, "insect")
    set_size(lib, 4, 4)
    frame(lib)
    assert (renderer.render(np.eye(4)) == responses).all()


@pytest.mark.parametrize(
    "name",
    ["natural-standin-sky.gltf", "ofstad-arena.gltf", "test-scene.gltf", "test-scene-sky.gltf",
     "env_2.gltf", "environment.glb"],
)  # fmt: skip
def test_every_camera_of_the_shared_scenes(fresh, name):
    path = SCENES / name
    if not path.exists():
        pytest.skip(f"needs {path}")
    fresh.setVerbosity(False)
    fresh.loadGlTFscene(os.fsencode(path))
    scene = omma.load_scene(path)
    assert fresh.getCameraCount() == len(scene.cameras)  # none is dropped
    set_size(fresh, 60, 40)
    for i in range(fresh.getCameraCount()):
        fresh.gotoCamera(i)
        if name == "environment.glb":  # its cameras sit in a black sphere
            fresh.setCameraPosition(0, 0, 4)
        if not fresh.isCompoundEyeActive():
            picture = frame(fresh)
            assert (picture[..., 3] == 255).all()
            assert len(np.unique(picture.reshape(-1, 4), axis=0)) > 1, "nothing is seen"
            continue
        assert fresh.getCurrentEyeOmmatidialCount() > 1
        assert Path(os.fsdecode(fresh.getCurrentEyeDataPath())).exists()
        for projection in (None, "spherical_orientationwise", "single_dimension"):
            if projection is not None:
                shader(fresh, projection)
            picture = frame(fresh)
            assert len(np.unique(picture.reshape(-1, 4), axis=0)) > 1, "nothing is seen"


def test_a_pointer_to_the_window():
    lib = declare(CDLL(omma.compoundray_library()))
    assert lib.getWindowPointer() is None
    mangled = ctypes.cast(lib._Z16getWindowPointerv, c_void_p).value
    assert mangled is not None
