"""Gaussian splats whose channels are bands of wavelengths: in lit worlds, in others, in files."""

from __future__ import annotations

import pickle
import warnings

import numpy as np
import pytest

import omma
from omma.scene import SplatCloud, calibrate, merge_scenes

AHEAD = np.eye(4)
# Red, green, blue and ultraviolet.
BANDS_NM = [(600.0, 700.0), (500.0, 600.0), (400.0, 500.0), (300.0, 400.0)]
BACKENDS = [name for name in ("embree", "portable") if name in omma.scene.devices()[0].backends]


def one(values, **more):
    """A splat as good as opaque, of one linear colour."""
    harmonics = (np.array(values) - 0.5) / 0.28209479177387814
    return SplatCloud(
        [(0, 0, -3)], [[0.5] * 3], [[0, 0, 0, 1]], [1.0], harmonics[None, None],
        color_space="linear", **more,
    )  # fmt: skip


def cloud(channels, seed=1, count=300, **more):
    """Splats of all shapes around the origin, of degree 3."""
    rng = np.random.default_rng(seed)
    direction = rng.normal(size=(count, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    rotations = rng.normal(size=(count, 4))
    return SplatCloud(
        direction * rng.uniform(0.3, 3, (count, 1)),
        0.2 * np.exp(rng.uniform(-1, 1, (count, 3))),
        rotations / np.linalg.norm(rotations, axis=1, keepdims=True),
        rng.random(count),
        np.random.default_rng(99).uniform(-0.3, 0.3, (count, 16, 16))[:, :, channels],
        **more,
    )


def rays(splats, axes=((0, 0, -1),), bands=None, **more):
    """(N, C), what single rays bring; with bands from a world that is lit, as good as dark but for
    what splats send."""
    if bands is not None:
        more["light"] = omma.light.uniform_sky(1e-6, bands=bands)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that nothing lights splats
        world = omma.World(omma.Scene(splats=[splats]), **more)
    axes = np.asarray(axes, np.float64)
    eye = omma.Eye(np.zeros_like(axes), axes, np.zeros(len(axes)))
    return omma.Renderer(world, eye, omma.Fixed(1)).render(AHEAD)[0]


def test_white_is_the_white_of_rgb():
    """Equal numbers of photons at each wavelength, as RGB has them from 400 to 700 nm."""
    bands = omma.light.Bands.equal(4, 300.0, 700.0)
    rgb = rays(one((1, 1, 1)), bands=bands, emission_cd_m2=100.0)[0]
    found = rays(one((1, 1, 1, 1), bands_nm=BANDS_NM), bands=bands, emission_cd_m2=100.0)[0]
    assert found[1:] == pytest.approx(rgb[1:], rel=1e-4)
    assert found[0] == pytest.approx(found[1], rel=1e-4)


def test_each_channel_is_seen_in_its_band():
    bands = omma.light.Bands.equal(4, 300.0, 700.0)
    white = rays(one((1, 1, 1, 1), bands_nm=BANDS_NM), bands=bands)[0]
    found = rays(one((0.2, 0.5, 0.7, 0.9), bands_nm=BANDS_NM), bands=bands)[0]
    assert found / white == pytest.approx([0.9, 0.7, 0.5, 0.2], rel=1e-5)
    # Of a band that a channel covers in part, that part.
    half = [*BANDS_NM[:3], (350.0, 400.0)]
    found = rays(one((1, 1, 1, 1), bands_nm=half), bands=bands)[0]
    assert found / white == pytest.approx([0.5, 1, 1, 1], rel=1e-3)
    brighter = rays(one((1, 1, 1, 1), bands_nm=BANDS_NM, white=(1, 1, 1, 3)), bands=bands)[0]
    assert brighter / white == pytest.approx([3, 1, 1, 1], rel=1e-5)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("direction", ["center", "ray"])
def test_channels_know_nothing_of_each_other(backend, direction):
    """Seven channels at once are each what three of the same are."""
    ends = [(300.0 + 100 * k, 400.0 + 100 * k) for k in range(7)]
    axes = np.random.default_rng(5).normal(size=(200, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    bands = omma.light.Bands.equal(7, 300.0, 1000.0)
    more = {"direction": direction}
    together = rays(
        cloud(list(range(7)), bands_nm=ends, **more), axes, bands=bands, backend=backend
    )
    for k in range(7):
        alone = cloud([k] * 3, bands_nm=[ends[k], (5000.0, 5001.0), (6000.0, 6001.0)], **more)
        found = rays(alone, axes, bands=bands, backend=backend)
        assert together[:, k] == pytest.approx(found[:, k], rel=1e-5, abs=1e-6 * float(found.max()))
    # Where nothing is lit, the first three are red, green and blue.
    shown = rays(cloud(list(range(7)), bands_nm=ends, **more), axes, backend=backend)
    assert np.array_equal(shown, rays(cloud([0, 1, 2], **more), axes, backend=backend))


def test_values_and_files(tmp_path):
    splats = cloud(list(range(5)), bands_nm=[*BANDS_NM, (700.0, 800.0)], white=(1, 2, 3, 4, 5))
    assert splats.harmonics.shape == (300, 16, 5)
    assert splats.bands_nm[3] == (300.0, 400.0)
    assert SplatCloud(**{"bands_nm": None, **_fields(cloud([0, 1, 2]))}).bands_nm is None
    scene = omma.Scene(splats=[splats])
    assert pickle.loads(pickle.dumps(scene)) == scene
    omma.scene.save_scene(tmp_path / "five.glb", scene)
    back = omma.load_scene(tmp_path / "five.glb").splats[0]
    assert (back.bands_nm, back.white) == (splats.bands_nm, splats.white)
    assert np.array_equal(back.harmonics, splats.harmonics)
    tripled = calibrate(
        omma.Scene(splats=[one((0.3,) * 4, bands_nm=BANDS_NM)]),
        gray_card=(0.1, 0.2, 0.3, 0.4), reflectance=0.2,
    )  # fmt: skip
    assert tripled.splats[0].white == pytest.approx([2, 1, 2 / 3, 0.5])


def _fields(splats):
    return {
        name: getattr(splats, name)
        for name in ("positions_m", "scales_m", "rotations", "opacities", "harmonics")
    }


def test_what_cannot_be_right_is_refused():
    with pytest.raises(omma.Error, match=r"harmonics.*\(N, N, 4\)"):
        cloud([0, 1, 2], bands_nm=BANDS_NM)
    with pytest.raises(omma.Error, match=r"white.*\(4,\)"):
        cloud(list(range(4)), bands_nm=BANDS_NM, white=(1, 1, 1))
    with pytest.raises(omma.Error, match="3 to 16 channels"):
        cloud([0, 1], bands_nm=BANDS_NM[:2])
    for band in ((400.0, 300.0), (float("nan"), 400.0), (0.4, 0.5)):
        with pytest.raises(omma.Error, match="bands_nm 3: expected a band"):
            cloud(list(range(4)), bands_nm=[*BANDS_NM[:3], band])
    with pytest.raises(omma.Error, match="bands and white of the other splats"):
        merge_scenes(
            [
                omma.Scene(splats=[cloud([0, 1, 2])]),
                omma.Scene(splats=[cloud([0, 1, 2], bands_nm=BANDS_NM[:3])]),
            ]
        )
    with pytest.raises(omma.Error, match="give gray_card"):
        calibrate(omma.Scene(splats=[cloud([0, 1, 2], bands_nm=BANDS_NM[:3])]), exposure=1.0)
