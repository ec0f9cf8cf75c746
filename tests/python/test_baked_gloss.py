"""Gloss in baked light: nothing is taken off for paths that are not followed, and there is no more
noise of rays than by paths. In the lit meadow, most of which is lit by probes here, as a bake takes
minutes: noise of rays does not depend on it.
"""

import warnings

import numpy as np
import pytest

import omma
from omma.light import Bands
from omma.scene import Bake

SUN_ELEVATION_DEG, SUN_AZIMUTH_DEG = 60, 135
POND_M = np.array([35.2, -0.2, -16.0])
SEEDS, RAYS = 12, 16


@pytest.fixture(scope="module")
def worlds():
    """By paths, and baked."""
    light = omma.light.clear_sky(
        SUN_ELEVATION_DEG, sun_azimuth_deg=SUN_AZIMUTH_DEG, bands=Bands.equal(8)
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        scene = omma.load_scene(omma.examples.lit_meadow())
        paths = omma.World(scene, light=light, ultraviolet=0.02, lighting="path")
        bake = Bake(most_bytes=1 << 18, cache=False)
        return paths, paths.with_light(light, lighting="baked", bake=bake)


def test_no_response_is_below_zero(worlds):
    eye = omma.species.honeybee_worker().eye
    seen = omma.Renderer(worlds[1], eye, omma.Fixed(RAYS)).render_receptors("bee")
    assert seen.min() > 0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        photons = omma.photoreceptors.photon_noise(
            seen / seen.mean(), 1, photons_per_s=100.0, integration_time_s=0.1
        )
    assert photons.min() >= 0


def noise(world, eye, pose):
    """The standard deviation of single frames as a share of the mean: (ommatidium, band)."""
    seen = np.array(
        [omma.Renderer(world, eye, omma.Fixed(RAYS), seed=k).render(pose)[0] for k in range(SEEDS)]
    ).astype(float)
    assert seen.min() >= 0
    return seen.std(axis=0, ddof=1) / seen.mean(axis=0)


@pytest.mark.parametrize("camera", ["bee", "bee-low"])
def test_grass_and_ground_are_no_noisier_than_by_paths(worlds, camera):
    paths, baked = worlds
    pose = paths.scene.camera(camera).world_from_camera
    eye = omma.species.honeybee_worker().eye
    below = np.flatnonzero((eye.axis @ pose[:3, :3].T)[:, 1] < -0.1)
    eye = eye.take(below[::4])
    found, most = (np.median(noise(world, eye, pose), axis=0) for world in (baked, paths))
    # 0.63 to 0.97 of it in every band, measured with all ommatidia.
    assert np.all(found < most), found / most


def test_water_with_the_sun_in_it_is_no_noisier_than_by_paths(worlds):
    paths, baked = worlds
    sun = np.asarray(paths.light.discs[0].direction)
    down = sun * [1, -1, 1]  # that a mirror sends on to the sun
    axes = down + np.random.default_rng(0).normal(0, 0.03, (300, 3))
    eye = omma.Eye(np.zeros((300, 3)), axes, acceptance_angle_rad=0.05)
    pose = np.eye(4)
    pose[:3, 3] = POND_M - 1.5 * down / sun[1]
    found, most = (np.sqrt((noise(world, eye, pose) ** 2).mean(axis=0)) for world in (baked, paths))
    # Both are mostly of the chance to meet the mirrored sun, which they share.
    assert np.all(found < 1.05 * most), found / most
