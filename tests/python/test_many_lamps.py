"""Ground below hundreds of lamps: each response is that of a sum over all of them, and its standard
error holds, also where lamps are triangles of one mesh, and where one is carried elsewhere.
"""

import numpy as np
import pytest

import omma
from omma.light import Bands, Spectrum

BACKENDS = ["embree", "portable"]
SPACING_M, UP_M, REFLECTANCE, RADIANCE, SIDE_M = 6.0, 4.0, 0.5, 100.0, 0.1
LAMPS = omma.light.lamps(bands=Bands.equal(1, 540, 560), unit="watts")
MATT = omma.scene.Material("matt", specular=0, base_color=(REFLECTANCE,) * 3)
PANEL = omma.scene.Material(
    "panel", specular=0, base_color=(0, 0, 0, 1), emissive=(1, 1, 1),
    emission=Spectrum([300.0, 800.0], [RADIANCE, RADIANCE]),
)  # fmt: skip
GROUND = omma.scene.plane((400, 400)).replace(materials=[MATT])


def lamp_places(count):
    """Places of lamps about a grid, (count, 3)."""
    side = int(np.ceil(count**0.5))
    column, row = np.arange(count) % side, np.arange(count) // side
    off_m = np.random.default_rng(2).uniform(-1, 1, (count, 2))
    level = (np.stack([column, row], 1) - (side - 1) / 2) * SPACING_M + off_m
    return np.stack([level[:, 0], np.full(count, UP_M), level[:, 1]], 1)


def panels(places_m, shared_mesh):
    """Small squares that shine downwards: instances of one, or all of them one mesh."""
    corner = np.float32([[-1, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]]) * SIDE_M / 2
    triangles = np.int32([[0, 1, 2], [0, 2, 3]])
    if shared_mesh:
        mesh = omma.scene.Mesh(corner, triangles, material=0)
        instances = []
        for number, place in enumerate(places_m):
            world_from_mesh = np.eye(4)
            world_from_mesh[:3, 3] = place
            instances.append(omma.scene.Instance(0, world_from_mesh, name=f"lamp {number}"))
    else:
        all_corners = (places_m[:, None] + corner).reshape(-1, 3).astype(np.float32)
        first = 4 * np.arange(len(places_m))[:, None, None]
        mesh = omma.scene.Mesh(all_corners, (triangles + first).reshape(-1, 3), material=0)
        instances = [omma.scene.Instance(0, name="lamps")]
    return omma.Scene(meshes=[mesh], materials=[PANEL], instances=instances)


def look_down(places_m):
    """An eye 1 m up, each of whose narrow ommatidia sees one place of the ground."""
    axes = places_m - (0, 1, 0)
    axes = axes / np.linalg.norm(axes, axis=1, keepdims=True)
    pose = np.eye(4)
    pose[1, 3] = 1
    return omma.Eye(np.zeros_like(axes), axes, np.radians(0.1)), pose


AT = np.linspace(-8, 8, 13)
PLACES = np.stack(np.meshgrid(AT, [0.0], AT, indexing="ij"), -1).reshape(-1, 3)


def check(world, true, samples, most_off):
    """One render: how far off single responses are, and by how many of their errors."""
    eye, pose = look_down(PLACES)
    response, error = omma.Renderer(world, eye, omma.Fixed(samples)).render(
        pose, standard_error=True
    )
    off = response[0, :, 0].astype(float) / true - 1
    claimed = error[0, :, 0] / true
    assert np.sqrt(np.mean(off**2)) < most_off
    z = off / claimed
    # Of 169 normal ones the rms is within 1 +- 0.055; of errors by 8 scrambles it is 1.18.
    assert 0.85 < np.sqrt(np.mean(z**2)) < 1.45
    assert np.mean(np.abs(z) > 3) < 0.06  # 2 % of Student's t of 7


@pytest.mark.parametrize("backend", BACKENDS)
def test_point_lamps(backend):
    places = lamp_places(300)
    lights = []
    for number, place in enumerate(places):
        world_from_light = np.eye(4)
        world_from_light[:3, 3] = place
        lights.append(
            omma.scene.PunctualLight(
                f"lamp {number}",
                spectrum=Spectrum([300.0, 800.0], [1.0, 1.0]),
                world_from_light=world_from_light,
            )
        )
    world = omma.World(GROUND.replace(lights=lights), light=LAMPS, depth=1, backend=backend)
    away = places - PLACES[:, None]
    distance = np.linalg.norm(away, axis=2)
    true = REFLECTANCE / np.pi * (away[..., 1] / distance**3).sum(1)
    # 2.7 %; chosen by their strength alone 42 %.
    check(world, true, 16, 0.07)


def lit_by_panels(places_m):
    """Radiance of the ground; panels are so small that their middle does for all of them."""
    away = places_m - PLACES[:, None]
    distance = np.linalg.norm(away, axis=2)
    sent = RADIANCE * SIDE_M**2 * (away[..., 1] ** 2 / distance**4).sum(1)
    return REFLECTANCE / np.pi * sent


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("shared_mesh", [True, False])
def test_panels_that_shine(shared_mesh, backend):
    places = lamp_places(300)
    scene = omma.scene.merge_scenes([GROUND, panels(places, shared_mesh)])
    world = omma.World(scene, light=LAMPS, depth=1, backend=backend)
    # 6.5 % of instances, 8.2 % of one mesh; chosen by their strength alone 40 %.
    check(world, lit_by_panels(places), 16, 0.12)


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_panel_that_is_carried_elsewhere(backend):
    places = lamp_places(300)
    far = places + (500, 0, 0)
    scene = omma.scene.merge_scenes([GROUND, panels(far, True)])
    world = omma.World(scene, light=LAMPS, depth=1, backend=backend)
    moved = np.eye(4)
    moved[:3, 3] = (1, UP_M, 2)
    world.set_transforms(["lamp 7"], moved[None])
    now = far.copy()
    now[7] = moved[:3, 3]
    # Nearly all is its own light; chosen as often as one of 300 it is missed by most. The others
    # get one ray in fifty, in all scrambles alike, so that errors say nothing.
    eye, pose = look_down(PLACES)
    response = omma.Renderer(world, eye, omma.Fixed(16)).render(pose)[0, :, 0]
    assert np.sqrt(np.mean((response / lit_by_panels(now) - 1) ** 2)) < 0.06


def spot_upwards():
    world_from_light = np.array([[1, 0, 0, 3], [0, 0, -1, 0.5], [0, 1, 0, 0], [0, 0, 0, 1]], float)
    if (world_from_light[:3, :3] @ (0, 0, -1))[1] < 0:
        world_from_light[:3, 1:3] *= -1
    return omma.scene.PunctualLight(
        "up", type="spot", intensity=5000, inner_cone_rad=0.2, outer_cone_rad=0.4,
        world_from_light=world_from_light,
    )  # fmt: skip


def out_of_range():
    world_from_light = np.eye(4)
    world_from_light[:3, 3] = 3, 4, 0
    return omma.scene.PunctualLight(
        "near", intensity=5000, range_m=2, world_from_light=world_from_light
    )


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("other", [spot_upwards(), out_of_range()], ids=["spot", "range"])
def test_a_strong_lamp_that_does_not_reach_a_place_is_not_chosen_there(other, backend):
    """Most responses were 0 with an error of 0."""
    above = np.eye(4)
    above[1, 3] = 8
    street = omma.scene.PunctualLight("street", intensity=100, world_from_light=above)
    eye, pose = look_down(PLACES)

    def seen(lights):
        scene = GROUND.replace(lights=lights)
        world = omma.World(scene, light=LAMPS, depth=1, backend=backend)
        return omma.Renderer(world, eye, omma.Fixed(16)).render(pose)

    np.testing.assert_allclose(seen([street, other]), seen([street]), rtol=1e-5)


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_lamp_far_from_all_others_takes_nothing_from_them(backend):
    """With one of them 3 km away responses had been half of what they are, 97 % of them beyond
    three errors."""
    places = np.vstack([lamp_places(30), [[3000, UP_M, 0]]])
    scene = omma.scene.merge_scenes([GROUND, panels(places, True)])
    world = omma.World(scene, light=LAMPS, depth=1, backend=backend)
    check(world, lit_by_panels(places), 16, 0.1)
    # One of the others is carried even farther.
    away = np.eye(4)
    away[:3, 3] = places[4] = (-9000, UP_M, 50)
    world.set_transforms(["lamp 4"], away[None])
    check(world, lit_by_panels(places), 16, 0.1)


def under_a_lamp(scene, lights, light, backend):
    """World of ground below lamps."""
    return omma.World(scene.replace(lights=lights), light=light, depth=1, backend=backend)


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_strong_lamp_behind_a_wall_leaves_none_dark(backend):
    """One of four responses was 0 with an error of 0: the lamp took nearly all rays."""
    lights = []
    for name, place, intensity in (("near", (0, 4, 0), 100), ("hidden", (0, 3, 30), 50_000)):
        world_from_light = np.eye(4)
        world_from_light[:3, 3] = place
        lights.append(
            omma.scene.PunctualLight(name, intensity=intensity, world_from_light=world_from_light)
        )
    upright = np.array([[1, 0, 0, 0], [0, 0, -1, 5], [0, 1, 0, 25], [0, 0, 0, 1]], float)
    black = omma.scene.Material(specular=0, base_color=(0, 0, 0, 1), double_sided=True)
    wall = omma.scene.plane((200, 30)).replace(
        materials=[black], instances=[omma.scene.Instance(0, upright, name="wall")]
    )
    walled = omma.scene.merge_scenes([GROUND, wall])
    eye, pose = look_down(PLACES)
    alone = under_a_lamp(walled, lights[:1], LAMPS, backend)
    true = omma.Renderer(alone, eye, omma.Fixed(16)).render(pose)[0, :, 0].astype(float)
    response, error = omma.Renderer(
        under_a_lamp(walled, lights, LAMPS, backend), eye, omma.Fixed(16)
    ).render(pose, standard_error=True)
    off, claimed = response[0, :, 0] / true - 1, error[0, :, 0] / true
    assert np.all(response > 0)
    # 8 %: of 16 shadow rays two at least look for the near one.
    assert np.sqrt(np.mean(off**2)) < 0.15
    assert 0.7 < np.sqrt(np.mean(off**2) / np.mean(claimed**2)) < 1.4


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("size_m", [20, 2000])
def test_a_lamp_under_the_moon_on_any_ground(size_m, backend):
    """How often rays looked for the lamp was by what it sends half a scene away: on a ground of
    2 km responses were off by 47 %."""
    bands = Bands.equal(2, 400, 700)
    moon, dark = omma.light.moonlit_sky(45, bands=bands), omma.light.lamps(bands=bands)
    world_from_light = np.eye(4)
    world_from_light[1, 3] = 5
    lamp = omma.scene.PunctualLight("lamp", intensity=100, world_from_light=world_from_light)
    ground = omma.scene.plane((size_m, size_m)).replace(materials=[MATT])
    eye, pose = look_down(PLACES)

    def seen(lights, light, samples):
        world = under_a_lamp(ground, lights, light, backend)
        return omma.Renderer(world, eye, omma.Fixed(samples)).render(pose)[0].astype(float)

    true = seen([lamp], dark, 16) + seen([], moon, 1024)
    # 2 %, of the choice between the two.
    assert np.sqrt(np.mean((seen([lamp], moon, 16) / true - 1) ** 2)) < 0.04


def test_a_directional_lamp_lights_scenes_of_any_size():
    """Of 4e11 m it had sent nothing: a sum of what lamps send had left single precision."""
    bands = Bands.equal(2, 400, 700)
    down = np.array([[1, 0, 0, 0], [0, 0, 1, 5], [0, -1, 0, 0], [0, 0, 0, 1]], float)
    lamp = omma.scene.PunctualLight("sun", type="directional", intensity=1e5, world_from_light=down)
    eye, pose = look_down(PLACES[:3])
    seen = []
    for half_m in (10, 4e11):
        ground = omma.scene.plane((2 * half_m, 2 * half_m)).replace(materials=[MATT])
        world = under_a_lamp(ground, [lamp], omma.light.lamps(bands=bands), "")
        seen.append(omma.Renderer(world, eye, omma.Fixed(4)).render(pose))
    np.testing.assert_allclose(seen[1], seen[0], rtol=1e-5)
