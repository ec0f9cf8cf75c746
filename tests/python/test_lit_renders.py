"""Lit worlds as renders: errors, seeds, threads, pickles, other lights, sharing, unlit worlds."""

import pickle

import numpy as np
import pytest
from lit_checks import BAND, DARK, look, matter, room, shining, square

import omma
from omma.light import uniform_sky

TRUTH = 2.0


@pytest.fixture(scope="module")
def furnace():
    """A closed room of e = 1 and ρ = 0.5, in which all is 2."""
    scene = omma.Scene(meshes=room(2), materials=[shining(1.0, 0.5)])
    return omma.World(scene, light=DARK, threads=2, lighting="path")


@pytest.fixture(scope="module")
def eye():
    """300 ommatidia of 5 degrees all around."""
    random = np.random.default_rng(5)
    axes = random.normal(size=(300, 3))
    return omma.Eye(np.zeros((300, 3)), axes, np.radians(5))


def z_scores(world, truth, eye, samples, seeds):
    found = [
        omma.Renderer(world, eye, omma.Fixed(samples), seed=seed).render(
            np.eye(4), standard_error=True
        )
        for seed in range(seeds)
    ]
    return np.concatenate([((seen - truth) / error).ravel() for seen, error in found])


def test_standard_errors_cover_the_truth(furnace, eye):
    axes = eye.axis * [1, 0, 1] + [0, -1, 0]
    down = omma.Eye(np.zeros((300, 3)), axes, 0.0)
    plain = omma.Scene(meshes=[square(200, (0, -1, 0), (0, 1, 0))], materials=[matter(0.5)])
    ground = omma.World(plain, light=uniform_sky(1.0, below=0, bands=BAND), lighting="path")
    z = z_scores(ground, 0.5, down, 16, 4)
    # Of Student's t with 7 degrees of freedom the rms is sqrt(7/5); of 1,200 to some 4 %.
    assert np.sqrt(np.mean(z**2)) == pytest.approx(np.sqrt(7 / 5), rel=0.12)
    # The mean is not off: 0.034 is its standard error.
    assert abs(z.mean()) < 0.11
    assert 0.93 < np.mean(np.abs(z) < 2.365) < 0.97  # 95 % of t
    # Where few paths carry much light, of few rays errors come out somewhat too small.
    z = z_scores(furnace, TRUTH, eye, 16, 4)
    assert np.sqrt(np.mean(z**2)) < 1.5
    assert np.mean(np.abs(z) < 2.365) > 0.9


def test_rendered_to_an_error(furnace, eye):
    renderer = omma.Renderer(furnace, eye, omma.ToError(0.02))
    seen, report = renderer.render(np.eye(4), report=True)
    reached = report.standard_error[0, :, 0] <= 0.02
    # Those that did not had all the rays that there may be.
    assert np.mean(reached) > 0.9
    assert np.all(report.rays[0, ~reached] == 4096)
    assert len(np.unique(report.rays)) > 1
    # Estimated errors are mostly too large.
    assert np.sqrt(np.mean((seen - TRUTH) ** 2)) < 0.02


def test_the_same_bits_for_any_number_of_threads(furnace, eye):
    found = []
    for threads in (1, 2, 7):
        world = omma.World(furnace.scene, light=DARK, threads=threads, lighting="path")
        renderer = omma.Renderer(world, eye, omma.Fixed(8), threads=threads)
        found.append(renderer.render(np.eye(4)))
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_array_equal(found[0], found[2])


def test_seeds_differ_and_repeat(furnace, eye):
    one, again, other = (
        omma.Renderer(furnace, eye, omma.Fixed(8), seed=seed).render(np.eye(4))
        for seed in (3, 3, 4)
    )
    np.testing.assert_array_equal(one, again)
    assert np.all(one != other)


@pytest.fixture(scope="module")
def sheets():
    """A glossy ground and a leaf above it, to be lit."""
    leaf = matter(0.4, transmittance=omma.light.Spectrum([200, 800], [0.3, 0.3]))
    gloss = matter(0.5, specular=1.0, roughness=0.3)
    return omma.Scene(
        meshes=[square(9, (0, 0, 0), (0, 1, 0), 0), square(1, (0, 1, 0), (0, 1, 0.5), 1)],
        materials=[gloss, leaf],
        instances=[omma.scene.Instance(0), omma.scene.Instance(1, name="leaf")],
    )


HIGH = np.array([[1.0, 0, 0, 0], [0, 1, 0, 2], [0, 0, 1, 0], [0, 0, 0, 1]])


@pytest.mark.parametrize("polarised", [False, True])
def test_pickles_give_the_same_bits(sheets, eye, polarised):
    light = uniform_sky(3.0, below=0.2, bands=BAND)
    world = omma.World(sheets, light=light, depth=4, polarized=polarised)
    world.set_transforms("leaf", HIGH)
    renderer = omma.Renderer(world, eye, omma.Fixed(8))
    pose = np.eye(4)
    pose[1, 3] = 1.5
    other = pickle.loads(pickle.dumps(renderer))
    assert other.world.light == light
    assert (other.world.depth, other.world.polarized) == (4, polarised)
    np.testing.assert_array_equal(renderer.render(pose), other.render(pose))
    if polarised:
        np.testing.assert_array_equal(renderer.render_stokes(pose), other.render_stokes(pose))


def test_with_light_is_a_fresh_world(sheets, eye):
    day, dusk = uniform_sky(3.0, bands=BAND), uniform_sky(0.1, below=0, bands=BAND)
    pose = np.eye(4)
    pose[1, 3] = 1.5
    shared = omma.World(sheets, light=day, lighting="path").with_light(dusk, depth=2)
    fresh = omma.World(sheets, light=dusk, depth=2)
    found = [omma.Renderer(world, eye, omma.Fixed(8)).render(pose) for world in (shared, fresh)]
    np.testing.assert_array_equal(*found)
    # What moves in one moves in both, and a pickle of one is the same world again.
    shared.set_transforms("leaf", HIGH)
    fresh.set_transforms("leaf", HIGH)
    found = [
        omma.Renderer(world, eye, omma.Fixed(8)).render(pose)
        for world in (shared, fresh, pickle.loads(pickle.dumps(shared)))
    ]
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_array_equal(found[0], found[2])


def test_a_lit_world_of_an_unlit_one_and_back(sheets, eye):
    # Unlit, surfaces show their base colour: the same bits whether there is a lit sibling or not.
    unlit = omma.World(sheets)
    before = omma.Renderer(unlit, eye, omma.Fixed(8)).render(HIGH)
    lit = unlit.with_light(uniform_sky(1.0, bands=BAND))
    assert lit.bands == 1
    assert unlit.light is None
    omma.Renderer(lit, eye, omma.Fixed(8)).render(HIGH)
    np.testing.assert_array_equal(before, omma.Renderer(unlit, eye, omma.Fixed(8)).render(HIGH))
    explicit = omma.World(sheets, lighting="unlit")
    np.testing.assert_array_equal(before, omma.Renderer(explicit, eye, omma.Fixed(8)).render(HIGH))


def test_polarisation_does_not_change_intensity_of_matt_scenes(sheets, eye):
    matt = sheets.replace(
        materials=[sheets.materials[0].replace(specular=0.0), sheets.materials[1]]
    )
    world = omma.World(matt, light=uniform_sky(1.0, bands=BAND), lighting="path")
    plain = omma.Renderer(world, eye, omma.Fixed(8)).render(HIGH)
    polarised = world.with_light(world.light, polarized=True)
    stokes = omma.Renderer(polarised, eye, omma.Fixed(8)).render_stokes(HIGH)
    np.testing.assert_allclose(stokes[:, :, 0], plain, rtol=1e-5)
    np.testing.assert_allclose(stokes[:, :, 1:], 0, atol=1e-6)


def test_shared_rays(sheets):
    axes = omma.eye.generate_eye(200).axis
    many = omma.Eye(np.zeros((200, 3)), axes, np.radians(20))
    world = omma.World(sheets, light=uniform_sky(1.0, below=0, bands=BAND), lighting="path")
    own = omma.Renderer(world, many, omma.Fixed(256)).render(HIGH)
    shared = omma.Renderer(world, many, omma.Shared()).render(HIGH)
    # Rays of few samples each: means over the eye agree.
    assert shared.mean() == pytest.approx(own.mean(), rel=0.01)
    assert np.corrcoef(shared.ravel(), own.ravel())[0, 1] > 0.99
    polarised = world.with_light(world.light, polarized=True)
    with pytest.raises(omma.Error, match=r"[Ss]hared"):
        omma.Renderer(polarised, many, omma.Shared()).render_stokes(HIGH)


def test_stokes_need_a_polarised_world(furnace, eye):
    with pytest.raises(omma.Error, match="stokes: expected a world that is polarised"):
        omma.Renderer(furnace, eye, omma.Fixed(1)).render_stokes(np.eye(4))


def test_both_backends_agree(sheets):
    light = uniform_sky(1.0, below=0, bands=BAND)
    found = [
        look(
            omma.World(sheets, light=light, backend=backend, lighting="path"),
            (0.3, 3, 0.2),
            (0, -1, 0.1),
        )[0]
        for backend in ("embree", "portable")
    ]
    # The same random numbers; where a ray hits differs in its last bits.
    np.testing.assert_allclose(*found, rtol=1e-4)


def test_pictures_with_other_seeds_have_other_paths():
    """Errors of two seeds have nothing to do with each other, so that their mean is the better."""
    ground = omma.scene.plane((40, 40), (0.5, 0.5, 0.5))
    roof = omma.scene.plane((6, 6), (0.5, 0.5, 0.5), center_m=(0, 1, 0))
    world = omma.World(
        omma.scene.merge_scenes([ground, roof]),
        light=uniform_sky(1.0, below=0.0, bands=BAND),
        lighting="path",
    )
    pose = omma.look_at((0, 0.5, 0), (0, 0.0, -2))
    camera = omma.scene.Camera("below", world_from_camera=pose, yfov_rad=0.6)

    def picture(samples, seed):
        found = omma.render_camera(world, camera, width=32, height=24, samples=samples, seed=seed)
        return found[..., 0].astype(float).ravel()

    truth = picture(1024, 9)
    one, two = (picture(16, seed) - truth for seed in (1, 2))
    # Of 768 pixels, 0.036 by chance; what the picture of truth is off by adds 1/64.
    assert abs(np.corrcoef(one, two)[0, 1]) < 0.2
