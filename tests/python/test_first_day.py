"""Tasks of a first day with Omma, each in a few lines of a user's code, without private names."""

import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import omma

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def meadow():
    return omma.load_scene(EXAMPLES / "meadow.glb")


@pytest.fixture(scope="module")
def bee():
    left = omma.load_eye(EXAMPLES / "honeybee_worker_left.eye")
    right = omma.load_eye(EXAMPLES / "honeybee_worker_right.eye")
    return omma.eye.merge_eyes([left, right])


@pytest.fixture(scope="module")
def small_eye():
    return omma.eye.generate_eye(300)


def test_render_from_a_camera(meadow, bee):
    responses = omma.Renderer(meadow, bee, omma.Fixed(1)).render("bee")
    assert responses.shape == (1, len(bee), 3)
    assert responses.dtype == np.float32


def test_render_from_a_place(meadow, small_eye):
    pose = omma.look_at((0, 1, 2), (0, 1, -5))
    assert omma.Renderer(meadow, small_eye, omma.Fixed(4)).render(pose).mean() > 0


def test_fly_a_path(meadow, small_eye):
    path = omma.load_poses(EXAMPLES / "flight.csv")
    renderer = omma.Renderer(meadow, small_eye, omma.Fixed(1))
    assert renderer.render(path[:20]).shape == (20, 300, 3)


def test_turn_on_the_spot(meadow, small_eye):
    yaw = np.arange(0, 360, 30)
    angles = np.stack([yaw, 0 * yaw, 0 * yaw], axis=1)
    turned = omma.poses_from_angles(np.tile([0.0, 1, 0], (len(yaw), 1)), angles)
    seen = omma.Renderer(meadow, small_eye, omma.Fixed(1)).render(turned)
    assert not np.array_equal(seen[0], seen[3])


def test_error_bars(meadow, small_eye):
    renderer = omma.Renderer(meadow, small_eye, omma.Fixed(4))
    responses, errors = renderer.render("bee", standard_error=True)
    assert errors.shape == responses.shape
    assert (errors >= 0).all()


def test_rays_to_an_error(meadow, small_eye):
    renderer = omma.Renderer(meadow, small_eye, omma.ToError(0.02))
    _, report = renderer.render("bee", report=True)
    assert report.rays.min() >= 8


def test_a_picture_of_what_the_eye_sees(meadow, bee):
    responses = omma.Renderer(meadow, bee, omma.Fixed(1)).render("bee")
    omma.save_png("bee.png", omma.picture.project(bee, responses[0], "mollweide", 400))
    assert Path("bee.png").stat().st_size > 1000


def test_a_picture_of_the_scene(meadow):
    picture = omma.render_camera(meadow, "bee", width=80, samples=1)
    omma.save_png("camera.png", omma.picture.display(picture))
    assert picture.shape[1] == 80


def test_numbers_for_a_spreadsheet(meadow, small_eye):
    responses = omma.Renderer(meadow, small_eye, omma.Fixed(1)).render("bee")
    omma.save_responses("seen.csv", responses, small_eye)
    assert len(Path("seen.csv").read_text().splitlines()) == 301


def test_design_an_eye():
    eye = omma.eye.generate_eye(500, radius_m=0.5e-3)
    omma.save_eye("new.csv", eye)
    assert len(omma.load_eye("new.csv")) == 500


def test_measure_an_eye(bee):
    measures = omma.eye.measure_eye(bee)
    median = np.degrees(np.nanmedian(measures.interommatidial_rad))
    assert 2 < median < 2.6


def test_sharper_eyes(meadow, small_eye):
    sharp = small_eye.replace(acceptance=omma.Acceptance.gaussian(np.radians(2.0)))
    blurred = small_eye.replace(acceptance=omma.Acceptance.gaussian(np.radians(40.0)))
    renderer = omma.Renderer(meadow, sharp, omma.Fixed(64))
    assert renderer.render("bee").std() > renderer.with_eye(blurred).render("bee").std()


def test_what_receptors_answer(meadow, small_eye):
    green = omma.receptors.ReceptorType("green", peak_wavelength_nm=544)
    eye = omma.receptors.assign_receptors(small_eye, omma.receptors.OmmatidiumType("all", (green,)))
    assert omma.Renderer(meadow, eye, omma.Fixed(1)).render_receptors("bee").shape == (1, 300)


def test_bands_of_light(meadow, small_eye):
    world = omma.World(meadow, band_from_rgb=omma.light.band_from_rgb([400, 500, 600, 700]))
    assert omma.Renderer(world, small_eye, omma.Fixed(1)).render("bee").shape == (1, 300, 3)


def test_another_sky(meadow, small_eye):
    white = omma.Background.constant((1, 1, 1))
    high = omma.look_at((0, 500, 0), (0, 1000, 1))
    assert omma.Renderer(meadow, small_eye, omma.Fixed(1), background=white).render(high).max() == 1


def test_two_animals_in_one_world(meadow, small_eye, bee):
    world = omma.World(meadow)
    for eye in (small_eye, bee):
        assert omma.Renderer(world, eye, omma.Fixed(1)).render("bee").shape[1] == len(eye)


def test_something_moves(meadow, small_eye):
    world = omma.World(meadow)
    renderer = omma.Renderer(world, small_eye, omma.Fixed(1))
    before = renderer.render("bee")
    thing = world.instances[0].name
    world.set_transforms(thing, np.diag([1.0, 1, 1, 1]) + np.eye(4, k=3) * 50)
    assert not np.array_equal(renderer.render("bee"), before)


def test_several_threads_of_python(meadow, small_eye):
    renderer = omma.Renderer(meadow, small_eye, omma.Fixed(1))
    poses = omma.load_poses(EXAMPLES / "flight.csv")[:8]
    with ThreadPoolExecutor(2) as pool:
        seen = list(pool.map(renderer.render, poses))
    assert np.array_equal(np.concatenate(seen), renderer.render(poses))


def test_an_animal():
    assert "drosophila" in omma.species.names()
    assert omma.species.facts("drosophila")[0].source.citation


def test_from_file_to_file():
    report = omma.render_file(
        EXAMPLES / "meadow.glb",
        ["bee.npy", "bee.png"],
        omma.Fixed(1),
        eyes=EXAMPLES / "honeybee_worker_left.eye",
    )
    assert np.load("bee.npy").shape[2] == 3
    written = {os.path.basename(name) for name in report.outputs}
    assert written == {"bee.npy", "bee.json", "bee.png"}
