"""Measured spectra of a scene's materials, by name, and from there to photons."""

import numpy as np
import pytest

import omma
from omma.light import Spectrum
from omma.scene import Material
from omma.scene.facets import mirrored_straight

RAMP = Spectrum([300, 500, 700], [0.1, 0.5, 0.3])
DOWN = omma.look_at((0, 1, 0), (0, 0, 0), (0, 0, -1))
# Of 64 rays, which look for the sky in 64 directions: 1.7e-4, of 1,024 rays 9e-5, of 16,384 2e-6.
NOISE = 5e-4
ONE = omma.Eye([[0, 0, 0]], [[0, 0, -1]], 0.05, facet_diameter_m=2e-5)


def ground(*materials, colors=None):
    square = [[-9, 0, -9], [9, 0, -9], [9, 0, 9], [-9, 0, 9]]
    mesh = omma.scene.Mesh(
        square, [[0, 2, 1], [0, 3, 2]], texture_coordinates=np.zeros((4, 2)), colors=colors,
        material=0,
    )  # fmt: skip
    grey = omma.scene.Image(np.full((1, 1, 4), 128, np.uint8))
    return omma.Scene(meshes=[mesh], materials=materials, images=[grey])


def seen(scene, light, **arguments):
    world = omma.World(scene, light=light, **arguments)
    return omma.Renderer(world, ONE, omma.Fixed(64)).render(DOWN)[0, 0]


# What files hold: a metal, glass, a texture, a sheet, an unlit thing.
MATERIALS = {
    "rough matter": Material("petal"),
    "metal": Material("petal", metallic=1.0, roughness=0.3, base_color=(0.1, 0.2, 0.3)),
    "glass": Material("petal", transmission=1.0, ior=1.4, clearcoat=1.0),
    "textured": Material("petal", base_color_texture=0),
    "unlit": Material("petal", unlit=True),
    "sheet": omma.scene.natural_material("white petal").replace(name="petal"),
}


@pytest.mark.parametrize("kind", MATERIALS)
def test_a_matt_surface_sends_back_what_was_measured(kind):
    """Under an even sky of radiance L it is ρ L, in every band the mean of the spectrum."""
    scene = ground(Material("ground"), MATERIALS[kind])
    mesh = scene.meshes[0].replace(material=1)
    scene = omma.scene.with_reflectance(scene.replace(meshes=[mesh]), "petal", RAMP, plain=True)
    light = omma.light.uniform_sky(1e17, bands=omma.light.Bands.equal(4))
    np.testing.assert_allclose(seen(scene, light), 1e17 * light.bands.mean(RAMP), rtol=NOISE)
    assert scene.materials[0] == Material("ground")


def test_from_a_measured_petal_to_photons(tmp_path):
    """The whole way, against π/4 D² Ω t ∫ ρ E/π (1 - exp(-k a l)) dλ / 3 in steps of 0.1 nm, of
    three cells of one rhabdom."""
    nm = np.arange(300, 701.0)
    reflectance = 0.1 + 0.4 / (1 + np.exp(-(nm - 520) / 15))
    daylight = 2e18 * (nm / 500) ** 2
    path = tmp_path / "flower.csv"
    np.savetxt(path, np.c_[nm, 100 * reflectance, daylight], "%.9g", ",", header="wl,petal,sun",
               comments="")  # fmt: skip
    petal = omma.light.load_spectra(path, unit="percent", columns=["petal"])["petal"]
    sun = omma.light.load_spectra(path, unit="as_is", columns=["sun"])["sun"]
    light = omma.light.measured_sky(sun, "photons", bands=omma.light.Bands.equal(80))
    scene = omma.scene.with_reflectance(ground(Material("petal")), "petal", petal)
    kinds = omma.species.bumblebee(assume="honeybee_worker").eye.receptor_types
    eye = ONE.replace(receptor_types=kinds, receptors=[[0, 1, 2]])
    renderer = omma.Renderer(omma.World(scene, light=light), eye, omma.Fixed(64))
    matrix = omma.receptors.receptor_matrix(eye, bands=light.bands)
    answers = renderer.render_receptors(DOWN, matrix=matrix)[0]
    caught = omma.receptors.photon_catch(eye, answers, light, integration_time_s=0.01)
    fine = np.arange(300, 700.05, 0.1)
    radiance = np.interp(fine, nm, reflectance) * np.interp(fine, nm, daylight) / np.pi
    field = np.pi / 4 * 4e-10 * omma.receptors.solid_angle_sr([0.05])[0] * 0.01
    for one, number in zip(eye.receptor_types, caught, strict=True):
        absorbed = -np.expm1(-6700 * 320e-6 * omma.receptors.govardovskii(
            one.peak_wavelength_nm, fine))  # fmt: skip
        expected = field * np.trapezoid(absorbed * radiance, fine) / 3
        # Bands of 5 nm: products of means beside means of products.
        assert number == pytest.approx(expected, rel=2e-3), one.name


def test_gloss_counts_into_the_whole():
    glossy = Material("petal", roughness=0.4)  # ior 1.5: level it would mirror 0.04
    gloss = mirrored_straight(0.4, 1.5)
    assert 0.038 < gloss < 0.04
    kept = omma.scene.with_reflectance(ground(glossy), "petal", RAMP, gloss=True).materials[0]
    np.testing.assert_allclose(
        kept.reflectance.value, (np.array([0.1, 0.5, 0.3]) - gloss) / (1 - gloss)
    )
    assert (kept.specular, kept.roughness) == (1.0, pytest.approx(0.4))
    black = Spectrum([300, 700], [0.02, 0.02])
    kept = omma.scene.with_reflectance(ground(glossy), "petal", black, gloss=True).materials[0]
    assert kept.reflectance.value.tolist() == [0, 0]


def test_textures_and_vertex_colours_want_a_word():
    textured = Material("petal", base_color=(0.5, 0.5, 0.5, 1), base_color_texture=0)
    with pytest.raises(omma.Error, match="'petal' has a texture; expected the luminance of its"):
        omma.scene.with_reflectance(ground(textured), "petal", RAMP)
    light = omma.light.uniform_sky(1e17, bands=omma.light.Bands.equal(4))
    # The texture is 128, linear 0.2159, times 0.5: measured at twice that, it is half the spectrum.
    scene = omma.scene.with_reflectance(ground(textured), "petal", RAMP, at_luminance=0.21586)
    np.testing.assert_allclose(seen(scene, light), 0.5e17 * light.bands.mean(RAMP), rtol=NOISE)
    coloured = ground(Material("petal"), colors=np.full((4, 3), 0.5))
    with pytest.raises(omma.Error, match="'petal' has vertex colours"):
        omma.scene.with_reflectance(coloured, "petal", RAMP)
    scene = omma.scene.with_reflectance(coloured, "petal", RAMP, plain=True)
    assert scene.meshes[0].colors is None
    np.testing.assert_allclose(seen(scene, light), 1e17 * light.bands.mean(RAMP), rtol=NOISE)
    scene = omma.scene.with_reflectance(coloured, "petal", RAMP, at_luminance=1.0)
    np.testing.assert_allclose(seen(scene, light), 0.5e17 * light.bands.mean(RAMP), rtol=NOISE)
    cut = textured.replace(alpha_mode="mask")
    with pytest.raises(omma.Error, match="plain: expected a material whose texture does not cut"):
        omma.scene.with_reflectance(ground(cut), "petal", RAMP, plain=True)
    with pytest.raises(omma.Error, match="at_luminance: not together with plain"):
        omma.scene.with_reflectance(ground(cut), "petal", RAMP, plain=True, at_luminance=1)


def test_a_black_spectrum_is_black():
    black = Spectrum([300, 700], [0, 0])
    scene = omma.scene.with_reflectance(ground(Material("petal")), "petal", black)
    light = omma.light.uniform_sky(1e17, bands=omma.light.Bands.equal(2))
    assert seen(scene, light).tolist() == [0, 0]


def test_names_and_spectra_that_do_not_fit():
    scene = ground(Material("ground"), Material("petal"))
    with pytest.raises(
        omma.Error, match="name: expected one of ground, petal, found 'petals'; did"
    ):
        omma.scene.with_reflectance(scene, "petals", RAMP)
    with pytest.raises(omma.Error, match="name: expected the name of a material of the scene, whi"):
        omma.scene.with_reflectance(omma.Scene(), "petal", RAMP)
    for nm in ([300, 650], [410, 700]):
        with pytest.raises(
            omma.Error, match="reflectance: expected values from 400 nm or below to"
        ):
            omma.scene.with_reflectance(scene, "petal", Spectrum(nm, [0.1, 0.2]))
    with pytest.raises(omma.Error, match="reflectance"):
        omma.scene.with_reflectance(scene, "petal", Spectrum([300, 700], [0.1, 1.2]))
    with pytest.raises(TypeError, match=r"scene: expected omma\.Scene"):
        omma.scene.with_reflectance("scene", "petal", RAMP)


@pytest.mark.parametrize("first", [400, 350])
def test_ultraviolet_that_was_not_measured_is_asked_for(first):
    """Under light down to 300 nm: no spectrum is continued in silence."""
    short = Spectrum([first, 700], [0.3, 0.5])
    scene = omma.scene.with_reflectance(ground(Material("petal")), "petal", short)
    light = omma.light.uniform_sky(1e17)
    with pytest.raises(
        omma.Error, match=r'ultraviolet: .* a spectrum that does not rea.*: "petal"'
    ):
        omma.World(scene, light=light)
    visible = omma.light.uniform_sky(1e17, bands=omma.light.Bands.equal(12, 400, 700))
    omma.World(scene, light=visible)
