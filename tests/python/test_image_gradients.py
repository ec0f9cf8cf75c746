"""How responses change with the pixels of an image that surfaces show: renders of pictures drawn
at random are told, for every way of reading an image."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import omma

EYE = omma.eye.generate_eye(60)
MATRIX = np.random.default_rng(3).uniform(0, 1, (5, 3))
POSES = omma.poses_from_angles([(0, 1, 0), (1, 1.5, 2)], [(0, 0, 0), (120, -20, 10)])
WAYS = [*itertools.product(("linear", "nearest"), ("repeat", "mirrored_repeat", "clamp_to_edge"))]


def walls(size=(7, 12), filter="linear", wrap="repeat"):
    """Two walls that show one image, one in its base colour, with colours at its corners, the
    other in what it gives off and turned, behind a sheet that lets half through."""
    rng = np.random.default_rng(5)
    material = omma.scene.Material
    turned = omma.scene.TextureUse(
        1, offset=(0.2, -0.3), scale=(1.4, 0.7), rotation_rad=0.5, texcoord_set=0
    )
    materials = [
        material("wall", base_color=(0.5, 0.4, 0.3, 1), base_color_texture=0, double_sided=True),
        material("screen", base_color=(0, 0, 0, 1), emissive=(0.9, 0.5, 0.7),
                 emissive_texture=turned, double_sided=True),
        material("glass", base_color=(0.3, 0.6, 0.9, 0.5), alpha_mode="blend", double_sided=True),
    ]  # fmt: skip
    corners = np.array([(-3, 0, 0), (3, 0, 0), (3, 2, 0), (-3, 2, 0)], float)
    tints = rng.uniform(0, 1, (4, 4))
    meshes = [
        omma.scene.Mesh(
            corners + move, [(0, 1, 2), (0, 2, 3)], material=k, colors=tints if k == 0 else None,
            texture_coordinates=corners[:, :2],
        )
        for k, move in enumerate([(0, 0, -3), (2, 1, 4), (1, 0.5, -2)])
    ]  # fmt: skip
    textures = [
        omma.scene.Texture(0, filter=filter, wrap_u=wrap, wrap_v=wrap),
        omma.scene.Texture(0, filter=filter),
    ]
    images = [omma.scene.Image(rng.uniform(0, 1, (*size, 3)).astype(np.float32), name="picture")]
    return omma.Scene(meshes=meshes, materials=materials, textures=textures, images=images)


def check(world, noise="frozen", eye=EYE):
    """A random picture's change of a random number of responses, by the gradient's pixels."""
    rng = np.random.default_rng(2)
    renderer = omma.Renderer(world, eye, omma.Fixed(16), footprints=False, noise=noise)
    cotangent = rng.normal(size=(2, len(eye), renderer.bands))
    before = renderer.render(POSES, first_pose=3)
    gradient = renderer.image_vjp(POSES, cotangent, "picture", first_pose=3)
    # All is as it was.
    assert np.array_equal(renderer.render(POSES, first_pose=3), before)
    picture = rng.uniform(0, 1, gradient.shape).astype(np.float32)
    seen = []
    for one in (picture, 0 * picture):
        world.set_image("picture", one)
        seen.append(renderer.render(POSES, first_pose=3))
    # Responses are of single precision, 6e-8 of themselves off, and at most 1. What pixels'
    # weights are off by, that over the angle between two pixels, is another for each ray.
    told, found = np.sum(gradient * picture), np.sum((seen[0] - seen[1]) * cotangent)
    assert told == pytest.approx(found, abs=1e-7 * np.abs(cotangent).sum())
    assert abs(found) > 0.1
    return gradient


@pytest.mark.parametrize(("filter", "wrap"), WAYS)
def test_pictures_are_sums_over_pixels(filter, wrap):
    gradient = check(omma.World(walls(filter=filter, wrap=wrap)))
    assert (np.abs(gradient).sum(-1) > 0).mean() > 0.8


@pytest.mark.parametrize("size", [(1, 1), (1, 2), (2, 3), (3, 1), (64, 500)])
def test_of_any_size(size):
    check(omma.World(walls(size)))


def test_bands_that_are_not_rgb_and_new_noise():
    check(omma.World(walls(), band_from_rgb=MATRIX), noise="new_every_frame")


def test_colours_and_pictures_that_were_set():
    """They count, and come back."""
    world = omma.World(walls())
    world.set_color("wall", (0.1, 0.9, 0.2))
    world.set_color("screen", (0.3, 0.2, 0.1), emissive=(0.2, 0.3, 0.9))
    world.set_image("picture", np.random.default_rng(8).uniform(0, 1, (7, 12, 3)))
    check(world)


def test_one_ommatidium_sees_its_piece_of_a_wall():
    """A wall of 2 m, 1 m ahead, 50 pixels a metre, as a Gaussian of 5° covers it: with
    σ = tan(5°/√(8 ln 2)) of the distance across the line of sight."""
    wall = omma.scene.Material(base_color_texture=0, double_sided=True)
    mesh = omma.scene.Mesh(
        [(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1)], [(0, 1, 2), (0, 2, 3)],
        texture_coordinates=[(0, 1), (1, 1), (1, 0), (0, 0)], material=0,
    )  # fmt: skip
    scene = omma.Scene(
        meshes=[mesh], materials=[wall], textures=[omma.scene.Texture(0)],
        images=[omma.scene.Image(np.zeros((100, 100, 3), np.float32))],
    )  # fmt: skip
    axis = np.array([(0.2, 0.3, -1.0)])
    eye = omma.Eye(np.zeros((1, 3)), axis / np.linalg.norm(axis), np.radians(5))
    renderer = omma.Renderer(scene, eye, omma.Fixed(4096), footprints=False)
    seen = renderer.image_vjp(np.eye(4), [[[0, 1, 0]]], 0)
    assert (seen[..., [0, 2]] == 0).all()
    assert seen.sum() == pytest.approx(1, abs=1e-5)
    rows, columns = np.indices((100, 100)) + 0.5
    weight = seen[..., 1]
    assert np.sum(weight * columns) == pytest.approx(50 + 50 * 0.2, abs=0.3)
    assert np.sum(weight * rows) == pytest.approx(50 - 50 * 0.3, abs=0.3)
    # Bilinear pixels add a sixth of a square pixel.
    sigma = 50 * np.tan(np.radians(5) / np.sqrt(8 * np.log(2))) * np.linalg.norm(axis)
    spread = np.sqrt(np.sum(weight * (columns - np.sum(weight * columns)) ** 2))
    stretched = np.sqrt(1 + 0.2**2)  # the wall is slanted, across
    assert spread == pytest.approx(np.hypot(sigma * stretched, np.sqrt(1 / 6)), rel=0.03)


def test_what_is_not_linear_is_refused():
    scene = walls()
    renderer = omma.Renderer(scene, EYE, omma.Fixed(4), footprints=False)
    weights = np.ones((1, 60, 3))
    cut = scene.materials[0].replace(alpha_mode="mask")
    leaves = scene.replace(materials=[cut, *scene.materials[1:]])
    plain = [one.replace(base_color_texture=None, emissive_texture=None) for one in scene.materials]
    for found, image, message in (
        (scene, "nobody", "image: expected one called 'nobody'"),
        (scene, 1, "image: expected 0"),
        (leaves, 0, "image: expected one whose alpha is not used"),
        (scene.replace(materials=plain), 0, "image: expected one that the base colour or"),
    ):
        other = omma.Renderer(found, EYE, omma.Fixed(4), footprints=False)
        with pytest.raises(omma.Error, match=message):
            other.image_vjp(POSES[:1], weights, image)
        # Also then all is as it was.
        assert other.render(POSES[:1]).any()
    with pytest.raises(omma.Error, match="footprints: expected footprints=False"):
        renderer.with_eye(EYE, footprints=True).image_vjp(POSES[:1], weights, 0)
    with pytest.raises(omma.Error, match="cotangent: expected"):
        renderer.image_vjp(POSES[:1], weights[:, :3], 0)
