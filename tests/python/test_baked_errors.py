"""How far baked light says that it is off, and how far it is: many bakes of small scenes, each with
random numbers of its own, whose spread is what standard errors claim.
"""

from dataclasses import replace

import numpy as np
import pytest
from lit_checks import BAND, eyes_at, matter

import omma
from omma.light import uniform_sky
from omma.scene import Bake, Instance, Mesh

SKY = uniform_sky(1.0, below=0.2, bands=BAND)
BAKES = 5


def grass(blades=150, half_m=0.5):
    """Upright triangles at random on a square of ground."""
    rng = np.random.default_rng(3)
    at = rng.uniform(-half_m, half_m, (blades, 2))
    angle, height = rng.uniform(0, np.pi, blades), rng.uniform(0.05, 0.15, blades)
    across = 0.01 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    corners = np.zeros((blades, 3, 3))
    corners[:, 0, ::2], corners[:, 1, ::2], corners[:, 2, ::2] = at - across, at + across, at
    corners[:, 2, 1] = height
    h = half_m
    ground = Mesh(
        [[-h, 0, h], [h, 0, h], [h, 0, -h], [-h, 0, -h]], [[0, 1, 2], [0, 2, 3]], material=0
    )
    leaves = Mesh(corners.reshape(-1, 3), np.arange(3 * blades).reshape(-1, 3), material=1)
    return omma.Scene(
        meshes=[ground, leaves],
        materials=[matter(0.3), matter(0.3)],
        instances=[Instance(0, name="ground"), Instance(1, name="grass")],
    )


def closed_room():
    """A box of 4 x 4 x 2 m with a hole in its lid, which is all that light comes through."""
    walls = []
    for corner, along, up in (
        ((-2, 0, 2), (4, 0, 0), (0, 0, -4)),
        ((-2, 0, -2), (4, 0, 0), (0, 2, 0)),
        ((2, 0, 2), (-4, 0, 0), (0, 2, 0)),
        ((-2, 0, 2), (0, 0, -4), (0, 2, 0)),
        ((2, 0, -2), (0, 0, 4), (0, 2, 0)),
        ((-2, 2, -2), (4, 0, 0), (0, 0, 1.5)),
        ((-2, 2, 0.5), (4, 0, 0), (0, 0, 1.5)),
        ((-2, 2, -0.5), (1.5, 0, 0), (0, 0, 1)),
        ((0.5, 2, -0.5), (1.5, 0, 0), (0, 0, 1)),
    ):
        one, first, second = (np.array(each, float) for each in (corner, along, up))
        quad = [one, one + first, one + first + second, one + second]
        walls.append(Mesh(quad, [[0, 1, 2], [0, 2, 3]], material=0))
    return omma.Scene(
        meshes=walls,
        materials=[matter(0.6)],
        instances=[Instance(k, name=f"wall {k}") for k in range(len(walls))],
    )


def looking_down(count, height_m, half_m):
    """An eye over the middle, whose ommatidia look at the ground."""
    rng = np.random.default_rng(5)
    at = np.column_stack(
        [rng.uniform(-half_m, half_m, count), np.full(count, -height_m),
         rng.uniform(-half_m, half_m, count)]
    )  # fmt: skip
    axis = at / np.linalg.norm(at, axis=1, keepdims=True)
    position = np.tile([0, height_m, 0], (count, 1))
    return omma.Eye(position, axis, acceptance_angle_rad=np.full(count, 0.04))


def around(count):
    """An eye in the middle of the room that looks everywhere but up."""
    axis = np.random.default_rng(6).normal(size=(count, 3))
    axis[:, 1] = -np.abs(axis[:, 1])
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    middle = np.tile([0, 1.0, 0], (count, 1))
    return omma.Eye(middle, axis, acceptance_angle_rad=np.full(count, 0.04))


CASES = {
    "grass": (grass, lambda: looking_down(150, 0.6, 0.4), {"paths": 16}),
    "room": (closed_room, lambda: around(150), {"cell_m": 0.15, "paths": 64}),
}


@pytest.fixture(scope="module", params=CASES)
def bakes(request):
    """Responses (bake, ommatidium) and their standard errors, and those by paths."""
    scene, eye, settings = CASES[request.param]
    paths = omma.World(scene(), light=SKY)
    found = []
    for seed in range(BAKES):
        bake = Bake(cache=False, seed=seed, **settings)
        world = paths.with_light(SKY, lighting="baked", bake=bake)
        renderer = omma.Renderer(world, eye(), omma.Fixed(32), seed=seed)
        found.append(renderer.render(np.eye(4), standard_error=True))
    truth = omma.Renderer(paths, eye(), omma.Fixed(1024)).render(np.eye(4), standard_error=True)
    pair = tuple(np.array([one[k][0, :, 0] for one in found], float) for k in range(2))
    return pair, tuple(one[0, :, 0].astype(float) for one in truth), world


def test_what_bakes_differ_by_is_claimed(bakes):
    (seen, errors), (truth, truth_error), _ = bakes
    claimed = np.sqrt((errors**2).mean())
    # What light varies by within cells is the same in all bakes.
    assert np.sqrt(seen.var(axis=0, ddof=1).mean()) < 1.1 * claimed
    off = np.sqrt(np.mean((seen - truth) ** 2 - truth_error**2))
    # Of 5 bakes; cells err together more widely than their groups by some of it.
    assert 0.8 < off / claimed < 1.25


def test_claims_hold_against_paths(bakes):
    (seen, errors), (truth, truth_error), _ = bakes
    z = (seen - truth) / np.sqrt(errors**2 + truth_error**2)
    # Of 750 responses: known to 1 / sqrt(1500), a fourth of what is left on either side.
    assert 0.9 < np.sqrt((z**2).mean()) < 1.1
    assert np.mean(np.abs(z) < 2) > 0.93
    assert seen.mean() == pytest.approx(truth.mean(), rel=0.01)


def test_what_a_bake_says_of_its_cells(bakes):
    world = bakes[2]
    info = world.baked
    assert 0 < info.error_median < info.error_95 < 1
    assert f"errors of cells {100 * info.error_median:.2g} %" in str(info)
    assert "(95 % below 400 %)" in str(replace(info, error_95=3.97))


def test_more_paths_err_less():
    paths = omma.World(grass(), light=SKY)
    median = []
    for count in (16, 256):
        bake = Bake(cell_m=0.1, paths=count, cache=False)
        median.append(paths.with_light(SKY, lighting="baked", bake=bake).baked.error_median)
    # A quarter, or less where more of what varies is told from noise; what light varies by within
    # cells stays.
    assert 2.5 < median[0] / median[1] < 6


def test_rendering_to_an_error_counts_the_bake():
    paths = omma.World(grass(), light=SKY)
    bake = Bake(cell_m=0.05, paths=16, cache=False)
    world = paths.with_light(SKY, lighting="baked", bake=bake)
    eye = looking_down(100, 0.6, 0.4)
    mean = omma.Renderer(world, eye, omma.Fixed(64)).render(np.eye(4)).mean()
    # Of cells alone an error of some percent is left, whatever rays there are.
    renderer = omma.Renderer(world, eye, omma.ToError(float(2e-3 * mean), most=4096))
    _, errors = renderer.render(np.eye(4), standard_error=True)
    assert np.median(errors) > 4e-3 * mean
    _, report = renderer.render(np.eye(4), report=True)
    # Rays go on until they are no longer what the error is made of, and no further.
    assert np.median(report.rays) < 4096
    by_paths = omma.Renderer(paths, eye, omma.ToError(float(0.02 * mean), most=4096))
    _, errors = by_paths.render(np.eye(4), standard_error=True)
    assert np.median(errors) < 0.02 * mean


def test_ground_under_clutter_has_its_cells():
    world = omma.World(
        grass(1500, 3.0), light=SKY, lighting="baked", bake=Bake(paths=32, cache=False)
    )
    eye = looking_down(600, 1.5, 2.0)
    paths = world.with_light(SKY, lighting="path")
    found, truth = (
        omma.Renderer(one, eye, omma.Fixed(256)).render(np.eye(4))[0, :, 0].astype(float)
        for one in (world, paths)
    )
    assert found.mean() == pytest.approx(truth.mean(), rel=0.005)
    assert np.sqrt(np.mean((found / truth - 1) ** 2)) < 0.03


def test_shade_finer_than_cells_is_claimed():
    """The edge of a black roof close over white ground, which gets (1 + x / hypot(x, h)) / 2 of the
    light of an even sky; what comes under its other edges is a thousandth."""
    height_m, far_m, half_m = 0.05, 1.2, 0.4
    ground, roof = (
        Mesh(
            [[low, y, half], [high, y, half], [high, y, -half], [low, y, -half]],
            [[0, 1, 2], [0, 2, 3]],
            material=k,
        )
        for k, (low, high, y, half) in enumerate(
            [(-half_m, half_m, 0, half_m), (-far_m, 0, height_m, far_m)]
        )
    )
    scene = omma.Scene(
        meshes=[ground, roof],
        materials=[matter(1.0), matter(0.0)],
        instances=[Instance(0, name="ground"), Instance(1, name="roof")],
    )
    bake = Bake(cell_m=0.06, paths=1024, cache=False)
    sky = uniform_sky(1.0, below=0, bands=BAND, unit="watts")
    world = omma.World(scene, light=sky, lighting="baked", bake=bake)
    rng = np.random.default_rng(7)
    x = rng.uniform(-0.1, 0.1, 400)
    at = np.column_stack([x, np.full(400, 0.02), rng.uniform(-0.3, 0.3, 400)])
    renderer = omma.Renderer(world, eyes_at(at, (0, -1, 0)), omma.Fixed(64))
    seen, errors = (one[0, :, 0] for one in renderer.render(np.eye(4), standard_error=True))
    off = seen - (1 + x / np.hypot(x, height_m)) / 2
    # Cells have no noise to speak of, but the light within one differs by more than it is.
    assert np.sqrt(np.mean((off / errors) ** 2)) < 1.5
    assert np.mean(np.abs(off) < 2 * errors) > 0.9
    assert np.sqrt(np.mean(off**2)) > 0.01


def test_what_it_would_cost():
    world = omma.World(grass(), light=SKY)
    bake = Bake(cell_m=0.02, paths=16, cache=False)
    cost = world.bake_cost(bake)
    info = world.with_light(SKY, lighting="baked", bake=bake).baked
    assert cost.cells == info.cells
    assert cost.triangles_by_probes == 0
    # Two bytes a band and four of errors for each side, and the last line of memory.
    assert cost.bytes == pytest.approx(cost.cells * 2 * (2 * len(BAND) + 4), abs=64)
    assert cost.seconds > 0
    assert f"{cost.cells:,} cells" in str(cost)
    with pytest.raises(omma.Error, match="expected a world with a light"):
        omma.World(grass()).bake_cost()


def test_a_triangle_out_of_reach_is_left_out():
    far = Mesh(np.float32([[0, 0, 0], [1, 0, 0], [0, 1e19, 0]]), [[0, 1, 2]], material=0)
    scene = grass()
    scene = scene.replace(
        meshes=[*scene.meshes, far], instances=[*scene.instances, Instance(2, name="far")]
    )
    bake = Bake(cell_m=0.1, paths=16, cache=False)
    world, without = (
        omma.World(one, light=SKY, lighting="baked", bake=bake) for one in (scene, grass())
    )
    assert world.baked.cells == without.baked.cells


def test_polarised_light_of_cells_errs_with_its_polarisation():
    """Level water at Brewster's angle mirrors a baked wall: Q is -I, so that both err by as much,
    and a receptor by its share of it."""
    mirror = omma.scene.Material("water", base_color=(0, 0, 0, 1), roughness=0, ior=1.333)
    matt = omma.scene.Material("matt", base_color=(0.5, 0.5, 0.5, 1), specular=0)
    scene = omma.scene.merge_scenes(
        [omma.scene.plane((40, 40)).replace(materials=[mirror])]
        + [
            omma.scene.box(size, center_m=centre).replace(materials=[matt])
            for size, centre in (
                ((6, 3, 0.2), (0, 1.5, -4)),
                ((6, 0.2, 6), (0, 3.1, -2)),
                ((0.2, 3, 6), (-3, 1.5, -2)),
            )
        ]
    )
    brewster, azimuth = np.arctan(1.333), np.radians(np.arange(-15, 16, 3))
    across, down = np.sin(brewster), np.full(len(azimuth), -np.cos(brewster))
    axis = np.column_stack([across * np.sin(azimuth), down, -across * np.cos(azimuth)])
    kinds = [
        omma.receptors.ReceptorType(
            name, wavelength_nm=[440, 450, 550, 560], sensitivity=[0, 1, 1, 0],
            microvillus_angle_rad=angle, polarisation_sensitivity=19,
        )
        for name, angle in (("upright", 0.0), ("level", np.pi / 2))
    ]  # fmt: skip
    eye = omma.Eye(np.zeros_like(axis), axis, np.radians(3), receptor_types=kinds, receptors=[0, 1])
    sky = uniform_sky(1.0, bands=omma.light.Bands.from_edges([450, 550]))
    bake = Bake(cell_m=0.5, paths=16, cache=False)
    world = omma.World(scene, light=sky, polarized=True, lighting="baked", bake=bake)
    renderer = omma.Renderer(world, eye, omma.Fixed(256))
    pose = omma.poses_from_angles((0, 1, 0), (0, 0, 0))
    stokes, error = renderer.render_stokes(pose, standard_error=True)
    degree = stokes[0, :, 1, 0] / stokes[0, :, 0, 0]
    assert np.all(degree < -0.99)
    np.testing.assert_allclose(error[0, :, 1, 0] / error[0, :, 0, 0], -degree, rtol=0.02)
    assert np.all(error[0, :, 2, 0] < 0.1 * error[0, :, 0, 0])
    response, of_response = renderer.render_receptors(pose, standard_error=True)
    share = (of_response / response)[0].reshape(-1, 2)
    # The upright one is some 5 % of the other; its share of U too is in its error.
    np.testing.assert_allclose(share[:, 0], share[:, 1], rtol=0.1)
