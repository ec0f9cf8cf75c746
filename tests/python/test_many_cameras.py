"""The pieces of bench/many_cameras.py: cube maps that are binned into ommatidia, and what pixels of
small cameras count."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import omma

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from cube_maps import binning_matrix, camera_weights, face_poses, pixel_directions
from light_peer import peer_variants
from light_scenes import Setup
from many_cameras import (
    COLUMNS,
    QUICK,
    Way,
    binned,
    blind_to_sun,
    find_truth,
    measure,
    omma_cube,
    omma_rays,
    omma_ways,
    on_the_way,
    print_rows,
)

# Weights are in single precision; some hundred are added up.
ROUNDING = 1e-6
POSE = omma.look_at((0.3, 0.1, -0.2), (1.0, 0.7, 0.4))


@pytest.fixture(scope="module")
def eye():
    """300 axes over all directions, some 12 degrees apart, and on edges and corners of the cube."""
    k = np.arange(300)
    height, azimuth = 1 - (2 * k + 1) / 300, k * np.pi * (3 - np.sqrt(5))
    flat = np.sqrt(1 - height**2)
    even = np.stack([flat * np.cos(azimuth), height, flat * np.sin(azimuth)], axis=-1)
    edges = np.array([[1, 0, -1], [1, 1, -1], [0, -1, 1], [0, 1, 0], [-1, -0.9999, 0.9999]])
    axis = np.concatenate([even, edges])
    return omma.Eye(np.zeros_like(axis), axis, np.radians(3.0))


def white():
    return omma.Background.constant((1, 1, 1))


def lone_square(direction, half_m=0.02):
    """A white square at a distance of 1 m in a direction of the head at POSE, in the dark."""
    towards = POSE[:3, :3] @ direction
    across = np.cross(towards, [0.1, 0.9, 0.3])
    across /= np.linalg.norm(across)
    along = np.cross(towards, across)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half_m
    position = POSE[:3, 3] + towards + corners @ np.stack([across, along])
    mesh = omma.scene.Mesh(
        position, [[0, 1, 2], [0, 2, 3]], texture_coordinates=np.zeros((4, 2)), material=0
    )
    paper = omma.scene.Material(double_sided=True, unlit=True)
    return omma.Scene(meshes=[mesh], materials=[paper])


@pytest.mark.parametrize("size", [4, 16, 50])
def test_weights_add_up_to_1(eye, size):
    matrix = binning_matrix(eye.axis, eye.acceptance_angle_rad, size)
    assert matrix.shape == (len(eye), 6 * size**2)
    assert matrix.data.min() >= 0
    np.testing.assert_allclose(matrix.sum(axis=1), 1, atol=ROUNDING)


def test_solid_angles_are_those_of_the_sphere():
    _, solid_angle = pixel_directions(64)
    # The midpoint rule on faces of 64 x 64.
    assert solid_angle.sum() == pytest.approx(4 * np.pi, rel=1e-4)


def test_a_uniform_surround_gives_its_value(eye):
    world = omma.World(omma.Scene(), background=white(), threads=1)
    seen = binned(eye, 16, omma_cube(world, 16, 1))(POSE, 0)
    np.testing.assert_allclose(seen, 1, atol=ROUNDING)


def test_a_slope_gives_what_the_integral_does(eye):
    # The mean of d · n over a round Gaussian is axis · n times the mean of cos θ.
    normal = np.array([0.36, 0.48, -0.8])
    directions, _ = pixel_directions(64)
    matrix = binning_matrix(eye.axis, eye.acceptance_angle_rad, 64)
    theta = np.linspace(0, np.radians(12), 20_000)
    weight = np.exp(-4 * np.log(2) * (theta / np.radians(3.0)) ** 2) * np.sin(theta)
    expected = eye.axis @ normal * np.average(np.cos(theta), weights=weight)
    # Parts of a pixel at an edge of the reach count or do not.
    np.testing.assert_allclose(matrix @ (directions @ normal), expected, atol=2e-4)


def test_a_bright_pixel_is_seen_by_who_looks_there(eye):
    directions, _ = pixel_directions(64)
    matrix = binning_matrix(eye.axis, eye.acceptance_angle_rad, 64)
    for k, axis in enumerate(eye.axis):
        pixels = np.zeros(len(directions))
        pixels[np.argmax(directions @ axis)] = 1
        assert np.argmax(matrix @ pixels) == k


def test_a_bright_patch_is_seen_by_who_looks_there(eye):
    """Also from a head that is turned and moved, and as bright as rays see it."""
    matrix = binning_matrix(eye.axis, eye.acceptance_angle_rad, 256)
    for k in (*range(0, 300, 60), *range(300, 305)):
        world = omma.World(
            lone_square(eye.axis[k]), background=omma.Background.constant((0, 0, 0)), threads=1
        )
        seen = (matrix @ omma_cube(world, 256, 4)(POSE, 0))[:, 0]
        expected = omma.Renderer(world, eye, omma.Fixed(1024), threads=1).render(POSE)[0, :, 0]
        assert np.argmax(seen) == np.argmax(expected) == k
        # A pixel is up to 0.45° wide, the acceptance angle 3°: at the corner of a pixel the mean
        # sensitivity in it is 0.96 of its peak. Rays and pixels end where the square does not.
        assert 0.95 * expected[k] < seen[k] < 1.03 * expected[k]


def test_faces_are_turns():
    turns = face_poses(np.eye(4))[:, :3, :3]
    np.testing.assert_array_equal(turns @ turns.swapaxes(1, 2), np.tile(np.eye(3), (6, 1, 1)))
    np.testing.assert_array_equal(np.linalg.det(turns), 1)


def test_camera_pixels_count_by_the_sensitivity():
    weights, fov_rad = camera_weights(np.radians([2.0, 5.0]), 6, 3.0)
    np.testing.assert_allclose(weights.sum(axis=(1, 2)), 1, atol=ROUNDING)
    np.testing.assert_allclose(weights, weights[:, ::-1], atol=ROUNDING)
    np.testing.assert_allclose(weights, weights.swapaxes(1, 2), atol=ROUNDING)
    np.testing.assert_allclose(np.degrees(fov_rad), np.array([2, 5]) * 6 / 2.3548, rtol=1e-4)
    # Pixels are a standard deviation wide, so that the row is read at 0.5, 1.5 and 2.5 of them; the
    # tangent of 6 degrees makes less than 0.001 of it.
    row = np.exp(-(np.array([0.5, 1.5, 2.5]) ** 2) / 2)
    np.testing.assert_allclose(weights.sum(axis=1)[:, 2], row[0] / row.sum() / 2, atol=1e-3)


def test_who_looks_at_the_sun_is_left_out(eye):
    light = omma.light.clear_sky(30, sun_azimuth_deg=135)
    blind = blind_to_sun(eye, POSE, light)
    axis = blind.axis @ POSE[:3, :3].T
    apart = np.degrees(np.arccos(axis @ light.discs[0].direction))
    assert apart.min() > 12
    assert 0 < len(eye) - len(blind) < 10


def test_errors_are_told_apart(eye):
    """Of a cube map with wide pixels the rest of the error is its width."""
    world = omma.World(lone_square(eye.axis[7], 0.1), background=white(), threads=1)
    truth = find_truth(world, eye, POSE, 256)
    cube = binned(eye, 8, omma_cube(world, 8, 64))
    wide = Way("wide", "", 0, lambda: cube, lambda pose: cube(pose, 0))
    _, _, found = measure(wide, truth, POSE, 1)
    assert found["noise"] == found["place"] == 0
    assert found["bias"] == pytest.approx(found["error"], rel=0.05)
    fine = Way("rays", "", 0, lambda: omma_rays(world, eye, omma.Fixed(256)))
    _, _, found = measure(fine, truth, POSE, 1)
    assert found["error"] < 0.1 * rms_of_wide(cube, truth)


def rms_of_wide(cube, truth):
    return np.sqrt(np.mean((cube(POSE, 0) - truth.seen) ** 2))


def test_the_table(eye, capsys):
    world = omma.World(lone_square(eye.axis[7], 0.3), background=white(), threads=1)
    few = eye.take(range(20))
    amounts = replace(QUICK, many_rays=10_000)
    ways = list(omma_ways(world, few, amounts))
    truth = find_truth(world, few, POSE, 8)
    print_rows("unlit", "few", Setup("square", world.scene, few, POSE), ways, truth, 1)
    rows = [line.split(",") for line in capsys.readouterr().out.replace(", ", " ").splitlines()]
    assert len(rows) == 1 + len(ways)
    assert {len(row) for row in rows} == {len(COLUMNS.split(","))}
    assert all(float(row[8]) > 0.9 for row in rows)


def test_the_head_moves_on():
    moved = on_the_way(POSE, 3)
    assert np.linalg.norm(moved[:3, 3] - POSE[:3, 3]) == pytest.approx(0.015)
    assert np.degrees(np.arccos(moved[:3, 2] @ POSE[:3, 2])) == pytest.approx(3.0)


@pytest.mark.skipif(not peer_variants(), reason="needs Mitsuba and libLLVM (DRJIT_LIBLLVM_PATH)")
def test_mitsuba_sees_the_same(eye):
    from small_cameras import CubeOfCameras, EyeOfCameras, PeerWorld, RaysOfEye

    scene = lone_square(eye.axis[7], 0.1)
    world = omma.World(scene, background=omma.Background.constant((0, 0, 0)), threads=1)
    expected = omma.Renderer(world, eye, omma.Fixed(1024)).render(POSE)[0, :, 0]
    light = omma.light.uniform_sky(bands=omma.light.Bands.equal(3, 400, 700))
    peer = PeerWorld(scene, light, "unlit")
    ways = (
        EyeOfCameras(peer, eye, 8, 16).see,
        binned(eye, 64, CubeOfCameras(peer, 64, 16).see),
        RaysOfEye(peer, eye, 1024).see,
    )
    for see in ways:
        for pose in (on_the_way(POSE, 5), POSE):
            seen = see(pose, 0)[:, 0]
        # Where the square ends random rays differ, by 1/2 over their root at most; and pixels.
        np.testing.assert_allclose(seen, expected, atol=0.05)
