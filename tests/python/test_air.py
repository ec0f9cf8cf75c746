"""Air between surfaces: how contrast falls with distance, its colours, its polarisation, and what
becomes of it where lights are changed. Closed forms in the engine: tests/cpp/render_air.cpp."""

import importlib.util
import pickle
import warnings
from dataclasses import replace
from datetime import datetime, timezone

import numpy as np
import pytest

import omma
from omma import Error
from omma.light import clear_sky, clouded, overcast_sky, under_water, uniform_sky, with_air

FEW = omma.light.Bands.equal(4)
POSE = np.eye(4)
AT_550 = omma.light.Bands.equal(1, 549.9, 550.1)


def wall(distance_m, reflectance=0.0):
    """A grey square across -Z, as wide as it is far."""
    material = omma.scene.Material(
        reflectance=omma.light.Spectrum([300, 700], [reflectance] * 2),
        specular=0.0,
        double_sided=True,
    )
    half = 0.5 * distance_m
    corners = [(-half, -half), (half, -half), (half, half), (-half, half)]
    mesh = omma.scene.Mesh(
        [(x, y, -distance_m) for x, y in corners], [(0, 1, 2), (0, 2, 3)], material=0
    )
    return omma.Scene(meshes=[mesh], materials=[material], instances=[omma.scene.Instance(mesh=0)])


def seen_ahead(light, scene, **world):
    """The light that comes along -Z, all components: (bands,) or of a polarised world more."""
    world = omma.World(scene, light=light, lighting="path", **world)
    eye = omma.Eye([(0, 0, 0)], [(0, 0, -1)], [0.0])
    renderer = omma.Renderer(world, eye, sampling=omma.Fixed(1))
    return renderer.render_stokes(POSE) if world.polarized else renderer.render(POSE)


@pytest.mark.parametrize("visibility_m", [50.0, 2e3, 60e3])
def test_contrast_to_the_horizon_is_a_twentieth_at_the_visibility(visibility_m):
    sky = clear_sky(35.0, sun_azimuth_deg=120, bands=AT_550)
    light = with_air(sky, visibility_m, layer_height_m=0)
    horizon = light.radiance((0, 0, -1))[0]
    for share in (0.1, 0.5, 1.0):
        black = np.asarray(seen_ahead(light, wall(share * visibility_m))).ravel()
        contrast = 1 - black / horizon
        # Koschmieder 1924: exp(-σ d), of a contrast of 1.
        np.testing.assert_allclose(contrast, 0.05**share, rtol=1e-3)


def test_hills_are_the_bluer_the_farther():
    light = with_air(clear_sky(40.0, sun_azimuth_deg=180, bands=FEW))
    seen = np.array([np.ravel(seen_ahead(light, wall(d))) for d in (10, 1e3, 10e3)])
    share = seen / light.radiance((0, 0, -1))[0]
    assert np.all(np.diff(share, axis=0) > 0)
    assert np.all(np.diff(share, axis=1) < 0)  # short waves first


def test_air_is_polarised_as_the_horizon_is():
    sky = clear_sky(20.0, sun_azimuth_deg=90, aerosol=0.0, bands=FEW)
    light = with_air(sky, 1000.0)
    horizon = light.radiance((0, 0, -1))
    assert np.hypot(*horizon[1:])[-1] > 0.4 * horizon[0, -1]
    stokes = np.asarray(seen_ahead(light, wall(300.0), polarized=True)).reshape(3, len(FEW))
    left = np.exp(-300 * light.extinction_per_m)
    scale = horizon[0].max()
    np.testing.assert_allclose(stokes / scale, (1 - left) * horizon / scale, atol=2e-5)


def test_baked_light_is_seen_through_air_and_gets_air_light():
    """Between two walls in fog, of which each is lit by the other and by the sky."""
    light = with_air(uniform_sky(1.0, bands=AT_550), 30.0, layer_height_m=0)
    scene = omma.scene.merge_scenes([wall(6.0, 0.6), wall(-6.0, 0.3)])
    eye = omma.Eye(np.zeros((3, 3)), [(0, 0, -1), (0.3, 0.1, -1), (0, 0, 1)], [0.1] * 3)
    pair = []
    for lighting in ("path", "baked"):
        bake = omma.scene.Bake(cache=False, paths=256) if lighting == "baked" else None
        world = omma.World(scene, light=light, lighting=lighting, bake=bake)
        renderer = omma.Renderer(world, eye, sampling=omma.Fixed(512))
        pair.append(renderer.render(POSE, standard_error=True))
    (paths, error), (baked, of_bake) = pair
    assert np.all(error > 0)
    assert np.all(np.abs(paths - baked) < 4 * np.hypot(error, of_bake))
    assert np.all(of_bake < 0.03 * baked)


class TestExtinction:
    def test_by_visibility_and_wavelength(self):
        """Kim, McArthur and Korevaar 2001, table 1."""
        bands = omma.light.Bands([450.0, 550.0, 650.0], np.eye(3))
        for visibility_m, power in [(300, 0), (800, 0.3), (3000, 0.82), (20e3, 1.3), (80e3, 1.6)]:
            sky = uniform_sky(1.0, bands=bands)
            air = with_air(sky, visibility_m, layer_height_m=0).extinction_per_m
            assert air[1] == pytest.approx(np.log(20) / visibility_m)
            np.testing.assert_allclose(
                air / air[1], (np.array([450, 550, 650]) / 550) ** -power, rtol=1e-6
            )
        sky = uniform_sky(1.0, bands=bands)
        own = with_air(sky, 300, angstrom=2.0, layer_height_m=0).extinction_per_m
        assert own[0] / own[1] == pytest.approx((550 / 450) ** 2)

    def test_of_clear_air(self):
        """Bucholtz (Appl. Opt. 34:2765, 1995): 1.162e-5 per m at 550 nm, recalled; of the tables'
        air 0.7 % less, as of its optical depth."""
        air = with_air(clear_sky(30.0, aerosol=0.0, bands=AT_550)).extinction_per_m
        assert air[0] == pytest.approx(1.162e-5, rel=0.015)

    def test_of_the_sky_that_it_is_under(self):
        clear = clear_sky(30.0, aerosol=0.2, bands=AT_550)
        air = with_air(clear_sky(30.0, aerosol=0.0, bands=AT_550)).extinction_per_m
        hazy = with_air(clear).extinction_per_m
        assert (hazy - air)[0] == pytest.approx(0.2 / 2000, rel=1e-3)
        through = clouded(clear, 0.5).turned(20).scaled(0.5)
        np.testing.assert_array_equal(with_air(through).extinction_per_m, hazy)
        usual = with_air(clear_sky(30.0, bands=AT_550)).extinction_per_m
        assert (usual - air)[0] == pytest.approx(0.1 / 2000, rel=1e-3)
        # Skies of other suns, of the moon and of the night say the same.
        same = {"aerosol": 0.2, "bands": AT_550}
        when = datetime(2026, 8, 27, 22, tzinfo=timezone.utc)
        for light in (
            omma.light.natural_sky(30.0, **same),
            omma.light.natural_sky(-30.0, **same),
            omma.light.moonlit_sky(30.0, **same),
        ):
            np.testing.assert_array_equal(with_air(light).extinction_per_m, hazy)
        np.testing.assert_array_equal(
            with_air(omma.light.natural_sky(30.0, bands=AT_550)).extinction_per_m, usual
        )
        high = with_air(omma.light.natural_sky(30.0, height_m=3000, bands=AT_550)).extinction_per_m
        expected = with_air(clear_sky(30.0, height_m=3000, bands=AT_550)).extinction_per_m
        np.testing.assert_array_equal(high, expected)
        if importlib.util.find_spec("ephem"):
            light = omma.light.natural_sky_at(when, 52.5, 13.4, **same)
            np.testing.assert_array_equal(with_air(light).extinction_per_m, hazy)
        with pytest.raises(Error, match=r"visibility_m: expected a number.*moonlit_sky"):
            with_air(overcast_sky(30.0))
        with pytest.raises(Error, match="expected one above the water"):
            with_air(under_water(clear, 1.0))

    def test_as_measured(self):
        assert with_air(uniform_sky(bands=FEW), extinction_per_m=0.5).extinction_per_m.tolist() == [
            0.5
        ] * len(FEW)
        with pytest.raises(Error, match="extinction_per_m"):
            with_air(uniform_sky(bands=FEW), extinction_per_m=[1, 2])
        with pytest.raises(Error, match="extinction_per_m"):
            with_air(uniform_sky(bands=FEW), extinction_per_m=-1)
        with pytest.raises(Error, match="at most 1000"):
            with_air(uniform_sky(bands=FEW), extinction_per_m=2000)
        with pytest.raises(Error, match="expected it alone"):
            with_air(uniform_sky(bands=FEW), 100, extinction_per_m=0.5)
        with pytest.raises(Error, match="goes with visibility_m"):
            with_air(uniform_sky(bands=FEW), angstrom=1.0)
        with pytest.raises(Error, match="1 to 250000"):
            with_air(uniform_sky(bands=FEW), 0.5)


class TestLayer:
    """Air that reaches up so high, before the sky too."""

    @pytest.mark.parametrize("height_m", [5.0, 100.0, 600.0])
    @pytest.mark.parametrize("sky", [overcast_sky(35.0, bands=FEW), clear_sky(35.0, bands=FEW)])
    def test_level_ground_gets_what_two_streams_let_through(self, sky, height_m):
        light = with_air(sky, 150.0, layer_height_m=height_m)
        depth = light.extinction_per_m * height_m
        # By sums over elevation and azimuth of the light as it is looked up.
        azimuth, edges = np.arange(0, 360, 4) + 2.0, np.linspace(0, 90, 721)
        elevation = (edges[:-1] + edges[1:]) / 2
        towards = omma.eye.direction(azimuth, elevation[:, None])
        weight = np.diff(np.sin(np.radians(edges)) ** 2) * np.pi / len(azimuth)
        below = np.einsum("e,eab->b", weight, replace(light, discs=()).radiance(towards)[:, :, 0])
        for one in light.discs:
            below += one.irradiance() * one.direction[1]
        # Rows of the map are 0.25 degrees apart, and this sum's too.
        np.testing.assert_allclose(below, sum(sky.irradiance()) * 2 / (2 + 0.15 * depth), rtol=1e-3)

    def test_discs_and_skies_are_dimmed_by_the_way_through(self):
        sky = clear_sky(35.0, bands=FEW)
        light = with_air(sky, 3000.0, layer_height_m=500.0)
        depth = light.extinction_per_m * 500.0
        left = np.exp(-depth / sky.discs[0].direction[1])
        np.testing.assert_allclose(light.discs[0].radiance, sky.discs[0].radiance * left)
        # Of polarised light nothing is added: Q and U are what is left.
        towards = omma.eye.direction([90.0, 200.0], [30.0, 62.0])
        before, after = (one.radiance(towards) for one in (sky, light))
        left = np.exp(-depth / towards[:, 1, None])
        np.testing.assert_allclose(after[:, 1:], before[:, 1:] * left[:, None], rtol=3e-3)
        added = (after[:, 0] - before[:, 0] * left) / (1 - left)
        np.testing.assert_allclose(added[0], added[1], rtol=1e-3)
        np.testing.assert_allclose(added[0], light.radiance((1, 0, 0))[0], rtol=1e-3)

    @pytest.mark.parametrize("sky", [overcast_sky(35.0, bands=FEW), clear_sky(40.0, bands=FEW)])
    def test_tall_things_vanish_too(self, sky):
        """A black wall whose top stands 17 to 31 degrees high, by its distance."""
        light = with_air(sky, 150.0, layer_height_m=100.0)
        for distance_m, rise in [(150.0, 0.3), (1000.0, 0.3), (1000.0, 0.45)]:
            eye = omma.Eye([(0, 0, 0)], [(0, rise, -1)], [0.0])
            seen = [
                np.ravel(
                    omma.Renderer(omma.World(scene, light=light), eye, omma.Fixed(1)).render(POSE)
                )
                for scene in (wall(distance_m), omma.Scene())
            ]
            contrast = seen[0] / seen[1] - 1
            near = 0.05 ** (distance_m * np.hypot(1, rise) / 150.0)
            # Koschmieder's, and what the layer leaves of the sky behind: exp(-2 / sin e), 0.7 % at
            # 24 degrees, of a sky that is up to 1.7 times as bright there.
            assert np.all(np.abs(contrast) < near + 0.012)

    def test_fog_without_a_height_is_told(self):
        sky = overcast_sky(35.0, bands=FEW)
        with pytest.warns(UserWarning, match="say how high the fog reaches, as layer_height_m=100"):
            plain = with_air(sky, 150.0)
        assert replace(plain, recipe=None) == replace(
            with_air(sky, 150.0, layer_height_m=0), recipe=None
        )
        with pytest.warns(UserWarning, match="is it in kilometres"):
            with_air(sky, 3.0)
        with pytest.raises(Error, match="layer_height_m: goes with visibility_m"):
            with_air(clear_sky(35.0), layer_height_m=50)
        with pytest.raises(Error, match="layer_height_m: expected 0 to 20000"):
            with_air(sky, 150.0, layer_height_m=-1)

    def test_without_a_sky_the_layer_shines_by_what_it_takes_from_discs(self):
        sun = replace(clear_sky(35.0, bands=FEW), sky=None, band_from_channel=None, recipe=None)
        light = with_air(sun, 150.0, layer_height_m=100.0)
        assert light.sky is not None
        assert np.all(light.radiance((0, 1, 0))[0] > 0)


class TestLightsInAir:
    def test_keep_it_when_they_are_changed(self):
        foggy = with_air(clear_sky(30.0, bands=FEW), 500.0, layer_height_m=0)
        air = foggy.extinction_per_m
        even = uniform_sky(bands=FEW)
        changes = [foggy.turned(30), 0.5 * foggy, clouded(foggy, 0.3), foggy + even, even + foggy]
        for changed in [*changes, foggy + foggy]:
            np.testing.assert_array_equal(changed.extinction_per_m, air)
        with pytest.raises(Error, match="the same air"):
            foggy + with_air(clear_sky(30.0, bands=FEW), 400.0, layer_height_m=0)

    def test_warn_once_not_in_each_process_that_gets_them(self):
        with pytest.warns(UserWarning, match="layer_height_m"):
            foggy = with_air(overcast_sky(30.0, bands=FEW), 150.0)
        stored = pickle.dumps(foggy)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert pickle.loads(stored) == foggy

    def test_are_values(self):
        foggy = with_air(clear_sky(30.0, bands=FEW), 500.0, layer_height_m=0)
        assert pickle.loads(pickle.dumps(foggy)) == foggy
        numbers = replace(foggy, recipe=None)
        assert pickle.loads(pickle.dumps(numbers)) == numbers
        assert foggy != clear_sky(30.0, bands=FEW)
        assert "with_air(" in repr(foggy)
        assert "air" in foggy._repr_html_()
        assert not foggy.extinction_per_m.flags.writeable
        other = omma.light.Bands.equal(8)
        assert foggy.in_bands(other) == with_air(
            clear_sky(30.0, bands=other), 500.0, layer_height_m=0
        )
