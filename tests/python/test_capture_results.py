"""How near cameras of a capture were, in what renders and data sets write: the numbers of ground
truth, beside responses of the same bits."""

import dataclasses

import numpy as np
import pytest
from capture_files import write_colmap_binary, write_transforms
from conftest import make_eye, write_gltf
from dataset_jobs import write_job
from splat_files import some_splats

import omma
from omma.job.again import render_like
from omma.job.info import describe_file
from omma.scene import load_capture_cameras

AROUND = [omma.look_at((np.sin(a), 1.5, 4 * np.cos(a)), (0, 0, 0)) for a in np.linspace(0, 5, 7)]
NUMBERED = ("r.npy", "r.nc", "r.zarr", "r.parquet", "r.csv")
UP = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])  # z to y


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A scene, an eye, cameras around it in COLMAP's frame turned up, and a path of 4 poses."""
    write_gltf(tmp_path / "scene.gltf")
    omma.save_eye(tmp_path / "bug.csv", make_eye(30))
    write_colmap_binary(tmp_path / "shots", AROUND)
    path = [(0.2 * k, 1, 2 - 0.1 * k, 20 * k, -10, 0) for k in range(4)]
    np.savetxt(
        tmp_path / "path.csv",
        path,
        delimiter=",",
        comments="",
        header="x,y,z,yaw_deg,pitch_deg,roll_deg",
    )
    monkeypatch.chdir(tmp_path)
    return tmp_path


def render(outputs, *sampling, **more):
    asked = {"eyes": "bug.csv", "path": "path.csv", "capture_cameras": "shots", "capture_up": "y"}
    sampling = sampling or (omma.Fixed(8),)
    return omma.render_file("scene.gltf", outputs, *sampling, **{**asked, **more})


def truth_of(sampling, cameras=None, **options):
    eye, poses = omma.load_eye("bug.csv"), omma.load_poses("path.csv")
    renderer = omma.Renderer(omma.load_scene("scene.gltf"), eye, sampling)
    cameras = load_capture_cameras("shots", up="y") if cameras is None else cameras
    return renderer.ground_truth(poses, capture_cameras=cameras, **options)


def check(data, truth, digits=None):
    wanted = {"camera_distance": truth.camera_distance_m, "camera_angle": truth.camera_angle_deg}
    for name, values in wanted.items():
        found = data[name].values
        assert found.dtype == values.dtype
        assert data[name].dims == ("pose", "ommatidium")[: values.ndim]
        if digits is None:
            assert np.array_equal(found, values, equal_nan=True)
        else:
            np.testing.assert_allclose(found, values, rtol=10.0**-digits)
    assert data.camera_angle.attrs["units"] == "degree"
    assert data.camera_distance.attrs["units"] == "m"


def test_every_file_has_them_beside_the_same_responses(folder):
    pytest.importorskip("xarray")
    report = render(NUMBERED)
    assert "r.camera_angle.npy" in report.outputs
    assert report.warnings == ()
    truth = truth_of(omma.Fixed(8))
    # Some of what is seen was in no camera's field, some was.
    assert 0 < np.isnan(truth.camera_angle_deg).mean() < 1
    omma.render_file("scene.gltf", "plain.npy", omma.Fixed(8), eyes="bug.csv", path="path.csv")
    plain = np.load("plain.npy")
    for name in NUMBERED:
        data = omma.rendering.load_responses(name)
        check(data, truth, digits=8 if name == "r.csv" else None)  # nine digits are written
        assert data.response.values.tobytes() == plain.tobytes()
    assert np.load("r.camera_angle.npy").dtype == np.float32
    header = (folder / "r.csv").read_text().splitlines()[0]
    assert header.endswith(",r,g,b,camera_distance_m,camera_angle_deg")


def test_with_standard_errors_and_to_an_error(folder):
    pytest.importorskip("xarray")
    render(("e.npy", "e.csv", "e.parquet"), standard_error=True)
    truth = truth_of(omma.Fixed(8), standard_error=True)
    for name in ("e.npy", "e.csv", "e.parquet"):
        data = omma.rendering.load_responses(name)
        check(data, truth, digits=8 if name == "e.csv" else None)
        assert np.array_equal(data.standard_error.values, truth.standard_error)
    target = omma.ToError(0.05, most=64)
    report = render(("t.nc", "t.npy"), target)
    assert "rays" in dict(describe_file("t.nc"))
    plain = omma.render_file("scene.gltf", "plain.nc", target, eyes="bug.csv", path="path.csv")
    assert (report.rays, report.spent) == (plain.rays, plain.spent)
    data, without = (omma.rendering.load_responses(one) for one in ("t.nc", "plain.nc"))
    check(data, truth_of(target))
    for name in ("response", "standard_error", "rays"):
        assert np.array_equal(data[name].values, without[name].values)


def test_rendered_again_and_gone_on_with(folder, monkeypatch):
    pytest.importorskip("xarray")
    render("a.nc")
    render_like("a.nc", "b.npy")
    truth = truth_of(omma.Fixed(8))
    check(omma.rendering.load_responses("b.npy"), truth)

    def stop(stage, share):
        if stage == "Writing" and share > 0.4:
            raise KeyboardInterrupt

    monkeypatch.setattr("omma.job.pieces._KEPT_PIECE_S", 0)
    with pytest.raises(KeyboardInterrupt):
        render(("c.npy", "c.csv"), resume=True, progress=stop)
    assert not (folder / "c.npy").exists()
    with pytest.raises(omma.Error, match=r"capture_up was 'y', is 'z'"):
        render(("c.npy", "c.csv"), resume=True, capture_up="z")
    assert "resumed at pose" in render(("c.npy", "c.csv"), resume=True).view
    for name in ("c.npy", "c.csv"):
        check(omma.rendering.load_responses(name), truth, digits=8 if name == "c.csv" else None)

    write_colmap_binary(folder / "shots", AROUND[1:])
    with pytest.raises(omma.Error, match=r"shots: is not what the cameras of a\.nc were"):
        render_like("a.nc", "b.npy")


def test_units_and_axes_are_those_of_the_scene_or_said(folder):
    pytest.importorskip("xarray")
    trimesh = pytest.importorskip("trimesh")
    box = trimesh.creation.box((200, 200, 200))  # mm
    box.export(folder / "box.stl")
    inverse = np.linalg.inv(UP)
    in_mm = []
    for pose in AROUND:
        moved = inverse @ pose
        moved[:3, 3] *= 1000
        in_mm.append(moved)
    write_transforms(folder / "transforms.json", in_mm)
    asked = {"eyes": "bug.csv", "path": "path.csv", "capture_cameras": "transforms.json"}
    asked |= {"scene_unit": "mm", "scene_up": "z"}
    wanted = omma.Renderer(
        omma.load_scene("box.stl", unit="mm", up="z"), omma.load_eye("bug.csv"), omma.Fixed(2)
    ).ground_truth(
        omma.load_poses("path.csv"),
        capture_cameras=load_capture_cameras("shots", up="y"),
    )
    for more in ({}, {"capture_unit": "mm", "capture_up": "z"}):
        omma.render_file("box.stl", "u.nc", omma.Fixed(2), **asked, **more)
        data = omma.rendering.load_responses("u.nc")
        # Cameras by way of millimetres and quaternions are off by some last digits.
        for name in ("camera_distance", "camera_angle"):
            values = getattr(wanted, name + ("_m" if "distance" in name else "_deg"))
            np.testing.assert_allclose(data[name].values, values, rtol=1e-5, atol=1e-4)
    # In another unit they are elsewhere.
    omma.render_file("box.stl", "u.npy", omma.Fixed(2), **asked, capture_unit="m")
    assert np.load("u.camera_distance.npy").min() > 1000


def test_cameras_of_another_place_are_told(folder):
    away = [omma.look_at((0, 500, 0), (0, 900, 1))] * 2  # looking up, far above
    write_colmap_binary(folder / "away", away)
    report = render("r.npy", capture_cameras="away")
    (warning,) = report.warnings
    assert warning.startswith("away: no camera had anything in its field that is seen here")


def test_what_cannot_be_is_refused(folder):
    write_gltf(folder / "cameras.gltf", cameras=[("plain", None, {"translation": [0, 1, 0]})])
    for more, message in (
        ({"receptors": True}, "capture_cameras: is for responses of ommatidia"),
        ({"outputs": "r.png"}, r"capture_cameras: expected an output that says numbers.*r\.png"),
        ({"capture_cameras": "nowhere"}, "nowhere: there is no such file"),
        ({"capture_cameras": "."}, r"\.: expected a folder of COLMAP"),
        ({"capture_up": "x"}, "capture_up: expected one of y, z"),
        ({"capture_unit": "ell"}, "capture_unit: expected mm"),
        ({"capture_cameras": None}, "capture_up: goes with capture_cameras"),
        ({"outputs": ["r.npy", "r.camera_angle.npy"]}, "r.camera_angle.npy: is an output twice"),
    ):
        outputs = more.pop("outputs", "r.npy")
        with pytest.raises(omma.Error, match=message):
            render(outputs, **more)
    with pytest.raises(omma.Error, match=r"expected rays of each ommatidium's own"):
        render("r.npy", omma.Shared(2))
    with pytest.raises(omma.Error, match="is for eyes; camera 'plain' is perspective"):
        omma.render_file("cameras.gltf", "r.npy", capture_cameras="shots")
    assert not list(folder.glob("r.*"))


def test_the_command_and_what_info_says(folder, run_omma):
    words = ("--eye", "bug.csv", "--path", "path.csv", "--capture-cameras", "shots")
    more = ("--capture-up", "y", "--samples", 8, "-o", "r.npy")
    assert run_omma("render", "scene.gltf", *words, *more)[0] == 0
    truth = truth_of(omma.Fixed(8))
    assert np.array_equal(np.load("r.camera_angle.npy"), truth.camera_angle_deg, equal_nan=True)
    lines = dict(describe_file("r.npy"))
    distance = truth.camera_distance_m
    assert lines["camera distance"] == (
        f"{distance.min():.4g} to {distance.max():.4g}, mean {distance.mean():.4g} m"
    )
    none = np.isnan(truth.camera_angle_deg).mean()
    assert f"(none in {none:.1%} of them) degrees" in lines["camera angle"]
    _, _, said = run_omma("render", "scene.gltf", *words, "--shared", 2, "-o", "s.npy")
    assert "--capture-cameras: expected rays of each ommatidium's own" in said
    _, _, said = run_omma("render", "scene.gltf", *words, "--capture-up", "x", "-o", "s.npy")
    assert "--capture-up: expected one of y, z" in said


def job_of(folder, **more):
    """Two scenes, one of them captured, in shards that have both."""
    (folder / "job").mkdir(exist_ok=True)
    omma.scene.save_scene(
        folder / "job/splats.glb", omma.Scene(splats=[some_splats(40, 1).replace(name="shrub")])
    )
    scenes = (
        '[[scene]]\nname = "splats"\nfile = "splats.glb"\n'
        'capture_cameras = "../shots"\ncapture_up = "y"\n'
    )
    job = write_job(folder / "job", count=3, **more)
    job.write_text(job.read_text().replace("[[eye]]", f"{scenes}[[eye]]", 1))
    return job


def truth_of_views(views, every, scene, eye):
    """Of those views that are of a scene."""
    renderer = omma.Renderer(scene, eye, omma.Fixed(2))
    return renderer.ground_truth(
        every["world_from_head"], capture_cameras=load_capture_cameras("shots", up="y")
    )


@pytest.mark.parametrize("is_first", [False, True])
@pytest.mark.parametrize("outputs", ["responses", "truth"])
def test_data_sets_have_them(folder, outputs, is_first):
    zarr = pytest.importorskip("zarr")
    dataset = 'outputs = ["responses", "truth"]\n' if outputs == "truth" else ""
    job = job_of(folder, dataset=dataset)
    if is_first:  # the captured scene of splats before the other
        text = job.read_text()
        begin, end = text.index("[[scene]]"), text.index("[[eye]]")
        one, other = text[begin:end].split("[[scene]]")[1:]
        job.write_text(f"{text[:begin]}[[scene]]{other}[[scene]]{one}{text[end:]}")
    omma.datasets.run(job, folder / "out.zarr")
    root = zarr.open_group(folder / "out.zarr", mode="r")
    poses = root["world_from_head"][:]
    names = root["scene"].attrs["flag_meanings"].split()
    captured = root["scene"][:] == names.index("splats")
    assert captured.sum() == 3
    renderer = omma.Renderer(
        omma.load_scene(folder / "job/splats.glb"), omma.load_eye(folder / "job/bug.csv"),
        omma.Fixed(2),
    )  # fmt: skip
    truth = renderer.ground_truth(
        poses[captured], capture_cameras=load_capture_cameras("shots", up="y")
    )
    distance, angle = root["camera_distance"][:], root["camera_angle"][:]
    assert distance[captured] == pytest.approx(truth.camera_distance_m, abs=0)
    assert np.array_equal(angle[captured], truth.camera_angle_deg, equal_nan=True)
    assert np.array_equal(root["response"][:][captured], truth.responses)
    # The other scene was not captured: there is no such number.
    assert np.isnan(distance[~captured]).all()
    assert np.isnan(angle[~captured]).all()
    assert ("distance" in root) == ("source_distance" in root) == (outputs == "truth")
    if outputs == "truth":
        found = root["source_distance"][:]
        assert np.array_equal(found[captured], truth.source_distance_m)
        assert np.isnan(found[~captured]).all()
        assert np.isfinite(root["nearest"][:][~captured]).any()


def test_shares_of_splats_in_data_sets(folder):
    zarr = pytest.importorskip("zarr")
    more = 'outputs = ["responses", "shares"]\ninstances = ["shrub", "ground"]\n'
    omma.datasets.run(job_of(folder, dataset=more), folder / "out.zarr")
    root = zarr.open_group(folder / "out.zarr", mode="r")
    assert root["instance"][:].tolist() == ["shrub", "ground"]
    is_splats = root["scene"][:] == 1
    share = root["share"][:]
    assert (share[is_splats][..., 1] == 0).all()
    assert (share[~is_splats][..., 0] == 0).all()
    assert share[~is_splats][..., 1].max() > 0.5


def test_jobs_that_cannot_be(folder):
    pytest.importorskip("zarr")
    job = job_of(folder)
    text = job.read_text()
    for old, new, message in (
        ('"../shots"', '"../nothing"', r"scene\[1\]\.capture_cameras: expected a file or folder"),
        ('"../shots"', '".."', "expected a folder of COLMAP"),
        ("samples = 2", "shared = 2", "rendering.shared: expected samples"),
        ('capture_cameras = "../shots"\n', "", r"scene\[1\]: expected capture_cameras"),
        ('capture_up = "y"', 'capture_up = "x"', "capture_up: expected one of y, z"),
    ):
        assert old in text
        job.write_text(text.replace(old, new))
        with pytest.raises(omma.Error, match=message):
            omma.datasets.run(job, folder / "out.zarr")
        assert not (folder / "out.zarr").exists()
    # Cameras that have changed are another data set.
    job.write_text(text)
    omma.datasets.run(job, folder / "out.zarr")
    write_colmap_binary(folder / "shots", AROUND[1:])
    with pytest.raises(omma.Error, match=r"shots/images\.bin has changed"):
        omma.datasets.run(job, folder / "out.zarr")


def test_what_scenes_of_jobs_pass_over_is_told(folder, run_omma):
    pytest.importorskip("zarr")
    job = write_job(folder / "job", count=2)
    scales = np.full((3, 3), 0.1, np.float32)
    splats = omma.scene.SplatCloud(
        np.zeros((3, 3)), scales, np.tile((0, 0, 0, 1.0), (3, 1)), np.ones(3), np.zeros((3, 1, 3))
    )
    omma.scene.save_splats(folder / "job/a.ply", splats)
    data = bytearray((folder / "job/a.ply").read_bytes())
    data[-44:-40] = np.float32(np.nan).tobytes()  # f_dc_0 of the last 17 numbers
    (folder / "job/a.ply").write_bytes(data)
    job.write_text(job.read_text().replace("scene.gltf", "a.ply"))
    report = omma.datasets.run(job, folder / "out.zarr")
    (sentence,) = report.warnings
    assert sentence.endswith("a.ply: 1 splats are left out: harmonics not finite")
    assert dataclasses.replace(report, warnings=()).warnings == ()
    code, _, err = run_omma("dataset", "run", job, "-o", folder / "two.zarr")
    assert code == 0
    assert "1 splats are left out" in err
