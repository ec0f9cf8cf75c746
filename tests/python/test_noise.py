"""The noise of frames is what was asked for, however they are rendered."""

import numpy as np
import pytest
from conftest import make_eye

import omma

FRAMES = 12


@pytest.fixture(scope="module")
def still():
    """One pose, many times: above the middle, where the ground's colours run."""
    pose = np.eye(4)
    pose[1, 3] = 1
    return np.repeat(pose[None], FRAMES, axis=0)


@pytest.fixture(scope="module")
def wide():
    """Fields in which much differs."""
    return make_eye(80, seed=4, acceptance_deg=40)


def in_ways(make, poses):
    """Responses of the poses rendered at once, in a loop, one after another, and in pieces."""
    looping, iterating, receiving = make(), make(), make()
    numbered = make()
    return [
        make().render(poses),
        np.concatenate([looping.render(pose) for pose in poses]),
        np.stack(list(iterating.render_iter(poses, chunk=5))),
        np.concatenate([receiving.render(poses[:5]), receiving.render(poses[5:])]),
        np.concatenate([numbered.render(poses[i : i + 4], first_pose=i) for i in (8, 4, 0)][::-1]),
    ]


@pytest.mark.parametrize("points", ["low_discrepancy", "random"])
@pytest.mark.parametrize("sampling", [omma.Fixed(8), omma.ToError(0.02)])
def test_every_way_of_calling_has_the_same_noise(scene, wide, still, points, sampling):
    def frozen():
        return omma.Renderer(scene, wide, sampling, points=points)

    def new():
        return omma.Renderer(scene, wide, sampling, points=points, noise="new_every_frame")

    assert frozen().settings.noise == "frozen"
    assert new().settings.noise == "new_every_frame"
    expected = frozen().render(still)
    assert (expected == expected[0]).all()
    for found in in_ways(frozen, still):
        assert np.array_equal(found, expected)
    expected = new().render(still)
    assert np.array_equal(expected[0], frozen().render(still[0])[0])
    assert (expected.std(axis=0) > 0).mean() > 0.5
    for found in in_ways(new, still):
        assert np.array_equal(found, expected)


def test_frames_without_a_number_are_counted(scene, wide, still):
    renderer = omma.Renderer(scene, wide, omma.Fixed(8), noise="new_every_frame")
    whole = renderer.render(still)
    assert not np.array_equal(renderer.render(still), whole)
    assert np.array_equal(renderer.render(still, first_pose=0), whole)
    assert np.array_equal(renderer.with_eye(wide).render(still), whole)  # counts by itself
    rays = renderer.render_rays(still[:2], first_pose=3)
    np.testing.assert_allclose(rays.mean(axis=2), whole[3:5], atol=1e-5)


def test_names_and_what_does_not_go_together(scene, wide):
    with pytest.raises(omma.Error, match="noise: expected one of frozen, new_every_frame"):
        omma.Renderer(scene, wide, noise="white")
    with pytest.raises(omma.Error, match="noise: expected frozen where rays are shared"):
        omma.Renderer(scene, wide, omma.Shared(), noise="new_every_frame")


def test_files_have_the_noise_asked_for(files, tmp_path):
    path = tmp_path / "still.csv"
    path.write_text("x,y,z,yaw_deg,pitch_deg,roll_deg\n" + "0,1,0,0,0,0\n" * 6)
    found = {}
    for noise in ("frozen", "new_every_frame"):
        out = tmp_path / f"{noise}.npy"
        omma.render_file(
            files / "scene.gltf", out, omma.Fixed(4), eyes=files / "bug.eye", path=path, noise=noise
        )
        found[noise] = np.load(out)
    assert (found["frozen"] == found["frozen"][0]).all()
    assert np.array_equal(found["new_every_frame"][0], found["frozen"][0])
    assert (found["new_every_frame"].std(axis=0) > 0).any()
    with pytest.raises(omma.Error, match="noise: is for eyes"):
        omma.render_file(
            files / "scene.gltf", tmp_path / "x.npy", camera="plain", noise="new_every_frame"
        )
