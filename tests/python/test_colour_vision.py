"""Colours as animals tell them apart: distances by receptor noise, colour spaces, contrasts."""

import itertools
import math
from statistics import NormalDist

import numpy as np
import pytest

import omma
from omma import colour_vision as cv

# Of the introduction to pavo 2 (Maia et al. 2019, Methods Ecol Evol 10:1097), "Analysing spectral
# data": what it prints of the reflectances of six Australian flowers. They are rounded there to
# seven digits, so that differences of them are good to 1e-7.
PUBLISHED = 2e-7
# Excitations of a honeybee's receptors, adapted to green; x, y, hue, distance from the middle.
HEXAGON = np.array([
    (0.56572097, 0.8237141, 0.7053057, 0.1208839, 0.1882007, 32.71320, 0.2236793),
    (0.35761236, 0.8176153, 0.8670134, 0.4411542, 0.2053024, 65.04388, 0.4865862),
    (0.01888788, 0.1622766, 0.7810589, 0.6600594, -0.2376968, 109.80467, 0.7015541),
    (0.21080752, 0.7345122, 0.6796464, 0.4060263, 0.2892853, 54.53092, 0.4985412),
    (0.55622758, 0.8515289, 0.8208038, 0.2291297, 0.1630132, 54.57024, 0.2812005),
    (0.45855056, 0.7828905, 0.8565895, 0.3447118, 0.1253205, 70.02119, 0.3667853),
])  # fmt: skip
SECTORS = ["blue-green", "blue-green", "green", "blue-green", "blue-green", "blue-green"]
# Distances of the first from the others, in hexagon units.
HEXAGON_CONTRAST = [0.3207265, 0.6870945, 0.3025298, 0.1111375, 0.2324927]
# Shares of a honeybee's receptors; x, y.
TRIANGLE = np.array([
    (0.2882383, 0.3587254, 0.3530363, -0.004022828, -0.05522995),
    (0.2475326, 0.3549832, 0.3974842, 0.030052720, -0.10508396),
    (0.1373117, 0.3125304, 0.5501579, 0.168028001, -0.24007647),
])  # fmt: skip
# Shares of a blue tit's cones; x, y, z; theta, phi, r and r_max.
TETRAHEDRON = np.array([
    (0.2274310, 0.2659669, 0.2524170, 0.2541851, -0.007214866, -0.005415708, -0.02256897,
     -2.4976873, -1.190529, 0.02430520, 0.2692325),
    (0.1625182, 0.2721621, 0.2828016, 0.2825182, 0.006341799, 0.003861848, -0.08748184,
     0.5469755, -1.486123, 0.08779638, 0.2508989),
    (0.0428552, 0.2443091, 0.3504414, 0.3623943, 0.072312163, 0.033297418, -0.20714480,
     0.4315247, -1.203879, 0.22191605, 0.2678272),
    (0.1766234, 0.2709785, 0.2642637, 0.2881344, 0.010505857, -0.010813615, -0.07337659,
     -0.7998327, -1.368146, 0.07490949, 0.2552227),
])  # fmt: skip
# Shares of a housefly's R7p, R7y, R8p and R8y; R7p - R8p, R7y - R8y.
FLY = np.array([
    (0.05387616, 0.18710662, 0.4335986, 0.3254187, -0.3797224, -0.1383120),
    (0.02080098, 0.08276030, 0.3737592, 0.5226795, -0.3529583, -0.4399192),
    (0.01153130, 0.02501417, 0.1420049, 0.8214496, -0.1304736, -0.7964355),
])  # fmt: skip


def matrix_formula(difference, noise):
    """ΔS of Clark et al. 2017 and Pike 2012, as it stands there: by differences of neighbouring
    classes and their covariance."""
    opponents = np.diff(np.eye(len(noise)), axis=0)
    signal = opponents @ difference
    covariance = opponents @ np.diag(np.square(noise)) @ opponents.T
    return math.sqrt(signal @ np.linalg.solve(covariance, signal))


def vorobyev_osorio(f, e):
    """ΔS of two to four classes, as Vorobyev & Osorio 1998 print them: a sum over pairs of classes,
    weighted by the noise of all others, over a sum of products of all but one."""
    n = len(f)
    above = sum(
        math.prod(e[k] for k in range(n) if k not in (i, j)) ** 2 * (f[i] - f[j]) ** 2
        for i, j in itertools.combinations(range(n), 2)
    )
    below = sum(math.prod(e[k] for k in range(n) if k != i) ** 2 for i in range(n))
    return math.sqrt(above / below)


@pytest.mark.parametrize("classes", [2, 3, 4])
def test_distances_are_those_of_vorobyev_and_osorio(classes):
    draw = np.random.default_rng(classes)
    for _ in range(20):
        one, other = draw.uniform(0.01, 1, (2, classes))
        noise = draw.uniform(0.02, 0.5, classes)
        found = cv.noise_limited_distance(one, other, noise)
        # The same sums in another order.
        assert found == pytest.approx(vorobyev_osorio(np.log(one / other), noise), rel=1e-11)
        linear = cv.noise_limited_distance(one, other, noise, signal="linear")
        assert linear == pytest.approx(vorobyev_osorio(one - other, noise), rel=1e-11)


def test_three_classes_written_out():
    e1, e2, e3 = noise = (0.12, 0.06, 0.1)
    f1, f2, f3 = np.log([0.2, 0.5, 0.9]) - np.log([0.4, 0.3, 0.8])
    squares = e1**2 * (f3 - f2) ** 2 + e2**2 * (f3 - f1) ** 2 + e3**2 * (f1 - f2) ** 2
    expected = math.sqrt(squares / ((e1 * e2) ** 2 + (e1 * e3) ** 2 + (e2 * e3) ** 2))
    found = cv.noise_limited_distance([0.2, 0.5, 0.9], [0.4, 0.3, 0.8], noise)
    assert found == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("classes", [2, 3, 5, 10])
@pytest.mark.parametrize("photons", [False, True])
def test_distances_of_any_number_of_classes_by_the_matrix_formula(classes, photons):
    draw = np.random.default_rng(classes)
    one, other = draw.uniform(10, 1000, (2, 6, classes))
    noise = cv.class_noise(0.1, draw.uniform(1, 5, classes))
    found = cv.noise_limited_distance(one, other, noise, photon_noise=photons)
    assert found.shape == (6,)
    for k in range(6):
        # pavo's noise="quantum": e² + 2/(Q_A + Q_B).
        added = 2 / (one[k] + other[k]) if photons else 0
        expected = matrix_formula(np.log(one[k] / other[k]), np.sqrt(noise**2 + added))
        assert found[k] == pytest.approx(expected, rel=1e-9)  # a matrix is solved


def test_photon_noise_of_linear_signals():
    one, other, by = np.array([90.0, 400]), np.array([110.0, 300]), np.array([200.0, 500])
    # Poisson: a class that catches the mean N has the variance N.
    variance = 0.1**2 + (one + other) / 2 / by**2
    expected = abs(np.diff((one - other) / by))[0] / math.sqrt(variance.sum())
    found = cv.noise_limited_distance(
        one, other, [0.1, 0.1], signal="linear", photon_noise=True, adapting=by
    )
    assert found == pytest.approx(expected, rel=1e-12)
    # What both have in common is no colour; near the background both signals agree to first order.
    near = by * [1.001, 1.0]
    for photons in (False, True):
        linear, log = (
            cv.noise_limited_distance(
                near, by, [0.1, 0.2], signal=signal, photon_noise=photons, adapting=by
            )
            for signal in ("linear", "log")
        )
        assert linear == pytest.approx(log, rel=1e-3)


def test_intensity_is_no_colour_and_one_class_sees_none():
    noise = cv.class_noise(0.1, [1, 2, 2, 4])
    colour = np.array([0.2, 0.3, 0.1, 0.9])
    assert cv.noise_limited_distance(colour, 7 * colour, noise) == pytest.approx(0, abs=1e-13)
    assert cv.noise_limited_distance([0.2], [0.9], [0.1]) == 0
    # Adaptation of each class by a number of its own cancels out of logarithms.
    by = [0.5, 0.9, 3.0, 1.1]
    other = np.array([0.4, 0.3, 0.2, 0.7])
    adapted = cv.noise_limited_distance(cv.von_kries(colour, by), cv.von_kries(other, by), noise)
    assert adapted == pytest.approx(cv.noise_limited_distance(colour, other, noise), rel=1e-12)


def test_more_receptors_have_less_noise():
    noise = cv.class_noise(0.1, [1, 2, 2, 4])
    assert noise.tolist() == pytest.approx([0.2, 0.1 * math.sqrt(2), 0.1 * math.sqrt(2), 0.1])
    assert cv.class_noise(0.1, [1, 2, 2, 4], reference=0)[3] == pytest.approx(0.05)


def test_achromatic_distances():
    # Of the six birds of the same page, double cones catch 0.1501 (a robin) to 0.2755 (an oriole),
    # which are printed to four digits: their distance, to 1e-4/0.15/0.1.
    assert cv.achromatic_distance(0.1501, 0.2755, 0.1) == pytest.approx(6.0716987, abs=7e-3)
    # Photon noise alone, of 10,000 and 10,100: ln 1.01 √10,050.
    found = cv.achromatic_distance(1e4, 1.01e4, 1e-6, photon_noise=True)
    assert found == pytest.approx(math.log(1.01) * math.sqrt(10_050), rel=1e-6)


def test_coordinates_keep_distances():
    draw = np.random.default_rng(5)
    for classes in (2, 3, 4, 7):
        noise = cv.class_noise(0.08, draw.uniform(1, 4, classes))
        colours = draw.uniform(0.01, 1, (5, classes))
        points = cv.noise_limited_coordinates(colours, noise)
        assert points.shape == (5, classes - 1)
        apart = np.linalg.norm(points[:, None] - points[None], axis=-1)
        expected = cv.noise_limited_distance(colours[:, None], colours[None], noise)
        np.testing.assert_allclose(apart, expected, rtol=1e-10, atol=1e-12)


def test_loci_of_published_flowers_in_the_hexagon():
    loci = cv.hexagon(HEXAGON[:, :3])
    np.testing.assert_allclose(loci, HEXAGON[:, 3:5], atol=PUBLISHED)
    # Printed to 1e-5 degrees; an angle at 0.22 from the middle is good to PUBLISHED/0.22.
    np.testing.assert_allclose(cv.hexagon_hue_deg(loci), HEXAGON[:, 5], atol=6e-5)
    assert cv.hexagon_sector(loci).tolist() == SECTORS
    found = cv.hexagon_contrast(HEXAGON[0, :3], HEXAGON[1:, :3])
    np.testing.assert_allclose(found, HEXAGON_CONTRAST, atol=PUBLISHED)
    middle = cv.hexagon_contrast(HEXAGON[:, :3], [0.5, 0.5, 0.5])
    np.testing.assert_allclose(middle, HEXAGON[:, 6], atol=PUBLISHED)


def test_corners_of_the_hexagon():
    corners = {
        "blue": (0, 1, 0), "blue-green": (0, 1, 1), "green": (0, 0, 1), "UV-green": (1, 0, 1),
        "UV": (1, 0, 0), "UV-blue": (1, 1, 0),
    }  # fmt: skip
    loci = cv.hexagon(list(corners.values()))
    np.testing.assert_allclose(np.hypot(*loci.T), 1, rtol=1e-15)
    assert cv.hexagon_hue_deg(loci).tolist() == pytest.approx([0, 60, 120, 180, 240, 300])
    assert cv.hexagon_hue_deg([-1e-20, 1]) == 0
    assert cv.hexagon_sector(loci).tolist() == list(corners)
    # 29.99° and 30.01° from the corner of blue.
    edges = np.radians([-30.01, -29.99, 29.99, 30.01])
    found = cv.hexagon_sector(np.stack([np.sin(edges), np.cos(edges)], axis=-1))
    assert found.tolist() == ["UV-blue", "blue", "blue", "blue-green"]


def test_the_background_lies_in_the_middle():
    seen = np.array([[3.0, 5.0, 9.0]])
    adapted = cv.von_kries(seen, seen[0])
    assert cv.hexagon(cv.excitations(adapted)).tolist() == [[0, 0]]
    assert cv.hexagon_sector([[0.0, 0.0], [0.0, 0.1]]).tolist() == ["uncoloured", "blue"]
    assert cv.maxwell_triangle(adapted).tolist() == [[0, 0]]
    middle = cv.tetrahedron([2.0] * 4)
    assert middle.chroma == 0
    assert middle.position.tolist() == [0, 0, 0]
    assert middle.largest_chroma == 0.75


def test_loci_of_published_flowers_in_the_triangle():
    np.testing.assert_allclose(
        cv.maxwell_triangle(TRIANGLE[:, :3]), TRIANGLE[:, 3:], atol=PUBLISHED
    )
    corners = cv.maxwell_triangle(np.eye(3))
    apart = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)
    np.testing.assert_allclose(apart, math.sqrt(2), rtol=1e-15)


def test_loci_of_published_flowers_in_the_tetrahedron():
    found = cv.tetrahedron(TETRAHEDRON[:, :4])
    np.testing.assert_allclose(found.position, TETRAHEDRON[:, 4:7], atol=PUBLISHED)
    # Angles of what lies 0.005 and more from the axis, r of all of 0.02 and more.
    np.testing.assert_allclose(found.theta_rad, TETRAHEDRON[:, 7], atol=PUBLISHED / 0.005)
    np.testing.assert_allclose(found.phi_rad, TETRAHEDRON[:, 8], atol=PUBLISHED / 0.02)
    np.testing.assert_allclose(found.chroma, TETRAHEDRON[:, 9], atol=PUBLISHED)
    np.testing.assert_allclose(found.largest_chroma, TETRAHEDRON[:, 10], rtol=PUBLISHED / 0.02)


def test_the_tetrahedron_is_regular_and_its_surface_is_where_a_class_is_dark():
    corners = cv.tetrahedron(np.eye(4)).position
    apart = np.linalg.norm(corners[:, None] - corners[None], axis=-1)[~np.eye(4, dtype=bool)]
    np.testing.assert_allclose(apart, math.sqrt(3 / 2), rtol=1e-14)
    surface = np.random.default_rng(2).dirichlet(np.ones(3), 20)
    for dark in range(4):
        found = cv.tetrahedron(np.insert(surface, dark, 0, axis=1))
        np.testing.assert_allclose(found.chroma, found.largest_chroma, rtol=1e-12)
    # Straight out from the middle of a face, a third of the way to its opposite corner.
    assert cv.tetrahedron([0, 1, 1, 1]).chroma == pytest.approx(0.25)
    assert cv.tetrahedron([0, 1, 1, 1]).phi_rad == pytest.approx(-math.pi / 2)


def test_categories_of_flies():
    in_our_order = FLY[:, [0, 2, 1, 3]]
    np.testing.assert_allclose(cv.fly_opponents(in_our_order), FLY[:, 4:], atol=PUBLISHED)
    assert cv.fly_category(in_our_order).tolist() == ["p-y-"] * 3
    every = [[2, 1, 2, 1], [2, 1, 1, 2], [1, 2, 2, 1], [1, 2, 1, 2], [1, 1, 2, 1]]
    assert cv.fly_category(every).tolist() == ["p+y+", "p+y-", "p-y+", "p-y-", "p0y+"]


def test_contrasts():
    assert cv.weber_contrast([0.0, 2.0, 6.0], 2.0).tolist() == [-1, 0, 2]
    assert cv.michelson_contrast([0.0, 2.0, 6.0, 0.0], [2.0, 2.0, 2.0, 0.0]).tolist() == [
        -1, 0, 0.5, 0
    ]  # fmt: skip


def test_d_prime_is_how_often_poisson_counts_are_told_apart():
    draw = np.random.default_rng(7)
    background = draw.uniform(20, 60, 40)
    target = background + draw.uniform(-3, 5, 40)
    expected = cv.d_prime(target, background, dark=3.0)
    assert 1.5 < expected < 3
    # In each trial one interval has the target; the observer weights each receptor by what it
    # tells, (N_T - N_B) over the mean variance.
    weight = (target - background) / ((target + background) / 2 + 3)
    trials = 40_000
    counts = [draw.poisson(mean + 3, (trials, 40)) @ weight for mean in (target, background)]
    right = np.mean(counts[0] > counts[1])
    # Four standard errors of a binomial number; sums of 40 Poisson numbers are normal to well
    # within that.
    tolerance = 4 * math.sqrt(right * (1 - right) / trials)
    assert cv.proportion_correct(expected) == pytest.approx(right, abs=tolerance)
    # Its definition: the difference of the means over the root mean square deviation.
    spread = math.sqrt((counts[0].var() + counts[1].var()) / 2)
    measured = (counts[0].mean() - counts[1].mean()) / spread
    # Standard error of d' from so many trials: √(2/n + d'²/(4 n)).
    assert measured == pytest.approx(expected, abs=4 * math.sqrt((2 + expected**2 / 4) / trials))
    # No other weights tell more.
    for _ in range(20):
        other = weight * draw.uniform(0.5, 1.5, 40)
        difference = other @ (target - background)
        variance = other**2 @ ((target + background) / 2 + 3)
        assert difference / math.sqrt(variance) < expected


def test_d_prime_adds_up_over_receptors_and_time():
    target, background = np.array([110.0]), np.array([90.0])
    assert cv.d_prime(target, background) == 2
    assert cv.d_prime(np.repeat(target, 9), np.repeat(background, 9)) == 6
    assert cv.d_prime(4 * target, 4 * background) == 4
    assert cv.d_prime([0.0, 3.0], [0.0, 3.0]) == 0
    expected = [NormalDist().cdf(one / math.sqrt(2)) for one in (0, 1, 2)]
    assert cv.proportion_correct([0, 1, 2]).tolist() == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: cv.von_kries([1, 2], [1, 0]), "adapting: expected numbers above 0, found 0"),
        (lambda: cv.von_kries([1, 2], [1, 2, 3]), r"adapting: expected shape \(..., 2\)"),
        (lambda: cv.class_noise(0, [1, 2]), "weber_fraction: expected"),
        (lambda: cv.class_noise(13, [1, 2]), "found 13; 13 per cent would be 0.13"),
        (lambda: cv.achromatic_distance(1, 2, 5), "to 1, found 5; 5 per cent would be 0.05"),
        (lambda: cv.class_noise(0.1, [1, -2]), "density: expected finite numbers above 0"),
        (lambda: cv.class_noise(0.1, [1, 2], reference=2), "reference: expected -2 to 1"),
        (
            lambda: cv.noise_limited_distance([0, 1], [1, 1], [1, 1]),
            "first: expected numbers above 0",
        ),
        (lambda: cv.noise_limited_distance([1, 1], [1, 1], [1]), r"noise: expected shape \(2,\)"),
        (
            lambda: cv.noise_limited_distance([1, 1], [1, 2], [13, 15]),
            "noise: .* at most 1, found 13 or more; 13 per cent would be 0.13",
        ),
        (
            lambda: cv.noise_limited_coordinates([1, 1], [13, 13]),
            "noise: .* 13 per cent would be 0.13",
        ),
        (
            lambda: cv.noise_limited_distance([1], [1], [1], signal="linear", photon_noise=True),
            "adapting: expected photons of the background",
        ),
        (
            lambda: cv.noise_limited_distance(np.ones((2, 3)), np.ones((4, 3)), [1, 1, 1]),
            "first, second: expected shapes that go together",
        ),
        (lambda: cv.noise_limited_coordinates([1.0], [1.0]), "at least two receptor classes"),
        (lambda: cv.excitations([-1, 0, 0]), "catches: expected finite numbers from 0 on"),
        (lambda: cv.hexagon([1.1, 0, 0]), "excited: expected excitations from 0 to 1, found 1.1"),
        (lambda: cv.hexagon([1, 0]), r"excited: expected shape \(..., 3\)"),
        (lambda: cv.maxwell_triangle([0, 0, 0]), "catches: expected a catch above 0"),
        (lambda: cv.fly_category([0, 0, 0, 0]), "catches: expected a catch above 0"),
        (lambda: cv.weber_contrast(1, 0), "background: expected numbers above 0"),
        (lambda: cv.d_prime([1, 2], [1, 2], dark=[1, 2, 3]), "dark: expected one number or 2"),
        (lambda: cv.proportion_correct(-1), "d_prime: expected numbers from 0 on"),
    ],
)
def test_what_is_refused(call, told):
    with pytest.raises(omma.Error, match=told):
        call()
