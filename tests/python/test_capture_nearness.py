"""How near cameras of a captured world were: against a loop over all cameras, closed forms, and
beside responses as ground truth."""

import numpy as np
import pytest
from capture_files import write_colmap_text, write_transforms
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

import omma
from omma import scene as solids
from omma.picture import plot_capture_cameras
from omma.picture.capture_plots import hull_outline
from omma.scene import CaptureCameras, camera_nearness, load_capture_cameras

AHEAD = omma.look_at((0, 1, 0), (0, 1, -1))


def random_cameras(count, half_deg, seed=0):
    rng = np.random.default_rng(seed)
    turns = Rotation.random(count, random_state=seed).as_matrix()
    return CaptureCameras(rng.normal(0, 2, (count, 3)), turns, half_deg)


def has_in_field(camera_from_world, half_deg, at):
    """Whether a point or a direction, in a camera's frame, lies in its field."""
    x, y, z = camera_from_world @ at
    width, height = np.nan_to_num(half_deg, nan=89.99999999)
    if max(width, height) < 90:
        return z < 0 and abs(x) <= -z * np.tan(np.radians(width)) and (
            abs(y) <= -z * np.tan(np.radians(height))
        )  # fmt: skip
    azimuth = np.degrees(np.arctan2(x, -z))
    elevation = np.degrees(np.arctan2(y, np.hypot(x, z)))
    return abs(azimuth) <= width and abs(elevation) <= height


def slow_nearness(cameras, eye, poses, distance_m):
    """One ommatidium, one camera after the other."""
    to_head = np.empty(len(poses))
    angles = np.full((len(poses), len(eye)), np.nan)
    for p, pose in enumerate(poses):
        to_head[p] = min(np.linalg.norm(one - pose[:3, 3]) for one in cameras.positions_m)
        for i in range(len(eye)):
            axis = eye.axis[i].astype(float)
            start = pose[:3, :3] @ (eye.position_m[i] - axis * eye.focal_offset_m[i]) + pose[:3, 3]
            towards = pose[:3, :3] @ axis
            towards /= np.linalg.norm(towards)
            found = []
            for at, turn, half in zip(
                cameras.positions_m, cameras.world_from_camera, cameras.half_angles_deg
            ):
                if np.isinf(distance_m[p, i]):
                    if has_in_field(turn.T, half, towards):
                        found.append(0.0)
                    continue
                point = start + distance_m[p, i] * towards
                if has_in_field(turn.T, half, point - at):
                    one, other = start - point, at - point
                    cosine = one @ other / np.linalg.norm(one) / np.linalg.norm(other)
                    found.append(np.degrees(np.arccos(np.clip(cosine, -1, 1))))
            angles[p, i] = min(found, default=np.nan)
    return to_head, angles


HALVES = {
    "narrow": np.full((40, 2), (33.0, 25.0)),
    "narrow and few": np.full((2, 2), (12.0, 40.0)),
    "fisheye": np.full((40, 2), (100.0, 95.0)),
    "all round": np.full((40, 2), (180.0, 90.0)),
    "not known": np.full((40, 2), np.nan),
    "of all kinds": np.array([(33, 25), (100, 80), (180, 90), (np.nan, np.nan)] * 10),
}


@pytest.mark.parametrize("kind", HALVES)
def test_a_loop_finds_the_same(kind, monkeypatch):
    rng = np.random.default_rng(7)
    cameras = random_cameras(len(HALVES[kind]), HALVES[kind], seed=3)
    eye = omma.eye.generate_eye(60, radius_m=0.01)
    eye = eye.replace(focal_offset_m=np.full(60, 0.004, np.float32))
    poses = omma.poses_from_angles(rng.normal(0, 1, (3, 3)), rng.uniform(-60, 60, (3, 3)))
    poses[2, :3, :3] *= 3  # a giant's head
    distance_m = rng.uniform(0.1, 6, (3, 60))
    distance_m[rng.random((3, 60)) < 0.2] = np.inf
    slow_distance, slow_angle = slow_nearness(cameras, eye, poses, distance_m)
    for cameras_at_once in (2048, 7):
        monkeypatch.setattr(camera_nearness, "_CAMERAS", cameras_at_once)
        monkeypatch.setattr(camera_nearness, "_PAIRS", 7 * cameras_at_once)
        shares = []
        distance, angle = cameras.nearness(
            eye, poses, distance_m=distance_m, progress=shares.append
        )
        assert angle.dtype == np.float32
        assert_allclose(distance, slow_distance, rtol=1e-12)
        assert_allclose(angle, slow_angle, rtol=1e-6, atol=1e-4)  # the loop's arccos near 0
        assert shares == sorted(shares)
        assert shares[-1] == 1
    if kind == "narrow and few":
        assert 0.5 < np.isnan(angle).mean() < 1


def test_a_camera_where_the_eye_is():
    """0 m and 0 degrees for what it had in its field, and nothing for what it had not."""
    camera = CaptureCameras(AHEAD[None, :3, 3], AHEAD[None, :3, :3], [[50, 40]])
    eye = omma.eye.generate_eye(2000)
    eye = eye.replace(position_m=np.zeros((2000, 3)))
    x, y, z = eye.axis.T.astype(float)
    with np.errstate(divide="ignore"):
        seen = (z < 0) & (abs(x / z) < np.tan(np.radians(50)))
        seen &= abs(y / z) < np.tan(np.radians(40))
    for distance_m in (None, np.full((1, 2000), 0.7), np.full((1, 2000), 1e4)):
        distance, angle = camera.nearness(eye, AHEAD, distance_m=distance_m)
        assert distance == 0
        assert (np.isnan(angle[0]) == ~seen).all()
        assert np.nanmax(angle) < 1e-6


def test_angles_by_hand():
    """An eye at the origin sees a point 2 m ahead; cameras look at it from the side, from behind
    and past it."""
    eye = omma.Eye([[0, 0, 0]], [[0, 0, -1]], 0.1)
    point = np.array([0, 0, -2.0])

    def angle_from(*places, half=(30, 30), targets=None):
        targets = [point] * len(places) if targets is None else targets
        looks = np.array([omma.look_at(a, b) for a, b in zip(places, targets)])
        cameras = CaptureCameras(places, looks[:, :3, :3], [half] * len(places))
        distance, angle = cameras.nearness(eye, np.eye(4), distance_m=[[2.0]])
        return distance.item(), angle.item()

    assert angle_from((2, 0, -2)) == pytest.approx((np.sqrt(8), 90))
    assert angle_from((0, 3, -2 + 3)) == pytest.approx((np.sqrt(10), 45))
    assert angle_from((0, 0, -5)) == pytest.approx((5, 180))
    assert angle_from((2, 0, -2), (0, 3, 1), (0, 0, -5)) == pytest.approx((np.sqrt(8), 45))
    # Nearest in place is not nearest in angle: the one above looks away.
    away = angle_from((0, 0.1, 0), (2, 0, -2), targets=[(0, 9, 0.1), point])
    assert away == pytest.approx((0.1, 90))
    assert np.isnan(angle_from((0, 0.1, 0), targets=[(0, 9, 0.1)])[1])
    # 44 and 46 degrees off the axis of a camera with 45.
    for off_deg, angle in ((44, 90), (46, np.nan)):
        turned = (2 - np.cos(np.radians(off_deg)), 0, -2 + np.sin(np.radians(off_deg)))
        found = angle_from((2, 0, -2), half=(45, 10), targets=[turned])
        assert found[1] == pytest.approx(angle, nan_ok=True)


def test_far_from_zero():
    """As in coordinates of a survey: only differences count."""
    cameras = random_cameras(30, np.full((30, 2), 40.0))
    eye = omma.eye.generate_eye(200)
    poses = omma.poses_from_angles([(0.2, 0.1, 0.3)], [(10, 20, 30)])
    distance_m = np.full((1, 200), 2.0)
    near = cameras.nearness(eye, poses, distance_m=distance_m)
    far_m = np.array([500_000, 300, -5_400_000.0])
    moved = CaptureCameras(
        cameras.positions_m + far_m, cameras.world_from_camera, cameras.half_angles_deg
    )
    poses[:, :3, 3] += far_m
    far = moved.nearness(eye, poses, distance_m=distance_m)
    assert_allclose(far[0], near[0], atol=1e-8)
    assert_allclose(far[1], near[1], atol=1e-6)


@pytest.fixture(scope="module")
def photographed():
    """A ball on the ground, cameras around it, and an eye between."""
    scene = solids.merge_scenes(
        [
            solids.plane((60, 60), (0.4, 0.3, 0.1)),
            solids.sphere(0.5, (1, 0, 0), center_m=(0, 0.5, -2), name="ball"),
        ]
    )
    turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    places = np.stack([3 * np.sin(turn), np.full(24, 1.5), -2 + 3 * np.cos(turn)], axis=1)
    poses = np.array([omma.look_at(place, (0, 0.5, -2)) for place in places])
    return scene, poses


def test_beside_responses(photographed, tmp_path):
    scene, shots = photographed
    cameras = load_capture_cameras(write_colmap_text(tmp_path / "sparse" / "0", shots), up="y")
    renderer = omma.Renderer(scene, omma.eye.generate_eye(300), omma.Fixed(8))
    poses = np.stack([shots[0], omma.look_at((0.3, 0.2, 0), (0, 0.5, -2))])
    plain = renderer.ground_truth(poses)
    assert plain.camera_distance_m is None
    assert plain.camera_angle_deg is None
    shares = []
    truth = renderer.ground_truth(poses, capture_cameras=cameras, progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1
    assert (truth.responses == plain.responses).all()
    distance, angle = cameras.nearness(renderer.eye, poses, distance_m=plain.distance_m)
    assert (truth.camera_distance_m == distance).all()
    assert np.array_equal(truth.camera_angle_deg, angle, equal_nan=True)
    nearest = np.linalg.norm(shots[:, :3, 3] - (0.3, 0.2, 0), axis=1).min()
    assert distance == pytest.approx([0, nearest], abs=1e-9)
    # Where the camera was and in its field the angle is that of an eye's radius; sky behind the
    # cameras was seen by none.
    ahead = renderer.eye.axis[:, 2] < -0.95
    assert np.nanmax(truth.camera_angle_deg[0, ahead]) < 0.5
    assert np.isnan(truth.camera_angle_deg[:, renderer.eye.axis[:, 1] > 0.9]).all()
    # 300 mm lower and nearer: what is seen of the ball comes by some degrees another way.
    assert 5 < np.nanmedian(truth.camera_angle_deg[1, ahead]) < 60


def test_in_datasets(photographed):
    pytest.importorskip("xarray", reason="xarray (omma[data]) is not installed")
    scene, shots = photographed
    cameras = CaptureCameras(shots[:, :3, 3], shots[:, :3, :3], [[40, 30]] * 24)
    renderer = omma.Renderer(scene, omma.eye.generate_eye(50), omma.Fixed(2))
    truth = renderer.ground_truth(shots[:2], capture_cameras=cameras)
    data = renderer.dataset(shots[:2], truth=truth)
    assert data.camera_distance.dims == ("pose",)
    assert data.camera_distance.attrs["units"] == "m"
    assert data.camera_angle.dims == ("pose", "ommatidium")
    assert data.camera_angle.attrs["units"] == "degree"
    assert np.array_equal(data.camera_angle, truth.camera_angle_deg, equal_nan=True)
    assert (data.camera_distance == truth.camera_distance_m).all()


def test_wrong_arguments(photographed):
    scene, shots = photographed
    cameras = CaptureCameras(shots[:, :3, 3], shots[:, :3, :3])
    eye = omma.eye.generate_eye(5)
    for arguments, said in (
        ((eye, np.diag([np.nan, 1, 1, 1])), "poses: expected finite numbers"),
        ((eye, ([[1e300, 0, 0]], [[0, 0, 0, 1]])), r"poses: expected finite numbers within 1e\+18"),
        ((eye, np.diag([0, 1.0, 1, 1])), "poses: expected axes of lengths above 1e-15"),
        ((eye, np.eye(4), np.ones(5)), r"distance_m: expected shape \(1, 5\), found \(5,\)"),
        ((eye, np.eye(4), [[1, 2, np.nan, 3, 4]]), "distance_m: expected distances of 0 or more"),
        ((eye, np.eye(4), [[1, 2, -1, 3, 4]]), "distance_m: expected distances of 0 or more"),
    ):
        with pytest.raises(omma.Error, match=said):
            cameras.nearness(*arguments[:2], distance_m=(*arguments, None)[2])
    with pytest.raises(TypeError, match=r"eye: expected omma\.Eye, found"):
        cameras.nearness("bee.eye", np.eye(4))
    with pytest.raises(TypeError, match=r"capture_cameras: expected omma\.scene\.CaptureCameras"):
        omma.Renderer(scene, eye).ground_truth(np.eye(4), capture_cameras="sparse/0")


def test_info_and_picture(run_omma, tmp_path, photographed, monkeypatch):
    pytest.importorskip("matplotlib", reason="Matplotlib (omma[plots]) is not installed")
    _, shots = photographed
    monkeypatch.chdir(tmp_path)
    write_colmap_text(tmp_path / "garden" / "sparse" / "0", shots)
    code, out, err = run_omma("info", "garden", "--up", "y", "-o", "hull.png")
    assert code == 0, err
    assert (tmp_path / "hull.png").read_bytes().startswith(b"\x89PNG")
    # A ring of 24: sides of 2 * 3 m * sin(180 / 24 degrees).
    for line in (
        "cameras          garden",
        "number           24",
        "bounds           (-3, 1.5, -5) to (3, 1.5, 1) m",
        "extent           6 x 0 x 6 m, as of a tree, a room or a plot",
        "lowest           y = 1.5 m, median 1.5, highest 1.5",
        "spacing          0.7832 m to the next, median (0.7832 to 0.7832 m)",
        "field of view    77.3° x 59.5°",
        "wrote hull.png",
    ):
        assert line in out.splitlines(), out
    write_transforms(tmp_path / "transforms.json", shots, camera_model="OTHER")
    code, out, _ = run_omma("info", "transforms.json", "--up", "y", "--unit", "mm")
    assert code == 0
    assert "bounds           (-0.003, 0.0015, -0.005) to (0.003, 0.0015, 0.001) m" in out
    assert "field of view    not said by the file" in out
    assert "unknown fields   24: count as seeing all before the camera" in out


def test_info_says_which_axis_is_up(run_omma, tmp_path, monkeypatch):
    """By how photographs were held: whoever takes a picture seldom lies on the side."""
    monkeypatch.chdir(tmp_path)
    around = [omma.look_at((3, 1, 0.1 * k), (0, 1, 0)) for k in range(-5, 6)]
    write_transforms(tmp_path / "transforms.json", around)  # +Y is up in it, taken as +Z

    def upright(*more):
        code, out, err = run_omma("info", "transforms.json", *more)
        assert code == 0, err
        return next(line for line in out.splitlines() if line.startswith("upright"))

    said = "and 0° with --up y (--capture-up y of a render)"
    assert upright() == f"upright          the cameras' own up is 90° from +Y on average, {said}"
    assert upright("--up", "-y").endswith(f"180° from +Y on average, {said}")
    assert upright("--up", "y").endswith("up is 0° from +Y on average")
    # With +X up in the file no axis that can be said is near.
    tipped = np.eye(4)[[1, 2, 0, 3]]
    write_transforms(tmp_path / "transforms.json", [tipped @ pose for pose in around])
    assert upright().endswith("up is 90° from +Y on average")
    # As many upside down as upright.
    mixed = [pose @ np.diag([s, s, 1, 1.0]) for pose in around for s in (1, -1)]
    write_transforms(tmp_path / "transforms.json", mixed)
    assert "turned every way" in upright()


def test_what_info_cannot_do(run_omma, tmp_path, photographed, monkeypatch):
    pytest.importorskip("matplotlib", reason="Matplotlib (omma[plots]) is not installed")
    _, shots = photographed
    monkeypatch.chdir(tmp_path)
    write_colmap_text(tmp_path / "garden", shots)
    omma.save_eye("bee.eye", omma.eye.generate_eye(9))
    (tmp_path / "empty").mkdir()
    for words, said in (
        (("garden", "-o", "hull.csv"), "expected a name ending in .pdf, .svg or .png"),
        (("bee.eye", "-o", "hull.png"), "--output: is for the cameras of a capture, found bee.eye"),
        (("garden", "--up", "x"), "--up: expected one of y, z, -y, found 'x'"),
        (("garden", "--unit", "ell"), "--unit: expected mm, um, m or a number of metres"),
    ):
        code, _, err = run_omma("info", *words)
        assert code == 1
        assert said in err, err
    assert not list(tmp_path.glob("hull*"))


def test_pictures_of_few_cameras(tmp_path):
    """One, and cameras on a line, which have no hull."""
    pytest.importorskip("matplotlib", reason="Matplotlib (omma[plots]) is not installed")
    line = np.c_[np.linspace(0, 20, 30), np.full(30, 1.5), np.zeros(30)]
    for name, places in (("one.png", line[:1]), ("two.svg", line[:2]), ("line.png", line)):
        cameras = CaptureCameras(places, [np.eye(3)] * len(places), path="a$b_1$")
        plot_capture_cameras(tmp_path / name, cameras, poses=AHEAD)
        assert (tmp_path / name).stat().st_size > 5000
    assert_allclose(hull_outline(line[:, [0, 1]]), [[0, 1.5], [20, 1.5]])
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5], [0.2, 0.9]])
    assert sorted(map(tuple, hull_outline(square))) == [(0, 0), (0, 1), (1, 0), (1, 1)]
