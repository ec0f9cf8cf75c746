"""Motion away from a place, and cells that pool it as LPLC2 do: against closed forms of a disc that
comes nearer, rendered, and of motion that is no looming.
"""

import numpy as np
import pytest

import omma

ARM = np.sin(np.pi / 4) / (np.pi / 4)  # mean of cos over a quarter


@pytest.fixture(scope="module")
def eye():
    """All around, 3,000 ommatidia in one place."""
    return omma.Eye(np.zeros((3000, 3)), omma.eye.generate_eye(3000).axis, 0.05)


def flow_of_disc(eye, size_over_speed_s, time_s, toward):
    """Ground truth of a disc of that l/v, so long before it arrives: (N, 2), and who is on it."""
    speed = 2.0
    distance, radius = speed * time_s, speed * size_over_speed_s
    disc = omma.scene.disc(radius, (0.5, 0.5, 0.5), facing=-toward, segments=720, name="disc")
    world = omma.World(disc)
    place = np.eye(4)
    place[:3, 3] = distance * toward
    world.set_transforms("disc", place)
    renderer = omma.Renderer(world, eye.replace(acceptance_angle_rad=0.0), omma.Fixed(1))
    truth = renderer.ground_truth(
        np.eye(4), shares=["disc"], velocities={"disc": (-speed * toward, np.zeros(3))}
    )
    flow = np.asarray(truth.flow_rad_s, float)[0]
    on = truth.shares[0, :, 0] > 0.5
    flow[~on] = np.nan
    return flow, on


@pytest.mark.parametrize("toward", [(0, 0, -1), (1, 0.3, -0.2), (-0.3, 2, 0.5)])
@pytest.mark.parametrize("time_s", [0.4, 0.1, 0.05])
def test_expansion_is_that_of_a_disc_of_known_size_over_speed(eye, time_s, toward):
    toward = np.array(toward, float) / np.linalg.norm(toward)
    flow, on = flow_of_disc(eye, 0.08, time_s, toward)
    theta = np.arccos(np.clip(eye.axis.astype(float) @ toward, -1, 1))
    # Seen as far as atan(l/v / t), where an edge passes between ommatidia.
    assert np.degrees(theta[on].max()) == pytest.approx(np.degrees(np.arctan(0.08 / time_s)), abs=4)
    expected = np.mean(np.sin(theta[on]) * np.cos(theta[on])) / time_s
    found = omma.motion.expansion(eye, flow, toward, radius_deg=90)
    # Flow is single precision.
    assert found == pytest.approx(expected, rel=1e-5)
    # So 1/t can be read off, which is what tells when it will be there.
    assert found / np.mean(np.sin(2 * theta[on]) / 2) == pytest.approx(1 / time_s, rel=1e-5)


def test_a_cell_in_the_middle_pools_what_its_arms_see(eye):
    toward = np.array([0.6, 0.0, -0.8])
    flow, on = flow_of_disc(eye, 0.08, 0.1, toward)
    cells = omma.motion.looming_cells(eye, [toward])
    theta = np.arccos(np.clip(eye.axis.astype(float) @ toward, -1, 1))
    inside = on & (theta < np.radians(30))
    outward = np.mean(np.sin(theta[inside]) * np.cos(theta[inside])) / 0.1
    arms = cells.arms(flow)
    assert arms.shape == (1, 4)
    # Quarters are alike but for where their ommatidia happen to lie: some 40 in each.
    assert arms[0] == pytest.approx(np.full(4, ARM * outward), rel=0.05)
    assert cells.responses(flow) == pytest.approx(arms.mean(axis=1))
    assert cells.responses(flow, join="product") == pytest.approx(arms.prod(axis=1) ** 0.25)


def radial(eye, center, speed=1.0):
    """Motion straight away from a direction, everywhere of one speed: (N, 2)."""
    axis = eye.axis.astype(float)
    away = axis * (axis @ center)[:, None] - center
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    return speed * np.stack([(away * eye.right).sum(1), (away * eye.up).sum(1)], 1)


def test_motion_straight_away_is_the_mean_of_a_cosine_in_each_arm(eye):
    for center in ((0, 0, -1), (0.0, 1, 0), (0.48, 0.6, 0.64)):
        center = np.array(center, float)
        flow = radial(eye, center)
        assert omma.motion.expansion(eye, flow, center) == pytest.approx(1, abs=1e-6)
        arms = omma.motion.looming_cells(eye, [center]).arms(flow)[0]
        assert arms == pytest.approx(np.full(4, ARM), abs=0.01)
        assert omma.motion.looming_cells(eye, [center]).responses(-flow) == 0  # it goes away


def test_turning_contraction_and_one_direction_are_not_looming(eye):
    center = np.array([0.0, 0, -1])
    cells = omma.motion.looming_cells(eye, [center])
    # A head that turns to the left: all goes to the right, one arm outwards, one inwards.
    renderer = omma.Renderer(omma.scene.box((20, 20, 20)), eye, omma.Fixed(1))
    turning = renderer.ground_truth(np.eye(4), head_velocity=((0, 0, 0), (0, 1.0, 0)))
    arms = cells.arms(turning.flow_rad_s[0])[0]
    assert arms[0] == pytest.approx(-arms[2], rel=0.02)
    assert arms[0] > 0.9
    assert np.abs(arms[[1, 3]]).max() < 0.02
    assert cells.responses(turning.flow_rad_s[0], join="product") == 0
    assert cells.responses(turning.flow_rad_s[0]) < 0.02 * arms[0]
    # Growing one way alone, up and down not at all: half in the sum, nothing in the product.
    wide = radial(eye, center)
    lateral = np.abs(eye.axis[:, 0]) > np.abs(eye.axis[:, 1])
    wide[~lateral] = 0
    assert cells.responses(wide) == pytest.approx(ARM / 2, abs=0.01)
    assert cells.responses(wide, join="product") == 0


def test_an_arms_direction_is_carried_along():
    """Beside the middle's great circles: up at the middle is up all along its meridian, and turned
    by nothing on the way to the right."""
    eye = omma.Eye(np.zeros((2, 3)), [omma.eye.direction(0, 25), omma.eye.direction(25, 0)], 0.05)
    cells = omma.motion.looming_cells(eye, [[0, 0, -1]])
    order = np.argsort(cells.ommatidium)
    assert cells.arm[order].tolist() == [1, 0]
    np.testing.assert_allclose(cells.along[order], [[0, 1], [1, 0]], atol=1e-7)


def test_cells_lie_where_all_four_arms_are_seen():
    fly = omma.species.drosophila().eye
    cells = omma.motion.looming_cells(fly)
    assert 120 < len(cells) < 200  # some 80 on each side
    least = [np.bincount(cells.arm[cells.cell == k], minlength=4).min() for k in range(len(cells))]
    assert min(least) >= 3
    assert np.linalg.norm(cells.center, axis=1) == pytest.approx(1)
    away = np.degrees(np.arccos(np.clip(cells.center @ cells.center.T, -1, 1)))
    np.fill_diagonal(away, 180)
    assert 12 < np.median(away.min(axis=1)) < 18


def test_cells_are_so_many_as_work_can_be_done_for():
    eye = omma.eye.generate_eye(200)
    shares = []
    cells = omma.motion.looming_cells(eye, spacing_deg=6.0, progress=shares.append)
    assert len(cells) > 500
    assert shares[0] == 0
    assert shares[-1] == 1
    assert shares == sorted(shares)

    def stop(share):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        omma.motion.looming_cells(eye, spacing_deg=1.0, progress=stop)
    with pytest.raises(omma.Error, match=r"spacing_deg: expected 1 to 180, found 0\.1"):
        omma.motion.looming_cells(eye, spacing_deg=0.1)
    many = omma.Eye(np.zeros((6000, 3)), np.tile([0, 0, -1.0], (6000, 1)), 0.05)
    with pytest.raises(omma.Error, match=r"spacing_deg: expected at most 268,435,456 pairs"):
        omma.motion.looming_cells(many, spacing_deg=1.0)
    with pytest.raises(omma.Error, match="centers: expected at most 268,435,456 pairs"):
        omma.motion.looming_cells(many, np.tile([0, 0, -1.0], (50_000, 1)))


def test_many_frames_are_the_frames_one_by_one(eye):
    rng = np.random.default_rng(2)
    vectors = rng.normal(size=(3, 2, len(eye), 2))
    vectors[..., ::50, :] = np.nan  # what detectors cannot tell does not count
    cells = omma.motion.looming_cells(eye, [[0, 0, -1], [1, 0, 0]])
    together = cells.responses(vectors)
    assert together.shape == (3, 2, 2)
    one = cells.responses(vectors[1, 0])
    np.testing.assert_allclose(together[1, 0], one, rtol=1e-12)
    spread = omma.motion.expansion(eye, vectors, (0, 0, -1))
    assert spread[2, 1] == pytest.approx(omma.motion.expansion(eye, vectors[2, 1], (0, 0, -1)))
    nothing = np.full((len(eye), 2), np.nan)
    assert np.isnan(omma.motion.expansion(eye, nothing, (0, 0, -1)))
    assert np.isnan(cells.responses(nothing)).all()


def test_a_rendered_disc_that_comes_is_found_where_it_comes_from():
    """Behind a renderer and motion detectors, beside one that goes and a field that turns."""
    fly = omma.species.drosophila().eye
    toward = omma.eye.direction(-50, 5)
    cells = omma.motion.looming_cells(fly, [toward, omma.eye.direction(60, 10)])
    detectors = omma.motion.detector_array(fly, 0.035, 100, high_pass_tau_s=0.25)
    world = omma.World(omma.scene.disc(0.1, (0.02,) * 3, facing=-toward, name="disc"),
                       background=omma.Background.constant((0.5,) * 3))  # fmt: skip
    renderer = omma.Renderer(world, fly, omma.Fixed(16))
    times = np.arange(60) / 100
    frames = np.empty((60, len(fly)))
    for t, time_s in enumerate(times):
        place = np.eye(4)
        place[:3, 3] = 2.0 * (0.65 - time_s) * toward
        world.set_transforms("disc", place)
        frames[t] = renderer.render(np.eye(4))[0, :, 1]
    there = cells.responses(detectors.vectors(detectors.run(frames)))
    away = cells.responses(detectors.vectors(detectors.run(frames[::-1])))
    assert there[50:, 0].mean() > 5 * there[20:40, 0].mean() > 0
    assert there[40:, 1].max() == 0
    assert away[:, 0].max() < 0.1 * there[:, 0].max()


def test_bad_input_is_named(eye):
    vectors = np.zeros((len(eye), 2))
    make, spread = omma.motion.looming_cells, omma.motion.expansion
    cells = make(eye, [[0, 0, -1]])
    for call, said in (
        (lambda: spread(eye, vectors[:5], (0, 0, -1)), r"vectors: expected shape \(..., 3000, 2\)"),
        (lambda: spread(eye, vectors, (0, 0, 0)), "center: expected directions of a length above"),
        (lambda: spread(eye, vectors, (0, 0)), "center: expected shape"),
        (lambda: spread(eye, vectors, (0, 0, -1), radius_deg=200), "radius_deg: expected"),
        (lambda: make(eye, [[0, 0, 0]]), "centers: expected directions"),
        (lambda: make(eye, radius_deg=0), "radius_deg: expected"),
        (lambda: make(eye, spacing_deg=0), "spacing_deg: expected"),
        (lambda: make(omma.Eye(np.zeros((1, 3)), [[0, 0, -1]], 0.1)), "found nowhere"),
        (lambda: cells.responses(vectors[:, :1]), "vectors: expected shape"),
        (lambda: cells.responses(vectors, join="max"), "join: expected one of sum, product"),
        (lambda: omma.motion.LoomingCells(3, [[0, 0, 1]], [0], [4], [0], [[0, 1]]), "arm: expect"),
        (lambda: omma.motion.LoomingCells(3, [[0, 0, 1]], [0], [1], [3], [[0, 1]]), "ommatidium"),
    ):
        with pytest.raises(omma.Error, match=said):
            call()
