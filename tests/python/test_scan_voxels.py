"""Scans thinned by the cells of a grid where they are scenes: in Python, on the command line, in
jobs of data sets, and in what files and pages say of how they were made."""

import json
import re

import numpy as np
import pytest
from conftest import make_eye
from dataset_jobs import write_job
from point_clouds import write_ply

import omma
from omma.job.info import describe_file
from omma.view import HeadPose, Look, Seen
from omma.view.command import Sources, render_command, render_python

RNG = np.random.default_rng(3)
CELL_M = 0.05
WORDS = ("--eye", "e.csv", "--position", "0.1", "0.5", "0.2")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A floor of 4,000 points with colours and classes, +Y up, and an eye."""
    places = RNG.uniform(-1, 1, (4000, 3))
    places[:, 1] = 0
    columns = {axis: ("float", places[:, k]) for k, axis in enumerate("xyz")}
    columns |= {name: ("uchar", RNG.integers(0, 256, 4000)) for name in ("red", "green", "blue")}
    columns["classification"] = ("uchar", RNG.integers(2, 4, 4000))
    write_ply(tmp_path / "scan.ply", columns)
    omma.save_eye(tmp_path / "e.csv", make_eye(40))
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def done(run_omma):
    """What a command prints that has to succeed."""

    def run(*words):
        code, out, err = run_omma(*words)
        assert code == 0, err
        return out

    return run


@pytest.fixture
def refused(run_omma):
    """The error of a command that has to fail."""

    def run(*words):
        code, _, err = run_omma(*words)
        assert code != 0
        return err

    return run


def thinned(folder):
    return omma.scene.surfels(
        omma.scene.load_points(folder / "scan.ply", voxel_m=CELL_M), name="scan.ply"
    )


def test_a_scene_is_made_of_the_means_of_cells(folder):
    scene = omma.load_scene(folder / "scan.ply", voxel_m=CELL_M)
    assert scene == thinned(folder)
    # A square of 2 m in cells of 5 cm, of which exp(-2.5), 8 %, have none of 4,000 random points;
    # the grid begins anywhere.
    assert 1400 < scene.triangle_count / 2 <= 41 * 41
    for name, voxel_m, message in (
        ("scan.ply", 0.0, r"scan\.ply: voxel_m: expected a number above 0"),
        ("scan.ply", 1e-9, r"scan\.ply: voxel_m: expected cells"),
        ("e.obj", 0.1, r"voxel_m: expected none, as e\.obj holds no points"),
        (omma.examples.meadow(), 0.1, "voxel_m: expected none"),
    ):
        with pytest.raises(omma.Error, match=message):
            omma.load_scene(name, voxel_m=voxel_m)


def test_info_says_what_is_left(folder, done, refused):
    cloud = omma.scene.load_points(folder / "scan.ply", voxel_m=CELL_M)
    lines = dict(describe_file("scan.ply", voxel_m=CELL_M))
    assert lines["number"] == f"{len(cloud):,}, means of 4,000 in cells of 0.05 m"
    counts = [f"{label}: {np.sum(cloud.labels == label):,}" for label in (2, 3)]
    assert lines["classes"] == ", ".join(counts)
    low, high = cloud.bounds
    assert lines["bounds"].startswith(f"({low[0]:.4g}, ")
    assert f"{high[2]:.4g}) m" in lines["bounds"]
    # Means in cells of 5 cm are about as far apart; all points are 16 mm at random.
    assert 20 < float(lines["spacing"].split()[0]) < 50
    assert dict(describe_file("scan.ply"))["number"] == "4,000"
    assert "means of 4,000 in cells" in done("info", "scan.ply", "--voxel-m", CELL_M)
    for words in (["scan.ply", "--voxel-m", "-1"], ["e.csv", "--voxel-m", "1"]):
        assert "--voxel-m: expected" in refused("info", *words)


def test_renders_are_of_the_means_and_again(folder, done):
    done("render", "scan.ply", *WORDS, "--scene-voxel-m", CELL_M, "-o", "a.npy", "-o", "a.nc")
    renderer = omma.Renderer(thinned(folder), omma.load_eye("e.csv"))
    wanted = renderer.render(omma.poses_from_angles((0.1, 0.5, 0.2), (0, 0, 0)))
    assert np.load("a.npy").tobytes() == wanted.tobytes()
    assert json.loads((folder / "a.json").read_text())["attributes"]["scene_voxel_m"] == CELL_M
    done("render", "scan.ply", *WORDS, "-o", "all.npy")
    assert (np.load("all.npy") != wanted).any()
    for name in ("a.npy", "a.nc"):
        done("render-again", name, "-o", "b.npy")
        assert np.load("b.npy").tobytes() == wanted.tobytes()


def test_what_does_not_fit_names_the_option(folder, done, refused, monkeypatch):
    monkeypatch.setattr("omma.scene.surfel_scenes.free_bytes", lambda: 400.0 * 500)
    said = refused("render", "scan.ply", *WORDS, "-o", "a.npy")
    assert "500 would fit; thin them by --scene-voxel-m 0." in said
    option = said.split("--scene-voxel-m ")[1].split()[0]
    done("render", "scan.ply", *WORDS, "--scene-voxel-m", option, "-o", "a.npy")
    said = refused("measure", "aliasing", "scan.ply", "--scene-voxel-m", "0", *WORDS[:2])
    assert "--scene-voxel-m: expected a number above 0" in said


def test_cells_that_leave_too_few_points_name_the_option(folder, done, refused):
    said = refused("render", "scan.ply", *WORDS, "--scene-voxel-m", "5", "-o", "a.npy")
    words = r"--scene-voxel-m: expected cells small enough to leave more than 12 of 4,000 points"
    assert re.search(words + ", found 5, which leaves [124]$", said.strip())
    with pytest.raises(omma.Error, match=r"scan\.ply: voxel_m: expected cells small enough"):
        omma.load_scene("scan.ply", voxel_m=5)
    (folder / "few.xyz").write_text("".join(f"{k} {k * k} 0\n" for k in range(6)))
    for more in ([], ["--scene-voxel-m", "0.1"]):
        said = refused("render", "few.xyz", *WORDS, *more, "-o", "a.npy")
        assert "few.xyz: expected more than 12 points at different places" in said
        assert "--" not in said


def test_the_page_says_it_too():
    seen = Seen(Look(HeadPose((0, 1, 0))), 1, False, None, None, None, None, 0.0)
    sources = Sources("scan.ply", ("e.csv",), scene_voxel_m=CELL_M)
    assert "--scene-voxel-m 0.05" in render_command(sources, seen)[0]
    assert "omma.load_scene('scan.ply', voxel_m=0.05)" in render_python(sources, seen)


def test_a_job_has_it(folder, tmp_path):
    pytest.importorskip("zarr")
    job = write_job(tmp_path / "job", count=4)
    text = job.read_text().replace('"scene.gltf"', '"../scan.ply"\nvoxel_m = 0.05')
    job.write_text(text)
    omma.datasets.run(job, tmp_path / "out.zarr")
    views = omma.datasets.open_views(tmp_path / "out.zarr", ["response", "world_from_head"])
    every = views[list(range(4))]
    renderer = omma.Renderer(
        thinned(folder), omma.load_eye(tmp_path / "job/bug.csv"), omma.Fixed(2)
    )
    wanted = renderer.render(every["world_from_head"])
    assert every["response"].tobytes() == wanted.tobytes()
    job.write_text(text.replace("0.05", "-1"))
    with pytest.raises(omma.Error, match=r"scene\[0\]\.voxel_m: expected a number above 0"):
        omma.datasets.load_job(job)
