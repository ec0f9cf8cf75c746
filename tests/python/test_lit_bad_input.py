"""Bad input to lit worlds: each is an omma.Error that says what is wrong.

Bad lights, skies and discs are in test_light.py, bad bands in test_light_bands.py.
"""

import numpy as np
import pytest
from lit_checks import BAND, matter, square

import omma
from omma.light import Bands, Disc, Spectrum, clear_sky, clear_sky_at, uniform_sky
from omma.scene import ExtraReflectance, Material, Mesh, PunctualLight

LIGHT = uniform_sky(1.0, bands=BAND)
NAN, INFINITE = float("nan"), float("inf")


def rising(*values):
    return Spectrum(np.linspace(300, 700, len(values)), values)


def scene_of(*materials, **parts):
    return omma.Scene(meshes=[square(1, (0, 0, 0), (0, 1, 0))], materials=materials, **parts)


def turned(normal):
    """A scene whose mesh has normals, of which one is as given."""
    normals = np.tile([0.0, 1, 0], (3, 1))
    normals[1] = normal
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 0, 1]], [[0, 1, 2]], normals=normals)
    return omma.Scene(meshes=[mesh])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        # Spectra.
        (lambda: matter(-0.1), "value: .*not negative, found -0.1 at 200 nm"),
        (lambda: matter(1.1), "reflectance"),
        (lambda: Material(reflectance=rising(0.2, NAN)), "value|reflectance|finite"),
        (
            lambda: Material(reflectance=rising(0.7, 0.6), transmittance=rising(0.1, 0.5)),
            "reflectance|transmittance|together",
        ),
        (lambda: Material(transmittance=rising(0.5, 1.5)), "transmittance"),
        (lambda: Material(emission=rising(1.0, -1.0)), "value: .*not negative, found -1 at 700 nm"),
        (lambda: Material(emission=rising(1.0, INFINITE)), "finite|emission"),
        (lambda: ExtraReflectance(0, [rising(0.5, 1.5)]), "spectra|reflectance"),
        (lambda: Spectrum([400, 300], [0.1, 0.1]), "wavelength_nm: expected wavelengths that grow"),
        (lambda: Spectrum([300, 300], [0.1, 0.1]), "wavelength_nm: expected wavelengths that grow"),
        (lambda: Spectrum([300, 400], [0.1]), "value"),
        (lambda: Spectrum([300], [0.1]), "wavelength_nm|two"),
        (lambda: Spectrum([50, 400], [0.1, 0.1]), "wavelength_nm"),
        # Factors.
        (lambda: Material(roughness=1.5), "roughness"),
        (lambda: Material(metallic=-0.5), "metallic"),
        (lambda: Material(ior=0.5), "ior"),
        (lambda: Material(ior=NAN), "ior"),
        (lambda: Material(transmission=2.0), "transmission"),
        (lambda: Material(specular=-1.0), "specular"),
        (lambda: Material(clearcoat=1.1), "clearcoat"),
        (lambda: Material(normal_scale=INFINITE), "normal_scale"),
        (lambda: Material(spectral_luminance=0.0), "spectral_luminance"),
        # Normals.
        (lambda: turned(normal=(0, 0, 0)), "mesh 0: the normal of vertex 1 is zero"),
        (lambda: turned(normal=(0, NAN, 0)), "mesh 0: the normal of vertex 1 is not finite"),
        # Lamps.
        (lambda: PunctualLight(intensity=-1.0), "intensity"),
        (lambda: PunctualLight(intensity=INFINITE), "intensity"),
        (lambda: PunctualLight(color=(1, -1, 1)), "color"),
        (lambda: PunctualLight(range_m=-1.0), "range_m"),
        (lambda: PunctualLight(type="lantern"), "type"),
        (lambda: PunctualLight(type="spot", inner_cone_rad=0.8, outer_cone_rad=0.4), "cone"),
        (lambda: PunctualLight(spectrum=rising(0.1, -0.1)), "value: .*not negative"),
        (lambda: PunctualLight(world_from_light=np.full((4, 4), NAN)), "world_from_light"),
        (lambda: PunctualLight(world_from_light=np.zeros((4, 4))), "world_from_light"),
        # Lights and dates that nobody knows.
        (lambda: clear_sky(30, bands=omma.light.Bands.equal(4, 280, 700)), "bands"),
        (lambda: clear_sky(30, bands=omma.light.Bands.equal(4, 300, 800)), "bands"),
        (lambda: uniform_sky(INFINITE), "radiance"),
        (lambda: LIGHT.scaled(INFINITE), "factor"),
        (lambda: LIGHT.scaled(-1.0), "factor"),
        # Finite numbers of which single precision makes darkness or infinity, or bands that would
        # take all memory.
        (lambda: uniform_sky(1e-300), "radiance: expected .*1e-30 somewhere, found 1e-300"),
        (lambda: uniform_sky(1e-20).scaled(1e-20), "light: expected .*1e-30 somewhere"),
        (lambda: LIGHT.scaled(1e-300), "factor: expected 0, or 1e-30 to 1e30"),
        (lambda: LIGHT.scaled(1e300), "factor: expected 0, or 1e-30 to 1e30"),
        (lambda: LIGHT.turned(1e300), "azimuth_deg: expected -1e6 to 1e6"),
        (lambda: Disc((0, 1, 0), 1e-8, [1.0]), "angular_radius_rad: expected 1e-06 or more"),
        (lambda: Bands.from_edges([300, 1e9]), "edges_nm: expected 100 to 5000 nm"),
        (lambda: Bands.equal(4, 0.1, 700), "edges_nm: expected 100 to 5000 nm"),
        (lambda: Bands.from_sensitivities([300, 1e12], [[0, 1]]), "wavelength_nm: expected 100 to"),
        (lambda: Bands([1.0, 400.0], [[1, 1]]), "wavelength_nm: expected 100 to 5000 nm"),
    ],
)
def test_bad_parts(make, message):
    with pytest.raises(omma.Error, match=message):
        make()


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"materials": [matter(emissive=(1, 1, 1), emission=rising(1e300, 1e300))]}, "material 0"),
        ({"materials": [matter(emissive=(1e15,) * 3, emission=rising(1e16, 1e16))]}, "material 0"),
        ({"lights": [PunctualLight("sun", intensity=1e300)]}, 'light 0 "sun"'),
        ({"lights": [PunctualLight(type="directional", intensity=1e35)]}, "light 0"),
        ({"lights": [PunctualLight(color=(1e38, 0, 0))]}, "light 0"),
        ({"lights": [PunctualLight(spectrum=rising(1e300, 1e300))]}, "light 0"),
    ],
)
def test_what_shines_too_brightly(parts, message):
    """Brighter than light from afar may be: sums would leave single precision."""
    scene = scene_of(matter(0.5)).replace(**parts)
    with pytest.raises(
        omma.Error, match=rf"scene: {message}.*: expected light of at most 1e30 per"
    ):
        omma.World(scene, light=LIGHT, lighting="path")


def test_bright_emission_is_finite():
    """Half of the limit, small in a large scene, so that squares are far from the mean."""
    lamp = matter(emissive=(1, 1, 1), emission=rising(2e11, 2e11))
    scene = omma.Scene(
        meshes=[square(2, (0, 0, 0), (0, 1, 0)), square(1e-3, (0.5, 1, 0), (0, -1, 0), 1)],
        materials=[matter(0.5), lamp],
    )
    world = omma.World(scene, light=LIGHT, lighting="path")
    eye = omma.Eye([[0, 1, 0]], [[0, -1, 0]], 0.0)
    seen, error = omma.Renderer(world, eye, omma.Fixed(64)).render(np.eye(4), standard_error=True)
    assert np.isfinite(seen).all()
    assert np.isfinite(error).all()


def test_dates_beyond_the_ephemeris():
    pytest.importorskip("ephem")
    from datetime import datetime, timezone

    for year in (1800, 2200):
        with pytest.raises(omma.Error, match=r"date_time.*1901"):
            clear_sky_at(datetime(year, 6, 21, tzinfo=timezone.utc), 48.0, 9.0)
    with pytest.raises(omma.Error, match=r"date_time.*zone"):
        clear_sky_at(datetime(2026, 6, 21), 48.0, 9.0)  # that is what is wrong
    for latitude, longitude in ((95.0, 9.0), (48.0, NAN)):
        with pytest.raises(omma.Error, match=r"latitude_deg|longitude_deg"):
            clear_sky_at(datetime(2026, 6, 21, tzinfo=timezone.utc), latitude, longitude)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"depth": 0}, "depth: expected 1 to 1000, found 0"),
        ({"depth": -1}, "depth"),
        ({"depth": 2000}, "depth"),
        ({"lighting": "bake"}, "lighting: expected one of"),
        ({"lighting": "baked", "depth": 2}, "depth: expected None"),
        ({"bake": omma.scene.Bake()}, 'bake: goes with lighting="baked", found lighting=None'),
        ({"sun": "map", "lighting": "path"}, 'sun: "map" goes with lighting="baked"'),
        ({"lighting": "unlit"}, "lighting"),
        ({"ultraviolet": "blue"}, "ultraviolet"),
        ({"ultraviolet": 1.5}, "ultraviolet"),
        ({"ultraviolet": NAN}, "ultraviolet"),
        ({"ultraviolet": {"leaf": -0.1}}, "ultraviolet"),
        ({"band_from_rgb": np.eye(3)}, "band_from_rgb|bands"),
        ({"background": omma.Background.constant((1, 1, 1))}, "background"),
    ],
)
def test_bad_worlds(settings, message):
    with pytest.raises(omma.Error, match=message):
        omma.World(scene_of(matter(0.5)), light=LIGHT, **settings)


def test_bad_types():
    scene = scene_of(matter(0.5))
    with pytest.raises(TypeError, match="light"):
        omma.World(scene, light="sun")
    with pytest.raises(TypeError, match="polarized"):
        omma.World(scene, light=LIGHT, polarized="yes")
    with pytest.raises(TypeError, match="depth"):
        omma.World(scene, light=LIGHT, depth=1.5)


@pytest.mark.parametrize("settings", [{"depth": 2}, {"polarized": True}, {"ultraviolet": "dark"}])
def test_what_needs_a_light(settings):
    with pytest.raises(omma.Error, match=f"{next(iter(settings))}: is for worlds with a light"):
        omma.World(scene_of(matter(0.5)), **settings)
    with pytest.raises(omma.Error, match="lighting"):
        omma.World(scene_of(matter(0.5)), lighting="path")


def test_ultraviolet_that_nobody_has_given():
    green = Material("meadow", base_color=(0.1, 0.4, 0.1, 1))
    day = uniform_sky(1.0)
    # The shortest way out comes first.
    with pytest.raises(
        omma.Error,
        match=r'ultraviolet: .*"dark".*visible.*25\.0%.*"meadow".*docs/materials\.md',
    ):
        omma.World(scene_of(green), light=day)
    # Of visible light alone nothing has to be said.
    omma.World(scene_of(green), light=uniform_sky(1.0, bands=Bands.equal(4, 400, 700)))
    with pytest.raises(omma.Error, match=r"ultraviolet: .*without a material"):
        omma.World(omma.Scene(meshes=[Mesh(np.eye(3), [[0, 1, 2]])]), light=day)
    with pytest.raises(omma.Error, match=r"ultraviolet: .*as the light: one without a name\."):
        omma.World(scene_of(Material(base_color=(0.1, 0.4, 0.1, 1))), light=day)
    # What is said counts below 400 nm, and only there.
    reflected = {}
    for rule in ("dark", "as_blue", 0.02, {"meadow": 0.02}, {"": "dark"}):
        world = omma.World(scene_of(green), light=day, ultraviolet=rule)
        eye = omma.Eye([[0, 1, 0]], [[0, -1, 0]], 0.0)
        reflected[str(rule)] = omma.Renderer(world, eye, omma.Fixed(16)).render(np.eye(4))[0, 0]
    dark, blue, little, named, other = reflected.values()
    np.testing.assert_array_equal(little, named)
    np.testing.assert_array_equal(dark, other)
    assert np.all(dark[:4] < little[:4])
    assert np.all(little[:4] < blue[:4])
    # Which lobes paths take depends on all bands: alike but for noise.
    np.testing.assert_allclose(dark[5:], blue[5:], rtol=0.05)


def test_lit_renders_refuse_what_they_cannot_do():
    world = omma.World(scene_of(matter(0.5)), light=LIGHT)
    eye = omma.Eye([[0, 1, 0]], [[0, -1, 0]], 0.0)
    renderer = omma.Renderer(world, eye, omma.Fixed(1))
    with pytest.raises(omma.Error, match="expected ommatidia with receptors"):
        renderer.render_receptors(np.eye(4))
    with pytest.raises(omma.Error, match="stokes: expected a world that is polarised"):
        renderer.render_stokes(np.eye(4))
    with pytest.raises(omma.Error, match=r"background|light"):
        world.with_background(omma.Background.constant((1, 1, 1)))
