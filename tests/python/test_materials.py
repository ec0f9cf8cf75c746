"""Natural materials: their numbers, what was measured of them, and as materials of scenes."""

import csv
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import omma
from omma.scene.materials import STANDINGS
from omma.scene.spectrum_colours import linear_srgb, luminance

ROOT = Path(__file__).resolve().parents[2]
MATERIALS = omma.scene.natural_materials()
EACH = pytest.mark.parametrize("name", MATERIALS)


def at(name, quantity, nm):
    one = MATERIALS[name]
    return float(np.interp(nm, one.wavelength_nm, getattr(one, f"total_{quantity}")))


@EACH
def test_spectra_are_shares_of_light_from_300_to_700_nm(name):
    one = MATERIALS[name]
    assert one.wavelength_nm[[0, -1]].tolist() == [300, 700]
    for back, through in (
        (one.total_reflectance, one.total_transmittance),
        (one.reflectance, one.transmittance),
    ):
        passed = np.zeros_like(back) if through is None else through
        assert np.isfinite(back + passed).all()
        assert min(back.min(), passed.min()) >= 0
        assert (back + passed).max() <= 1


@EACH
def test_the_whole_is_gloss_and_what_gets_in(name):
    one = MATERIALS[name]
    # None reflects less than its surface does: nothing was cut off at 0.
    assert one.total_reflectance.min() >= one.surface_reflectance
    whole = one.surface_reflectance + (1 - one.surface_reflectance) * one.reflectance
    np.testing.assert_allclose(whole, one.total_reflectance, rtol=1e-12)


@EACH
def test_an_even_sky_shows_the_whole(name):
    """Seen straight on, by reciprocity what a sphere measures. Petals gave two thirds of it where
    they are dark: what got past rough facets was taken for what gets past a level surface."""
    one = MATERIALS[name]
    scene = omma.scene.plane((200, 200)).replace(materials=[omma.scene.natural_material(name)])
    sky = omma.light.uniform_sky(1.0, below=0.0)
    eye = omma.Eye([[0, 1, 0]], [[0, -1, 0]], np.radians(2))
    seen = omma.Renderer(omma.World(scene, light=sky), eye, omma.Fixed(4096)).render(np.eye(4))
    whole = sky.bands.mean(omma.light.Spectrum(one.wavelength_nm, one.total_reflectance))
    # The engine's table of what facets mirror (tests/cpp/physics_specular_albedo.cpp), and noise.
    np.testing.assert_allclose(seen[0, 0], whole, atol=1e-3)


def test_rough_facets_mirror_less_of_light_that_falls_straight_on_them():
    from omma.scene.facets import mirrored_straight

    assert mirrored_straight(0.0, 1.5) == pytest.approx(0.04, rel=1e-6)
    # By quadrature over GGX facets, of which each ray meets one.
    assert mirrored_straight(0.8, 1.4) == pytest.approx(0.0160, abs=1e-4)


@EACH
def test_every_number_has_a_standing_and_a_source(name):
    facts = MATERIALS[name].facts
    assert {fact.standing for fact in facts} <= set(STANDINGS)
    assert all(fact.source and fact.source_read for fact in facts)
    told = Counter((fact.quantity, fact.wavelength_nm) for fact in facts)
    assert max(told.values()) == 1, "a number twice"
    for quantity in ("ior", "specular", "roughness"):
        assert told[quantity, None] == 1
    for quantity in {fact.quantity for fact in facts if fact.wavelength_nm is not None}:
        assert quantity in ("reflectance", "transmittance")
        assert told[quantity, 300.0] == told[quantity, 700.0] == 1
    # Who assumes names nobody, or says what of the source it is after.
    for fact in facts:
        if fact.standing == "assumed" and "Nobody" not in fact.source:
            assert fact.note


@EACH
def test_curves_pass_through_their_numbers(name):
    for fact in MATERIALS[name].facts:
        if fact.wavelength_nm is not None and fact.wavelength_nm % 5 == 0:
            assert at(name, fact.quantity, fact.wavelength_nm) == pytest.approx(
                fact.value, rel=1e-9
            )


@pytest.mark.parametrize(
    ("name", "quantity", "low_nm", "high_nm", "least", "most"),
    [
        # Feister & Grewe 1995: albedo of vegetation, bare soil, dry sand and concrete.
        ("green sward", "reflectance", 300, 315, 0.016, 0.017),
        ("green sward", "reflectance", 350, 385, 0.0195, 0.0205),
        ("dark soil", "reflectance", 300, 400, 0.04, 0.08),
        ("light soil", "reflectance", 300, 400, 0.04, 0.08),
        ("sand", "reflectance", 300, 300, 0.14, 0.14),
        ("sand", "reflectance", 400, 400, 0.24, 0.24),
        ("sand", "reflectance", 300, 400, 0.14, 0.24),
        ("concrete", "reflectance", 300, 315, 0.07, 0.10),
        # Single leaves: 35 species.
        ("green leaf", "reflectance", 300, 300, 0.0477, 0.0861),
        ("grass blade", "reflectance", 300, 300, 0.0477, 0.0861),
        ("green leaf", "transmittance", 300, 300, 0, 0.0017),
        ("grass blade", "transmittance", 300, 300, 0, 0.0017),
        ("green leaf", "reflectance", 540, 540, 0.10, 0.15),
        ("green leaf", "transmittance", 540, 540, 0.08, 0.12),
        ("grass blade", "reflectance", 540, 540, 0.10, 0.15),
        # The common poppy reflects 0.35 at most (van der Kooi & Stavenga 2019).
        ("red petal with ultraviolet", "reflectance", 680, 680, 0.345, 0.355),
        ("red petal with ultraviolet", "reflectance", 300, 700, 0, 0.355),
    ],
)
def test_what_was_measured_is_met(name, quantity, low_nm, high_nm, least, most):
    values = [at(name, quantity, nm) for nm in np.arange(low_nm, high_nm + 1, 5)]
    assert least - 1e-12 <= min(values)
    assert max(values) <= most + 1e-12


def mean(name, low_nm, high_nm):
    one = MATERIALS[name]
    chosen = (one.wavelength_nm >= low_nm) & (one.wavelength_nm <= high_nm)
    return float(one.total_reflectance[chosen].mean())


def test_flowers_differ_in_the_ultraviolet_as_their_kinds_do():
    # Chittka et al. 1994: most white flowers absorb it, and of no flower is it more than the rest.
    assert mean("white petal", 300, 370) < 0.12 * mean("white petal", 450, 650)
    for name in MATERIALS:
        if "petal" in name:
            values = MATERIALS[name].total_reflectance
            assert values[:21].max() <= values[21:].max()
    # The guide of a yellow flower is there for a bee alone.
    outer, foot = "yellow petal with ultraviolet", "yellow petal"
    assert mean(outer, 330, 380) > 4 * mean(foot, 330, 380)
    assert mean(outer, 500, 700) == pytest.approx(mean(foot, 500, 700))
    assert mean("red petal with ultraviolet", 330, 380) > 3 * mean("red petal", 330, 380)


def test_water_is_smooth_and_polarises_at_53_degrees():
    water = MATERIALS["pond water"]
    assert np.degrees(np.arctan(water.ior)) == pytest.approx(53.12, abs=0.01)
    assert water.surface_reflectance == pytest.approx(0.0204, abs=5e-5)
    assert water.roughness <= 0.02
    # Dark below, so that its surface is most of what is seen.
    assert water.reflectance.max() < 0.02


def test_colours_are_those_people_see():
    nm = np.arange(300.0, 701.0)
    for rgb in np.eye(3):
        lifted = omma.light.primary_spectra(nm) @ rgb
        # Spectra of the primaries are the primaries, but for their own digits.
        np.testing.assert_allclose(linear_srgb(nm, lifted), rgb, atol=1e-3)
    np.testing.assert_allclose(linear_srgb(nm, np.full(len(nm), 0.5)), 0.5, atol=1e-3)
    assert luminance(np.ones(3)) == pytest.approx(1)
    order = {"green leaf": 1, "red petal": 0, "blue petal": 2, "sky-blue paint": 2, "sand": 0}
    for name, brightest in order.items():
        assert np.argmax(MATERIALS[name].base_color) == brightest


@EACH
def test_colours_for_others_add_up_to_the_spectra(name):
    one = MATERIALS[name]
    # As KHR_materials_diffuse_transmission mixes them.
    share = one.diffuse_transmission
    back = one.base_color * (1 - share)
    np.testing.assert_allclose(back, linear_srgb(one.wavelength_nm, one.reflectance), atol=1e-12)
    if one.transmittance is not None:
        through = one.diffuse_transmission_color * share
        expected = linear_srgb(one.wavelength_nm, one.transmittance)
        np.testing.assert_allclose(through, expected, atol=0.005)  # red ones reach 1 and end there


@EACH
def test_as_a_material_of_scenes(name):
    one, made = MATERIALS[name], omma.scene.natural_material(name)
    assert made.name == name
    assert (made.ior, made.specular, made.roughness) == pytest.approx(
        (one.ior, one.specular, one.roughness)
    )
    np.testing.assert_array_equal(made.reflectance.value, one.reflectance)
    assert made.spectral_luminance == pytest.approx(luminance(np.array(made.base_color[:3])))
    assert made.double_sided == (made.transmittance is not None)
    if made.transmittance is not None:
        np.testing.assert_array_equal(made.transmittance.value, one.transmittance)
        assert made.diffuse_transmission == pytest.approx(one.diffuse_transmission)


def test_an_unknown_name_is_said():
    with pytest.raises(omma.Error, match=r"name: expected one of .*did you mean 'grass blade'"):
        omma.scene.natural_material("gras blade")


def test_the_page_has_all_of_them():
    text = (ROOT / "docs" / "materials.md").read_text(encoding="utf-8")
    for name, one in MATERIALS.items():
        assert f"| {name} | {mean(name, 300, 400):.3f} |" in text
        for fact in one.facts:
            assert "Nobody" in fact.source or fact.source in text


def test_leaves_are_computed_as_the_script_does():
    pytest.importorskip("prosail", reason="prosail computes the table of leaves")
    import runpy

    script = runpy.run_path(str(ROOT / "scripts" / "make_leaf_spectra.py"))
    with script["TABLE"].open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    for name in script["LEAVES"]:
        for quantity, values in zip(("reflectance", "transmittance"), script["leaf"](name)):
            kept = [
                float(r["value"])
                for r in rows
                if (r["material"], r["quantity"]) == (name, quantity)
            ]
            np.testing.assert_allclose(values[:301:10], kept, atol=5.1e-5)  # four digits
