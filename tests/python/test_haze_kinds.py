"""Hazes of other kinds: OPAC's own numbers, Beer and Lambert's law, light scattered once, and the
tables' own haze as one of them.
"""

from pathlib import Path

import numpy as np
import pytest

import omma
from omma.light.haze_kinds import KINDS, haze_of, scattering_angles
from omma.light.sky_stored import depths_of_air_and_haze
from omma.light.sky_tables import TableSky
from omma.scene.light_words import parse_light

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts" / "sky"
FEW = omma.light.Bands([350.0, 450.0, 650.0], np.eye(3))
OTHERS = [kind for kind in KINDS if kind != "rural"]


def mean_cosine(phase):
    """Of scattering, (K,), of phase functions at angles even by the sine of their half."""
    half = np.linspace(0, 1, phase.shape[1])
    # sin(a) da = 4 half d(half)
    return np.trapezoid(phase * (1 - 2 * half**2) * 2 * half, half, axis=1)


def test_opacs_own_numbers(monkeypatch):
    """Of its mixture "continental polluted" at 80 % humidity and 550 nm, as the program prints them
    (forge.ipsl.jussieu.fr/ether, opac_calc/copo): 0.1746 per km, of which 0.8925 is scattered, by a
    mean cosine of 0.6977."""
    pytest.importorskip("sasktran2")
    monkeypatch.syspath_prepend(str(SCRIPTS))
    from haze_kinds import cross_sections

    total, scattered, phase = cross_sections("continental polluted", np.array([550.0]))
    # um2 of particles in a cm3; as many digits as are printed, and one of rounding on the way.
    assert total[0] * 1e-3 == pytest.approx(0.1746, abs=2e-4)
    assert scattered[0] / total[0] == pytest.approx(0.8925, abs=2e-4)
    assert mean_cosine(phase[..., 0])[0] == pytest.approx(0.6977, abs=2e-4)


def test_stored_is_what_is_computed(monkeypatch):
    pytest.importorskip("sasktran2")
    monkeypatch.syspath_prepend(str(SCRIPTS))
    import haze_kinds

    nm = TableSky(90.0, 0.0, 300.0).table["wavelength_nm"]
    for kind in ("urban", "smoke"):
        depth, scattered, phase = haze_kinds.optics(kind, nm[[4, 20]])
        stored = haze_of(kind)
        np.testing.assert_allclose(stored.depth[[4, 20]], depth, rtol=1e-6)
        np.testing.assert_allclose(stored.scattered[[4, 20]], scattered, rtol=1e-6)
        np.testing.assert_allclose(stored.phase[[4, 20]], phase[:, ::2, 0], rtol=1e-5)
        np.testing.assert_allclose(stored.linear[[4, 20]], phase[:, ::2, 1], rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("kind", KINDS)
def test_phase_matrices(kind):
    haze = haze_of(kind)
    half = np.linspace(0, 1, haze.phase.shape[1])
    # Steps of half a degree: within 1 % for the narrow peak of coarse salt.
    np.testing.assert_allclose(np.trapezoid(haze.phase * 2 * half, half, axis=1), 1, rtol=0.01)
    assert np.all(np.abs(haze.linear) <= haze.phase)
    np.testing.assert_allclose(haze.linear[:, [0, -1]], 0, atol=1e-4 * haze.phase.max())


def test_kinds_differ_as_they_are_known_to():
    nm = TableSky(90.0, 0.0, 300.0).table["wavelength_nm"]
    at_550 = {kind: np.interp(550, nm, haze_of(kind).scattered) for kind in KINDS}
    # OPAC's table of types at 80 % humidity, recalled: 0.817 and 0.997 are scattered; Amazonian
    # smoke: about 0.92 in the visible (Sayer et al. 2014, abstract).
    assert at_550["urban"] == pytest.approx(0.817, abs=0.01)
    assert at_550["maritime"] == pytest.approx(0.997, abs=0.003)
    assert at_550["smoke"] == pytest.approx(0.92, abs=0.02)
    # Powers of the wavelength from 350 to 500 nm, in the same table: 1.14 and 0.12.
    powers = {}
    for kind in KINDS:
        ends = np.interp([350, 500], nm, haze_of(kind).depth)
        powers[kind] = np.log(ends[0] / ends[1]) / np.log(500 / 350)
    assert powers["urban"] == pytest.approx(1.14, abs=0.1)
    assert powers["maritime"] == pytest.approx(0.12, abs=0.05)
    assert powers["smoke"] > 1.5


@pytest.mark.parametrize("kind", OTHERS)
def test_the_sun_by_beer_and_lamberts_law(kind):
    nm = np.array([320.0, 400.0, 550.0, 625.0, 700.0])
    through = [TableSky(90.0, haze, 300.0, 0.0, kind).transmission(nm) for haze in (0.0, 0.2)]
    haze = haze_of(kind)
    nodes = TableSky(90.0, 0.0, 300.0).table["wavelength_nm"]
    depth = 0.2 * np.interp(nm, nodes, haze.depth)
    # Nodes are at all but 550 nm, beside which salt has 1.003. In round air the way upwards is the
    # column but for 1e-4.
    np.testing.assert_allclose(through[1] / through[0], np.exp(-depth), rtol=5e-4)
    assert depths_of_air_and_haze(np.array([550.0]), kind)[1] == pytest.approx(1, abs=5e-3)


@pytest.mark.parametrize("kind", OTHERS)
def test_little_haze_scatters_once(kind):
    """What little haze adds in the red, by a quadrature over height of its own: sunlight that comes
    through what is above, scattered, and what is left of it below."""
    sun, up, little = 40.0, np.array([25.0, 60.0]), 0.004
    azimuth = np.array([0.0, 20.0])
    nm = np.array([700.0])
    skies = []
    for depth in (0.0, little):
        log_i, *_ = TableSky(sun, depth, 300.0, 0.0, kind).stokes(up, azimuth, nm)
        i = np.exp(log_i.astype(float))
        skies.append(i[..., 0])
    haze = haze_of(kind)
    height = np.linspace(0, 30e3, 3001)
    slant, sun_slant = 1 / np.sin(np.radians(up))[:, None], 1 / np.sin(np.radians(sun))
    air = depths_of_air_and_haze(nm)[0]
    below = 1 - np.exp(-height / 8400)
    passed = np.exp(-air * (slant[:, None] * below + sun_slant * (1 - below)))
    once = np.trapezoid(np.exp(-height / 2000) / 2000 * passed, height)[..., 0]
    half, _ = scattering_angles(sun, up, azimuth)
    at = np.linspace(0, 1, haze.phase.shape[1])
    scattered = little * haze.depth[-1] * haze.scattered[-1] / (4 * np.pi) * slant * once[:, None]
    expected = scattered * np.interp(half, at, haze.phase[-1])
    ozone = np.exp(-300 * TableSky(sun, 0.0, 300.0).table["ozone_depth_per_du"][-1] * sun_slant)
    found = skies[1] - skies[0]
    # What it adds to light that is scattered more often is up to 7 % of that near the sun.
    np.testing.assert_allclose(found, ozone * expected, rtol=0.08)


@pytest.mark.parametrize("sun", [50.0, 8.0, -3.0])
def test_the_tables_own_haze_is_one_of_them(sun, monkeypatch):
    """Of a kind with the same optics all that is taken out is put back."""
    at = np.array([2.0, 20, 50, 80]), np.linspace(0, 180, 5), np.array([330.0, 440, 650])
    expected = TableSky(sun, 0.15, 300.0).stokes(*at)
    ground = TableSky(sun, 0.15, 300.0).ground(at[0], at[2], 0.5)
    monkeypatch.setattr("omma.light.sky_tables.haze_of", lambda kind: haze_of("rural"))
    other = TableSky(sun, 0.15, 300.0, 0.0, "urban")
    for found, one in zip(other.stokes(*at), expected):
        np.testing.assert_allclose(found, one, atol=2e-6)  # single precision
    for found, one in zip(other.ground(at[0], at[2], 0.5), ground):
        np.testing.assert_allclose(found, one, rtol=1e-12)


def test_electric_vectors_stand_across_the_plane_of_scattering():
    # As the sky's own, which is air's far more than haze's.
    elevation, azimuth = np.array([20.0, 45.0, 70.0]), np.array([70.0, 110.0, 150.0])
    _, q, u = TableSky(30.0, 0.0, 300.0).stokes(elevation, azimuth, np.array([660.0]))
    _, psi = scattering_angles(30.0, elevation, azimuth)
    off = np.angle(np.exp(1j * (np.arctan2(u[..., 0], q[..., 0]) - 2 * psi)))
    assert np.abs(off).max() < 0.15  # rad, of twice the angle: light scattered twice


def test_skies_of_kinds():
    settings = {"aerosol": 0.2, "bands": FEW}
    skies = {kind: omma.light.clear_sky(35.0, haze_kind=kind, **settings) for kind in KINDS}
    np.testing.assert_array_equal(skies["rural"].sky, omma.light.clear_sky(35.0, **settings).sky)
    level = {kind: sum(sky.irradiance()) for kind, sky in skies.items()}
    # Soot takes light away: the brightest is what takes none.
    assert np.all(level["urban"] < level["smoke"])
    assert np.all(level["smoke"] < level["maritime"])
    # Big particles: a bright aureole.
    near = [
        skies[kind].radiance(omma.eye.direction(0, 40))[0] / skies[kind].radiance((0, 1, 0))[0]
        for kind in ("maritime", "smoke")
    ]
    assert np.all(near[0] > 1.3 * near[1])
    words = parse_light("clear_sky sun_elevation_deg=35 aerosol=0.2 haze_kind=urban")
    assert words["light"] == omma.light.clear_sky(35, aerosol=0.2, haze_kind="urban")
    hazy = [omma.light.with_air(skies[kind]).extinction_per_m for kind in ("rural", "maritime")]
    assert np.all(np.diff(hazy[1] / hazy[0]) > 0)
    no_haze = [omma.light.clear_sky(35.0, aerosol=0.0, haze_kind=k, bands=FEW) for k in KINDS]
    np.testing.assert_array_equal(no_haze[0].sky, no_haze[1].sky)
    for other in ("moonlit_sky", "natural_sky", "overcast_sky"):
        make = getattr(omma.light, other)
        assert make(20.0, haze_kind="urban", bands=FEW) != make(20.0, bands=FEW)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"haze_kind": "dust"}, "haze_kind: expected one of rural, urban, maritime, smoke"),
        ({"haze_kind": "smoke", "aerosol": 0.3}, "aerosol: expected 0 to 0.2.* of smoke haze"),
        (
            {"haze_kind": "urban", "sun_elevation_deg": 9.9},
            "haze_kind: expected rural with the sun or the moon below 10 degrees, found urban",
        ),
        ({"haze_kind": "urban", "aerosol": 0.31}, "aerosol: expected 0 to 0.3 of urban haze"),
    ],
)
def test_nonsense_is_refused(change, message):
    with pytest.raises(omma.Error, match=message):
        omma.light.clear_sky(**{"sun_elevation_deg": 30.0, **change})
