"""Shadows of clouds: the layer's own closed form, the engine's, and that they go with the sky."""

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest
from lit_checks import eyes_at, matter, square

import omma
from omma import Error
from omma.light import Bands, CloudShadow, clear_sky, clouded, uniform_sky, with_air

FEW = Bands.equal(3, 400, 700)
SUN_DEG = 40.0
CLEAR = clear_sky(SUN_DEG, sun_azimuth_deg=75, bands=FEW)
SUN = CLEAR.discs[0].direction
# Metres, a layer of 4 by 3 nodes.
LAYER = CloudShadow(
    [[0, 0.5, 3, 0.25], [1, 0, 0, 2], [0.75, 0.1, 0.3, 4]], 50, 800, first_m=(10, -20)
)


class TestCloudShadow:
    def test_at_nodes_and_between_them(self):
        straight_up = (0.0, 1.0, 0.0)
        for (x, z), depth in {
            (10, -20): 0, (60, -20): 0.5, (85, -20): 1.75, (60, 5): 0.25, (35, 5): 0.375,
            (210, -20): 0, (-40, -20): 0.25, (10, 130): 0, (185, -45): (0.25 + 0 + 4 + 0.75) / 4,
        }.items():  # fmt: skip
            found = LAYER.transmittance((x, 0, z), straight_up)
            assert found == pytest.approx(np.exp(-depth), rel=1e-6)

    def test_on_a_slanting_way(self):
        slant = np.array([3.0, 4.0, 0.0]) / 5
        # From 400 m below the layer its way crosses it 300 m on, and is 5/4 as long in it.
        found = LAYER.transmittance((60 - 300, 400, -20), slant)
        assert found == pytest.approx(np.exp(-0.5 / 0.8), rel=1e-6)

    def test_above_the_layer_and_below_the_horizon_nothing_is_shaded(self):
        assert LAYER.transmittance((110, 801, -20), (0, 1, 0)) == 1
        assert LAYER.transmittance((110, 0, -20), (1, 0, 0)) == 1
        assert LAYER.transmittance((110, 0, -20), (1, -1, 0)) == 1

    def test_is_a_value(self):
        assert copy.deepcopy(LAYER) == LAYER == pickle.loads(pickle.dumps(LAYER))
        assert replace(LAYER, spacing_m=51) != LAYER
        assert not LAYER.optical_depth.flags.writeable

    @pytest.mark.parametrize(
        ("changes", "said"),
        [
            ({"optical_depth": [[1.0, 2.0]]}, "2 or more rows and columns"),
            ({"optical_depth": [[1.0, -2.0], [0, 0]]}, "0 to 1e6"),
            ({"optical_depth": [[1.0, np.nan], [0, 0]]}, "optical_depth"),
            ({"spacing_m": 0}, "spacing_m"),
            ({"height_m": np.inf}, "height_m"),
            ({"first_m": (0, 0, 0)}, "first_m"),
        ],
    )
    def test_what_it_cannot_be(self, changes, said):
        with pytest.raises(Error, match=said):
            replace(LAYER, **changes)


def test_the_ground_is_lit_through_it():
    places = np.array([(0, 0, 0), (37, 0, 11), (-212, 0, 480), (1700, 0, -1333)], float)
    scene = omma.Scene(meshes=[square(8000, (0, 0, 0), (0, 1, 0))], materials=[matter(0.5)])
    eye = eyes_at((0, 0, 0), (0, -1, 0))
    poses = np.tile(np.eye(4), (len(places), 1, 1))
    poses[:, :3, 3] = places + [0, 2, 0]

    def seen(shadow):
        light = omma.light.Light(FEW, discs=CLEAR.discs, cloud_shadow=shadow)
        world = omma.World(scene, light=light, lighting="path")
        return omma.Renderer(world, eye, omma.Fixed(16)).render(poses)[:, 0]

    # Single precision at places of kilometres, in nodes of 50 m, with depths of some.
    np.testing.assert_allclose(
        seen(LAYER) / seen(None),
        np.repeat(LAYER.transmittance(places, SUN)[:, None], 3, axis=1),
        rtol=2e-4,
    )


# A layer that is the same everywhere dims all that a sun sends: straight, from wall to ground, by
# paths, in what is baked and where the sun is looked up in its map.
@pytest.mark.parametrize("kind", ["path", "exact", "map"])
def test_an_even_layer_dims_all_light_alike(kind):
    scene = omma.Scene(
        meshes=[square(4, (0, 0, 0), (0, 1, 0)), square(4, (0, 2, -2), (0, 0, 1))],
        materials=[matter(0.5)],
    )
    settings = {"lighting": "path"}
    if kind != "path":
        bake = omma.scene.Bake(paths=64, cache=False)
        settings = {"lighting": "baked", "bake": bake, "sun": kind}
    sun = omma.light.Disc((0.2, 0.7, 0.7), 0.005, [1e4] * 3)
    eye = eyes_at((0, 0, 0), [(0, -1, 0), (0.3, -0.6, -1), (0.1, 0.2, -1), sun.direction])
    pose = np.eye(4)
    pose[:3, 3] = 0.3, 1, 0.5

    def seen(shadow):
        light = omma.light.Light(FEW, discs=[sun], cloud_shadow=shadow)
        world = omma.World(scene, light=light, **settings)
        return omma.Renderer(world, eye, omma.Fixed(64)).render(pose)[0]

    even = CloudShadow(np.full((2, 2), 0.7), 100, 500)
    plain = seen(None)
    assert plain.min() > 0
    # Baked light is kept in 16 bits.
    wanted = np.exp(-0.7 / sun.direction[1])
    np.testing.assert_allclose(seen(even) / plain, wanted, rtol=1e-5 if kind == "path" else 2e-3)


class TestOfASky:
    @pytest.mark.parametrize("kind", ["cumulus", "cirrus"])
    def test_the_sun_is_behind_the_cloud_that_the_sky_shows_before_it(self, kind):
        compared = 0
        around = np.array([(x, 0, z) for x in (-60, 0, 60) for z in (-60, 0, 60)], float)
        for seed in range(6):
            plain = clouded(CLEAR, 0.5, kind, seed=seed)
            shading = clouded(CLEAR, 0.5, kind, seed=seed, shadow_height_m=1200)
            np.testing.assert_array_equal(shading.sky, plain.sky)
            assert shading.discs == CLEAR.discs
            there = plain.discs[0].radiance[0] / CLEAR.discs[0].radiance[0] if plain.discs else 0.0
            here = shading.cloud_shadow.transmittance((0, 0, 0), SUN)
            # The sky's map is coarser than the layer's, some 40 m there: edges are left out.
            if np.ptp(shading.cloud_shadow.transmittance(around, SUN)) < 0.1:
                assert here == pytest.approx(there, abs=0.05)
                compared += 1
            assert shading.irradiance()[1] == pytest.approx(here * CLEAR.irradiance()[1])
        assert compared >= 2

    def test_going_on_moves_the_clouds_by_their_own_size(self):
        # Ground that goes on by a height of the layer sees the field one height on.
        light = clouded(CLEAR, 0.5, seed=2, shadow_height_m=1000)
        twice = clouded(CLEAR, 0.5, seed=2, shadow_height_m=2000)
        places = np.random.default_rng(0).uniform(-3000, 3000, (200, 3)) * [1, 0, 1]
        near = light.cloud_shadow.transmittance(places, SUN)
        np.testing.assert_allclose(
            twice.cloud_shadow.transmittance(2 * places, SUN), near, atol=1e-5
        )
        assert near.min() < 1e-6
        assert near.max() == 1

    def test_more_cloud_is_more_shade(self):
        def in_shade(fraction):
            shadow = clouded(CLEAR, fraction, seed=1, shadow_height_m=1000).cloud_shadow
            return np.mean(shadow.optical_depth > 0)

        shares = [in_shade(fraction) for fraction in (0, 0.2, 0.5, 0.8, 1)]
        assert shares[0] == 0
        assert shares[-1] == 1
        # The sky's share by solid angle is that of a part of the layer only.
        np.testing.assert_allclose(shares[1:-1], (0.2, 0.5, 0.8), atol=0.12)

    def test_changes_keep_it_and_what_cannot_is_refused(self):
        light = clouded(CLEAR, 0.5, seed=3, shadow_height_m=1000)
        shadow = light.cloud_shadow
        even = uniform_sky(1.0, bands=FEW)
        for one in (0.5 * light, light + even, even + light, with_air(light, 5000)):
            assert one.cloud_shadow == shadow
        assert pickle.loads(pickle.dumps(light)) == light
        assert light.in_bands(Bands.equal(2, 450, 650)).cloud_shadow == shadow
        with pytest.raises(Error, match="turn the light, then"):
            light.turned(10)
        with pytest.raises(Error, match="the same clouds"):
            light + clouded(CLEAR, 0.5, seed=4, shadow_height_m=1000)
        with pytest.raises(Error, match="cast no shadows"):
            omma.light.under_water(light, 3)
        with pytest.raises(Error, match="found no disc"):
            clouded(even, 0.5, shadow_height_m=1000)
        with pytest.raises(Error, match="shadow_height_m"):
            clouded(CLEAR, 0.5, shadow_height_m=-1)
        with pytest.raises(TypeError, match=r"omma\.light\.CloudShadow"):
            omma.light.Light(FEW, cloud_shadow=3)
