"""Cameras of captured worlds: files of every kind give the poses that they were written from, and
what is wrong with them is said."""

import json
import random
import struct
import warnings

import numpy as np
import pytest
from capture_files import (
    LENSES,
    transforms,
    write_colmap_binary,
    write_colmap_text,
    write_splat_cameras,
    write_transforms,
)
from numpy.testing import assert_allclose

import omma
from omma.scene import CaptureCameras, load_capture_cameras

RNG = np.random.default_rng(3)
TARGET = np.array([0.3, 0.2, -0.4])
PLACES = RNG.uniform(-3, 3, (7, 3)) + (0, 4, 0)
# In Omma's frame.
POSES = np.array([omma.look_at(place, TARGET) for place in PLACES])
# +Z up as +Y up.
Y_FROM_Z = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
# y down and z ahead as +Y up.
Y_DOWN = np.diag([1.0, -1.0, -1.0, 1.0])
HALF = np.degrees(np.arctan([320 / 400, 240 / 420]))
WRITERS = {
    "text": lambda folder, poses: write_colmap_text(folder / "model", poses),
    "binary": lambda folder, poses: write_colmap_binary(folder / "model", poses),
    "transforms": lambda folder, poses: write_transforms(folder / "transforms.json", poses),
    "splats": lambda folder, poses: write_splat_cameras(folder / "cameras.json", poses),
}


@pytest.mark.parametrize("kind", WRITERS)
@pytest.mark.parametrize("up", ["y", "z", "-y"])
def test_each_file_gives_the_poses_it_was_written_from(tmp_path, kind, up):
    file_from_world = {"y": np.eye(4), "z": Y_FROM_Z.T, "-y": Y_DOWN}[up]
    path = WRITERS[kind](tmp_path, file_from_world @ POSES)
    cameras = load_capture_cameras(path, up=up)
    assert_allclose(cameras.positions_m, PLACES, atol=1e-12)
    assert_allclose(cameras.world_from_camera, POSES[:, :3, :3], atol=1e-12)
    assert_allclose(cameras.half_angles_deg, np.tile(HALF, (7, 1)), atol=1e-12)
    assert len(cameras.names) == len(cameras) == 7
    assert cameras.path == str(path)
    # By hand: along its -Z each camera has the target, right of the middle is +X, above is +Y.
    for k in range(7):
        seen = cameras.world_from_camera[k].T @ (TARGET - cameras.positions_m[k])
        assert_allclose(seen, [0, 0, -np.linalg.norm(TARGET - PLACES[k])], atol=1e-12)
    assert (cameras.world_from_camera[:, 1, 1] > 0).all()  # nobody stands on his head


def test_text_of_colmap_as_it_is_written(tmp_path):
    """With the number of images in its head, and without the line of points of the last one."""
    path = write_colmap_text(tmp_path / "model", POSES[:2])
    text = (path / "images.txt").read_text().rstrip("\n")
    (path / "images.txt").write_text(f"# Number of images: 2, mean observations: 0.5\n{text}")
    assert load_capture_cameras(path).names == ("shot 0.jpg", "shot 1.jpg")


def test_what_is_up_by_default(tmp_path):
    """-y in COLMAP's frame and that of splats, z in Nerfstudio's."""
    for kind, file_from_world in (
        ("text", Y_DOWN),
        ("splats", Y_DOWN),
        ("transforms", Y_FROM_Z.T),
    ):
        cameras = load_capture_cameras(WRITERS[kind](tmp_path, file_from_world @ POSES))
        assert_allclose(cameras.positions_m, PLACES, atol=1e-12)


def test_a_camera_at_a_known_place_that_looks_east(tmp_path):
    """Numbers by hand: 2 m up, looking along +X of the world, which in the camera is +z forward."""
    folder = tmp_path / "sparse" / "0"
    folder.mkdir(parents=True)
    (folder / "cameras.txt").write_text("1 SIMPLE_PINHOLE 200 100 100 100 50\n")
    # Rows of camera_from_world: its right is +Z of the world, its down -Y, its forward +X. As a
    # quaternion (0.5, 0.5, 0.5, -0.5) up to the sign; t = -R (0, 2, 0) = (0, 2, 0).
    turn = np.array([[0, 0, 1], [0, -1, 0], [1, 0, 0.0]])
    assert np.linalg.det(turn) == 1
    half = np.sqrt(0.5)  # w = 0: a half turn about (1, 0, 1) / sqrt(2)
    (folder / "images.txt").write_text(f"1 0 {half} 0 {half} 0 2 0 1 a.jpg\n\n")
    cameras = load_capture_cameras(tmp_path, up="y")
    assert_allclose(cameras.positions_m, [[0, 2, 0]], atol=1e-15)
    # Columns: right, up, back, in the world.
    assert_allclose(cameras.world_from_camera[0], [[0, 0, -1], [0, 1, 0], [1, 0, 0]], atol=1e-15)
    assert_allclose(cameras.half_angles_deg, [[45, np.degrees(np.arctan(0.5))]])


def test_quaternions_of_colmap_of_another_length_are_told_of(tmp_path):
    whole = load_capture_cameras(WRITERS["text"](tmp_path, POSES))
    folder = changed_file("images.txt", lambda data: line_of(data, 3, doubled))(tmp_path)
    with pytest.warns(UserWarning, match=r"images\.txt, line 4: expected .* length 1, found .* 2"):
        found = load_capture_cameras(folder)
    assert_allclose(found.world_from_camera, whole.world_from_camera, atol=1e-12)


def doubled(words):
    """A line of images.txt whose quaternion is twice as long."""
    return " ".join([words[0], *(str(2 * float(one)) for one in words[1:5]), *words[5:]])


def test_units_and_matrices(tmp_path):
    path = WRITERS["text"](tmp_path, POSES)
    feet = load_capture_cameras(path, unit=0.3048, up="y")
    assert_allclose(feet.positions_m, PLACES * 0.3048, atol=1e-12)
    world_from_file = omma.poses_from_angles((5, -2, 1), (30, 20, 10))[0]
    world_from_file[:3, :3] *= 2.5
    moved = load_capture_cameras(path, world_from_file=world_from_file)
    assert_allclose(moved.positions_m, PLACES @ world_from_file[:3, :3].T + (5, -2, 1), atol=1e-12)
    assert_allclose(
        moved.world_from_camera, world_from_file[:3, :3] / 2.5 @ POSES[:, :3, :3], atol=1e-12
    )


def test_the_transform_that_nerfstudio_applied_can_be_undone(tmp_path):
    applied = np.array([[1.0, 0, 0, 0.5], [0, 0, 1, -2], [0, -1, 0, 3]])
    turned = np.vstack([applied, [0, 0, 0, 1]]) @ POSES
    turned[:, :3, 3] *= 4
    path = write_transforms(
        tmp_path / "transforms.json", turned, applied_transform=applied.tolist(), applied_scale=4.0
    )
    assert_allclose(load_capture_cameras(path, up="y").positions_m, turned[:, :3, 3], atol=1e-12)
    undone = load_capture_cameras(path, undo_applied=True, up="y")
    assert_allclose(undone.positions_m, PLACES, atol=1e-12)
    assert_allclose(undone.world_from_camera, POSES[:, :3, :3], atol=1e-12)


@pytest.mark.parametrize("write", [write_colmap_text, write_colmap_binary])
@pytest.mark.parametrize("lens", LENSES)
def test_fields_of_lenses(tmp_path, write, lens):
    half = {
        "SIMPLE_PINHOLE": np.degrees(np.arctan([320 / 400, 240 / 400])),
        "SIMPLE_RADIAL": np.degrees(np.arctan([320 / 400, 240 / 400])),
        "OPENCV_FISHEYE": np.degrees([320 / 200, 240 / 210]),
        "SIMPLE_FISHEYE": np.degrees([320 / 200, 240 / 200]),
        "FOV": [np.nan, np.nan],
        "EQUIRECTANGULAR": [180, 90],
    }.get(lens, HALF)
    cameras = load_capture_cameras(write(tmp_path / "a", POSES, lens))
    assert_allclose(cameras.half_angles_deg, np.tile(half, (7, 1)))


def test_fields_in_json(tmp_path):
    """A frame's own numbers go before those that all share; angles of the first NeRF; nothing."""
    document = transforms(POSES)
    document["frames"][1] |= {"fl_x": 800.0, "w": 1280}
    document["frames"][2] |= {"camera_model": "OPENCV_FISHEYE"}
    document["frames"][3] |= {"camera_model": "EQUIRECTANGULAR"}
    document["frames"][4] |= {"cx": 220.0}
    document["frames"][5] |= {"camera_model": "ORTHOPHOTO"}
    path = tmp_path / "transforms.json"
    path.write_text(json.dumps(document))
    found = load_capture_cameras(path).half_angles_deg
    assert_allclose(found[0], HALF)
    assert_allclose(found[1], np.degrees(np.arctan([320 / 800, 240 / 420])))  # cx is 320 still
    assert_allclose(found[2], np.degrees([320 / 400, 240 / 420]))
    assert_allclose(found[3], [180, 90])
    assert_allclose(found[4], np.degrees(np.arctan([220 / 400, 240 / 420])))
    assert np.isnan(found[5]).all()
    for shared, half in (
        ({"camera_angle_x": 0.8}, [np.degrees(0.4), np.nan]),
        (
            {"camera_angle_x": 0.8, "w": 200, "h": 100},
            np.degrees([0.4, np.arctan(np.tan(0.4) / 2)]),
        ),
        ({}, [np.nan, np.nan]),
    ):
        path.write_text(json.dumps({**shared, "frames": document["frames"][:1]}))
        assert_allclose(load_capture_cameras(path).half_angles_deg[0], half)


def changed_json(change):
    def write(folder):
        document = transforms(POSES)
        change(document)
        path = folder / "transforms.json"
        path.write_text(json.dumps(document))
        return path

    return write


def changed_file(name, change):
    def write(folder):
        write_colmap = write_colmap_binary if name.endswith(".bin") else write_colmap_text
        path = write_colmap(folder / "model", POSES)
        data = (path / name).read_bytes()
        (path / name).write_bytes(change(data))
        return path

    return write


def text_file(name, text):
    def write(folder):
        (folder / name).write_text(text)
        return folder / name

    return write


def without_points(data):
    """A text file whose lines of points are left out, with names of several words or not."""
    lines = data.decode().split("\n")
    return "\n".join([lines[0], *lines[1::2], ""]).encode()


def promising(name, what, count):
    """A text file that says in its first line how many records it has."""
    return changed_file(name, lambda data: f"# Number of {what}: {count}, of all\n".encode() + data)


def line_of(data, number, words):
    """A text file with another line."""
    lines = data.decode().split("\n")
    lines[number] = words(lines[number].split(" "))
    return "\n".join(lines).encode()


BAD = {
    "nothing": (lambda folder: folder / "none.json", r"none\.json"),
    "no COLMAP": (lambda folder: folder, "expected a folder of COLMAP, with cameras.bin and"),
    "no JSON": (text_file("a.json", "frames:"), "a.json: expected JSON, found none"),
    "JSON of no text": (
        lambda folder: ((folder / "a.json").write_bytes(b"\xff\xd8"), folder / "a.json")[1],
        "a.json: expected JSON, found none: it is no text",
    ),
    "another file": (
        text_file("a.ply", "ply\n"),
        r"a\.ply: expected a folder of COLMAP, transforms\.json .* or cameras\.json of 3D Gaussian",
    ),
    "deep JSON": (text_file("a.json", "[" * 100_000), "a.json: expected JSON, found none"),
    "long number": (text_file("a.json", "1" * 10_000), "a.json: expected JSON, found none"),
    "another JSON": (
        text_file("a.json", '{"a": 1}'),
        r"expected a folder of COLMAP, transforms.json of Nerfstudio",
    ),
    "a list of texts": (text_file("a.json", '["a"]'), "expected .*transforms.json of Nerfstudio"),
    "no cameras": (text_file("a.json", "[]"), "expected photographs with poses, found none"),
    "no frames": (
        changed_json(lambda d: d.update(frames=[])),
        "expected photographs with poses, found none",
    ),
    "frames no list": (changed_json(lambda d: d.update(frames=3)), "frames: expected a list"),
    "frame no object": (
        changed_json(lambda d: d["frames"].insert(2, [1, 2])),
        r"frames\[2\]: expected an object, found a list of 2 items",
    ),
    "no matrix": (
        changed_json(lambda d: d["frames"][1].pop("transform_matrix")),
        r"frames\[1\]: expected transform_matrix, found none",
    ),
    "two rows": (
        changed_json(lambda d: d["frames"][1].update(transform_matrix=[[1, 0, 0, 0]] * 2)),
        r"frames\[1\], transform_matrix: expected 4 items, found 2",
    ),
    "short row": (
        changed_json(lambda d: d["frames"][1]["transform_matrix"][2].pop()),
        r"frames\[1\], transform_matrix\[2\]: expected 4 items, found 3",
    ),
    "NaN": (
        changed_json(lambda d: d["frames"][1]["transform_matrix"][2].__setitem__(3, np.nan)),
        r"transform_matrix\[2\]\[3\]: expected a finite number, found nan",
    ),
    "a text": (
        changed_json(lambda d: d["frames"][1]["transform_matrix"][2].__setitem__(3, "x")),
        r"transform_matrix\[2\]\[3\]: expected a finite number, found 'x'",
    ),
    "too long a whole number": (
        changed_json(lambda d: d["frames"][1]["transform_matrix"][2].__setitem__(3, 10**400)),
        r"transform_matrix\[2\]\[3\]: expected a finite number, found 10",
    ),
    "far": (
        changed_json(lambda d: d["frames"][1]["transform_matrix"][2].__setitem__(3, 1e20)),
        r"transform_matrix: expected coordinates within 1e\+18, found",
    ),
    "no rotation": (
        changed_json(lambda d: d["frames"][1]["transform_matrix"][2].__setitem__(2, 2.0)),
        r"frames\[1\], transform_matrix: expected a rotation, found columns of the lengths 1, ",
    ),
    "mirror": (
        changed_json(
            lambda d: d["frames"][1].update(transform_matrix=np.diag([1, 1, -1, 1.0]).tolist())
        ),
        "expected a rotation, found one that mirrors",
    ),
    "last row": (
        changed_json(
            lambda d: d["frames"][1].update(transform_matrix=np.diag([1, 1, 1, 0.01]).tolist())
        ),
        r"expected a last row of 0, 0, 0, 1, found 0, 0, 0, 0\.01",
    ),
    "path no text": (
        changed_json(lambda d: d["frames"][0].update(file_path=7)),
        r"frames\[0\], file_path: expected a text, found 7",
    ),
    "focal length": (
        changed_json(lambda d: d.update(fl_x=0)),
        r"frames\[0\]: expected a size and focal lengths above 0",
    ),
    "angle": (
        changed_json(lambda d: (d.pop("fl_x"), d.update(camera_angle_x=3.2))),
        r"camera_angle_x: expected radians above 0 and below pi, found 3\.2",
    ),
    "model no text": (
        changed_json(lambda d: d.update(camera_model=["OPENCV"])),
        "camera_model: expected a text, found a list of 1 items",
    ),
    "text: quaternion": (
        changed_file(
            "images.txt",
            lambda data: line_of(data, 3, lambda w: " ".join([w[0], *"0000", *w[5:]])),
        ),
        r"images\.txt, line 4: expected a quaternion, found one of length 0",
    ),
    "text: NaN": (
        changed_file(
            "images.txt", lambda data: line_of(data, 1, lambda w: " ".join([w[0], "nan", *w[2:]]))
        ),
        r"images\.txt, line 2: expected finite numbers, found 'nan ",
    ),
    "text: cut off": (
        changed_file("images.txt", lambda data: data[: data.index(b"shot 4") - 4]),
        r"images\.txt, line 10: expected IMAGE_ID, QW",
    ),
    "text: no lines of points": (
        changed_file("images.txt", without_points),
        r"images\.txt, line 3: expected the points of the photograph above, .* found '2 ",
    ),
    "text: names of three words": (
        changed_file(
            "images.txt", lambda data: without_points(data.replace(b"shot ", b"shot of "))
        ),
        r"images\.txt, line 3: expected the points of the photograph above, .* found '2 ",
    ),
    "text: cut off in points": (
        changed_file("images.txt", lambda data: data[: data.rindex(b" 12 3")]),
        r"images\.txt, line 15: expected the points of the photograph above",
    ),
    "text: fewer images": (
        promising("images.txt", "images", 8),
        r"images\.txt: expected 8 images, as line 1 says, found 7: the file is cut off",
    ),
    "text: more images": (
        promising("images.txt", "images", 6),
        r"images\.txt: expected 6 images, as line 1 says, found 7",
    ),
    "text: fewer cameras": (
        changed_file("cameras.txt", lambda data: data.replace(b"cameras: 1", b"cameras: 2")),
        r"cameras\.txt: expected 2 cameras, as line 2 says, found 1: the file is cut off",
    ),
    "text: camera": (
        lambda folder: write_colmap_text(folder / "a", POSES, camera_of=8),
        r"images\.txt, line 2: expected a camera of .*cameras\.txt, found 8, which is not there",
    ),
    "text: model": (
        changed_file("cameras.txt", lambda data: data.replace(b"PINHOLE", b"KEYHOLE")),
        r"cameras\.txt, line 3: expected CAMERA_ID, MODEL, .* found '7 KEYHOLE",
    ),
    "text: parameters": (
        changed_file("cameras.txt", lambda data: data.replace(b"PINHOLE", b"OPENCV")),
        r"cameras\.txt, line 3: expected 8 parameters of OPENCV, found 4",
    ),
    "text: empty": (
        changed_file("images.txt", lambda data: b"# none\n"),
        "expected photographs with poses, found none",
    ),
    "text: no text": (changed_file("images.txt", lambda data: b"\xff\xfd"), "expected UTF-8 text"),
    "binary: count": (
        changed_file("images.bin", lambda data: struct.pack("<Q", 10**12) + data[8:]),
        r"images\.bin, byte 0: expected at most \d+ images in the .* found 1,000,000,000,000",
    ),
    "binary: points": (
        changed_file(
            "images.bin",
            lambda data: data[: data.index(b"shot 1") + 11] + b"\xff" * 8 + bytes(600),
        ),
        "expected at most .* points in the .* bytes that follow, found",
    ),
    "binary: cut off": (
        changed_file("images.bin", lambda data: data[:-3]),
        r"images\.bin, byte \d+: expected ",
    ),
    "binary: longer": (
        changed_file("images.bin", lambda data: data + b"abc"),
        r"images\.bin, byte \d+: expected the end of the file, found 3 more bytes",
    ),
    "binary: cut cameras": (
        changed_file("cameras.bin", lambda data: data[:-8]),
        r"cameras\.bin, byte 32: expected a camera's parameters, found the end of the file",
    ),
    "binary: model": (
        changed_file("cameras.bin", lambda data: data[:12] + struct.pack("<i", 99) + data[16:]),
        r"cameras\.bin, byte 8: expected a camera's model, 0 to 17, found 99",
    ),
    "binary: camera": (
        lambda folder: write_colmap_binary(folder / "a", POSES, camera_of=8),
        r"images\.bin, byte 8: expected a camera of .*cameras\.bin, found 8",
    ),
    "binary: empty": (
        changed_file("images.bin", lambda data: b"\0" * 8),
        "expected photographs with poses, found none",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_wrong_is_said(tmp_path, case):
    write, said = BAD[case]
    with pytest.raises(omma.Error, match=said):
        load_capture_cameras(write(tmp_path))


def test_wrong_arguments(tmp_path):
    colmap = WRITERS["text"](tmp_path, POSES)
    nerf = WRITERS["transforms"](tmp_path, POSES)
    stretched = np.diag([1.0, 2, 1, 1])
    for path, arguments, said in (
        (colmap, {"undo_applied": True}, "undo_applied: is for Nerfstudio's transforms.json"),
        (nerf, {"undo_applied": True}, "applied_transform: expected a matrix to undo, found none"),
        (colmap, {"unit": "ell"}, "unit: expected mm, um, m or a number of metres, found 'ell'"),
        (colmap, {"up": "x"}, "up: expected one of y, z, -y, found 'x'"),
        (colmap, {"up": "y", "world_from_file": np.eye(4)}, "not together with unit and up"),
        (colmap, {"world_from_file": np.eye(3)}, r"expected shape \(4, 4\), found \(3, 3\)"),
        (colmap, {"world_from_file": stretched}, "expected a rotation times a scale above 0"),
        (colmap, {"world_from_file": -np.eye(4)}, "expected a rotation times a scale above 0"),
        (colmap, {"world_from_file": np.full((4, 4), np.nan)}, "expected a rotation times"),
    ):
        with pytest.raises(omma.Error, match=said):
            load_capture_cameras(path, **arguments)


def test_values_are_checked():
    for arguments, said in (
        ((np.empty((0, 3)), np.empty((0, 3, 3))), "expected a camera or more, found none"),
        (([[0, 0, np.nan]], [np.eye(3)]), r"positions_m\[0\]: expected coordinates within"),
        (([[0, 0, 0]], [np.zeros((3, 3))]), r"world_from_camera\[0\]: expected a rotation"),
        (([[0, 0, 0]], np.eye(3)), r"world_from_camera: expected shape \(1, 3, 3\)"),
        (([[0, 0, 0]], [np.eye(3)], [[-1, 4]]), "half_angles_deg: expected 0 to 180, or NaN"),
    ):
        with pytest.raises(omma.Error, match=said):
            CaptureCameras(*arguments)
    with pytest.raises(omma.Error, match="names: expected 1, one of each camera, or none, found 2"):
        CaptureCameras([[0, 0, 0]], [np.eye(3)], names=("a", "b"))
    with pytest.raises(TypeError, match="names: expected a tuple of texts"):
        CaptureCameras([[0, 0, 0]], [np.eye(3)], names=["a"])
    cameras = CaptureCameras([[0, 0, 0], [1, 2, -3]], [np.eye(3)] * 2)
    assert_allclose(cameras.bounds, [[0, 0, -3], [1, 2, 0]])
    assert np.isnan(cameras.half_angles_deg).all()
    with pytest.raises(ValueError, match="read-only"):
        cameras.positions_m[0] = 1


@pytest.mark.parametrize("kind", WRITERS)
def test_changed_bytes_end_in_an_error_or_in_cameras(tmp_path, kind):
    """Whatever is in the files: nothing from inside, no warnings but those of a quaternion's
    length, no memory beyond them."""
    path = WRITERS[kind](tmp_path, POSES)
    files = [path] if path.is_file() else [*path.iterdir()]
    drawn = random.Random(5)
    ends = {"an error": 0, "cameras": 0}
    for _ in range(400):
        file = drawn.choice(files)
        good = file.read_bytes()
        data = bytearray(good)
        for _ in range(drawn.choice((1, 1, 2, 8))):
            data[drawn.randrange(len(data))] = drawn.choice(
                (drawn.randrange(256), *b'0919-+.eE[]{}," \n', 0, 255)
            )
        if drawn.random() < 0.2:
            del data[drawn.randrange(len(data)) :]
        file.write_bytes(data)
        said = ""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                warnings.simplefilter("ignore", UserWarning)
                assert len(load_capture_cameras(path)) <= len(POSES) + 4
        except omma.Error as error:
            said = str(error)
        assert not said or str(path) in said
        assert "\n" not in said
        ends["an error" if said else "cameras"] += 1
        file.write_bytes(good)
    assert min(ends.values()) > 20, ends
