"""Receptors: sensitivities, the matrix from RGB, and rendering what they answer."""

import numpy as np
import pytest

import omma
from omma.rendering import receptor_frames

UV, BLUE, GREEN = (
    omma.receptors.ReceptorType(name, peak_wavelength_nm=peak)
    for name, peak in (("uv", 344), ("blue", 436), ("green", 544))
)
# CIE 1931 colour matching functions and illuminant D65 (CIE 15:2004) at 400, 410, ... 700 nm: the
# tables, where the primaries were made with a fit to them.
CIE_X = """
.01431 .04351 .13438 .2839 .34828 .3362 .2908 .19536 .09564 .03201 .0049 .0093 .06327 .1655
.2904 .43345 .5945 .7621 .9163 1.0263 1.0622 1.0026 .85445 .6424 .4479 .2835 .1649 .0874 .04677
.0227 .011359"""
CIE_Y = """
.000396 .00121 .004 .0116 .023 .038 .06 .09098 .13902 .20802 .323 .503 .71 .862 .954 .99495
.995 .952 .87 .757 .631 .503 .381 .265 .175 .107 .061 .032 .017 .00821 .004102"""
CIE_Z = """
.06785 .2074 .6456 1.3856 1.74706 1.77211 1.6692 1.28764 .81295 .46518 .272 .1582 .07825
.04216 .0203 .00875 .0039 .0021 .00165 .0011 .0008 .00034 .00019 .00005 .00002 0 0 0 0 0 0"""
D65 = """
82.7549 91.486 93.4318 86.6823 104.865 117.008 117.812 114.861 115.923 108.811 109.354
107.802 104.79 107.689 104.405 104.046 100 96.3342 95.788 88.6856 90.0062 89.5991 87.6987 83.2886
83.6992 80.0268 80.2146 82.2778 78.2842 69.7213 71.6091"""


def one_line(*types, **others):
    """Three ommatidia looking ahead, right and up-left, each with these receptors."""
    axis = np.array([[0, 0, -1], [1, 0, 0], [-0.5, 0.5, -0.5]])
    return omma.Eye(
        np.zeros((3, 3)),
        axis,
        np.radians([3, 5, 8]),
        receptor_types=list(types),
        receptors=list(range(len(types))),
        **others,
    )


@pytest.fixture(scope="module")
def colourful(scene):
    """A renderer whose background is another colour in every direction."""
    background = omma.Background.test_pattern()
    return omma.Renderer(scene, one_line(GREEN), omma.Fixed(16), background=background, threads=2)


def test_spectral_sensitivity_takes_any_shape():
    nm = np.array([[344.0, 436, 500], [544, 600, 700]])
    values = omma.receptors.spectral_sensitivity(GREEN, nm)
    assert values.shape == nm.shape
    assert values[1, 0] == pytest.approx(omma.receptors.spectral_sensitivity(544, 544.0))
    assert np.array_equal(values, omma.receptors.govardovskii(544, nm))
    alpha = omma.receptors.govardovskii(544, nm, beta=False)
    assert np.allclose(
        alpha + omma.receptors.govardovskii(544, nm, alpha=False), values, rtol=1e-15
    )
    # Half the peak's wavelength away x is 1.25: by the formula as it is printed.
    x, a = 544 / 435.2, 0.8795 + 0.0459 * np.exp(-(244**2) / 11940)
    by_hand = (
        np.exp(69.7 * (a - x)) + np.exp(28 * (0.922 - x)) + np.exp(-14.9 * (1.104 - x)) + 0.674
    )
    assert omma.receptors.govardovskii(544, 435.2, beta=False) == pytest.approx(
        1 / by_hand, rel=1e-12
    )


def test_thick_rhabdoms_are_sensitive_to_more_of_the_spectrum():
    nm = np.arange(300, 701)
    thick = omma.receptors.ReceptorType(
        "thick", peak_wavelength_nm=544, absorption_per_m=6700, length_m=320e-6
    )
    depth, a = 6700 * 320e-6, omma.receptors.govardovskii(544, nm)
    expected = (1 - np.exp(-depth * a)) / (1 - np.exp(-depth))
    assert np.allclose(omma.receptors.spectral_sensitivity(thick, nm), expected, rtol=1e-12)


@pytest.mark.parametrize("peak", [0, 299, 801, np.nan])
def test_pigments_have_their_range(peak):
    with pytest.raises(omma.Error, match="300 to 800 nm"):
        omma.receptors.govardovskii(peak, 500)


def test_primaries_have_the_colours_of_srgb():
    cmf = np.array([[float(v) for v in table.split()] for table in (CIE_X, CIE_Y, CIE_Z)])
    light = np.array([float(v) for v in D65.split()])
    xyz = cmf * light @ omma.light.primary_spectra(np.arange(400, 701, 10))
    xy = (xyz / xyz.sum(axis=0))[:2].T
    # sRGB's (IEC 61966-2-1), within what the fitted matching functions are off the tables: a
    # just noticeable difference in xy is about 0.005 there.
    assert np.allclose(xy, [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]], atol=0.005)
    # Y of the three as in sRGB, of a white of 1.
    assert np.allclose(xyz[1] / xyz[1].sum(), [0.2126, 0.7152, 0.0722], atol=0.005)
    assert omma.light.primary_spectra([399, 701]).tolist() == [[0, 0, 0], [0, 0, 0]]


def test_matrix_is_the_integral_of_sensitivity_and_primaries():
    visible, nm = np.linspace(400, 700, 30001), np.linspace(300, 700, 40001)
    matrix = omma.receptors.receptor_matrix([UV, BLUE, GREEN])
    for row, receptor in zip(matrix, (UV, BLUE, GREEN), strict=True):
        seen = omma.receptors.spectral_sensitivity(receptor, visible)[:, None]
        parts = np.trapezoid(seen * omma.light.primary_spectra(visible), visible, axis=0)
        whole = np.trapezoid(omma.receptors.spectral_sensitivity(receptor, nm), nm)
        # Steps of 0.25 nm there, of 0.01 nm here: (0.25 nm / 40 nm)² / 12 of the whole.
        assert np.allclose(row, parts / whole, atol=4e-6)
    assert matrix.sum(axis=1) == pytest.approx([0.0017, 0.671, 0.848], abs=0.001)
    assert np.array_equal(omma.receptors.receptor_matrix(one_line(GREEN, UV)), matrix[[2, 0]])
    assert omma.receptors.receptor_matrix(BLUE).shape == (1, 3)


def test_ultraviolet_is_never_invented():
    plain = omma.receptors.receptor_matrix([UV, GREEN])
    assert np.array_equal(plain, omma.receptors.receptor_matrix([UV, GREEN], ultraviolet=(0, 0, 0)))
    told = omma.receptors.receptor_matrix([UV, GREEN], ultraviolet=(0, 0.25, 0.5))
    hidden = 1 - plain.sum(axis=1, keepdims=True)  # their share below 400 nm
    assert np.allclose(told - plain, hidden * [0, 0.25, 0.5], atol=1e-12)
    assert hidden[0] > 0.99


@pytest.mark.parametrize("wrong", [1, (0, 1), (0, 0, -1), (0, 0, np.inf), np.eye(3)])
def test_ultraviolet_is_a_mix_of_channels(wrong):
    with pytest.raises(omma.Error, match="ultraviolet: expected weights of red, green, blue"):
        omma.receptors.receptor_matrix(GREEN, ultraviolet=wrong)


# Facet (µm), acceptance angle (deg), rhabdom (µm), S (µm² sr): J Exp Biol 212:2448, table 1, which
# has two digits; the next column is the formula's own value.
@pytest.mark.parametrize(
    ("diameter", "angle", "length", "published", "value"),
    [
        (20, 1.75, 320, 0.1, 0.111),  # Apis mellifera
        (24.5, 1.2, 270, 0.07, 0.0715),  # A. cerana
        (19.5, 1.1, 190, 0.03, 0.0308),  # A. florea
        (29.5, 1.8, 260, 0.21, 0.228),  # A. dorsata
    ],
)
def test_optical_sensitivity_of_bees(diameter, angle, length, published, value):
    s = omma.receptors.optical_sensitivity(1e-6 * diameter, np.radians(angle), 1e-6 * length, 6700)
    assert 1e12 * s == pytest.approx(value, rel=0.005)  # its three digits
    assert 1e12 * s == pytest.approx(published, rel=0.12)  # one digit, and rounded inputs
    at_peak = omma.receptors.optical_sensitivity(
        1e-6 * diameter, np.radians(angle), 1e-6 * length, 6700, monochromatic=True
    )
    depth = 0.0067 * length
    assert at_peak / s == pytest.approx((1 - np.exp(-depth)) * (2.3 + depth) / depth, rel=1e-12)


def test_optical_sensitivity_of_an_eyes_receptors():
    known = {"absorption_per_m": 6700, "length_m": 320e-6}
    thick = omma.receptors.ReceptorType("thick", peak_wavelength_nm=544, **known)
    wide = omma.receptors.ReceptorType(
        "wide",
        peak_wavelength_nm=344,
        acceptance=omma.Acceptance.gaussian(np.radians(4)),
        **known,
    )
    eye = one_line(thick, wide, GREEN, facet_diameter_m=[20e-6, 25e-6, 0])
    s = 1e12 * omma.receptors.receptor_optical_sensitivity(eye).reshape(3, 3)

    def of(diameter, angle, length, absorption, **others):
        return 1e12 * omma.receptors.optical_sensitivity(
            diameter, angle, length, absorption, **others
        )

    assert s[0, 0] == pytest.approx(of(20e-6, np.radians(3), 320e-6, 6700), rel=1e-6)
    assert s[1, 0] == pytest.approx(of(25e-6, np.radians(5), 320e-6, 6700), rel=1e-6)
    assert s[0, 1] == pytest.approx(of(20e-6, np.radians(4), 320e-6, 6700), rel=1e-6)
    assert np.isnan(s[:, 2]).all()  # no length
    assert np.isnan(s[2]).all()  # no facet
    peak = omma.receptors.receptor_optical_sensitivity(eye, monochromatic=True)
    expected = of(20e-6, np.radians(3), 320e-6, 6700, monochromatic=True)
    assert 1e12 * peak[0] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("unit", [1e-3, 1e-9, 10])
def test_tables_in_other_units_are_refused(unit):
    """In micrometres, metres, ångström, of which nothing within the light is left."""
    wavelength = np.linspace(301, 700, 41) * unit
    with pytest.raises(omma.Error, match="100 to 5000"):
        omma.receptors.ReceptorType("green", wavelength_nm=wavelength, sensitivity=np.ones(41))


def test_microvilli_turn_from_up_to_right():
    types = [
        omma.receptors.ReceptorType(
            str(deg), peak_wavelength_nm=350, microvillus_angle_rad=np.radians(deg)
        )
        for deg in (0, 30, 90)
    ]
    eye = one_line(*types)
    directions = omma.receptors.microvillus_direction(eye).reshape(3, 3, 3)
    # Ahead: up is +y, right +x. To the right: up is +y, right is backwards, +z.
    half, most = 0.5, np.sqrt(0.75)
    assert np.allclose(directions[0], [[0, 1, 0], [half, most, 0], [1, 0, 0]], atol=1e-6)
    assert np.allclose(directions[1], [[0, 1, 0], [0, most, half], [0, 0, 1]], atol=1e-6)
    across = np.sum(directions * eye.axis[:, None, :], axis=-1)
    assert np.allclose(across, 0, atol=1e-6)


def test_microvilli_lie_across_where_a_receptor_looks():
    aside = omma.receptors.ReceptorType(
        "R1", peak_wavelength_nm=480, right_rad=0.3, up_rad=0.1, microvillus_angle_rad=0.7
    )
    eye = one_line(aside, GREEN)
    looking, microvilli = (
        omma.receptors.receptor_axis(eye),
        omma.receptors.microvillus_direction(eye),
    )
    assert np.allclose(np.sum(looking * microvilli, axis=1), 0, atol=1e-6)
    assert np.allclose(looking[1::2], eye.axis)
    angles = np.arccos(np.sum(looking[::2] * eye.axis, axis=1))
    assert np.allclose(angles, np.hypot(0.3, 0.1), atol=1e-5)  # arc cosines of single precision


@pytest.mark.parametrize("count", [1, 2, 9])
def test_receptors_answer_together_as_they_do_alone(colourful, flight, count):
    types = [
        omma.receptors.ReceptorType(
            f"R{k}", peak_wavelength_nm=340 + 30 * k, polarisation_sensitivity=1 + k
        )
        for k in range(count)
    ]
    together = colourful.with_eye(one_line(*types)).render_receptors(flight)
    assert together.shape == (len(flight), 3 * count)
    assert together.dtype == np.float32
    for k, receptor in enumerate(types):
        alone = colourful.with_eye(one_line(receptor)).render_receptors(flight)
        assert np.array_equal(together[:, k::count], alone)


def test_responses_are_the_matrix_times_radiance(colourful, flight):
    eye = one_line(UV, BLUE, GREEN)
    renderer = colourful.with_eye(eye)
    radiance = renderer.render(flight).astype(np.float64)
    matrix = omma.receptors.receptor_matrix(eye, ultraviolet=(0, 0.1, 0.6))
    expected = np.einsum("pic,tc->pit", radiance, matrix).reshape(len(flight), -1)
    found = renderer.render_receptors(flight, ultraviolet=(0, 0.1, 0.6))
    assert np.allclose(found, expected, rtol=1e-6, atol=1e-9)  # rounded once to single precision
    assert np.array_equal(found, renderer.render_receptors(flight, matrix=matrix))
    assert not np.allclose(found, renderer.render_receptors(flight), rtol=0.01)


@pytest.mark.parametrize(
    "settings",
    [{"sampling": omma.ToError(0.02)}, {"sampling": omma.Shared()}, {"points": "random"}],
)
def test_every_way_of_rendering_will_do(colourful, flight, eye, settings):
    bee = omma.receptors.assign_receptors(eye, omma.receptors.honeybee_ommatidia())
    renderer = colourful.with_eye(bee, **settings)
    matrix = omma.receptors.receptor_matrix(bee)[bee.receptor_type]
    radiance = renderer.render(flight)[:, omma.receptors.ommatidium_of_receptor(bee)].astype(
        np.float64
    )
    expected = np.sum(radiance * matrix, axis=-1)
    assert np.allclose(renderer.render_receptors(flight), expected, rtol=1e-6, atol=1e-9)


def test_white_gives_each_receptor_its_share_of_visible_light(scene, flight):
    renderer = omma.Renderer(
        omma.load_scene(scene.path),
        one_line(UV, BLUE, GREEN),
        background=omma.Background.constant((1, 1, 1)),
    )
    high = omma.poses_from_angles((0, 1e4, 0), (0, 80, 0))  # nothing but background
    fractions = renderer.render_receptors(high).reshape(3, 3)
    assert np.allclose(
        fractions, omma.receptors.receptor_matrix(renderer.eye).sum(axis=1), rtol=1e-6
    )
    white = renderer.render_receptors(high, ultraviolet=np.full(3, 1 / 3))
    assert np.allclose(white, 1, rtol=1e-6)


def test_receptors_beside_the_axis_look_there(colourful, flight):
    right, up = 0.2, -0.1
    aside = omma.receptors.ReceptorType("aside", peak_wavelength_nm=500, right_rad=right, up_rad=up)
    eye = one_line(aside, up=[[0, 1, 0], [0, 1, 1], [1, 0, 0]])
    angle = np.hypot(right, up)
    beside = (eye.right * right + eye.up * up) / angle
    axis = eye.axis * np.cos(angle) + beside * np.sin(angle)
    moved = omma.Eye(eye.position_m, axis, eye.acceptance_angle_rad)
    found = colourful.with_eye(eye).render_receptors(flight)
    radiance = colourful.with_eye(moved).render(flight)
    # Round sensitivities, but another frame: the same estimate with other rays.
    expected = radiance @ omma.receptors.receptor_matrix(eye)[0]
    straight = (
        colourful.with_eye(one_line(GREEN)).render(flight) @ omma.receptors.receptor_matrix(eye)[0]
    )
    errors = colourful.with_eye(eye).render_receptors(flight, standard_error=True)[1]
    assert np.all(np.abs(found - expected) < 5 * np.sqrt(2 * 8) * errors + 1e-3)
    assert np.abs(straight - expected).mean() > 0.02


def test_views_that_are_all_a_receptors_own_are_rendered_as_an_eye(colourful, flight):
    """Bit for bit, as the rays are those of an eye with these acceptances."""
    pillbox = omma.Acceptance.pillbox(np.radians(10))
    own = omma.receptors.ReceptorType("own", peak_wavelength_nm=500, acceptance=pillbox)
    eye = one_line(own)
    found = colourful.with_eye(eye).render_receptors(flight)
    same = eye.replace(acceptance=pillbox, receptors=None, receptor_types=None)
    radiance = colourful.with_eye(same).render(flight).astype(np.float64)
    expected = radiance @ omma.receptors.receptor_matrix(own)[0]
    assert np.allclose(found, expected, rtol=1e-6)


def test_those_along_the_axis_keep_their_rays_among_others(colourful, flight):
    aside = omma.receptors.ReceptorType("aside", peak_wavelength_nm=500, right_rad=0.1)
    mixed = colourful.with_eye(one_line(aside, GREEN, BLUE)).render_receptors(flight)
    alone = colourful.with_eye(one_line(GREEN, BLUE)).render_receptors(flight)
    assert np.array_equal(mixed[:, [1, 2, 4, 5, 7, 8]], alone)


@pytest.mark.parametrize("offset", [{"right_rad": 0.3}, {"up_rad": 0.3}])
def test_either_offset_counts(colourful, flight, offset):
    aside = omma.receptors.ReceptorType("aside", peak_wavelength_nm=544, **offset)
    found = colourful.with_eye(one_line(aside)).render_receptors(flight)
    straight = colourful.with_eye(one_line(GREEN)).render_receptors(flight)
    assert np.abs(found - straight).mean() > 0.02


def test_another_eye_has_its_own_receptors(colourful, flight):
    first = colourful.with_eye(one_line(GREEN))
    first.render_receptors(flight)
    second = first.with_eye(one_line(UV, BLUE))
    assert np.array_equal(
        second.render_receptors(flight),
        colourful.with_eye(one_line(UV, BLUE)).render_receptors(flight),
    )


def test_receptors_in_pieces_are_the_same(colourful, flight, monkeypatch):
    renderer = colourful.with_eye(one_line(GREEN, UV), noise="new_every_frame")
    whole = renderer.render_receptors(flight)
    monkeypatch.setattr(receptor_frames, "_CHUNK_BYTES", 2 * 3 * 3 * 4)  # two poses
    assert not np.array_equal(renderer.render_receptors(flight), whole)  # the next frames
    assert np.array_equal(renderer.render_receptors(flight, first_pose=0), whole)
    assert np.array_equal(renderer.render_receptors(flight[4:], first_pose=4), whole[4:])
    both = renderer.render_receptors(flight, standard_error=True, first_pose=0)
    monkeypatch.undo()
    again = renderer.render_receptors(flight, standard_error=True, first_pose=0)
    assert np.array_equal(both, again)
    monkeypatch.setattr(receptor_frames, "_CHUNK_BYTES", 2 * 3 * 3 * 4)
    fractions = []
    renderer.render_receptors(flight, progress=fractions.append)
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1


def test_standard_errors_are_those_of_the_receptors_themselves(colourful, flight):
    """From the spread of the same eight scrambles, so bounded by what those of the bands allow."""
    eye = one_line(UV, GREEN)
    renderer = colourful.with_eye(eye)
    matrix = np.array([[1, 0, 0], [0.5, -2, 0.25]])
    responses, errors = renderer.render_receptors(flight, matrix=matrix, standard_error=True)
    radiance, sigma = renderer.render(flight, standard_error=True)
    assert np.array_equal(responses[:, ::2], radiance[..., 0])
    assert np.array_equal(errors[:, ::2], sigma[..., 0])  # one band: to the bit
    # Floats, summed ray by ray.
    assert responses[:, 1::2] == pytest.approx(radiance @ matrix[1], abs=1e-5)
    bound = sigma @ np.abs(matrix[1])
    assert np.all(errors[:, 1::2] <= bound + 1e-6)
    assert np.any(errors[:, 1::2] < 0.9 * bound)


def test_wrong_arguments_are_named(colourful, flight):
    renderer = colourful.with_eye(one_line(GREEN, UV))
    bare = one_line(GREEN).replace(receptor_types=None, receptors=None)
    with pytest.raises(omma.Error, match="expected ommatidia with receptors, found none"):
        colourful.with_eye(bare).render_receptors(flight)
    with pytest.raises(omma.Error, match=r"matrix: .* shape \(2, 3\), found \(3, 3\)"):
        renderer.render_receptors(flight, matrix=np.eye(3))
    with pytest.raises(omma.Error, match="not all of them finite"):
        renderer.render_receptors(flight, matrix=np.full((2, 3), np.nan))
    with pytest.raises(omma.Error, match="not together with matrix"):
        renderer.render_receptors(flight, matrix=np.ones((2, 3)), ultraviolet=(0, 0, 1))
    with pytest.raises(omma.Error, match=r"out: expected shape \(9, 6\)"):
        renderer.render_receptors(flight, out=np.empty((9, 3), np.float32))
    unknown = omma.receptors.ReceptorType("R9")
    with pytest.raises(omma.Error, match="'R9': expected a peak wavelength or a table"):
        colourful.with_eye(one_line(unknown)).render_receptors(flight)
    out = np.empty((9, 6), np.float32)
    assert renderer.render_receptors(flight, out=out) is out
