"""How responses change with colours: they are linear in them, and so renders with other colours,
backgrounds and panoramas are told to rounding."""

from __future__ import annotations

import numpy as np
import pytest

import omma

EYE = omma.eye.generate_eye(60)
MATRIX = np.random.default_rng(3).uniform(0, 1, (5, 3))
POSES = omma.poses_from_angles([(0, 1, 0), (1, 1.5, 2)], [(0, 0, 0), (120, -20, 10)])


def sheets():
    """Before a wall with a picture, of colours at its corners, leaves whose image cuts them out,
    and a sheet that lets half through; above and beside them is nothing."""
    picture = np.random.default_rng(5).uniform(0, 1, (16, 16, 4)).astype(np.float32)
    material = omma.scene.Material
    materials = [
        material("wall", base_color=(0.5, 0.4, 0.3, 1), base_color_texture=0, double_sided=True),
        material("leaves", base_color_texture=0, alpha_mode="mask", double_sided=True),
        material("glass", base_color=(0.3, 0.6, 0.9, 0.5), alpha_mode="blend", double_sided=True),
    ]
    corners = np.array([(-3, 0, 0), (3, 0, 0), (3, 2, 0), (-3, 2, 0)], float)
    tints = np.random.default_rng(6).uniform(0, 1, (4, 4))
    meshes = [
        omma.scene.Mesh(
            corners + (0, 0, -3 + k), [(0, 1, 2), (0, 2, 3)], material=k, colors=tints,
            texture_coordinates=corners[:, :2],
        )
        for k in range(3)
    ]  # fmt: skip
    textures = [omma.scene.Texture(0)]
    images = [omma.scene.Image(picture)]
    return omma.Scene(meshes=meshes, materials=materials, textures=textures, images=images)


@pytest.fixture(scope="module")
def scene():
    return sheets()


@pytest.mark.parametrize("band_from_rgb", [None, MATRIX])
def test_responses_are_sums_over_colours(scene, band_from_rgb):
    """With colours drawn at random, what a render gives is Σ J c."""
    rng = np.random.default_rng(1)
    world = omma.World(scene, band_from_rgb=band_from_rgb)
    renderer = omma.Renderer(world, EYE, omma.Fixed(16))
    names = [one.name for one in scene.materials]
    before = renderer.render(POSES)
    found = renderer.color_jacobian(POSES, [*range(len(names)), "background"])
    assert found.shape == (2, 60, renderer.bands, len(names) + 1, 3)
    # The colours are as they were.
    assert np.array_equal(renderer.render(POSES), before)
    colors = rng.uniform(0, 1, (len(names) + 1, 3))
    for k, color in enumerate(colors[:-1]):
        world.set_color(k, color)
    sky = omma.Background.constant(colors[-1])
    rendered = renderer.with_world(world.with_background(sky)).render(POSES)
    # Sixteen rays, each of a few products in single precision.
    assert np.einsum("pnckj,kj->pnc", found, colors) == pytest.approx(rendered, abs=2e-6)
    # Each is of its own: none is the other's, and all are seen.
    assert (found.sum(axis=(0, 1, 2, 4)) > 0).all()


@pytest.mark.parametrize("band_from_rgb", [None, MATRIX])
def test_what_is_given_off(scene, band_from_rgb):
    """With emission drawn at random, textured on the glass, beside colours that take no part."""
    rng = np.random.default_rng(4)
    glass = scene.materials[2].replace(emissive_texture=0)
    shining = scene.replace(materials=[*scene.materials[:2], glass])
    world = omma.World(shining, band_from_rgb=band_from_rgb)
    renderer = omma.Renderer(world, EYE, omma.Fixed(16))
    before = renderer.render(POSES)
    found = renderer.color_jacobian(POSES, ["wall", "leaves", "glass"], emissive=True)
    assert np.array_equal(renderer.render(POSES), before)
    emission = rng.uniform(0, 1, (3, 3))
    for k, color in enumerate(emission):
        world.set_color(k, emissive=color)
    # Sixteen rays, each of a few products in single precision, of sums up to 2.
    told = np.einsum("pnckj,kj->pnc", found, emission)
    assert told == pytest.approx(renderer.render(POSES) - before, abs=4e-6)
    assert (found.sum(axis=(0, 1, 2, 4)) > 0).all()


def test_what_was_set_and_what_gives_off_light_stays(scene):
    """Colours that a world was given come back, and light of materials takes no part."""
    world = omma.World(scene)
    renderer = omma.Renderer(world, EYE, omma.Fixed(4))
    plain = renderer.color_jacobian(POSES, ["wall", "glass"])
    world.set_color("wall", (0.9, 0.1, 0.2), emissive=(0.1, 0.5, 0.2))
    before = renderer.render(POSES)
    assert np.array_equal(renderer.color_jacobian(POSES, ["wall", "glass"]), plain)
    assert np.array_equal(renderer.render(POSES), before)
    # What has no material is white whatever is asked for, and no colour's.
    bare = omma.Scene(
        meshes=[omma.scene.Mesh([(-9, -9, -1), (9, -9, -1), (0, 9, -1)], [(0, 1, 2)])]
    )
    sky = omma.Renderer(bare, EYE, omma.Fixed(4)).color_jacobian(np.eye(4), "background")
    truth = omma.Renderer(bare, EYE, omma.Fixed(4)).ground_truth(np.eye(4))
    assert sky[0, :, 1, 0, 1] == pytest.approx(1 - truth.met[0], abs=1e-6)


@pytest.mark.parametrize("band_from_rgb", [None, MATRIX])
@pytest.mark.parametrize("noise", ["frozen", "new_every_frame"])
def test_a_panorama_by_its_pixels(scene, band_from_rgb, noise):
    """What a random panorama adds to a random number of responses, by the gradient's pixels."""
    rng = np.random.default_rng(2)
    world = omma.World(scene, band_from_rgb=band_from_rgb)
    renderer = omma.Renderer(world, EYE, omma.Fixed(16), footprints=False, noise=noise)
    cotangent = rng.normal(size=(2, 60, renderer.bands))
    picture = rng.uniform(0, 1, (24, 48, 3)).astype(np.float32)
    gradient = renderer.background_vjp(POSES, cotangent, (24, 48), first_pose=3)
    seen, dark = (
        renderer.with_world(world.with_background(omma.Background.image(one))).render(
            POSES, first_pose=3
        )
        for one in (picture, 0 * picture)
    )
    # Responses are of single precision, 6e-8 of themselves off, and at most 1.
    assert np.sum(gradient * picture) == pytest.approx(
        np.sum((seen - dark) * cotangent), abs=1e-7 * np.abs(cotangent).sum()
    )
    assert np.abs(gradient).max() > 0.01


def test_one_ommatidium_sees_its_piece_of_a_panorama():
    """Of nothing but sky: weights sum to 1 and lie as the Gaussian does, also around the back."""
    width = np.radians(10.0)
    azimuth = np.radians([0.0, 90.0, 179.5])
    axis = np.stack([np.sin(azimuth), 0 * azimuth, -np.cos(azimuth)], axis=1)
    eye = omma.Eye(np.zeros((3, 3)), axis, width)
    renderer = omma.Renderer(omma.Scene(), eye, omma.Fixed(4096), footprints=False)
    for k in range(3):
        cotangent = np.zeros((1, 3, 3))
        cotangent[0, k, 1] = 1
        seen = renderer.background_vjp(np.eye(4), cotangent, (180, 360))
        assert (seen[..., [0, 2]] == 0).all()
        assert seen.sum() == pytest.approx(1, abs=1e-6)
        rows, columns = np.indices((180, 360)) + 0.5
        around = np.radians(columns - 180) - azimuth[k]
        off = np.angle(np.exp(1j * around))
        # A Gaussian of full width w at half maximum has σ = w / √(8 ln 2), near the horizon, where
        # azimuth is an angle; bilinear pixels of 1° add a sixth of a square degree.
        sigma = np.hypot(width / np.sqrt(8 * np.log(2)), np.radians(1) / np.sqrt(6))
        level = np.abs(rows - 90) < 8
        found = np.sqrt(np.sum((seen[..., 1] * off**2)[level]) / seen[..., 1][level].sum())
        assert found == pytest.approx(sigma, rel=0.02)
        assert np.sum(seen[..., 1] * off) == pytest.approx(0, abs=np.radians(0.1))


def test_what_is_not_linear_is_refused(scene):
    renderer = omma.Renderer(scene, EYE, omma.Fixed(4), footprints=False)
    lit = omma.World(omma.scene.box(), light=omma.light.uniform_sky(1e15), ultraviolet="dark")
    weights = np.ones((1, 60, 3))
    for call, message in (
        (lambda: renderer.color_jacobian(POSES[:1], "nobody"), "by: expected one called 'nobody'"),
        (lambda: renderer.color_jacobian(POSES[:1], ["nobody"]), "; or 'background'$"),
        (lambda: renderer.color_jacobian(POSES[:1], 99), "by: expected 0 to"),
        (
            lambda: omma.Renderer(lit, EYE, omma.Fixed(4)).color_jacobian(np.eye(4), 0),
            "world: expected one that is not lit",
        ),
        (
            lambda: renderer.with_eye(EYE, omma.ToError(0.1)).color_jacobian(POSES[:1], 0),
            "sampling: expected omma.Fixed",
        ),
        (
            lambda: renderer.with_eye(EYE, footprints=True).background_vjp(
                POSES[:1], weights, (4, 8)
            ),
            "footprints: expected footprints=False",
        ),
        (lambda: renderer.background_vjp(POSES[:1], weights[:, :3], (4, 8)), "cotangent: expected"),
        (
            lambda: renderer.background_vjp(POSES[:1], weights * np.nan, (4, 8)),
            "cotangent: expected",
        ),
        (lambda: renderer.background_vjp(POSES[:1], weights, (0, 8)), "shape: expected 1 to"),
        (lambda: renderer.background_vjp(POSES[:1], weights, (4, 8, 3)), "shape: expected shape"),
    ):
        with pytest.raises(omma.Error, match=message):
            call()


@pytest.mark.parametrize("sampling", [omma.Fixed(4), omma.ToError(0.1)])
def test_that_a_world_is_lit_is_said_before_what_the_renderer_lacks(sampling):
    lit = omma.World(omma.scene.box(), light=omma.light.uniform_sky(1e15), ultraviolet="dark")
    renderer, weights = omma.Renderer(lit, EYE, sampling), np.ones((1, 60, lit.bands))
    for call in (
        lambda: renderer.color_jacobian(np.eye(4), 0),
        lambda: renderer.background_vjp(np.eye(4), weights, (4, 8)),
        lambda: renderer.image_vjp(np.eye(4), weights, 0),
    ):
        with pytest.raises(omma.Error, match="world: expected one that is not lit"):
            call()
