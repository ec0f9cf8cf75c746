"""The speed test: what it counts and writes. How fast anything is, is not asserted."""

import csv

import numpy as np
import pytest
from test_sampling_tools import check_png

import omma
from omma.study.speed_test import PUBLISHED_FRAMES_PER_S, PUBLISHED_RAYS, machine_name


@pytest.fixture(scope="module")
def found(scene, eye):
    stages = []
    result = omma.study.measure_speed(
        scene, eye, np.eye(4), [1, 4], frames=3, warm_up_s=0.01, threads=2,
        progress=lambda stage, fraction: stages.append((stage, fraction)),
    )  # fmt: skip
    return result, stages


def test_speed_of_each_number_of_rays(found, eye):
    result, stages = found
    assert result.rays.tolist() == [1, 4]
    for speeds in (result.frames_per_s, result.batch_frames_per_s):
        assert speeds.shape == (2,)
        assert (speeds > 0).all()
    assert (result.threads, result.ommatidia, result.frames) == (2, len(eye), 3)
    assert "embree" in result.backend
    assert result.machine == machine_name() != ""
    order = list(dict.fromkeys(stage for stage, _ in stages))
    assert order == ["Building the acceleration structure", "Warming up", "1 rays", "4 rays"]


def test_speed_files(found, tmp_path):
    result, _ = found
    omma.study.save_speed_test(tmp_path / "x.csv", result)
    omma.study.save_speed_test(tmp_path / "x.png", result)
    with (tmp_path / "x.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["rays_per_ommatidium"] for row in rows] == ["1", "4"]
    assert rows[0]["machine"] == result.machine
    # Nine digits are written.
    assert float(rows[1]["frames_per_s"]) == pytest.approx(result.frames_per_s[1], rel=1e-8)
    check_png(tmp_path / "x.png")


def test_published_figures_are_complete():
    assert all(len(speeds) == len(PUBLISHED_RAYS) for speeds in PUBLISHED_FRAMES_PER_S.values())


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"frames": 0}, "frames: expected 1"),
        ({"warm_up_s": -1}, "warm_up_s: expected 0"),
        ({"rays": []}, "rays: expected at least one"),
        ({"rays": [0]}, "samples: expected 1"),
        ({"pose": [np.eye(4)] * 2}, r"pose: expected one pose \(4, 4\), found 2"),
    ],
)
def test_wrong_arguments_are_named(scene, eye, changes, message):
    settings = {"pose": np.eye(4), "rays": [1], "frames": 1, "warm_up_s": 0} | changes
    with pytest.raises(omma.Error, match=message):
        omma.study.measure_speed(scene, eye, **settings)


def test_speed_command(omma_command, tmp_path):
    path = tmp_path / "x.csv"
    code, out, err = omma_command(
        "measure", "speed", "scene.gltf", "--eye", "bug.eye", "--rays", "1,2", "--frames", 2,
        "--warm-up", 0, "-o", path,
    )  # fmt: skip
    assert (code, err) == (0, "")
    assert "machine    " in out
    assert "frames/s" in out
    assert len(path.read_text().splitlines()) == 3
    code, _, err = omma_command(
        "measure", "speed", "scene.gltf", "--eye", "bug.eye", "--rays", "1,x"
    )
    assert (code, err) == (
        1, "omma: error: --rays: expected whole numbers separated by commas, found '1,x'\n",
    )  # fmt: skip
