"""Bodies on the ground, `place_on`, `walk_on` and `ground_at` of `omma.motion`: against planes, a
sphere, a field of heights, steps and holes, on both backends."""

import warnings

import numpy as np
import pytest

import omma
from omma import scene as solids
from omma.motion import Track, ground_at, place_on, walk_on
from omma.motion.ground_rays import ray_bundle

BACKENDS = ("embree", "portable")
HEIGHT_M = 0.003
FLOOR = solids.plane((20, 20), name="floor")
# UTM: metres east and north of a zone's corner.
FAR_M = (512_345.0, 431.0, -5_403_210.0)


@pytest.fixture(params=BACKENDS)
def world_of(request):
    def make(*scenes):
        try:
            return omma.World(solids.merge_scenes(scenes), backend=request.param)
        except omma.Error as error:
            pytest.skip(str(error))

    return make


def assert_rigid(poses):
    turn = poses[:, :3, :3]
    squares = turn.transpose(0, 2, 1) @ turn
    np.testing.assert_allclose(squares, np.broadcast_to(np.eye(3), squares.shape), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(turn), 1, atol=1e-12)


def angles_deg(poses):
    """Yaw, pitch and roll (3, P), as `omma.poses_from_angles` takes them."""
    ahead = -poses[:, :3, 2]
    yaw = np.arctan2(ahead[:, 0], -ahead[:, 2])
    return np.degrees([yaw, np.arcsin(ahead[:, 1]), np.arctan2(-poses[:, 1, 0], poses[:, 1, 1])])


@pytest.mark.parametrize("middle_m", [(0, 0, 0), FAR_M])
@pytest.mark.parametrize("legs_m", [None, [(0.0, 0.004), (0.003, -0.002), (-0.003, -0.002)]])
def test_on_a_tilted_plane_pitch_and_roll_are_its_own(world_of, middle_m, legs_m):
    slope = omma.poses_from_angles(middle_m, (0, 24, -13))[0]
    world = world_of(solids.place_scene(FLOOR, slope))
    rng = np.random.default_rng(1)
    xz = np.array(middle_m)[[0, 2]] + rng.uniform(-6, 6, (300, 2))
    heading = rng.uniform(-180, 180, 300)
    poses = place_on(world, xz, height_m=HEIGHT_M, heading_deg=heading, legs_m=legs_m)
    assert_rigid(poses)
    # 20 m of one triangle, in single precision: 1e-6.
    normal = slope[:3, 1]
    np.testing.assert_allclose(poses[:, :3, 1], np.tile(normal, (300, 1)), atol=1e-6)
    np.testing.assert_allclose((poses[:, :3, 3] - middle_m) @ normal, HEIGHT_M, atol=4e-6)
    yaw, pitch, roll = angles_deg(poses)
    np.testing.assert_allclose(yaw, heading, atol=1e-9)
    ahead = np.column_stack(
        [np.sin(np.radians(heading)), np.zeros(300), -np.cos(np.radians(heading))]
    )
    rise = -(ahead @ normal) / normal[1]
    np.testing.assert_allclose(np.radians(pitch), np.arctan(rise), atol=1e-4)
    again = omma.poses_from_angles(poses[:, :3, 3], np.column_stack([yaw, pitch, roll]))
    np.testing.assert_allclose(again, poses, atol=1e-9)
    # Up from the foot along the normal: the head is not above the point itself.
    shift = poses[:, [0, 2], 3] - xz
    np.testing.assert_allclose(shift, np.tile(HEIGHT_M * normal[[0, 2]], (300, 1)), atol=1e-8)


def test_a_point_beside_the_ground_is_told_once_and_no_poses():
    for call in (
        lambda: place_on(FLOOR, (5000, 0), height_m=HEIGHT_M),
        lambda: walk_on(FLOOR, [(5000, 0), (5001, 0)], height_m=HEIGHT_M),
    ):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with pytest.raises(omma.Error, match="no ground below"):
                call()


def test_names_of_ground_are_those_of_things(world_of):
    ball = solids.sphere(1, center_m=(0, 1, 0), name="ball")
    world = world_of(FLOOR, ball)
    on_floor = place_on(world, (0, 0), height_m=HEIGHT_M, on="floor")
    assert (on_floor == place_on(world, (0, 0), height_m=HEIGHT_M, on=["floor"])).all()
    assert (on_floor == place_on(world, (0, 0), height_m=HEIGHT_M, on=["floor", "floor"])).all()
    for wrong in (3, [0], [None]):
        with pytest.raises(TypeError, match=r"^on: expected names of instances, found"):
            place_on(world, (0, 0), height_m=HEIGHT_M, on=wrong)
    heads = on_floor.copy()
    heads[:, 1, 3] = 3
    assert ground_at(world, heads, on="floor").height_m == pytest.approx(3)
    for call in (
        lambda: place_on(world, (0, 0), height_m=HEIGHT_M, on="flor"),
        lambda: walk_on(world, [(0, 0), (1, 0)], height_m=HEIGHT_M, on=("ball", "flor")),
        lambda: ground_at(world, heads, on=["flor"]),
    ):
        with pytest.raises(omma.Error, match=r"^on: expected the name of a thing .*'floor'"):
            call()


def field(rng, cells=40, cell_m=0.05):
    """Heights that are a sum of a function of x and one of z: two triangles of a cell are then in
    one plane, and bilinear interpolation is what the mesh is."""
    line = (np.arange(cells + 1) - cells / 2) * cell_m
    of_x, of_z = rng.uniform(-0.01, 0.01, (2, cells + 1))
    x, z = np.meshgrid(line, line, indexing="ij")
    points = np.stack([x, of_x[:, None] + of_z[None], z], axis=-1).reshape(-1, 3)
    first = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    a, b, c, d = first, first + 1, first + cells + 2, first + cells + 1
    triangles = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    scene = omma.Scene(meshes=[solids.Mesh(points, triangles)])
    return scene, lambda x, z: np.interp(x, line, of_x) + np.interp(z, line, of_z)


def by_hand(height, x, z, heading_deg, legs):
    """One pose, the slow way: its normal and its head."""
    yaw = np.radians(heading_deg)
    at_x = x + legs[:, 0] * np.cos(yaw) + legs[:, 1] * np.sin(yaw)
    at_z = z + legs[:, 0] * np.sin(yaw) - legs[:, 1] * np.cos(yaw)
    rows = np.column_stack([np.ones(len(legs)), at_x - x, at_z - z])
    middle, by_x, by_z = np.linalg.lstsq(rows, height(at_x, at_z), rcond=None)[0]
    normal = np.array([-by_x, 1, -by_z]) / np.linalg.norm([by_x, 1, by_z])
    return normal, np.array([x, max(middle, height(x, z)), z]) + 0.05 * normal


@pytest.mark.parametrize("middle_m", [(0, 0, 0), FAR_M])
def test_on_a_field_of_heights_as_bilinear_interpolation_says(world_of, middle_m):
    rng = np.random.default_rng(2)
    scene, height = field(rng)
    world = world_of(solids.place_scene(scene, omma.poses_from_angles(middle_m, (0, 0, 0))[0]))
    legs = np.array([(s, a) for s in (-0.05, 0.05) for a in (0.075, 0.0, -0.075)])
    xz, heading = rng.uniform(-0.8, 0.8, (200, 2)), rng.uniform(-180, 180, 200)
    poses = place_on(
        world, xz + np.array(middle_m)[[0, 2]], height_m=0.05, heading_deg=heading,
        legs_m=(0.15, 0.1),
    )  # fmt: skip
    assert_rigid(poses)
    for pose, (x, z), turned in zip(poses, xz, heading):
        normal, head = by_hand(height, x, z, turned, legs)
        # Coordinates of a metre in single precision: 1e-7 m, over legs 0.1 m apart.
        np.testing.assert_allclose(pose[:3, 1], normal, atol=3e-6)
        np.testing.assert_allclose(pose[:3, 3] - middle_m, head, atol=1e-6)


def test_on_a_sphere_the_normal_is_the_radius(world_of):
    ball = solids.sphere(1.0, segments=512)
    rng = np.random.default_rng(3)
    xz = rng.uniform(-0.5, 0.5, (200, 2))
    poses = place_on(world_of(ball), xz, height_m=0.02, heading_deg=rng.uniform(-180, 180, 200))
    # Faces are 0.012 m long and so tilted by up to 0.006; the chord below the legs, 0.06 m, is
    # tilted from the tangent by its square over 6, times the third derivative: below 0.004. Faces
    # lie within the sphere by up to 2e-5.
    radius = np.column_stack([xz[:, 0], np.sqrt(1 - (xz**2).sum(axis=1)), xz[:, 1]])
    np.testing.assert_allclose(poses[:, :3, 1], radius, atol=0.01)
    # The ground in the middle is above the plane of the legs: it is what the head is above.
    foot = poses[:, :3, 3] - 0.02 * poses[:, :3, 1]
    np.testing.assert_allclose(np.linalg.norm(foot, axis=1), 1, atol=4e-5)


def test_across_a_step(world_of):
    step_m, length_m = 0.02, 0.1
    stairs = solids.box((4, step_m, 4), center_m=(2, step_m / 2, 0), name="step")
    pose = place_on(
        world_of(FLOOR, stairs), (-0.02, 0), height_m=0.05, heading_deg=90, legs_m=(length_m, 0.06)
    )
    # The two legs ahead are on the step: the mean height is a third of it, the slope of the least
    # squares 2 (l/2) s / (4 (l/2)²).
    _, pitch, roll = angles_deg(pose)
    np.testing.assert_allclose(np.radians(pitch), np.arctan(step_m / length_m), atol=1e-4)
    np.testing.assert_allclose(roll, 0, atol=1e-3)
    foot = pose[0, :3, 3] - 0.05 * pose[0, :3, 1]
    np.testing.assert_allclose(foot, [-0.02, step_m / 3, 0], atol=1e-6)


def slab(x, z, name="slab"):
    """From the first to the second of x and of z, its upper side at y = 1."""
    size, middle = (x[1] - x[0], 0.1, z[1] - z[0]), ((x[0] + x[1]) / 2, 0.95, (z[0] + z[1]) / 2)
    return solids.box(size, center_m=middle, name=name)


def test_a_small_hole_is_bridged_and_a_large_one_is_not(world_of):
    around = [slab((-2, -0.01), (-2, 2)), slab((0.01, 2), (-2, 2))]
    around += [slab((-0.01, 0.01), (-2, -0.01)), slab((-0.01, 0.01), (0.01, 2))]
    for below in ([], [FLOOR]):
        world = world_of(*around, *below)
        pose = place_on(world, (0, 0), height_m=0.05, legs_m=(0.1, 0.1))
        np.testing.assert_allclose(pose[0, :3, 1], [0, 1, 0], atol=1e-6)
        np.testing.assert_allclose(pose[0, 1, 3], 1.05, atol=1e-6)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        small = place_on(world, (0, 0), height_m=0.002)
    np.testing.assert_allclose(small[0, 1, 3], 0.002, atol=1e-6)


def test_legs_over_an_edge_are_left_out_and_counted(world_of):
    world = world_of(slab((-1, 1), (-1, 1)))
    two = [(0.9, 0), (0, 0)]
    with pytest.warns(
        UserWarning, match=r"2 of 12 legs reach no ground, at 1 of 2 points.* at 0 fewer"
    ):
        poses = place_on(world, two, height_m=0.1, heading_deg=90, legs_m=(0.3, 0.2))
    np.testing.assert_allclose(poses[:, :3, 1], [[0, 1, 0]] * 2, atol=1e-6)
    # Two legs behind are left, or three in a line: the ground in the middle says how to stand.
    tilted = solids.place_scene(
        slab((-1, 1), (-1, 1)), omma.poses_from_angles((0, 0, 0), (0, 0, 20))[0]
    )
    edge = world_of(tilted)
    x = np.cos(np.radians(20)) + np.sin(np.radians(20)) - 0.01
    for legs in ((0.4, 0.2), (0.2, 0.2)):
        turned = 90 if legs[0] > 0.3 else 0
        with pytest.warns(UserWarning, match="at 1 fewer than three|at 0 fewer"):
            pose = place_on(edge, (x, 0), height_m=0.1, heading_deg=turned, legs_m=legs)
        expected = omma.poses_from_angles((0, 0, 0), (0, 0, 20))[0, :3, 1]
        np.testing.assert_allclose(pose[0, :3, 1], expected, atol=1e-6)


def test_ground_far_below_an_edge_is_out_of_reach_at_any_coordinates(world_of):
    ledge = solids.merge_scenes([slab((-1, 1), (-1, 1)), FLOOR])
    world = world_of(solids.place_scene(ledge, omma.poses_from_angles(FAR_M, (0, 0, 0))[0]))
    at = (FAR_M[0] + 0.9, FAR_M[2])
    with pytest.warns(UserWarning, match="2 of 6 legs"):
        pose = place_on(world, at, height_m=0.1, heading_deg=90, legs_m=(0.3, 0.2))
    np.testing.assert_allclose(pose[0, :3, 1], [0, 1, 0], atol=1e-6)


def test_on_a_post_that_no_leg_reaches(world_of):
    world = world_of(FLOOR, solids.box((0.001, 2, 0.001), center_m=(0, 1, 0)))
    with pytest.warns(UserWarning, match="at 1 fewer than three"):
        pose = place_on(world, (0, 0), height_m=0.01)
    np.testing.assert_allclose(pose[0, :3, 3], [0, 2.01, 0], atol=1e-6)


def test_where_there_is_no_ground(world_of):
    world = world_of(slab((-1, 1), (-1, 1)))
    points = np.column_stack([np.linspace(0.5, 3.5, 31), np.zeros(31)])
    with pytest.raises(
        omma.Error, match=r"no ground below 25 of 31 points: 6 \(x 1\.1, z 0\), .* and 20 more"
    ):
        place_on(world, points, height_m=0.01)
    with pytest.raises(omma.Error, match=r"no ground below 1 of 2 points: 1 \(x 5, z 0\)"):
        ground_at(world, omma.poses_from_angles([(0, 2, 0), (5, 2, 0)], (0, 0, 0)))
    with pytest.raises(omma.Error, match="no surfaces"):
        place_on(omma.Scene(), (0, 0), height_m=0.01)


def test_points_beside_the_scene_are_told_where_it_lies():
    """A survey in UTM, z up in the file: x is the easting, z the northing's negative."""
    east, north, up = 389_123.25, 5_819_456.5, 112.25
    at = np.eye(4)
    at[:3, 3] = east, up, -north
    survey = omma.World(solids.place_scene(solids.plane((20, 10)), at))
    says = r"the scene lies at x 389113\.25 to 389133\.25, z -5819461\.5 to -5819451\.5"
    with pytest.raises(omma.Error, match=f"{says}, where these are with z of the other sign"):
        place_on(survey, (east, north), height_m=0.003)
    with pytest.raises(omma.Error, match=f"{says}$"):
        place_on(survey, (0, 0), height_m=0.003)
    # Where a point is in that range the ground may have a hole, or face down.
    with pytest.raises(omma.Error, match=f"{says}; single-sided surfaces that face down"):
        place_on(survey, (east, -north), height_m=0.003, from_m=100.0)
    pose = place_on(survey, (east, -north), height_m=0.003)
    assert pose[0, :3, 3] == pytest.approx([east, up + 0.003, -north], abs=1e-5)


def test_leaves_are_stood_on_where_they_are_not_cut_out(world_of):
    """A leaf of two squares, of which one is cut out."""
    alpha = np.full((8, 16, 4), 255, np.uint8)
    alpha[:, 8:, 3] = 0
    leaf = solids.Mesh(
        [(-1, 0.5, -1), (-1, 0.5, 1), (1, 0.5, 1), (1, 0.5, -1)],
        [(0, 1, 2), (0, 2, 3)],
        texture_coordinates=[(0, 0), (0, 1), (1, 1), (1, 0)],
        material=0,
    )
    green = solids.Material("leaf", base_color_texture=0, alpha_mode="mask")
    foliage = omma.Scene(
        meshes=[leaf], materials=[green], images=[solids.Image(alpha)], textures=[solids.Texture(0)]
    )
    poses = place_on(world_of(FLOOR, foliage), [(-0.5, 0), (0.5, 0)], height_m=0.01)
    np.testing.assert_allclose(poses[:, 1, 3], [0.51, 0.01], atol=1e-6)


def test_below_a_roof_and_through_what_is_no_ground(world_of):
    roof = solids.box((8, 0.1, 8), center_m=(0, 3, 0), name="roof")
    leaf = solids.plane((8, 8), center_m=(0, 0.001, 0), name="leaf")
    world = world_of(FLOOR, roof, leaf)
    rng = np.random.default_rng(4)
    xz, heading = rng.uniform(-3, 3, (50, 2)), rng.uniform(-180, 180, 50)

    def heights(**where):
        return place_on(world, xz, height_m=0.01, heading_deg=heading, **where)[:, 1, 3]

    np.testing.assert_allclose(heights(), 3.06, atol=1e-6)
    np.testing.assert_allclose(heights(from_m=2), 0.011, atol=1e-6)
    np.testing.assert_allclose(heights(on=["floor"]), 0.01, atol=1e-6)
    np.testing.assert_allclose(heights(on=["floor", "leaf"]), 0.011, atol=1e-6)
    np.testing.assert_allclose(heights(on=["floor"], from_m=0.0005), 0.01, atol=1e-6)
    with pytest.raises(omma.Error, match=r"floor"):
        heights(on=["flor"])


def test_things_are_where_they_are_now(world_of):
    box = solids.box((1, 1, 1), center_m=(0, 0.5, 0), name="box")
    world = world_of(FLOOR, box)
    up = omma.poses_from_angles((3, 50, 0), (0, 0, 0))[0]
    world.set_transforms("box", up)
    poses = place_on(world, [(0, 0), (3, 0)], height_m=0.01)
    np.testing.assert_allclose(poses[:, 1, 3], [0.01, 50.51], atol=1e-5)
    tall = next(k for k, mesh in enumerate(world.scene.meshes) if mesh.name.startswith("box"))
    world.set_vertices(tall, world.vertices(tall) * (1, 200, 1))
    taller = place_on(world, (3, 0), height_m=0.01)
    np.testing.assert_allclose(taller[0, 1, 3] - 0.01, 50 + 200 * 0.5, atol=1e-4)


def test_large_bodies_are_no_eyes_to_warn_of():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pose = place_on(FLOOR, (0, 0), height_m=0.7)
    np.testing.assert_allclose(pose[0, :3, 3], [0, 0.7, 0], atol=1e-6)


def test_slopes_and_obstacles(world_of):
    slope = omma.poses_from_angles((0, 0, 0), (0, 20, 0))[0]  # uphill along -Z
    wall = solids.box((20, 20, 1), center_m=(0, 0, -5.5))
    world = world_of(solids.place_scene(FLOOR, slope), wall)
    heads = omma.poses_from_angles([(0, 0.5, 0)] * 3, [(0, 30, 0), (180, 0, 0), (90, 0, 0)])
    there = ground_at(world, heads)
    np.testing.assert_allclose(there.height_m, 0.5, atol=1e-6)
    np.testing.assert_allclose(there.slope_deg, 20, atol=1e-4)
    np.testing.assert_allclose(there.climb_deg, [20, -20, 0], atol=1e-4)
    np.testing.assert_allclose(
        there.ahead_m, [5 / np.cos(np.radians(30)), np.inf, np.inf], rtol=1e-5
    )
    leaf = solids.plane((4, 4), center_m=(0, 0.4, 0), name="leaf")
    leafy = world_of(solids.place_scene(FLOOR, slope), leaf)
    assert ground_at(leafy, heads).height_m == pytest.approx([0.1] * 3)
    below = ground_at(leafy, heads, on=["floor"])
    np.testing.assert_allclose(below.height_m, 0.5, atol=1e-6)
    np.testing.assert_allclose(below.slope_deg, 20, atol=1e-4)
    walking = place_on(world, [(0, 0), (0, 1)], height_m=0.1)
    ahead = ground_at(world, walking)
    np.testing.assert_allclose(ahead.climb_deg, 20, atol=1e-4)
    z = walking[:, 2, 3]
    np.testing.assert_allclose(ahead.ahead_m, (z + 5) / np.cos(np.radians(20)), rtol=1e-5)


@pytest.mark.parametrize("on", [(), ("land", "path", "verges")])
def test_ants_in_the_meadow_are_above_its_ground(on):
    world = omma.World(omma.load_scene(omma.examples.meadow()))
    track = Track(np.array([(-2, 3), (0, 0), (1.5, -1), (1, -3)])).at_speed(0.1, step_s=0.1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        poses = walk_on(world, track, height_m=HEIGHT_M, on=on)
    assert len(poses) > 700
    assert_rigid(poses)
    heads = np.tile(np.eye(4), (len(poses), 1, 1))
    heads[:, :3, 3] = poses[:, :3, 3]
    ground = ["land", "path", "verges"]
    up = ray_bundle(world, [[0, 1, 0]]).ground_truth(heads, shares=ground)
    assert not up.shares.any()
    if on:
        below = place_on(world, heads[:, [0, 2], 3], height_m=HEIGHT_M, on=on)
        clear = poses[:, 1, 3] - (below[:, 1, 3] - HEIGHT_M * below[:, 1, 1])
        assert 0.5 * HEIGHT_M < clear.min() <= clear.max() < 2 * HEIGHT_M


def moss(tilt_deg, count=12_000):
    """Flat splats, opaque but for 5 %, on the plane through the origin that rises along -Z."""
    rng = np.random.default_rng(5)
    at = np.column_stack([rng.uniform(-1, 1, count), np.zeros(count), rng.uniform(-1, 1, count)])
    half = np.radians(tilt_deg) / 2
    turn = omma.poses_from_angles((0, 0, 0), (0, tilt_deg, 0))[0, :3, :3]
    return omma.Scene(
        splats=[
            solids.SplatCloud(
                at @ turn.T,
                np.tile((0.03, 1e-5, 0.03), (count, 1)),
                np.tile((np.sin(half), 0, 0, np.cos(half)), (count, 1)),
                np.full(count, 0.95),
                np.zeros((count, 1, 3)),
                name="moss",
            )
        ]
    )


@pytest.mark.parametrize("on", [(), ("moss",)])
def test_on_gaussian_splats_by_where_half_of_the_light_is(world_of, on):
    """Splats are as thick as the engine takes them, 1e-4 of their size: heights are within 10 um,
    on legs 6 cm apart."""
    world = world_of(moss(12.0), solids.plane((4, 4), center_m=(0, -2, 0)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        poses = place_on(
            world, [(0.1, 0.2), (-0.3, 0.1)], height_m=0.03, heading_deg=[0, 90], on=on
        )
    assert_rigid(poses)
    _, pitch, roll = angles_deg(poses)
    assert pitch == pytest.approx([12, 0], abs=0.02)
    assert roll == pytest.approx([0, 12], abs=0.02)  # the left, towards -Z, is higher
    up = np.array([0, np.cos(np.radians(12)), np.sin(np.radians(12))])
    assert poses[:, :3, 3] @ up == pytest.approx(0.03, abs=1e-4)
    there = ground_at(world, poses)
    assert there.height_m == pytest.approx(0.03 / np.cos(np.radians(12)), abs=1e-4)
    assert np.isnan(there.slope_deg).all()
    assert np.isnan(there.climb_deg).all()
    # Heights within 10 um, 5 cm apart: 0.02°.
    sloping = ground_at(world, poses, on=on, splat_span_m=0.05)
    assert sloping.slope_deg == pytest.approx(12, abs=0.05)
    assert sloping.climb_deg == pytest.approx([12, 0], abs=0.05)
    assert sloping.height_m.tolist() == there.height_m.tolist()
    # Beyond the edge of the moss is the floor, or nothing that is asked for.
    edge = omma.look_at((0.98, 0.5, 0), (0.98, 0.5, -1))
    (beyond,) = ground_at(world, edge, on=on, splat_span_m=0.2).slope_deg
    assert np.isnan(beyond) if on else beyond > 80


def test_surfaces_keep_their_normals_beside_splats(world_of):
    world = world_of(moss(12.0, 3000), solids.plane((1, 1), center_m=(5, 0, 0)))
    heads = [omma.look_at((x, 0.5, 0), (x, 0.5, -1)) for x in (5.0, 0.0)]
    there = ground_at(world, heads, splat_span_m=0.1)
    assert there.slope_deg == pytest.approx([0, 12], abs=0.05)
    with pytest.raises(omma.Error, match="splat_span_m: expected a number above 0"):
        ground_at(world, heads, splat_span_m=0)


def test_upright_on_a_splat_that_no_leg_reaches(world_of):
    one = solids.SplatCloud(
        [(0, 0, 0)], [(0.001, 0.001, 0.001)], [(0, 0, 0, 1)], [1.0], np.zeros((1, 1, 3))
    )
    with pytest.warns(UserWarning, match="6 of 6 legs reach no ground"):
        pose = place_on(world_of(omma.Scene(splats=[one])), (0, 0), height_m=0.01)[0]
    assert pose[:3, :3] == pytest.approx(np.eye(3))
    assert pose[1, 3] == pytest.approx(0.01, abs=0.002)


@pytest.mark.parametrize(
    ("match", "arguments"),
    [
        (r"xz_m: expected shape \(P, 2\)", {"xz_m": [(0, 0, 0)]}),
        ("xz_m: expected finite numbers, found .* in row 1", {"xz_m": [(0, 0), (0, np.nan)]}),
        ("height_m: expected a number above 0", {"height_m": 0}),
        ("heading_deg: expected one finite number or 1", {"heading_deg": [1, 2]}),
        ("legs_m: expected a length and a width above 0", {"legs_m": (0.1, 0)}),
        ("legs_m: .* with three legs or more", {"legs_m": [(0, 0), (1, 1)]}),
        ("legs_m: .* not all in a line", {"legs_m": [(0, 0), (1, 1), (2, 2)]}),
        ("from_m: expected a finite number", {"from_m": np.inf}),
    ],
)
def test_what_is_refused(match, arguments):
    with pytest.raises(omma.Error, match=match):
        place_on(FLOOR, **({"xz_m": (0, 0), "height_m": 0.01} | arguments))
