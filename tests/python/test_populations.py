"""Many eyes in one world in one call: to the bits of each alone, at poses of their own, other eyes
in the same world, what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import omma

AHEAD = np.eye(4)
BACKENDS = [name for name in ("embree", "portable") if name in omma.scene.devices()[0].backends]


def eyes_of(count, widths):
    """Eyes of different sizes, looking everywhere."""
    rng = np.random.default_rng(1)
    made = []
    for k in range(count):
        size = int(rng.integers(1, 150))
        axis = rng.normal(size=(size, 3))
        made.append(omma.Eye(0.001 * rng.normal(size=(size, 3)), axis, widths(rng, k, size)))
    return made


def alone(world, eye, poses, **options):
    return omma.Renderer(world, eye, omma.Fixed(16), **options).render(poses, first_pose=0)


@pytest.fixture(scope="module")
def scene():
    return omma.load_scene(omma.examples.meadow())


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("noise", ["frozen", "new_every_frame"])
def test_each_sees_what_it_would_alone(scene, backend, noise):
    world = omma.World(scene, backend=backend)
    eyes = eyes_of(12, lambda rng, k, size: rng.choice([0.02, 0.05, 0.1], size))
    rng = np.random.default_rng(2)
    poses = omma.poses_from_angles(
        scene.camera("bee").world_from_camera[:3, 3] + 0.1 * rng.normal(size=(36, 3)),
        rng.uniform(-180, 180, (36, 3)) * (1, 0.2, 0),
    ).reshape(3, 12, 4, 4)
    population = omma.Population(world, eyes, omma.Fixed(16), noise=noise)
    found = population.render(poses, first_pose=0)
    assert [one.shape for one in found] == [(3, len(eye), 3) for eye in eyes]
    for e, eye in enumerate(eyes):
        assert np.array_equal(found[e], alone(world, eye, poses[:, e], noise=noise))
    # However many stand beside it.
    last = omma.Population(world, eyes[-3:], omma.Fixed(16), noise=noise)
    assert np.array_equal(last.render(poses[:, -3:], first_pose=0)[2], found[-1])


def test_many_widths_are_within_a_ten_thousandth(scene):
    world = omma.World(scene)
    eyes = eyes_of(30, lambda rng, k, size: rng.uniform(0.02, 0.1, size))
    pose = scene.camera("bee").world_from_camera
    found = omma.Population(world, eyes, omma.Fixed(256)).render(pose)
    for one, eye in zip(found, eyes, strict=True):
        # Its own directions are those of its widths; rays at edges may fall on the other side.
        rendered = omma.Renderer(world, eye, omma.Fixed(256)).render(pose)
        assert np.sqrt(np.mean((one - rendered) ** 2)) < 2e-3 * rendered.mean()


def test_errors_and_one_eye_for_all(scene):
    world = omma.World(scene)
    eyes = eyes_of(5, lambda rng, k, size: np.full(size, 0.05))
    poses = np.tile(scene.camera("bee").world_from_camera, (5, 1, 1))
    population = omma.Population(world, eyes, omma.Fixed(8))
    found, errors = population.render(poses, standard_error=True)
    for e, eye in enumerate(eyes):
        same, error = omma.Renderer(world, eye, omma.Fixed(8)).render(poses[e], standard_error=True)
        assert np.array_equal(found[e], same)
        assert np.array_equal(errors[e], error)
    sizes = [len(eye) for eye in eyes]
    together = omma.Population(world, population.eye, omma.Fixed(8), sizes=sizes)
    assert together.sizes.tolist() == sizes
    for one, other in zip(together.render(poses), population.render(poses), strict=True):
        assert np.array_equal(one, other)


def with_receptors(eyes, beside):
    """Ommatidia of one receptor and of two, which may look beside the axis."""
    looks = {"right_rad": 0.02, "up_rad": -0.01} if beside else {}
    types = [
        omma.receptors.ReceptorType("green", peak_wavelength_nm=540),
        omma.receptors.ReceptorType(
            "blue", peak_wavelength_nm=440, polarisation_sensitivity=4.0, **looks
        ),
    ]
    return [
        eye.replace(receptor_types=types, receptors=[[[1], [0, 1]][i % 2] for i in range(len(eye))])
        for eye in eyes
    ]


@pytest.mark.filterwarnings("ignore:receptors have a polarisation sensitivity")
@pytest.mark.parametrize("beside", [False, True])
@pytest.mark.parametrize("polarized", [False, True])
def test_receptors_of_each_are_those_it_has_alone(beside, polarized):
    bands = omma.light.Bands.equal(4, 400.0, 700.0)
    light = omma.light.clear_sky(30, sun_azimuth_deg=120, bands=bands)
    world = omma.World(omma.scene.box(), light=light, polarized=polarized)
    eyes = with_receptors(eyes_of(4, lambda rng, k, size: np.full(size, 0.05)), beside)
    poses = omma.poses_from_angles(np.tile((0, 2, 3), (8, 1)), np.arange(24).reshape(8, 3))
    poses = poses.reshape(2, 4, 4, 4)
    population = omma.Population(world, eyes, omma.Fixed(8))
    found = population.render_receptors(poses)
    same, errors = population.render_receptors(poses, standard_error=True)
    for e, eye in enumerate(eyes):
        renderer = omma.Renderer(world, eye, omma.Fixed(8))
        assert found[e].shape == (2, len(eye.receptor_type))
        assert np.array_equal(found[e], renderer.render_receptors(poses[:, e]))
        one, error = renderer.render_receptors(poses[:, e], standard_error=True)
        assert np.array_equal(same[e], one)
        assert np.array_equal(errors[e], error)
    weights = np.arange(8.0).reshape(2, 4)
    mixed = population.render_receptors(poses[0], matrix=weights)[1]
    one = omma.Renderer(world, eyes[1], omma.Fixed(8))
    assert np.array_equal(mixed, one.render_receptors(poses[0, 1], matrix=weights))


def test_eyes_without_receptors_have_none_to_render(scene):
    population = omma.Population(scene, eyes_of(2, lambda *_: 0.05), omma.Fixed(1))
    with pytest.raises(omma.Error, match="expected ommatidia with receptors, found none"):
        population.render_receptors(AHEAD)


def test_the_next_generation(scene):
    world = omma.World(scene)
    pose = scene.camera("bee").world_from_camera
    population = omma.Population(world, eyes_of(4, lambda *_: 0.03), omma.Fixed(16))
    others = eyes_of(7, lambda *_: 0.06)
    found = population.with_eyes(others).render(pose)
    assert "7 eyes" in repr(population.with_eyes(others))
    for one, eye in zip(found, others, strict=True):
        assert np.array_equal(one, alone(world, eye, pose))
    assert len(population.render(pose)) == 4


def test_lit_worlds():
    """The sun is aimed at by each ommatidium, whichever eye it is of."""
    bands = omma.light.Bands.equal(4, 400.0, 700.0)
    light = omma.light.clear_sky(30, sun_azimuth_deg=120, bands=bands)
    world = omma.World(omma.load_scene(omma.examples.meadow()), light=light)
    eyes = eyes_of(3, lambda *_: 0.08)
    pose = world.scene.camera("bee").world_from_camera
    found = omma.Population(world, eyes, omma.Fixed(16)).render(pose)
    for one, eye in zip(found, eyes, strict=True):
        assert np.array_equal(one, alone(world, eye, pose))


def test_a_camera_is_a_pose_by_its_name(scene):
    population = omma.Population(scene, [omma.eye.generate_eye(20)] * 2, omma.Fixed(1))
    assert population.world.scene is scene
    by_name, by_pose = (
        population.render(pose, first_pose=0)
        for pose in ("bee", scene.camera("bee").world_from_camera)
    )
    assert all(map(np.array_equal, by_name, by_pose))
    with pytest.raises(omma.Error, match='there is no camera "wasp"'):
        population.render("wasp")


def test_what_is_no_population_is_refused():
    world = omma.World(omma.scene.box())
    eye = omma.eye.generate_eye(10)
    typed = omma.species.honeybee_worker().eye
    for eyes, options, message in (
        ([], {}, "found none"),
        ([eye, typed], {}, r"eyes\[1\]: expected the receptor types"),
        (eye, {}, "sizes: expected how many"),
        (eye, {"sizes": [4, 5]}, "10 ommatidia in all, found 9"),
        (eye, {"sizes": [10, 0]}, "numbers above 0"),
        ([eye], {"sizes": [10]}, "only with one eye"),
    ):
        with pytest.raises(omma.Error, match=message):
            omma.Population(world, eyes, **options)
    with pytest.raises(TypeError):
        omma.Population(world, [eye], omma.Shared(4))
    with pytest.raises(TypeError):
        omma.Population(world, [eye, "bee.eye"])
    population = omma.Population(world, [eye, eye])
    for poses in (np.zeros((3, 4, 4)), np.tile(AHEAD, (2, 3, 1, 1)), np.eye(3)):
        with pytest.raises(omma.Error, match=r"poses: expected shape \(4, 4\), \(2, 4, 4\)"):
            population.render(poses)
