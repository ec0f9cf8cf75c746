"""Tracks on the ground: headings, times, files; renders, data sets and closed loops along them."""

import re
import warnings

import numpy as np
import pytest
from dataset_jobs import write_job
from test_walking import FLOOR, angles_deg

import omma
from omma import scene as solids
from omma.motion import Track, ground_at, load_track, place_on, walk_on


def test_headings_along_a_track():
    turn = np.linspace(0, np.pi, 200)
    arc = np.column_stack([1 - np.cos(turn), -np.sin(turn)])  # to the right, from looking along -Z
    yaw = angles_deg(walk_on(FLOOR, arc, height_m=0.01))[0]
    np.testing.assert_allclose(yaw[3:-3], np.degrees(turn)[3:-3], atol=0.5)
    corner = Track(np.array([(0, 0), (0, -1), (1, -1)])).at_speed(0.01, step_s=1)
    yaw = angles_deg(walk_on(FLOOR, corner, height_m=0.02))[0]
    assert yaw[50] == pytest.approx(0)
    assert yaw[100] == pytest.approx(45, abs=1e-6)
    assert yaw[150] == pytest.approx(90)
    assert np.abs(np.diff(yaw)).max() < 45
    still = np.array([(0, 0), (0, 0), (1, 0), (1, 0)])
    yaw = angles_deg(walk_on(FLOOR, still, height_m=0.01))[0]
    np.testing.assert_allclose(yaw, 90, atol=1e-9)
    with pytest.raises(omma.Error, match="positions that differ"):
        walk_on(FLOOR, still[:2], height_m=0.01)
    told = Track(still[:2], heading_deg=np.array([10.0, 20.0]))
    yaw = angles_deg(walk_on(FLOOR, told, height_m=0.01))[0]
    np.testing.assert_allclose(yaw, [10, 20], atol=1e-9)


def test_tracks_in_time():
    track = Track(
        np.array([(0, 0), (0, -1), (2, -1)]), np.array([170.0, -170.0, -150.0]), np.array([1, 2, 4])
    )
    even = track.every(0.5)
    np.testing.assert_allclose(even.times_s, np.arange(1, 4.1, 0.5))
    np.testing.assert_allclose(even.xz_m[[1, 3]], [(0, -0.5), (0.5, -1)])
    np.testing.assert_allclose(even.heading_deg[1], 180)
    steady = track.at_speed(0.3, step_s=0.1)
    np.testing.assert_allclose(np.abs(np.diff(steady.xz_m, axis=0)).sum(axis=1), 0.03)
    assert len(steady.xz_m) == 101
    with pytest.raises(omma.Error, match="times_s: expected a track with times"):
        Track(track.xz_m).every(0.1)
    with pytest.raises(omma.Error, match=r"times that grow, found times_s\[1\] 1 after 1"):
        Track(track.xz_m, times_s=np.array([1, 1, 2]))


def test_files_of_tracks(tmp_path):
    path = tmp_path / "track.csv"
    path.write_text("t_s,x_m,z_m,heading_deg\n# an ant\n0,0,0,10\n\n0.5,0.1,-0.2,20\n")
    track = load_track(path)
    np.testing.assert_array_equal(track.xz_m, [(0, 0), (0.1, -0.2)])
    np.testing.assert_array_equal(track.heading_deg, [10, 20])
    np.testing.assert_array_equal(track.times_s, [0, 0.5])
    path.write_text("x_m,z_m\n1,2\n")
    assert load_track(path) == Track(np.array([(1.0, 2.0)]))
    for text, match in (
        ("x,y\n1,2\n", r"line 1: expected a header line t_s,x_m,z_m or .*x_m,z_m,heading_deg"),
        ("x_m,z_m\n1\n", "line 2: expected 2 numbers"),
        ("x_m,z_m\n1,a\n", "line 2, column z_m: expected a finite number"),
        ("x_m,z_m\n", "holds no position"),
        (
            "t_s,x_m,z_m\n\n0,0,0\n2,0,0\n1.5,0,1\n",
            r"track\.csv, line 5: expected times that grow, found t_s 1.5 after 2 in line 4",
        ),
        ("x_m,z_m\n1,inf\n", "line 2, column z_m: expected a finite number"),
    ):
        path.write_text(text)
        with pytest.raises(omma.Error, match=match):
            load_track(path)


def test_headers_of_loggers_and_maps_are_told_what_to_do(tmp_path):
    path = tmp_path / "gps.csv"
    for header, says in (
        (
            "time,lat,lon",
            "project latitude and longitude to metres first, as to UTM; x_m is the easting and z_m "
            "the northing's negative, in metres; columns are in seconds, metres and degrees: t_s "
            "for time",
        ),
        ("t_s,easting,northing", "x_m is the easting and z_m the northing's negative, in metres"),
        (
            "x_m,y_m",
            "z_m leads south: it is y_m, in metres, where that grows downwards, as in videos from "
            "above, and its negative where it grows northwards, as on maps",
        ),
        (
            "frame,x_px,y_px",
            "where it grows northwards, as on maps; columns are in seconds, metres and degrees: "
            "x_m for x_px; t_s is frame divided by the frames of a second",
        ),
        ("id,x_m,z_m", "a track is of one animal: one file for each, of id"),
        ("t_s,track_id,x_m,z_m", "a track is of one animal: one file for each, of track_id"),
        ("seconds,x1,y1,x2,y2", "a track is of one animal: one file for each, of x1, x2"),
        ("t_ms,x_cm,z_cm", "metres and degrees: t_s for t_ms, x_m for x_cm, z_m for z_cm"),
        ("time (s),x_m,z_m", "metres and degrees: t_s for time (s)"),
        ("t_s,x_m,z_m,speed,sex", "leave out speed, sex"),
        (
            "easting,northing,z",
            "x_m is the easting and z_m the northing's negative, in metres",
        ),
        (
            "t_s,x_m,y_m,z_m",
            "z_m is horizontal, in metres south of the origin: where z_m is height, z_m is the "
            "negative of y_m, and the height is left out; where y_m is height, leave it out",
        ),
        (
            "x,y,z",
            "negative of y, and the height is left out; where y is height, leave it out, and z_m "
            "is z; columns are in seconds, metres and degrees: x_m for x",
        ),
        ("t_s,x_m,z_m,bearing_deg", "metres and degrees: heading_deg for bearing_deg"),
        ("t_s,x_m,z_m,yaw_deg,theta", "metres and degrees: heading_deg for yaw_deg"),
        ("x_m,z_m,azimuth_deg", "metres and degrees: heading_deg for azimuth_deg"),
        ("x_m,z_m,heading_deg,bearing_deg", "leave out bearing_deg"),
        ("timestamp,x_m,z_m", "columns are in seconds, metres and degrees: t_s for timestamp"),
        ("t_s,timestamp,x_m,z_m", "leave out timestamp"),
        ("frame,x_m,z_m", "t_s is frame divided by the frames of a second"),
        ("x_m,z_m,z_m", "found 'x_m,z_m,z_m'"),
        ("a,b", "found 'a,b'"),
    ):
        path.write_text(f"{header}\n1,2,3\n")
        with pytest.raises(omma.Error, match=f"{re.escape(says)}$"):
            load_track(path)


def test_dates_for_times_are_told_that_times_are_in_seconds(tmp_path):
    path = tmp_path / "walk.csv"
    for header, rest in (("x_m,z_m", ",0,0"), ("x,y,z,yaw_deg,pitch_deg,roll_deg", ",0" * 6)):
        path.write_text(f"t_s,{header}\n2026-06-21T09:00:00+09:30{rest}\n")
        read = load_track if header == "x_m,z_m" else omma.load_poses
        with pytest.raises(omma.Error, match=r"found '2026-06-21T.*'; t_s is in seconds"):
            read(path)


def test_decimal_commas_between_commas_are_told(tmp_path):
    path = tmp_path / "track.csv"
    says = "decimals have points where commas separate the cells, or commas where semicolons do"
    path.write_text('"x_m","z_m"\n"389123,45","-5819456,78"\n')
    with pytest.raises(omma.Error, match=f"column x_m: .*found '389123,45'; {says}"):
        load_track(path)
    path.write_text("x_m,z_m\n0,5,1,5\n")
    with pytest.raises(omma.Error, match=f"expected 2 numbers .*, found 4; {says}"):
        load_track(path)
    path.write_text("x_m,z_m\n0,a\n")
    with pytest.raises(omma.Error, match=r"found 'a'$"):
        load_track(path)


LOST = """t_s,x_m,z_m
0,nan,NaN
0.1,0,0
0.2,,
0.3,0,-0.1
# a note
0.4,,nan
0.5,NA,-0.2
1.6,0,-0.3
1.7,0,-0.4
"""


def test_frames_in_which_the_animal_was_lost(tmp_path):
    path = tmp_path / "track.csv"
    path.write_text(LOST)
    with pytest.raises(omma.Error, match=r'line 2, column x_m: .*4 of 8 .*lost="leave_out"'):
        load_track(path)
    told = r"left out 4 of 8 .*, the first 1 among.*without a position: lines 5 to 9 \(1\.3 s"
    with pytest.warns(UserWarning, match=told):
        track = load_track(path, lost="leave_out")
    np.testing.assert_array_equal(track.times_s, [0.1, 0.3, 1.6, 1.7])
    np.testing.assert_array_equal(track.xz_m, [(0, 0), (0, -0.1), (0, -0.3), (0, -0.4)])
    # Without times no gap has a length; whole tracks are read without a word.
    path.write_text("x_m;z_m\n0;0\n;\nnan;nan\n1,5;0\n")
    with pytest.warns(UserWarning, match=r"2 of 4 .*without t_s, at most 2 in a row"):
        assert load_track(path, lost="leave_out") == Track(np.array([(0.0, 0.0), (1.5, 0.0)]))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        path.write_text("t_s,x_m,z_m\n0,0,0\n5,1,1\n")
        assert len(load_track(path, lost="leave_out").xz_m) == 2
    path.write_text("x_m,z_m\nnan,nan\n")
    with pytest.raises(omma.Error, match="holds no position: each line lacks a number"):
        load_track(path, lost="leave_out")
    with pytest.raises(omma.Error, match="lost: expected one of refuse, leave_out"):
        load_track(path, lost="interpolate")


@pytest.fixture
def files(tmp_path):
    """A meadow's path, an eye and a track."""
    hill = solids.place_scene(FLOOR, omma.poses_from_angles((0, 0, 0), (0, 10, 0))[0])
    roof = solids.plane((20, 20), center_m=(0, 9, 0), name="roof")
    omma.scene.save_scene(tmp_path / "hill.glb", solids.merge_scenes([hill, roof]))
    omma.save_eye(tmp_path / "ant.eye", omma.eye.generate_eye(50))
    (tmp_path / "track.csv").write_text("x_m,z_m\n0,0\n0.5,-0.5\n1,-0.5\n")
    return tmp_path


def test_renders_along_a_track(files, run_omma):
    scene, eye, track = (files / name for name in ("hill.glb", "ant.eye", "track.csv"))
    run_omma(
        "render", scene, "--eye", eye, "--path", track, "--on-ground", "0.003",
        "--ground", "floor", "-o", files / "walk.npy",
    )  # fmt: skip
    world = omma.World(omma.load_scene(scene))
    poses = walk_on(world, load_track(track), height_m=0.003, on=["floor"])
    expected = omma.Renderer(world, omma.load_eye(eye), omma.Fixed(16)).render(poses)
    np.testing.assert_array_equal(np.load(files / "walk.npy"), expected)
    assert poses[:, 1, 3].max() < 1
    (files / "lost.csv").write_text("x_m,z_m\n0,0\nnan,nan\n0.5,-0.5\n1,-0.5\n")
    run_omma(
        "render", scene, "--eye", eye, "--path", files / "lost.csv", "--on-ground", "0.003",
        "--ground", "floor", "--lost", "leave_out", "-o", files / "lost.npy",
    )  # fmt: skip
    np.testing.assert_array_equal(np.load(files / "lost.npy"), expected)
    for match, asked in (
        ("on_ground: expected a path", {"on_ground": 0.1}),
        ("ground: goes with on_ground", {"path": track, "ground": ["floor"]}),
        ("lost: goes with on_ground", {"path": track, "lost": "leave_out"}),
        ("on_ground: expected a number above 0", {"path": track, "on_ground": 0.0}),
        (
            "^ground: expected the name of a thing",
            {"path": track, "on_ground": 0.1, "ground": ["flor"]},
        ),
        ("header line t_s,x_m,z_m", {"path": omma.examples.flight(), "on_ground": 0.1}),
    ):
        with pytest.raises(omma.Error, match=match):
            omma.render_file(scene, files / "no.npy", eyes=eye, **asked)


@pytest.mark.parametrize("suffix", [".zarr", ".nc", ".parquet", ".npy"])
def test_times_of_a_track_are_kept(files, suffix):
    for package in ("xarray", "zarr", "h5netcdf", "pyarrow"):
        pytest.importorskip(package)
    (files / "timed.csv").write_text("t_s,x_m,z_m\n0,0,0\n0.25,0.5,-0.5\n1,1,-0.5\n")
    output, again = files / f"walk{suffix}", files / f"again{suffix}"
    scene, eye, track = (files / name for name in ("hill.glb", "ant.eye", "timed.csv"))
    omma.render_file(scene, output, eyes=eye, path=track, on_ground=0.003)
    data = omma.rendering.load_responses(output)
    assert data.response.dims == ("time", "ommatidium", "band")
    assert data.time.values.tolist() == [0, 0.25, 1]
    poses = walk_on(omma.load_scene(scene), load_track(track), height_m=0.003)
    np.testing.assert_array_equal(data.world_from_head, poses)
    omma.job.render_like(output, again)
    same = omma.rendering.load_responses(again)
    np.testing.assert_array_equal(same.response, data.response)
    np.testing.assert_array_equal(same.time, data.time)
    omma.render_file(scene, output, eyes=eye, path=files / "track.csv", on_ground=0.003)
    assert omma.rendering.load_responses(output).response.dims[0] == "pose"


def test_data_sets_along_a_track(files):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("zarr")
    lines = [f"{0.1 * k},0,{-0.01 * k}" for k in range(11)]
    lines[5] = "0.5,,"
    (files / "timed.csv").write_text("\n".join(["t_s,x_m,z_m", *lines]))
    poses = '[[poses]]\nsampler = "track"\nfile = "timed.csv"\nheight_m = 0.003\nstep_s = 0.05\n'
    poses += 'lost = "leave_out"\n'
    job = write_job(files, dataset='outputs = ["flow"]', poses=poses)
    with pytest.warns(UserWarning, match="left out 1 of 11 positions"):
        omma.datasets.run(job)
    data = xarray.open_zarr(files / "job.zarr")
    made = data.world_from_head.values
    with pytest.warns(UserWarning, match="left out 1 of 11 positions"):
        track = load_track(files / "timed.csv", lost="leave_out").every(0.05)
    scene = omma.load_scene(files / "scene.gltf")
    np.testing.assert_array_equal(made, walk_on(scene, track, height_m=0.003))
    assert len(made) == 21
    linear, _ = omma.velocities_from_poses(made, track.times_s)
    np.testing.assert_allclose(data.head_velocity, linear, atol=1e-9)
    np.testing.assert_array_equal(data.time, track.times_s)
    assert (data.walk == 0).all()


def test_a_closed_loop_on_the_ground():
    spaces = pytest.importorskip("gymnasium").spaces
    hill = solids.place_scene(FLOOR, omma.poses_from_angles((0, 0, 0), (0, 20, 0))[0])
    world = omma.World(hill)

    def pose_of(z):
        return z, place_on(world, (0, z), height_m=0.01)[0]

    loop = omma.gym.Loop(
        omma.Renderer(world, omma.eye.generate_eye(30), omma.Fixed(1)),
        lambda rng: pose_of(1.0),
        lambda z, action, rng: pose_of(z - action[0]),
        reward=lambda moment: ground_at(world, moment.pose).climb_deg[0],
        action_space=spaces.Box(0, 1, (1,), np.float32),
        most_steps=5,
    )
    env = omma.gym.eye_env(loop)
    env.reset(seed=1)
    _, reward, _, _, info = env.step(np.array([0.5], np.float32))
    assert reward == pytest.approx(20, abs=1e-4)
    np.testing.assert_array_equal(info["pose"], pose_of(0.5)[1])


@pytest.mark.parametrize(
    "text",
    [
        "t_s;x_m;z_m\n0;1,5;2\n0,5;2,5;3\n",
        "t_s\tx_m\tz_m\n0\t1,5\t2\n0.5\t2.5\t3\n",
        "x_m,z_m,t_s\n1.5,2,0\n2.5,3,0.5\n",
        "z_m; T_s; x_m # of the tracker\n2; 0; 1.5\n\n3; 0.5; 2.5\n",
    ],
)
def test_tracks_as_programs_write_them(tmp_path, text):
    """Semicolons and tabs, with decimal commas then, and columns in any order."""
    (tmp_path / "track.csv").write_text(text)
    found = omma.motion.load_track(tmp_path / "track.csv")
    assert np.array_equal(found.xz_m, [(1.5, 2), (2.5, 3)])
    assert np.array_equal(found.times_s, [0, 0.5])


def test_poses_as_programs_write_them(tmp_path):
    (tmp_path / "path.csv").write_text(
        "yaw_deg;pitch_deg;roll_deg;x;y;z\n90;0;0;1,5;2;3\n0;10;0;0;0;0\n"
    )
    expected = omma.poses_from_angles([(1.5, 2, 3), (0, 0, 0)], [(90, 0, 0), (0, 10, 0)])
    assert np.array_equal(omma.load_poses(tmp_path / "path.csv"), expected)
    (tmp_path / "path.csv").write_text("x;y;z;yaw_deg;pitch_deg;roll_deg\n1;2;3;4;5\n")
    with pytest.raises(omma.Error, match="line 2: expected 6 numbers separated by semicolons"):
        omma.load_poses(tmp_path / "path.csv")
