"""What stacks of thin layers reflect, against closed forms and characteristic matrices."""

import warnings

import numpy as np
import pytest

import omma
from omma.scene import LayerStack, refractive_index

RNG = np.random.default_rng(3)
ROUNDING = 1e-9
ANGLES = np.array([0.0, 12.0, 35.0, 56.0, 75.0, 89.0])


def characteristic(stack, nm, angle_deg):
    """Amplitudes r and transmittances of s and p of numbers for indices, by characteristic matrices
    (Born and Wolf 1999, 1.6.2 and 1.6.3)."""
    sine = np.sin(np.radians(angle_deg))
    indices = [complex(index) for _, index in stack.layers] + [complex(stack.substrate)]
    cosines = [np.sqrt(1 - (sine / n) ** 2) for n in indices]
    r, t2 = [], []
    for is_s in (True, False):

        def admittance(n, cosine, is_s=is_s):
            return n * cosine if is_s else cosine / n

        matrix = np.eye(2, dtype=complex)
        for (depth, _), n, cosine in zip(stack.layers, indices, cosines):
            phase = 2 * np.pi / nm * n * depth * cosine
            p = admittance(n, cosine)
            matrix = matrix @ [
                [np.cos(phase), -1j / p * np.sin(phase)],
                [-1j * p * np.sin(phase), np.cos(phase)],
            ]
        first = admittance(1.0, np.cos(np.radians(angle_deg)))
        last = admittance(indices[-1], cosines[-1])
        (a, b), (c, d) = matrix
        above, below = (a + b * last) * first, c + d * last
        r.append((above - below) / (above + below))
        t2.append(last.real / first * abs(2 * first / (above + below)) ** 2)
    return r, t2


def elements(r):
    s, p = r
    return [(abs(s) ** 2 + abs(p) ** 2) / 2, (abs(s) ** 2 - abs(p) ** 2) / 2, (s * p.conj()).real]


def test_a_film_gives_airys_sum():
    """Of all beams that go to and fro in it, each by the laws of sines and tangents."""
    for index, depth, nm in ((1.33, 420.0, 510.0), (1.55, 200.0, 333.0), (2.2, 95.0, 660.0)):
        stack = LayerStack([(depth, index)], substrate=1.7)
        for angle in ANGLES[1:]:
            i = np.radians(angle)
            t, u = np.arcsin(np.sin(i) / index), np.arcsin(np.sin(i) / 1.7)
            phase = np.exp(4j * np.pi * index * depth * np.cos(t) / nm)
            found = []
            for first, second in (
                (-np.sin(i - t) / np.sin(i + t), -np.sin(t - u) / np.sin(t + u)),
                (np.tan(i - t) / np.tan(i + t), np.tan(t - u) / np.tan(t + u)),
            ):
                # t t' = 1 - r^2, and r' = -r.
                again = (-first * second * phase) ** np.arange(400)
                found.append(first + second * phase * (1 - first**2) * again.sum())
            np.testing.assert_allclose(stack.mueller(nm, angle)[0, 0], elements(found), atol=1e-9)


@pytest.mark.parametrize("layers", [0, 1, 2, 7, 20])
def test_stacks_agree_with_characteristic_matrices(layers):
    for _ in range(20):
        absorbs = RNG.random() < 0.7
        stack = LayerStack(
            [
                (RNG.uniform(0, 300), RNG.uniform(1, 2.5) + 1j * absorbs * RNG.uniform(0, 0.3))
                for _ in range(layers)
            ],
            substrate=RNG.uniform(0.1, 3) + 1j * RNG.uniform(0, 5),
        )
        nm, angle = RNG.uniform(300, 700), RNG.uniform(0, 89)
        r, _ = characteristic(stack, nm, angle)
        np.testing.assert_allclose(stack.mueller(nm, angle)[0, 0], elements(r), atol=1e-8)


def test_what_lossless_stacks_do_not_reflect_passes():
    for _ in range(50):
        stack = LayerStack(
            [(RNG.uniform(0, 300), RNG.uniform(1, 2.5)) for _ in range(9)],
            substrate=RNG.uniform(1, 3),
        )
        nm, angle = RNG.uniform(300, 700), RNG.uniform(0, 89)
        a, b, _ = stack.mueller(nm, angle)[0, 0]
        _, (through_s, through_p) = characteristic(stack, nm, angle)
        assert a + b + through_s == pytest.approx(1, abs=ROUNDING)
        assert a - b + through_p == pytest.approx(1, abs=ROUNDING)


@pytest.mark.parametrize("pairs", [1, 3, 8])
def test_quarter_waves_reflect_as_the_textbook_says(pairs):
    """Born and Wolf 1.6.5, equation 95: N pairs on a substrate."""
    high, low, below, nm = 2.3, 1.38, 1.52, 520.0
    stack = LayerStack([(nm / 4 / high, high), (nm / 4 / low, low)] * pairs, substrate=below)
    ratio = (high / low) ** (2 * pairs)
    expected = ((1 - below * ratio) / (1 + below * ratio)) ** 2
    assert stack.mueller(nm, 0)[0, 0, 0] == pytest.approx(expected, abs=ROUNDING)
    # And nowhere more.
    wide = np.linspace(400, 700, 601)
    assert stack.mueller(wide, 0)[:, 0, 0].max() == pytest.approx(expected, abs=1e-6)


def test_bare_metals_follow_fresnel():
    """In real numbers: Born and Wolf 14.2; Ditchburn's form of R_s and R_p."""
    for n, k in ((0.62, 2.08), (1.37, 7.4), (0.05, 4.15), (1.5, 0.0)):
        stack = LayerStack(substrate=complex(n, k))
        at_normal = ((n - 1) ** 2 + k**2) / ((n + 1) ** 2 + k**2)
        assert stack.mueller(500, 0)[0, 0] == pytest.approx([at_normal, 0, -at_normal])
        for angle in np.radians(ANGLES[1:]):
            sine, cosine = np.sin(angle), np.cos(angle)
            real = n**2 - k**2 - sine**2
            root = np.hypot(real, 2 * n * k)
            a, b2 = np.sqrt((root + real) / 2), (root - real) / 2
            r_s = ((a - cosine) ** 2 + b2) / ((a + cosine) ** 2 + b2)
            steep = sine * np.tan(angle)
            r_p = r_s * ((a - steep) ** 2 + b2) / ((a + steep) ** 2 + b2)
            found = stack.mueller(500, np.degrees(angle))[0, 0]
            assert found[:2] == pytest.approx([(r_s + r_p) / 2, (r_s - r_p) / 2], abs=ROUNDING)


def test_films_turn_blue_as_they_are_tilted():
    """A soap film is brightest where 2 n d cos t is half a wavelength and whole ones."""
    index, depth = 1.33, 300.0
    film, nm = LayerStack([(depth, index)], substrate=1.0), np.arange(300.0, 1700.0, 0.25)
    peaks = []
    for angle in (0.0, 30.0, 60.0):
        cosine = np.sqrt(1 - (np.sin(np.radians(angle)) / index) ** 2)
        a, b, _ = film.mueller(nm, angle)[:, 0].T
        brightest = nm[1:-1][np.diff(np.sign(np.diff(a + b))) < 0]
        expected = [2 * index * depth * cosine / (m - 0.5) for m in (1, 2, 3)]
        expected = sorted(peak for peak in expected if nm[0] < peak < nm[-1])
        assert brightest == pytest.approx(expected, abs=0.5)
        peaks.append(brightest[-1])
    assert peaks == sorted(peaks, reverse=True)


def test_no_difference_reflects_nothing():
    assert LayerStack([(100, 1.0)]).mueller([400, 600], ANGLES) == pytest.approx(0, abs=1e-12)


def test_thicknesses_are_averaged_over():
    stack = LayerStack([(90, 1.56), (120, 1.0)] * 6, substrate=1.56 + 0.06j, spread=0.05)
    at = np.linspace(-6, 6, 601)
    weights = np.exp(-(at**2) / 2)
    expected = sum(
        weight * LayerStack([((1 + 0.05 * z) * d, n) for d, n in stack.layers],
                            stack.substrate).mueller([380, 460, 520], [0, 40])
        for z, weight in zip(at, weights / weights.sum())
    )  # fmt: skip
    # What is cut off is less than a ten thousandth of the Gaussian.
    np.testing.assert_allclose(stack.mueller([380, 460, 520], [0, 40]), expected, atol=1e-4)
    alike = stack.mueller(np.arange(300, 700, 5.0), 0)[:, 0, 0]
    sharp = LayerStack(stack.layers, stack.substrate).mueller(np.arange(300, 700, 5.0), 0)[:, 0, 0]
    assert np.ptp(alike) < np.ptp(sharp)


@pytest.mark.parametrize("name", ["aluminium", "chitin", "copper", "gold", "silver"])
def test_tables_are_linear_between_their_nodes(name):
    """As physics/surface/boundary_table.h says, half way between nodes where it is worst: c, which
    turns from 1 to -1, next to grazing."""
    table = LayerStack(substrate=refractive_index(name)).boundary()
    cosines = np.linspace(0, 1, table.mueller.shape[1])
    half = (cosines[1:] + cosines[:-1]) / 2
    exact = LayerStack(substrate=refractive_index(name)).mueller(
        table.wavelength_nm, np.degrees(np.arccos(half))
    )
    between = (table.mueller[:, 1:] + table.mueller[:, :-1]) / 2
    assert np.abs(between - exact)[..., :2].max() < 5e-4
    assert np.abs(between - exact)[..., 2].max() < 2e-3


def test_measured_indices_are_as_published():
    """Rows of Johnson and Christy 1972, and the chitin of Leertouwer et al. 2011: 1.572, 1.552 and
    1.541 at 400, 500 and 600 nm."""
    assert [548.6, 0.43, 2.455] in refractive_index("gold").tolist()
    chitin = refractive_index("chitin")
    at = np.interp([400, 500, 600], chitin[:, 0], chitin[:, 1])
    assert at == pytest.approx([1.572, 1.552, 1.541], abs=6e-4)
    # Gold is yellow, copper red, silver and aluminium are mirrors.
    for name, nm, least, most in (
        ("gold", 450, 0.3, 0.45), ("gold", 650, 0.94, 0.99), ("copper", 500, 0.5, 0.65),
        ("silver", 550, 0.96, 1.0), ("aluminium", 550, 0.9, 0.93),
    ):  # fmt: skip
        found = LayerStack(substrate=refractive_index(name)).mueller(nm, 0)[0, 0, 0]
        assert least < found < most, name


def test_materials_of_stacks():
    blue = LayerStack([(65, 1.56), (125, 1.0)] * 8, substrate=1.56 + 0.06j, spread=0.04)
    material = blue.material("scale", roughness=0.3)
    assert material.metallic == 1
    assert material.roughness == pytest.approx(0.3)
    assert material.boundary == blue.boundary()
    assert np.argmax(material.base_color[:3]) == 2
    assert material.replace(name="other").boundary == material.boundary


def test_what_is_refused():
    film = LayerStack([(100, 1.5)])
    for layers, message in (
        ([(-1, 1.5)], "layers[0] thickness: expected 0 to 100000, found -1"),
        ([(100, 1.5 - 0.1j)], "layers[0] index: expected n + ik, neither below 0"),
        ([(100, 0)], "layers[0] index: expected n + ik"),
        ([(100, 1e150)], "layers[0] index: expected n + ik"),
        ([(100, [[400, 1.5], [500, 1e9]])], "layers[0] index: expected n and k"),
        ([(100, np.nan)], "layers[0] index: expected n + ik"),
        ([(100, [[400, 1.5]])], "layers[0] index: expected 2 or more wavelengths"),
        ([(100, [[500, 1.5], [400, 1.5]])], "layers[0] index: expected 2 or more wavelengths"),
        ([(100, [[400, 1.5], [500, -1]])], "layers[0] index: expected n and k"),
        ([(100, 1.5, 2)], "layers[0]: expected a thickness and an index, found 3"),
        ([(80, 1.5), (1.5, 80)], "layers[1]: expected a thickness in nm and then an index"),
        ([(1.5, 120)], "found 1.5 nm and an index of 120: the other way round"),
    ):
        with pytest.raises(omma.Error) as error:
            LayerStack(layers)
        assert message in str(error.value)
    for layers in ("glass", 5, [5]):
        with pytest.raises(TypeError, match="layers"):
            LayerStack(layers)
    with pytest.raises(omma.Error, match=r"spread: expected 0 to 0\.2"):
        LayerStack(spread=0.5)
    with pytest.raises(omma.Error, match="angle_deg: expected 0 to 90"):
        film.mueller(500, 91)
    with pytest.raises(omma.Error, match="wavelength_nm: expected 10 to 100,000 nm"):
        film.mueller(0, 0)
    with pytest.raises(omma.Error, match="did you mean 'gold'"):
        refractive_index("goldd")


@pytest.mark.parametrize(("thickness_nm", "is_told"), [(1000, False), (20_000, True)])
def test_fringes_that_are_finer_than_a_table_are_told(thickness_nm, is_told):
    film = omma.scene.LayerStack([(thickness_nm, 1.56)], substrate=1.0)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        film.boundary()
    assert any("129 cosines" in str(one.message) for one in told) == is_told
    assert any("wavelengths" in str(one.message) for one in told) == is_told


def test_thin_layers_of_metal_are_no_pairs_the_other_way_round():
    at_10_um = LayerStack([(5, 11 + 70j)], substrate=1.5).mueller(10_000, 0)[0, 0, 0]
    assert at_10_um > 0.5
    assert LayerStack([(5, [[400, 11], [500, 12]])]).mueller(450, 0)[0, 0, 0] > 0


def test_metres_and_micrometres_are_no_thickness():
    for thickness in (80e-9, 0.08):
        with pytest.raises(omma.Error, match="metres or micrometres"):
            omma.scene.LayerStack([(thickness, 1.56)], substrate=1.5)
    assert omma.scene.LayerStack([(0, 1.56)], substrate=1.5).mueller(500, 0).shape
