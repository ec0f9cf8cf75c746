"""What receptors make of light in bands: matrices, photons, polarisation, and how wrong it is."""

import numpy as np
import pytest
from conftest import make_eye

import omma
from omma.light import Bands
from omma.receptors import ReceptorType
from omma.receptors.solid_angles import receptor_coupling_efficiency

RANGE_NM = np.linspace(300, 700, 400_001)


def bee(count=6):
    eye = make_eye(count).replace(
        facet_diameter_m=20e-6, acceptance_angle_rad=np.full(count, 0.045)
    )
    return omma.receptors.assign_receptors(eye, omma.receptors.honeybee_ommatidia(), seed=1)


def test_bands_side_by_side_weigh_as_their_edges_do():
    eye = bee()
    bands = Bands.equal(16)
    np.testing.assert_array_equal(
        omma.receptors.receptor_matrix(eye, bands=bands),
        omma.receptors.receptor_matrix(eye, edges_nm=bands.edges_nm),
    )


def test_a_receptor_that_sees_nothing_from_300_to_700_nm_is_refused():
    infrared = ReceptorType(
        "infrared",
        wavelength_nm=[710, 750, 800],
        sensitivity=[0.5, 1, 0.5],
        absorption_per_m=6700.0,
        length_m=2e-4,
    )
    for options in ({}, {"bands": Bands.equal(16)}, {"edges_nm": [300, 500, 700]}):
        with pytest.raises(omma.Error, match="'infrared': expected a sensitivity between 300 and"):
            omma.receptors.receptor_matrix(infrared, **options)
    eye = bee().replace(receptor_types=[infrared], receptors=[[0]] * 6)
    light = omma.light.uniform_sky(1e16)
    with pytest.raises(omma.Error, match="'infrared': expected a sensitivity between 300 and"):
        omma.receptors.photon_catch(eye, np.ones(6), light, integration_time_s=0.03)


def test_one_band_per_receptor_gives_its_answer_at_once():
    eye = bee()
    nm = np.arange(300, 701.0)
    sensitivities = [omma.receptors.spectral_sensitivity(one, nm) for one in eye.receptor_types]
    bands = Bands.from_sensitivities(nm, sensitivities)
    matrix = omma.receptors.receptor_matrix(eye, bands=bands)
    # Steps of 1 nm, linear between, for sensitivities that are smooth.
    np.testing.assert_allclose(matrix, np.eye(3), atol=1e-4)


def test_a_matrix_of_bands_is_asked_for_one_way():
    with pytest.raises(omma.Error, match="edges_nm: not together with bands"):
        omma.receptors.receptor_matrix(bee(), edges_nm=[300, 700], bands=Bands.equal())
    with pytest.raises(omma.Error, match="ultraviolet: is for RGB; not together with bands"):
        omma.receptors.receptor_matrix(bee(), (0, 0, 1), bands=Bands.equal())


def test_photons_caught_of_a_flat_spectrum():
    eye = bee()
    light = omma.light.uniform_sky(3e17)
    matrix = omma.receptors.receptor_matrix(eye, bands=light.bands)
    seen = light.radiance((0, 1, 0))[0]
    responses = (matrix @ seen)[eye.receptor_type]
    found = omma.receptors.photon_catch(eye, responses[None], light, integration_time_s=0.015)
    assert found.shape == (1, len(eye.receptor_type))
    land = omma.receptors.photon_catch(
        eye, responses, light, integration_time_s=0.015, field="land"
    )
    # Summed in steps of 1 pm: (π/4) D² Ω ∫ L (1 - exp(-k a l)) dλ t / 8 of eight cells that share
    # a rhabdom, of Gaussians so narrow that
    # Ω = π/(4 ln 2) Δρ² to Δρ²/(16 ln 2), 2e-4; Land's is (π/4) Δρ².
    for receptor, one in enumerate(eye.receptor_types):
        absorbance = omma.receptors.govardovskii(one.peak_wavelength_nm, RANGE_NM)
        absorbed = -np.expm1(-one.absorption_per_m * one.length_m * absorbance)
        integral = np.trapezoid(absorbed, RANGE_NM) * 3e17
        angle = float(np.float32(0.045))  # as the eye holds it
        diameter = float(np.float32(20e-6))
        per_sr = np.pi / 4 * diameter**2 * integral * 0.015 / 8
        here = eye.receptor_type == receptor
        expected = per_sr * np.pi / 4 * angle**2
        np.testing.assert_allclose(land[here], expected, rtol=1e-5)
        np.testing.assert_allclose(found[0, here], expected / np.log(2), rtol=3e-4)


def test_photons_caught_of_a_table():
    one = ReceptorType(
        "box", wavelength_nm=[399, 400, 500, 501], sensitivity=[0, 2, 2, 0],
        absorption_per_m=5000, length_m=2e-4,
    )  # fmt: skip
    eye = make_eye(2).replace(facet_diameter_m=20e-6, receptor_types=[one], receptors=[[0], [0]])
    light = omma.light.uniform_sky(1e17)
    found = omma.receptors.photon_catch(eye, [1e17, 2e17], light, integration_time_s=1.0)
    # A box of 101 nm that absorbs 1 - e^-1 at its top.
    S = omma.receptors.receptor_optical_sensitivity(  # noqa: N806
        eye, monochromatic=True, field="acceptance"
    )
    np.testing.assert_allclose(found, S * 101 * np.array([1e17, 2e17]), rtol=1e-6)


def test_catches_need_photons_and_what_an_eye_knows():
    eye = bee()
    answers = np.ones(len(eye.receptor_type))
    light = omma.light.uniform_sky()
    with pytest.raises(omma.Error, match="light: expected one in photons"):
        omma.receptors.photon_catch(
            eye, answers, omma.light.uniform_sky(unit="watts"), integration_time_s=1
        )
    with pytest.raises(omma.Error, match="integration_time_s: expected a number above 0"):
        omma.receptors.photon_catch(eye, answers, light, integration_time_s=0)
    with pytest.raises(omma.Error, match="responses: expected shape"):
        omma.receptors.photon_catch(eye, answers[1:], light, integration_time_s=1)
    for bad in (-1.0, np.nan, np.inf):
        given = np.stack([answers, answers])
        given[1, 2] = bad
        with pytest.raises(omma.Error, match=rf"responses: expected finite .* {bad:g} at \[1, 2\]"):
            omma.receptors.photon_catch(eye, given, light, integration_time_s=1)
    with pytest.raises(omma.Error, match=r"lacks .*any receptors"):
        omma.receptors.photon_catch(make_eye(3), answers, light, integration_time_s=1)
    with pytest.raises(omma.Error, match="lacks facet_diameter_m of 6 of 6 ommatidia"):
        omma.receptors.photon_catch(
            eye.replace(facet_diameter_m=np.zeros(len(eye))), answers, light, integration_time_s=1
        )


# Each kind with ∫ S dω in closed form; of an Airy disc 4 λ²/(π D²) over all that is seen, which
# its cut at the 64th dark ring and the sphere leave to a percent.
def gaussian_sr(width):
    theta = np.linspace(0, min(np.pi, 5 * width), 200_001)
    return 2 * np.pi * np.trapezoid(np.exp(-4 * np.log(2) * (theta / width) ** 2) * np.sin(theta),
                                    theta)  # fmt: skip


ACCEPTANCES = {
    "gaussian": (omma.Acceptance.gaussian(0.05), gaussian_sr(0.05), 1e-6),
    "wide gaussian": (omma.Acceptance.gaussian(1.0), gaussian_sr(1.0), 1e-6),
    "ellipse": (
        omma.Acceptance.gaussian(0.05, 0.02), np.pi / (4 * np.log(2)) * 0.05 * 0.02, 1e-3
    ),
    "pillbox": (omma.Acceptance.pillbox(0.4), 2 * np.pi * (1 - np.cos(0.2)), 1e-9),
    "airy": (omma.Acceptance.airy(20e-6, 500), 4 * 500e-9**2 / (np.pi * 20e-6**2), 0.01),
    "cone": (  # 1 - θ/a
        omma.Acceptance.table([0, 0.1], [1, 0]), 2 * np.pi * (1 - np.sin(0.1) / 0.1), 1e-4
    ),
    "ring": (  # nothing on the axis: sums of straight lines, nearly flat
        omma.Acceptance.table([0, 0.01, 0.02], [0, 1, 0]), 2 * np.pi * 1e-4, 1e-3
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", ACCEPTANCES)
def test_the_solid_angle_of_each_kind(kind):
    acceptance, expected, near = ACCEPTANCES[kind]
    assert omma.receptors.solid_angle_sr(acceptance) == pytest.approx(expected, rel=near)
    eye = bee().replace(acceptance=acceptance)
    found = omma.receptors.receptor_solid_angle_sr(eye)
    assert found == pytest.approx(np.full(len(eye.receptor_type), expected), rel=near)


def test_a_catch_is_the_light_that_enters():
    """Of a rendered field: a spot of 0.01 sr that fills a wide pillbox's middle, and an even one;
    photons are radiance times facet, solid angle and time, whatever S is."""
    eye = bee(4).replace(acceptance=omma.Acceptance.pillbox(0.5))
    light = omma.light.uniform_sky(1e17)
    count = len(eye.receptor_type)
    green = [one.name for one in eye.receptor_types].index("green")
    here = eye.receptor_type == green
    share = 0.01 / (2 * np.pi * (1 - np.cos(0.25)))  # of S, so the response to the spot
    caught = omma.receptors.photon_catch(
        eye, np.stack([np.full(count, 1e17), np.full(count, share * 1e17)]), light,
        integration_time_s=1.0,
    )[:, here]  # fmt: skip
    one = eye.receptor_types[green]
    absorbed = -np.expm1(-one.absorption_per_m * one.length_m * omma.receptors.govardovskii(
        one.peak_wavelength_nm, RANGE_NM))  # fmt: skip
    of_a_sr = np.pi / 4 * 20e-6**2 * np.trapezoid(absorbed, RANGE_NM) * 1e17 / 8
    assert caught[1] == pytest.approx(0.01 * of_a_sr, rel=1e-5)  # the spot's own solid angle
    assert caught[0] == pytest.approx(2 * np.pi * (1 - np.cos(0.25)) * of_a_sr, rel=1e-5)


def test_solid_angles_of_widths_and_of_receptors_own():
    widths = np.array([[0.0, 1e-4], [0.05, 2.0]])
    found = omma.receptors.solid_angle_sr(widths)
    assert found[0, 0] == 0
    for width, one in zip(widths.ravel()[1:], found.ravel()[1:]):
        assert one == pytest.approx(gaussian_sr(width), rel=1e-5)
    assert found[1, 0] == pytest.approx(
        float(omma.receptors.solid_angle_sr(omma.Acceptance.gaussian(0.05))), rel=1e-6
    )
    with pytest.raises(omma.Error, match=r"eye\.acceptance_angle_rad"):
        omma.receptors.solid_angle_sr(bee())
    own = ReceptorType("own", peak_wavelength_nm=500, acceptance=omma.Acceptance.pillbox(0.4))
    plain = ReceptorType("plain", peak_wavelength_nm=500)
    eye = make_eye(2).replace(
        acceptance_angle_rad=0.05, receptor_types=[own, plain], receptors=[[0, 1], [1]]
    )
    assert omma.receptors.receptor_solid_angle_sr(eye) == pytest.approx(
        [2 * np.pi * (1 - np.cos(0.2)), found[1, 0], found[1, 0]], rel=1e-6
    )
    land = omma.receptors.receptor_solid_angle_sr(eye, field="land")
    assert land == pytest.approx(np.pi / 4 * np.array([0.4, 0.05, 0.05]) ** 2, rel=1e-6)
    with pytest.raises(omma.Error, match="found a compoundray, which is infinite"):
        omma.receptors.solid_angle_sr(omma.Acceptance.compoundray(0.05))
    with pytest.raises(omma.Error, match="expected widths of 0 to 2π"):
        omma.receptors.solid_angle_sr([-0.1])
    with pytest.raises(omma.Error, match="field: expected one of acceptance, land"):
        omma.receptors.receptor_solid_angle_sr(eye, field="warrant")


def even_light(eye, light):
    """What each receptor answers to light that is the same everywhere."""
    matrix = omma.receptors.receptor_matrix(eye, bands=light.bands)
    return (matrix @ light.radiance((0, 1, 0))[0])[eye.receptor_type]


# Of which animal what is taken; Holcocephala has no receptors, so that it gets a blowfly's.
DONORS = {"holcocephala": ("calliphora", "honeybee_worker")}


@pytest.mark.parametrize("name", omma.species.names())
def test_photons_of_every_animal(name):
    """f (π/4) D² Ω t L ∫ (1 - exp(-k a l)) dλ of light that is the same everywhere, f its share of
    the rhabdom, times what gets into it."""
    animal = omma.species.make(name, assume=DONORS.get(name, "honeybee_worker"))
    eye, light = animal.eye, omma.light.uniform_sky(1e17)
    caught = omma.receptors.photon_catch(
        eye, even_light(eye, light), light, integration_time_s=0.01
    )
    assert caught.shape == (len(eye.receptor_type),)
    own = omma.species.make(name).eye.receptor_types
    lengths = {one.length_m for one in own if one.length_m} or {
        {"holcocephala": 250e-6}.get(name, 320e-6)
    }
    diameter = eye.facet_diameter_m[omma.receptors.ommatidium_of_receptor(eye)].astype(float)
    per_nm = np.pi / 4 * diameter**2 * omma.receptors.receptor_solid_angle_sr(eye) * 0.01 * 1e17
    per_nm *= omma.receptors.rhabdom_share(eye) * receptor_coupling_efficiency(eye)
    peaks = np.array([one.peak_wavelength_nm for one in eye.receptor_types])[eye.receptor_type]
    for peak in np.unique(peaks):
        absorbance = omma.receptors.govardovskii(peak, RANGE_NM[::100])
        (length,) = lengths
        width = np.trapezoid(-np.expm1(-6700 * length * absorbance), RANGE_NM[::100])
        # Steps of 0.1 nm here and of 0.25 nm there, of spectra tens of nm wide.
        np.testing.assert_allclose(caught[peaks == peak], width * per_nm[peaks == peak], rtol=1e-5)


def test_no_more_is_caught_than_enters():
    """Cells of one rhabdom divide its light: how many there are changes nothing in their sum, and
    rhabdoms of any depth catch at most what the lens lets in."""
    light = omma.light.uniform_sky(1e17, bands=Bands.from_edges([300, 530, 550, 700]))
    entering = np.pi / 4 * 20e-6**2 * omma.receptors.solid_angle_sr([0.045])[0] * 1e17 * 20
    sums = []
    for cells in (1, 6, 24):
        one = ReceptorType("deep", peak_wavelength_nm=540, absorption_per_m=1e5, length_m=1e-2)
        eye = make_eye(1).replace(
            facet_diameter_m=20e-6, acceptance_angle_rad=0.045,
            receptor_types=[one], receptors=[[0] * cells],
        )  # fmt: skip
        seen = (omma.receptors.receptor_matrix(eye, bands=light.bands) @ [0, 1e17, 0])[[0] * cells]
        caught = omma.receptors.photon_catch(eye, seen, light, integration_time_s=1.0)
        sums.append(caught.sum())
    # exp(-1000) is let through; single precision of the eye.
    assert sums == pytest.approx([entering] * 3, rel=1e-5)
    for name in omma.species.names():
        eye = omma.species.make(name, assume=DONORS.get(name, "honeybee_worker")).eye
        share = omma.receptors.rhabdom_share(eye)
        # Receptors that look along the axis of their ommatidium, which shares are of one window.
        along = np.array([t.right_rad == t.up_rad == 0 for t in eye.receptor_types])
        here = along[eye.receptor_type]
        of = omma.receptors.ommatidium_of_receptor(eye)[here]
        assert np.bincount(of, share[here])[np.unique(of)] == pytest.approx(1), name
        assert (share[~here] == 1).all()  # flies' R1-6


@pytest.mark.parametrize("diameter_um", [0.65, 1.0, 1.4])
def test_a_waveguide_of_one_mode_catches_no_more_than_it_carries(diameter_um):
    """The antenna theorem: area times solid angle is at most λ² for each mode; and of a rhabdom
    that takes what falls on its tip it is (π/4)² D² (d/f)²."""
    light = omma.light.uniform_sky(1e17, bands=Bands.from_edges([300, 475, 485, 700]))
    deep = ReceptorType("deep", peak_wavelength_nm=480, absorption_per_m=1e5, length_m=1e-2)

    def caught(acceptance):
        eye = make_eye(1).replace(
            facet_diameter_m=15e-6, acceptance=acceptance, receptor_types=[deep], receptors=[[0]]
        )
        seen = omma.receptors.receptor_matrix(eye, bands=light.bands) @ [0, 1e17, 0]
        return float(
            omma.receptors.photon_catch(eye, seen, light, integration_time_s=1.0)[0]
        ) / (1e17 * 10)  # fmt: skip

    waveguide = omma.Acceptance.lens_rhabdom(15e-6, 25e-6, diameter_um * 1e-6, 480)
    assert 0.005 < caught(waveguide) / 480e-9**2 < (1 if diameter_um <= 1 else 3)
    tip = omma.Acceptance.lens_rhabdom(15e-6, 55e-6, diameter_um * 1e-6, 480, model="geometric")
    etendue = (np.pi / 4 * 15e-6 * diameter_um / 55) ** 2
    # Tails of an Airy pattern far out, of which sin θ is not θ.
    assert caught(tip) == pytest.approx(etendue, rel=2e-3)


def test_what_is_taken_from_another_animal_is_said():
    plain = omma.species.bumblebee()
    taken = omma.species.bumblebee(assume="honeybee_worker")
    assert plain.assumed == ()
    assert taken.assumed == (
        "rhabdom length 320 µm, as of honeybee_worker (measured)",
        "absorption 0.0067 /µm, as of honeybee_worker (assumed)",
    )
    assert "assumed from honeybee_worker" in repr(taken)
    assert taken.assumed[0] in taken._repr_html_()
    # All else is kept, also what an animal has itself.
    assert np.array_equal(plain.eye.axis, taken.eye.axis)
    assert plain.eye.receptor_types[0].length_m == 0
    fly = omma.species.calliphora(assume="honeybee_worker")
    assert {one.length_m for one in fly.eye.receptor_types} == {250e-6}
    for before, after in zip(omma.species.calliphora().eye.receptor_types, fly.eye.receptor_types):
        for field in ("name", "peak_wavelength_nm", "right_rad", "up_rad", "length_m"):
            assert getattr(before, field) == getattr(after, field)
    robber = omma.species.holcocephala(assume=("calliphora", "honeybee_worker"))
    assert [t.peak_wavelength_nm for t in robber.eye.receptor_types] == [490, 350, 440, 520]
    assert robber.assumed[0].startswith("one receptor of each pigment of calliphora (490, 350,")
    bee = omma.species.honeybee_worker(assume="bumblebee")
    # It lacks nothing that photons are counted by; only the time is the bumblebee's.
    assert bee.assumed == (
        "integration time of ultraviolet 12.3 ms, as of bumblebee (measured)",
        "integration time of blue 9.8 ms, as of bumblebee (measured)",
        "integration time of green 7.9 ms, as of bumblebee (measured)",
    )
    assert bee.eye.receptor_types == omma.species.honeybee_worker().eye.receptor_types


def test_animals_that_do_not_have_a_number_give_none():
    with pytest.raises(
        omma.Error, match=r"whose absorption is known \(honeybee_worker\), found cal"
    ):
        omma.species.drosophila(assume="calliphora")
    with pytest.raises(omma.Error, match="assume: expected an animal with receptors"):
        omma.species.holcocephala(assume="holcocephala")
    with pytest.raises(omma.Error, match=r"expected one of .* found 'wasp'"):
        omma.species.drosophila(assume="wasp")
    with pytest.raises(omma.Error, match="assume: expected one animal or more, found none"):
        omma.species.assume_rhabdoms(bee(), ())
    with pytest.raises(TypeError, match="assume: expected the name of an animal, or several, foun"):
        omma.species.drosophila(assume=3)


def test_eyes_of_ones_own_take_rhabdoms():
    eye = make_eye(3).replace(
        receptor_types=[
            ReceptorType("a", peak_wavelength_nm=400, microvillus_angle_rad=0.3, length_m=1e-4),
            ReceptorType("b", wavelength_nm=[400, 500, 600], sensitivity=[0, 1, 0]),
        ],
        receptors=[[0, 1]] * 3,
        facet_diameter_m=[2e-5, 0, 0],
    )
    with pytest.warns(UserWarning, match="rhabdom length of b 320 µm, as of honeybee_worker"):
        whole = omma.species.assume_rhabdoms(eye, "honeybee_worker")
    first, second = whole.receptor_types
    assert (first.length_m, first.microvillus_angle_rad) == (1e-4, 0.3)
    assert (second.length_m, list(second.sensitivity)) == (pytest.approx(320e-6), [0, 1, 0])
    assert {one.absorption_per_m for one in whole.receptor_types} == {6700}
    median = np.median(omma.species.honeybee_worker().eye.facet_diameter_m)
    np.testing.assert_array_equal(whole.facet_diameter_m, np.float32([2e-5, median, median]))
    light = omma.light.uniform_sky(1e17)
    omma.receptors.photon_catch(whole, even_light(whole, light), light, integration_time_s=0.01)


def test_what_lacks_is_told_with_whose_it_is_and_the_way_out():
    drone, light = omma.species.honeybee_drone().eye, omma.light.uniform_sky()

    def said(eye, responses=1.0):
        with pytest.raises(omma.Error) as error:
            omma.receptors.photon_catch(eye, responses, light, integration_time_s=1)
        return str(error.value)

    # Also where the responses are of another number: what lacks comes first.
    text = said(drone)
    assert "honeybee_drone lacks absorption_per_m of the receptors ultraviolet, blue, green" in text
    assert "length_m of the receptors ultraviolet, blue, green" in text
    assert "facet_diameter_m" not in text
    assert "omma.species.honeybee_drone(assume='honeybee_worker').eye" in text
    assert "honeybee_drone lacks" in said(drone.select(1))
    assert "holcocephala lacks any receptors" in said(omma.species.holcocephala().eye)
    few = said(drone.take(np.arange(5)))
    assert "it lacks" in few
    assert "omma.species.assume_rhabdoms(eye, 'honeybee_worker')" in few
    assert "facet_diameter_m of 6 of 6" in said(bee().replace(facet_diameter_m=np.zeros(6)))
    eye = bee()
    assert "take responses[..., eye.receptor_type]" in said(eye, np.ones((2, 3)))
    assert "take those of render_receptors" in said(eye, np.ones((2, 6)))
    # As computed, so that a number that is added is found.
    animals = omma.species.with_catches()
    assert "honeybee_worker" in animals
    for name in omma.species.names():
        eye = omma.species.make(name).eye
        known = bool(eye.receptor_types) and all(
            one.length_m > 0 and one.absorption_per_m > 0 for one in eye.receptor_types
        )
        assert (name in animals) == (known and bool((eye.facet_diameter_m > 0).all()))


def test_catches_by_integration_time():
    animal = omma.species.bumblebee(assume="honeybee_worker")
    eye, light = animal.eye, omma.light.uniform_sky(1e17)
    answers = even_light(eye, light)
    one_second = omma.receptors.photon_catch(eye, answers, light, integration_time_s=1)
    own = omma.receptors.photon_catch(
        eye, answers, light, integration_time_s=animal.integration_time_s
    )
    # Skorupski and Chittka 2010: green 7.9, blue 9.8, ultraviolet 12.3 ms.
    times = {"green": 0.0079, "blue": 0.0098, "ultraviolet": 0.0123}
    expected = np.array([times[one.name] for one in eye.receptor_types])[eye.receptor_type]
    np.testing.assert_allclose(own, one_second * expected, rtol=1e-12)
    # The table's number is that of the model's filters, printed to a tenth.
    blowfly = omma.species.calliphora().integration_time_s
    width = omma.photoreceptors.published_response("blowfly").full_width_s
    np.testing.assert_allclose(blowfly, width, atol=0.05e-3)
    # Of an animal without: of the first that has it, by receptor before for all.
    worker = omma.species.honeybee_worker(assume=("bumblebee", "calliphora")).integration_time_s
    assert sorted(set(worker)) == pytest.approx([0.0079, 0.0098, 0.0123])
    ant = omma.species.melophorus(assume=("honeybee_worker", "calliphora"))
    np.testing.assert_allclose(ant.integration_time_s, 0.0074)
    with pytest.raises(
        omma.Error, match="melophorus: its integration time is not known of the rec"
    ):
        omma.species.melophorus().integration_time_s  # noqa: B018
    with pytest.raises(omma.Error, match="expected one number or 77232, one for each receptor"):
        omma.receptors.photon_catch(eye, answers, light, integration_time_s=[1, 2])
    with pytest.raises(omma.Error, match="integration_time_s: expected numbers above 0, found -1"):
        omma.receptors.photon_catch(eye, answers, light, integration_time_s=-expected / expected)


def test_microvilli():
    types = [
        ReceptorType("a", peak_wavelength_nm=350, polarisation_sensitivity=6.3),
        ReceptorType(
            "b", peak_wavelength_nm=350, polarisation_sensitivity=6.3, microvillus_angle_rad=0.4
        ),
        ReceptorType("c", peak_wavelength_nm=540),
    ]
    eye = make_eye(2).replace(receptor_types=types, receptors=[[0, 1], [2]])
    share, angle = omma.receptors.polarisation_weights(eye)
    np.testing.assert_allclose(share, [5.3 / 7.3, 5.3 / 7.3, 0])  # 0.726
    np.testing.assert_allclose(angle, [0, 0.4, 0])
    # Fully polarised light: the best angle gives PS times what the worst gives.
    turn = np.linspace(0, np.pi, 1801)
    seen = 1 + share[1] * (np.cos(2 * turn) * np.cos(0.8) + np.sin(2 * turn) * np.sin(0.8))
    assert seen.max() / seen.min() == pytest.approx(6.3, rel=1e-4)
    assert turn[np.argmax(seen)] == pytest.approx(0.4, abs=2e-3)
    with pytest.raises(omma.Error, match="eye: expected one with receptors"):
        omma.receptors.polarisation_weights(make_eye(2))


def test_no_reflection_and_flat_light_have_no_error():
    eye = bee()
    flat = omma.light.uniform_sky()
    assert omma.receptors.band_error(flat, eye, Bands.equal(4), reflections=0).worst < 1e-4
    grey = ([300, 700], [[0.3, 0.3]])
    assert omma.receptors.band_error(flat, eye, Bands.equal(4), grey).worst < 1e-4


def test_the_error_of_two_bands_by_hand():
    # Sensitivity and reflectance rise together over 400 to 500 nm: the product of means is 1/4,
    # the mean of products is 1/3.
    one = ReceptorType("ramp", wavelength_nm=[400, 500], sensitivity=[0, 1])
    ramp = ([300, 400, 500, 501, 700], [[0, 0, 1, 0, 0]])
    found = omma.receptors.band_error(
        omma.light.uniform_sky(), one, Bands.from_edges([400, 500]), ramp
    )
    assert found.relative_error.shape == (1, 1, 1)
    # Against bands of 5 nm, whose own error is (5/100)²/4 of it.
    assert found.worst == pytest.approx(0.25, abs=1e-3)
    assert found.rms == found.worst


def test_reflectances_out_of_range():
    light, eye = omma.light.uniform_sky(), bee()
    for wrong in (([300, 700], [[0, 1.5]]), ([300, 700], [[-0.1, 1]]), 3, ([300, 700], [[1]])):
        with pytest.raises(omma.Error, match="reflectances"):
            omma.receptors.band_error(light, eye, None, wrong)
    with pytest.raises(omma.Error, match="spectrum: expected values from"):
        omma.receptors.band_error(light, eye, None, ([400, 700], [[1, 1]]))
    with pytest.raises(omma.Error, match="light: expected one that is not dark"):
        omma.receptors.band_error(omma.light.uniform_sky(0), eye)


def test_a_honeybee_to_assume_of_is_the_worker():
    one, other = (omma.species.melophorus(assume=name) for name in ("honeybee", "honeybee_worker"))
    assert one.assumed == other.assumed != ()


def test_superposition_eyes_catch_by_their_aperture():
    """Land 1981: of all facets through which light comes to one rhabdom, (400/20)² as much."""
    eye = bee()
    light = omma.light.uniform_sky(1e15)
    wide = eye.replace(aperture_diameter_m=np.full(len(eye), 400e-6))
    caught = [
        omma.receptors.photon_catch(one, even_light(one, light), light, integration_time_s=0.01)
        for one in (eye, wide)
    ]
    assert caught[1] == pytest.approx(400 * caught[0], rel=1e-5)
    alone = wide.replace(facet_diameter_m=np.zeros(len(eye)))
    found = omma.receptors.photon_catch(
        alone, even_light(alone, light), light, integration_time_s=0.01
    )
    assert np.array_equal(found, caught[1])


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ((25e-6, 1.5, 1e-4, 6700), "acceptance_angle_rad: 1.5 rad .* 1.5° would be 0.02618 rad"),
        ((25e-6, 0.026, 1e-4, 0.0067), "absorption_per_m: .* 0.0067 per µm would be 6700 per m"),
        ((25.0, 0.026, 1e-4, 6700), "facet_diameter_m: .* 25 µm would be 2.5e-05 m"),
        ((25e-6, 0.026, 100.0, 6700), "length_m: .* 100 µm would be 0.0001 m"),
    ],
)
def test_numbers_in_another_unit_are_told(numbers, words):
    with pytest.warns(UserWarning, match=words):
        omma.receptors.optical_sensitivity(*numbers)
