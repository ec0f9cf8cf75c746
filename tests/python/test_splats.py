"""Gaussian splats as Python has them: values, files, worlds with and without light, ground truth;
against a slow renderer in NumPy. Closed forms are in tests/cpp/render_splats.cpp."""

from __future__ import annotations

import pickle
import warnings

import numpy as np
import pytest
from slow_splats import trace

import omma
from omma.scene import SplatCloud, calibrate, merge_scenes, place_scene

AHEAD = np.eye(4)
BACKENDS = [name for name in ("embree", "portable") if name in omma.scene.devices()[0].backends]


def cloud(count=200, seed=1, terms=16, size_m=0.1, **more):
    """Splats of all shapes around the origin."""
    rng = np.random.default_rng(seed)
    direction = rng.normal(size=(count, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    rotations = rng.normal(size=(count, 4))
    return SplatCloud(
        direction * rng.uniform(0.3, 3, (count, 1)),
        size_m * np.exp(rng.uniform(-1, 1, (count, 3))),
        rotations / np.linalg.norm(rotations, axis=1, keepdims=True),
        rng.random(count),
        rng.uniform(-0.3, 0.3, (count, terms, 3)),
        **more,
    )


def one(opacity, color, at=(0.0, 0.0, -3.0), scale_m=0.5, **more):
    """A splat of one colour."""
    harmonics = (np.array(color) - 0.5) / 0.28209479177387814
    return SplatCloud(
        [at], [[scale_m] * 3], [[0, 0, 0, 1]], [opacity], harmonics[None, None], **more
    )


def eye_of(axes):
    """Rays, as an eye."""
    axes = np.asarray(axes, np.float64)
    return omma.Eye(np.zeros_like(axes), axes, np.zeros(len(axes)))


def rays(scene, axes, **more):
    """(N, C), what single rays bring."""
    world = omma.World(scene, **more)
    return omma.Renderer(world, eye_of(axes), omma.Fixed(1)).render(AHEAD)[0]


def sphere(count):
    """(N, 3), unit vectors all around."""
    axes = np.random.default_rng(5).normal(size=(count, 3))
    return axes / np.linalg.norm(axes, axis=1, keepdims=True)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("direction", ["center", "ray"])
def test_as_a_slow_renderer_has_it(backend, direction):
    splats = cloud(direction=direction)
    axes = sphere(300)
    found = rays(omma.Scene(splats=[splats]), axes, backend=backend)
    display, through, _, _ = trace(splats, np.zeros_like(axes), axes, np.full(len(axes), np.inf))
    covered = (1 - through)[:, None]
    color = display / np.maximum(covered, 1e-12)
    linear = np.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)
    off = np.abs(found - covered * linear).max(axis=1)
    # A splat at the edge of what counts is in for one and out for the other: 1/255 of a ray.
    assert np.sum(off > 2e-5) <= 2
    assert off.max() < 0.01


def test_backends_agree_to_the_bit():
    scene = merge_scenes([omma.Scene(splats=[cloud()]), omma.scene.sphere(center_m=(0, 0, -2))])
    axes = sphere(500)
    found = [rays(scene, axes, backend=backend) for backend in BACKENDS]
    for other in found[1:]:
        # Which triangle of two that share an edge is met may differ; splats may not.
        assert np.mean((found[0] != other).any(axis=1)) < 0.01


def test_an_acceptance_averages_linear_light():
    """The mean over an acceptance of a splat's light is that of its rays, each decoded."""
    splats = one(0.9, (0.8, 0.5, 0.2))
    scene = omma.Scene(splats=[splats], background=omma.Background.constant((0.1, 0.1, 0.1)))
    angle = np.radians(5)
    eye = omma.Eye([(0, 0, 0)], [(0, 0, -1)], [angle])
    found = omma.Renderer(omma.World(scene), eye, omma.Fixed(4096)).render(AHEAD)[0, 0]
    # By a Gaussian of that full width at half maximum, about the axis.
    sigma = angle / np.sqrt(8 * np.log(2))
    theta = (np.arange(4000) + 0.5) / 4000 * 6 * sigma
    weight = np.exp(-(theta**2) / (2 * sigma**2)) * np.sin(theta)
    alpha = 0.9 * np.exp(-((3 * np.sin(theta) / 0.5) ** 2) / 2)
    for channel, value in enumerate((0.8, 0.5, 0.2)):
        linear = ((value + 0.055) / 1.055) ** 2.4
        expected = np.sum(weight * (alpha * linear + (1 - alpha) * 0.1)) / weight.sum()
        assert found[channel] == pytest.approx(expected, rel=2e-4)


def test_errors_batches_and_shared_rays():
    scene = omma.Scene(splats=[cloud(2000, size_m=0.05)])
    eye = omma.eye.generate_eye(200)
    world = omma.World(scene)
    exact = omma.Renderer(world, eye, omma.Fixed(1024)).render(AHEAD)[0]
    found, error = omma.Renderer(world, eye, omma.Fixed(64)).render(AHEAD, standard_error=True)
    z = (found[0] - exact) / np.maximum(error[0], 1e-12)
    # Student's t of eight scrambles, 1.18, and the error of what is taken for exact.
    assert 0.9 < np.sqrt(np.mean(z**2)) < 1.35
    to_error = omma.Renderer(world, eye, omma.ToError(relative_error=0.05))
    close = to_error.render(AHEAD)[0]
    assert np.sqrt(np.mean((close / exact - 1)[exact > 0.02] ** 2)) < 0.06
    shared = omma.Renderer(world, eye, omma.Shared(8)).render(AHEAD)[0]
    assert np.corrcoef(shared.ravel(), exact.ravel())[0, 1] > 0.99
    poses = omma.poses_from_angles(np.zeros((3, 3)), [(0, 0, 0), (10, 0, 0), (20, 0, 0)])
    renderer = omma.Renderer(world, eye, omma.Fixed(4))
    together = renderer.render(poses, first_pose=0)
    for k in range(3):
        assert np.array_equal(renderer.render(poses[k], first_pose=k)[0], together[k])


def test_bands_by_the_words_of_rgb():
    types = omma.species.honeybee_worker().eye.receptor_types
    matrix = omma.receptors.receptor_matrix(types)
    scene = omma.Scene(splats=[cloud()])
    axes = sphere(50)
    in_rgb = rays(scene, axes)
    assert rays(scene, axes, band_from_rgb=matrix) == pytest.approx(in_rgb @ matrix.T, rel=1e-5)


def test_values_and_files(tmp_path):
    splats = cloud(terms=9, name="shrub", direction="ray", white=(2, 1, 1))
    scene = omma.Scene(splats=[splats])
    assert pickle.loads(pickle.dumps(scene)) == scene
    assert scene.splat_count == 200
    assert "200 splats" in repr(scene)
    omma.scene.save_scene(tmp_path / "shrub.glb", scene)
    back = omma.load_scene(tmp_path / "shrub.glb")
    assert back == scene
    axes = sphere(100)
    assert np.array_equal(rays(back, axes), rays(scene, axes))
    turned = omma.poses_from_angles((1, 2, 3), (40, 10, 5))[0]
    placed = place_scene(scene, turned)
    seen = omma.Renderer(omma.World(placed), eye_of(axes), omma.Fixed(1)).render(turned)[0]
    off = np.abs(seen - rays(scene, axes)).max(axis=1)
    assert np.sum(off > 1e-4) <= 1
    assert len(merge_scenes([scene, scene]).splats) == 2
    assert np.abs(scene.bounds).max() <= 3


def test_ground_truth_names_clouds():
    scene = merge_scenes(
        [
            omma.Scene(splats=[one(0.9, (1, 1, 1), name="shrub")]),
            omma.scene.plane((40, 40), center_m=(0, -1, 0), name="ground"),
        ]
    )
    eye = eye_of([(0, 0, -1), (0, -1, 0)])
    truth = omma.Renderer(omma.World(scene), eye, omma.Fixed(1)).ground_truth(
        AHEAD, shares=["shrub", "ground"]
    )
    assert truth.shares[0].tolist() == [[1, 0], [0, 1]]
    assert truth.distance_m[0] == pytest.approx([3, 1])
    assert truth.source_distance_m[0] == pytest.approx([3, 1])
    data = omma.Renderer(omma.World(omma.scene.box()), eye, omma.Fixed(1)).ground_truth(AHEAD)
    assert data.source_distance_m is None
    with pytest.raises(omma.Error, match="shrubs"):
        omma.Renderer(omma.World(scene), eye, omma.Fixed(1)).ground_truth(AHEAD, shares=["shrubs"])


def test_calibration():
    card = 0.46  # sRGB of 0.18
    scene = omma.Scene(splats=[one(1.0, (card, card, card))])
    by_card = calibrate(scene, gray_card=(card, card, card), reflectance=0.18)
    assert rays(by_card, [(0, 0, -1)])[0] == pytest.approx([0.18 * 0.99] * 3, rel=1e-3)
    by_exposure = calibrate(scene, exposure=12.0)
    white = 1.2 * 2**12
    linear = ((card + 0.055) / 1.055) ** 2.4
    assert rays(by_exposure, [(0, 0, -1)])[0] == pytest.approx(
        [linear * 0.99 * white] * 3, rel=1e-3
    )
    tinted = calibrate(scene, gray_card=(0.5, 0.4, 0.3), exposure=0.0)
    luminance = np.array([0.2126, 0.7152, 0.0722]) @ tinted.splats[0].white
    assert luminance == pytest.approx(1.2)
    for nonsense in (
        {}, {"gray_card": (0, 0.5, 0.5)}, {"gray_card": (0.5, 0.5, 2)}, {"exposure": 99.0},
        {"gray_card": (0.5, 0.5, 0.5), "reflectance": 1.5},
    ):  # fmt: skip
        with pytest.raises(omma.Error):
            calibrate(scene, **nonsense)
    with pytest.raises(omma.Error, match=r"found \[118\.0, 115\.0, 120\.0\]; divide .* by 255$"):
        calibrate(scene, gray_card=(118, 115, 120))
    with pytest.raises(omma.Error, match="found none"):
        calibrate(omma.Scene(), exposure=1.0)


@pytest.fixture
def white_sky():
    """A uniform sky, of visible bands."""
    return omma.light.uniform_sky(1e16, bands=omma.light.Bands.equal(12, 400.0, 700.0))


def test_a_lit_world_adds_and_dims(white_sky):
    """Splats send what they have, in cd/m² by emission_cd_m2, and let through what they let."""
    axes = [(0, 0, -1), (0, 0, 1)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        empty = rays(omma.scene.box((1e-6, 1e-6, 1e-6), center_m=(9, 9, 9)), axes, light=white_sky)
        dark = rays(omma.Scene(splats=[one(0.75, (0, 0, 0))]), axes, light=white_sky)
        bright = rays(
            omma.Scene(splats=[one(0.75, (1, 1, 1))]), axes, light=white_sky, emission_cd_m2=1e4
        )
        twice = rays(
            omma.Scene(splats=[one(0.75, (1, 1, 1))]), axes, light=white_sky, emission_cd_m2=2e4
        )
    assert dark[0] == pytest.approx(0.25 * empty[0], rel=1e-5)
    assert dark[1] == pytest.approx(empty[1], rel=1e-5)
    assert (bright[0] > dark[0]).all()
    assert twice[0] - dark[0] == pytest.approx(2 * (bright[0] - dark[0]), rel=1e-4)


def test_splats_cast_shadows_and_light_surfaces():
    """Before a lamp a splat dims the wall behind by what it covers; a bright one lights it."""
    wall = omma.scene.plane((40, 40), (0.5, 0.5, 0.5), center_m=(0, 0, 0))
    lamp = omma.scene.PunctualLight(
        "lamp", intensity=100.0, world_from_light=np.array(
            [[1, 0, 0, 0], [0, 1, 0, 4.0], [0, 0, 1, 0], [0, 0, 0, 1]]
        )
    )  # fmt: skip
    eye = omma.Eye([(0.5, 1.0, 0)], [(-0.4472, -0.8944, 0)], [0.0])

    def seen(*splats, emission=1.0):
        scene = merge_scenes([wall, omma.Scene(lights=[lamp], splats=splats)])
        world = omma.World(scene, light=omma.light.lamps(), emission_cd_m2=emission)
        return omma.Renderer(world, eye, omma.Fixed(256)).render(AHEAD)[0, 0]

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        plain = seen()
        shaded = seen(one(0.75, (0, 0, 0), at=(0, 2.5, 0), scale_m=0.05))
        lit = seen(one(0.75, (1, 1, 1), at=(-2, 1.0, 0), scale_m=0.5), emission=1e3)
    assert shaded == pytest.approx(0.25 * plain, rel=0.01)
    assert (lit > 1.05 * plain).all()


def test_a_lit_world_says_so_once(white_sky, monkeypatch):
    monkeypatch.setattr("omma.scene.lighting._told_of_splats", set())
    scene = omma.Scene(splats=[one(0.5, (1, 1, 1))])

    def told(**options):
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            omma.World(scene, light=white_sky, **options)
        return [str(one.message) for one in found if "do not light Gaussian" in str(one.message)]

    # What is stopped by its warning is no world, and the next one says so again.
    for _ in range(2):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with pytest.raises(UserWarning, match="do not light Gaussian splats"):
                omma.World(scene, light=white_sky)
    (sentence,) = told()
    assert "a colour of 1 is 1 cd/m²" in sentence
    assert told() == []
    # Another size of their light is another sentence.
    (sentence,) = told(emission_cd_m2=500)
    assert "a colour of 1 is 500 cd/m²" in sentence
    assert told(emission_cd_m2=500) == told() == []


def test_baking_refuses_splats(white_sky):
    scene = merge_scenes([omma.scene.box(), omma.Scene(splats=[one(0.5, (1, 1, 1))])])
    with (
        warnings.catch_warnings(),
        pytest.raises(omma.Error, match="without Gaussian splats"),
    ):
        warnings.simplefilter("ignore")
        omma.World(scene, light=white_sky, lighting="baked", ultraviolet="dark")
